module bw_measured
  !! This module measures waves from two histories alone, as an experiment with two sensors would. Their lines are those of a record
  !! without noise (bw_pure_record), and their waves follow from two amplitudes as from those of any sensors (bw_sensor_waves);
  !! bounds of errors take the place of standard deviations.
  use bw_constants, only: two_pi
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_line_group, only: resolution
  use bw_line_peaks, only: peak_type, peaks_of, with_hidden
  use bw_measured_notes, only: measured_notes
  use bw_missing, only: is_missing, missing
  use bw_mode_check, only: check_peaks, is_mode, not_known, record_facts, verdict_type
  use bw_monitor, only: monitor_type, stops
  use bw_pure_record, only: find_lines_if_pure
  use bw_samples, only: samples_type
  use bw_sensor_lines, only: measured_lines, sensor_facts, sensor_waves
  use bw_sensor_waves, only: measure_sensor_waves
  use bw_tapered_residual, only: residual_type
  use bw_text, only: string
  implicit none (type, external)
  private
  public :: measure_waves

  integer, parameter :: fewest_samples = 16
  real(dp), parameter :: near = 1.5_dp                      !! difference of α; neighbouring modes are about π apart
  real(dp), parameter :: one_deviation = erf(sqrt(0.5_dp))  !! confidence of an interval of ± one standard deviation

  type, public :: measured_type
    !! The peaks by ascending frequency. Errors are bounds; values that do not exist are `missing`.
    integer :: peak_count = 0
    real(dp), allocatable :: angular_frequency(:), angular_frequency_error(:)  !! rad/s, (peak)
    real(dp), allocatable :: wavenumber(:), wavenumber_error(:)                !! 1/m
    real(dp), allocatable :: phase_velocity(:), phase_velocity_error(:)        !! m/s
    real(dp), allocatable :: group_velocity(:), group_velocity_error(:)        !! m/s
    type(string), allocatable :: notes(:)                                      !! for the report
  end type measured_type

