module bw_loaded_sum
  !! Histories of modes under a contact force, exact in each step, with the quasi-static contribution of omitted modes.
  use bw_double_double, only: dd, operator(*), operator(-)
  use bw_force_step, only: advance_state, force_in_step, polynomial_of, step_end
  use bw_kinds, only: dp
  use bw_mode_set, only: curvatures, damping_rates, deflections, mode_set, turns, values_at
  use bw_monitor, only: monitor_type
  use bw_oscillators, only: oscillators, oscillators_of
  use bw_response, only: sampling_type
  use bw_segment, only: segment_type
  implicit none (type, external)
  private
  public :: find_loaded_motion

contains

  subroutine find_loaded_motion(modes, ladder, sampling, samples, curved, monitor, segment)
    !! Find all histories of a segment with a load together, as computing the state costs more than the sums.
    class(mode_set), intent(in) :: modes
    type(step_end), intent(in) :: ladder(0:)         !! step operators of its load, by level
    type(sampling_type), intent(in) :: sampling      !! of the whole record
    integer, intent(in) :: samples(2)                !! first and last of the segment, from 1
    logical, intent(in) :: curved                    !! with curvatures
    class(monitor_type), intent(inout) :: monitor    !! results are invalid if it requests a stop
    type(segment_type), intent(inout) :: segment     !! with a load, whose residual is that of the points
    type(oscillators) :: parts
    type(dd) :: after
    real(dp) :: start, length, left, force, slope, a(modes%count)
    real(dp), dimension(modes%count) :: u, v, u_there, v_there
    real(dp), dimension(modes%count, size(sampling%points)) :: shapes, bends
    real(dp) :: turned(modes%count)                  ! rotation of a free hub
    integer :: i, sample
    a = modes%struck
    a(segment%load%taking_part + 1:) = 0.0_dp
    parts = oscillators_of(modes%beta_squared, damping_rates(modes))
    shapes = values_at(modes, deflections, 1, modes%count, sampling%points)
    if (curved) bends = values_at(modes, curvatures, 1, modes%count, sampling%points)
    turned = modes%hub_turns()
    u = segment%q
    v = segment%rate
    start = 0.0_dp
    sample = samples(1)
    associate (load => segment%load)
      allocate (load%displacement(samples(2) - samples(1) + 1, size(sampling%points)))
      if (sampling%velocity) allocate (load%velocity, mold=load%displacement)
      if (curved) allocate (load%curvature, mold=load%displacement)
      if (any(turned /= 0.0_dp)) allocate (load%hub_turn(samples(2) - samples(1) + 1))
      do i = 1, size(load%length)
        length = load%length(i)
        do while (sample <= samples(2))
          after = sampling%grid%step*real(sample - 1, dp) - segment%start
          left = (after%hi - start) + after%lo
          if (left > length .and. i < size(load%length)) exit
          if (monitor%stop_requested()) return
          u_there = u
          v_there = v
          force = 0.0_dp                           ! after the contact, by rounding, or in the last sample of a record
          slope = 0.0_dp
          if (left <= length) call force_in_step(polynomial_of(load%force(:, i)), max(0.0_dp, left/length), force, slope)
          if (left > 0.0_dp) call advance_state(parts, a, modes%modal_mass, length, min(1.0_dp, left/length), load%force(:, i), &
                                    u_there, v_there)
          call put_sample(sample - samples(1) + 1)
          sample = sample + 1
        end do
        if (sample > samples(2)) exit
        call ladder(load%level(i))%advance(load%force(:, i), u, v)
        start = start + length
      end do
    end associate
  contains
    subroutine put_sample(row)
      integer, intent(in) :: row
      associate (load => segment%load)
        load%displacement(row, :) = matmul(u_there, shapes) + load%residual(:, deflections)*force
        if (sampling%velocity) load%velocity(row, :) = matmul(v_there, shapes) + load%residual(:, deflections)*(slope/length)
        if (curved) load%curvature(row, :) = matmul(u_there, bends) + load%residual(:, curvatures)*force
        if (allocated(load%hub_turn)) load%hub_turn(row) = dot_product(u_there, turned) + load%residual(1, turns)*force
      end associate
    end subroutine put_sample
  end subroutine find_loaded_motion

end module bw_loaded_sum
