module bw_mode_check
  !! What is known of a record beside its samples, and how the modes that are known to be in it check what was measured: which
  !! peaks are aliased from above half the sampling rate, and which are no mode. It gives no value.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_line_group, only: resolution
  use bw_line_peaks, only: as_single, peak_type, with_hidden
  use bw_piece_beam, only: piece_beam
  implicit none (type, external)
  private
  public :: check_peaks

  real(dp), parameter :: faint = 0.1_dp                  !! of a line; what is less beside it makes no close pair
  integer, parameter :: further = 4                      !! times as many modes as there are peaks may matter
  real(dp), parameter :: uneven = 4                      !! modes at a tip fall in strength with such steps back
  real(dp), parameter :: hides = 0.58_dp                !! 2π times the deviation of time under the square of the taper sin⁶
  real(dp), parameter :: rounding = 32*epsilon(1.0_dp)   !! of the frequencies of modes

  integer, parameter, public :: not_known = 0, is_mode = 1, is_folded = 2, is_none = 3

  type, public :: known_modes
    !! The modes that make up a record, from the first on.
    real(dp), allocatable :: angular_frequency(:)  !! rad/s, ascending; 0 of a mode that does not oscillate, (mode)
    logical :: all = .true.                        !! false: there are others above these
    real(dp), allocatable :: wavenumber(:)         !! 1/m; unallocated: not known, (mode)
  end type known_modes

  type, public :: record_facts
    !! What is known of a record beside its samples.
    real(dp) :: duration = 1                   !! of the record, T > 0, s
    real(dp) :: length = 1                     !! of the beam, > 0, m; of one of pieces the mean wave number times it is α
    integer :: max_peaks = 20                  !! ≥ 0
    character(5) :: ends = 'tip'               !! that shapes follow from, as `ends` of sensor_facts; '': from none of these, so that
                                               !! wave numbers and velocities are missing
    type(piece_beam) :: model                  !! of `ends` = 'model'
    logical :: rotates = .true.                !! in the plane of bending, or may do so
    type(known_modes), allocatable :: known    !! to check what was measured; unallocated: not known
  end type record_facts

  type, public :: verdict_type
    integer :: kind = not_known       !! a number above
    integer :: number = 0           !! of the mode that a peak is, or is folded from
  end type verdict_type

  type :: mode_lines
    !! The lines that the known modes make; positions are periods in the record.
    real(dp), allocatable :: position(:)           !! (mode)
    real(dp), allocatable :: image(:)              !! where it is seen, folded or not, (mode)
    logical, allocatable :: taken(:)               !! a peak is this mode, (mode)
    real(dp), allocatable :: strength(:)           !! about, at most; of those that matter, (first modes)
    logical :: all = .true.                        !! there are no others
  end type mode_lines

