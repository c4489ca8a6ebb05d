module bw_line_group
  !! One group of lines that share bins: their number, whether they are steady or grow, their positions, and which are superfluous.
  use bw_band, only: tapered_band
  use bw_band_fit, only: amplitudes_of, fit_band, reduced_type, squares_left
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_line_poles, only: ample_pencil, pencil_type, pole_lines
  use bw_tapered_line, only: growth_of, line_image, position_of, strength_of
  use bw_tapered_residual, only: peak_lines, residual_type, rounding_of
  implicit none (type, external)
  private
  public :: band_of, group_image, group_image_of, group_noise, numbers_in, refit_group, unknowns

  integer, parameter :: half_band = 5          !! bins beside the outermost lines; the main lobe has 4
  integer, parameter :: extra_lines = 2        !! numbers of lines tried beyond one more line
  real(dp), parameter :: worth = 0.3_dp        !! fraction to which a further line must lower the residual
  real(dp), parameter :: unseen = 0.2_dp       !! of the threshold, below which no peak would be seen
  real(dp), parameter :: fullest = 0.7_dp      !! most unknowns for each number in a group's bins
  real(dp), parameter :: least_freedom = 1.0e-4_dp  !! of degrees of freedom: the residual of noise is at least 1 % of it
  real(dp), parameter :: enough = 3            !! times the expected residual: a smaller one needs no further lines
  real(dp), parameter :: most_cancelled = 1.0e5_dp  !! amplitude relative to the record's largest sample
  integer, parameter :: steady_all = 1, growing_all = 2  !! passes of a fit

  integer, parameter :: most_steps = 20
  real(dp), parameter :: slowest = 0.64_dp     !! fraction of the squares; the fit ends with a step that leaves more
  real(dp), parameter, public :: resolution = 1  !! periods per record; closer lines are one
  real(dp), parameter, public :: correlated = 2.3_dp  !! numbers for each independent one: the taper correlates neighbouring bins

  type, public :: group_type
    type(line_type), allocatable :: lines(:)
    integer, allocatable :: peaks(:)           !! bins of peaks that are not lines yet
  end type group_type

