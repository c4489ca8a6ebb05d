module bw_contact_case
  !! A case with a lasting impact: modes ► contacts and flights ► histories ► errors ► spectrum. The motion converges as
  !! modes are added, and a tolerance increases their number until the error is small enough.
  !!
  !! Contacts are nonlinear, and no bound is known for the growth of errors. So the motion is followed with all modes
  !! and with half of them. Their difference, and the contribution of the next octave of modes, estimate the truncation
  !! error (bw_contact_errors). Step errors are far smaller. As a tolerance increases the number of modes, the previous
  !! run replaces that with half of them.
  use bw_amplitude_spectrum, only: spectrum_plan
  use bw_beam_units, only: units_of
  use bw_case_contacts, only: follow_run, run_type
  use bw_case_loads, only: load_summary, place_loads
  use bw_case_modes, only: case_mode_cache, extend_source, find_modes, most_in_run
  use bw_case_notes, only: note_lasting_contacts
  use bw_case_result, only: add_notes, case_done, case_motion, case_not_converged, case_result, case_spectrum, history_errors, &
    load_result, put_together
  use bw_case_spectrum, only: find_spectrum
  use bw_changing_case, only: compose_modes
  use bw_changing_errors, only: join_state_errors
  use bw_case_validity, only: note_contact, note_validity
  use bw_constants, only: two_pi
  use bw_history_notes, only: note_history_errors
  use bw_mode_set, only: observe_searches, configuration_type, first_numbers, mode_set, search_failure
  use bw_modes_par, only: by_tolerance, shown_modes, wanted_tolerance
  use bw_contact_errors, only: add_rounding, fall_of_force, find_force_errors, find_history_errors
  use bw_event, only: contact_event
  use bw_kinds, only: dp
  use bw_lasting_contact, only: demand_type
  use bw_load_columns, only: placed_loads
  use bw_load_courses, only: courses_of
  use bw_monitor, only: monitor_type
  use bw_result_layout, only: result_layout
  use bw_reached_tolerance, only: first_count, is_met, judge_tolerance, part_of_peak, with_counts
  use bw_scene, only: bodies_change, is_loaded, scene_type, unit_velocity
  use bw_segment, only: alone
  use bw_stopwatch, only: stage_events, stage_modes, stage_response, stage_spectrum, stopwatch
  use bw_text, only: string
  implicit none (type, external)
  private
  public :: run_contact_case

  integer, parameter :: most_count = 4096          !! and the most that it may sum,
  integer, parameter :: most_by_default = 1024     !! or the default tolerance if accelerations are requested

