module bw_believed_search
  !! The lines of a record that it tells something of: they are found and judged, and judged once more without those whose
  !! intervals say nothing.
  !!
  !! Noise that is smooth, as behind a filter, and what a mode leaves that changes as it dies away, are described by lines that
  !! drift as one likes. Each pays for its unknowns; but only its interval, which holds the ends of its drift and counts what is
  !! left beside it, shows that its frequency may be any, or that of a stronger line.
  use bw_belief, only: believed_line, believed_lines, close_pair, drifting
  use bw_distinct_sensors, only: distinct_type, find_distinct, keep_distinct
  use bw_damped_search, only: find_damped_lines, fit_without
  use bw_found_lines, only: found_lines
  use bw_kinds, only: dp
  use bw_line_refusals, only: refuse_untold
  use bw_monitor, only: monitor_type, stops
  use bw_recorded_sensors, only: mix_again, repeat_sensors
  use bw_samples, only: samples_type, span_of
  implicit none (type, external)
  private
  public :: find_believed_lines

  integer, parameter :: most_rounds = 4
  real(dp), parameter :: usual = 0.95_dp         !! confidence of the intervals that refuse a line
  real(dp), parameter :: most_growth = 300       !! logarithm over the record, that is told

contains

  subroutine find_believed_lines(samples, confidence, false_alarm, found, believed, monitor)
    !! Find the lines of a record with their intervals. Those whose intervals say nothing, at the usual confidence whatever is asked
    !! for, are refused as uncertain; but not one of a close pair, which are known together far better than a drift of either.
    type(samples_type), intent(inout) :: samples   !! even ones are whitened in their memory
    real(dp), intent(in) :: confidence             !! of the intervals, 0 … 1
    real(dp), intent(in) :: false_alarm            !! that noise alone makes any line, or a steady line is said to drift
    type(found_lines), intent(out) :: found        !! with all lines of the fit
    type(believed_line), allocatable, intent(out) :: believed(:)   !! by ascending frequency
    class(monitor_type), intent(inout), optional :: monitor  !! nothing is of use where it asks to stop
    type(distinct_type) :: distinct
    logical, allocatable :: nothing(:)
    integer :: round
    distinct = find_distinct(samples)
    call keep_distinct(distinct, samples)
    call find_damped_lines(samples, false_alarm, found, monitor)
    allocate (believed(0))
    do round = 1, most_rounds
      if (stops(monitor)) return
      believed = believed_lines(samples, found, usual, false_alarm)
      nothing = reaches_0(samples, believed)
      if (round == most_rounds .or. .not. any(nothing)) exit
      call fit_without(samples, numbered(nothing, believed), found, monitor)
    end do
    nothing = nothing .or. reaches_over(samples, believed)
    call refuse_untold(samples, numbered(nothing, believed), found)
    if (abs(confidence - usual) > 0) believed = believed_lines(samples, found, confidence, false_alarm)
    believed = pack(believed, .not. nothing)
    call mix_again(found)
    call repeat_sensors(distinct, found, believed)
  end subroutine find_believed_lines

  pure function numbered(nothing, believed) result(untold)
    !! What holds of lines by their frequencies, by the order in which they were found.
    logical, intent(in) :: nothing(:)
    type(believed_line), intent(in) :: believed(:)
    logical :: untold(size(nothing))
    untold(believed%number) = nothing
  end function numbered

  pure function reaches_0(samples, believed) result(nothing)
    !! Whether the interval of a line reaches from its frequency to 0, unless it lies within 1/span of 0, where an offset that dies
    !! away is. The others are fitted again without it.
    type(samples_type), intent(in) :: samples
    type(believed_line), intent(in) :: believed(:)
    logical :: nothing(size(believed))
    nothing = believed%frequency_error >= believed%frequency .and. believed%frequency*span_of(samples) >= 1 &
      & .and. iand(believed%status, close_pair) == 0
  end function reaches_0

  pure function reaches_over(samples, believed) result(nothing)
    !! Whether the interval of a line that drifts reaches over one of more energy, whose own drift may have left it. It stays in the
    !! fit: what it describes is no noise, and would widen the intervals of all others.
    type(samples_type), intent(in) :: samples
    type(believed_line), intent(in) :: believed(:)
    logical :: nothing(size(believed))
    real(dp) :: strength(size(believed)), span     ! root of the energy
    integer :: k
    span = span_of(samples)
    strength = [(norm2(abs(believed(k)%amplitude)), k=1, size(believed))]    ! at the first sample
    strength = strength*exp(min(-min(believed%decay, 0.0_dp)*span, most_growth))
    strength = strength/sqrt(max(abs(believed%decay)*span, 1.0_dp))
    nothing = .false.
    do k = 1, size(believed)
      if (iand(believed(k)%status, drifting) == 0 .or. iand(believed(k)%status, close_pair) > 0) cycle
      nothing(k) = any(strength > strength(k) .and. &
        & abs(believed%frequency - believed(k)%frequency) < believed(k)%frequency_error)
    end do
  end function reaches_over

end module bw_believed_search
