module bw_mode_check
  !! What is known of a record besides its samples, and the check of measured peaks against the modes known to be in it: which
  !! peaks are aliased from above half the sampling rate, and which are no mode. Known modes never supply a measured value.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_line_group, only: resolution
  use bw_line_peaks, only: as_single, peak_type, with_hidden
  use bw_piece_beam, only: piece_beam
  implicit none (type, external)
  private
  public :: check_peaks

  real(dp), parameter :: faint = 0.1_dp                  !! relative strength; a fainter line beside another makes no close pair
  integer, parameter :: further = 4                      !! modes considered per peak
  real(dp), parameter :: uneven = 4                      !! factor by which a mode at a tip may be stronger than the one before it
  real(dp), parameter :: hides = 0.58_dp                !! 2π times the standard deviation of time under the squared taper sin⁶
  real(dp), parameter :: rounding = 32*epsilon(1.0_dp)   !! relative, of the frequencies of modes

  integer, parameter, public :: not_known = 0, is_mode = 1, is_alias = 2, is_none = 3

  type, public :: known_modes
    !! The modes of a record, from the first on.
    real(dp), allocatable :: angular_frequency(:)  !! rad/s, ascending; 0 if the mode does not oscillate, (mode)
    logical :: all = .true.                        !! false: there are further modes above these
    real(dp), allocatable :: wavenumber(:)         !! 1/m, (mode); unallocated: not known
  end type known_modes

  type, public :: record_facts
    !! What is known of a record besides its samples.
    real(dp) :: duration = 1                   !! of the record, T > 0, s
    real(dp) :: length = 1                     !! of the beam, > 0, m; times the (mean) wave number it is α
    integer :: max_peaks = 20                  !! ≥ 0
    character(5) :: ends = 'tip'               !! end conditions of the shapes, as `ends` of sensor_facts; '': none of these, and
                                               !! wave numbers and velocities are missing
    type(piece_beam) :: model                  !! of `ends` = 'model'
    logical :: rotates = .true.                !! in the plane of bending, or possibly
    type(known_modes), allocatable :: known    !! to check the measurement against; unallocated: not known
  end type record_facts

  type, public :: verdict_type
    integer :: kind = not_known       !! not_known, is_mode, is_alias or is_none
    integer :: number = 0           !! of the mode that the peak is, or is aliased from
  end type verdict_type

  type :: mode_lines
    !! Lines of the known modes; positions are in periods per record.
    real(dp), allocatable :: position(:)           !! (mode)
    real(dp), allocatable :: image(:)              !! where it appears, aliased or not, (mode)
    logical, allocatable :: taken(:)               !! a peak has been matched to this mode, (mode)
    real(dp), allocatable :: strength(:)           !! estimated upper bound, for the first modes only
    logical :: all = .true.                        !! there are no further modes
  end type mode_lines

