module bw_line_peaks
  !! From fitted lines to peaks that can be told apart, each with bounds on its errors.
  !!
  !! A bound is `safety` standard deviations of the fit, with the residual of the line's own bins as the noise (never
  !! less than rounding). Where the residual is more than noise, a line hidden beside this one may be the reason: one
  !! that leaves a relative residual ρ moves it by about √ρ bins, which is added.
  use bw_kinds, only: dp
  use bw_line, only: line_position, line_type, main_lobe, points
  use bw_line_fit, only: add_lines, line_errors, unknowns
  use bw_line_group, only: band_of, group_image, group_noise, group_type
  use bw_line_residual, only: residual_type
  use bw_line_search, only: line_groups
  implicit none (type, external)
  private
  public :: peaks_of

  real(dp), parameter :: safety = 10           !! tuned on random records: 4 already holds in all of them
  real(dp), parameter :: correlated = 2.3_dp   !! neighbouring bins of the window that share their noise
  real(dp), parameter :: unexplained = 10      !! times the noise: the residual hides a line
  real(dp), parameter :: resolution = 1        !! bins; closer lines are one

  type, public :: peak_type
    !! One peak; positions in periods in the record.
    real(dp) :: position = 0
    real(dp) :: position_error = 0
    real(dp) :: growth = 0                     !! logarithm of the growth over the record
    real(dp) :: ratio = 0                      !! signed, midpoint to tip
    real(dp) :: ratio_error = 0
    real(dp) :: strength = 0                   !! largest amplitude, both histories together
    integer :: members = 1                     !! lines that are one within the resolution
    logical :: at_edge = .false.               !! one with its own mirror image at 0 or the Nyquist frequency
  end type peak_type

contains

  function peaks_of(lines, residual) result(peaks)
    type(line_type), intent(in) :: lines(:)
    type(residual_type), intent(in) :: residual  !! what these lines leave
    type(peak_type), allocatable :: peaks(:)
    type(group_type), allocatable :: group(:)
    integer :: i
    allocate (peaks(0))
    allocate (group, source=line_groups(lines, [integer ::]))
    do i = 1, size(group)
      call bound_errors(group(i), residual)
      peaks = [peaks, merged(group(i)%lines, residual%count)]
    end do
  end function peaks_of

  subroutine bound_errors(group, residual)
    !! Fill the errors of the group's lines.
    type(group_type), intent(inout) :: group
    type(residual_type), intent(in) :: residual
    real(dp) :: left, noise, expected, numbers, hidden
    integer :: bins(2)
    bins = band_of(group, residual%count)
    left = norm2(abs(residual%windowed(bins(1):bins(2), :)))
    numbers = 2*points*(bins(2) - bins(1) + 1)
    expected = group_noise(residual, group%lines, 0.0_dp)
    noise = max(left/sqrt(max(1.0_dp, numbers/correlated - sum(unknowns(group%lines)))), expected)
    call line_errors(group%lines, residual%count, bins(1), bins(2) - bins(1) + 1, safety*noise)
    associate (lines => group%lines)
      if (noise > unexplained*expected) then
        lines%position_error = min(lines%position_error, real(residual%count, dp)) &
          & + sqrt(left/(line_strength(lines)*residual%count*main_lobe/2))
      end if
      hidden = 4*epsilon(1.0_dp)
      lines%position_error = min(lines%position_error, real(residual%count, dp)) + hidden*line_position(lines)
      lines%ratio_error = min(lines%ratio_error, sqrt(huge(1.0_dp))) + hidden*abs(lines%ratio) &
        & + abs(aimag(lines%amplitude(2)*conjg(lines%amplitude(1))))/max(abs(lines%amplitude(1))**2, tiny(1.0_dp))
    end associate
  end subroutine bound_errors

  elemental real(dp) function line_strength(line)
    type(line_type), intent(in) :: line
    line_strength = max(sqrt(abs(line%amplitude(1))**2 + abs(line%amplitude(2))**2), sqrt(tiny(1.0_dp)))
  end function line_strength

  function merged(lines, count) result(peaks)
    !! Lines that lie within the resolution of the one before become one peak, their mirror images included.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: count
    type(peak_type), allocatable :: peaks(:)
    integer :: i, first
    allocate (peaks(0))
    first = 1
    do i = 1, size(lines)
      if (i < size(lines)) then
        if (line_position(lines(i + 1)) - line_position(lines(i)) < resolution) cycle
      end if
      peaks = [peaks, one_peak(lines(first:i), count)]
      first = i + 1
    end do
  end function merged

  function one_peak(lines, count) result(peak)
    !! The peak of lines that cannot be told apart.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: count
    type(peak_type) :: peak
    real(dp) :: position(size(lines)), weight(size(lines))
    position = line_position(lines)
    weight = line_strength(lines)**2
    peak%position = sum(weight*position)/sum(weight)
    if (size(lines) == 1) peak%position = position(1)
    peak%position_error = maxval(abs(position - peak%position) + lines%position_error)
    peak%growth = lines(maxloc(weight, dim=1))%growth
    peak%strength = sqrt(maxval(weight))
    peak%members = size(lines)
    peak%ratio = lines(1)%ratio
    peak%ratio_error = lines(1)%ratio_error
    peak%at_edge = minval(position) < resolution/2 .or. maxval(position) > (count - resolution)/2
    if (peak%members > 1 .or. peak%at_edge) then
      peak%position_error = max(peak%position_error, resolution)
      peak%ratio_error = huge(1.0_dp)
    end if
  end function one_peak

end module bw_line_peaks
