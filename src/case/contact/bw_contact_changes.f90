module bw_contact_changes
  !! Lasting contacts on a beam that bodies may join or leave. Between two changes the beam has one configuration, and contacts
  !! and flights are followed. At a change the motion is projected onto other modes; within a contact, the quasi-static
  !! deflection of omitted modes under its force is projected as well. From a capture on the mass is one of the bodies.
  use bw_acting_loads, only: acting_loads
  use bw_case_bodies, only: bodies_of, presence
  use bw_case_result, only: case_motion
  use bw_change_of_bodies, only: beam_state, body_type, change_bodies
  use bw_changing_motion, only: kind_of_change, note_late_change
  use bw_contact_bodies, only: bodies_after, first_motion
  use bw_contact_flexibility, only: flexibility_of, flexibility_type, store_residual
  use bw_contact_law, only: contact_law_of, stored_energy
  use bw_contact_steps, only: contact_run
  use bw_double_double, only: dd, to_dd, operator(-), operator(/)
  use bw_event, only: capture_event, event_type
  use bw_force_step, only: force_in_step, polynomial_of
  use bw_kinds, only: dp
  use bw_lasting_contact, only: append_segment, begin_contacts, demand_type, finish_contacts, follow_until, go_on, &
    lasting_contacts
  use bw_load_columns, only: find_drive, placed_loads
  use bw_load_course, only: loads_before
  use bw_loads_beside, only: beam_of, project_loads, modes_taking_part
  use bw_missing, only: is_missing
  use bw_mode_set, only: configuration_type, damping_rates, first_numbers, mode_set
  use bw_monitor, only: monitor_type
  use bw_oscillators, only: moving_state, oscillators, oscillators_of
  use bw_rotation, only: full_speed_in_plane, speed_in_plane
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: leaves_range, move, segment_type
  use bw_text, only: append
  use bw_timeline, only: carried_type, configurations_of, number_of, step_type, steps_of
  use bw_unprojected, only: unprojected_errors
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: follow_contacts

  type :: contact_progress
    integer :: configuration = 1
    type(carried_type) :: carried
    logical, allocatable :: there(:)                 !! bodies that the beam carries, (bodies)
    type(body_type), allocatable :: bodies(:)        !! the last is the mass if it is captured
    type(flexibility_type) :: flexibility
    type(acting_loads), allocatable :: loads         !! in terms of modes and mass; unallocated: none
    type(beam_state) :: state                        !! after the capture, at the start of its last segment
    type(contact_run) :: run
  end type contact_progress

