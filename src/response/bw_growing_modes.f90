module bw_growing_modes
  !! Histories of modes at or beyond their critical speed, β² ≤ 0: q C + q̇ S with C = cosh|β|t, S = sinh|β|t/|β|,
  !! and C = 1, S = t at β = 0: the same smooth functions of β² as those of the stable modes.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, sqrt, operator(-), operator(*)
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: add_growing_mode, samples_until_overflow

  real(dp), parameter :: log_half = log(0.5_dp)
  real(dp), parameter :: largest_exponent = 1400.0_dp   !! of e^x taken as the square of e^(x/2)

contains

  pure integer function samples_until_overflow(beta_squared, q, q_dot, shapes, grid, limit, velocity_limit) result(samples)
    !! How many samples of a growing mode are, at every point, no larger than given limits. The mode moves as
    !! Φ·½(q + q̇/|β|)e^(|β|t), and a part that decays.
    type(dd), intent(in) :: beta_squared         !! β² ≤ 0
    real(dp), intent(in) :: q, q_dot             !! modal displacement and velocity at t = 0
    real(dp), intent(in) :: shapes(:)            !! Φ(ξ_p), (points)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: limit                !! logarithm of the largest displacement
    real(dp), intent(in), optional :: velocity_limit   !! the same for the velocity; absent: none is asked for
    type(dd) :: rate
    real(dp) :: amplitude, room
    samples = grid%samples
    rate = sqrt(-beta_squared)
    amplitude = maxval([0.0_dp, abs(shapes)])
    if (rate%hi == 0.0_dp .or. amplitude == 0.0_dp .or. rate%hi*q + q_dot == 0.0_dp) return
    amplitude = log_half + log(amplitude) + log(abs(rate%hi*q + q_dot))      ! of the velocity
    room = limit - amplitude + log(rate%hi)
    if (present(velocity_limit)) room = min(room, velocity_limit - amplitude)
    room = min(room, largest_exponent)
    if (room < rate%hi*grid%step%hi*(samples - 1)) samples = max(0, floor(room/(rate%hi*grid%step%hi))) + 1
  end function samples_until_overflow

  pure subroutine add_growing_mode(beta_squared, q, q_dot, shapes, grid, samples, displacement, velocity)
    !! Adds one mode's motion to the first `samples` samples.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: q, q_dot
    real(dp), intent(in) :: shapes(:)
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: samples               !! at most those of `samples_until_overflow`
    real(dp), intent(inout) :: displacement(:, :)          !! (samples, points)
    real(dp), intent(inout), optional :: velocity(:, :)
    type(dd) :: rate, time, x
    integer :: j
    rate = sqrt(-beta_squared)
    do j = 1, samples
      time = grid%step*real(j - 1, dp)
      x = rate*time
      displacement(j, :) = displacement(j, :) + displacement_at(x, time%hi, rate%hi, q, q_dot, shapes)
      if (present(velocity)) velocity(j, :) = velocity(j, :) + velocity_at(x, rate%hi, q, q_dot, shapes)
    end do
  end subroutine add_growing_mode

  elemental real(dp) function displacement_at(x, time, rate, q, q_dot, shape) result(now)
    !! Φ·(q C + q̇ S).
    type(dd), intent(in) :: x                    !! |β|t
    real(dp), intent(in) :: time, rate, q, q_dot, shape
    if (x%hi < 1.0_dp) then
      now = shape*(q*cosh(x%hi) + q_dot*time*mean_hyperbolic_cosine(x%hi))
    else
      now = exponentials(shape*(0.5_dp*(q + q_dot/rate)), shape*(0.5_dp*(q - q_dot/rate)), x)
    end if
  end function displacement_at

  elemental real(dp) function velocity_at(x, rate, q, q_dot, shape) result(now)
    !! Its derivative.
    type(dd), intent(in) :: x
    real(dp), intent(in) :: rate, q, q_dot, shape
    if (x%hi < 1.0_dp) then
      now = shape*(q_dot*cosh(x%hi) + q*rate*sinh(x%hi))
    else
      now = exponentials(shape*(0.5_dp*(rate*q + q_dot)), shape*(0.5_dp*(q_dot - rate*q)), x)
    end if
  end function velocity_at

  elemental real(dp) function mean_hyperbolic_cosine(x) result(mean)
    !! sinh x/x, 1 at x = 0: the mean of cosh from 0 to x.
    real(dp), intent(in) :: x
    mean = 1.0_dp
    if (x > 0.0_dp) mean = sinh(x)/x
  end function mean_hyperbolic_cosine

  elemental real(dp) function exponentials(growing, decaying, x) result(value)
    !! growing·e^x + decaying·e^(−x). As e^x may overflow where the product does not, the growing part is multiplied
    !! by e^(x/2) twice. The part of the exponent that rounding would lose, up to 1e-13, is added to first order.
    real(dp), intent(in) :: growing, decaying
    type(dd), intent(in) :: x                     !! 0 ≤ x ≤ `largest_exponent`
    real(dp) :: half
    half = exp(0.5_dp*x%hi)*(1.0_dp + 0.5_dp*x%lo)
    value = (growing*half)*half + (decaying/half)/half
  end function exponentials

end module bw_growing_modes
