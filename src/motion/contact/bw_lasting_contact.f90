module bw_lasting_contact
  !! Lasting contacts and the flights between them, to the end of the record.
  !!
  !! In a contact the force is a polynomial in each step through values at Chebyshev points that obey the contact law
  !! (bw_contact_law); in between all oscillators move exactly (bw_force_step). Steps are a unit of time over powers of
  !! two, so that operators are computed once; the unit is what the tolerance allows for a smooth force. A force that
  !! starts or ends as t^(3/2) is not a polynomial: steps grow from the shortest, unless the force starts from rest, and
  !! shrink to it at the end of the contact, controlled by the last coefficients of the force. The error of the last
  !! step, 1e-7 of the contact, is below rounding. A contact no deeper than the rounding of the gap is not an event.
  !!
  !! A flight is exact, and the search for its end misses no contact (bw_signal). At a change of bodies contacts and flights are
  !! interrupted: `follow_until` ends there, and `go_on` continues with the state of the modes after it. Units of bw_segment.
  use bw_contact_bodies, only: bodies_of, contact_bodies, first_motion
  use bw_contact_force, only: find_largest
  use bw_contact_law, only: contact_law, undamped_force, stored_energy, contact_with_fixed_point
  use bw_contact_steps, only: contact_run, most_halvings, step_through_contact
  use bw_double_double, only: dd, operator(+)
  use bw_event, only: contact_event, event_type
  use bw_force_response, only: force_degree
  use bw_force_step, only: force_step, step_end
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, stops
  use bw_segment, only: growth_ends, largest_exponent, load_type, segment_type

  implicit none (type, external)
  private
  public :: append_segment, begin_contacts, finish_contacts, follow_until, go_on, load_of

  type, public :: demand_type
    !! What is requested of a run with contacts.
    integer :: modes = 0                          !! modes that take part
    integer :: most_contacts = 1
    real(dp) :: longest = 0.0_dp                  !! the record, l²/h
    real(dp) :: tolerance = 1.0e-9_dp             !! error of a polynomial at its points over the largest force
    logical :: captures = .false.                 !! the mass stays from the first largest indentation on
  end type demand_type

  type, public :: lasting_contacts
    !! Events and segments with contacts, and the motion of the mass.
    type(event_type), allocatable :: events(:)    !! contacts and changes of the beam by their start, times in l²/h
    type(segment_type), allocatable :: segments(:)   !! contacts and flights, in order
    integer, allocatable :: event_of(:)           !! event of each; 0: a flight, (segments)
    type(step_end), allocatable :: ladder(:, :)   !! step operators of contacts, (0:levels, configurations)
    real(dp) :: approach = 0.0_dp                 !! closing speed at the first contact, V
    real(dp) :: restitution = missing             !! separation over closing speed, first contact
    real(dp) :: leaving = missing                 !! velocity of the mass after the last finished contact, V
    real(dp) :: largest_indentation = 0.0_dp      !! V l²/h
    real(dp) :: known_until = huge(1.0_dp)        !! the motion is unknown from then on
    logical :: out_of_range = .false.             !! because it overflows
    logical :: cut = .false.                      !! because there are more contacts than requested
    logical :: lasting = .false.                  !! the last contact outlasts the record
    logical :: failed = .false.                   !! no force obeys the contact law
    logical :: captured = .false.                 !! the mass stayed at the end of the last contact
  end type lasting_contacts

