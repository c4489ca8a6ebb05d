module bw_next_zero
  !! When a sum over oscillators falls to zero after an event, and whether it does so for certain. The search is in binary64
  !! and skips nothing (bw_signal); the time is then found, and the state moved there, in binary128.
  !! The margin within which the sum is known comes from the neighbours of the motion and from the noise of computing it in
  !! binary64.
  use bw_kinds, only: dp, qp
  use bw_monitor, only: monitor_type
  use bw_oscillators, only: moving_state, oscillators, weighted_sum
  use bw_perturbations, only: error_from, neighbours, perturbations
  use bw_safe_step, only: instant, instant_of
  use bw_signal, only: margin_type, signal_type
  implicit none (type, external)
  private
  public :: find_zero, margin_of

  integer, parameter, public :: never = 0, certain = 1, in_doubt = 2

  real(dp), parameter :: noise = 16*epsilon(1.0_dp)     !! of a signal, over what its parts can be

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

  pure type(margin_type) function margin_of(near, parts, sum_of, signal, order) result(margin)
    !! Until the next event.
    type(perturbations), intent(in) :: near
    type(oscillators), intent(in) :: parts
    type(weighted_sum), intent(in) :: sum_of
    type(signal_type), intent(in) :: signal        !! the sum
    integer, intent(in) :: order                   !! of the first derivative of the sum that is not zero for certain
    type(signal_type) :: other
    type(instant) :: reaches
    real(dp), dimension(neighbours) :: first, next, swing, drift
    real(dp), dimension(size(signal%u)) :: u, v
    real(dp) :: own_swing, own_drift
    integer :: p
    other%beta_squared = signal%beta_squared
    other%c = signal%c
    do p = 1, neighbours
      u = near%u(:, p)/signal%unit
      v = near%v(:, p)/signal%unit
      other%u = real(sum_of%a, dp)*u + real(sum_of%b, dp)*v
      other%u_dot = real(sum_of%a, dp)*v - real(sum_of%b, dp)*(signal%c*v + signal%beta_squared%hi*u)
      reaches = instant_of(other%beta_squared, other%c, 0.0_dp, other%u, other%u_dot)
      first(p) = other%derivative(order)
      next(p) = sum(reaches%reach*reaches%rate**(order + 1))
      call spread(reaches, swing(p), drift(p))
    end do
    margin%order = order
    margin%first = error_from(first)
    margin%next = error_from(next)
    margin%swing = error_from(swing)
    margin%drift = error_from(drift)
    reaches = instant_of(signal%beta_squared, signal%c, 0.0_dp, signal%u, signal%u_dot)
    call spread(reaches, own_swing, own_drift)
    margin%growth = sqrt(max(0.0_dp, maxval(-signal%beta_squared%hi)))
    margin%noise = noise*own_swing
    margin%noise_rate = noise*sum(reaches%rate*reaches%reach)
    margin%blur = noise*own_drift + sum(parts%square_error*reaches%reach/max(reaches%rate, 1.0_dp) &
                                        + parts%c_error*reaches%reach)
  end function margin_of

  pure subroutine spread(parts, swing, drift)
    !! How far from the start a sum may get: what turns at once, what does not at a rate.
    type(instant), intent(in) :: parts
    real(dp), intent(out) :: swing, drift
    swing = 2.0_dp*sum(parts%reach, mask=parts%turning)
    drift = sum(abs(parts%u_dot) + parts%rate*abs(parts%u), mask=.not. parts%turning)
  end subroutine spread

end module bw_next_zero
