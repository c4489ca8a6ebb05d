module bw_case_errors
  !! Errors of the histories of a case. With a captured mass they are relative to the limit of infinitely many modes:
  !! omitted modes, and errors of summed ones. With contacts they are relative to the exact motion of the given modes:
  !! input errors, as amplified by contacts. Rounding of sums and phases is added to both.
  use bw_case_drift, only: drift_errors, rounding_errors
  use bw_case_notes, only: note_failure
  use bw_case_result, only: block_type, case_done, case_histories, case_motion, case_not_converged, history_errors
  use bw_double_double, only: dd, operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_lack_error, only: find_lack, lack_error
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: missing
  use bw_mode_set, only: curvatures, deflections, first_failure, mode_set, values_at
  use bw_mode_survey, only: mode_survey
  use bw_monitor, only: monitor_type
  use bw_plan, only: bound_times, looked_ahead
  use bw_response, only: response_type
  use bw_scene, only: scene_type
  use bw_segment, only: beam_energy, growth_error, move, segment_type
  use bw_segment_samples, only: samples_of_segment, stretch_of
  use bw_time_grid, only: time_grid, time_grid_of
  use bw_truncation_error, only: block_ends, displacement_error, falling_part, fewest, find_rates, find_tail, no_bound, &
    phase_agreement, rate_error, tail_type, crest_factor
  implicit none (type, external)
  private
  public :: drop_errors, estimate_errors, errors_of_quantity

  type :: segment_error
    !! Bound and estimate for the displacement, V l²/h; and for the velocity, V, or curvature, V l²/h, (points).
    real(dp), allocatable :: bound(:), displacement(:), rate(:)
    real(dp), allocatable :: part(:)       !! |sum of a block| over the sum of its amplitudes, (points)
  end type segment_error