contains

  subroutine measure_waves(tip, midpoint, facts, measured, monitor)
    !! Measure frequencies, wave numbers, phase and group velocities of the lines in two histories.
    !!
    !! Lines closer than 1/duration to each other, or to their own mirror image at 0 or the Nyquist frequency, are one peak
    !! with an error of at least 2π/duration, unless all but one are faint modes. If the modes are known, peaks that match
    !! none of them are left out and noted; otherwise, if lines could be numbered, those that fit no mode. Of more than
    !! `max_peaks` peaks, those of the largest amplitude (tip and midpoint together) are listed. A record of zeros, of fewer than
    !! 16 samples, or with missing samples has no peaks.
    real(dp), intent(in) :: tip(:)                      !! displacement at ξ = 1, (N), at the times jT/N
    real(dp), intent(in) :: midpoint(:)                 !! displacement at ξ = ½, (N)
    type(record_facts), intent(in) :: facts
    type(measured_type), intent(out) :: measured        !! undefined after a stop request
    class(monitor_type), intent(inout), optional :: monitor
    type(peak_type), allocatable :: peaks(:)
    type(verdict_type), allocatable :: verdict(:)
    logical, allocatable :: is_wave(:)
    integer, allocatable :: listed(:)
    call find_peaks(tip, midpoint, peaks, monitor)
    if (stops(monitor)) return
    allocate (verdict(size(peaks)))
    if (allocated(facts%known)) then
      call check_peaks(facts%known, size(tip), facts%duration, peaks, verdict)
    else
      peaks = with_hidden(peaks, merge(peaks%hidden, 0.0_dp, peaks%doubtful))
    end if
    call find_waves(peaks, verdict, facts, measured, monitor)
    if (stops(monitor)) return
    is_wave = .not. is_missing(measured%wavenumber)
    allocate (listed, source=listed_peaks(peaks, is_wave, verdict, facts))
    call fill_listed(measured, peaks(listed), listed, facts)
    measured%notes = measured_notes(peaks, is_wave, verdict, listed, facts, size(tip))
  end subroutine measure_waves

  subroutine find_peaks(tip, midpoint, peaks, monitor)
    !! Find the peaks of a record, none if it is not usable. They are undefined after a stop request.
    real(dp), intent(in) :: tip(:), midpoint(:)
    type(peak_type), allocatable, intent(out) :: peaks(:)
    class(monitor_type), intent(inout), optional :: monitor
    type(samples_type) :: samples
    type(line_type), allocatable :: lines(:)
    type(residual_type) :: residual
    logical :: pure
    integer :: power
    allocate (peaks(0))
    if (.not. is_usable(tip, midpoint)) return
    power = exponent(max(maxval(abs(tip)), maxval(abs(midpoint))))
    samples%count = size(tip)
    samples%pure = .true.
    allocate (samples%value(size(tip), 2))
    samples%value(:, 1) = scale(tip, -power)
    samples%value(:, 2) = scale(midpoint, -power)
    call find_lines_if_pure(samples, lines, residual, pure, monitor)
    if (.not. stops(monitor)) peaks = peaks_of(lines, residual)
  end subroutine find_peaks

  pure logical function is_usable(tip, midpoint)
    !! Whether a record is long enough, complete and not zero everywhere.
    real(dp), intent(in) :: tip(:), midpoint(:)
    is_usable = size(tip) >= fewest_samples
    if (is_usable) is_usable = .not. (any(is_missing(tip)) .or. any(is_missing(midpoint)))
    if (is_usable) is_usable = any(abs(tip) > 0) .or. any(abs(midpoint) > 0)
  end function is_usable

  pure function listed_peaks(peaks, is_wave, verdict, facts) result(listed)
    !! Indices of the peaks that are or may be modes, of which at most the `max_peaks` strongest.
    type(peak_type), intent(in) :: peaks(:)
    logical, intent(in) :: is_wave(:)            !! the peak has a wave number
    type(verdict_type), intent(in) :: verdict(:)
    type(record_facts), intent(in) :: facts
    integer, allocatable :: listed(:)
    logical :: qualified(size(peaks))
    integer :: i
    if (allocated(facts%known)) then
      qualified = verdict%kind == is_mode .or. verdict%kind == not_known
    else
      qualified = .not. any(is_wave) .or. is_wave .or. peaks%members > 1 .or. peaks%at_edge
    end if
    qualified = qualified .and. peaks%located
    allocate (listed, source=pack([(i, i=1, size(peaks))], qualified .and. &
      & [(count(qualified .and. peaks%strength > peaks(i)%strength) < facts%max_peaks, i=1, size(peaks))]))
  end function listed_peaks

  subroutine find_waves(peaks, verdict, facts, measured, monitor)
    !! Measure the waves of all peaks that may be modes; a single line is taken as the first mode that oscillates. Where a wave
    !! number is not that of the known mode at this frequency, the peak is left out and the others are measured again.
    type(peak_type), intent(in) :: peaks(:)
    type(verdict_type), intent(in) :: verdict(:)
    type(record_facts), intent(in) :: facts
    type(measured_type), intent(inout) :: measured
    class(monitor_type), intent(inout), optional :: monitor
    type(sensor_facts) :: sensors
    type(sensor_waves) :: waves
    real(dp) :: none(size(peaks))
    logical :: possible(size(peaks))
    logical, allocatable :: right(:)
    integer, allocatable :: chosen(:)
    integer :: i
    none = missing
    possible = facts%ends /= '' .and. (verdict%kind == is_mode .or. verdict%kind == not_known)
    sensors%position = [1.0_dp, 0.5_dp]
    allocate (sensors%quantity(2), source=string('displacement'))
    sensors%length = facts%length
    sensors%ends = trim(facts%ends)
    sensors%model = facts%model
    sensors%simulated = .true.
    sensors%rotates = facts%rotates
    sensors%confidence = one_deviation
    if (count(possible .and. .not. peaks%at_edge) == 1) &
      & sensors%alone = 1 + count(possible .and. peaks%at_edge .and. peaks%position < resolution)
    possible = possible .and. peaks%located .and. peaks%ratio_error < sqrt(huge(1.0_dp))
    chosen = pack([(i, i=1, size(peaks))], possible)
    do
      call measure_sensor_waves(sensors, lines_of(peaks(chosen), facts%duration), waves, monitor)
      if (stops(monitor)) return
      right = [(.true., i=1, size(chosen))]
      do i = 1, size(chosen)
        if (is_missing(waves%wavenumber(i)) .or. verdict(chosen(i))%kind == not_known) cycle
        if (.not. allocated(facts%known%wavenumber)) cycle
        right(i) = abs(waves%wavenumber(i) - facts%known%wavenumber(verdict(chosen(i))%number))*facts%length < near
      end do
      if (all(right)) exit
      chosen = pack(chosen, right)
    end do
    allocate (measured%wavenumber, measured%wavenumber_error, measured%phase_velocity, measured%phase_velocity_error, &
      & measured%group_velocity, measured%group_velocity_error, source=none)
    measured%wavenumber(chosen) = waves%wavenumber
    measured%wavenumber_error(chosen) = waves%wavenumber_error
    measured%phase_velocity(chosen) = waves%phase_velocity
    measured%phase_velocity_error(chosen) = waves%phase_velocity_error
    measured%group_velocity(chosen) = waves%group_velocity
    measured%group_velocity_error(chosen) = waves%group_velocity_error
  end subroutine find_waves

  pure function lines_of(peaks, duration) result(lines)
    !! The peaks as lines: vectors of length 1 at tip and midpoint. An error e of the ratio R rotates the vector by e/(1 + R²).
    type(peak_type), intent(in) :: peaks(:)
    real(dp), intent(in) :: duration             !! of the record, s
    type(measured_lines) :: lines
    lines%angular_frequency = two_pi*peaks%position/duration
    lines%frequency_deviation = two_pi*peaks%position_error/duration
    lines%decay_rate = -peaks%growth/duration
    associate (length => hypot(1.0_dp, peaks%ratio), least => hypot(1.0_dp, max(0.0_dp, abs(peaks%ratio) - peaks%ratio_error)))
      lines%amplitude = cmplx(reshape([1/length, peaks%ratio/length], [2, size(peaks)], order=[2, 1]), kind=dp)
      lines%deviation = spread(peaks%ratio_error/(length*least), 1, 2)
    end associate
  end function lines_of

  pure subroutine fill_listed(measured, peaks, listed, facts)
    !! Fill the result with the listed peaks.
    type(measured_type), intent(inout) :: measured
    type(peak_type), intent(in) :: peaks(:)      !! the listed ones
    integer, intent(in) :: listed(:)
    type(record_facts), intent(in) :: facts
    measured%peak_count = size(peaks)
    measured%angular_frequency = two_pi*peaks%position/facts%duration
    measured%angular_frequency_error = two_pi*peaks%position_error/facts%duration
    measured%wavenumber = measured%wavenumber(listed)
    measured%wavenumber_error = measured%wavenumber_error(listed)
    measured%phase_velocity = measured%phase_velocity(listed)
    measured%phase_velocity_error = measured%phase_velocity_error(listed)
    measured%group_velocity = measured%group_velocity(listed)
    measured%group_velocity_error = measured%group_velocity_error(listed)
  end subroutine fill_listed

end module bw_measured
