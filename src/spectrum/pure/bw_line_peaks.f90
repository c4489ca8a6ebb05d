module bw_line_peaks
  !! This module combines fitted lines into resolved peaks, each with bounds of its errors.
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_line_bounds, only: bound_errors, bounded_line
  use bw_line_group, only: band_of, group_image_of, group_type, resolution
  use bw_tapered_line, only: position_of, strength_of
  use bw_tapered_residual, only: residual_type
  use bw_tapered_search, only: line_groups
  implicit none (type, external)
  private
  public :: as_single, peaks_of, with_hidden

  real(dp), parameter :: unlocated = 2         !! bins; a peak with a larger error is not located
  real(dp), parameter :: faint_part = 0.1_dp   !! relative strength, below which a line beside another is faint
  real(dp), parameter :: clear = 10            !! times the residual, above which a line cannot be an artefact of it

  type, public :: single_type
    !! The position of a line, in periods per record, and its ratio.
    real(dp) :: position = 0
    real(dp) :: position_error = 0
    real(dp) :: ratio = 0                      !! signed, midpoint to tip
    real(dp) :: ratio_error = 0
    real(dp) :: hidden = 0                     !! fraction of it that may belong to a line hidden beside it
  end type single_type

  type, public :: peak_type
    !! A peak of the record: one line, or several that are not resolved. Positions are in periods per record.
    real(dp) :: position = 0
    real(dp) :: position_error = 0
    real(dp) :: growth = 0                     !! logarithm of the growth over the record
    real(dp) :: ratio = 0                      !! signed, midpoint to tip
    real(dp) :: ratio_error = 0
    real(dp) :: hidden = 0                     !! fraction of it that may belong to a line hidden beside it
    logical :: doubtful = .false.              !! such a line cannot be excluded
    real(dp) :: strength = 0                   !! norm of all sensors' amplitudes, of the strongest line
    integer :: members = 1                     !! number of lines within the resolution; e^(gt) and e^(−gt) count as one
    logical :: at_edge = .false.               !! not resolved from its mirror image at 0 or the Nyquist frequency
    logical :: located = .true.                !! .false.: the fit does not locate the peak, or its residual is as large
    type(single_type), allocatable :: single    !! the strongest member alone, if all others are faint and may be no lines
  end type peak_type

