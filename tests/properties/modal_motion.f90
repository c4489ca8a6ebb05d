module modal_motion
  !! Each mode's own motion: the histories of `bw_response` at points where one mode has the shape 1 and the others 0.
  use bw_double_double, only: operator(*)
  use bw_growing_modes, only: add_sample_by_sample
  use bw_kinds, only: dp
  use bw_modal_sum, only: add_stable_modes
  use bw_mode_set, only: mode_set
  use bw_monitor, only: silent_monitor
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: move

contains

  subroutine move(modes, q, q_dot, grid, displacement, velocity)
    !! Modal displacements and velocities at all samples.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), q_dot(:)                                !! at t = 0, (modes)
    type(time_grid), intent(in) :: grid
    real(dp), allocatable, intent(out) :: displacement(:, :), velocity(:, :)   !! (samples, modes)
    type(silent_monitor) :: monitor
    real(dp) :: unit(modes%count, modes%count)
    integer, allocatable :: stable(:)
    integer :: k
    allocate (displacement(grid%samples, modes%count), velocity(grid%samples, modes%count), source=0.0_dp)
    unit = 0.0_dp
    do k = 1, modes%count
      unit(k, k) = 1.0_dp
    end do
    stable = pack([(k, k=1, modes%count)], modes%beta_squared%hi > 0.0_dp)
    call add_stable_modes(modes%beta_squared(stable), q(stable), q_dot(stable), unit(stable, :), grid, monitor, &
                          displacement, velocity)
    do k = 1, modes%count
      if (modes%beta_squared(k)%hi > 0.0_dp) cycle
      call add_sample_by_sample(modes%beta_squared(k), 0.0_dp, q(k), q_dot(k), unit(k, :), grid, [1, grid%samples], &
                            displacement, velocity)
    end do
  end subroutine move

end module modal_motion