contains

  subroutine begin_contacts(free, mass_ratio, law, omega, demand, configurations, run, contacts, first)
    !! Start a run with contacts.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: mass_ratio
    type(contact_law), intent(in) :: law
    type(dd), intent(in) :: omega
    type(demand_type), intent(in) :: demand
    integer, intent(in) :: configurations         !! upper limit
    type(contact_run), intent(out) :: run
    type(lasting_contacts), intent(out) :: contacts
    type(first_motion), intent(in), optional :: first   !! absent: the mass arrives with velocity 1 at a beam at rest
    real(dp) :: pace                              ! estimate of closing speeds
    run%bodies = bodies_of(free, demand%modes, mass_ratio, omega, first)
    run%law = law
    pace = 1.0_dp
    if (present(first)) pace = hypot(run%bodies%pace(), first%others)
    call contact_with_fixed_point(law, mass_ratio, pace, run%unit, run%typical)
    run%unit = run%unit/pace*demand%tolerance**(1.0_dp/(force_degree + 1))
    run%tolerance = demand%tolerance
    run%captures = demand%captures
    run%most_contacts = demand%most_contacts
    run%typical = 1.0e-3_dp*run%typical           ! negligible contacts
    run%in_range = range_of(free, omega)
    allocate (contacts%events(0), contacts%segments(0), contacts%event_of(0), contacts%ladder(0:most_halvings, configurations))
    run%ended = .true.
    call check_closing(run)
  end subroutine begin_contacts

  pure real(dp) function range_of(modes, omega) result(time)
    !! Return the time until a motion of modes, or of a free mass, overflows.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: omega
    time = growth_ends(modes)
    if (omega%hi > 0.0_dp) time = min(time, largest_exponent/omega%hi)
  end function range_of

  pure subroutine check_closing(run)
    !! Return whether a mass that touches the beam is pressed into it at once.
    type(contact_run), intent(inout) :: run
    run%found = run%bodies%separation() < 0.0_dp
    if (allocated(run%bodies%loads)) run%found = run%found .and. run%bodies%loads%gap(0.0_dp, 0) <= 0.0_dp
  end subroutine check_closing

  subroutine follow_until(run, until, contacts, monitor)
    !! Follow contacts and flights up to a time.
    type(contact_run), intent(inout) :: run
    real(dp), intent(in) :: until
    type(lasting_contacts), intent(inout) :: contacts
    class(monitor_type), intent(inout), optional :: monitor   !! results are invalid if it requests a stop
    type(segment_type) :: segment
    run%last = min(until, run%in_range)
    if (run%captured .or. run%last <= run%bodies%state%time%hi) return
    run%goes_on = .not. run%ended
    do
      if (run%found) call add_contact(run, contacts, monitor)
      if (stops(monitor) .or. run%failed .or. run%captured .or. .not. run%ended) return
      call start_segment(run, segment)
      call run%bodies%fly(run%law%damping, run%last, run%found, monitor)
      if (stops(monitor)) return
      call append_segment(contacts, segment, 0)
      if (.not. run%found) return
      run%cut = run%contacts == run%most_contacts
      if (run%cut) return
    end do
  end subroutine follow_until

  pure subroutine append_segment(contacts, segment, event)
    type(lasting_contacts), intent(inout) :: contacts
    type(segment_type), intent(in) :: segment
    integer, intent(in) :: event                  !! of the segment, or 0
    contacts%segments = [contacts%segments, segment]
    contacts%event_of = [contacts%event_of, event]
  end subroutine append_segment

  pure subroutine go_on(run, contacts, configuration, modes, omega, bodies, residual, error, beyond)
    !! Continue with other modes after a change of the beam. Gains of a current contact are attributed to the change.
    !! The force follows from the gap, which omitted modes may affect, with its factor 1 + cδ̇ before the change.
    type(contact_run), intent(inout) :: run
    type(lasting_contacts), intent(inout) :: contacts
    integer, intent(in) :: configuration
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: omega
    type(contact_bodies), intent(in) :: bodies
    real(dp), intent(in) :: residual              !! of these modes
    real(dp), intent(in) :: error(:, :), beyond(:, :)   !! see segment_type
    type(contact_law) :: law
    real(dp) :: before(3)
    before = balance_of(run)
    call keep_ladder(run, contacts)
    run%configuration = configuration
    run%bodies = bodies
    run%law%residual = residual
    run%error = error
    run%beyond = beyond
    run%in_range = bodies%state%time%hi + range_of(modes, omega)
    run%changed = .true.
    if (.not. run%ended) then
      run%found = .true.
      law = run%law
      if (law%damping > 0.0_dp) law%stiffness = run%last_force/max(run%last_indentation, tiny(residual))**law%exponent
      run%last_force = undamped_force(law, -bodies%gap())
      run%last_indentation = -bodies%gap() - residual*run%last_force
      run%gained = run%gained + (balance_of(run) - before)
      run%captured = run%captures .and. run%bodies%separation() >= 0.0_dp   ! past its largest indentation
    else if (bodies%state%time%hi <= 0.0_dp) then
      call check_closing(run)
    else
      run%found = bodies%gap() < 0.0_dp
    end if
  end subroutine go_on

  pure function balance_of(run) result(balance)
    !! Return energy, momentum and hub rate, with the energy stored in a current contact and in omitted modes.
    type(contact_run), intent(in) :: run
    real(dp) :: balance(3)
    balance = [run%bodies%energy(), run%bodies%momentum(), run%bodies%hub_rate()]
    if (run%captured .or. .not. run%ended) balance(1) = balance(1) + stored_energy(run%law, run%last_indentation) &
      + 0.5_dp*run%law%residual*run%last_force**2
  end function balance_of

  pure subroutine keep_ladder(run, contacts)
    !! Store the operators of steps in use. Other modes need new ones.
    type(contact_run), intent(inout) :: run
    type(lasting_contacts), intent(inout) :: contacts
    type(force_step) :: none
    integer :: i
    do i = 0, most_halvings
      if (run%ladder(i)%length > 0.0_dp) contacts%ladder(i, run%configuration) = run%ladder(i)%step_end
      run%ladder(i) = none
    end do
  end subroutine keep_ladder

  subroutine finish_contacts(run, demand, contacts)
    !! Record how the contacts ended.
    type(contact_run), intent(inout) :: run
    type(demand_type), intent(in) :: demand
    type(lasting_contacts), intent(inout) :: contacts
    call keep_ladder(run, contacts)
    contacts%cut = run%cut
    contacts%failed = run%failed
    contacts%captured = run%captured
    contacts%largest_indentation = run%indentation
    if (run%captured) return
    contacts%out_of_range = .not. (contacts%cut .or. run%failed) .and. run%in_range < demand%longest
    contacts%lasting = .not. (run%ended .or. contacts%out_of_range)
    if (contacts%cut .or. contacts%out_of_range .or. run%failed) contacts%known_until = run%bodies%state%time%hi
  end subroutine finish_contacts

  pure subroutine start_segment(run, segment)
    !! Start a segment from the current state.
    type(contact_run), intent(inout) :: run
    type(segment_type), intent(out) :: segment
    associate (state => run%bodies%state, count => size(run%bodies%weight) - 1)
      segment = segment_type(run%configuration, state%time, count=count, q=state%u(:count), rate=state%v(:count))
    end associate
    if (allocated(run%bodies%shape)) segment%shape = run%bodies%shape
    if (allocated(run%error)) call move_alloc(run%error, segment%error)
    if (allocated(run%beyond)) call move_alloc(run%beyond, segment%beyond)
  end subroutine start_segment

  subroutine add_contact(run, contacts, monitor)
    !! Follow one contact, which adds an event and a segment, or continue one, which adds a segment.
    type(contact_run), intent(inout) :: run
    type(lasting_contacts), intent(inout) :: contacts
    class(monitor_type), intent(inout), optional :: monitor
    type(segment_type) :: segment
    type(event_type) :: event
    real(dp) :: balance(3), unseen                ! indentation below the errors of modal sums or steps
    call start_segment(run, segment)
    unseen = max(run%bodies%rounding(), (run%tolerance*run%typical/run%law%stiffness)**(1.0_dp/run%law%exponent))
    if (run%goes_on) then
      event = contacts%events(run%event)
    else
      run%approach = -run%bodies%separation()
      run%gained = 0.0_dp
      run%impulse = 0.0_dp
      run%deepest = 0.0_dp
      event%kind = contact_event
      event%time = run%bodies%state%time%hi
      event%energy_before = run%bodies%energy()
      event%momentum_before = run%bodies%momentum()
      run%rate_before = run%bodies%hub_rate()
    end if
    allocate (segment%load)
    segment%load%taking_part = count_taking_part(run%bodies)
    call step_through_contact(run, segment%load, monitor)
    if (stops(monitor) .or. run%failed) return
    run%indentation = max(run%indentation, run%deepest)
    if (run%ended .and. run%deepest <= unseen .and. .not. (run%goes_on .or. run%captured)) then
      call append_segment(contacts, segment, 0)
      return
    end if
    if (.not. run%goes_on) then
      run%contacts = run%contacts + 1
      contacts%events = [contacts%events, event]
      run%event = size(contacts%events)
      if (run%contacts == 1) contacts%approach = run%approach
    end if
    run%goes_on = .false.
    call append_segment(contacts, segment, run%event)
    event%end_time = run%end_time%hi
    event%impulse = run%impulse
    balance = balance_of(run) - run%gained
    event%energy_after = balance(1)
    event%momentum_after = balance(2)
    event%hub_rate_change = balance(3) - run%rate_before
    call find_largest(load_of(contacts, run%event), event%largest_force, event%largest_force_time)
    event%largest_force_time = event%largest_force_time + event%time
    if (run%contacts == 1 .and. run%ended .and. .not. run%captured .and. run%approach > 0.0_dp) &
      contacts%restitution = run%bodies%separation()/run%approach
    contacts%leaving = missing
    if (run%ended .and. .not. run%captured) contacts%leaving = run%bodies%state%v(size(run%bodies%state%v))
    contacts%events(run%event) = event
  end subroutine add_contact

  pure type(load_type) function load_of(contacts, event) result(load)
    !! Return the steps of a contact over all its segments.
    type(lasting_contacts), intent(in) :: contacts
    integer, intent(in) :: event
    integer :: i
    allocate (load%length(0), load%force(0:force_degree, 0))
    do i = 1, size(contacts%segments)
      if (contacts%event_of(i) /= event) cycle
      associate (part => contacts%segments(i)%load)
        load%length = [load%length, part%length]
        load%force = reshape([load%force, part%force], [force_degree + 1, size(load%length)])
      end associate
    end do
  end function load_of

  pure integer function count_taking_part(bodies) result(count)
    !! Return the last mode that takes part.
    type(contact_bodies), intent(in) :: bodies
    count = findloc(abs(bodies%weight(:size(bodies%weight) - 1)) > 0.0_dp, .true., dim=1, back=.true.)
  end function count_taking_part

end module bw_lasting_contact