contains

  function peaks_of(lines, residual) result(peaks)
    !! The peaks of the lines, with bounds of their errors; lines that are not resolved are one peak.
    type(line_type), intent(in) :: lines(:)
    type(residual_type), intent(in) :: residual  !! of these lines
    type(peak_type), allocatable :: peaks(:)
    type(group_type), allocatable :: group(:)
    integer :: i
    allocate (peaks(0))
    allocate (group, source=line_groups(lines, [integer ::], residual%count))
    do i = 1, size(group)
      peaks = [peaks, peaks_of_group(group(i), 2*size(lines)/real(residual%count, dp), residual)]
    end do
  end function peaks_of

  function peaks_of_group(lines_together, density, residual) result(peaks)
    !! The peaks of lines that share bins.
    type(group_type), intent(in) :: lines_together
    real(dp), intent(in) :: density              !! lines per bin of the whole record
    type(residual_type), intent(in) :: residual
    type(peak_type), allocatable :: peaks(:)
    type(bounded_line), allocatable :: lines(:), strong(:)
    logical, allocatable :: faint(:)
    logical :: explained
    associate (group => lines_together)
      faint = are_faint(position_of(group%lines, residual%count), strength_of(group%lines, residual%count))
      allocate (strong(0))
      if (any(faint)) call bound_errors(pack(group%lines, .not. faint), pack(group%lines, faint), density, residual, strong, &
        & explained)
      call bound_errors(group%lines, [line_type ::], density, residual, lines, explained)
      allocate (peaks, source=merged(group, lines, strong, residual, explained))
    end associate
  end function peaks_of_group

  pure function are_faint(position, strength) result(faint)
    !! The lines that lie beside a much stronger one.
    real(dp), intent(in) :: position(:), strength(:)
    logical :: faint(size(position))
    integer :: j
    do j = 1, size(position)
      faint(j) = any(abs(position - position(j)) < resolution .and. strength(j) < faint_part*strength)
    end do
  end function are_faint

  elemental logical function is_real(line)
    !! Whether the line is a real exponential, one of the two in the motion of a mode above its critical speed.
    type(bounded_line), intent(in) :: line
    is_real = .not. line%steady .and. .not. line%position > 0
  end function is_real

  function merged(group, lines, strong, residual, explained) result(peaks)
    !! Combine lines that lie within the resolution of the one before into one peak, including their mirror images.
    type(group_type), intent(in) :: group
    type(bounded_line), intent(in) :: lines(:)   !! the group's, ascending
    type(bounded_line), intent(in) :: strong(:)  !! without faint ones, with errors as if these did not exist
    type(residual_type), intent(in) :: residual
    logical, intent(in) :: explained
    type(peak_type), allocatable :: peaks(:)
    type(peak_type) :: peak
    integer :: i, first
    allocate (peaks(0))
    first = 1
    do i = 1, size(lines)
      if (i < size(lines)) then
        if (lines(i + 1)%position - lines(i)%position < resolution) cycle
      end if
      peak = one_peak(lines(first:i), residual%count, explained)
      if (peak%members > 1) then
        peak%located = peak%located .and. exceed_residual(group%lines(first:i), residual, band_of(group, residual%count))
        call find_strongest(strong, lines(first:i), peak)
      end if
      peaks = [peaks, peak]
      first = i + 1
    end do
  end function merged

  pure subroutine find_strongest(strong, lines, peak)
    !! Find the strongest line of the peak as it would be without the others, if all others are faint.
    type(bounded_line), intent(in) :: strong(:)
    type(bounded_line), intent(in) :: lines(:)   !! of the peak, ascending
    type(peak_type), intent(inout) :: peak
    logical :: here(size(strong))
    here = strong%position >= lines(1)%position .and. strong%position <= lines(size(lines))%position
    if (count(here) /= 1) return
    associate (line => strong(findloc(here, .true., dim=1)))
      peak%single = single_type(line%position, line%position_error, line%ratio, line%ratio_error, line%hidden)
    end associate
  end subroutine find_strongest

  logical function exceed_residual(lines, residual, bins)
    !! Whether the lines together, which may nearly cancel, contribute clearly more to a bin than the residual has in any.
    type(line_type), intent(in) :: lines(:)
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: bins(2)
    exceed_residual = maxval(abs(group_image_of(residual, lines, bins))) > &
      & clear*maxval(abs(residual%tapered(bins(1):bins(2), :)))
  end function exceed_residual

  function one_peak(lines, count, explained) result(peak)
    !! The peak of lines that are not resolved.
    type(bounded_line), intent(in) :: lines(:)
    integer, intent(in) :: count
    logical, intent(in) :: explained
    type(peak_type) :: peak
    real(dp) :: position(size(lines)), weight(size(lines)), error(size(lines))
    position = lines%position
    weight = lines%strength**2
    peak%at_edge = minval(position) < resolution/2 .or. maxval(position) > (count - resolution)/2
    error = lines%position_error
    if (explained .and. (size(lines) > 1 .or. peak%at_edge)) error = min(error, resolution)  ! the peak as a whole is resolved
    peak%position = sum(weight*position)/sum(weight)
    if (size(lines) == 1) peak%position = position(1)
    peak%position = max(0.0_dp, peak%position)   ! rounding may put lines below 0
    peak%position_error = maxval(abs(position - peak%position) + error)
    peak%growth = lines(maxloc(weight, dim=1))%growth
    peak%strength = sqrt(maxval(weight))
    peak%members = size(lines) - max(0, sum(merge(1, 0, is_real(lines))) - 1)
    peak%ratio = lines(1)%ratio
    peak%ratio_error = lines(1)%ratio_error
    peak%hidden = maxval(lines%hidden)
    peak%doubtful = any(lines%doubtful)
    peak%located = peak%position_error - maxval(abs(position - peak%position)) &
      & + merge(peak%hidden, 0.0_dp, peak%doubtful .and. size(lines) == 1) <= unlocated
    if (peak%at_edge) peak%located = explained
    if (size(lines) == 1) peak%located = peak%located .and. lines(1)%strength > lines(1)%strength_error
    if (peak%members > 1 .or. peak%at_edge) peak = close_pair(peak)
  end function one_peak

  elemental type(peak_type) function close_pair(peak)
    !! The peak as one of several lines that are not resolved, which may be its own mirror image.
    type(peak_type), intent(in) :: peak
    close_pair = peak
    close_pair%position_error = max(peak%position_error, resolution)
    close_pair%ratio_error = huge(1.0_dp)
  end function close_pair

  elemental type(peak_type) function as_single(peak)
    !! The peak as its strongest member alone, if that is possible.
    type(peak_type), intent(in) :: peak
    as_single = peak
    if (.not. allocated(peak%single) .or. peak%at_edge) return
    as_single%members = 1
    as_single%position = peak%single%position
    as_single%position_error = peak%single%position_error
    as_single%ratio = peak%single%ratio
    as_single%ratio_error = peak%single%ratio_error
    as_single%hidden = peak%single%hidden
    as_single%doubtful = .true.
    as_single%located = peak%single%position_error + peak%single%hidden <= unlocated
    deallocate (as_single%single)
  end function as_single

  elemental type(peak_type) function with_hidden(peak, part, covered)
    !! The peak with bounds that also hold if a line is hidden beside it or at its own position.
    type(peak_type), intent(in) :: peak
    real(dp), intent(in) :: part               !! largest fraction of the peak in the hidden line
    real(dp), intent(in), optional :: covered  !! largest fraction in lines at its own position
    real(dp) :: other
    other = part
    if (present(covered)) other = max(part, covered)
    with_hidden = peak
    with_hidden%position_error = peak%position_error + part
    if (peak%ratio_error < huge(1.0_dp)) with_hidden%ratio_error = peak%ratio_error &
      & + other*(1 + abs(peak%ratio))*hypot(1.0_dp, peak%ratio)  ! it is a larger fraction of the tip's amplitude
  end function with_hidden

end module bw_line_peaks
