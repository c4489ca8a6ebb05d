module bw_motion_margin
  !! Within what margin a sum over oscillators is known after an event, from the neighbours of the motion and from the noise
  !! of computing it in binary64.
  use bw_kinds, only: dp
  use bw_margin, only: margin_type
  use bw_oscillators, only: oscillators, weighted_sum
  use bw_perturbations, only: error_from, neighbours, perturbations
  use bw_safe_step, only: instant, instant_of
  use bw_signal, only: signal_type
  implicit none (type, external)
  private
  public :: margin_of

  real(dp), parameter :: noise = 16*epsilon(1.0_dp)     !! of a signal, over what its parts can be

contains

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
    !! How far from the start a sum may get: what turns at once, the rest at a rate.
    type(instant), intent(in) :: parts
    real(dp), intent(out) :: swing, drift
    swing = 2.0_dp*sum(parts%reach, mask=parts%turning)
    drift = sum(abs(parts%u_dot) + parts%rate*abs(parts%u), mask=.not. parts%turning)
  end subroutine spread

end module bw_motion_margin
