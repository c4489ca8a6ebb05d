module bw_line_peaks
  !! From fitted lines to peaks that can be told apart, each with bounds on its errors.
  !!
  !! A bound is `safety` standard deviations of the fit, with the residual of the line's own bins as the noise (never
  !! less than rounding). Where the residual is more than noise, a line hidden beside this one may be the reason: one
  !! that leaves a relative residual ρ moves it by about √ρ bins, which is added.
  use bw_kinds, only: dp
  use bw_line, only: line_position, line_type, main_lobe
  use bw_line_errors, only: line_errors
  use bw_line_group, only: band_of, correlated, group_image_of, group_noise, group_type, numbers_in
  use bw_line_image, only: unknowns
  use bw_line_needless, only: resolution
  use bw_line_residual, only: residual_type
  use bw_line_search, only: line_groups
  implicit none (type, external)
  private
  public :: peaks_of

  real(dp), parameter :: safety = 10           !! tuned on random records: 5 holds without noise, not always with it
  real(dp), parameter :: unexplained = 10      !! times the noise: the residual hides a line
  real(dp), parameter :: at_edge = 1.0e-3_dp   !! bins
  real(dp), parameter :: unlocated = 2         !! bins; a peak with a larger error is none
  real(dp), parameter :: clear = 10            !! times the residual: no fit makes such a line of it

  type, public :: peak_type
    !! One peak; positions in periods in the record.
    real(dp) :: position = 0
    real(dp) :: position_error = 0
    real(dp) :: growth = 0                     !! logarithm of the growth over the record
    real(dp) :: ratio = 0                      !! signed, midpoint to tip
    real(dp) :: ratio_error = 0
    real(dp) :: strength = 0                   !! largest amplitude, both histories together
    integer :: members = 1                     !! lines that are one within the resolution; e^(gt) and e^(−gt) are one
    logical :: at_edge = .false.               !! one with its own mirror image at 0 or the Nyquist frequency
    logical :: located = .true.                !! .false.: something is there, but the fit does not say where
    logical :: stands_out = .true.             !! .false.: what the fit leaves explains it
  end type peak_type

