module bw_case_contacts
  !! One run of a case with a lasting impact, from contacts to histories, with a given number of modes.
  use bw_case_histories, only: add_hub_angle, find_loaded_segments, samples_before, sum_histories
  use bw_case_moments, only: find_moments
  use bw_case_result, only: case_diverged, case_done, case_histories, case_motion, case_not_converged, contact_result, &
    history_errors
  use bw_constants, only: pi
  use bw_contact_bodies, only: first_motion
  use bw_contact_changes, only: follow_contacts
  use bw_contact_force, only: force_at
  use bw_contact_rates, only: add_rates, driven_histories, find_driven_histories, find_next_octave, rounding_in, store_in_segments
  use bw_event, only: capture_event, contact_event
  use bw_first_motion, only: find_first_motion
  use bw_initial_state, only: initial_state
  use bw_kinds, only: dp
  use bw_lasting_contact, only: demand_type, lasting_contacts, load_of
  use bw_load_columns, only: quantities
  use bw_loads_beside, only: unit_force
  use bw_missing, only: is_missing, missing, scaled
  use bw_mode_set, only: deflections
  use bw_monitor, only: monitor_type
  use bw_neglected_modes, only: find_neglected, neglected_type
  use bw_placed_loads, only: placed_loads
  use bw_response, only: response_type
  use bw_result_layout, only: contact_samples
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: alone
  use bw_text, only: string
  use bw_time_grid, only: time_grid_of
  use bw_timeline, only: step_type, steps_of, timeline_type
  implicit none (type, external)
  private
  public :: follow_run

  type, public :: run_type
    type(timeline_type) :: timeline
    type(initial_state) :: initial                  !! velocities of the modes in the first flight
    type(contact_result), allocatable :: result
    type(response_type), allocatable :: response    !! SI
    integer :: status = case_done                   !! of the histories
    integer :: ending = case_done                   !! status: why the motion is not known to its end
    logical :: cut = .false., out_of_range = .false., failed = .false.   !! see lasting_contacts
    integer :: summed = 0                           !! modes of the struck beam
    real(dp) :: step_tolerance = 0.0_dp             !! error of a step over the largest force
    real(dp), allocatable :: rounding(:, :)         !! under loads, SI, (points, quantities)
    type(neglected_type) :: neglected
    type(string), allocatable :: notes(:)
  end type run_type

