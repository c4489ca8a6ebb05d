module bw_believed_search
  !! The lines of a record that it tells something of: they are found and judged, and judged once more without those whose
  !! intervals say nothing.
  !!
  !! Noise that is smooth, as behind a filter, and what a mode leaves that changes as it dies away, are described by lines that
  !! drift as one likes. Each pays for its unknowns; but only its interval, which holds the ends of its drift and counts what is
  !! left beside it, shows that its frequency may be any, or that of a stronger line.
  use bw_belief, only: believed_line, believed_lines, drifting
  use bw_damped_search, only: find_damped_lines, fit_without
  use bw_found_lines, only: found_lines
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type, stops
  use bw_samples, only: samples_type, span_of
  implicit none (type, external)
  private
  public :: find_believed_lines

  integer, parameter :: most_rounds = 8
  real(dp), parameter :: most_growth = 300       !! logarithm over the record, that is told

contains

  subroutine find_believed_lines(samples, confidence, false_alarm, found, believed, monitor)
    !! Find the lines of a record with their intervals. Those whose intervals say nothing are refused as uncertain.
    type(samples_type), intent(inout) :: samples   !! even ones are whitened in their memory
    real(dp), intent(in) :: confidence             !! of the intervals, 0 … 1
    real(dp), intent(in) :: false_alarm            !! that noise alone makes any line, or a steady line is said to drift
    type(found_lines), intent(out) :: found
    type(believed_line), allocatable, intent(out) :: believed(:)   !! by ascending frequency
    class(monitor_type), intent(inout), optional :: monitor  !! nothing is of use where it asks to stop
    logical, allocatable :: untold(:)
    integer :: round
    call find_damped_lines(samples, false_alarm, found, monitor)
    allocate (believed(0))
    do round = 1, most_rounds
      if (stops(monitor)) return
      believed = believed_lines(samples, found, confidence, false_alarm)
      allocate (untold(size(believed)))
      untold(believed%number) = says_nothing(samples, believed)
      if (.not. any(untold)) return
      call fit_without(samples, untold, found, monitor)
      deallocate (untold)
    end do
    if (.not. stops(monitor)) believed = believed_lines(samples, found, confidence, false_alarm)
  end subroutine find_believed_lines

  pure function says_nothing(samples, believed) result(nothing)
    !! Whether the interval of a line reaches from its frequency to 0, unless it lies within 1/span of 0, where an offset that dies
    !! away is; or that of a line that drifts reaches over one of more energy, whose own drift may have left it.
    type(samples_type), intent(in) :: samples
    type(believed_line), intent(in) :: believed(:)
    logical :: nothing(size(believed))
    real(dp) :: strength(size(believed)), span     ! root of the energy
    integer :: k
    span = span_of(samples)
    nothing = believed%frequency_error >= believed%frequency .and. believed%frequency*span >= 1
    strength = [(norm2(abs(believed(k)%amplitude)), k=1, size(believed))]    ! at the first sample
    strength = strength*exp(min(-min(believed%decay, 0.0_dp)*span, most_growth))
    strength = strength/sqrt(max(abs(believed%decay)*span, 1.0_dp))
    do k = 1, size(believed)
      if (iand(believed(k)%status, drifting) == 0) cycle
      nothing(k) = nothing(k) .or. any(strength > strength(k) .and. &
        & abs(believed%frequency - believed(k)%frequency) < believed(k)%frequency_error)
    end do
  end function says_nothing

end module bw_believed_search
