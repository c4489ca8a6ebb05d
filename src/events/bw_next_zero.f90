module bw_next_zero
  !! When a sum over oscillators falls to zero after an event, and whether it does so for certain. The search is in binary64
  !! and skips nothing (bw_signal); the time is then found, and the state moved there, in binary128.
  use bw_kinds, only: dp, qp
  use bw_monitor, only: monitor_type
  use bw_motion_margin, only: margin_of
  use bw_oscillators, only: moving_state, oscillators, weighted_sum
  use bw_perturbations, only: perturbations
  use bw_signal, only: signal_type
  implicit none (type, external)
  private
  public :: find_zero

  integer, parameter, public :: never = 0, certain = 1, in_doubt = 2

contains

  subroutine find_zero(parts, sum_of, near, order, longest, state, outcome, monitor)
    !! The first zero within `longest`.
    type(oscillators), intent(in) :: parts
    type(weighted_sum), intent(in) :: sum_of      !! positive from the start on, for certain but for its margin
    type(perturbations), intent(in) :: near       !! neighbours of the motion at the start
    integer, intent(in) :: order                  !! of the first derivative of the sum that is not zero at the start
    real(dp), intent(in) :: longest
    type(moving_state), intent(inout) :: state    !! moved to the zero, to where it is in doubt, or to the end
    integer, intent(out) :: outcome               !! never, certain or in_doubt
    class(monitor_type), intent(inout), optional :: monitor   !! the outcome means nothing where it asks to stop
    type(signal_type) :: signal
    real(qp) :: end
    real(dp) :: touch
    logical :: found
    end = state%time + longest
    signal = parts%signal(sum_of, state, order)
    signal%margin = margin_of(near, parts, sum_of, signal, order)
    if (order == 0) then
      call signal%first_zero(0.0_dp, longest, epsilon(longest)*longest, found, touch, monitor=monitor)
    else
      call signal%first_zero(0.0_dp, longest, epsilon(longest)*longest, found, touch, order, monitor)
    end if
    outcome = never
    if (found) call arrive(parts, sum_of, signal, touch, state, outcome)
    if (outcome == certain .and. state%time > end) outcome = never
    if (outcome == never) call parts%move(end - state%time, state)
  end subroutine find_zero

  subroutine arrive(parts, sum_of, signal, touch, state, outcome)
    !! To the zero behind the time at which a signal comes within its margin of it, if there is one for certain.
    type(oscillators), intent(in) :: parts
    type(weighted_sum), intent(in) :: sum_of
    type(signal_type), intent(in) :: signal       !! the sum
    real(dp), intent(in) :: touch                 !! that time
    type(moving_state), intent(inout) :: state
    integer, intent(out) :: outcome               !! certain or in_doubt
    real(qp) :: start
    real(dp) :: zero, off
    logical :: sure
    start = state%time
    call signal%falls_through(touch, sure, zero)
    call parts%move(real(merge(zero, touch, sure), qp), state)
    if (sure) call parts%closest(sum_of, state, sure)
    off = real(abs(state%time - start - zero), dp)
    outcome = merge(certain, in_doubt, sure .and. off <= max(zero - touch, epsilon(zero)*zero))
  end subroutine arrive

end module bw_next_zero
