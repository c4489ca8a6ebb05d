module bw_contact_case
  !! The motion of a case with a lasting impact: modes ► contacts and flights ► histories ► errors. The motion converges
  !! as modes are added, and a tolerance increases their number until the error is small enough.
  !!
  !! Contacts are nonlinear, and no bound is known for the growth of errors. So the motion is followed with all modes
  !! and with half of them. Their difference, and the contribution of the next octave of modes, estimate the truncation
  !! error (bw_contact_errors). Step errors are far smaller. As a tolerance increases the number of modes, the previous
  !! run replaces that with half of them.
  use bw_beam_units, only: units_of
  use bw_case_contacts, only: follow_run, run_type
  use bw_case_loads, only: load_summary
  use bw_case_modes, only: case_mode_cache, extend_source, find_modes, most_in_run
  use bw_case_notes, only: note_lasting_contacts
  use bw_case_result, only: add_notes, case_done, case_motion, case_not_converged, history_errors, simulation
  use bw_changing_errors, only: join_state_errors
  use bw_constants, only: two_pi
  use bw_contact_errors, only: add_rounding, fall_of_force, find_force_errors, find_history_errors
  use bw_error, only: error_type
  use bw_event, only: contact_event
  use bw_kinds, only: dp
  use bw_lasting_contact, only: demand_type
  use bw_load_courses, only: courses_of
  use bw_mode_set, only: configuration_type, first_numbers, observe_searches
  use bw_modes_par, only: wanted_tolerance
  use bw_monitor, only: monitor_type
  use bw_placed_loads, only: place_loads, placed_loads
  use bw_reached_tolerance, only: first_count, is_met, judge_tolerance, part_of_peak, with_counts
  use bw_scene, only: is_loaded, scene_type
  use bw_segment, only: alone
  use bw_stopwatch, only: stage_events, stage_modes, stage_response, stopwatch
  implicit none (type, external)
  private
  public :: run_contacts

  integer, parameter :: most_count = 4096          !! and the most that it may sum,
  integer, parameter :: most_by_default = 1024     !! or the default tolerance if accelerations are requested

contains

  subroutine run_contacts(scene, watch, monitor, cache, found, error)
    !! Run a case with the counts of the scene or by its tolerance.
    !! **Errors**: those of reading the loads.
    type(scene_type), intent(in) :: scene            !! without sweeps
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(case_mode_cache), intent(inout), target :: cache
    type(simulation), intent(inout), target :: found !! new
    type(error_type), allocatable, intent(out) :: error
    type(placed_loads), allocatable :: loads
    type(run_type), allocatable :: run
    if (is_loaded(scene)) then
      allocate (loads)
      associate (units => units_of(scene%beam))
        call courses_of(scene, units, loads%course, error)
        if (allocated(error)) return
        found%loads = load_summary(scene, loads%course, units)
      end associate
      call place_loads(scene, loads)
    end if
    allocate (found%motion)
    associate (motion => found%motion, errors => found%errors)
      call follow_to_tolerance(scene, loads, watch, monitor, cache, found, run)
      if (monitor%stop_requested()) return
      if (.not. motion%modes%resolved) then
        errors%status = case_not_converged
        return
      end if
      call move_alloc(run%response, found%histories%response)
      call move_alloc(run%result, found%contact)
      call note_lasting_contacts(scene, motion, found%contact, run%cut, run%out_of_range, run%failed)
      if (errors%status == case_done) motion%plan%within = is_met(scene%modes, motion%plan%reached)
      call judge_tolerance(scene%modes, motion%plan%reached, found%counted%modes%before, 'a shorter duration', &
                           found%histories%response, errors)
      if (.not. is_loaded(scene)) return
      found%loads%count = found%counted%modes%before
      call add_notes(errors%notes, found%loads%notes)
    end associate
  end subroutine run_contacts

  subroutine follow_to_tolerance(scene, loads, watch, monitor, cache, found, run)
    !! Follow the motion with the counts of the scene, or with as many modes as its tolerance needs, and estimate its errors.
    type(scene_type), intent(in) :: scene
    type(placed_loads), allocatable, intent(in) :: loads   !! besides the contact force
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor
    type(case_mode_cache), intent(inout), target :: cache
    type(simulation), intent(inout), target :: found !! its motion and errors
    type(run_type), allocatable, intent(out) :: run  !! with all modes
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
    associate (counted => found%counted, motion => found%motion, errors => found%errors)
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
        call observe_searches(motion%modes%configuration, found%failure, monitor)
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
    end associate
  contains
    subroutine extend_modes(configuration)
      !! Extend a source to twice the summed modes, and take these from the extended basis.
      type(configuration_type), intent(inout) :: configuration
      logical :: extended
      if (configuration%source%highest >= 2*found%counted%modes%before) return
      call extend_source(found%counted, found%motion%units, alone, monitor, configuration%source, extended, cache)
      if (monitor%stop_requested() .or. .not. extended) return
      call configuration%source%find(first_numbers(found%counted%modes%before), configuration%set, monitor=monitor)
      if (monitor%stop_requested()) return
      call configuration%set%forget_rigid_waves()
    end subroutine extend_modes

    subroutine follow_part(divisor, followed)
      !! Follow the motion with 1/`divisor` of the modes.
      integer, intent(in) :: divisor
      type(run_type), allocatable, intent(out) :: followed
      type(demand_type) :: demand
      demand = demand_type((found%counted%modes%before + divisor - 1)/divisor, scene%contact%max_contacts, &
                           scene%response%duration/found%motion%units%time%hi, step_tolerance(scene), allocated(scene%capture))
      allocate (followed)
      call follow_run(found%counted, found%motion, demand, monitor, followed, loads)
    end subroutine follow_part
  end subroutine follow_to_tolerance

  pure real(dp) function step_tolerance(scene) result(tolerance)
    !! Return the tolerance of the force in a step: so far below that of histories that contacts may amplify it.
    type(scene_type), intent(in) :: scene
    real(dp), parameter :: share = 1.0e-3_dp, most = 1.0e-9_dp, least = 1.0e-11_dp   ! tuned: below it rounding controls the steps
    tolerance = max(least, min(most, share*wanted_tolerance(scene%modes)))
  end function step_tolerance

  pure logical function resolves_contacts(motion, run) result(resolves)
    !! Return whether the highest mode completes some periods within the contact of largest impulse. With fewer modes
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
    !! Return whether the tolerance would need far more modes than the limit, at the observed rate of convergence or that of forces.
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

end module bw_contact_case