contains

  function peaks_of(lines, residual) result(peaks)
    !! Lines as peaks, with bounds of their errors; those that cannot be told apart are one.
    type(line_type), intent(in) :: lines(:)
    type(residual_type), intent(in) :: residual  !! what these lines leave
    type(peak_type), allocatable :: peaks(:)
    type(group_type), allocatable :: group(:)
    logical :: explained
    integer :: i
    allocate (peaks(0))
    allocate (group, source=line_groups(lines, [integer ::]))
    do i = 1, size(group)
      call bound_errors(group(i), residual, explained)
      peaks = [peaks, merged(group(i), residual, explained)]
    end do
  end function peaks_of

  subroutine bound_errors(group, residual, explained)
    !! Fill the errors of the group's lines.
    type(group_type), intent(inout) :: group
    type(residual_type), intent(in) :: residual
    logical, intent(out) :: explained          !! the lines leave no more than noise
    real(dp) :: left, noise, expected, least
    integer :: bins(2)
    bins = band_of(group, residual%count)
    left = norm2(abs(residual%windowed(bins(1):bins(2), :)))
    expected = group_noise(residual, group%lines, 0.0_dp)
    noise = max(left/sqrt(max(1.0_dp, numbers_in(bins)/correlated - sum(unknowns(group%lines)))), expected)
    call settle(group%lines, residual%count)
    call line_errors(group%lines, residual%count, bins(1), bins(2) - bins(1) + 1, safety*noise)
    explained = noise <= unexplained*expected
    associate (lines => group%lines)
      if (.not. explained) then
        lines%position_error = min(lines%position_error, real(residual%count, dp)) &
          & + sqrt(left/(line_strength(lines)*residual%count*main_lobe/2))
      end if
      least = 4*epsilon(1.0_dp)
      lines%position_error = min(lines%position_error, real(residual%count, dp)) + least*line_position(lines)
      lines%ratio_error = min(lines%ratio_error, sqrt(huge(1.0_dp))) + least*abs(lines%ratio) &
        & + abs(aimag(lines%amplitude(2)*conjg(lines%amplitude(1))))/max(abs(lines%amplitude(1))**2, tiny(1.0_dp))
    end associate
  end subroutine bound_errors

  elemental subroutine settle(line, count)
    !! A steady line that is at 0 or the Nyquist frequency but for rounding is put there: it has no phase, and the fit
    !! must not be asked for one.
    type(line_type), intent(inout) :: line
    integer, intent(in) :: count
    if (.not. line%steady .or. abs(line%offset) > at_edge) return
    if (line%bin /= 0 .and. 2*line%bin /= count) return
    line%offset = 0
    line%amplitude%im = 0
  end subroutine settle

  elemental logical function is_real(line)
    !! A real exponential: one of the two that a mode above its critical speed moves as.
    type(line_type), intent(in) :: line
    is_real = .not. line%steady .and. .not. line_position(line) > 0
  end function is_real

  elemental real(dp) function line_strength(line)
    type(line_type), intent(in) :: line
    line_strength = max(sqrt(abs(line%amplitude(1))**2 + abs(line%amplitude(2))**2), sqrt(tiny(1.0_dp)))
  end function line_strength

  function merged(group, residual, explained) result(peaks)
    !! Lines that lie within the resolution of the one before become one peak, their mirror images included.
    type(group_type), intent(in) :: group
    type(residual_type), intent(in) :: residual
    logical, intent(in) :: explained
    type(peak_type), allocatable :: peaks(:)
    type(peak_type) :: peak
    integer :: i, first
    allocate (peaks(0))
    first = 1
    associate (lines => group%lines)
      do i = 1, size(lines)
        if (i < size(lines)) then
          if (line_position(lines(i + 1)) - line_position(lines(i)) < resolution) cycle
        end if
        peak = one_peak(lines(first:i), residual%count, explained)
        if (peak%members > 1) peak%stands_out = exceed(lines(first:i), residual, band_of(group, residual%count))
        peaks = [peaks, peak]
        first = i + 1
      end do
    end associate
  end function merged

  logical function exceed(lines, residual, bins)
    !! Whether the lines together, which may all but cancel, put clearly more into a bin than is left in any.
    type(line_type), intent(in) :: lines(:)
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: bins(2)
    exceed = maxval(abs(group_image_of(lines, residual%count, bins))) > &
      & clear*maxval(abs(residual%windowed(bins(1):bins(2), :)))
  end function exceed

  function one_peak(lines, count, explained) result(peak)
    !! The peak of lines that cannot be told apart.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: count
    logical, intent(in) :: explained
    type(peak_type) :: peak
    real(dp) :: position(size(lines)), weight(size(lines)), error(size(lines))
    position = line_position(lines)
    weight = line_strength(lines)**2
    peak%at_edge = minval(position) < resolution/2 .or. maxval(position) > (count - resolution)/2
    error = lines%position_error
    if (explained .and. (size(lines) > 1 .or. peak%at_edge)) error = min(error, resolution)  ! one may roam, all may not
    peak%position = sum(weight*position)/sum(weight)
    if (size(lines) == 1) peak%position = position(1)
    peak%position = max(0.0_dp, peak%position)   ! rounding puts lines below 0
    peak%position_error = maxval(abs(position - peak%position) + error)
    peak%growth = lines(maxloc(weight, dim=1))%growth
    peak%strength = sqrt(maxval(weight))
    peak%members = size(lines) - max(0, sum(merge(1, 0, is_real(lines))) - 1)
    peak%ratio = lines(1)%ratio
    peak%ratio_error = lines(1)%ratio_error
    peak%located = size(lines) > 1 .or. peak%position_error <= unlocated
    if (peak%at_edge) peak%located = explained
    if (size(lines) == 1) peak%located = peak%located .and. line_strength(lines(1)) > lines(1)%strength_error
    if (peak%members > 1 .or. peak%at_edge) then
      peak%position_error = max(peak%position_error, resolution)
      peak%ratio_error = huge(1.0_dp)
    end if
  end function one_peak

end module bw_line_peaks
