module bw_case_contacts
  !! One way to follow the motion of a case whose impact lasts, to its histories.
  use bw_case_bodies, only: bodies_of
  use bw_case_histories, only: add_hub_angle, find_loaded_segments, samples_before, sum_histories
  use bw_case_modes, only: whole_beam
  use bw_case_moments, only: find_moments
  use bw_case_result, only: case_diverged, case_done, case_histories, case_motion, case_not_converged, contact_result, &
    history_errors
  use bw_change_of_bodies, only: body_type
  use bw_contact_bodies, only: first_motion
  use bw_contact_changes, only: follow_changing_contacts
  use bw_contact_force, only: force_at
  use bw_contact_law, only: contact_law, contact_law_of
  use bw_case_motion, only: follow_motion
  use bw_constants, only: pi
  use bw_contact_rates, only: add_rates, driven_type, find_driven, neglected_in, rounding_in, show_in_segments
  use bw_event, only: capture_event, contact_event, event_type
  use bw_initial_state, only: initial_state
  use bw_first_motion, only: find_first_motion
  use bw_kinds, only: dp
  use bw_lasting_contact, only: demand_type, follow_lasting_contacts, lasting_contacts, load_of
  use bw_missing, only: is_missing, missing
  use bw_load_columns, only: placed_loads, quantities
  use bw_loads_beside, only: place_beside, unit_force
  use bw_missing, only: scaled
  use bw_mode_set, only: deflections, first_numbers, first_struck, mean_rate, mode_set, turns
  use bw_monitor, only: monitor_type
  use bw_neglected_modes, only: find_neglected, neglected_type
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_piece_beam, only: arm_of
  use bw_response, only: response_type
  use bw_result_layout, only: contact_samples
  use bw_rotation, only: full_speed_in_plane, speed_in_plane
  use bw_scene, only: bodies_change, scene_type, unit_velocity
  use bw_segment, only: alone, beam_energy, lack_type, segment_type, together
  use bw_static_shape, only: find_residual
  use bw_text, only: append, string
  use bw_time_grid, only: time_grid_of
  use bw_timeline, only: step_type, steps_of, timeline_type
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: follow_run

  type, public :: run_type
    type(timeline_type) :: timeline
    type(initial_state) :: initial                  !! of its modes the speeds of the first flight
    type(contact_result), allocatable :: result
    type(response_type), allocatable :: response    !! SI
    integer :: status = case_done                   !! of the histories
    integer :: ending = case_done                   !! why the motion is not known to its end
    logical :: cut = .false., out_of_range = .false., failed = .false.   !! as those of lasting_contacts
    integer :: summed = 0                           !! modes of the beam as it is struck
    real(dp) :: step_tolerance = 0.0_dp             !! of the largest force, what steps lack
    real(dp), allocatable :: rounding(:, :)         !! what it leaves under loads, SI, (points, quantities)
    type(neglected_type) :: neglected
    type(string), allocatable :: notes(:)
  end type run_type

