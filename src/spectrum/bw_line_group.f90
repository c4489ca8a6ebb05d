module bw_line_group
  !! One group of lines that share bins: how many there are, steady or growing, and where.
  use bw_kinds, only: dp
  use bw_line, only: line_position, line_row, line_type, main_lobe, mirror_row, points
  use bw_line_fit, only: add_lines, fit_lines, unknowns
  use bw_line_poles, only: find_poles
  use bw_line_residual, only: plain_bins, residual_type
  implicit none (type, external)
  private
  public :: band_of, group_noise, group_image, refit_group

  integer, parameter :: half_band = 5          !! bins beside the outermost lines; the main lobe has 4
  integer, parameter :: extra_lines = 3        !! tried beyond the peaks seen
  real(dp), parameter :: worth = 0.3_dp        !! a further line must lower the residual to this part of it
  real(dp), parameter :: enough = 3            !! times the expected residual

  type, public :: group_type
    type(line_type), allocatable :: lines(:)
    integer, allocatable :: peaks(:)           !! bins of peaks that are not lines yet
  end type group_type

contains

  pure function band_of(group, count) result(bins)
    !! First and last bin of the group's fit, wider where lines grow.
    type(group_type), intent(in) :: group
    integer, intent(in) :: count
    integer :: bins(2), half
    half = half_band
    if (size(group%lines) > 0) half = half + min(40, int(maxval(abs(group%lines%growth))/2))
    bins(1) = minval([floor(line_position(group%lines)), group%peaks]) - half
    bins(2) = maxval([ceiling(line_position(group%lines)), group%peaks]) + half
    bins = max(0, min(count/2, bins))
  end function band_of

  pure function group_image(residual, lines, bins) result(image)
    !! Windowed transform of these lines with what is left, without all others.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: bins(2)
    complex(dp) :: image(bins(1):bins(2), points)
    image = residual%windowed(bins(1):bins(2), :)
    call add_lines(lines, residual%count, bins(1), image, 1.0_dp)
  end function group_image

  pure real(dp) function group_noise(residual, lines, leakage)
    !! Expected residual of a real number of the image: noise, leakage, rounding of the strongest line.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: lines(:)
    real(dp), intent(in) :: leakage
    real(dp) :: strongest
    strongest = 0
    if (size(lines) > 0) strongest = maxval(abs([lines%amplitude(1), lines%amplitude(2)]))
    group_noise = residual%noise + leakage + epsilon(1.0_dp)*strongest*residual%count*main_lobe/2
  end function group_noise

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
    left = huge(1.0_dp)
    if (size(group%lines) > 0) then
      goal = goal_of(residual, group%lines, leakage, bins)
      call fit_lines(group%lines, residual%count, bins(1), group_image(residual, start%lines, bins), goal, left)
      if (left <= goal .or. size(group%peaks) == 0) return
    end if
    group%lines = start%lines
    call grow(residual, start, leakage, group%lines, left)
    if (size(group%lines) == size(start%lines)) group%lines%closed = .true.
  end subroutine refit_group

  pure real(dp) function goal_of(residual, lines, leakage, bins)
    !! Length of the image's residual that leaves nothing to explain.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: lines(:)
    real(dp), intent(in) :: leakage
    integer, intent(in) :: bins(2)
    goal_of = enough*group_noise(residual, lines, leakage)*sqrt(2.0_dp*points*(bins(2) - bins(1) + 1))
  end function goal_of

  subroutine grow(residual, start, leakage, lines, left)
    !! Try the peaks as lines, then 1, 2, … poles of the group's bins; keep the first set that explains all,
    !! otherwise the last that was worth its further lines.
    type(residual_type), intent(in) :: residual
    type(group_type), intent(in) :: start
    real(dp), intent(in) :: leakage
    type(line_type), allocatable, intent(inout) :: lines(:)
    real(dp), intent(inout) :: left
    type(line_type), allocatable :: trial(:)
    integer :: rank, bins(2), edge
    logical :: done
    bins = band_of(start, residual%count)
    edge = merge(2, 1, bins(1) == 0 .or. bins(2) == residual%count/2)  ! mirror images are poles too
    trial = [start%lines, peak_lines(residual, start%peaks)]
    call try(residual, start, leakage, trial, lines, left, done)
    do rank = 1, edge*(size(start%lines) + size(start%peaks) + extra_lines)
      if (done) exit
      trial = pole_lines(residual, start%lines, bins, rank)
      if (size(trial) == 0) cycle
      call try(residual, start, leakage, trial, lines, left, done)
    end do
  end subroutine grow

  subroutine try(residual, start, leakage, trial, lines, left, done)
    !! Fit `trial` as steady lines, then with growth; keep what was worth it.
    type(residual_type), intent(in) :: residual
    type(group_type), intent(in) :: start
    real(dp), intent(in) :: leakage
    type(line_type), intent(in) :: trial(:)
    type(line_type), allocatable, intent(inout) :: lines(:)
    real(dp), intent(inout) :: left
    logical, intent(out) :: done
    type(line_type), allocatable :: fitted(:)
    real(dp) :: trial_left, goal
    integer :: bins(2), pass
    done = .false.
    do pass = 1, 2
      fitted = trial
      fitted%steady = pass == 1
      if (pass == 1) fitted%growth = 0
      bins = band_of(group_type(fitted, start%peaks), residual%count)
      if (sum(unknowns(fitted)) > 2*points*(bins(2) - bins(1))) return
      goal = goal_of(residual, fitted, leakage, bins)
      call fit_lines(fitted, residual%count, bins(1), group_image(residual, start%lines, bins), goal, trial_left)
      goal = goal_of(residual, fitted, leakage, bins)
      done = trial_left <= goal
      if (done .or. trial_left < worth*left) then
        lines = fitted
        left = trial_left
      end if
      if (done) return
    end do
  end subroutine try

  pure function peak_lines(residual, peaks) result(lines)
    !! A line at each peak, its offset by a parabola through the logarithms of three bins.
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: peaks(:)
    type(line_type) :: lines(size(peaks))
    real(dp) :: value(-1:1)
    integer :: i, m
    lines%bin = peaks
    do i = 1, size(peaks)
      if (peaks(i) == 0 .or. peaks(i) == ubound(residual%windowed, 1)) cycle
      value = [(norm2(abs(residual%windowed(peaks(i) + m, :))), m=-1, 1)]
      if (any(value <= 0)) cycle
      value = log(value)
      lines(i)%offset = (value(1) - value(-1))/max(2*(2*value(0) - value(1) - value(-1)), 1.0_dp)
      lines(i)%offset = max(-0.5_dp, min(0.5_dp, lines(i)%offset))
    end do
  end function peak_lines

  function pole_lines(residual, own, bins, rank) result(lines)
    !! Lines at the poles of the group's bins.
    type(residual_type), intent(in) :: residual
    type(line_type), intent(in) :: own(:)      !! lines of the group so far, which `residual` is without
    integer, intent(in) :: bins(2), rank
    type(line_type), allocatable :: lines(:)
    complex(dp), allocatable :: image(:, :)
    real(dp), allocatable :: position(:), growth(:)
    integer :: first, last, wide, i, p
    allocate (lines(0))
    wide = 2*rank + 6
    first = min(bins(1), (bins(1) + bins(2) - wide)/2)
    if (bins(1) == 0) first = min(first, -bins(2), -wide/2)
    last = max(bins(2), first + wide)
    if (last - first + 1 > residual%count) then
      first = -((residual%count - 1)/2)
      last = residual%count/2
    end if
    if (last - first + 1 < 2*rank + 1) return
    allocate (image(first:last, points))
    image = plain_bins(residual, first, last)
    do i = 1, size(own)
      do p = 1, points
        image(:, p) = image(:, p) + (own(i)%amplitude(p)*line_row(own(i), residual%count, first, last, 0.0_dp, .false.) &
          & + conjg(own(i)%amplitude(p))*mirror_row(own(i), residual%count, first, last, 0.0_dp, .false.))/2
      end do
    end do
    call find_poles(image, first, residual%count, rank, position, growth)
    do i = 1, size(position)
      if (position(i) < max(bins(1) - 1.0_dp, -1.0e-3_dp) .or. position(i) > bins(2) + 1 .or. abs(growth(i)) > 300) cycle
      if (2*position(i) > residual%count + 1.0e-3_dp) cycle
      lines = [lines, line_type(bin=nint(position(i)), offset=position(i) - nint(position(i)), growth=growth(i))]
    end do
  end function pole_lines

end module bw_line_group
