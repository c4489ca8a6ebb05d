module bw_loaded_sum
  !! Histories of modes that a force drives, step by step: exact between all samples, with what modes that are not summed add at once.
  use bw_double_double, only: dd, to_dd, operator(*), operator(-)
  use bw_force_response, only: force_degree
  use bw_force_step, only: part_values, polynomial_of, step_end, step_end_of
  use bw_kinds, only: dp
  use bw_mode_set, only: curvatures, mode_set, values_at
  use bw_monitor, only: monitor_type
  use bw_oscillators, only: oscillators, oscillators_of
  use bw_response, only: response_type
  use bw_segment, only: segment_type
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: add_loaded_motion

contains

  subroutine add_loaded_motion(modes, segment, grid, first, unit, monitor, response)
    !! Add the motion of a segment with a load. Velocities are in m per unit of the grid's time until the histories are finished.
    class(mode_set), intent(in) :: modes
    type(segment_type), intent(in) :: segment        !! with a load, whose residual is that of the points
    type(time_grid), intent(in) :: grid              !! of the whole record
    integer, intent(in) :: first                     !! sample of it that is the first of the histories, from 1
    real(dp), intent(in) :: unit                     !! m of displacements in V l²/h
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response   !! started, of the samples of the segment
    type(step_end), allocatable :: known(:)
    type(step_end) :: there
    type(oscillators) :: parts
    type(dd) :: after
    real(dp) :: start, length, left, force(0:force_degree), a(modes%count), c(modes%count)
    real(dp), dimension(modes%count) :: u, v, u_there, v_there
    real(dp), allocatable :: shapes(:, :)
    integer :: i, sample, samples
    samples = response%sampling%grid%samples
    a = modes%struck
    a(segment%load%taking_part + 1:) = 0.0_dp
    c = 0.0_dp
    if (allocated(modes%damping)) c = modes%damping
    parts = oscillators_of(modes%beta_squared, c)
    shapes = values_at(modes, response%sampling%quantity, 1, modes%count, response%sampling%points)
    allocate (known(0))
    u = segment%q
    v = segment%rate
    start = 0.0_dp
    sample = 1
    associate (load => segment%load)
      do i = 1, size(load%length)
        length = load%length(i)
        do while (sample <= samples)
          after = grid%step*real(first + sample - 2, dp) - segment%start
          left = (after%hi - start) + after%lo
          if (left > length .and. i < size(load%length)) exit
          if (monitor%stop_requested()) return
          u_there = u
          v_there = v
          force = load%force(:, i)
          if (left > 0.0_dp) then
            there = step_end_of(parts, a, modes%modal_mass, left)
            if (left <= length) force = part_values(force, left/length)
            if (left > length) force = 0.0_dp        ! by rounding, or in the last sample of a record
            call there%advance(force, u_there, v_there)
          else
            force = part_values(force, 0.0_dp)
          end if
          call put_sample(left/length)
          sample = sample + 1
        end do
        if (sample > samples) exit
        call move_on()
        start = start + length
      end do
    end associate
  contains
    subroutine put_sample(x)
      !! The histories at a sample, at a part of the step.
      real(dp), intent(in) :: x
      real(dp) :: coefficients(0:force_degree), rate
      integer :: column, j
      column = merge(2, 1, response%sampling%quantity == curvatures)
      coefficients = polynomial_of(segment%load%force(:, i))
      associate (residual => segment%load%residual(:, column))
        response%displacement(sample, :) = unit*(matmul(u_there, shapes) + residual*force(force_degree))
        if (.not. allocated(response%velocity)) return
        rate = sum([(j*coefficients(j)*x**(j - 1), j=1, force_degree)])/length
        if (x > 1.0_dp) rate = 0.0_dp
        response%velocity(sample, :) = unit*(matmul(v_there, shapes) + residual*rate)
      end associate
    end subroutine put_sample

    subroutine move_on()
      !! To the end of the step; steps of one length share their operators.
      integer :: k
      do k = 1, size(known)
        if (known(k)%length == length) exit
      end do
      if (k > size(known)) known = [known, step_end_of(parts, a, modes%modal_mass, length)]
      call known(k)%advance(segment%load%force(:, i), u, v)
    end subroutine move_on
  end subroutine add_loaded_motion

end module bw_loaded_sum
