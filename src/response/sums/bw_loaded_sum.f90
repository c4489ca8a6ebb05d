module bw_loaded_sum
  !! Histories of modes that a force drives, step by step: exact between all samples, with what modes that are not summed add at once.
  use bw_double_double, only: dd, operator(*), operator(-)
  use bw_force_step, only: drive, force_in_step, polynomial_of, step_end
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

  subroutine add_loaded_motion(modes, segment, ladder, grid, first, unit, monitor, response)
    !! Add the motion of a segment with a load. Velocities are in m per unit of the grid's time until the histories are finished.
    class(mode_set), intent(in) :: modes
    type(segment_type), intent(in) :: segment        !! with a load, whose residual is that of the points
    type(step_end), intent(in) :: ladder(0:)         !! of the steps of its load, by their level
    type(time_grid), intent(in) :: grid              !! of the whole record
    integer, intent(in) :: first                     !! sample of it that is the first of the histories, from 1
    real(dp), intent(in) :: unit                     !! m of displacements in V l²/h
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(inout) :: response   !! started, of the samples of the segment
    type(oscillators) :: parts
    type(dd) :: after
    real(dp) :: start, length, left, force, slope, a(modes%count), c(modes%count)
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
          force = 0.0_dp                           ! beyond, by rounding, or in the last sample of a record
          slope = 0.0_dp
          if (left <= length) call force_in_step(polynomial_of(load%force(:, i)), max(0.0_dp, left/length), force, slope)
          if (left > 0.0_dp) call drive(parts, a, modes%modal_mass, length, min(1.0_dp, left/length), load%force(:, i), &
                                    u_there, v_there)
          call put_sample()
          sample = sample + 1
        end do
        if (sample > samples) exit
        call ladder(load%level(i))%advance(load%force(:, i), u, v)
        start = start + length
      end do
    end associate
  contains
    subroutine put_sample()
      !! The histories at a sample.
      integer :: column
      column = merge(2, 1, response%sampling%quantity == curvatures)
      associate (residual => segment%load%residual(:, column))
        response%displacement(sample, :) = unit*(matmul(u_there, shapes) + residual*force)
        if (allocated(response%velocity)) response%velocity(sample, :) = unit*(matmul(v_there, shapes) + residual*(slope/length))
      end associate
    end subroutine put_sample
  end subroutine add_loaded_motion

end module bw_loaded_sum
