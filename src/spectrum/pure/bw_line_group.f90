module bw_line_group
  !! One group of lines that share bins: how many there are, steady or growing, where, and which the others do without.
  use bw_damped_line, only: damped_line, position_of, strength_of
  use bw_kinds, only: dp
  use bw_line_poles, only: ample_pencil, pencil_type, pole_lines
  use bw_tapered_fit, only: band_type, fit_band, fit_type, tapered_band
  use bw_tapered_line, only: line_image, main_lobe
  use bw_tapered_residual, only: peak_lines, residual_type
  implicit none (type, external)
  private
  public :: band_of, drop_needless, group_image, group_image_of, group_noise, numbers_in, refit_group, unknowns

  integer, parameter :: half_band = 5          !! bins beside the outermost lines; the main lobe has 4
  integer, parameter :: extra_lines = 2        !! tried beyond one more
  real(dp), parameter :: worth = 0.3_dp        !! a further line must lower the residual to this part of it
  real(dp), parameter :: unseen = 0.2_dp       !! of the threshold: no peak would be taken up any more
  real(dp), parameter :: fullest = 0.7_dp      !! unknowns for each number in a group's bins
  real(dp), parameter :: most_fitted = 0.85_dp !! unknowns for each independent number of a fit that leaves more than it may; tuned
  real(dp), parameter :: least_freedom = 1.0e-4_dp  !! noise that as many unknowns have been fitted to keeps 1 %
  real(dp), parameter :: enough = 3            !! times the expected residual
  real(dp), parameter :: no_worse = 1.01_dp    !! times what is left with a line that is left out
  real(dp), parameter :: most_cancelled = 1.0e5_dp  !! amplitude, of the record's highest sample
  integer, parameter :: steady_all = 1, growing_at_zero = 2, growing_all = 3  !! passes of a fit

  real(dp), parameter :: slowest = 0.64_dp     !! part of the squares: a step that leaves more is the last
  real(dp), parameter, public :: resolution = 1  !! periods in the record; closer lines are one
  real(dp), parameter, public :: correlated = 2.3_dp  !! neighbouring bins of the taper share their noise

  type, public :: group_type
    type(damped_line), allocatable :: lines(:)
    integer, allocatable :: peaks(:)           !! bins of peaks that are not lines yet
  end type group_type

