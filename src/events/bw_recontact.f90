module bw_recontact
  !! A mass that rebounded strikes the tip again: contacts in order, each an impact with restitution e, until the record
  !! ends. Contacts that follow each other ever faster become one that lasts: beam and mass then move in the modes of
  !! bw_held_modes until the force between them falls to zero.
  !!
  !! The gap is v_tip − y ≥ 0. Units of bw_course: times in l²/h, velocities in V, displacements in V l²/h.
  use bw_body_state, only: body_state, energy_of, energy_reached, momentum_of
  use bw_course, only: append_course, course_type, free_modes
  use bw_double_double, only: accurate_sum, dd
  use bw_energy, only: energy_type, known_energy, sharper, operator(+)
  use bw_event, only: contact_event, event_type
  use bw_free_flight, only: fly
  use bw_held_modes, only: held_set
  use bw_kinds, only: dp
  use bw_lasting_contact, only: hold, stays
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, stops
  implicit none (type, external)
  private
  public :: follow_contacts

  type, public :: contacts_type
    !! What became of the mass.
    type(event_type), allocatable :: events(:)
    type(course_type), allocatable :: courses(:)
    type(held_set), allocatable :: held           !! unallocated where no contact lasted
    logical :: out_of_range = .false.             !! the motion grew so much that the search ended
    logical :: cut = .false.                      !! more contacts came than were asked for
    logical :: lasting = .false.                  !! the last contact had not ended when the record did
  end type contacts_type

contains

  subroutine follow_contacts(free, gamma, restitution, omega, start_rate, mass_rate, longest, most, contacts, monitor)
    !! From the state just after the impact.
    class(mode_set), intent(in) :: free           !! modes of the beam alone
    real(dp), intent(in) :: gamma, restitution    !! γ > 0, e
    real(dp), intent(in) :: omega                 !! angular velocity in the plane of the motion, else 0
    real(dp), intent(in) :: start_rate(:)         !! modal velocities, (modes)
    real(dp), intent(in) :: mass_rate             !! velocity of the mass
    real(dp), intent(in) :: longest               !! the record
    integer, intent(in) :: most                   !! contacts that are followed
    type(contacts_type), intent(out) :: contacts
    class(monitor_type), intent(inout), optional :: monitor   !! what is found means nothing where it asks to stop
    type(body_state) :: state, start
    type(event_type) :: event
    type(energy_type) :: energy
    logical :: ends, found, pressed
    integer :: opening
    state = body_state(dd(), 0.0_dp*start_rate, start_rate, 0.0_dp, mass_rate)
    energy = energy_of(free, gamma, omega, state)
    allocate (contacts%events(0), contacts%courses(0))
    pressed = .false.
    if (stays(free, restitution, omega, longest, state)) call begin_contact(state, event, pressed)
    opening = 1
    do
      if (stops(monitor)) return
      if (pressed) then
        if (.not. allocated(contacts%held)) allocate (contacts%held)
        call hold(free, gamma, omega, longest, contacts%held, state, event, energy, contacts%courses, ends, &
                  contacts%out_of_range, monitor)
        contacts%lasting = .not. ends
        contacts%events = [contacts%events, event]
        if (contacts%lasting) exit
        opening = 3
      end if
      if (.not. pressed .or. opening == 3) then
        call append_course(contacts%courses, free_modes, state%time, state%q, state%rate)
      end if
      start = state
      call fly(free, omega, longest, opening, state, found, contacts%out_of_range, monitor)
      if (.not. found) exit
      if (size(contacts%events) == most) then
        contacts%cut = .true.
        exit
      end if
      energy = energy_reached(free, gamma, omega, start, state, energy)
      call begin_contact(state, event, pressed)
      call rebound(free, gamma, restitution, state, event, energy)
      pressed = stays(free, restitution, omega, longest, state)
      opening = 1
      if (pressed) cycle
      call end_contact(state, event)
      contacts%events = [contacts%events, event]
    end do
  contains
    subroutine begin_contact(state, event, pressed)
      type(body_state), intent(in) :: state
      type(event_type), intent(out) :: event
      logical, intent(out) :: pressed
      pressed = .true.
      event%kind = contact_event
      event%time = state%time%hi
      event%end_time = state%time%hi
      event%energy_before = known_energy(energy)
      event%momentum_before = momentum_of(free, gamma, state)
    end subroutine begin_contact
    subroutine end_contact(state, event)
      type(body_state), intent(in) :: state
      type(event_type), intent(inout) :: event
      energy = sharper(energy, energy_of(free, gamma, omega, state))
      event%energy_after = known_energy(energy)
      event%momentum_after = momentum_of(free, gamma, state)
    end subroutine end_contact
  end subroutine follow_contacts

  subroutine rebound(free, gamma, restitution, state, event, energy)
    !! The blow: H = (1+e)u/(1/m_j + Σφ_i(1)²/M_i), u the velocity of approach. It takes the energy ½(1−e)Hu.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: gamma, restitution
    type(body_state), intent(inout) :: state
    type(event_type), intent(inout) :: event
    type(energy_type), intent(inout) :: energy
    real(dp) :: approach
    approach = max(0.0_dp, state%speed - dot_product(free%tip, state%rate))
    event%impulse = (1.0_dp + restitution)*approach/(1.0_dp/gamma + accurate_sum(free%tip**2/free%modal_mass))
    state%rate = state%rate + free%tip*event%impulse/free%modal_mass
    state%speed = state%speed - event%impulse/gamma
    state%place = dot_product(free%tip, state%q)
    energy = energy + energy_type(-0.5_dp*(1.0_dp - restitution)*event%impulse*approach)
  end subroutine rebound

end module bw_recontact