contains

  subroutine run_contact_case(scene, layout, watch, monitor, cache, plan, result, completed)
    !! Run a case with the counts of the scene or by its tolerance.
    type(scene_type), intent(in) :: scene            !! without sweeps
    type(result_layout), intent(in) :: layout
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor
    type(case_mode_cache), intent(inout), target :: cache
    type(spectrum_plan), intent(inout) :: plan
    type(case_result), intent(out) :: result
    logical, intent(out) :: completed                    !! false if the monitor requested a stop before the end
    type(scene_type) :: counted
    type(case_motion) :: motion
    type(history_errors) :: errors
    type(case_spectrum) :: spectrum
    type(run_type), allocatable :: run
    type(search_failure), target :: failure
    type(string), allocatable :: leading_notes(:), validity(:)
    type(placed_loads), allocatable :: loads
    type(load_result), allocatable :: acted
    completed = .false.
    call watch%start()
    if (is_loaded(scene)) then
      allocate (loads)
      associate (units => units_of(scene%beam))
        call courses_of(scene, units, loads%course, result%error)
        completed = allocated(result%error)
        if (completed) return
        acted = load_summary(scene, loads%course, units)
      end associate
      call place_loads(scene, loads)
    end if
    call follow_to_tolerance(scene, loads, watch, monitor, cache, failure, counted, motion, run, errors)
    if (monitor%stop_requested()) return
    if (motion%modes%resolved) then
      call note_validity(counted, motion, run%response, validity)
      call note_contact(counted, motion%units, run%result, motion%timeline%events, validity)
      call note_history_errors(counted, run%response, errors, leading_notes, validity)
      call note_lasting_contacts(scene, motion, run%result, run%cut, run%out_of_range, run%failed)
      if (errors%status == case_done) motion%plan%within = is_met(scene%modes, motion%plan%reached)
      call judge_tolerance(scene%modes, motion%plan%reached, counted%modes%before, 'a shorter duration', run%response, errors)
    end if
    call watch%lap(stage_response)
    if (motion%modes%resolved .and. allocated(scene%spectrum)) then
      call find_spectrum(counted, layout, motion, run%response, errors%status, monitor, plan, spectrum, acted)
      if (monitor%stop_requested()) return
      call watch%lap(stage_spectrum)
    end if
    allocate (result%notes(0))
    call add_notes(result%notes, leading_notes)
    call add_notes(result%notes, motion%modes%notes)
    call add_notes(result%notes, validity)
    call add_notes(result%notes, motion%notes)
    call add_notes(result%notes, errors%notes)
    call add_notes(result%notes, spectrum%notes)
    if (allocated(acted)) call add_notes(result%notes, acted%notes)
    call compose(scene, motion, run, errors, spectrum, result)
    if (allocated(acted)) acted%count = result%mode_count
    call move_alloc(acted, result%loads)
    result%profile_points = layout%profile
    completed = .true.
  end subroutine run_contact_case

  subroutine follow_to_tolerance(scene, loads, watch, monitor, cache, failure, counted, motion, run, errors)
    !! Follow the motion with the counts of the scene, or with as many modes as its tolerance needs, and estimate its errors.
    type(scene_type), intent(in) :: scene
    type(placed_loads), allocatable, intent(in) :: loads   !! besides the contact force
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor
    type(case_mode_cache), intent(inout), target :: cache
    type(search_failure), intent(inout), target :: failure
    type(scene_type), intent(out) :: counted         !! the scene with the final count
    type(case_motion), intent(out) :: motion
    type(run_type), allocatable, intent(out) :: run
    type(history_errors), intent(out) :: errors
    type(run_type), allocatable :: half
    real(dp) :: before, fall
    integer :: most
    integer :: octaves                               ! doublings of the mode count, last and next
    logical :: grown
    allocate (run)
    most = most_count
    if (scene%response%acceleration .and. .not. scene%modes%asked) most = most_by_default   ! accelerations converge slowly
    before = huge(before)
    most = most_in_run(scene, most)
    counted = with_counts(scene)
    octaves = 1
    grown = .false.
    do
      counted%modes%after = counted%modes%before
      motion = case_motion(units=units_of(scene%beam))
      call find_modes(counted, motion%units, monitor, motion%modes, cache)
      if (monitor%stop_requested()) return
      if (motion%modes%resolved) call extend_modes(motion%modes%configuration(alone))
      if (monitor%stop_requested()) return
      call watch%lap(stage_modes)
      if (.not. motion%modes%resolved) return
      call observe_searches(motion%modes%configuration, failure, monitor)
      if (grown) then                                ! the previous modes are among these
        call move_alloc(run, half)
      else
        call follow_part(2, half)
        if (monitor%stop_requested() .or. .not. motion%modes%resolved) return
      end if
      call follow_part(1, run)
      if (monitor%stop_requested()) return
      call watch%lap(stage_events)
      errors = history_errors()
      call find_history_errors(run, half, errors)
      call join_state_errors(counted, motion, errors)
      call watch%lap(stage_response)
      if (run%failed .or. counted%modes%before >= most) exit
      motion%plan%reached = part_of_peak(run%response, errors)
      if (is_met(scene%modes, motion%plan%reached)) exit
      if (resolves_contacts(motion, run)) then
        fall = fall_of_force(run, half)
        if (is_unreachable(motion%plan%reached, before, scene%modes%tolerance, counted%modes%before, most, octaves, fall)) exit
        octaves = octaves_to(scene%modes%tolerance, motion%plan%reached, fall)
      end if
      before = motion%plan%reached
      grown = 2**octaves*counted%modes%before <= most
      counted%modes%before = min(most, 2**octaves*counted%modes%before)
    end do
    call find_force_errors(run, half)
    motion%timeline = run%timeline
    motion%initial = run%initial
    motion%ending = run%ending
    errors%status = run%ending
    if (run%status /= case_done) errors%status = run%status
    call add_notes(errors%notes, run%notes)
    call add_rounding(counted, motion, run%response, errors, run%rounding)
    motion%plan%reached = part_of_peak(run%response, errors)
  contains
    subroutine extend_modes(configuration)
      !! Extend a source to twice the summed modes, and take these from the extended basis.
      type(configuration_type), intent(inout) :: configuration
      logical :: extended
      if (configuration%source%highest >= 2*counted%modes%before) return
      call extend_source(counted, motion%units, alone, monitor, configuration%source, extended, cache)
      if (monitor%stop_requested() .or. .not. extended) return
      call configuration%source%find(first_numbers(counted%modes%before), configuration%set, monitor=monitor)
      if (monitor%stop_requested()) return
      call configuration%set%forget_rigid_waves()
    end subroutine extend_modes

    subroutine follow_part(divisor, followed)
      !! Follow the motion with 1/`divisor` of the modes.
      integer, intent(in) :: divisor
      type(run_type), allocatable, intent(out) :: followed
      type(demand_type) :: demand
      demand = demand_type((counted%modes%before + divisor - 1)/divisor, scene%contact%max_contacts, &
                           scene%response%duration/motion%units%time%hi, step_tolerance(scene), allocated(scene%capture))
      allocate (followed)
      call follow_run(counted, motion, demand, monitor, followed, loads)
    end subroutine follow_part
  end subroutine follow_to_tolerance

  pure real(dp) function step_tolerance(scene) result(tolerance)
    !! Return the tolerance of the force in a step: so far below that of histories that contacts may amplify it.
    type(scene_type), intent(in) :: scene
    real(dp), parameter :: share = 1.0e-3_dp, most = 1.0e-9_dp, least = 1.0e-11_dp   ! tuned: below it rounding controls the steps
    tolerance = max(least, min(most, share*wanted_tolerance(scene%modes)))
  end function step_tolerance

  pure logical function resolves_contacts(motion, run) result(resolves)
    !! Tell whether the highest mode completes some periods within the contact of largest impulse. With fewer modes
    !! forces are not resolved, and no convergence rate can be read from their errors.
    type(case_motion), intent(in) :: motion
    type(run_type), intent(in) :: run
    real(dp), parameter :: some = 2.0_dp             ! periods
    integer :: largest
    largest = maxloc(run%timeline%events%impulse, dim=1, mask=run%timeline%events%kind == contact_event)
    resolves = largest == 0                          ! nothing strikes the beam
    if (resolves) return
    associate (event => run%timeline%events(largest), square => motion%modes%configuration(alone)%set%beta_squared)
      resolves = sqrt(abs(square(size(square))%hi))*motion%units%frequency*(event%end_time - event%time) > some*two_pi
    end associate
  end function resolves_contacts

  pure integer function octaves_to(tolerance, reached, fall) result(octaves)
    !! Return how often to double the number of modes at once to reach the tolerance, if errors fall per octave as those
    !! of forces did.
    real(dp), intent(in) :: tolerance, reached, fall
    integer, parameter :: most = 3                   ! tuned: limit of extrapolation
    octaves = 1
    if (fall > 0.0_dp .and. fall < 1.0_dp) octaves = max(1, ceiling(min(real(most, dp), log(reached/tolerance)/(-log(fall)))))
  end function octaves_to

  pure logical function is_unreachable(reached, before, tolerance, count, most, octaves, fall)
    !! Tell whether the tolerance would need far more modes than the limit, at the observed rate of convergence or that of forces.
    real(dp), intent(in) :: reached, before, tolerance
    integer, intent(in) :: count, most
    integer, intent(in) :: octaves                   !! doublings since `before`
    real(dp), intent(in) :: fall                     !! ratio of force errors per octave; 1: unknown
    integer, parameter :: far = 3                    ! octaves
    real(dp) :: by_octave
    is_unreachable = .false.
    if (before >= huge(before) .or. count <= 4*first_count) return
    is_unreachable = reached >= 0.999_dp*before
    if (fall >= 1.0_dp) return
    by_octave = -log(max(fall, tiny(fall)))
    if (.not. is_unreachable) by_octave = max(by_octave, log(before/reached)/octaves)
    is_unreachable = log(reached/tolerance)/by_octave > log(real(most, dp)/count)/log(2.0_dp) + far
  end function is_unreachable

  subroutine compose(scene, motion, run, errors, spectrum, result)
    !! Collect the values of all stages. Large arrays are moved, not copied.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(run_type), intent(inout) :: run
    type(history_errors), intent(inout) :: errors
    type(case_spectrum), intent(inout) :: spectrum
    type(case_result), intent(inout) :: result
    class(mode_set), allocatable :: shown
    integer :: moving
    call put_together(motion, run%response, errors, spectrum, result)
    if (.not. motion%modes%resolved) result%status = case_not_converged
    result%approach_velocity = unit_velocity(scene)
    if (allocated(scene%hub)) result%lever = scene%hub%radius + scene%impact%position*motion%units%length
    if (motion%modes%resolved) call move_alloc(run%result, result%contact)
    if (bodies_change(scene)) then
      call compose_modes(scene, motion, result)
      return
    end if
    moving = motion%modes%moving
    result%mode_count = merge(motion%modes%configuration(moving)%set%count, 0, motion%modes%resolved)
    if (by_tolerance(scene%modes)) then
      call motion%modes%configuration(moving)%source%find(first_numbers(shown_modes), shown)
      call shown%forget_rigid_waves()
      call move_alloc(shown, result%modes)
    else
      if (moving /= alone) call move_alloc(motion%modes%configuration(alone)%set, result%before)
      call move_alloc(motion%modes%configuration(moving)%set, result%modes)
    end if
  end subroutine compose

end module bw_contact_case
