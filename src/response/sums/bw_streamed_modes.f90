module bw_streamed_modes
  !! Histories of more modes than fit in memory: batch by batch they are solved, spread onto the grids of the transform
  !! and dropped, and the grids are transformed once.
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_mode_set, only: batch, deflections, mode_set, mode_source, take_terms
  use bw_monitor, only: monitor_type
  use bw_nonuniform_sum, only: nonuniform_sum, points_at_once
  use bw_response, only: histories_of, response_type, turns_in_record
  use bw_set_sum, only: add_motion, modes_at_once
  use bw_stopwatch, only: wall_seconds
  use bw_sum_choice, only: chosen_sum, error_of_sum, sum_choice
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: add_modes_of_source


contains

  subroutine add_modes_of_source(source, force, first, last, monitor, response, workspace)
    !! Add modes `first` … `last`, undeflected at the start, with velocities force·Φ_k(1)/M_k: by the transform if that
    !! is faster, except those with less than a cycle in the record and damped ones.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force                !! velocities are in m per l²/h, as in `add_motion`
    integer, intent(in) :: first, last
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response   !! started
    type(nonuniform_sum), intent(inout), optional :: workspace    !! of another motion, whose plans are reused
    type(nonuniform_sum) :: own
    type(sum_choice) :: choice
    integer :: samples, turning
    samples = response%sampling%grid%samples
    turning = last + 1
    if (.not. allocated(source%damping)) then
      choice = chosen_sum(last - first + 1, samples, histories_of(response))
      if (choice%transform) turning = first_turning(source, first, last, response%sampling%grid)
    end if
    call add_sets(source, force, first, turning - 1, monitor, response)
    if (turning > last) return
    if (monitor%stop_requested()) return
    if (present(workspace)) then
      call transform_source(source, force, turning, last, choice, monitor, workspace, response)
    else
      call transform_source(source, force, turning, last, choice, monitor, own, response)
    end if
    response%sum_error = response%sum_error + error_of_sum(choice, samples)
    response%transformed = response%transformed + (last - turning + 1)
  end subroutine add_modes_of_source

  integer function first_turning(source, first, last, grid) result(k)
    !! Return the first mode that completes a cycle in the record; `last` + 1 if none does.
    class(mode_source), intent(in) :: source
    integer, intent(in) :: first, last
    type(time_grid), intent(in) :: grid
    integer, parameter :: step = 16              ! one step suffices except in short records
    type(dd) :: beta(step)
    real(dp) :: drive(step), mass(step), shapes(step, 0)
    integer :: i, n, slow
    k = first
    do while (k <= last)
      n = min(step, last - k + 1)
      call source%terms([(i, i=k, k + n - 1)], [real(dp) ::], record_of(source, grid), beta(:n), drive(:n), shapes(:n, :), &
                        mass(:n))
      slow = count(.not. turns_in_record(beta(:n)%hi, grid))
      k = k + slow
      if (slow < n) return
    end do
  end function first_turning

  subroutine add_sets(source, force, first, last, monitor, response)
    !! Add modes in sets of bounded size.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    integer, intent(in) :: first, last
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response
    class(mode_set), allocatable :: modes
    real(dp) :: started
    integer :: at_once, i, k
    at_once = modes_at_once(size(response%sampling%points))
    do k = first, last, at_once
      started = wall_seconds()
      call source%find([(i, i=k, min(k + at_once - 1, last))], modes, record_of(source, response%sampling%grid))
      response%mode_seconds = response%mode_seconds + (wall_seconds() - started)
      call add_motion(modes, force*modes%struck/modes%modal_mass, monitor, response)
      if (monitor%stop_requested()) return
    end do
  end subroutine add_sets

  subroutine transform_source(source, force, first, last, choice, monitor, workspace, response)
    !! Add modes by the transform. If the grids of all points do not fit in memory, modes are solved again for every
    !! group of points.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    integer, intent(in) :: first, last
    type(sum_choice), intent(in) :: choice
    class(monitor_type), intent(inout) :: monitor
    type(nonuniform_sum), intent(inout) :: workspace
    type(response_type), intent(inout) :: response
    real(dp) :: drive(batch), started
    real(dp), allocatable :: shapes(:, :)
    type(dd) :: beta(batch)
    integer :: e, group, i, k, n, p
    logical :: with_velocity
    with_velocity = allocated(response%velocity)
    associate (points => response%sampling%points, grid => response%sampling%grid)
      group = points_at_once(choice%half, grid%samples, size(points), merge(2, 1, with_velocity))
      allocate (shapes(batch, group))
      do p = 1, size(points), group
        e = min(p + group - 1, size(points))
        call workspace%open(grid, choice%width, choice%half, e - p + 1, with_velocity, moved=.false.)
        do k = first, last, batch
          n = min(batch, last - k + 1)
          started = wall_seconds()
          call find_terms(source, response%sampling%quantity, [(i, i=k, k + n - 1)], points(p:e), record_of(source, grid), &
                          beta(:n), drive(:n), shapes(:n, :e - p + 1))
          response%mode_seconds = response%mode_seconds + (wall_seconds() - started)
          call workspace%add(beta(:n), force*drive(:n), shapes(:n, :e - p + 1))
          call monitor%advance((p - 1 + (e - p + 1)*real(k - first + n, dp)/(last - first + 1))/size(points))
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
  end subroutine transform_source

  subroutine find_terms(source, quantity, number, xi, longest, beta, drive, shapes)
    !! Find the terms of modes that the transform needs; for curvatures through a set.
    class(mode_source), intent(in) :: source
    integer, intent(in) :: quantity, number(:)
    real(dp), intent(in) :: xi(:), longest
    type(dd), intent(out) :: beta(:)
    real(dp), intent(out) :: drive(:), shapes(:, :)
    real(dp) :: mass(size(number))
    class(mode_set), allocatable :: modes
    if (quantity == deflections) then
      call source%terms(number, xi, longest, beta, drive, shapes, mass)
    else
      call source%find(number, modes, longest)
      call take_terms(modes, beta, drive)
      shapes = modes%some_curvatures(1, modes%count, xi)
    end if
  end subroutine find_terms

  pure real(dp) function record_of(source, grid) result(longest)
    !! Return the duration over which phases are accurate, l²/h.
    class(mode_source), intent(in) :: source
    type(time_grid), intent(in) :: grid
    longest = source%stretch*(grid%samples*grid%step%hi)
  end function record_of

end module bw_streamed_modes