contains

  pure function band_of(group, count) result(bins)
    !! The first and last bin of the group's fit. The band is wider if lines grow.
    type(group_type), intent(in) :: group
    integer, intent(in) :: count
    integer :: bins(2), half
    half = half_band
    if (size(group%lines) > 0) half = half + min(40, int(maxval(abs(growth_of(group%lines, count)))/2))
    bins(1) = minval([floor(position_of(group%lines, count)), group%peaks]) - half
    bins(2) = maxval([ceiling(position_of(group%lines, count)), group%peaks]) + half
    bins = max(0, min(count/2, bins))
  end function band_of

  pure function group_image(residual, lines, bins) result(image)
    !! The tapered transform of these lines and of the residual in these bins, which is that of the record without other lines.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: bins(2)
    complex(dp) :: image(bins(1):bins(2), size(residual%tapered, 2))
    image = residual%tapered(bins(1):bins(2), :) + group_image_of(residual, lines, bins)
  end function group_image

  pure function group_image_of(residual, lines, bins) result(image)
    !! The tapered transform of these lines alone in these bins.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: bins(2)
    complex(dp) :: image(bins(1):bins(2), size(residual%tapered, 2))
    integer :: i
    image = 0
    do i = 1, size(lines)
      image = image + line_image(lines(i), residual%count, bins, .true.)
    end do
  end function group_image_of

  elemental integer function unknowns(line, sensors)
    !! The number of real unknowns of a line: its amplitudes, its position, and its growth unless it is steady.
    type(line_type), intent(in) :: line
    integer, intent(in) :: sensors
    unknowns = 2*sensors + merge(1, 2, line%steady)
  end function unknowns

  pure real(dp) function group_noise(residual, lines)
    !! The expected residual of each real number of the image: noise, and rounding of the strongest line.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: lines(:)
    group_noise = residual%noise + rounding_of(lines, residual%count)
  end function group_noise

  subroutine fit_group(residual, image, bins, goal, lines, residual_norm)
    !! Refine lines in the bins of an image until the norm of the residual stops falling or is far below the goal.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: bins(2)
    complex(dp), intent(in) :: image(:, :)     !! of these lines alone, (bins, S)
    real(dp), intent(in) :: goal
    type(line_type), intent(inout) :: lines(:)
    real(dp), intent(out) :: residual_norm
    type(reduced_type), allocatable :: reduced(:)
    real(dp) :: noise
    integer :: k
    noise = max(goal, tiny(1.0_dp)**0.4_dp)/(enough*sqrt(numbers_in(residual, bins)))
    call fit_band(tapered_band(residual%count, image, bins(1), noise), .false., most_steps, lines, reduced, slowest)
    do k = 1, size(lines)
      lines(k)%amplitude = amplitudes_of(reduced, k, 2, size(image, 2))
    end do
    residual_norm = noise*sqrt(squares_left(reduced))
  end subroutine fit_group

  subroutine refit_group(residual, group)
    !! Refine the group's lines; if the residual is more than noise and there are new peaks, look for further lines.
    type(residual_type), intent(in) :: residual
    type(group_type), intent(inout) :: group
    type(group_type) :: start
    complex(dp), allocatable :: image(:, :)
    real(dp) :: goal, residual_norm
    integer :: bins(2)
    start = group
    bins = band_of(group, residual%count)
    if (size(group%lines) > 0) then
      goal = goal_of(residual, group%lines, bins)
      image = group_image(residual, start%lines, bins)
      call fit_group(residual, image, bins, goal, group%lines, residual_norm)
      if (residual_norm <= goal) call drop_superfluous(residual, image, bins, group%lines)
      if (residual_norm <= goal .or. size(group%peaks) == 0) return
    end if
    call grow(residual, start, group%lines)
  end subroutine refit_group

  subroutine drop_superfluous(residual, image, bins, lines)
    !! Remove superfluous lines: the residual of stronger lines that were not yet at their positions may have been taken for a
    !! line beside one of them.
    type(residual_type), intent(in) :: residual
    complex(dp), intent(in) :: image(:, :)     !! of the lines, (bins, S)
    integer, intent(in) :: bins(2)
    type(line_type), allocatable, intent(inout) :: lines(:)
    type(line_type), allocatable :: trial(:)
    real(dp) :: goal, residual_norm
    integer :: i
    i = 1
    do while (i <= size(lines) .and. size(lines) > 1)
      trial = [lines(:i - 1), lines(i + 1:)]
      goal = goal_of(residual, trial, bins)
      call fit_group(residual, image, bins, goal, trial, residual_norm)
      if (residual_norm <= goal) then
        call move_alloc(trial, lines)
      else
        i = i + 1
      end if
    end do
  end subroutine drop_superfluous

  pure real(dp) function goal_of(residual, lines, bins)
    !! The norm of the image's residual below which no further lines are needed.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: bins(2)
    goal_of = max(enough*group_noise(residual, lines), unseen*residual%threshold)*sqrt(numbers_in(residual, bins))
  end function goal_of

  pure real(dp) function numbers_in(residual, bins)
    !! The number of real values of all sensors in these bins.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: bins(2)
    numbers_in = 2*size(residual%tapered, 2)*(bins(2) - bins(1) + 1)
  end function numbers_in

  subroutine grow(residual, start, lines)
    !! Try the peaks as lines, then poles of the group's bins: as many as exceed noise, one or two fewer or more, and one further
    !! line after another. Keep the first set that explains all, or else the last that was worth its further lines.
    type(residual_type), intent(in) :: residual
    type(group_type), intent(in) :: start
    type(line_type), allocatable, intent(inout) :: lines(:)
    type(pencil_type) :: pencil
    type(line_type), allocatable :: trial(:)
    integer :: rank, fewest, images, i, bins(2)
    integer, allocatable :: ranks(:)
    logical :: done
    bins = band_of(start, residual%count)
    allocate (trial, source=[start%lines, peak_lines(residual, start%peaks)])
    call try(residual, start, trial, lines, done)
    if (done) return
    call ample_pencil(residual, start%lines, bins, residual%noise, pencil, rank)
    fewest = size(start%lines) + 1
    images = merge(2, 1, bins(1) == 0 .or. bins(2) == residual%count/2)  ! mirror images are poles too
    allocate (ranks, source=[rank, rank - 1, rank + 1, rank - 2, rank + 2, (images*i, i=fewest, fewest + extra_lines)])
    do i = 1, size(ranks)
      if (ranks(i) < 1 .or. any(ranks(:i - 1) == ranks(i))) cycle
      trial = pole_lines(pencil, ranks(i), bins)
      if (size(trial) == 0) cycle
      call try(residual, start, trial, lines, done)
      if (done) return
    end do
  end subroutine grow

  subroutine try(residual, start, trial, lines, done)
    !! Fit `trial` as steady lines, then as lines that grow or decay; keep a fit that is worth its lines.
    type(residual_type), intent(in) :: residual
    type(group_type), intent(in) :: start
    type(line_type), intent(in) :: trial(:)
    type(line_type), allocatable, intent(inout) :: lines(:)
    logical, intent(out) :: done
    type(line_type), allocatable :: fitted(:)
    complex(dp), allocatable :: image(:, :)
    real(dp) :: residual_norm, trial_norm, goal, freedom
    integer :: bins(2), pass, sensors
    sensors = size(residual%tapered, 2)
    done = .false.
    allocate (fitted, source=trial)
    do pass = steady_all, growing_all
      fitted = trial
      fitted%steady = pass == steady_all
      where (fitted%steady) fitted%pole%re = 0
      bins = band_of(group_type(fitted, start%peaks), residual%count)
      if (sum(unknowns(fitted, sensors)) > fullest*numbers_in(residual, bins)) return
      goal = goal_of(residual, fitted, bins)
      image = group_image(residual, start%lines, bins)
      call fit_group(residual, image, bins, goal, fitted, trial_norm)
      if (cancel(fitted, residual)) cycle
      goal = goal_of(residual, fitted, bins)
      residual_norm = norm2(abs(image - group_image_of(residual, lines, bins)))
      done = trial_norm <= min(goal, worth*residual_norm)
      freedom = 1 - correlated*(sum(unknowns(fitted, sensors)) - sum(unknowns(lines, sensors)))/numbers_in(residual, bins)
      if (.not. done .and. trial_norm > worth*residual_norm*sqrt(max(freedom, least_freedom))) cycle
      lines = fitted
      if (done) return
    end do
  end subroutine try

  pure logical function cancel(lines, residual)
    !! Whether lines are so much larger than the record that they nearly cancel: their sum is a polynomial that fits any slow
    !! motion, and leaves its rounding everywhere.
    type(line_type), intent(in) :: lines(:)
    type(residual_type), intent(in) :: residual
    cancel = any(strength_of(lines, residual%count) > most_cancelled*residual%highest)
  end function cancel

end module bw_line_group
