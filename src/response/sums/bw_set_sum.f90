module bw_set_sum
  !! Histories of the modes of one set, from any initial state: Eq. 29. Many modes are summed in parts whose shapes fit in memory.
  use bw_damped_modes, only: add_damped_modes, damped_motion, grows
  use bw_double_double, only: dd, sqrt, operator(*), operator(-)
  use bw_growing_modes, only: add_sample_by_sample, find_overflow
  use bw_kinds, only: dp
  use bw_modal_flow, only: fast_exponent, slow_exponent
  use bw_modal_sum, only: add_stable_modes
  use bw_mode_set, only: batch, mode_set, values_at
  use bw_monitor, only: monitor_type, part_monitor
  use bw_nonuniform_sum, only: nonuniform_sum, points_at_once
  use bw_response, only: histories_of, response_type, turns_in_record
  use bw_sum_choice, only: chosen_sum, error_of_sum, sum_choice
  implicit none (type, external)
  private
  public :: add_motion, modes_at_once

  integer, parameter :: most_numbers = 2**22   !! values of shapes in memory at a time
  real(dp), parameter :: log_huge = log(huge(1.0_dp))*(1.0_dp - 4*epsilon(1.0_dp))
    !! of the largest number, less rounding errors of a logarithm

contains

  subroutine add_motion(modes, rate, monitor, response, displaced, workspace, range)
    !! Add modes with any initial state. Velocities are in m per unit of the grid's time until the histories are finished.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: rate(:)              !! modal velocities at t = 0, m per l²/h, (modes)
    class(monitor_type), intent(inout), target :: monitor
    type(response_type), intent(inout) :: response   !! started
    real(dp), intent(in), optional :: displaced(:)   !! modal displacements at t = 0, m, (modes); absent: 0
    type(nonuniform_sum), intent(inout), optional :: workspace    !! of another motion, whose plans are reused
    integer, intent(in), optional :: range(2)    !! first and last mode added; absent: all
    type(nonuniform_sum) :: own
    real(dp), allocatable :: q(:)
    integer :: ends(2)
    ends = [1, modes%count]
    if (present(range)) ends = range
    if (ends(1) > ends(2)) return
    allocate (q(modes%count), source=0.0_dp)
    if (present(displaced)) q = displaced
    if (allocated(modes%damping)) then
      call add_damped(modes, ends, q, rate, monitor, response)
      response%sum_error = response%sum_error + error_of_sum(sum_choice(), response%sampling%grid%samples)
    else
      if (present(workspace)) then
        call add_stable(modes, ends, q, rate, monitor, workspace, response)
      else
        call add_stable(modes, ends, q, rate, monitor, own, response)
      end if
      call add_growing(modes, ends, q, rate, monitor, response)
    end if
  end subroutine add_motion

  subroutine add_stable(modes, ends, q, rate, monitor, workspace, response)
    !! Add modes below their critical speed. One that completes less than a cycle in the record is left to matrix
    !! products, whose error is relative to its motion, not to its amplitude.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: ends(2)               !! first and last mode added
    real(dp), intent(in) :: q(:), rate(:)        !! displacements and velocities at t = 0, (modes)
    class(monitor_type), intent(inout), target :: monitor
    type(nonuniform_sum), intent(inout) :: workspace
    type(response_type), intent(inout) :: response
    type(sum_choice) :: choice
    type(part_monitor) :: part
    logical, dimension(modes%count) :: others, stable, turns
    integer :: k
    part = part_monitor(monitor)
    stable = modes%beta_squared%hi > 0.0_dp .and. [(k >= ends(1) .and. k <= ends(2), k=1, modes%count)]
    turns = stable .and. turns_in_record(sqrt(max(0.0_dp, modes%beta_squared%hi)), response%sampling%grid)
    choice = chosen_sum(count(turns), response%sampling%grid%samples, histories_of(response))
    response%sum_error = response%sum_error + error_of_sum(choice, response%sampling%grid%samples)
    if (choice%transform) then
      response%transformed = response%transformed + count(turns)
      call add_transformed(modes, turns, choice, q, rate, monitor, workspace, response)
      if (monitor%stop_requested()) return
      others = stable .and. .not. turns
      part = part_monitor(monitor, 1.0_dp, 0.0_dp)        ! few modes remain
    else
      others = stable
    end if
    if (any(others)) call add_products(modes, others, q, rate, part, response)
  end subroutine add_stable

  subroutine add_products(modes, chosen, q, rate, monitor, response)
    !! Add some of the modes by matrix products. Shapes are evaluated in fixed ranges, as a set may have stored them for all modes.
    class(mode_set), intent(in) :: modes
    logical, intent(in) :: chosen(:)             !! (modes)
    real(dp), intent(in) :: q(:), rate(:)        !! displacements and velocities at t = 0, (modes)
    class(monitor_type), intent(inout), target :: monitor
    type(response_type), intent(inout) :: response
    type(part_monitor) :: part
    integer, allocatable :: k(:)
    integer :: first, last, n
    n = modes_at_once(size(response%sampling%points))
    do first = 1, modes%count, n
      last = min(first + n - 1, modes%count)
      k = numbers_of(chosen(first:last)) + (first - 1)
      if (size(k) == 0) cycle
      part = part_monitor(monitor, (first - 1.0_dp)/modes%count, (last - first + 1.0_dp)/modes%count)
      associate (shapes => values_at(modes, response%sampling%quantity, first, last, response%sampling%points))
        call add_stable_modes(modes%beta_squared(k), q(k), rate(k), shapes(k - first + 1, :), &
                              response%sampling%grid, part, response%displacement, response%velocity)
      end associate
      if (monitor%stop_requested()) return
    end do
  end subroutine add_products

  subroutine add_transformed(modes, chosen, choice, q, rate, monitor, workspace, response)
    !! Add some of the modes by the transform, with shapes for part of the modes and points at a time.
    class(mode_set), intent(in) :: modes
    logical, intent(in) :: chosen(:)             !! (modes)
    type(sum_choice), intent(in) :: choice
    real(dp), intent(in) :: q(:), rate(:)        !! displacements and velocities at t = 0, (modes)
    class(monitor_type), intent(inout) :: monitor
    type(nonuniform_sum), intent(inout) :: workspace
    type(response_type), intent(inout) :: response
    real(dp), allocatable :: shapes(:, :)
    integer, allocatable :: k(:)
    integer :: e, first, last, p, group
    logical :: moved
    moved = any(q /= 0.0_dp)
    associate (points => response%sampling%points, grid => response%sampling%grid, with_velocity => allocated(response%velocity))
      group = points_at_once(choice%half, grid%samples, size(points), merge(2, 1, with_velocity)*merge(2, 1, moved))
      allocate (shapes(batch, group))
      do p = 1, size(points), group
        e = min(p + group - 1, size(points))
        call workspace%open(grid, choice%width, choice%half, e - p + 1, with_velocity, moved)
        do first = 1, modes%count, batch
          last = min(first + batch - 1, modes%count)
          k = numbers_of(chosen(first:last)) + (first - 1)
          if (size(k) == 0) cycle
          shapes(:k(size(k)) - k(1) + 1, :e - p + 1) = &
            values_at(modes, response%sampling%quantity, k(1), k(size(k)), points(p:e))
          if (moved) then
            call workspace%add(sqrt(modes%beta_squared(k)), rate(k), shapes(k - k(1) + 1, :e - p + 1), q(k))
          else
            call workspace%add(sqrt(modes%beta_squared(k)), rate(k), shapes(k - k(1) + 1, :e - p + 1))
          end if
          call monitor%advance((p - 1 + (e - p + 1)*(real(last, dp)/modes%count))/size(points))
          if (monitor%stop_requested()) return
        end do
        if (with_velocity) then
          call workspace%close(response%displacement(:, p:e), response%velocity(:, p:e), monitor)
        else
          call workspace%close(response%displacement(:, p:e), monitor=monitor)
        end if
      end do
    end associate
    call workspace%shrink()
  end subroutine add_transformed

  subroutine add_damped(modes, ends, q, rate, monitor, response)
    !! Add damped modes.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: ends(2)               !! see `add_stable`
    real(dp), intent(in) :: q(:), rate(:)        !! displacements and velocities at t = 0, (modes)
    class(monitor_type), intent(inout), target :: monitor
    type(response_type), intent(inout) :: response
    type(part_monitor) :: part
    integer, allocatable :: k(:)
    integer :: first, last, n
    n = modes_at_once(size(response%sampling%points))
    do first = 1, ends(2), n
      last = min(first + n - 1, modes%count)
      k = numbers_between(max(first, ends(1)), min(last, ends(2)))
      if (size(k) == 0) cycle
      part = part_monitor(monitor, (first - 1.0_dp)/modes%count, (last - first + 1.0_dp)/modes%count)
      associate (shapes => values_at(modes, response%sampling%quantity, first, last, response%sampling%points))
        call add_damped_batch(k(1), damped_motion(modes%beta_squared(k), modes%damping(k), q(k), rate(k), &
                                                  shapes(k - first + 1, :)), part, response)
      end associate
      if (monitor%stop_requested()) return
    end do
  end subroutine add_damped

  subroutine add_damped_batch(first, motion, monitor, response)
    !! Add a batch of damped modes. The growing exponential A e^(st) of unstable ones is the motion of an undamped mode
    !! with β² = −s².
    integer, intent(in) :: first                 !! number of the first mode
    type(damped_motion), intent(in) :: motion
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response
    integer, allocatable :: k(:)
    type(dd), allocatable :: up(:)
    real(dp), allocatable :: down(:), growing(:), start(:), start_rate(:)
    associate (beta_squared => motion%beta_squared, c => motion%c, q => motion%q, rate => motion%q_dot, shapes => motion%shapes, &
               grid => response%sampling%grid)
      start = response%displacement(1, :) + matmul(q, shapes)
      if (allocated(response%velocity)) start_rate = response%velocity(1, :) + matmul(rate, shapes)
      call add_damped_modes(motion, grid, monitor, response%displacement, response%velocity)
      k = numbers_of(grows(beta_squared, c, grid%samples*grid%step%hi))
      if (size(k) > 0) then
        up = slow_exponent(beta_squared(k), c(k))
        down = fast_exponent(beta_squared(k), c(k))
        growing = (rate(k) - down*q(k))/(up%hi - down)
        call add_growing_batch(first - 1 + k, -(up*up), growing, growing*up%hi, shapes(k, :), monitor, response)
      end if
    end associate
    response%displacement(1, :) = start          ! exact: 0 for an undeflected beam
    if (allocated(response%velocity)) response%velocity(1, :) = start_rate
  end subroutine add_damped_batch

  subroutine add_growing(modes, ends, q, rate, monitor, response)
    !! Add modes at or beyond their critical speed.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: ends(2)               !! see `add_stable`
    real(dp), intent(in) :: q(:), rate(:)        !! displacements and velocities at t = 0, (modes)
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response
    real(dp), allocatable :: shapes(:, :)
    integer, allocatable :: k(:)
    k = ends(1) - 1 + numbers_of(modes%beta_squared(ends(1):ends(2))%hi <= 0.0_dp)
    if (size(k) == 0) return
    shapes = values_at(modes, response%sampling%quantity, k(1), k(size(k)), response%sampling%points)
    call add_growing_batch(k, modes%beta_squared(k), q(k), rate(k), shapes(k - k(1) + 1, :), monitor, response)
  end subroutine add_growing

  subroutine add_growing_batch(number, beta_squared, q, rate, shapes, monitor, response)
    !! Add growing modes up to the first sample at which their sum, or a velocity in m/s, overflows.
    integer, intent(in) :: number(:)             !! of the modes
    type(dd), intent(in) :: beta_squared(:)      !! none above 0
    real(dp), intent(in) :: q(:), rate(:), shapes(:, :)
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response
    real(dp), allocatable :: limits(:)           ! logarithms of the largest displacement and velocity
    integer, parameter :: block = 4096           ! samples
    integer :: first, k, finite, failing
    limits = [log_huge]
    if (allocated(response%velocity)) limits = [log_huge, log_huge + min(0.0_dp, log(response%sampling%unit_time))]
    call find_overflow(beta_squared, q, rate, shapes, response%sampling%grid, limits, finite, failing)
    if (finite < response%finite_samples) then
      response%finite_samples = finite
      response%failing_mode = number(failing)
    end if
    do first = 1, response%finite_samples, block
      do k = 1, size(q)
        if (monitor%stop_requested()) return
        call add_sample_by_sample(beta_squared(k), 0.0_dp, q(k), rate(k), shapes(k, :), response%sampling%grid, &
                                  [first, min(first + block - 1, response%finite_samples)], &
                                  response%displacement, response%velocity)
      end do
    end do
  end subroutine add_growing_batch

  pure integer function modes_at_once(points) result(modes)
    !! Return how many modes may have shapes in memory at a time.
    integer, intent(in) :: points                !! their number
    modes = max(batch, most_numbers/max(64, points))
  end function modes_at_once

  pure function numbers_between(first, last) result(k)
    !! Return first, first + 1, … last.
    integer, intent(in) :: first, last
    integer :: k(max(0, last - first + 1))
    integer :: i
    k = [(i, i=first, last)]
  end function numbers_between

  pure function numbers_of(chosen) result(k)
    !! Return the indices of true elements, ascending.
    logical, intent(in) :: chosen(:)
    integer, allocatable :: k(:)
    k = pack(numbers_between(1, size(chosen)), chosen)
  end function numbers_of

end module bw_set_sum
