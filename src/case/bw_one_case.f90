module bw_one_case
  !! One case from scene to result. Records are left to bw_record_case, lasting impacts to bw_contact_case and beams
  !! that change in time to bw_changing_case. All others go modes ► plan ► initial state ► events ► histories ► errors ►
  !! spectrum; each stage takes the values of those before it and returns its own.
  use bw_amplitude_spectrum, only: spectrum_plan
  use bw_beam_units, only: units_of
  use bw_case_errors, only: drop_errors
  use bw_case_frequency, only: find_frequency_response
  use bw_case_histories, only: add_hub_angle
  use bw_case_loads, only: add_loads, without_tolerance
  use bw_case_modes, only: find_modes
  use bw_case_moments, only: find_moments
  use bw_case_notes, only: note_relaxed
  use bw_case_octave, only: drop_unresolved
  use bw_case_result, only: add_notes, case_histories, case_motion, case_result, case_spectrum, history_errors, load_result, &
    put_together
  use bw_case_cost, only: answer_share, case_shares, events_share, histories_share, modes_share, spectrum_share, stage_part
  use bw_case_spectrum, only: find_spectrum
  use bw_case_validity, only: note_validity
  use bw_changing_case, only: run_changing_case
  use bw_contact_case, only: run_contact_case
  use bw_history_notes, only: note_history_errors
  use bw_kept_tolerance, only: find_histories, find_motion, motion_cache
  use bw_kinds, only: dp
  use bw_modal_model, only: find_modal_model
  use bw_mode_set, only: observe_searches, search_failure
  use bw_missing, only: is_missing
  use bw_modes_par, only: relaxed_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_note, only: remark
  use bw_record_case, only: record_cache, run_record_case
  use bw_result_layout, only: result_layout
  use bw_scene, only: changes_in_time, is_loaded, scene_type
  use bw_segment, only: alone
  use bw_stopwatch, only: stage_events, stage_modes, stage_response, stage_spectrum, stopwatch
  use bw_text, only: shortest, string
  implicit none (type, external)
  private
  public :: run_case

  type, public :: case_cache
    !! Work shared by the cases of a sweep, which the caller passes to each. Its memory is bounded, and results are the
    !! same to the bit without it.
    type(motion_cache) :: motion
    type(spectrum_plan) :: spectrum      !! window and plan of the last spectrum
    type(record_cache) :: record         !! the last record
  end type case_cache