contains

  pure subroutine check_peaks(known, samples, duration, peaks, verdict)
    !! Judge what each peak is: a mode where its interval holds the frequency of one, the narrowest interval first, each mode
    !! once. The errors of peaks make room for hidden lines where other strong modes lie within the
    !! resolution, and a close pair is one line where none is there, or the fit has no room for one.
    type(known_modes), intent(in) :: known
    integer, intent(in) :: samples
    real(dp), intent(in) :: duration               !! s
    type(peak_type), intent(inout) :: peaks(:)
    type(verdict_type), intent(out) :: verdict(:)
    type(mode_lines) :: modes
    type(peak_type) :: single
    type(verdict_type) :: first
    real(dp) :: error(size(peaks))
    integer :: i, j
    modes = lines_of(known, samples, duration, peaks%strength)
    do i = 1, size(peaks)
      single = as_single(peaks(i))
      first = judged(single, modes)
      if (any(first%kind == [is_mode, is_folded]) .and. min(single%hidden, beside(single, first, modes)) <= faint) &
        & peaks(i) = single
      peaks(i) = with_room(peaks(i), judged(peaks(i), modes), modes)
    end do
    error = peaks%position_error
    do i = 1, size(peaks)
      j = minloc(error, dim=1)
      error(j) = huge(1.0_dp)
      verdict(j) = judged(peaks(j), modes)
      if (peaks(j)%located .and. verdict(j)%kind == is_mode) modes%taken(verdict(j)%number) = .true.
    end do
  end subroutine check_peaks

  pure type(mode_lines) function lines_of(known, samples, duration, strength) result(modes)
    !! The lines that the modes make in a record. Modes fall in strength as peaks do: mode j is about as strong as the j-th
    !! strongest peak, and the next ones after the last as the faintest.
    type(known_modes), intent(in) :: known
    integer, intent(in) :: samples
    real(dp), intent(in) :: duration               !! s
    real(dp), intent(in) :: strength(:)            !! of the peaks
    real(dp) :: sorted(size(strength))
    integer :: j
    modes%position = known%angular_frequency*duration/(2*pi)
    modes%image = abs(modes%position - samples*anint(modes%position/samples))
    modes%taken = [(.false., j=1, size(modes%position))]
    modes%all = known%all
    sorted = falling(strength)
    modes%strength = [(uneven*sorted(min(j, size(sorted))), j=1, min(size(modes%position), further*size(sorted)))]
  end function lines_of

  pure type(verdict_type) function judged(peak, modes)
    !! What a peak is: of several modes that its interval holds the nearest, of several folded ones the first, the strongest.
    type(peak_type), intent(in) :: peak
    type(mode_lines), intent(in) :: modes
    real(dp) :: reach(size(modes%position))
    logical :: holds(size(modes%position))
    reach = peak%position_error + rounding*modes%position
    holds = abs(modes%position - peak%position) <= reach .and. .not. modes%taken
    if (any(holds)) then
      judged = verdict_type(is_mode, minloc(abs(modes%position - peak%position), dim=1, mask=holds))
    else if (.not. modes%all .and. peak%position > maxval(modes%position)) then
      judged = verdict_type(not_known, 0)
    else
      holds = abs(modes%image - peak%position) <= reach .and. modes%image < modes%position
      judged = verdict_type(is_none, 0)
      if (any(holds)) judged = verdict_type(is_folded, findloc(holds, .true., dim=1))
    end if
  end function judged

  pure real(dp) function beside(peak, own, modes) result(part)
    !! The strength of all other strong modes within the resolution, over that of the peak.
    type(peak_type), intent(in) :: peak
    type(verdict_type), intent(in) :: own
    type(mode_lines), intent(in) :: modes
    logical :: near(size(modes%strength))
    near = abs(modes%image(:size(near)) - peak%position) <= resolution + peak%position_error
    if (own%number >= 1 .and. own%number <= size(near)) near(own%number) = .false.
    part = sum(modes%strength, mask=near)/peak%strength
  end function beside

  pure real(dp) function in_its_place(peak, own, modes) result(part)
    !! What other strong modes near it may be of the peak, whose ratio they turn by as much. One of another ratio that is s of the
    !! peak and d bins away leaves `hides` s d: the nearer it is the more of it is hidden.
    type(peak_type), intent(in) :: peak
    type(verdict_type), intent(in) :: own
    type(mode_lines), intent(in) :: modes
    real(dp), dimension(size(modes%strength)) :: distance, share
    distance = abs(modes%image(:size(distance)) - modes%image(own%number))
    share = modes%strength/peak%strength
    where (hides*distance*share > peak%hidden**2) share = peak%hidden**2/(hides*distance)
    if (own%number <= size(share)) share(own%number) = 0
    part = sum(share, mask=distance <= resolution)
  end function in_its_place

  pure type(peak_type) function with_room(peak, own, modes)
    !! The peak with errors that have room for what may be hidden beside it.
    type(peak_type), intent(in) :: peak
    type(verdict_type), intent(in) :: own
    type(mode_lines), intent(in) :: modes
    if (any(own%kind == [is_mode, is_folded])) then
      with_room = with_hidden(peak, min(peak%hidden, beside(peak, own, modes)), in_its_place(peak, own, modes))
    else
      with_room = with_hidden(peak, merge(peak%hidden, 0.0_dp, peak%doubtful))
    end if
  end function with_room

  pure function falling(values) result(sorted)
    !! The same values, the largest first.
    real(dp), intent(in) :: values(:)
    real(dp) :: sorted(size(values))
    integer :: i, j
    do i = 1, size(values)
      j = count(sorted(:i - 1) >= values(i)) + 1
      sorted(j + 1:i) = sorted(j:i - 1)
      sorted(j) = values(i)
    end do
  end function falling

end module bw_mode_check