contains

  pure function band_of(group, count) result(bins)
    !! The first and last bin of the group's fit; the band is wider where lines grow.
    type(group_type), intent(in) :: group
    integer, intent(in) :: count
    integer :: bins(2), half
    half = half_band
    if (size(group%lines) > 0) half = half + min(40, int(maxval(abs(group%lines%decay))*count/2))
    bins(1) = minval([floor(position_of(group%lines, count)), group%peaks]) - half
    bins(2) = maxval([ceiling(position_of(group%lines, count)), group%peaks]) + half
    bins = max(0, min(count/2, bins))
  end function band_of

  pure function group_image(residual, lines, bins) result(image)
    !! The tapered transform of these lines and of what all lines leave, in these bins: the record without all other lines.
    type(residual_type), intent(in) :: residual
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: bins(2)
    complex(dp) :: image(bins(1):bins(2), size(residual%tapered, 2))
    image = residual%tapered(bins(1):bins(2), :) + group_image_of(residual, lines, bins)
  end function group_image

  pure function group_image_of(residual, lines, bins) result(image)
    !! The tapered transform of these lines and nothing else in these bins.
    type(residual_type), intent(in) :: residual
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: bins(2)
    complex(dp) :: image(bins(1):bins(2), size(residual%tapered, 2))
    integer :: i
    image = 0
    do i = 1, size(lines)
      image = image + line_image(lines(i), residual%count, bins(1), bins(2), .true.)
    end do
  end function group_image_of

  elemental integer function unknowns(line, sensors)
    !! How many real numbers describe a line: its amplitudes, its position, and its growth unless it is steady.
    type(damped_line), intent(in) :: line
    integer, intent(in) :: sensors
    unknowns = 2*sensors + merge(1, 2, line%steady)
  end function unknowns

  pure real(dp) function group_noise(residual, lines, leakage)
    !! The residual to be expected of each real number of the image: noise, leakage, and rounding of the strongest line.
    type(residual_type), intent(in) :: residual
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: leakage
    real(dp) :: strongest
    integer :: i
    strongest = 0
    do i = 1, size(lines)
      if (allocated(lines(i)%amplitude)) strongest = max(strongest, maxval(abs(lines(i)%amplitude)))
    end do
    group_noise = residual%noise + leakage + epsilon(1.0_dp)*strongest*residual%count*main_lobe/2
  end function group_noise

  subroutine fit_group(residual, image, bins, goal, lines, left)
    !! Improve lines in the bins of an image until the length of what they leave stops falling, or is far below the goal.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: bins(2)
    complex(dp), intent(in) :: image(:, :)     !! of these lines alone, (bins, S)
    real(dp), intent(in) :: goal
    type(damped_line), intent(inout) :: lines(:)
    real(dp), intent(out) :: left
    type(band_type) :: band
    type(fit_type) :: fit
    real(dp) :: weight(size(image, 2))
    weight = 1/max(goal, tiny(1.0_dp)**0.4_dp)**2
    fit%lines = lines
    fit%slowest = slowest
    band = tapered_band(residual%count, image, bins(1))
    call fit_band(band, weight, fit)
    lines = fit%lines
    left = sqrt(fit%left/weight(1))
  end subroutine fit_group

  subroutine refit_group(residual, group, leakage)
    !! Improve the group's lines; where that leaves more than noise beside new peaks, look for further lines.
    type(residual_type), intent(in) :: residual
    type(group_type), intent(inout) :: group
    real(dp), intent(in) :: leakage            !! expected from other groups, per bin
    type(group_type) :: start
    real(dp) :: goal, left
    integer :: bins(2)
    start = group
    bins = band_of(group, residual%count)
    if (size(group%lines) > 0) then
      goal = goal_of(residual, group%lines, leakage, bins)
      call fit_group(residual, group_image(residual, start%lines, bins), bins, goal, group%lines, left)
      if (left <= goal .or. size(group%peaks) == 0) return
    end if
    call grow(residual, start, leakage, group%lines)
  end subroutine refit_group

  pure real(dp) function goal_of(residual, lines, leakage, bins)
    !! The length of the image's residual below which nothing is left to explain.
    type(residual_type), intent(in) :: residual
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: leakage
    integer, intent(in) :: bins(2)
    goal_of = max(enough*group_noise(residual, lines, leakage), unseen*residual%threshold)*sqrt(numbers_in(residual, bins))
  end function goal_of

  pure real(dp) function numbers_in(residual, bins)
    !! How many real numbers all sensors have in these bins.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: bins(2)
    numbers_in = 2*size(residual%tapered, 2)*(bins(2) - bins(1) + 1)
  end function numbers_in

  subroutine grow(residual, start, leakage, lines)
    !! Try the peaks as lines, then poles of the group's bins, as many as stand out of noise, one more or less, and
    !! one after another; keep the first set that explains all, otherwise the last that was worth its further lines.
    type(residual_type), intent(in) :: residual
    type(group_type), intent(in) :: start
    real(dp), intent(in) :: leakage
    type(damped_line), allocatable, intent(inout) :: lines(:)
    type(pencil_type) :: pencil
    type(damped_line), allocatable :: trial(:)
    integer :: rank, fewest, images, i, bins(2)
    integer, allocatable :: ranks(:)
    logical :: done
    bins = band_of(start, residual%count)
    allocate (trial, source=[start%lines, peak_lines(residual, start%peaks)])
    call try(residual, start, leakage, trial, lines, done)
    if (done) return
    call ample_pencil(residual, start%lines, bins, residual%noise + leakage, pencil, rank)
    fewest = size(start%lines) + 1
    images = merge(2, 1, bins(1) == 0 .or. bins(2) == residual%count/2)  ! mirror images are poles too
    allocate (ranks, source=[rank, rank - 1, rank + 1, rank - 2, rank + 2, (images*i, i=fewest, fewest + extra_lines)])
    do i = 1, size(ranks)
      if (ranks(i) < 1 .or. any(ranks(:i - 1) == ranks(i))) cycle
      trial = pole_lines(pencil, ranks(i), bins)
      if (size(trial) == 0) cycle
      call try(residual, start, leakage, trial, lines, done)
      if (done) return
    end do
  end subroutine grow

  subroutine try(residual, start, leakage, trial, lines, done)
    !! Fit `trial` as steady lines, then with growth at 0 (a mode above its critical speed moves as e^(gt) and e^(−gt)
    !! while all others are steady), then with growth everywhere; keep what was worth it.
    type(residual_type), intent(in) :: residual
    type(group_type), intent(in) :: start
    real(dp), intent(in) :: leakage
    type(damped_line), intent(in) :: trial(:)
    type(damped_line), allocatable, intent(inout) :: lines(:)
    logical, intent(out) :: done
    type(damped_line), allocatable :: fitted(:)
    complex(dp), allocatable :: image(:, :)
    real(dp) :: left, trial_left, goal, freedom
    integer :: bins(2), pass, sensors
    sensors = size(residual%tapered, 2)
    done = .false.
    allocate (fitted, source=trial)
    do pass = steady_all, growing_all
      fitted = trial
      fitted%steady = pass == steady_all .or. (pass == growing_at_zero .and. trial%frequency > 0)
      if (pass == growing_at_zero .and. count(.not. fitted%steady) == 0) cycle
      where (fitted%steady) fitted%decay = 0
      bins = band_of(group_type(fitted, start%peaks), residual%count)
      if (sum(unknowns(fitted, sensors)) > fullest*numbers_in(residual, bins)) return
      goal = goal_of(residual, fitted, leakage, bins)
      image = group_image(residual, start%lines, bins)
      call fit_group(residual, image, bins, goal, fitted, trial_left)
      if (cancel(fitted, residual%highest)) cycle
      goal = goal_of(residual, fitted, leakage, bins)
      left = norm2(abs(image - group_image_of(residual, lines, bins)))
      done = trial_left <= min(goal, worth*left)
      freedom = 1 - correlated*(sum(unknowns(fitted, sensors)) - sum(unknowns(lines, sensors)))/numbers_in(residual, bins)
      if (.not. done .and. trial_left > worth*left*sqrt(max(freedom, least_freedom))) cycle
      lines = fitted
      if (done) return
    end do
  end subroutine try

  pure logical function cancel(lines, highest)
    !! Whether lines are so much larger than the record that only their difference is in it: a polynomial that fits anything slow,
    !! and leaves its rounding everywhere.
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: highest            !! of the record's samples
    cancel = any(strength_of(lines) > most_cancelled*highest)
  end function cancel

  subroutine drop_needless(residual, group)
    !! Leave out, the weakest first, lines within the resolution of another one without which the group's fit leaves no more
    !! than it may, or no more than with them: what was left while stronger lines were not at their places yet may have been
    !! taken for a line beside one of them. Of a fit that still leaves more, the weakest lines give way until numbers are free
    !! to tell the noise from. What is needed stays as it is, to the bit.
    type(residual_type), intent(in) :: residual  !! what all lines leave
    type(group_type), intent(inout) :: group
    type(damped_line), allocatable :: whole(:), trial(:)
    real(dp) :: goal, left, left_now
    integer :: weakest, bins(2)
    allocate (whole, source=group%lines)
    bins = band_of(group, residual%count)
    left_now = norm2(abs(residual%tapered(bins(1):bins(2), :)))
    do
      weakest = weakest_of_close(group%lines, residual%count)
      if (weakest == 0) exit
      trial = [group%lines(:weakest - 1), group%lines(weakest + 1:)]
      goal = goal_of(residual, trial, 0.0_dp, bins)
      call fit_group(residual, group_image(residual, whole, bins), bins, goal, trial, left)
      if (left > max(goal, no_worse*left_now)) exit
      left_now = left
      call move_alloc(trial, group%lines)
    end do
    goal = goal_of(residual, group%lines, 0.0_dp, bins)
    if (left_now > goal) call drop_crowded(residual, whole, bins, goal, group%lines)
  end subroutine drop_needless

  subroutine drop_crowded(residual, whole, bins, goal, lines)
    !! Leave out the weakest lines of a fit that leaves more than it may and has taken up nearly all independent numbers of its
    !! bins: such lines stand for no mode, and nothing would be left to tell the noise from. The others are fitted again.
    type(residual_type), intent(in) :: residual
    type(damped_line), intent(in) :: whole(:)    !! lines that `residual` is without
    integer, intent(in) :: bins(2)             !! first and last bin of the fit
    real(dp), intent(in) :: goal
    type(damped_line), allocatable, intent(inout) :: lines(:)
    type(damped_line), allocatable :: strongest(:)
    logical :: stays(size(lines))
    real(dp) :: strength(size(lines)), left
    strength = strength_of(lines)
    stays = .true.
    do while (sum(unknowns(lines, size(residual%tapered, 2)), mask=stays) > most_fitted*numbers_in(residual, bins)/correlated)
      stays(minloc(strength, dim=1, mask=stays)) = .false.
    end do
    if (all(stays)) return
    allocate (strongest, source=pack(lines, stays))
    call fit_group(residual, group_image(residual, whole, bins), bins, goal, strongest, left)
    call move_alloc(strongest, lines)
  end subroutine drop_crowded

  pure integer function weakest_of_close(lines, count) result(weakest)
    !! The index of the weakest line that has another one within the resolution, or 0 where none has.
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: count               !! samples
    real(dp) :: strength(size(lines)), position(size(lines))
    integer :: i
    strength = strength_of(lines)
    position = position_of(lines, count)
    do i = 1, size(lines)
      if (all(abs(position(i) - [position(:i - 1), position(i + 1:)]) >= resolution)) strength(i) = huge(1.0_dp)
    end do
    weakest = 0
    if (any(strength < huge(1.0_dp))) weakest = minloc(strength, dim=1)
  end function weakest_of_close

end module bw_line_group
