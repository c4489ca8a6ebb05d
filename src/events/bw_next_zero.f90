module bw_next_zero
  !! When a sum over oscillators falls to zero after an event, and whether it does so for certain. The search is in binary64
  !! and skips nothing (bw_signal); the time is then found, and the state moved there, in binary128.
  use bw_kinds, only: dp, qp
  use bw_motion_margin, only: margin_of
  use bw_oscillators, only: moving_state, oscillators, weighted_sum
  use bw_perturbations, only: perturbations
  use bw_signal, only: signal_type
  implicit none (type, external)
  private
  public :: find_zero

  integer, parameter, public :: never = 0, certain = 1, in_doubt = 2

contains

  subroutine find_zero(parts, sum_of, near, order, longest, state, time, outcome)
    !! The first zero within `longest`.
    type(oscillators), intent(in) :: parts
    type(weighted_sum), intent(in) :: sum_of      !! positive from the start on, for certain but for its margin
    type(perturbations), intent(in) :: near       !! neighbours of the motion at the start
    integer, intent(in) :: order                  !! of the first derivative of the sum that is not zero at the start
    real(dp), intent(in) :: longest
    type(moving_state), intent(inout) :: state    !! moved by `time`
    real(qp), intent(out) :: time                 !! to the zero, or to where it is in doubt; `longest` where there is none
    integer, intent(out) :: outcome
    type(signal_type) :: signal
    real(dp) :: touch, zero
    logical :: found, sure
    signal = parts%signal(sum_of, state, order)
    signal%margin = margin_of(near, parts, sum_of, signal, order)
    if (order == 0) then
      call signal%first_zero(0.0_dp, longest, epsilon(longest)*longest, found, touch)
    else
      call signal%first_zero(0.0_dp, longest, epsilon(longest)*longest, found, touch, opening=order)
    end if
    outcome = never
    time = longest
    if (found) then
      outcome = in_doubt
      call signal%falls_through(touch, sure, zero)
      time = merge(zero, touch, sure)
    end if
    call parts%move(time, state)
    if (.not. (found .and. sure)) return
    call parts%closest(sum_of, state, time, sure)
    if (sure) sure = abs(time - zero) <= max(zero - touch, epsilon(zero)*zero)
    if (.not. sure) return
    outcome = certain
    if (time <= longest) return
    outcome = never
    call parts%move(longest - time, state)
    time = longest
  end subroutine find_zero

end module bw_next_zero
