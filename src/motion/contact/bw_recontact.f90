module bw_recontact
  !! A mass that rebounded strikes the tip again: contacts in order, each an impact with restitution e, to the end of
  !! the record. Contacts at ever shorter intervals become a lasting one: beam and mass then move in the modes of
  !! bw_contact_modes until the force between them vanishes.
  !!
  !! Contacts amplify errors at least twofold, like a mass bouncing off a moving body. So the motion is followed with an
  !! ensemble of neighbours (bw_neighbours), as long as it is known: the tip's displacement has three digits, and all
  !! neighbours behave alike. It ends before a contact beyond the requested number.
  !!
  !! The gap is v_tip − y ≥ 0. Units of bw_segment: times in l²/h, velocities in V, displacements in V l²/h.
  use bw_contact_modes, only: contact_set, find_contact_modes
  use bw_contact_motion, only: contact_motion, motion_of
  use bw_contact_segments, only: elapsed, follow_contact, follow_flight, rebound_error, mass_stays
  use bw_double_double, only: dd
  use bw_event, only: contact_event, event_type, impact_event, no_event
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, stops
  use bw_neighbours, only: errors_of, lags_of, neighbours, scatter_type
  use bw_oscillators, only: moving_state
  use bw_segment, only: alone, growth_ends, largest_exponent, segment_type, together
  implicit none (type, external)
  private
  public :: follow_contacts

  type, public :: contacts_type
    !! Contacts and segments, and how they end.
    type(event_type), allocatable :: events(:)       !! contacts, in order
    type(segment_type), allocatable :: segments(:)   !! in order
    type(contact_set), allocatable :: modes          !! unallocated: no lasting contact
    real(dp) :: known_until = huge(1.0_dp)        !! the motion is unknown from then on
    logical :: out_of_range = .false.             !! because it overflows
    logical :: cut = .false.                      !! because there are more contacts than requested
    logical :: lasting = .false.                  !! the last contact outlasts the record
    real(dp) :: amplification = 1.0_dp            !! of relative input errors, by the contacts
    real(dp), private :: largest_deflection = 0.0_dp            !! largest displacement of the tip so far
  end type contacts_type

  type :: ensemble_type
    !! The motion, number 0, and its neighbours.
    type(contact_motion) :: run(0:neighbours)
    type(moving_state) :: from(0:neighbours), to(0:neighbours)   !! ends of a segment, in its modes
    logical :: ended(0:neighbours) = .false.      !! before the end of the search
    type(scatter_type) :: scatter
    real(dp) :: last = 0.0_dp                     !! end of the search
  end type ensemble_type