contains

  pure subroutine check_peaks(known, samples, duration, peaks, verdict)
    !! Judge each peak: it is a mode if its interval contains the mode's frequency. The narrowest intervals come first, and each
    !! mode is matched once. Errors are widened for lines that may be hidden where other strong modes lie within the resolution;
    !! a close pair becomes one line if no such mode is near, or if the fit leaves no room for a second line.
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
      first = verdict_of(single, modes)
      if (any(first%kind == [is_mode, is_alias]) .and. min(single%hidden, strength_beside(single, first, modes)) <= faint) &
        & peaks(i) = single
      peaks(i) = widened(peaks(i), verdict_of(peaks(i), modes), modes)
    end do
    error = peaks%position_error
    do i = 1, size(peaks)
      j = minloc(error, dim=1)
      error(j) = huge(1.0_dp)
      verdict(j) = verdict_of(peaks(j), modes)
      if (peaks(j)%located .and. verdict(j)%kind == is_mode) modes%taken(verdict(j)%number) = .true.
    end do
  end subroutine check_peaks

  pure type(mode_lines) function lines_of(known, samples, duration, strength) result(modes)
    !! The lines of the modes in a record. Strengths are assumed to fall as those of peaks do: mode j is about as strong as the
    !! j-th strongest peak, and further modes are as strong as the faintest.
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
    sorted = descending(strength)
    modes%strength = [(uneven*sorted(min(j, size(sorted))), j=1, min(size(modes%position), further*size(sorted)))]
  end function lines_of

  pure type(verdict_type) function verdict_of(peak, modes)
    !! What a peak is: the nearest mode in its interval, or else the first aliased one in it, which is the strongest.
    type(peak_type), intent(in) :: peak
    type(mode_lines), intent(in) :: modes
    real(dp) :: reach(size(modes%position))
    logical :: holds(size(modes%position))
    reach = peak%position_error + rounding*modes%position
    holds = abs(modes%position - peak%position) <= reach .and. .not. modes%taken
    if (any(holds)) then
      verdict_of = verdict_type(is_mode, minloc(abs(modes%position - peak%position), dim=1, mask=holds))
    else if (.not. modes%all .and. peak%position > maxval(modes%position)) then
      verdict_of = verdict_type(not_known, 0)
    else
      holds = abs(modes%image - peak%position) <= reach .and. modes%image < modes%position
      verdict_of = verdict_type(is_none, 0)
      if (any(holds)) verdict_of = verdict_type(is_alias, findloc(holds, .true., dim=1))
    end if
  end function verdict_of

  pure real(dp) function strength_beside(peak, own, modes) result(part)
    !! The strength of all other strong modes within the resolution, relative to the peak.
    type(peak_type), intent(in) :: peak
    type(verdict_type), intent(in) :: own
    type(mode_lines), intent(in) :: modes
    logical :: near(size(modes%strength))
    near = abs(modes%image(:size(near)) - peak%position) <= resolution + peak%position_error
    if (own%number >= 1 .and. own%number <= size(near)) near(own%number) = .false.
    part = sum(modes%strength, mask=near)/peak%strength
  end function strength_beside

  pure real(dp) function hidden_part(peak, own, modes) result(part)
    !! The part of the peak that may belong to other strong modes near it, which change its ratio by as much. A mode of another
    !! ratio, relative strength s and distance d in bins leaves a residual of `hides` s d: the nearer it is, the more is hidden.
    type(peak_type), intent(in) :: peak
    type(verdict_type), intent(in) :: own
    type(mode_lines), intent(in) :: modes
    real(dp), dimension(size(modes%strength)) :: distance, share
    distance = abs(modes%image(:size(distance)) - modes%image(own%number))
    share = modes%strength/peak%strength
    where (hides*distance*share > peak%hidden**2) share = peak%hidden**2/(hides*distance)
    if (own%number <= size(share)) share(own%number) = 0
    part = sum(share, mask=distance <= resolution)
  end function hidden_part

  pure type(peak_type) function widened(peak, own, modes)
    !! The peak with errors widened for lines that may be hidden beside it.
    type(peak_type), intent(in) :: peak
    type(verdict_type), intent(in) :: own
    type(mode_lines), intent(in) :: modes
    if (any(own%kind == [is_mode, is_alias])) then
      widened = with_hidden(peak, min(peak%hidden, strength_beside(peak, own, modes)), hidden_part(peak, own, modes))
    else
      widened = with_hidden(peak, merge(peak%hidden, 0.0_dp, peak%doubtful))
    end if
  end function widened

  pure function descending(values) result(sorted)
    !! The values in descending order.
    real(dp), intent(in) :: values(:)
    real(dp) :: sorted(size(values))
    integer :: i, j
    do i = 1, size(values)
      j = count(sorted(:i - 1) >= values(i)) + 1
      sorted(j + 1:i) = sorted(j:i - 1)
      sorted(j) = values(i)
    end do
  end function descending

end module bw_mode_check
