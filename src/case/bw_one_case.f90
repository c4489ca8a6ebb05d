module bw_one_case
  !! One case from scene to result: a record (bw_record_case), or a simulation: modes ► motion ► histories ► errors ►
  !! spectrum. Its motion is followed by bw_contact_case, bw_changing_case or bw_planned_case.
  use bw_amplitude_spectrum, only: spectrum_plan
  use bw_case_cost, only: answer_share, case_shares, spectrum_share, stage_part
  use bw_case_frequency, only: find_frequency_response
  use bw_case_notes, only: note_relaxed
  use bw_case_octave, only: drop_unresolved
  use bw_case_result, only: add_notes, case_motion, case_result, case_spectrum, simulation
  use bw_case_spectrum, only: find_spectrum
  use bw_case_validity, only: note_validity
  use bw_changing_case, only: run_changes
  use bw_contact_case, only: run_contacts
  use bw_history_notes, only: note_history_errors
  use bw_kept_tolerance, only: motion_cache
  use bw_missing, only: is_missing
  use bw_modal_model, only: find_modal_model
  use bw_mode_set, only: first_numbers, mode_set
  use bw_modes_par, only: by_tolerance, relaxed_tolerance, shown_modes
  use bw_monitor, only: monitor_type, part_monitor
  use bw_planned_case, only: run_planned
  use bw_record_case, only: record_cache, run_record_case
  use bw_result_layout, only: result_layout
  use bw_scene, only: changes_in_time, has_configurations, is_planned, scene_type, unit_velocity
  use bw_stopwatch, only: stage_modes, stage_response, stage_spectrum, stopwatch
  use bw_text, only: string
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
    else
      call simulate_case(scene, layout, watch, monitor, cache, result, completed, planned)
      if (allocated(result%error)) return
      relaxed = scene
      do while (completed .and. is_planned(scene) .and. .not. (scene%modes%asked .or. result%within))
        relaxed%modes%tolerance = relaxed_tolerance(max(relaxed%modes%tolerance, result%reached))
        if (is_missing(relaxed%modes%tolerance)) exit
        call simulate_case(relaxed, layout, watch, monitor, cache, result, completed)
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

  subroutine simulate_case(scene, layout, watch, monitor, cache, result, completed, planned)
    !! Simulate a case, with the counts of the scene or by its tolerance.
    type(scene_type), intent(in) :: scene            !! without sweeps
    type(result_layout), intent(in) :: layout
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor
    type(case_cache), intent(inout), target :: cache !! filled by other cases
    type(case_result), intent(out) :: result
    logical, intent(out) :: completed                    !! false if the monitor requested a stop before the end
    type(case_motion), allocatable, intent(inout), optional :: planned   !! see `run_case`
    type(simulation), target :: run
    type(case_spectrum) :: spectrum
    type(string), allocatable :: leading_notes(:), validity(:)
    type(part_monitor) :: part
    call watch%start()
    if (present(planned)) call move_alloc(planned, run%motion)
    if (allocated(scene%contact)) then
      call run_contacts(scene, watch, monitor, cache%motion%modes, run, result%error)
    else if (changes_in_time(scene)) then
      call run_changes(scene, watch, monitor, cache%motion%modes, run, result%error)
    else
      call run_planned(scene, watch, monitor, cache%motion, run, result%error)
    end if
    completed = allocated(result%error)
    if (monitor%stop_requested() .or. completed) return
    if (run%motion%modes%resolved) call note_validity(run%counted, run%motion, run%histories%response, run%contact, validity)
    if (allocated(run%histories%response)) then
      call note_history_errors(run%counted, run%histories%response, run%errors, leading_notes, validity)
      call drop_unresolved(run%counted, run%motion, run%histories, run%errors)
      call watch%lap(stage_response)
      call watch%rebook(stage_response, stage_modes, run%histories%response%mode_seconds)
    end if
    if (allocated(scene%spectrum) .and. allocated(run%histories%response)) then
      part = stage_part(monitor, case_shares(scene), spectrum_share)
      call find_spectrum(run%counted, layout, run%motion, run%histories%response, run%errors%status, part, cache%spectrum, &
                         spectrum, run%loads)
      if (monitor%stop_requested()) return
      call watch%lap(stage_spectrum)
    end if
    completed = .true.
    allocate (result%notes(0))
    call add_notes(result%notes, leading_notes)
    call note_relaxed(scene, result%notes)
    call add_notes(result%notes, run%motion%modes%notes)
    call add_notes(result%notes, validity)
    call add_notes(result%notes, run%motion%notes)
    call add_notes(result%notes, run%histories%notes)
    call add_notes(result%notes, run%errors%notes)
    call add_notes(result%notes, spectrum%notes)
    result%profile_points = layout%profile
    call compose(scene, run, result)
    call move_alloc(spectrum%amplitude, result%amplitude)
    call move_alloc(spectrum%measured, result%measured)
  end subroutine simulate_case

  subroutine compose(scene, run, result)
    !! Collect the values of all stages. Large arrays are moved, not copied.
    type(scene_type), intent(in) :: scene
    type(simulation), intent(inout) :: run
    type(case_result), intent(inout) :: result
    associate (motion => run%motion, initial => run%motion%initial)
      result%units = motion%units
      result%can_grow = motion%modes%can_grow
      result%reached = motion%plan%reached
      result%within = motion%plan%within
      result%status = run%errors%status
      result%approach_velocity = unit_velocity(scene)
      call move_alloc(motion%timeline%events, result%events)
      call move_alloc(motion%timeline%segments, result%segments)
      if (.not. allocated(result%events)) allocate (result%events(0))
      if (.not. allocated(result%segments)) allocate (result%segments(0))
      call compose_modes(scene, motion, result)
      if (allocated(run%loads)) result%mode_count = max(result%mode_count, run%loads%count)
      if (allocated(scene%hub)) then
        result%lever = scene%hub%radius + motion%units%length
        if (allocated(scene%impact)) result%lever = scene%hub%radius + scene%impact%position*motion%units%length
      end if
      if (.not. allocated(scene%contact)) then
        if (allocated(scene%impact) .and. size(result%events) > 0) result%impact = initial%impact
        call move_alloc(initial%velocity_jump, result%velocity_jump)
        call move_alloc(initial%modal_displacement, result%modal_displacement)
        call move_alloc(initial%modal_velocity, result%modal_velocity)
      end if
    end associate
    call move_alloc(run%contact, result%contact)
    call move_alloc(run%loads, result%loads)
    call move_alloc(run%histories%response, result%response)
    if (.not. allocated(result%response)) return
    call move_alloc(run%errors%displacement, result%response%displacement_error)
    call move_alloc(run%errors%displacement_bound, result%response%displacement_bound)
    call move_alloc(run%errors%velocity, result%response%velocity_error)
    call move_alloc(run%errors%bending_moment, result%response%bending_moment_error)
    call move_alloc(run%errors%acceleration, result%response%acceleration_error)
    call move_alloc(run%errors%shear_force, result%response%shear_force_error)
  end subroutine compose

  subroutine compose_modes(scene, motion, result)
    !! Take the modes after the last event at t = 0, those of the beam alone before a capture, and those of all
    !! configurations if there may be many. Of modes that a tolerance counted during the run only the first are kept.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(case_result), intent(inout) :: result
    class(mode_set), allocatable :: shown
    logical :: counted
    integer :: c
    counted = .not. (by_tolerance(scene%modes) .and. (allocated(scene%contact) .or. changes_in_time(scene)))
    associate (configuration => motion%modes%configuration, moving => motion%modes%moving)
      if (motion%modes%resolved) then
        result%mode_count = configuration(moving)%set%count
        if (size(result%segments) > 0) result%mode_count = result%segments(1)%count
      end if
      do c = 1, size(configuration)
        if (counted .or. .not. motion%modes%resolved) exit
        call configuration(c)%source%find(first_numbers(min(shown_modes, configuration(c)%set%count)), shown)
        call shown%forget_rigid_waves()
        call move_alloc(shown, configuration(c)%set)
      end do
      if (counted .and. allocated(scene%capture)) call keep(configuration(1)%set, result%before)
      call keep(configuration(moving)%set, result%modes)
    end associate
    if (has_configurations(scene)) call move_alloc(motion%modes%configuration, result%configurations)
  contains
    subroutine keep(set, kept)
      !! Move a set, or copy one that is also kept in its configuration.
      class(mode_set), allocatable, intent(inout) :: set
      class(mode_set), allocatable, intent(out) :: kept
      if (.not. has_configurations(scene)) then
        call move_alloc(set, kept)
      else if (allocated(set)) then
        allocate (kept, source=set)
      end if
    end subroutine keep
  end subroutine compose_modes

end module bw_one_case
