module bw_case_histories
  !! The histories of a case, from the state after each event to the next: of the modes that a scene counts, or of as many
  !! as its tolerance takes. A sample at exactly the time of an event belongs to what comes after it.
  use bw_beam_units, only: beam_units
  use bw_case_notes, only: note_failure, out_of_reach
  use bw_case_plan, only: captured_samples, force_of
  use bw_case_result, only: case_diverged, case_histories, case_motion, case_not_converged
  use bw_double_double, only: operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_response, only: fill_unknown, finish_histories, response_type, sampling_type, start_histories, sum_tolerance
  use bw_scene, only: scene_type
  use bw_segment, only: beam_in_contact, leaves_range, loaded_beam, move, segment_type
  use bw_set_sum, only: add_motion, free_motion
  use bw_streamed_modes, only: add_modes_of_source
  use bw_text, only: append, shortest, text_of
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: last_sample, sum_histories

contains

  subroutine sum_histories(scene, motion, monitor, workspace, histories, first)
    !! Fill where the modes mean nothing, or one was not found, or the tolerance is out of reach, and from the first overflow on.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(monitor_type), intent(inout) :: monitor        !! the histories mean nothing where it asks to stop
    type(nonuniform_sum), intent(inout) :: workspace     !! any, also one that another case has used
    type(case_histories), intent(out) :: histories
    integer, intent(in), optional :: first               !! mode, from which on they are summed, else from 1
    type(time_grid) :: grid
    integer :: from
    from = 1
    if (present(first)) from = first
    if (.not. motion%modes%resolved) histories%status = case_not_converged
    if (.not. allocated(scene%response)) return
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    allocate (histories%response)
    if (.not. motion%modes%resolved) then
      call fill_histories(sampling_of(scene, motion%units, grid), histories%response)
    else if (by_tolerance(scene%modes) .and. motion%plan%reached > scene%modes%tolerance) then
      histories%status = case_not_converged
      call append(histories%notes, 'tolerance: '//out_of_reach(scene, motion%sources, motion%plan)//'; no histories are given')
      call fill_histories(sampling_of(scene, motion%units, grid), histories%response)
    else if (by_tolerance(scene%modes)) then
      call sum_to_tolerance(scene, motion, grid, from, monitor, workspace, histories%response)
    else if (allocated(motion%later%segments)) then
      call sum_segments(scene, motion, grid, from, monitor, histories%response)
    else if (allocated(motion%modes%loaded)) then
      call sum_whole(motion%modes%loaded)
    else
      call sum_whole(motion%modes%free)
    end if
    if (histories%response%failing_mode > 0) call note_overflow(scene, histories)
    associate (failure => motion%sources%failure())
      if (failure%first == 0 .or. histories%status == case_not_converged) return
      histories%status = case_not_converged
      call note_failure(failure, 'no histories are given', histories%notes)
      call fill_histories(sampling_of(scene, motion%units, grid), histories%response)
    end associate
  contains
    subroutine sum_whole(modes)
      class(mode_set), intent(in) :: modes
      call free_motion(modes, without_first(from - 1, motion%initial%modal_velocity)*scene%impact%approach_velocity, &
                       sampling_of(scene, motion%units, grid), monitor, histories%response, workspace)
    end subroutine sum_whole
  end subroutine sum_histories

  pure function without_first(count, values) result(others)
    !! Of values of modes, in their order, zeros in the place of the first.
    integer, intent(in) :: count
    real(dp), intent(in) :: values(:)
    real(dp) :: others(size(values))
    others = values
    others(:min(count, size(values))) = 0.0_dp
  end function without_first

  pure type(sampling_type) function sampling_of(scene, units, grid) result(sampling)
    !! What the scene asks for, of all samples or of some.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(time_grid), intent(in) :: grid
    sampling = sampling_type(scene%response%points, grid, units%time%hi, scene%response%velocity)
  end function sampling_of

  subroutine fill_histories(sampling, response)
    !! No sample is known.
    type(sampling_type), intent(in) :: sampling
    type(response_type), intent(out) :: response
    call start_histories(sampling, response)
    response%finite_samples = 0
    call fill_unknown(response)
  end subroutine fill_histories

  subroutine note_overflow(scene, histories)
    type(scene_type), intent(in) :: scene
    type(case_histories), intent(inout) :: histories
    histories%status = case_diverged
    call append(histories%notes, 'overflow: mode '//text_of(histories%response%failing_mode)//' overflows at t = '// &
      shortest(histories%response%finite_samples*(scene%response%duration/scene%response%samples), 6)// &
      ' s; the histories hold fill from there on')
  end subroutine note_overflow

  subroutine sum_to_tolerance(scene, motion, grid, from, monitor, workspace, response)
    !! As many modes as the plan says; where the mass leaves, the captured motion up to the last sample before that, then the
    !! motion of the beam alone.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: from                  !! the first mode that is summed
    class(monitor_type), intent(inout), target :: monitor
    type(nonuniform_sum), intent(inout) :: workspace
    type(response_type), intent(out) :: response
    type(response_type) :: captured
    type(part_monitor) :: part
    type(time_grid) :: early
    if (.not. allocated(motion%plan%release)) then
      call sum_captured(scene, motion, grid, from, monitor, workspace, response)
      return
    end if
    early = time_grid(captured_samples(motion%plan, grid), grid%step)
    call start_histories(sampling_of(scene, motion%units, grid), response)
    part = part_monitor(monitor, 0.0_dp, real(early%samples, dp)/grid%samples)
    call sum_captured(scene, motion, early, from, part, workspace, captured)
    if (monitor%stop_requested()) return
    call copy_samples(captured, 1, early%samples, response)
    response%sum_error = max(sum_tolerance, captured%sum_error)
    response%mode_seconds = captured%mode_seconds
    response%transformed = captured%transformed
    call add_segment(scene, motion%units, motion%later%segments(2), motion%later%released, grid%samples, from, monitor, response)
    call fill_unknown(response)
  end subroutine sum_to_tolerance

  subroutine sum_captured(scene, motion, grid, from, monitor, workspace, response)
    !! Modes of beam and mass that start from rest position.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: from                  !! the first mode that is summed
    class(monitor_type), intent(inout) :: monitor
    type(nonuniform_sum), intent(inout) :: workspace
    type(response_type), intent(out) :: response
    call start_histories(sampling_of(scene, motion%units, grid), response)
    call add_modes_of_source(motion%sources%loaded, force_of(scene)*(scene%impact%approach_velocity*motion%units%time%hi), &
                             from, motion%plan%count, sum_tolerance, monitor, response, workspace)
    call finish_histories(response)
  end subroutine sum_captured

  subroutine sum_segments(scene, motion, grid, from, monitor, response)
    !! All segments in order, up to where contacts leave nothing that is known; leaves early if the monitor asks for it.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: from                  !! the first mode that is summed
    class(monitor_type), intent(inout) :: monitor
    type(response_type), intent(out) :: response
    integer :: i, last
    call start_histories(sampling_of(scene, motion%units, grid), response)
    response%finite_samples = samples_before(motion%later%known_until, grid)
    do i = 1, size(motion%later%segments)
      last = min(last_sample(motion%later%segments, i, grid), response%finite_samples)
      associate (segment => motion%later%segments(i))
        select case (segment%modes)
        case (loaded_beam)
          call add_segment(scene, motion%units, segment, motion%modes%loaded, last, from, monitor, response)
        case (beam_in_contact)
          call add_segment(scene, motion%units, segment, motion%later%in_contact, last, from, monitor, response)
        case default
          call add_segment(scene, motion%units, segment, motion%modes%free, last, from, monitor, response)
        end select
      end associate
      if (monitor%stop_requested()) return
    end do
    call fill_unknown(response)
    if (allocated(scene%release)) response%sum_error = sum_tolerance
  end subroutine sum_segments

  pure integer function samples_before(time, grid) result(samples)
    !! How many of the samples come before a time.
    real(dp), intent(in) :: time                  !! l²/h
    type(time_grid), intent(in) :: grid
    samples = grid%samples
    if (time >= samples*grid%step%hi) return
    samples = int(max(0.0_dp, time)/grid%step%hi) + 1
    if ((samples - 1)*grid%step%hi >= time) samples = samples - 1
  end function samples_before

  pure integer function last_sample(segments, i, grid) result(last)
    !! Of a segment, from 1: before the first of the next.
    type(segment_type), intent(in) :: segments(:)
    integer, intent(in) :: i
    type(time_grid), intent(in) :: grid
    last = grid%samples
    if (i < size(segments)) last = first_sample(segments(i + 1)%start, grid) - 1
  end function last_sample

  subroutine add_segment(scene, units, segment, modes, last, from, monitor, response)
    !! From the first sample of a segment to its last: summed from its own state at the first.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(segment_type), intent(in) :: segment
    class(mode_set), intent(in) :: modes          !! that move in it
    integer, intent(in) :: last                   !! sample, from 1
    integer, intent(in) :: from                   !! the first mode that is summed
    class(monitor_type), intent(inout), target :: monitor
    type(response_type), intent(inout) :: response    !! of the whole record, started
    type(time_grid) :: grid, own
    type(response_type) :: part
    type(part_monitor) :: share
    real(dp) :: q(modes%count), rate(modes%count), unit
    integer :: first
    grid = time_grid_of(scene%response%duration, scene%response%samples, units%time)
    first = first_sample(segment%start, grid)
    if (first > last .or. response%failing_mode > 0) return
    q = without_first(from - 1, segment%q)
    rate = without_first(from - 1, segment%rate)
    if (leaves_range(modes, grid%step*real(first - 1, dp) - segment%start)) then
      response%failing_mode = 1
      response%finite_samples = first - 1
      return
    end if
    call move(modes, grid%step*real(first - 1, dp) - segment%start, q, rate)
    share = part_monitor(monitor, real(first - 1, dp)/grid%samples, real(last - first + 1, dp)/grid%samples)
    own = time_grid(last - first + 1, grid%step)
    call start_histories(sampling_of(scene, units, own), part)
    unit = scene%impact%approach_velocity*units%time%hi
    call add_motion(modes, rate*unit, share, part, displaced=q*unit)
    response%sum_error = max(response%sum_error, part%sum_error)
    call finish_histories(part)
    call copy_samples(part, first, last, response)
  end subroutine add_segment

  pure subroutine copy_samples(part, first, last, whole)
    !! Histories of some of the samples into those of all.
    type(response_type), intent(in) :: part
    integer, intent(in) :: first, last
    type(response_type), intent(inout) :: whole
    whole%displacement(first:last, :) = part%displacement
    if (allocated(whole%velocity)) whole%velocity(first:last, :) = part%velocity
    if (part%failing_mode == 0) return
    whole%failing_mode = part%failing_mode
    whole%finite_samples = first - 1 + part%finite_samples
  end subroutine copy_samples

end module bw_case_histories
