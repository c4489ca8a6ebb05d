module bw_growing_modes
  !! Histories of modes at or beyond their critical speed, β² ≤ 0: q C + q̇ S with C = cosh|β|t, S = sinh|β|t/|β|,
  !! and C = 1, S = t at β = 0: the same smooth functions of β² as those of the stable modes.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, sqrt, operator(-), operator(*)
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: add_growing_mode, samples_until_overflow

  real(dp), parameter :: log_huge = log(huge(1.0_dp))

contains

  pure integer function samples_until_overflow(beta_squared, q, q_dot, shapes, grid, with_velocity) result(samples)
    !! How many samples of a growing mode are finite numbers at every point.
    type(dd), intent(in) :: beta_squared         !! β² ≤ 0
    real(dp), intent(in) :: q, q_dot             !! modal displacement and velocity at t = 0
    real(dp), intent(in) :: shapes(:)            !! Φ(ξ_p), (points)
    type(time_grid), intent(in) :: grid
    logical, intent(in) :: with_velocity         !! velocities are asked for as well
    type(dd) :: rate
    real(dp) :: amplitude, room
    samples = grid%samples
    rate = sqrt(-beta_squared)
    if (rate%hi == 0.0_dp) return
    amplitude = max(1.0_dp, maxval(abs(shapes)))*(abs(q) + abs(q_dot)/rate%hi)
    if (amplitude == 0.0_dp) return
    room = log_huge - max(0.0_dp, log(amplitude))
    if (with_velocity) room = room - max(0.0_dp, log(rate%hi))
    if (room < rate%hi*grid%step%hi*(samples - 1)) samples = int(room/(rate%hi*grid%step%hi)) + 1
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
    type(dd) :: rate, turn
    real(dp) :: c, s, now, now_dot
    integer :: j
    rate = sqrt(-beta_squared)
    do j = 1, samples
      turn = grid%step*real(j - 1, dp)
      call hyperbolic_pair(rate, turn, c, s)
      now = q*c + q_dot*s
      displacement(j, :) = displacement(j, :) + shapes*now
      if (.not. present(velocity)) cycle
      now_dot = q_dot*c + rate%hi*(rate%hi*s)*q
      velocity(j, :) = velocity(j, :) + shapes*now_dot
    end do
  end subroutine add_growing_mode

  pure subroutine hyperbolic_pair(rate, time, c, s)
    !! cosh(rate·t) and sinh(rate·t)/rate; t where the rate is zero. The part of the exponent that rounding would
    !! lose, up to 1e-13 of a number near overflow, is added to first order.
    type(dd), intent(in) :: rate, time
    real(dp), intent(out) :: c, s
    type(dd) :: x
    real(dp) :: hyperbolic_cosine, hyperbolic_sine
    x = rate*time
    hyperbolic_cosine = cosh(x%hi)
    hyperbolic_sine = sinh(x%hi)
    c = hyperbolic_cosine + x%lo*hyperbolic_sine
    s = time%hi
    if (rate%hi > 0.0_dp) s = (hyperbolic_sine + x%lo*hyperbolic_cosine)/rate%hi
  end subroutine hyperbolic_pair

end module bw_growing_modes
