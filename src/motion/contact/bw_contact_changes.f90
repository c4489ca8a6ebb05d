module bw_contact_changes
  !! Lasting contacts on a beam that bodies may join or leave. Between two changes the beam has one configuration, and contacts
  !! and flights are followed. At a change the motion is projected onto other modes (bw_contact_projection). From a
  !! capture on the mass is one of the bodies.
  use bw_acting_loads, only: acting_loads
  use bw_beam_motion, only: beam_motion
  use bw_case_bodies, only: beam_of, bodies_of, presence
  use bw_change_of_bodies, only: beam_state
  use bw_changing_motion, only: kind_of_change, note_late_change
  use bw_contact_bodies, only: bodies_after, first_motion
  use bw_contact_flexibility, only: flexibility_of, store_residual
  use bw_contact_law, only: contact_law_of, stored_energy
  use bw_contact_projection, only: change_configuration, contact_progress
  use bw_contact_steps, only: contact_run
  use bw_double_double, only: dd, to_dd, operator(-), operator(/)
  use bw_event, only: capture_event, event_type
  use bw_kinds, only: dp
  use bw_lasting_contact, only: append_segment, begin_contacts, demand_type, finish_contacts, follow_until, go_on, &
    lasting_contacts
  use bw_loads_beside, only: project_loads, modes_taking_part
  use bw_missing, only: is_missing
  use bw_mode_set, only: damping_rates, mode_set
  use bw_monitor, only: monitor_type
  use bw_oscillators, only: moving_state, oscillators, oscillators_of
  use bw_placed_loads, only: placed_loads
  use bw_rotation, only: full_speed_in_plane
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: leaves_range, move, segment_type
  use bw_text, only: append
  use bw_timeline, only: carried_type, number_of, step_type, steps_of, time_of
  implicit none (type, external)
  private
  public :: follow_contacts