contains

  subroutine run_case(scene, layout, watch, monitor, cache, result, completed, planned)
    !! Run a case, measured or simulated. A default tolerance that is out of reach is relaxed.
    type(scene_type), intent(in) :: scene            !! without sweeps
    type(result_layout), intent(in) :: layout
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor
    type(case_cache), intent(inout), target :: cache !! filled by other cases
    type(case_result), intent(out) :: result
    logical, intent(out) :: completed                    !! false if the monitor requested a stop before the end
    type(case_motion), allocatable, intent(inout), optional :: planned
      !! its motion up to the histories (bw_case_tolerance), used up; unallocated: not planned yet
    type(scene_type) :: relaxed
    if (allocated(scene%record)) then
      call run_record_case(scene, layout, watch, monitor, cache%record, result, completed)
    else if (allocated(scene%contact)) then
      call run_contact_case(scene, layout, watch, monitor, cache%motion%modes, cache%spectrum, result, completed)
    else if (changes_in_time(scene)) then
      call run_changing_case(scene, layout, watch, monitor, cache%motion%modes, cache%spectrum, result, completed)
    else
      if (is_loaded(scene)) then
        call simulate_case(without_tolerance(scene), layout, watch, monitor, cache, result, completed, planned, scene)
      else
        call simulate_case(scene, layout, watch, monitor, cache, result, completed, planned)
      end if
      if (allocated(result%error)) return
      relaxed = scene
      do while (completed .and. .not. (scene%modes%asked .or. result%within))
        relaxed%modes%tolerance = relaxed_tolerance(max(relaxed%modes%tolerance, result%reached))
        if (is_missing(relaxed%modes%tolerance)) exit
        if (is_loaded(scene)) then
          call simulate_case(relaxed, layout, watch, monitor, cache, result, completed, loaded=relaxed)
        else
          call simulate_case(relaxed, layout, watch, monitor, cache, result, completed)
        end if
      end do
    end if
    if (completed .and. allocated(scene%frequency_response)) call answer_force(scene, layout, watch, monitor, cache, result, &
                                                                            completed)
    if (completed .and. scene%modes%modal_model .and. .not. allocated(result%error)) then
      call find_modal_model(scene, merge(layout%modes, 0, result%mode_count > 0), monitor, result)
      completed = .not. monitor%stop_requested()
      call watch%lap(stage_modes)
    end if
  end subroutine run_case

  subroutine answer_force(scene, layout, watch, monitor, cache, result, completed)
    !! Add the frequency response to a result.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout) :: monitor
    type(case_cache), intent(inout), target :: cache
    type(case_result), intent(inout) :: result
    logical, intent(out) :: completed
    type(part_monitor) :: part
    part = stage_part(monitor, case_shares(scene), answer_share)
    call find_frequency_response(scene, result%units, layout%junctions, layout%cases == 0, part, cache%motion%modes, &
                                 result%answer, result%notes, result%status)
    completed = .not. monitor%stop_requested()
    call watch%lap(stage_response)
  end subroutine answer_force

  subroutine simulate_case(scene, layout, watch, monitor, cache, result, completed, planned, loaded)
    !! Simulate a case without lasting contacts or changes in time.
    type(scene_type), intent(in) :: scene            !! without sweeps
    type(result_layout), intent(in) :: layout
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor
    type(case_cache), intent(inout), target :: cache !! filled by other cases
    type(case_result), intent(out) :: result
    logical, intent(out) :: completed                    !! false if the monitor requested a stop before the end
    type(case_motion), allocatable, intent(inout), optional :: planned   !! see `run_case`
    type(scene_type), intent(in), optional :: loaded   !! the scene with its loads and their tolerance; absent: no loads
    type(case_motion), allocatable :: motion
    type(case_histories) :: histories
    type(history_errors) :: errors
    type(case_spectrum) :: spectrum
    type(load_result), allocatable :: loads
    type(string), allocatable :: leading_notes(:), validity(:)
    type(part_monitor) :: part
    type(search_failure), target :: failure
    real(dp), allocatable :: share(:)
    logical :: planning
    call watch%start()
    share = case_shares(scene)
    completed = .false.

    planning = .false.
    if (present(planned)) then
      planning = allocated(planned)
      call move_alloc(planned, motion)
    end if
    if (.not. planning) then
      allocate (motion)
      motion%units = units_of(scene%beam)
      part = stage_part(monitor, share, modes_share)
      call find_modes(scene, motion%units, part, motion%modes, cache%motion%modes)
      if (monitor%stop_requested()) return
    end if
    call observe_searches(motion%modes%configuration, failure, monitor)
    call watch%lap(stage_modes)

    if (.not. planning) then
      part = stage_part(monitor, share, events_share)
      call find_motion(scene, motion, part, cache%motion)
      if (monitor%stop_requested()) return
      if (allocated(scene%impact)) call watch%lap(stage_events)
    end if
    part = stage_part(monitor, share, histories_share)
    call find_histories(scene, motion, part, cache%motion, histories, errors, watch)
    if (monitor%stop_requested()) return
    if (allocated(histories%response)) then
      if (scene%response%bending_moment) call find_moments(scene, motion, part, histories, errors)
      if (monitor%stop_requested()) return
      call add_hub_angle(scene, motion, part, histories%response)
      if (monitor%stop_requested()) return
      call drop_errors(motion, errors)
      if (present(loaded)) then
        call add_loads(loaded, motion, part, cache%motion%modes, histories, errors, loads, result%error)
        completed = allocated(result%error)
        if (completed) return
        if (monitor%stop_requested()) return
      end if
    end if

    if (motion%modes%resolved) call note_validity(scene, motion, histories%response, validity)
    if (allocated(histories%response)) then
      call note_history_errors(scene, histories%response, errors, leading_notes, validity)
      call drop_unresolved(scene, motion, histories, errors)
      call watch%lap(stage_response)
      call watch%rebook(stage_response, stage_modes, histories%response%mode_seconds)
    end if
    call add_notes(motion%modes%notes, validity)

    if (allocated(scene%spectrum)) then
      part = stage_part(monitor, share, spectrum_share)
      call find_spectrum(scene, layout, motion, histories%response, errors%status, part, cache%spectrum, spectrum, loads)
      if (monitor%stop_requested()) return
      call watch%lap(stage_spectrum)
    end if
    completed = .true.
    result%profile_points = layout%profile
    call compose(scene, leading_notes, motion, histories, errors, spectrum, result)
    if (allocated(loads) .and. .not. allocated(scene%impact)) result%mode_count = loads%count
    call move_alloc(loads, result%loads)
  end subroutine simulate_case

  subroutine compose(scene, leading_notes, motion, histories, errors, spectrum, result)
    !! Collect the values of all stages. Large arrays are moved, not copied.
    type(scene_type), intent(in) :: scene
    type(string), allocatable, intent(in) :: leading_notes(:)     !! notes that come first
    type(case_motion), intent(inout) :: motion
    type(case_histories), intent(inout) :: histories
    type(history_errors), intent(inout) :: errors
    type(case_spectrum), intent(inout) :: spectrum
    type(case_result), intent(inout) :: result
    allocate (result%notes(0))
    call add_notes(result%notes, leading_notes)
    call note_relaxed(scene, result%notes)
    call add_notes(result%notes, motion%modes%notes)
    call add_notes(result%notes, motion%notes)
    call add_notes(result%notes, histories%notes)
    call add_notes(result%notes, errors%notes)
    call add_notes(result%notes, spectrum%notes)
    call put_together(motion, histories%response, errors, spectrum, result)
    call compose_modes(motion, result)
    if (size(result%events) > 0) then
      result%impact = motion%initial%impact
      result%approach_velocity = scene%impact%approach_velocity
      if (allocated(scene%hub)) then
        result%lever = scene%hub%radius + scene%impact%position*motion%units%length
        call remark(result%notes, 'hub: after the last event its mean angular velocity is '// &
          shortest(sum(result%events%hub_rate_change)*(scene%impact%approach_velocity/motion%units%length), 6)// &
          ' rad/s, in addition to the steady rotation')
      end if
      call move_alloc(motion%initial%modal_velocity, result%modal_velocity)
      call move_alloc(motion%initial%velocity_jump, result%velocity_jump)
    end if
  end subroutine compose

  subroutine compose_modes(motion, result)
    !! Take the modes after the last event at t = 0, and those of the beam alone if they differ.
    type(case_motion), intent(inout) :: motion
    type(case_result), intent(inout) :: result
    associate (configuration => motion%modes%configuration, moving => motion%modes%moving)
      if (moving /= alone) call move_alloc(configuration(alone)%set, result%before)
      call move_alloc(configuration(moving)%set, result%modes)
    end associate
    result%mode_count = 0
    if (size(result%segments) > 0) then
      result%mode_count = result%segments(1)%count
    else if (motion%modes%resolved) then
      result%mode_count = result%modes%count
    end if
  end subroutine compose_modes

end module bw_one_case
