module bw_direct_sum
  !! Displacements at a few chosen samples, mode by mode: phases reduced and terms added in extended precision, no blocks,
  !! no tables, no transform. Slow, and what the fast sums are checked against.
  use bw_kinds, only: dp
  use bw_double_double, only: accurate_sum, dd, dd_pi, sqrt, operator(+), operator(*), operator(/)
  use bw_growing_modes, only: add_growing_mode
  use bw_mode_set, only: mode_set
  use bw_time_grid, only: time_grid
  use bw_turn, only: phase_angles
  implicit none (type, external)
  private
  public :: add_directly

contains

  pure subroutine add_directly(modes, rate, points, grid, sample, displacement)
    !! Adds the motion of modes that start from rest position.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: rate(:)                  !! modal velocities at t = 0, length per l²/h, (modes)
    real(dp), intent(in) :: points(:)                !! ξ, (points)
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: sample(:)                 !! numbers of samples, from 0, (samples)
    type(dd), intent(inout) :: displacement(:, :)    !! (samples, points)
    real(dp) :: shapes(modes%count, size(points))
    type(dd), dimension(modes%count) :: beta, cycles
    logical :: stable(modes%count)
    integer :: j, k, p
    shapes = modes%shapes(points)
    stable = modes%beta_squared%hi > 0.0_dp
    beta = sqrt(modes%beta_squared)                  ! 0 where it is not real
    cycles = beta*(grid%step/(dd_pi*2.0_dp))
    do j = 1, size(sample)
      associate (motion => sine_motion(beta, phase_angles(cycles, sample(j)), rate))
        do p = 1, size(points)
          displacement(j, p) = displacement(j, p) + accurate_sum(motion*shapes(:, p))
        end do
      end associate
    end do
    do k = 1, modes%count
      if (stable(k)) cycle
      call add_growing(modes%beta_squared(k), rate(k), shapes(k, :), grid, sample, displacement)
    end do
  end subroutine add_directly

  elemental real(dp) function sine_motion(beta, angle, rate) result(motion)
    !! q̇ sin βt/β; 0 for a mode that is not stable.
    type(dd), intent(in) :: beta
    real(dp), intent(in) :: angle                    !! βt less whole turns
    real(dp), intent(in) :: rate
    motion = 0.0_dp
    if (beta%hi > 0.0_dp) motion = rate*sin(angle)/beta%hi
  end function sine_motion

  pure subroutine add_growing(beta_squared, rate, shapes, grid, sample, displacement)
    !! A mode at or beyond its critical speed: each sample is the second one of a grid with a step as long.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: rate, shapes(:)
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: sample(:)
    type(dd), intent(inout) :: displacement(:, :)
    type(time_grid) :: coarse
    real(dp) :: motion(2, size(shapes))
    integer :: j
    coarse%samples = 2
    do j = 1, size(sample)
      coarse%step = grid%step*real(sample(j), dp)
      motion = 0.0_dp
      call add_growing_mode(beta_squared, 0.0_dp, rate, shapes, coarse, 2, motion)
      displacement(j, :) = displacement(j, :) + motion(2, :)
    end do
  end subroutine add_growing

end module bw_direct_sum