contains

  subroutine follow_run(scene, motion, demand, monitor, run, loads)
    !! Follow contacts and flights, and sum histories. `motion` gets the timeline of this run.
    type(scene_type), intent(in) :: scene            !! with mode counts
    type(case_motion), intent(inout) :: motion       !! its modes are known
    type(demand_type), intent(in) :: demand
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(run_type), intent(out) :: run
    type(placed_loads), intent(in), optional :: loads   !! N; absent: only the mass acts on the beam
    type(lasting_contacts) :: contacts
    type(case_histories) :: histories
    type(history_errors) :: none
    type(driven_histories) :: driven
    logical :: asked(quantities)
    call find_contacts(scene, motion, demand, monitor, contacts, loads)
    if (monitor%stop_requested() .or. .not. motion%modes%resolved) return
    run%summed = demand%modes
    run%step_tolerance = demand%tolerance
    run%cut = contacts%cut
    run%out_of_range = contacts%out_of_range
    run%failed = contacts%failed
    if (contacts%out_of_range) run%ending = case_diverged
    if (contacts%cut .or. contacts%failed) run%ending = case_not_converged
    call keep_contacts(scene, motion, contacts, run)
    call move_alloc(contacts%events, motion%timeline%events)
    call move_alloc(contacts%segments, motion%timeline%segments)
    call move_alloc(contacts%ladder, motion%ladder)
    motion%timeline%known_until = contacts%known_until
    run%timeline = motion%timeline
    associate (response => scene%response)
      asked = [.false., .false., response%acceleration, .false., response%shear_force, .false.]
      if (present(loads)) asked = [.true., response%velocity, response%acceleration, response%bending_moment, &
                                   response%shear_force, allocated(scene%hub)]
      if (any(asked)) call find_driven_histories(scene, motion, demand%modes, asked, samples_before(contacts%known_until, &
        time_grid_of( &
        response%duration, response%samples, motion%units%time)), monitor, driven, loads)
    end associate
    if (monitor%stop_requested()) return
    if (present(loads)) then
      call store_in_segments(scene, driven, motion)
      run%rounding = rounding_in(scene, motion, driven)
    else
      call find_loaded_segments(scene, motion, monitor)
      if (monitor%stop_requested()) return
      call find_neglected(scene, motion, demand%modes, monitor, run%neglected)
    end if
    if (monitor%stop_requested()) return
    if (any(asked)) call find_next_octave(scene, motion, driven, run%neglected)
    call sum_histories(scene, motion, deflections, monitor, histories)
    if (monitor%stop_requested()) return
    if (scene%response%bending_moment) call find_moments(scene, motion, monitor, histories, none)
    if (monitor%stop_requested()) return
    call add_hub_angle(scene, motion, monitor, histories%response)
    if (monitor%stop_requested()) return
    run%status = max(histories%status, none%status)
    call move_alloc(histories%response, run%response)
    call move_alloc(histories%notes, run%notes)
    if (any(asked)) call add_rates(scene, motion, driven, run%response)
  end subroutine follow_run

  subroutine find_contacts(scene, motion, demand, monitor, contacts, loads)
    !! Find the initial motion, then contacts and flights, or the free motion of a beam that nothing strikes.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion       !! unresolved if the beam cannot start as requested
    type(demand_type), intent(in) :: demand
    class(monitor_type), intent(inout), target :: monitor
    type(lasting_contacts), intent(out) :: contacts
    type(placed_loads), intent(in), optional :: loads   !! N
    type(first_motion) :: first
    call find_first_motion(scene, alone, motion, first%q, first%rate)
    if (.not. motion%modes%resolved) return
    associate (unit => unit_velocity(scene))
      first%q = first%q/unit
      first%rate = first%rate/unit
      first%speed = scene%impact%approach_velocity/unit
      if (allocated(scene%bodies)) first%others = &
        max(0.0_dp, maxval(abs(scene%bodies%velocity), mask=.not. is_missing(scene%bodies%velocity)))/abs(unit)
    end associate
    call follow_contacts(scene, motion, demand, first, monitor, contacts, loads)
  end subroutine find_contacts

  subroutine keep_contacts(scene, motion, contacts, run)
    !! Store forces and times in SI, and modal velocities after the first contact.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(lasting_contacts), intent(inout) :: contacts
    type(run_type), intent(inout) :: run
    real(dp) :: newton, places(contact_samples)
    type(step_type), allocatable :: steps(:)
    integer :: first, i, last
    allocate (run%result)
    associate (events => contacts%events, unit => motion%units%time%hi, duration => scene%response%duration, kept => run%result)
      newton = unit_force(scene, motion)
      places = [(0.5_dp*(1.0_dp - cos(pi*(i - 1)/(contact_samples - 1))), i=1, contact_samples)]
      allocate (kept%force(contact_samples, size(events)), source=missing)
      last = findloc(events%kind, contact_event, dim=1, back=.true.)
      do i = 1, last
        if (events(i)%kind /= contact_event) cycle
        kept%force(:, i) = newton*force_at(load_of(contacts, i), places*(events(i)%end_time - events(i)%time))
        if (i < last .or. .not. (contacts%lasting .or. contacts%captured)) kept%force(contact_samples, i) = 0.0_dp
      end do
      kept%force_error = 0.0_dp*events%time
      kept%largest = newton*events%largest_force
      kept%largest_time = unit*events%largest_force_time
      where (events%kind /= contact_event)
        kept%force_error = missing
        kept%largest = missing
        kept%largest_time = missing
      end where
      kept%restitution = contacts%restitution
      kept%approach = unit_velocity(scene)*contacts%approach
      kept%indentation = contacts%largest_indentation*abs(unit_velocity(scene))*unit
      kept%leaving = scaled(contacts%leaving, unit_velocity(scene))
      kept%lasting = contacts%lasting
      events%time = min(events%time*unit, duration)
      events%end_time = min(events%end_time*unit, duration)
      if (contacts%lasting .and. last > 0) events(last)%end_time = duration
      steps = steps_of(scene)
      do i = 1, size(events)
        if (events(i)%kind == contact_event .or. events(i)%kind == capture_event) cycle
        events(i)%time = steps(minloc(abs(steps%seconds - events(i)%time), dim=1))%seconds
        events(i)%end_time = events(i)%time
      end do
      run%initial%modal_velocity = 0.0_dp*motion%modes%configuration(alone)%set%modal_mass   ! if no force was found
      first = size(contacts%segments)                           ! the first flight, if any
      do i = first, 1, -1
        if (.not. allocated(contacts%segments(i)%load)) first = i
      end do
      if (first == 0) return
      associate (flight => contacts%segments(first))
        run%initial%modal_velocity = sqrt(flight%rate**2 + flight%q**2 &
          *max(0.0_dp, motion%modes%configuration(flight%configuration)%set%beta_squared%hi))
      end associate
    end associate
  end subroutine keep_contacts

end module bw_case_contacts
