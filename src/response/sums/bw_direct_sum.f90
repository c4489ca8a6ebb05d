module bw_direct_sum
  !! Displacements at a few chosen times, mode by mode: phases reduced and terms added in extended precision, no blocks,
  !! no tables, no transform, each time from the start. Slow, and what the fast sums are checked against.
  use bw_kinds, only: dp
  use bw_double_double, only: accurate_sum, dd, dd_pi, sqrt, operator(+), operator(*), operator(/)
  use bw_growing_modes, only: add_growing_mode
  use bw_modal_flow, only: flow
  use bw_mode_set, only: mode_set
  use bw_time_grid, only: time_grid
  use bw_turn, only: phase_angles
  implicit none (type, external)
  private
  public :: add_directly

contains

  pure subroutine add_directly(modes, rate, points, times, displacement, displaced)
    !! Adds the motion of modes from their state at t = 0.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: rate(:)                  !! modal velocities at t = 0, length per l²/h, (modes)
    real(dp), intent(in) :: points(:)                !! ξ, (points)
    type(dd), intent(in) :: times(:)                 !! l²/h, (times)
    type(dd), intent(inout) :: displacement(:, :)    !! (times, points)
    real(dp), intent(in), optional :: displaced(:)   !! modal displacements at t = 0, (modes); absent: none
    real(dp) :: shapes(modes%count, size(points)), q(modes%count)
    q = 0.0_dp
    if (present(displaced)) q = displaced
    shapes = modes%shapes(points)
    if (allocated(modes%damping)) then
      call add_damped(modes, q, rate, shapes, times, displacement)
    else
      call add_undamped(modes, q, rate, shapes, times, displacement)
    end if
  end subroutine add_directly

  pure subroutine add_damped(modes, q, rate, shapes, times, displacement)
    !! Damped modes: the state of all of them at each time.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:), shapes(:, :)
    type(dd), intent(in) :: times(:)
    type(dd), intent(inout) :: displacement(:, :)
    real(dp) :: moved(modes%count), velocity(modes%count)
    integer :: j, p
    do j = 1, size(times)
      moved = q
      velocity = rate
      call flow(modes%beta_squared, modes%damping, times(j), moved, velocity)
      do p = 1, size(shapes, 2)
        displacement(j, p) = displacement(j, p) + accurate_sum(moved*shapes(:, p))
      end do
    end do
  end subroutine add_damped

  pure subroutine add_undamped(modes, q, rate, shapes, times, displacement)
    !! Undamped modes, those that grow one by one.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:), shapes(:, :)
    type(dd), intent(in) :: times(:)
    type(dd), intent(inout) :: displacement(:, :)
    type(dd) :: beta(modes%count)
    integer :: j, k, p
    beta = sqrt(modes%beta_squared)                  ! 0 where it is not real
    do j = 1, size(times)
      associate (motion => swing(beta, phase_angles(beta*(times(j)/(dd_pi*2.0_dp)), 1), q, rate))
        do p = 1, size(shapes, 2)
          displacement(j, p) = displacement(j, p) + accurate_sum(motion*shapes(:, p))
        end do
      end associate
    end do
    do k = 1, modes%count
      if (beta(k)%hi > 0.0_dp) cycle
      call add_growing(modes%beta_squared(k), q(k), rate(k), shapes(k, :), times, displacement)
    end do
  end subroutine add_undamped

  elemental real(dp) function swing(beta, angle, q, rate) result(motion)
    !! q cos βt + q̇ sin βt/β; 0 for a mode that is not stable.
    type(dd), intent(in) :: beta
    real(dp), intent(in) :: angle                    !! βt less whole turns
    real(dp), intent(in) :: q, rate
    motion = 0.0_dp
    if (beta%hi > 0.0_dp) motion = q*cos(angle) + rate*sin(angle)/beta%hi
  end function swing

  pure subroutine add_growing(beta_squared, q, rate, shapes, times, displacement)
    !! A mode at or beyond its critical speed: each time is the second one of a grid with a step as long.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: q, rate, shapes(:)
    type(dd), intent(in) :: times(:)
    type(dd), intent(inout) :: displacement(:, :)
    real(dp) :: motion(2, size(shapes))
    integer :: j
    do j = 1, size(times)
      motion = 0.0_dp
      call add_growing_mode(beta_squared, q, rate, shapes, time_grid(2, times(j)), [2, 2], motion)
      displacement(j, :) = displacement(j, :) + motion(2, :)
    end do
  end subroutine add_growing

end module bw_direct_sum
