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
  use bw_modal_sum, only: add_stable_modes
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_nonuniform_sum, only: nonuniform_sum, transform_stable_modes
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
    allocate (response%displacement(grid%samples, points), source=0.0_dp)
    if (with_velocity) allocate (response%velocity(grid%samples, points), source=0.0_dp)
    response%finite_samples = grid%samples
  end subroutine start_histories

  subroutine add_motion(modes, rate, points, grid, unit_time, monitor, response, displaced, kept)
    !! Add modes that start from any state; velocities are in m per unit of time until the histories are finished.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: rate(:)              !! modal velocities at t = 0, m per l²/h, (modes)
    real(dp), intent(in) :: points(:)            !! ξ, (points)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: unit_time            !! l²/h, s
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response
    real(dp), intent(in), optional :: displaced(:)   !! modal displacements at t = 0, m, (modes); absent: none
    type(nonuniform_sum), intent(inout), optional :: kept    !! as that of `free_motion`
    type(nonuniform_sum) :: own
    real(dp) :: shapes(modes%count, size(points)), q(modes%count)
    shapes = modes%shapes(points)
    q = 0.0_dp
    if (present(displaced)) q = displaced
    if (allocated(modes%damping)) then
      call add_damped(modes%beta_squared, modes%damping, q, rate, shapes, grid, unit_time, monitor, response)
      response%sum_error = response%sum_error + error_of_sum(sum_choice(), grid%samples)
    else
      if (present(kept)) then
        call add_stable(modes%beta_squared, q, rate, shapes, grid, monitor, kept, response)
      else
        call add_stable(modes%beta_squared, q, rate, shapes, grid, monitor, own, response)
      end if
      call add_growing(modes%beta_squared, q, rate, shapes, grid, unit_time, response)
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

  subroutine add_stable(beta_squared, q, rate, shapes, grid, monitor, sum, response)
    !! Modes below their critical speed, all together; one that turns less than once in the record is left to the
    !! products, whose error follows its motion and not its amplitude.
    type(dd), intent(in) :: beta_squared(:)
    real(dp), intent(in) :: q(:), rate(:), shapes(:, :)
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    type(nonuniform_sum), intent(inout) :: sum
    type(response_type), intent(inout) :: response
    type(sum_choice) :: choice
    logical :: turns(size(q))
    turns = turns_in_record(sqrt(max(0.0_dp, beta_squared%hi)), grid)
    choice = chosen_sum(count(turns), grid%samples, histories_of(response), sum_tolerance)
    response%sum_error = response%sum_error + error_of_sum(choice, grid%samples)
    if (choice%transform) response%transformed = response%transformed + count(turns)
    if (.not. choice%transform) then
      call by_products(numbers_of(beta_squared%hi > 0.0_dp))
    else if (all(turns)) then
      call by_transform(beta_squared, q, rate, shapes)      ! as below, without copies
    else
      associate (k => numbers_of(turns))
        call by_transform(beta_squared(k), q(k), rate(k), shapes(k, :))
      end associate
      call by_products(numbers_of(beta_squared%hi > 0.0_dp .and. .not. turns))
    end if
  contains
    subroutine by_products(k)
      integer, intent(in) :: k(:)
      call add_stable_modes(beta_squared(k), q(k), rate(k), shapes(k, :), grid, monitor, response%displacement, &
                            response%velocity)
    end subroutine by_products
    subroutine by_transform(beta_squared, q, rate, shapes)
      type(dd), intent(in) :: beta_squared(:)
      real(dp), intent(in) :: q(:), rate(:), shapes(:, :)
      call transform_stable_modes(sum, beta_squared, q, rate, shapes, grid, choice%width, choice%half, monitor, &
                                  response%displacement, response%velocity)
    end subroutine by_transform
  end subroutine add_stable

  subroutine add_damped(beta_squared, c, q, rate, shapes, grid, unit_time, monitor, response)
    !! Damped modes; of those that grow, A e^(st) is the motion of an undamped mode with β² = −s².
    type(dd), intent(in) :: beta_squared(:)
    real(dp), intent(in) :: c(:), q(:), rate(:), shapes(:, :)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: unit_time
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response
    integer, allocatable :: k(:)
    integer :: finite
    type(dd), allocatable :: up(:)
    real(dp), allocatable :: down(:), growing(:)
    call add_damped_modes(beta_squared, c, q, rate, shapes, grid, monitor, response%displacement, response%velocity)
    k = numbers_of(grows(beta_squared, c, grid%samples*grid%step%hi))
    if (size(k) == 0) return
    up = slow_exponent(beta_squared(k), c(k))
    down = fast_exponent(beta_squared(k), c(k))
    growing = (rate(k) - down*q(k))/(up%hi - down)
    finite = response%finite_samples
    call add_growing(-(up*up), growing, growing*up%hi, shapes(k, :), grid, unit_time, response)
    if (response%finite_samples < finite) response%failing_mode = k(response%failing_mode)
  end subroutine add_damped

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

  pure function numbers_of(chosen) result(k)
    logical, intent(in) :: chosen(:)
    integer, allocatable :: k(:)
    integer :: i
    k = pack([(i, i=1, size(chosen))], chosen)
  end function numbers_of

  pure subroutine add_growing(beta_squared, q, rate, shapes, grid, unit_time, response)
    !! Modes at or beyond their critical speed, up to the first sample at which their sum overflows, or a velocity
    !! in m/s.
    type(dd), intent(in) :: beta_squared(:)
    real(dp), intent(in) :: q(:), rate(:), shapes(:, :)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: unit_time
    type(response_type), intent(inout) :: response
    integer, allocatable :: growing(:)
    real(dp), allocatable :: velocity_limit        ! absent: no velocity is asked for
    integer :: i, k, finite, failing
    growing = numbers_of(beta_squared%hi <= 0.0_dp)
    if (size(growing) == 0) return
    if (allocated(response%velocity)) velocity_limit = log_huge + min(0.0_dp, log(unit_time))
    call find_overflow(beta_squared(growing), q(growing), rate(growing), shapes(growing, :), grid, log_huge, &
                       velocity_limit, finite, failing)
    if (finite < response%finite_samples) then
      response%finite_samples = finite
      response%failing_mode = growing(failing)
    end if
    do i = 1, size(growing)
      k = growing(i)
      call add_growing_mode(beta_squared(k), q(k), rate(k), shapes(k, :), grid, response%finite_samples, &
                            response%displacement, response%velocity)
    end do
  end subroutine add_growing

end module bw_response