contains

  subroutine follow_run(scene, motion, demand, monitor, workspace, run, loads)
    !! Contacts, flights and histories. The timeline of the motion is that of this run then.
    type(scene_type), intent(in) :: scene            !! with counts of modes
    type(case_motion), intent(inout) :: motion       !! its modes are known
    type(demand_type), intent(in) :: demand
    class(monitor_type), intent(inout), target :: monitor   !! what is found means nothing where it asks to stop
    type(nonuniform_sum), intent(inout) :: workspace(:)
    type(run_type), intent(out) :: run
    type(placed_loads), intent(in), optional :: loads   !! N; absent: nothing but the mass acts on the beam
    type(lasting_contacts) :: contacts
    type(case_histories) :: histories
    type(history_errors) :: none
    type(driven_type) :: driven
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
    if (contacts%captured .and. .not. bodies_change(scene)) call keep_mass(scene, motion, demand%modes, contacts, monitor)
    if (monitor%stop_requested()) return
    run%timeline = motion%timeline
    associate (response => scene%response)
      asked = [.false., .false., response%acceleration, .false., response%shear_force, .false.]
      if (present(loads)) asked = [.true., response%velocity, response%acceleration, response%bending_moment, &
                                   response%shear_force, allocated(scene%hub)]
      if (any(asked)) call find_driven(scene, motion, demand%modes, asked, samples_before(contacts%known_until, time_grid_of( &
        response%duration, response%samples, motion%units%time)), monitor, driven, loads)
    end associate
    if (monitor%stop_requested()) return
    if (present(loads)) then
      call show_in_segments(scene, driven, motion)
      run%rounding = rounding_in(scene, motion, driven)
    else
      call find_loaded_segments(scene, motion, monitor)
      if (monitor%stop_requested()) return
      call find_neglected(scene, motion, demand%modes, monitor, workspace, run%neglected)
    end if
    if (monitor%stop_requested()) return
    if (any(asked)) call neglected_in(scene, motion, driven, run%neglected)
    call sum_histories(scene, motion, deflections, monitor, workspace, histories)
    if (monitor%stop_requested()) return
    if (scene%response%bending_moment) call find_moments(scene, motion, monitor, workspace, histories, none)
    if (monitor%stop_requested()) return
    call add_hub_angle(scene, motion, monitor, workspace, histories%response)
    if (monitor%stop_requested()) return
    run%status = max(histories%status, none%status)
    call move_alloc(histories%response, run%response)
    call move_alloc(histories%notes, run%notes)
    if (any(asked)) call add_rates(scene, motion, driven, run%response)
  end subroutine follow_run

  subroutine find_contacts(scene, motion, demand, monitor, contacts, loads)
    !! Contacts and flights; the free motion of a beam that nothing strikes.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion       !! unresolved where the beam cannot begin as the scene asks for
    type(demand_type), intent(in) :: demand
    class(monitor_type), intent(inout) :: monitor
    type(lasting_contacts), intent(out) :: contacts
    type(placed_loads), intent(in), optional :: loads   !! N
    type(varying_beam) :: given
    type(contact_law) :: law
    type(first_motion), allocatable :: first
    real(dp) :: residual(size(scene%response%points), 3), here(1, 3)
    integer :: i, struck
    if (allocated(scene%initial) .or. present(loads) .or. bodies_change(scene)) then
      allocate (first)
      call find_first_motion(scene, alone, motion, first%q, first%rate)
      if (.not. motion%modes%resolved) return
      first%q = first%q/unit_velocity(scene)
      first%rate = first%rate/unit_velocity(scene)
      first%speed = scene%impact%approach_velocity/unit_velocity(scene)
      if (bodies_change(scene)) then
        if (allocated(scene%bodies)) then
          first%others = maxval(abs(scene%bodies%velocity), mask=.not. is_missing(scene%bodies%velocity))
          first%others = max(0.0_dp, first%others)/abs(unit_velocity(scene))
        end if
        call follow_changing_contacts(scene, motion, demand, first, monitor, contacts, loads)
        return
      end if
    end if
    associate (free => motion%modes%configuration(alone)%set, response => scene%response)
      if (scene%impact%mass_ratio == 0.0_dp .or. (scene%impact%approach_velocity == 0.0_dp .and. .not. allocated(first))) then
        allocate (contacts%events(0), contacts%event_of(0))
        contacts%segments = [segment_type(alone, count=free%count, q=spread(0.0_dp, 1, free%count), &
                                          rate=spread(0.0_dp, 1, free%count))]
        if (.not. allocated(first)) return
        contacts%segments(1)%q(:demand%modes) = first%q(:demand%modes)
        contacts%segments(1)%rate(:demand%modes) = first%rate(:demand%modes)
        return
      end if
      call whole_beam(scene, motion%units, given, struck)
      if (present(loads)) then
        call place_beside(scene, motion, alone, given, demand%modes, loads, monitor, first%loads)
        if (monitor%stop_requested()) return
      end if
      call find_residual(given, struck, free, demand%modes, [scene%impact%position], here)
      call find_residual(given, struck, free, demand%modes, response%points, residual)
      law = contact_law_of(scene%contact, motion%units, abs(unit_velocity(scene)))
      law%residual = max(0.0_dp, here(1, deflections) + arm_of(given%beam, scene%impact%position)*here(1, turns))
      call follow_lasting_contacts(free, scene%impact%mass_ratio, law, full_speed_in_plane(scene%rotation, motion%units), &
                                   demand, contacts, monitor, first)
      if (monitor%stop_requested()) return
      do i = 1, size(contacts%segments)
        if (allocated(contacts%segments(i)%load)) contacts%segments(i)%load%residual = residual
      end do
    end associate
  end subroutine find_contacts

  subroutine keep_mass(scene, motion, taking_part, contacts, monitor)
    !! The mass stays: the motion goes over to the modes of beam and mass, with displacements as they are, and with those of the modes that
    !! were not summed, which gave way to the force at once. The body keeps its indentation δ; in the plane of rotation the
    !! centrifugal force on that much, m_jω²δ, moves the equilibrium, and with tension in the beam the body's pull m_jω²(R + ξ₀), which acts
    !! δ beside the axis. It brings no spin, as one that
    !! strikes at an instant. What the contact and those modes have stored is lost.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion       !! up to the capture
    integer, intent(in) :: taking_part
    type(lasting_contacts), intent(in) :: contacts
    class(monitor_type), intent(inout), target :: monitor
    integer, parameter :: times_as_many = 4          ! modes are handed on as are summed
    type(segment_type) :: next
    type(event_type) :: event
    class(mode_set), allocatable :: before
    real(dp), allocatable :: q(:), rate(:)
    real(dp) :: speed, turned
    type(body_type), allocatable :: bodies(:)        ! the mass is the last
    real(dp) :: held(2)                              ! of the mass: its displacement and velocity at the beam
    integer :: first, mass
    event%kind = capture_event
    event%time = motion%timeline%events(size(motion%timeline%events))%end_time
    event%end_time = event%time
    event%energy_before = motion%timeline%events(size(motion%timeline%events))%energy_after
    speed = speed_in_plane(scene%rotation, motion%units)
    bodies = bodies_of(scene, motion%units)
    mass = size(contacts%state%u)
    associate (free => motion%modes%configuration(alone), loaded => motion%modes%configuration(together)%set, n => taking_part)
      call free%source%find(first_numbers(min(free%source%highest, times_as_many*free%set%count)), before, monitor=monitor)
      if (monitor%stop_requested()) return
      q = [contacts%state%u(:n), contacts%force*before%struck(n + 1:)/(before%modal_mass(n + 1:)*before%beta_squared(n + 1:)%hi)]
      rate = 0.0_dp*q
      rate(:n) = contacts%state%v(:n)
      next%configuration = together
      next%start = contacts%state%time
      next%count = loaded%count
      turned = motion%modes%configuration(together)%source%pieces%captured%inertia%hi*dot_product(before%turnings(), q)
      held = scene%impact%mass_ratio*[contacts%state%u(mass) - contacts%indentation, contacts%state%v(mass)]
      next%q = (loaded%overlap_of_beam(before, q, monitor) + held(1)*loaded%struck + turned*loaded%turnings())/loaded%modal_mass
      next%rate = (loaded%overlap_of_beam(before, rate, monitor) + held(2)*loaded%struck)/loaded%modal_mass
      next%q(n + 1:) = 0.0_dp
      next%rate(n + 1:) = 0.0_dp
      first = first_struck(loaded)
      event%momentum_before = loaded%modal_mass(first)*next%rate(first)/loaded%struck(first)
      event%momentum_after = event%momentum_before
      event%hub_rate_change = mean_rate(loaded, next%rate) - mean_rate(free%set, contacts%state%v)
      if (speed > 0.0_dp) then
        next%rest = 0.0_dp*next%q                       ! nothing turns a hub that is free
        where (loaded%beta_squared%hi /= 0.0_dp) next%rest = contacts%indentation*(scene%impact%mass_ratio*speed**2*loaded%struck &
          - bodies(size(bodies))%pull*loaded%turnings())/(loaded%modal_mass*loaded%beta_squared%hi)
        next%rest(n + 1:) = 0.0_dp
        next%q = next%q - next%rest
      end if
      event%energy_after = beam_energy(loaded, next%q, next%rate)          ! about that equilibrium
      associate (body => bodies(size(bodies)), contact => motion%timeline%events(size(motion%timeline%events)))
        if (body%pull > 0.0_dp) then                                       ! its tension finds the beam bent
          contact%energy_before = contact%energy_before + body%pull*before%energy_of_pull(body%position, q)
          contact%energy_after = contact%energy_after + body%pull*before%energy_of_pull(body%position, q)
          event%energy_before = contact%energy_after
        end if
      end associate
      next%lack = lack_type(q=0.0_dp*next%q, rate=0.0_dp*next%q)
      next%energy = event%energy_after
    end associate
    motion%timeline%segments = [motion%timeline%segments, next]
    motion%timeline%events = [motion%timeline%events, event]
    call let_go(scene, motion, taking_part, monitor)
  end subroutine keep_mass

  subroutine let_go(scene, motion, taking_part, monitor)
    !! A release after the capture, if the scene has one.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    integer, intent(in) :: taking_part
    class(monitor_type), intent(inout), target :: monitor
    integer :: i
    real(dp), allocatable :: moved(:)
    if (.not. allocated(scene%release)) return
    i = size(motion%timeline%segments)
    associate (held => motion%timeline%segments(i))
      if (scene%release%time <= held%start%hi*motion%units%time%hi) then
        call append(motion%notes, 'release: it comes before the capture, and releases nothing')
        return
      end if
      if (allocated(motion%notes)) deallocate (motion%notes)      ! those of a run with fewer modes
      call follow_motion(scene, motion, monitor)
      if (monitor%stop_requested() .or. size(motion%timeline%segments) == i) return
    end associate
    associate (held => motion%timeline%segments(i), free => motion%timeline%segments(i + 1), &
               set => motion%modes%configuration(alone)%set)
      if (allocated(held%rest)) then
        moved = set%overlap_of_beam(motion%modes%configuration(together)%set, held%rest, monitor)/set%modal_mass
        free%q = free%q + moved
      end if
      free%q(taking_part + 1:) = 0.0_dp
      free%rate(taking_part + 1:) = 0.0_dp
    end associate
  end subroutine let_go

  subroutine keep_contacts(scene, motion, contacts, run)
    !! Forces and times in SI, and the speeds of the modes after the first contact.
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
      run%initial%modal_velocity = 0.0_dp*motion%modes%configuration(alone)%set%modal_mass   ! where no force was found
      first = size(contacts%segments)                           ! the first flight, if there is one
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