contains

  subroutine estimate_errors(scene, motion, histories, monitor, errors)
    !! Estimate all errors. There are none for a rebound without contacts, whose impulse depends on the number of modes,
    !! nor after an overflow.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(case_histories), intent(in) :: histories
    class(monitor_type), intent(inout) :: monitor            !! the errors are invalid if it requests a stop
    type(history_errors), intent(out) :: errors
    errors%status = histories%status
    if (.not. allocated(histories%response) .or. histories%status /= case_done) return
    call errors_of_quantity(scene, motion, deflections, histories, monitor, errors)
    if (motion%ending /= case_done) errors%status = motion%ending
    if (monitor%stop_requested()) return
    if (motion%plan%peak > 0.0_dp .and. allocated(errors%displacement)) &
      errors%missed = is_missed(scene, motion, histories%response, errors)
  end subroutine estimate_errors

  subroutine errors_of_quantity(scene, motion, quantity, histories, monitor, errors)
    !! Estimate the errors of displacements and velocities, or of curvatures in the unit of displacements, m.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: quantity                          !! deflections or curvatures (bw_mode_set)
    type(case_histories), intent(in) :: histories            !! of this quantity
    class(monitor_type), intent(inout) :: monitor
    type(history_errors), intent(inout) :: errors
    if (size(motion%timeline%segments) == 0) return
    associate (first => motion%timeline%segments(1))
      if (allocated(scene%recontact)) then
        call estimate_contacts(scene, motion, quantity, histories%response, errors)
      else if (allocated(first%lack) .or. .not. allocated(first%rate)) then
        call estimate_truncation(scene, motion, quantity, histories, monitor, errors)
      end if
    end associate
  end subroutine errors_of_quantity

  subroutine estimate_truncation(scene, motion, quantity, histories, monitor, errors)
    !! Estimate truncation errors with rounding: the largest of all segments.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: quantity
    type(case_histories), intent(in) :: histories
    class(monitor_type), intent(inout) :: monitor
    type(history_errors), intent(inout) :: errors
    real(dp), dimension(size(scene%response%points)) :: bound, displacement, rate, rounding
    real(dp) :: part(size(scene%response%points), size(motion%timeline%segments))
    type(segment_error), allocatable :: found
    real(dp) :: speed
    integer :: i
    part = 0.0_dp
    bound = 0.0_dp
    displacement = 0.0_dp
    rate = 0.0_dp
    speed = abs(scene%impact%approach_velocity)
    do i = 1, size(motion%timeline%segments)
      call find_segment_error(scene, motion, i, quantity, histories%blocks(i), monitor, found)
      if (monitor%stop_requested()) return
      if (.not. allocated(found)) cycle
      if (maxval(found%displacement) > maxval(displacement)) errors%segment = i
      bound = max(bound, found%bound)
      displacement = max(displacement, found%displacement)
      part(:, i) = found%part
      rate = max(rate, found%rate)
    end do
    associate (unit => speed*motion%units%time%hi, response => histories%response)
      rounding = rounding_errors(scene, motion, response, .false.) + drift_errors(scene, motion, quantity, .false.)
      if (quantity == curvatures) then
        errors%bending_moment = rate*unit + rounding
        return
      end if
      errors%displacement = displacement*unit + rounding
      errors%part = part
      errors%displacement_bound = bound*unit + rounding
      where (bound >= no_bound) errors%displacement_bound = missing
      if (.not. allocated(response%velocity)) return
      errors%velocity = max(rate*speed, error_at_start(scene, response)) &
        + rounding_errors(scene, motion, response, .true.) + drift_errors(scene, motion, quantity, .true.)
    end associate
  end subroutine estimate_truncation

  pure function error_at_start(scene, response) result(error)
    !! Return the velocity error at the first sample. With infinitely many modes only the struck place moves then, (points).
    type(scene_type), intent(in) :: scene
    type(response_type), intent(in) :: response
    real(dp) :: error(size(scene%response%points)), jump
    jump = scene%impact%approach_velocity*(1.0_dp + scene%impact%restitution)
    error = abs(response%velocity(1, :) - merge(jump, 0.0_dp, scene%response%points == scene%impact%position))
  end function error_at_start

  subroutine find_segment_error(scene, motion, i, quantity, block, monitor, error)
    !! Estimate the errors of one segment, V l²/h and V; unallocated if no sample after its start shows it.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: i, quantity
    type(block_type), intent(in) :: block
    class(monitor_type), intent(inout) :: monitor
    type(segment_error), allocatable, intent(out) :: error
    type(mode_survey) :: survey
    type(tail_type) :: tail
    type(lack_error) :: lacking
    real(dp), dimension(size(scene%response%points)) :: part, times
    real(dp), dimension(size(scene%response%points), 2) :: rate, value
    real(dp) :: energy, speed
    integer :: samples
    associate (segment => motion%timeline%segments(i), moving => motion%modes%configuration(configuration_of(motion, i)))
      call take_survey(scene, motion, i, quantity, monitor, survey, samples)
      speed = abs(scene%impact%approach_velocity)
      if (monitor%stop_requested()) return
      if (samples == 0 .or. speed == 0.0_dp) return
      associate (source => moving%source)
        energy = segment%energy
        if (allocated(segment%rate)) then
          energy = energy_beside(segment, moving%set)
          call find_tail(survey, source%pieces%beam, source%damping, energy, segment%count, tail)
        else
          call find_tail(survey, source%pieces%beam, source%damping, energy, segment%count, tail, segment%force, &
                         source%struck_at)
        end if
      end associate
      value = block%value/(speed*motion%units%time%hi)
      rate = block%rate/speed
      if (quantity == curvatures) rate = value
      part = phase_agreement(survey, segment%count, samples, value)
      if (segment%count >= fewest) part = max(part, falling_part(tail, value))
      times = crest_factor(survey, segment%count, samples, rate)
      error = segment_error(tail%bound, displacement_error(tail, part), 0.0_dp*part, part)
      if (scene%response%velocity .or. quantity == curvatures) then
        call find_rates(survey, moving%source%pieces%beam, moving%source%damping, energy, tail)
        error%rate = rate_error(tail, times, rate)
      end if
      if (.not. allocated(segment%lack)) return
      call find_lack(segment%lack, moving%set, segment%count, survey, samples, part, times, lacking)
      error%bound = error%bound + lacking%bound
      error%displacement = min(error%bound, error%displacement + lacking%displacement)
      error%rate = error%rate + lacking%rate
    end associate
  end subroutine find_segment_error

  pure integer function configuration_of(motion, i)
    !! Return the configuration of a segment.
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: i
    configuration_of = motion%timeline%segments(i)%configuration
  end function configuration_of

  subroutine take_survey(scene, motion, i, quantity, monitor, survey, samples)
    !! Take the survey by which the modes of a segment were chosen, or survey them, and as many omitted ones if these
    !! have the same motion.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: i, quantity
    class(monitor_type), intent(inout) :: monitor
    type(mode_survey), intent(out) :: survey
    integer, intent(out) :: samples                !! in the segment after its start
    type(time_grid) :: grid
    real(dp), allocatable :: q(:)
    integer :: ends(2), n
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    ends = samples_of_segment(motion, i, grid)
    if (i == 1) ends(1) = 2                        ! nothing has moved at the first
    samples = max(0, ends(2) - ends(1) + 1)
    if (samples == 0) return
    if (quantity == deflections .and. allocated(motion%plan%survey)) then
      survey = motion%plan%survey(i)
      if (survey%bins > 0) return
    end if
    associate (segment => motion%timeline%segments(i), moving => motion%modes%configuration(configuration_of(motion, i)))
      n = segment%count
      call survey%start(quantity, scene%response%points, stretch_of(grid, ends(1), ends(2), segment%start), block_ends(n))
      if (allocated(segment%rate)) then
        q = 0.0_dp*segment%rate
        if (allocated(segment%q)) q = segment%q
        call survey%add_set(moving%set, 1, n, q, segment%rate)
      else
        call survey%add_source(moving%source, segment%force, n, monitor)
      end if
      if (segment%force == 0.0_dp) return          ! the motion of omitted modes is unknown
      if (n <= looked_ahead) call survey%add_source(moving%source, segment%force, 2*n, monitor)
      do while (survey%bin(survey%bins)%square <= 0.0_dp .and. survey%count() < moving%source%highest)
        if (monitor%stop_requested()) return
        call survey%add_source(moving%source, segment%force, survey%count() + 1, monitor)
      end do
    end associate
  end subroutine take_survey

  pure real(dp) function energy_beside(segment, modes) result(energy)
    !! Return the energy of omitted modes: that of all, less what summed modes should have and lack.
    type(segment_type), intent(in) :: segment
    class(mode_set), intent(in) :: modes
    real(dp), allocatable :: q(:), rate(:)
    energy = segment%energy
    if (.not. allocated(segment%lack)) return
    if (.not. allocated(segment%lack%rate)) return
    q = 0.0_dp*segment%rate
    if (allocated(segment%q)) q = segment%q
    rate = segment%rate
    energy = energy + beam_energy(modes, q, rate)
    rate = rate + segment%lack%rate
    if (allocated(segment%lack%q)) q = q + segment%lack%q
    energy = energy - beam_energy(modes, q, rate)
  end function energy_beside

  logical function is_missed(scene, motion, response, errors)
    !! Return whether the sum misses its tolerance by the estimate or by the bound, both beyond rounding.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    type(history_errors), intent(in) :: errors
    real(dp) :: allowed
    allowed = motion%plan%tolerance*largest_magnitude(response%displacement)
    is_missed = maxval(errors%displacement) > allowed + maxval(rounding_errors(scene, motion, response, .false.)) .or. &
      maxval(errors%displacement_bound) > bound_times*allowed
  end function is_missed

  subroutine estimate_contacts(scene, motion, quantity, response, errors)
    !! Estimate errors as contacts amplify them, with rounding.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: quantity
    type(response_type), intent(in) :: response
    type(history_errors), intent(inout) :: errors
    type(time_grid) :: grid
    real(dp) :: largest(size(scene%response%points), 2)    ! of displacements, V l²/h, and velocities, V
    real(dp) :: rounding, speed
    integer :: i, n, samples(2)
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    largest = 0.0_dp
    do i = 1, size(motion%timeline%segments)
      associate (segment => motion%timeline%segments(i))
        if (.not. allocated(segment%error)) cycle
        samples = samples_of_segment(motion, i, grid)
        if (samples(1) <= samples(2)) largest = max(largest, matmul(transpose(abs(shapes_in(motion, i, quantity, &
                                                                         scene%response%points))), segment%error))
        if (i == 1) cycle
        if (is_blurred(segment, grid)) largest(:, 2) = max(largest(:, 2), jump_at(motion, i, scene%response%points))
      end associate
    end do
    speed = abs(scene%impact%approach_velocity)
    n = response%finite_samples
    rounding = response%sum_error
    do i = 1, size(motion%modes%configuration)
      rounding = rounding + growth_error(motion%modes%configuration(i)%set, grid%samples*grid%step%hi)
    end do
    associate (error => largest(:, 1)*(speed*motion%units%time%hi) + rounding*largest_magnitude(response%displacement(:n, :)))
      if (quantity == curvatures) then
        errors%bending_moment = error
      else
        errors%displacement = error
      end if
    end associate
    if (allocated(response%velocity)) then
      errors%velocity = largest(:, 2)*speed + rounding*largest_magnitude(response%velocity(:n, :))
    end if
  end subroutine estimate_contacts

  pure function shapes_in(motion, i, quantity, points) result(values)
    !! Return the shapes of the modes that move in a segment, (modes, points).
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: i, quantity
    real(dp), intent(in) :: points(:)
    real(dp), allocatable :: values(:, :)
    associate (modes => motion%modes%configuration(configuration_of(motion, i))%set)
      values = values_at(modes, quantity, 1, modes%count, points)
    end associate
  end function shapes_in

  pure logical function is_blurred(segment, grid)
    !! Return whether a sample is so close to the contact at a segment's start that it may belong to the other side.
    type(segment_type), intent(in) :: segment
    type(time_grid), intent(in) :: grid
    type(dd) :: distance
    distance = segment%start - grid%step*anint(segment%start%hi/grid%step%hi)
    is_blurred = abs(distance%hi) <= segment%start_error
  end function is_blurred

  pure function jump_at(motion, i, points) result(jump)
    !! Return the jump of the velocity at the start of segment i > 1, V, (points).
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: i
    real(dp), intent(in) :: points(:)
    real(dp) :: jump(size(points))
    real(dp), allocatable :: q(:), rate(:)
    associate (before => motion%timeline%segments(i - 1), after => motion%timeline%segments(i))
      q = before%q
      rate = before%rate
      call move(motion%modes%configuration(before%configuration)%set, after%start - before%start, q, rate)
      jump = matmul(rate, shapes_in(motion, i - 1, deflections, points))
      jump = abs(matmul(after%rate, shapes_in(motion, i, deflections, points)) - jump)
    end associate
  end function jump_at

  subroutine drop_errors(motion, errors)
    !! Drop the estimates if a mode that they need was not found.
    type(case_motion), intent(in) :: motion
    type(history_errors), intent(inout) :: errors          !! of the whole case
    associate (failure => first_failure(motion%modes%configuration))
      if (failure%first == 0 .or. errors%status /= case_done) return
      errors = history_errors(status=case_not_converged)
      call note_failure(failure, 'the errors of the histories are missing', errors%notes)
    end associate
  end subroutine drop_errors

end module bw_case_errors