contains

  subroutine follow_contacts(free, mass_ratio, restitution, omega, longest, most, contacts, monitor)
    !! Follow the motion from the impact on; the mass arrives at a beam at rest.
    class(mode_set), intent(in) :: free           !! modes of the beam alone, accurate for any duration
    real(dp), intent(in) :: mass_ratio            !! γ > 0
    real(dp), intent(in) :: restitution           !! e
    type(dd), intent(in) :: omega                 !! angular velocity in the plane of the motion, else 0
    real(dp), intent(in) :: longest               !! the record
    integer, intent(in) :: most                   !! limit of contacts
    type(contacts_type), intent(out) :: contacts
    class(monitor_type), intent(inout), optional :: monitor   !! results are invalid if it requests a stop
    type(ensemble_type) :: ensemble
    type(event_type) :: event
    ensemble%run(0) = motion_of(free, mass_ratio, restitution, omega)
    call ensemble%scatter%vary(free, ensemble%run)
    ensemble%last = min(longest, growth_ends(free))
    if (omega%hi > 0.0_dp) ensemble%last = min(ensemble%last, largest_exponent/omega%hi)
    allocate (contacts%events(0), contacts%segments(0))
    ensemble%from = ensemble%run%state
    ensemble%to = ensemble%from
    call strike(ensemble, event)
    event = event_type(impact_event, energy_before=event%energy_after, momentum_before=event%momentum_after)    ! listed elsewhere
    do
      call add_contact(free, ensemble, longest, event, contacts, monitor)
      if (stops(monitor) .or. contacts%known_until < huge(longest) .or. contacts%lasting) exit
      call add_flight(free%struck, ensemble, event, most, contacts, monitor)
      if (stops(monitor) .or. contacts%known_until < huge(longest) .or. .not. ensemble%ended(0)) exit
      call strike(ensemble, event)
    end do
    if (contacts%known_until == huge(longest) .and. ensemble%last < longest) then
      contacts%out_of_range = .true.
      contacts%known_until = ensemble%last
      if (contacts%lasting) contacts%events = contacts%events(:size(contacts%events) - 1)     ! drop the last, which ends later
      contacts%lasting = .false.
    end if
  end subroutine follow_contacts

  subroutine strike(ensemble, event)
    !! Apply an impact, which ends the event unless the mass stays.
    type(ensemble_type), intent(inout) :: ensemble
    type(event_type), intent(out) :: event
    real(dp) :: before(ensemble%run(0)%modes + 1, 2), impulse
    integer :: i
    event%kind = contact_event
    event%time = ensemble%run(0)%state%time%hi
    event%time_error = largest_lag(ensemble)
    event%energy_before = ensemble%run(0)%energy()
    event%momentum_before = ensemble%run(0)%momentum()
    before = extent_of(ensemble, alone)
    do i = neighbours, 0, -1
      call ensemble%run(i)%strike(impulse)
    end do
    ensemble%to = ensemble%run%state
    call ensemble%scatter%blur(max(before, extent_of(ensemble, alone)), ensemble%run)
    event%impulse = impulse
    call end_event(ensemble, event)
  end subroutine strike

  pure subroutine end_event(ensemble, event)
    !! Record the state after an event.
    type(ensemble_type), intent(in) :: ensemble
    type(event_type), intent(inout) :: event
    event%end_time = ensemble%run(0)%state%time%hi
    event%end_error = largest_lag(ensemble)
    event%energy_after = ensemble%run(0)%energy()
    event%momentum_after = ensemble%run(0)%momentum()
  end subroutine end_event

  subroutine add_contact(free, ensemble, longest, event, contacts, monitor)
    !! Follow a lasting contact, if the mass stays after an impact: this adds an event and a segment. Sets `known_until`
    !! if staying, or its end, is uncertain.
    class(mode_set), intent(in) :: free
    type(ensemble_type), intent(inout) :: ensemble
    real(dp), intent(in) :: longest               !! the whole record
    type(event_type), intent(inout) :: event      !! of the impact; `no_event` if it is over
    type(contacts_type), intent(inout) :: contacts
    class(monitor_type), intent(inout), optional :: monitor
    type(segment_type) :: segment
    real(dp) :: impulse
    logical :: stays(0:neighbours)
    integer :: i
    stays = [(mass_stays(ensemble%run(i), longest), i=0, neighbours)]
    ensemble%from = ensemble%run%state
    if (any(stays .neqv. stays(0))) contacts%known_until = earliest(ensemble%from)
    if (.not. all(stays)) return
    if (.not. allocated(contacts%modes)) then
      allocate (contacts%modes)
      call find_contact_modes(free, ensemble%run(0), contacts%modes, monitor)
      if (stops(monitor)) return
      call ensemble%scatter%press(contacts%modes, ensemble%run)
    end if
    call ensemble%scatter%push(rebound_error(ensemble%run(0)), ensemble%run)
    do i = neighbours, 0, -1
      call follow_contact(ensemble%run(i), contacts%modes, ensemble%last, ensemble%from(i), ensemble%to(i), impulse, &
                          ensemble%ended(i), monitor)
    end do
    segment = segment_of(ensemble, together, contacts%modes%count)
    call check_accuracy(contacts%modes%struck, ensemble, together, segment, contacts)
    if (any(ensemble%ended .neqv. ensemble%ended(0))) contacts%known_until = earliest(ensemble%from)
    if (contacts%known_until < huge(longest)) return
    associate (motion => ensemble%run(0))
      call ensemble%scatter%blur(motion%parts(alone)%extent(motion%state%u, motion%state%v, &
                                                           elapsed(ensemble%from(0), ensemble%to(0))), ensemble%run)
    end associate
    event%kind = contact_event
    event%impulse = event%impulse + impulse
    call end_event(ensemble, event)
    contacts%lasting = .not. ensemble%ended(0)
    contacts%segments = [contacts%segments, segment]
    contacts%events = [contacts%events, event]
    event%kind = no_event
  end subroutine add_contact

  subroutine add_flight(tip, ensemble, event, most, contacts, monitor)
    !! Follow a flight: this adds a segment, and the event of the impact before it. Sets `known_until` if the flight or
    !! its end is uncertain.
    real(dp), intent(in) :: tip(:)                !! Φ_k(1) of the beam alone, (modes)
    type(ensemble_type), intent(inout) :: ensemble
    type(event_type), intent(in) :: event         !! listed if it is a contact
    integer, intent(in) :: most                   !! limit of contacts
    type(contacts_type), intent(inout) :: contacts
    class(monitor_type), intent(inout), optional :: monitor
    type(segment_type) :: segment
    integer :: i
    ensemble%from = ensemble%run%state
    do i = 0, neighbours
      call follow_flight(ensemble%run(i), event%kind == no_event, ensemble%last, ensemble%ended(i), monitor)
    end do
    ensemble%to = ensemble%run%state
    segment = segment_of(ensemble, alone, size(tip))
    call check_accuracy(tip, ensemble, alone, segment, contacts)
    if (contacts%known_until < huge(tip)) return
    if (event%kind == contact_event) contacts%events = [contacts%events, event]
    contacts%segments = [contacts%segments, segment]
    contacts%cut = ensemble%ended(0) .and. size(contacts%events) == most
    if (contacts%cut .or. any(ensemble%ended .neqv. ensemble%ended(0))) contacts%known_until = earliest(ensemble%to)
  end subroutine add_flight

  pure type(segment_type) function segment_of(ensemble, kind, count) result(segment)
    !! Return the segment until the next event, with its errors.
    type(ensemble_type), intent(in) :: ensemble
    integer, intent(in) :: kind                   !! configuration that moves
    integer, intent(in) :: count                  !! modes of it
    real(dp) :: error(size(ensemble%from(0)%u), 2), time
    time = elapsed(ensemble%from(0), ensemble%to(0))
    error = max(errors_of(ensemble%run, kind, ensemble%from, time), errors_of(ensemble%run, kind, ensemble%to, time))
    associate (from => ensemble%from(0))
      segment = segment_type(kind, from%time, count=count, q=from%u(:count), rate=from%v(:count), &
                             start_error=maxval(abs(lags_of(ensemble%from))), error=error(:count, :))
    end associate
  end function segment_of

  subroutine check_accuracy(tip, ensemble, kind, segment, contacts)
    !! Compare the error of the tip's displacement in a segment with the largest so far: with fewer than three digits
    !! the motion is unknown from its start on.
    real(dp), intent(in) :: tip(:)                !! Φ_k(1), (modes)
    type(ensemble_type), intent(in) :: ensemble
    integer, intent(in) :: kind                   !! configuration that moves
    type(segment_type), intent(in) :: segment
    type(contacts_type), intent(inout) :: contacts
    real(dp), parameter :: three_digits = 1.0e-3_dp
    real(dp) :: error, extent(size(ensemble%from(0)%u), 2)
    extent = extent_of(ensemble, kind)
    contacts%largest_deflection = max(contacts%largest_deflection, sum(abs(tip)*extent(:size(tip), 1)))
    error = sum(abs(tip)*segment%error(:, 1))
    if (error > three_digits*contacts%largest_deflection) then
      contacts%known_until = earliest(ensemble%from)
    else if (contacts%largest_deflection > 0.0_dp) then                              ! no amplification of an underflow
      contacts%amplification = error/contacts%largest_deflection/ensemble%scatter%data_error
    end if
  end subroutine check_accuracy

  pure function extent_of(ensemble, kind) result(extent)
    !! Bound displacements and velocities in a segment.
    type(ensemble_type), intent(in) :: ensemble
    integer, intent(in) :: kind                   !! configuration that moves
    real(dp) :: extent(size(ensemble%from(0)%u), 2), time
    time = elapsed(ensemble%from(0), ensemble%to(0))
    associate (parts => ensemble%run(0)%parts(kind), from => ensemble%from(0), to => ensemble%to(0))
      extent = max(parts%extent(from%u, from%v, time), parts%extent(to%u, to%v, time))
    end associate
  end function extent_of

  pure real(dp) function largest_lag(ensemble) result(lag)
    !! Return the largest time difference of neighbours.
    type(ensemble_type), intent(in) :: ensemble
    lag = maxval(abs(lags_of(ensemble%run%state)))
  end function largest_lag

  pure real(dp) function earliest(state) result(time)
    !! Return until when the motion and all neighbours agree.
    type(moving_state), intent(in) :: state(0:)
    time = minval(state%time%hi)
  end function earliest

end module bw_recontact
