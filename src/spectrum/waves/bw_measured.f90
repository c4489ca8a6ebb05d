module bw_measured
  !! Waves measured from two histories alone: what an experiment with two sensors would tell of the beam.
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_line_peaks, only: peak_type, peaks_of
  use bw_line_residual, only: residual_type
  use bw_line_search, only: find_lines
  use bw_measured_notes, only: measured_notes
  use bw_missing, only: is_missing, missing
  use bw_monitor, only: monitor_type, stops
  use bw_mode_numbering, only: curve_type, folded_mode, mode_type, number_modes
  use bw_text, only: string
  implicit none (type, external)
  private
  public :: measure_waves

  integer, parameter :: fewest_samples = 16
  real(dp), parameter :: two_pi = 2*acos(-1.0_dp)

  type, public :: measured_type
    !! Peaks by ascending frequency; errors are bounds; `missing` where something does not exist.
    integer :: peak_count = 0
    real(dp), allocatable :: angular_frequency(:), angular_frequency_error(:)  !! rad/s, (peak)
    real(dp), allocatable :: wavenumber(:), wavenumber_error(:)                !! 1/m
    real(dp), allocatable :: phase_velocity(:), phase_velocity_error(:)        !! m/s
    real(dp), allocatable :: group_velocity(:), group_velocity_error(:)        !! m/s
    type(string), allocatable :: notes(:)                                      !! what a reader must know
  end type measured_type

contains

  subroutine measure_waves(tip, midpoint, duration, length, max_peaks, uniform, measured, monitor)
    !! Frequencies, wave numbers, phase and group velocities of the lines in two histories.
    !!
    !! Lines closer than 1/duration, or as close to 0 or the Nyquist frequency as to their own mirror image, are one
    !! peak with an error of at least 2π/duration. On a uniform beam, lines that are no mode below the Nyquist frequency
    !! are left out and noted. Of more than `max_peaks` peaks, those of the largest amplitude (tip and midpoint
    !! together) stay. A record of zeros, of fewer than 16 samples, or with missing samples, has no peaks.
    real(dp), intent(in) :: tip(:)       !! displacement at ξ = 1, (N), at the times jT/N
    real(dp), intent(in) :: midpoint(:)  !! displacement at ξ = ½, (N)
    real(dp), intent(in) :: duration     !! T > 0, s
    real(dp), intent(in) :: length       !! of the beam, > 0, m
    integer, intent(in) :: max_peaks     !! ≥ 0
    logical, intent(in) :: uniform       !! Eqs 18 and 20 hold; otherwise wave numbers and velocities are missing
    type(measured_type), intent(out) :: measured        !! of no use where the monitor stops
    class(monitor_type), intent(inout), optional :: monitor
    type(line_type), allocatable :: lines(:)
    type(residual_type) :: residual
    type(peak_type), allocatable :: peaks(:)
    type(mode_type), allocatable :: modes(:)
    type(curve_type) :: curve
    integer, allocatable :: listed(:), folded(:)
    real(dp) :: record(size(tip), 2)
    integer :: i, faint, power
    allocate (peaks(0))
    if (is_usable(tip, midpoint)) then
      power = exponent(max(maxval(abs(tip)), maxval(abs(midpoint))))
      record(:, 1) = scale(tip, -power)
      record(:, 2) = scale(midpoint, -power)
      call find_lines(record, lines, residual, monitor)
      if (stops(monitor)) return
      peaks = peaks_of(lines, residual)
    end if
    faint = count(.not. peaks%stands_out)
    peaks = pack(peaks, peaks%stands_out)
    allocate (modes(size(peaks)))
    if (uniform) call number_modes(peaks, size(tip), modes, curve)
    allocate (listed, source=listed_peaks(peaks, modes, curve, max_peaks))
    allocate (folded(size(peaks)), source=0)
    do i = 1, size(peaks)
      if (curve%support > 0 .and. modes(i)%number == 0) folded(i) = folded_mode(peaks(i), curve, size(tip))
    end do
    call fill(measured, peaks(listed), modes(listed), curve, duration, length)
    measured%notes = measured_notes(peaks, modes, curve, uniform, listed, folded, faint, size(tip), duration)
  end subroutine measure_waves

  pure logical function is_usable(tip, midpoint)
    real(dp), intent(in) :: tip(:), midpoint(:)
    is_usable = size(tip) >= fewest_samples
    if (is_usable) is_usable = .not. (any(is_missing(tip)) .or. any(is_missing(midpoint)))
    if (is_usable) is_usable = any(abs(tip) > 0) .or. any(abs(midpoint) > 0)
  end function is_usable

  pure function listed_peaks(peaks, modes, curve, max_peaks) result(listed)
    !! Peaks that are modes, or that cannot be told; the strongest of them.
    type(peak_type), intent(in) :: peaks(:)
    type(mode_type), intent(in) :: modes(:)
    type(curve_type), intent(in) :: curve
    integer, intent(in) :: max_peaks
    integer, allocatable :: listed(:)
    logical :: qualified(size(peaks))
    integer :: i
    qualified = peaks%located .and. &
      & (curve%support == 0 .or. modes%number > 0 .or. peaks%members > 1 .or. peaks%at_edge)
    allocate (listed, source=pack([(i, i=1, size(peaks))], &
      & qualified .and. [(count(qualified .and. peaks%strength > peaks(i)%strength) < max_peaks, i=1, size(peaks))]))
  end function listed_peaks

  pure subroutine fill(measured, peaks, modes, curve, duration, length)
    !! From periods in the record to physical units.
    type(measured_type), intent(inout) :: measured
    type(peak_type), intent(in) :: peaks(:)
    type(mode_type), intent(in) :: modes(:)
    type(curve_type), intent(in) :: curve
    real(dp), intent(in) :: duration, length
    real(dp), dimension(size(peaks)) :: undamped, relative
    logical :: is_mode(size(peaks))
    real(dp) :: none(size(peaks))
    none = missing
    is_mode = modes%number > 0
    measured%peak_count = size(peaks)
    measured%angular_frequency = two_pi*peaks%position/duration
    measured%angular_frequency_error = two_pi*peaks%position_error/duration
    allocate (measured%wavenumber, measured%wavenumber_error, measured%phase_velocity, measured%phase_velocity_error, &
      & measured%group_velocity, measured%group_velocity_error, source=none)
    undamped = 1
    relative = 0
    where (is_mode)
      undamped = sqrt(modes%square)
      relative = modes%square_error/(2*modes%square) + modes%alpha_error/modes%alpha + 8*epsilon(1.0_dp)
      measured%wavenumber = modes%alpha/length
      measured%wavenumber_error = modes%alpha_error/length
      measured%phase_velocity = two_pi*undamped/duration*length/modes%alpha
      measured%phase_velocity_error = measured%phase_velocity*relative
    end where
    if (curve%support == 0) return
    where (is_mode)
      measured%group_velocity = two_pi/duration*length*2*curve%slope*modes%alpha**3/undamped
      measured%group_velocity_error = measured%group_velocity* &
        & (curve%slope_error/curve%slope + 2*modes%alpha_error/modes%alpha + relative)
    end where
  end subroutine fill

end module bw_measured
