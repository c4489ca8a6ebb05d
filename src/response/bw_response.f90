module bw_response
  !! Modal state to histories at points of the beam: Eqs 27–30.
  !!
  !! The answer is exact in modal coordinates: what limits it is the truncation of the modes. It never asks which
  !! event left the state that it starts from. Velocities that are not asked for are an unallocated array, which the
  !! sums below receive as an absent argument.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, operator(*), operator(-)
  use bw_damped_modes, only: add_damped_modes, grows
  use bw_growing_modes, only: add_growing_mode, find_overflow
  use bw_missing, only: missing
  use bw_modal_flow, only: fast_exponent, slow_exponent
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, part_monitor
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_set_sum, only: add_products, add_transformed, modes_at_once, numbers_between, numbers_of, state_of
  use bw_sum_choice, only: chosen_sum, error_of_sum, sum_choice
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: free_motion, start_histories, add_motion, finish_histories, histories_of, turns_in_record

  real(dp), parameter :: log_huge = log(huge(1.0_dp))*(1.0_dp - 4*epsilon(1.0_dp))
    !! of the largest number, less what the roundings of a logarithm may amount to
  real(dp), parameter, public :: sum_tolerance = 2.0e-13_dp
    !! of the sum of modes, over the peak: far below what their number leaves

  type, public :: response_type
    !! Histories in the rotating frame, SI units.
    real(dp), allocatable :: displacement(:, :)   !! m, (samples, points); missing from the first overflow on
    real(dp), allocatable :: velocity(:, :)       !! m/s, (samples, points); allocated only if asked for
    real(dp), allocatable :: displacement_error(:)  !! m, estimate of the largest error, (points); not of a rebound
    real(dp), allocatable :: velocity_error(:)      !! m/s, (points)
    real(dp) :: mode_seconds = 0.0_dp             !! wall time of finding the modes that were streamed
    real(dp) :: sum_error = 0.0_dp                !! of the sums of modes, as a part of the largest value at any point
    integer :: transformed = 0                    !! modes that were summed by the transform
    integer :: finite_samples = 0                 !! samples before the first overflow; all where there is none
    integer :: failing_mode = 0                   !! the mode that overflows first; 0 where none does
  end type response_type

