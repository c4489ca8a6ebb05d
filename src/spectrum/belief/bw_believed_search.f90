module bw_believed_search
  !! The lines of a record that it tells something of: they are found and judged, and judged once more without those whose
  !! intervals say nothing.
  !!
  !! Noise that is smooth, as behind a filter, and what a mode leaves that changes as it dies away, are described by lines that
  !! drift as one likes. Each pays for its unknowns; but only its interval, which holds the ends of its drift and what is left
  !! beside it, shows that its frequency may be any.
  use bw_belief, only: believed_line, believed_lines
  use bw_damped_search, only: find_damped_lines, fit_without
  use bw_found_lines, only: found_lines
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type, stops
  use bw_samples, only: samples_type, span_of
  implicit none (type, external)
  private
  public :: find_believed_lines

  integer, parameter :: most_rounds = 4

contains

  subroutine find_believed_lines(samples, confidence, false_alarm, found, believed, monitor)
    !! Find the lines of a record with their intervals. A line whose interval reaches from its frequency to 0 is refused as
    !! uncertain, unless it lies within 1/span of 0, where an offset that dies away is.
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
      untold(believed%number) = believed%frequency_error >= believed%frequency .and. believed%frequency*span_of(samples) >= 1
      if (.not. any(untold)) return
      call fit_without(samples, untold, found, monitor)
      deallocate (untold)
    end do
    if (.not. stops(monitor)) believed = believed_lines(samples, found, confidence, false_alarm)
  end subroutine find_believed_lines

end module bw_believed_search