contains

  subroutine follow_contacts(scene, motion, demand, first, monitor, contacts, loads)
    !! Follow contacts and flights from t = 0 to the end of the record.
    type(scene_type), intent(in) :: scene            !! with mode counts
    class(beam_motion), intent(inout) :: motion      !! its modes are known
    type(demand_type), intent(in) :: demand
    type(first_motion), intent(inout) :: first
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(lasting_contacts), intent(out) :: contacts
    type(placed_loads), intent(in), optional :: loads   !! N; absent: none
    type(step_type), allocatable :: steps(:)
    type(contact_progress) :: now
    type(dd) :: time
    integer :: i
    now%summed = demand%modes
    if (present(loads)) now%placed = loads
    if (allocated(motion%notes)) deallocate (motion%notes)          ! those of a run with fewer modes
    steps = steps_of(scene)
    now%carried = steps(1)%carried
    now%there = presence(scene, now%carried)
    now%bodies = bodies_of(scene, motion%units)
    where (.not. is_missing(now%bodies%velocity)) now%bodies%velocity = now%bodies%velocity/unit_velocity(scene)
    steps = steps(size(steps) - count(.not. (steps(2:)%is_impact .or. steps(2:)%is_capture)) + 1:)
    call find_flexibility(scene, motion, now%summed, now, monitor)
    if (monitor%stop_requested()) return
    if (allocated(now%loads)) first%loads = now%loads
    now%run%captured = nothing_strikes(scene, first)
    if (now%run%captured) then
      call start_without_mass(first, now, contacts)
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
        if (steps(i)%seconds < scene%response%duration) time = time_of(steps(i), motion%units)
      end if
      if (.not. now%run%captured) then
        call follow_until(now%run, time%hi, contacts, monitor)
        if (monitor%stop_requested()) return
        call store_residual(now%flexibility, contacts)
        if (now%run%failed .or. now%run%cut .or. now%run%in_range < time%hi) exit
        if (now%run%captured) call capture_mass(scene, motion, now, contacts, monitor)
        if (monitor%stop_requested()) return
      end if
      if (i > size(steps)) exit
      if (steps(i)%seconds >= scene%response%duration) then
        call note_late_change(steps(i)%seconds, motion)
        exit
      end if
      call apply_change(scene, steps(i), time, motion, now, contacts, monitor)
      if (monitor%stop_requested()) return
    end do
    call finish_contacts(now%run, demand, contacts)
    contacts%captured = now%run%captured .and. .not. nothing_strikes(scene, first)
  end subroutine follow_contacts

  pure logical function nothing_strikes(scene, first) result(nothing)
    !! Return whether the mass is 0, or nothing moves.
    type(scene_type), intent(in) :: scene
    type(first_motion), intent(in) :: first
    nothing = scene%impact%mass_ratio == 0.0_dp
    if (.not. (nothing .or. allocated(first%loads))) &
      nothing = first%speed == 0.0_dp .and. first%others == 0.0_dp .and. all(first%q == 0.0_dp) .and. all(first%rate == 0.0_dp)
  end function nothing_strikes

  pure subroutine start_without_mass(first, now, contacts)
    !! Start the motion of a beam without a striking mass, at rest or not.
    type(first_motion), intent(in) :: first
    type(contact_progress), intent(inout) :: now
    type(lasting_contacts), intent(inout) :: contacts
    allocate (contacts%events(0), contacts%segments(0), contacts%event_of(0))
    now%state = beam_state(now%summed, first%q, first%rate)
    now%state%q(now%summed + 1:) = 0.0_dp
    now%state%rate(now%summed + 1:) = 0.0_dp
    allocate (now%state%shape(0), now%beyond(0, 2))
    now%error = spread(0.0_dp*first%q, 2, 2)
    call add_segment(now, to_dd(0.0_dp), contacts)
  end subroutine start_without_mass

  subroutine find_flexibility(scene, motion, summed, now, monitor)
    !! Find the residual flexibility of the current configuration under the contact force and under loads.
    type(scene_type), intent(in) :: scene
    class(beam_motion), intent(in) :: motion
    integer, intent(in) :: summed                    !! modes summed
    type(contact_progress), intent(inout) :: now
    class(monitor_type), intent(inout) :: monitor    !! results are invalid if it requests a stop
    now%flexibility = flexibility_of(scene, motion, now%configuration, now%carried, summed, now%bodies)
    if (allocated(now%placed)) call project_loads(scene, motion, now%configuration, beam_of(scene, motion%units, now%carried), &
                                       summed, now%placed, monitor, now%loads, now%bodies%position, now%flexibility%of_loads)
  end subroutine find_flexibility

  subroutine apply_change(scene, step, time, motion, now, contacts, monitor)
    !! Apply one change: bodies that come or leave.
    type(scene_type), intent(in) :: scene
    type(step_type), intent(in) :: step
    type(dd), intent(in) :: time
    class(beam_motion), intent(inout) :: motion
    type(contact_progress), intent(inout) :: now
    type(lasting_contacts), intent(inout) :: contacts
    class(monitor_type), intent(inout), target :: monitor
    type(carried_type) :: carried
    type(event_type) :: event
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
      now%state = state_of(now%run, modes_taking_part(motion, now%configuration, now%summed))
    end if
    event%kind = kind_of_change(step, now%there, presence(scene, carried))
    event%time = time%hi
    call change_configuration(scene, carried, time, motion, now, contacts, event, monitor)
    if (monitor%stop_requested()) return
    contacts%events = [contacts%events, event]
    if (allocated(now%placed) .or. .not. now%run%captured) call find_flexibility(scene, motion, now%state%count, now, monitor)
    if (monitor%stop_requested()) return
    if (now%run%captured) then
      call add_segment(now, time, contacts)
      return
    end if
    held = 0.0_dp
    do i = 1, size(now%state%shape)
      associate (term => now%state%shape(i))
        held = held + dot_product(motion%modes%configuration(term%configuration)%set%struck(:size(term%amplitude)), term%amplitude)
      end associate
    end do
    associate (set => motion%modes%configuration(now%configuration)%set, moved => now%run%bodies%state, &
               omega => full_speed_in_plane(scene%rotation, motion%units))
      mass = size(moved%u)
      call go_on(now%run, contacts, now%configuration, set, omega, &
                 bodies_after(set, now%state%count, scene%impact%mass_ratio, omega, now%state, held, &
                              moving_state(moved%u(mass:), moved%v(mass:), time), now%loads), now%flexibility%here, now%error, &
                 now%beyond)
    end associate
    if (now%run%captured) call capture_mass(scene, motion, now, contacts, monitor)
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

  subroutine capture_mass(scene, motion, now, contacts, monitor)
    !! Capture the mass with its indentation. The energy stored in the contact and in omitted modes is lost.
    type(scene_type), intent(in) :: scene
    class(beam_motion), intent(in) :: motion
    type(contact_progress), intent(inout) :: now
    type(lasting_contacts), intent(inout) :: contacts
    class(monitor_type), intent(inout), target :: monitor
    type(event_type) :: event
    real(dp) :: stored
    associate (run => now%run)
      event%kind = capture_event
      event%time = run%bodies%state%time%hi
      associate (mass => now%bodies(size(now%bodies)))
        mass%velocity = run%bodies%state%v(size(run%bodies%state%v))
        mass%beside = run%last_indentation
      end associate
      now%state = state_of(run, modes_taking_part(motion, now%configuration, now%summed))
      stored = stored_energy(run%law, run%last_indentation) + 0.5_dp*run%law%residual*run%last_force**2
      call change_configuration(scene, carried_type(now%carried%body, .true.), run%bodies%state%time, motion, now, contacts, &
                                event, monitor)
      if (monitor%stop_requested()) return
      if (allocated(now%placed)) call find_flexibility(scene, motion, now%state%count, now, monitor)
      if (monitor%stop_requested()) return
      event%energy_before = event%energy_before + stored
      if (now%bodies(size(now%bodies))%pull > 0.0_dp) then  ! its tension acts on the bent beam: the contact's balance includes it
        associate (contact => contacts%events(run%event), brought => event%energy_before - (run%bodies%energy() + stored))
          contact%energy_before = contact%energy_before + brought
          contact%energy_after = contact%energy_after + brought
        end associate
      end if
      contacts%events = [contacts%events, event]
      call add_segment(now, run%bodies%state%time, contacts)
    end associate
  end subroutine capture_mass

  logical function advance(motion, time, contacts, now, monitor) result(happens)
    !! Move the state from the last segment to a time. Returns false if it has overflowed by then: no later event happens.
    class(beam_motion), intent(in) :: motion
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

  pure subroutine add_segment(now, time, contacts)
    !! Append a segment of free motion about the equilibrium.
    type(contact_progress), intent(in) :: now
    type(dd), intent(in) :: time
    type(lasting_contacts), intent(inout) :: contacts
    type(segment_type) :: segment
    segment = segment_type(now%configuration, time, count=size(now%state%q), q=now%state%q, rate=now%state%rate)
    if (size(now%state%shape) > 0) segment%shape = now%state%shape
    segment%error = now%error
    segment%beyond = now%beyond
    call append_segment(contacts, segment, 0)
  end subroutine add_segment

end module bw_contact_changes
