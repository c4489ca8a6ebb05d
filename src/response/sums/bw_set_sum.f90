module bw_set_sum
  !! Histories of modes of one set whose shapes are not all held at a time.
  use bw_kinds, only: dp
  use bw_double_double, only: sqrt
  use bw_modal_sum, only: add_stable_modes
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, part_monitor
  use bw_nonuniform_sum, only: nonuniform_sum, points_at_once
  use bw_sum_choice, only: sum_choice
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: add_products, add_transformed, modes_at_once, numbers_between, numbers_of, state_of

  integer, parameter :: batch = 256            !! tuned: modes whose arrays stay in the cache
  integer, parameter :: most_numbers = 2**22   !! shapes held at a time

contains

  subroutine add_products(modes, chosen, displaced, rate, points, grid, monitor, displacement, velocity)
    !! Some of the modes, by products of matrices; of many no more at a time than whose shapes may be held.
    class(mode_set), intent(in) :: modes
    logical, intent(in) :: chosen(:)             !! (modes)
    real(dp), intent(in), optional :: displaced(:)
    real(dp), intent(in) :: rate(:), points(:)
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout), target :: monitor
    real(dp), intent(inout), contiguous :: displacement(:, :)   !! (samples, points)
    real(dp), intent(inout), optional, contiguous :: velocity(:, :)
    type(part_monitor) :: part
    integer, allocatable :: k(:)
    integer :: first, last, n
    n = modes_at_once(size(points))
    do first = 1, modes%count, n
      last = min(first + n - 1, modes%count)
      k = numbers_of(chosen(first:last)) + (first - 1)
      if (size(k) == 0) cycle
      part = part_monitor(monitor, (first - 1.0_dp)/modes%count, (last - first + 1.0_dp)/modes%count)
      associate (shapes => modes%some_shapes(k(1), k(size(k)), points))
        call add_stable_modes(modes%beta_squared(k), state_of(k, displaced), rate(k), shapes(k - k(1) + 1, :), grid, part, &
                              displacement, velocity)
      end associate
      if (monitor%stop_requested()) return
    end do
  end subroutine add_products

  subroutine add_transformed(modes, chosen, choice, displaced, rate, points, grid, monitor, sum, displacement, &
                             velocity)
    !! Some of the modes, by the transform; shapes are found for some modes and points at a time.
    class(mode_set), intent(in) :: modes
    logical, intent(in) :: chosen(:)             !! (modes)
    type(sum_choice), intent(in) :: choice
    real(dp), intent(in), optional :: displaced(:)
    real(dp), intent(in) :: rate(:), points(:)
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    type(nonuniform_sum), intent(inout) :: sum
    real(dp), intent(inout), contiguous :: displacement(:, :)   !! (samples, points)
    real(dp), intent(inout), optional, contiguous :: velocity(:, :)
    real(dp), allocatable :: shapes(:, :)
    integer, allocatable :: k(:)
    integer :: e, first, last, p, group
    logical :: moved
    moved = .false.
    if (present(displaced)) moved = any(displaced /= 0.0_dp)
    group = points_at_once(choice%half, grid%samples, size(points), merge(2, 1, present(velocity))*merge(2, 1, moved))
    allocate (shapes(batch, group))
    do p = 1, size(points), group
      e = min(p + group - 1, size(points))
      call sum%open(grid, choice%width, choice%half, e - p + 1, present(velocity), moved)
      do first = 1, modes%count, batch
        last = min(first + batch - 1, modes%count)
        k = numbers_of(chosen(first:last)) + (first - 1)
        if (size(k) == 0) cycle
        shapes(:k(size(k)) - k(1) + 1, :e - p + 1) = modes%some_shapes(k(1), k(size(k)), points(p:e))
        if (moved) then
          call sum%add(sqrt(modes%beta_squared(k)), rate(k), shapes(k - k(1) + 1, :e - p + 1), displaced(k))
        else
          call sum%add(sqrt(modes%beta_squared(k)), rate(k), shapes(k - k(1) + 1, :e - p + 1))
        end if
        call monitor%advance((p - 1 + (e - p + 1)*(real(last, dp)/modes%count))/size(points))
        if (monitor%stop_requested()) return
      end do
      if (present(velocity)) then
        call sum%close(displacement(:, p:e), velocity(:, p:e), monitor)
      else
        call sum%close(displacement(:, p:e), monitor=monitor)
      end if
    end do
    call sum%shrink()
  end subroutine add_transformed

  pure integer function modes_at_once(points) result(modes)
    !! A bound of the memory that shapes take.
    integer, intent(in) :: points                !! how many
    modes = max(batch, most_numbers/max(64, points))
  end function modes_at_once

  pure function state_of(k, displaced) result(q)
    !! Modal displacements of some modes at t = 0.
    integer, intent(in) :: k(:)
    real(dp), intent(in), optional :: displaced(:)   !! of all; absent: none are displaced
    real(dp) :: q(size(k))
    q = 0.0_dp
    if (present(displaced)) q = displaced(k)
  end function state_of

  pure function numbers_between(first, last) result(k)
    !! first, first + 1, … last.
    integer, intent(in) :: first, last
    integer :: k(last - first + 1)
    integer :: i
    k = [(i, i=first, last)]
  end function numbers_between

  pure function numbers_of(chosen) result(k)
    !! The places of what is true, ascending.
    logical, intent(in) :: chosen(:)
    integer, allocatable :: k(:)
    k = pack(numbers_between(1, size(chosen)), chosen)
  end function numbers_of

end module bw_set_sum
