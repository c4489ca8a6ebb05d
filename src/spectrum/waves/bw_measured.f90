module bw_measured
  !! This module measures waves in two histories and nothing else: what an experiment with two sensors would tell of the beam.
  use bw_damped_search, only: find_damped_lines
  use bw_found_lines, only: found_lines
  use bw_kinds, only: dp
  use bw_line_peaks, only: peak_type, peaks_of, with_hidden
  use bw_measured_notes, only: measured_notes
  use bw_missing, only: is_missing, missing
  use bw_mode_check, only: check_peaks, is_mode, not_known, record_facts, verdict_type
  use bw_mode_curve, only: mode_type, slope_of
  use bw_mode_numbering, only: number_modes
  use bw_monitor, only: monitor_type, stops
  use bw_samples, only: samples_type
  use bw_text, only: string
  implicit none (type, external)
  private
  public :: measure_waves

  integer, parameter :: fewest_samples = 16
  real(dp), parameter :: chance = 1.0e-4_dp, chance_if_checked = 1.0e-2_dp  !! that peaks are numbered as they are by chance
  integer, parameter :: fewest_lines = 3       !! two lie on a curve whatever they are folded from
  real(dp), parameter :: no_noise = 0          !! chance that noise is taken for a line
  real(dp), parameter :: two_pi = 2*acos(-1.0_dp)

  type, public :: measured_type
    !! The peaks by ascending frequency. Errors are bounds, and what does not exist is `missing`.
    integer :: peak_count = 0
    real(dp), allocatable :: angular_frequency(:), angular_frequency_error(:)  !! rad/s, (peak)
    real(dp), allocatable :: wavenumber(:), wavenumber_error(:)                !! 1/m
    real(dp), allocatable :: phase_velocity(:), phase_velocity_error(:)        !! m/s
    real(dp), allocatable :: group_velocity(:), group_velocity_error(:)        !! m/s
    type(string), allocatable :: notes(:)                                      !! what a reader must know
  end type measured_type