contains

  subroutine follow_contacts(scene, motion, demand, first, monitor, contacts, loads)
    !! Follow contacts and flights from t = 0 to the end of the record.
    type(scene_type), intent(in) :: scene            !! with mode counts
    type(case_motion), intent(inout) :: motion       !! its modes are known
    type(demand_type), intent(in) :: demand
    type(first_motion), intent(inout) :: first
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(lasting_contacts), intent(out) :: contacts
    type(placed_loads), intent(in), optional :: loads   !! N; absent: none
    type(step_type), allocatable :: steps(:)
    type(contact_progress) :: now
    type(dd) :: time
    integer :: i
    if (allocated(motion%notes)) deallocate (motion%notes)          ! those of a run with fewer modes
    steps = steps_of(scene)
    now%carried = steps(1)%carried
    now%there = presence(scene, now%carried)
    now%bodies = bodies_of(scene, motion%units)
    where (.not. is_missing(now%bodies%velocity)) now%bodies%velocity = now%bodies%velocity/unit_velocity(scene)
    steps = steps(size(steps) - count(.not. (steps(2:)%is_impact .or. steps(2:)%is_capture)) + 1:)
    call find_flexibility(scene, motion, demand%modes, now, monitor, loads)
    if (monitor%stop_requested()) return
    if (allocated(now%loads)) first%loads = now%loads
    now%run%captured = nothing_strikes(scene, first)
    if (now%run%captured) then
      call start_without_mass(demand, first, now, contacts)
    else
      call begin_contacts(motion%modes%configuration(1)%set, scene%impact%mass_ratio, &
                          contact_law_of(scene%contact, motion%units, abs(unit_velocity(scene))), &
                          full_speed_in_plane(scene%rotation, motion%units), demand, size(motion%modes%configuration), now%run, &
                          contacts, first)
      now%run%law%residual = now%flexibility%here
    end if
    do i = 1, size(steps) + 1
      time = to_dd(demand%longest)
      if (i <= size(steps)) then
        if (steps(i)%seconds < scene%response%duration) time = to_dd(steps(i)%seconds)/motion%units%time
      end if
      if (.not. now%run%captured) then
        call follow_until(now%run, time%hi, contacts, monitor)
        if (monitor%stop_requested()) return
        call store_residual(now%flexibility, contacts)
        if (now%run%failed .or. now%run%cut .or. now%run%in_range < time%hi) exit
        if (now%run%captured) call capture_mass(scene, demand, motion, now, contacts, monitor, loads)
        if (monitor%stop_requested()) return
      end if
      if (i > size(steps)) exit
      if (steps(i)%seconds >= scene%response%duration) then
        call note_late_change(steps(i)%seconds, motion)
        exit
      end if
      call apply_change(scene, demand, steps(i), time, motion, now, contacts, monitor, loads)
      if (monitor%stop_requested()) return
    end do
    call finish_contacts(now%run, demand, contacts)
    contacts%captured = now%run%captured .and. .not. nothing_strikes(scene, first)
  end subroutine follow_contacts

  pure logical function nothing_strikes(scene, first) result(nothing)
    !! Tell whether the mass is 0, or nothing moves.
    type(scene_type), intent(in) :: scene
    type(first_motion), intent(in) :: first
    nothing = scene%impact%mass_ratio == 0.0_dp
    if (.not. (nothing .or. allocated(first%loads))) &
      nothing = first%speed == 0.0_dp .and. first%others == 0.0_dp .and. all(first%q == 0.0_dp) .and. all(first%rate == 0.0_dp)
  end function nothing_strikes

  pure subroutine start_without_mass(demand, first, now, contacts)
    !! Start the motion of a beam without a striking mass, at rest or not.
    type(demand_type), intent(in) :: demand
    type(first_motion), intent(in) :: first
    type(contact_progress), intent(inout) :: now
    type(lasting_contacts), intent(inout) :: contacts
    type(beam_state) :: state
    allocate (contacts%events(0), contacts%segments(0), contacts%event_of(0))
    state = beam_state(demand%modes, first%q, first%rate)
    state%q(demand%modes + 1:) = 0.0_dp
    state%rate(demand%modes + 1:) = 0.0_dp
    allocate (state%shape(0))
    call add_segment(now, state, to_dd(0.0_dp), spread(0.0_dp*first%q, 2, 2), reshape([real(dp) ::], [0, 2]), contacts)
  end subroutine start_without_mass

  subroutine find_flexibility(scene, motion, summed, now, monitor, loads)
    !! Find the residual flexibility of the current configuration under the contact force and under loads.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: summed                    !! modes summed
    type(contact_progress), intent(inout) :: now
    class(monitor_type), intent(inout) :: monitor    !! results are invalid if it requests a stop
    type(placed_loads), intent(in), optional :: loads
    now%flexibility = flexibility_of(scene, motion, now%configuration, now%carried, summed, now%bodies)
    if (present(loads)) call project_loads(scene, motion, now%configuration, beam_of(scene, motion, now%configuration), summed, &
                                          loads, monitor, now%loads, now%bodies%position, now%flexibility%of_loads)
  end subroutine find_flexibility

  subroutine apply_change(scene, demand, step, time, motion, now, contacts, monitor, loads)
    !! Apply one change: bodies that come or leave.
    type(scene_type), intent(in) :: scene
    type(demand_type), intent(in) :: demand
    type(step_type), intent(in) :: step
    type(dd), intent(in) :: time
    type(case_motion), intent(inout) :: motion
    type(contact_progress), intent(inout) :: now
    type(lasting_contacts), intent(inout) :: contacts
    class(monitor_type), intent(inout), target :: monitor
    type(placed_loads), intent(in), optional :: loads
    type(carried_type) :: carried
    type(beam_state) :: later
    type(event_type) :: event
    real(dp), allocatable :: error(:, :), beyond(:, :)
    real(dp) :: held
    integer :: i, mass
    carried = carried_type(step%carried%body, now%carried%captured .and. .not. step%is_release)
    if (step%is_release .and. .not. now%carried%captured) call append(motion%notes, &
      'release: it is before the capture, and has no effect')
    if (number_of([now%carried], carried) == 1) return
    if (now%run%captured) then
      if (.not. advance(motion, time, contacts, now, monitor)) return
      if (monitor%stop_requested()) return
    else
      now%state = state_of(now%run, modes_taking_part(motion, now%configuration, demand%modes))
    end if
    event%kind = kind_of_change(step, now%there, presence(scene, carried))
    event%time = time%hi
    call change_configuration(scene, demand, carried, time, motion, now, contacts, later, event, error, beyond, monitor, loads)
    if (monitor%stop_requested()) return
    contacts%events = [contacts%events, event]
    if (present(loads) .or. .not. now%run%captured) call find_flexibility(scene, motion, later%count, now, monitor, loads)
    if (monitor%stop_requested()) return
    if (now%run%captured) then
      call add_segment(now, later, time, error, beyond, contacts)
      return
    end if
    held = 0.0_dp
    do i = 1, size(later%shape)
      associate (set => motion%modes%configuration(later%shape(i)%configuration)%set, amplitude => later%shape(i)%amplitude)
        held = held + dot_product(set%struck(:size(amplitude)), amplitude)
      end associate
    end do
    associate (set => motion%modes%configuration(now%configuration)%set, moved => now%run%bodies%state, &
               omega => full_speed_in_plane(scene%rotation, motion%units))
      mass = size(moved%u)
      call go_on(now%run, contacts, now%configuration, set, omega, &
                 bodies_after(set, later%count, scene%impact%mass_ratio, omega, later, held, &
                              moving_state(moved%u(mass:), moved%v(mass:), time), now%loads), now%flexibility%here, error, beyond)
    end associate
    if (now%run%captured) call capture_mass(scene, demand, motion, now, contacts, monitor, loads)
  end subroutine apply_change

  pure type(beam_state) function state_of(run, count) result(state)
    !! Return the state of the beam in a contact or a flight.
    type(contact_run), intent(in) :: run
    integer, intent(in) :: count                     !! modes that take part
    state%count = count
    associate (modes => size(run%bodies%weight) - 1)
      state%q = run%bodies%state%u(:modes)
      state%rate = run%bodies%state%v(:modes)
    end associate
    allocate (state%shape(0))
    if (allocated(run%bodies%shape)) state%shape = run%bodies%shape
    state%level = run%bodies%level
  end function state_of

  subroutine change_configuration(scene, demand, carried, time, motion, now, contacts, later, event, error, beyond, monitor, loads)
    !! Project the motion onto the modes of the beam with the bodies that it carries from now on.
    type(scene_type), intent(in) :: scene
    type(demand_type), intent(in) :: demand
    type(carried_type), intent(in) :: carried
    type(dd), intent(in) :: time
    type(case_motion), intent(in) :: motion
    type(contact_progress), intent(inout) :: now
    type(lasting_contacts), intent(in) :: contacts
    type(beam_state), intent(out) :: later
    type(event_type), intent(inout) :: event
    real(dp), allocatable, intent(out) :: error(:, :), beyond(:, :)   !! see segment_type
    class(monitor_type), intent(inout), target :: monitor
    type(placed_loads), intent(in), optional :: loads
    real(dp) :: unsummed_at(size(now%bodies), 2, 2), force(2)
    real(dp) :: follows(now%state%count, 2)          ! quasi-static part of the projected modes, displacements and velocities
    real(dp), allocatable :: load(:, :)              ! loads and their rates, (loads, 2)
    real(dp), allocatable :: unsummed(:)
    type(configuration_type), allocatable :: wide(:)   ! with the next octave of modes after the change
    logical, allocatable :: is(:)
    real(dp) :: spin_squared
    integer :: count, i, l, next
    spin_squared = speed_in_plane(scene%rotation, motion%units)**2
    next = number_of(configurations_of(scene), carried)
    is = presence(scene, carried)
    force = 0.0_dp
    if (now%run%captured .neqv. now%carried%captured .or. .not. now%run%ended) force = last_force(contacts)
    unsummed_at(:, :, 1) = force(1)*now%flexibility%at_bodies
    unsummed_at(:, :, 2) = force(2)*now%flexibility%at_bodies
    associate (set => motion%modes%configuration(now%configuration)%set, n => now%state%count)
      follows = spread(set%struck(:n)/(set%modal_mass(:n)*max(set%beta_squared(:n)%hi, 1.0_dp)), 2, 2)*spread(force, 1, n)
    end associate
    if (allocated(now%loads)) then
      load = loads_before(now%loads%course, time%hi)
      associate (square => motion%modes%configuration(now%configuration)%set%beta_squared(:now%state%count)%hi)
        do l = 1, size(load, 1)
          do i = 1, 2
            unsummed_at(:, :, i) = unsummed_at(:, :, i) + load(l, i)*now%flexibility%of_loads(:, :, l)
            where (square > 1.0_dp) follows(:, i) = follows(:, i) + load(l, i)*now%loads%drive(:now%state%count, l)/square
          end do
        end do
      end associate
    end if
    associate (configuration => motion%modes%configuration)
      count = modes_taking_part(motion, next, demand%modes)
      wide = configuration
      call wide(next)%source%find(first_numbers(min(2*count, wide(next)%source%highest)), wide(next)%set, monitor=monitor)
      if (monitor%stop_requested()) return
      if (force(1) /= 0.0_dp .or. present(loads)) then
        call project_omitted(beam_of(scene, motion, now%configuration), configuration(now%configuration), now%state%count, &
                             force(1), wide(next)%set, monitor, unsummed, load, loads)
        if (monitor%stop_requested()) return
      end if
      call project_octave(wide, now, next, count, is, spin_squared, unsummed_at, unsummed, monitor, beyond)
      if (monitor%stop_requested()) return
      if (allocated(unsummed)) unsummed = unsummed(:configuration(next)%set%count)
      call change_bodies(configuration, now%configuration, now%state, now%there, next, count, is, now%bodies, spin_squared, later, &
                     event, monitor, unsummed_at, unsummed)
      if (monitor%stop_requested()) return
      associate (n => now%state%count)
        error = unprojected_errors(configuration(now%configuration)%set, now%state%q(:n) - follows(:, 1), &
                                now%state%rate(:n) - follows(:, 2), configuration(next)%set, now%bodies, now%there, is)
      end associate
    end associate
    event%end_time = event%time
    now%configuration = next
    now%carried = carried
    now%there = is
  end subroutine change_configuration

  subroutine project_octave(wide, now, next, count, is, spin_squared, unsummed_at, unsummed, monitor, beyond)
    !! Project the motion onto the next octave of modes after a change.
    type(configuration_type), intent(in) :: wide(:)  !! with that octave
    type(contact_progress), intent(in) :: now
    integer, intent(in) :: next                      !! configuration after the change
    integer, intent(in) :: count                     !! modes of it that take part
    logical, intent(in) :: is(:)                     !! bodies that the beam carries then, (bodies)
    real(dp), intent(in) :: spin_squared
    real(dp), intent(in) :: unsummed_at(:, :, :)     !! see `beyond` of `change_bodies`
    real(dp), allocatable, intent(in) :: unsummed(:) !! see `change_bodies`
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    real(dp), allocatable, intent(out) :: beyond(:, :)      !! see segment_type
    type(body_type), allocatable :: bodies(:)
    type(beam_state) :: later
    type(event_type) :: ignored
    bodies = now%bodies
    call change_bodies(wide, now%configuration, now%state, now%there, next, wide(next)%set%count, is, bodies, spin_squared, later, &
                   ignored, monitor, unsummed_at, unsummed)
    if (monitor%stop_requested()) return
    beyond = reshape([later%q(count + 1:), later%rate(count + 1:)], [size(later%q) - count, 2])
  end subroutine project_octave

  subroutine project_omitted(given, configuration, summed, force, after, monitor, unsummed, load, loads)
    !! Project the quasi-static deflection of the omitted modes onto the modes after a change.
    type(varying_beam), intent(in) :: given          !! before the change
    type(configuration_type), intent(in) :: configuration
    integer, intent(in) :: summed
    real(dp), intent(in) :: force                    !! of the contact
    class(mode_set), intent(in) :: after
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    real(dp), allocatable, intent(out) :: unsummed(:)       !! (modes after)
    real(dp), allocatable, intent(in) :: load(:, :)  !! other loads and their rates, (loads, 2)
    type(placed_loads), intent(in), optional :: loads
    integer, parameter :: times_as_many = 4          ! modes, over those summed
    class(mode_set), allocatable :: before
    real(dp), allocatable :: drive(:, :), nothing(:, :), pressed(:)
    real(dp) :: no_points(0)
    call configuration%source%find(first_numbers(min(configuration%source%highest, times_as_many*summed)), before, monitor=monitor)
    if (monitor%stop_requested()) return
    pressed = force*before%struck
    if (present(loads)) then
      allocate (nothing(before%count, 0))
      call find_drive(given, before, loads%place, loads%accelerated, monitor, drive, no_points, nothing)
      if (monitor%stop_requested()) return
      pressed = pressed + matmul(drive(:, loads%kind), load(:, 1))
    end if
    pressed(:summed) = 0.0_dp
    pressed(summed + 1:) = pressed(summed + 1:)/(before%modal_mass(summed + 1:)*before%beta_squared(summed + 1:)%hi)
    unsummed = after%overlap(before, pressed, .false., monitor)
  end subroutine project_omitted

  pure function last_force(contacts) result(force)
    !! Return the contact force and its rate at the end of the last segment; 0 in flight.
    type(lasting_contacts), intent(in) :: contacts
    real(dp) :: force(2)
    integer :: n
    force = 0.0_dp
    if (size(contacts%segments) == 0) return
    associate (last => contacts%segments(size(contacts%segments)))
      if (.not. allocated(last%load)) return
      n = size(last%load%length)
      call force_in_step(polynomial_of(last%load%force(:, n)), 1.0_dp, force(1), force(2))
      force(2) = force(2)/last%load%length(n)
    end associate
  end function last_force

  subroutine capture_mass(scene, demand, motion, now, contacts, monitor, loads)
    !! Capture the mass with its indentation. The energy stored in the contact and in omitted modes is lost.
    type(scene_type), intent(in) :: scene
    type(demand_type), intent(in) :: demand
    type(case_motion), intent(in) :: motion
    type(contact_progress), intent(inout) :: now
    type(lasting_contacts), intent(inout) :: contacts
    class(monitor_type), intent(inout), target :: monitor
    type(placed_loads), intent(in), optional :: loads
    type(event_type) :: event
    type(beam_state) :: later
    real(dp), allocatable :: error(:, :), beyond(:, :)
    real(dp) :: stored
    associate (run => now%run)
      event%kind = capture_event
      event%time = run%bodies%state%time%hi
      associate (mass => now%bodies(size(now%bodies)))
        mass%velocity = run%bodies%state%v(size(run%bodies%state%v))
        mass%beside = run%last_indentation
      end associate
      now%state = state_of(run, modes_taking_part(motion, now%configuration, demand%modes))
      stored = stored_energy(run%law, run%last_indentation) + 0.5_dp*run%law%residual*run%last_force**2
      call change_configuration(scene, demand, carried_type(now%carried%body, .true.), run%bodies%state%time, motion, now, &
                                contacts, later, event, error, beyond, monitor, loads)
      if (monitor%stop_requested()) return
      if (present(loads)) call find_flexibility(scene, motion, later%count, now, monitor, loads)
      if (monitor%stop_requested()) return
      event%energy_before = event%energy_before + stored
      if (now%bodies(size(now%bodies))%pull > 0.0_dp) then  ! its tension acts on the bent beam: the contact's balance includes it
        associate (contact => contacts%events(run%event), brought => event%energy_before - (run%bodies%energy() + stored))
          contact%energy_before = contact%energy_before + brought
          contact%energy_after = contact%energy_after + brought
        end associate
      end if
      contacts%events = [contacts%events, event]
      call add_segment(now, later, run%bodies%state%time, error, beyond, contacts)
    end associate
  end subroutine capture_mass

  logical function advance(motion, time, contacts, now, monitor) result(happens)
    !! Move the state from the last segment to a time. Returns false if it has overflowed by then: no later event happens.
    type(case_motion), intent(in) :: motion
    type(dd), intent(in) :: time
    type(lasting_contacts), intent(in) :: contacts
    type(contact_progress), intent(inout) :: now
    class(monitor_type), intent(inout) :: monitor    !! the state is invalid if it requests a stop
    associate (last => contacts%segments(size(contacts%segments)), state => now%state)
      associate (set => motion%modes%configuration(last%configuration)%set)
        happens = .not. leaves_range(set, time - last%start)
        if (.not. happens) return
        if (allocated(now%loads)) then
          call drive(set, now%loads, last%start, time, state, monitor)
        else
          call move(set, time - last%start, state%q, state%rate)
        end if
      end associate
    end associate
  end function advance

  subroutine drive(set, loads, start, until, state, monitor)
    !! Move the state under loads from one time to another.
    class(mode_set), intent(in) :: set
    type(acting_loads), intent(in) :: loads
    type(dd), intent(in) :: start, until
    type(beam_state), intent(inout) :: state
    class(monitor_type), intent(inout) :: monitor
    type(acting_loads) :: acting
    type(moving_state) :: moved
    type(oscillators) :: parts
    type(dd) :: next
    parts = oscillators_of(set%beta_squared, damping_rates(set))
    acting = loads
    acting%drive = loads%drive(:set%count, :)        ! no mass beside the beam
    acting%drive(state%count + 1:, :) = 0.0_dp
    call acting%begin(parts)
    moved = moving_state(state%q, state%rate, start)
    do while (moved%time%hi < until%hi)
      if (monitor%stop_requested()) return
      next = to_dd(acting%calm_until(moved%time%hi))
      if (next%hi >= until%hi) next = until
      associate (length => next - moved%time)
        call acting%move(parts, length%hi, moved)
      end associate
      moved%time = next
    end do
    state%q = moved%u
    state%rate = moved%v
  end subroutine drive

  pure subroutine add_segment(now, later, time, error, beyond, contacts)
    !! Append a segment of free motion about the equilibrium.
    type(contact_progress), intent(inout) :: now
    type(beam_state), intent(in) :: later
    type(dd), intent(in) :: time
    real(dp), intent(in) :: error(:, :), beyond(:, :)   !! see segment_type
    type(lasting_contacts), intent(inout) :: contacts
    type(segment_type) :: segment
    now%state = later
    segment = segment_type(now%configuration, time, count=size(later%q), q=later%q, rate=later%rate)
    if (size(later%shape) > 0) segment%shape = later%shape
    segment%error = error
    segment%beyond = beyond
    call append_segment(contacts, segment, 0)
  end subroutine add_segment

end module bw_contact_changes