contains

  subroutine free_motion(modes, q_dot, points, grid, unit_time, with_velocity, monitor, response, kept)
    !! The motion that starts from rest position with given modal velocities.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q_dot(:)             !! modal velocities at t = 0, m/s, (modes)
    real(dp), intent(in) :: points(:)            !! ξ, (points)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: unit_time            !! l²/h, s
    logical, intent(in) :: with_velocity
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(out) :: response
    type(nonuniform_sum), intent(inout), optional :: kept    !! of another motion, whose plans may serve again
    call start_histories(grid, size(points), with_velocity, response)
    call add_motion(modes, q_dot*unit_time, points, grid, unit_time, monitor, response, kept=kept)
    call finish_histories(unit_time, response)
  end subroutine free_motion

  subroutine start_histories(grid, points, with_velocity, response)
    !! Histories of a beam at rest.
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: points                !! how many
    logical, intent(in) :: with_velocity
    type(response_type), intent(out) :: response
    allocate (response%displacement(grid%samples, points))
    response%displacement = 0.0_dp         ! by a fill of memory, which `source=` is not
    if (with_velocity) response%velocity = response%displacement
    response%finite_samples = grid%samples
  end subroutine start_histories

  subroutine add_motion(modes, rate, points, grid, unit_time, monitor, response, displaced, kept)
    !! Add modes that start from any state; velocities are in m per unit of time until the histories are finished.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: rate(:)              !! modal velocities at t = 0, m per l²/h, (modes)
    real(dp), intent(in) :: points(:)            !! ξ, (points)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: unit_time            !! l²/h, s
    class(monitor_type), intent(inout), target :: monitor
    type(response_type), intent(inout) :: response
    real(dp), intent(in), optional :: displaced(:)   !! modal displacements at t = 0, m, (modes); absent: none
    type(nonuniform_sum), intent(inout), optional :: kept    !! as that of `free_motion`
    type(nonuniform_sum) :: own
    if (allocated(modes%damping)) then
      call add_damped(modes, displaced, rate, points, grid, unit_time, monitor, response)
      response%sum_error = response%sum_error + error_of_sum(sum_choice(), grid%samples)
    else
      if (present(kept)) then
        call add_stable(modes, displaced, rate, points, grid, monitor, kept, response)
      else
        call add_stable(modes, displaced, rate, points, grid, monitor, own, response)
      end if
      call add_growing(modes, displaced, rate, points, grid, unit_time, monitor, response)
    end if
  end subroutine add_motion

  subroutine finish_histories(unit_time, response)
    !! Fill from the first overflow on, and velocities in m/s.
    real(dp), intent(in) :: unit_time            !! l²/h, s
    type(response_type), intent(inout) :: response
    response%displacement(response%finite_samples + 1:, :) = missing
    if (.not. allocated(response%velocity)) return
    response%velocity(:response%finite_samples, :) = response%velocity(:response%finite_samples, :)/unit_time
    response%velocity(response%finite_samples + 1:, :) = missing
  end subroutine finish_histories

  subroutine add_stable(modes, displaced, rate, points, grid, monitor, sum, response)
    !! Modes below their critical speed, all together; one that turns less than once in the record is left to the
    !! products, whose error follows its motion and not its amplitude.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in), optional :: displaced(:)
    real(dp), intent(in) :: rate(:), points(:)
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout), target :: monitor
    type(nonuniform_sum), intent(inout) :: sum
    type(response_type), intent(inout) :: response
    type(sum_choice) :: choice
    type(part_monitor) :: part
    logical :: turns(modes%count), left(modes%count)
    part = part_monitor(monitor)
    turns = turns_in_record(sqrt(max(0.0_dp, modes%beta_squared%hi)), grid)
    choice = chosen_sum(count(turns), grid%samples, histories_of(response), sum_tolerance)
    response%sum_error = response%sum_error + error_of_sum(choice, grid%samples)
    if (choice%transform) then
      response%transformed = response%transformed + count(turns)
      call add_transformed(modes, turns, choice, displaced, rate, points, grid, monitor, sum, response%displacement, &
                           response%velocity)
      if (monitor%stop_requested()) return
      left = modes%beta_squared%hi > 0.0_dp .and. .not. turns
      part = part_monitor(monitor, 1.0_dp, 0.0_dp)        ! of few modes
    else
      left = modes%beta_squared%hi > 0.0_dp
    end if
    if (any(left)) call add_products(modes, left, displaced, rate, points, grid, part, response%displacement, response%velocity)
  end subroutine add_stable

  subroutine add_damped(modes, displaced, rate, points, grid, unit_time, monitor, response)
    !! Damped modes, of many no more at a time than whose shapes may be held.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in), optional :: displaced(:)
    real(dp), intent(in) :: rate(:), points(:)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: unit_time
    class(monitor_type), intent(inout), target :: monitor
    type(response_type), intent(inout) :: response
    type(part_monitor) :: part
    integer, allocatable :: k(:)
    integer :: first, last, n
    n = modes_at_once(size(points))
    do first = 1, modes%count, n
      last = min(first + n - 1, modes%count)
      k = numbers_between(first, last)
      part = part_monitor(monitor, (first - 1.0_dp)/modes%count, (last - first + 1.0_dp)/modes%count)
      call add_some_damped(k, modes%beta_squared(k), modes%damping(k), state_of(k, displaced), rate(k), &
                           modes%some_shapes(first, last, points), grid, unit_time, part, response)
      if (monitor%stop_requested()) return
    end do
  end subroutine add_damped

  subroutine add_some_damped(number, beta_squared, c, q, rate, shapes, grid, unit_time, monitor, response)
    !! Of those that grow, A e^(st) is the motion of an undamped mode with β² = −s².
    integer, intent(in) :: number(:)             !! of the modes
    type(dd), intent(in) :: beta_squared(:)
    real(dp), intent(in) :: c(:), q(:), rate(:), shapes(:, :)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: unit_time
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response
    integer, allocatable :: k(:)
    type(dd), allocatable :: up(:)
    real(dp), allocatable :: down(:), growing(:), start(:), start_rate(:)
    start = response%displacement(1, :) + matmul(q, shapes)
    if (allocated(response%velocity)) start_rate = response%velocity(1, :) + matmul(rate, shapes)
    call add_damped_modes(beta_squared, c, q, rate, shapes, grid, monitor, response%displacement, response%velocity)
    k = numbers_of(grows(beta_squared, c, grid%samples*grid%step%hi))
    if (size(k) > 0) then
      up = slow_exponent(beta_squared(k), c(k))
      down = fast_exponent(beta_squared(k), c(k))
      growing = (rate(k) - down*q(k))/(up%hi - down)
      call add_some_growing(number(k), -(up*up), growing, growing*up%hi, shapes(k, :), grid, unit_time, monitor, response)
    end if
    response%displacement(1, :) = start          ! to the last digit: of a beam at rest position zero
    if (allocated(response%velocity)) response%velocity(1, :) = start_rate
  end subroutine add_some_damped

  elemental logical function turns_in_record(beta, grid)
    !! A slower mode's amplitude q̇/β is larger than its motion, and the transform's error follows the amplitude.
    real(dp), intent(in) :: beta
    type(time_grid), intent(in) :: grid
    turns_in_record = beta*(grid%samples*grid%step%hi) > 2.0_dp*dd_pi%hi
  end function turns_in_record

  pure integer function histories_of(response)
    !! Of displacements, and of velocities where they are asked for.
    type(response_type), intent(in) :: response
    histories_of = size(response%displacement, 2)
    if (allocated(response%velocity)) histories_of = 2*histories_of
  end function histories_of

  subroutine add_growing(modes, displaced, rate, points, grid, unit_time, monitor, response)
    !! Modes at or beyond their critical speed.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in), optional :: displaced(:)
    real(dp), intent(in) :: rate(:), points(:)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: unit_time
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response
    real(dp), allocatable :: shapes(:, :)
    integer, allocatable :: k(:)
    if (.not. any(modes%beta_squared%hi <= 0.0_dp)) return
    k = numbers_of(modes%beta_squared%hi <= 0.0_dp)
    shapes = modes%some_shapes(k(1), k(size(k)), points)
    call add_some_growing(k, modes%beta_squared(k), state_of(k, displaced), rate(k), shapes(k - k(1) + 1, :), grid, unit_time, &
                          monitor, response)
  end subroutine add_growing

  subroutine add_some_growing(number, beta_squared, q, rate, shapes, grid, unit_time, monitor, response)
    !! Up to the first sample at which their sum overflows, or a velocity in m/s.
    integer, intent(in) :: number(:)             !! of the modes
    type(dd), intent(in) :: beta_squared(:)      !! none above 0
    real(dp), intent(in) :: q(:), rate(:), shapes(:, :)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: unit_time
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response
    real(dp), allocatable :: velocity_limit        ! absent: no velocity is asked for
    integer, parameter :: block = 4096           ! samples
    integer :: first, k, finite, failing
    if (allocated(response%velocity)) velocity_limit = log_huge + min(0.0_dp, log(unit_time))
    call find_overflow(beta_squared, q, rate, shapes, grid, log_huge, velocity_limit, finite, failing)
    if (finite < response%finite_samples) then
      response%finite_samples = finite
      response%failing_mode = number(failing)
    end if
    do first = 1, response%finite_samples, block
      do k = 1, size(q)
        if (monitor%stop_requested()) return
        call add_growing_mode(beta_squared(k), q(k), rate(k), shapes(k, :), grid, min(first + block - 1, response%finite_samples), &
                              response%displacement, response%velocity, first)
      end do
    end do
  end subroutine add_some_growing

end module bw_response