contains

  subroutine measure_waves(tip, midpoint, facts, measured, monitor)
    !! Measure frequencies, wave numbers, phase and group velocities of the lines in two histories.
    !!
    !! Lines closer than 1/duration, or as close to 0 or the Nyquist frequency as to their own mirror image, are one
    !! peak with an error of at least 2π/duration, unless all but one are faint modes. Where the modes are known, peaks that
    !! are none of them are left out and noted; else, where lines have been numbered, those that fit no mode. Of more than
    !! `max_peaks` peaks, those of the largest amplitude (tip and midpoint together) stay. A record of zeros, of fewer than
    !! 16 samples, or with missing samples, has no peaks.
    real(dp), intent(in) :: tip(:)                      !! displacement at ξ = 1, (N), at the times jT/N
    real(dp), intent(in) :: midpoint(:)                 !! displacement at ξ = ½, (N)
    type(record_facts), intent(in) :: facts
    type(measured_type), intent(out) :: measured        !! of no use where the monitor stops
    class(monitor_type), intent(inout), optional :: monitor
    type(peak_type), allocatable :: peaks(:)
    type(mode_type), allocatable :: modes(:)
    type(verdict_type), allocatable :: verdict(:)
    integer, allocatable :: listed(:)
    integer :: faint
    call find_peaks(tip, midpoint, peaks, monitor)
    if (stops(monitor)) return
    faint = count(.not. peaks%stands_out)
    peaks = pack(peaks, peaks%stands_out)
    allocate (modes(size(peaks)), verdict(size(peaks)))
    if (allocated(facts%known)) then
      call check_peaks(facts%known, size(tip), facts%duration, peaks, verdict)
    else
      peaks = with_hidden(peaks, merge(peaks%hidden, 0.0_dp, peaks%doubtful))
    end if
    if (facts%uniform) call number_modes(peaks, verdict%kind == is_mode .or. verdict%kind == not_known, &
      & merge(chance_if_checked, chance, allocated(facts%known)), modes)
    where (modes%number /= verdict%number .and. verdict%kind /= not_known) modes%number = 0
    allocate (listed, source=listed_peaks(peaks, modes, verdict, facts))
    call fill(measured, peaks(listed), modes(listed), modes, facts)
    measured%notes = measured_notes(peaks, modes, verdict, listed, faint, facts, size(tip))
  end subroutine measure_waves

  subroutine find_peaks(tip, midpoint, peaks, monitor)
    !! Find the peaks of a record, none if it is not usable; they are of no use where the monitor stops.
    real(dp), intent(in) :: tip(:), midpoint(:)
    type(peak_type), allocatable, intent(out) :: peaks(:)
    class(monitor_type), intent(inout), optional :: monitor
    type(samples_type) :: samples
    type(found_lines) :: found
    integer :: power
    allocate (peaks(0))
    if (.not. is_usable(tip, midpoint)) return
    power = exponent(max(maxval(abs(tip)), maxval(abs(midpoint))))
    samples%count = size(tip)
    samples%pure = .true.
    allocate (samples%value(size(tip), 2))
    samples%value(:, 1) = scale(tip, -power)
    samples%value(:, 2) = scale(midpoint, -power)
    call find_damped_lines(samples, no_noise, found, monitor)
    if (.not. stops(monitor)) peaks = peaks_of(found%lines, found%left)
  end subroutine find_peaks

  pure logical function is_usable(tip, midpoint)
    !! Whether a record is long enough, complete and not zero everywhere.
    real(dp), intent(in) :: tip(:), midpoint(:)
    is_usable = size(tip) >= fewest_samples
    if (is_usable) is_usable = .not. (any(is_missing(tip)) .or. any(is_missing(midpoint)))
    if (is_usable) is_usable = any(abs(tip) > 0) .or. any(abs(midpoint) > 0)
  end function is_usable

  pure function listed_peaks(peaks, modes, verdict, facts) result(listed)
    !! The indices of peaks that are modes or may be, up to `max_peaks` of the strongest.
    type(peak_type), intent(in) :: peaks(:)
    type(mode_type), intent(in) :: modes(:)
    type(verdict_type), intent(in) :: verdict(:)
    type(record_facts), intent(in) :: facts
    integer, allocatable :: listed(:)
    logical :: qualified(size(peaks))
    integer :: i
    if (allocated(facts%known)) then
      qualified = verdict%kind == is_mode .or. verdict%kind == not_known
    else
      qualified = all(modes%number == 0) .or. modes%number > 0 .or. peaks%members > 1 .or. peaks%at_edge
    end if
    qualified = qualified .and. peaks%located
    allocate (listed, source=pack([(i, i=1, size(peaks))], qualified .and. &
      & [(count(qualified .and. peaks%strength > peaks(i)%strength) < facts%max_peaks, i=1, size(peaks))]))
  end function listed_peaks

  pure subroutine fill(measured, peaks, modes, all_modes, facts)
    !! Fill in the quantities of the listed peaks, turned from periods in the record to physical units.
    type(measured_type), intent(inout) :: measured
    type(peak_type), intent(in) :: peaks(:)
    type(mode_type), intent(in) :: modes(:)
    type(mode_type), intent(in) :: all_modes(:)    !! those of peaks that are not listed too
    type(record_facts), intent(in) :: facts
    real(dp), dimension(size(peaks)) :: undamped, relative
    logical :: is_wave(size(peaks))
    real(dp) :: none(size(peaks)), slope, slope_error
    none = missing
    is_wave = modes%number > 0
    measured%peak_count = size(peaks)
    measured%angular_frequency = two_pi*peaks%position/facts%duration
    measured%angular_frequency_error = two_pi*peaks%position_error/facts%duration
    allocate (measured%wavenumber, measured%wavenumber_error, measured%phase_velocity, measured%phase_velocity_error, &
      & measured%group_velocity, measured%group_velocity_error, source=none)
    undamped = 1
    relative = 0
    where (is_wave)
      undamped = sqrt(modes%square)
      relative = modes%square_error/(2*modes%square) + modes%alpha_error/modes%alpha + 8*epsilon(1.0_dp)
      measured%wavenumber = modes%alpha/facts%length
      measured%wavenumber_error = modes%alpha_error/facts%length
      measured%phase_velocity = two_pi*undamped/facts%duration*facts%length/modes%alpha
      measured%phase_velocity_error = measured%phase_velocity*relative
    end where
    if (.not. allocated(facts%known) .and. count(all_modes%number > 0) < fewest_lines) return
    call slope_of(all_modes, slope, slope_error)
    if (.not. slope > 0) return
    where (is_wave)
      measured%group_velocity = two_pi/facts%duration*facts%length*2*slope*modes%alpha**3/undamped
      measured%group_velocity_error = measured%group_velocity* &
        & (slope_error/slope + 2*modes%alpha_error/modes%alpha + relative)
    end where
  end subroutine fill

end module bw_measured
