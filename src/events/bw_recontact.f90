module bw_recontact
  !! A mass that rebounded strikes the tip again: contacts in order, each an impact with restitution e, until the record
  !! ends. Contacts that follow each other ever faster become one that lasts: beam and mass then move in the modes of
  !! bw_held_modes until the force between them falls to zero.
  !!
  !! The mass moves in a guide that turns with the hub, y'' = ω²y in the plane of rotation and y'' = 0 out of it. The gap
  !! is v_tip − y ≥ 0. Units of bw_course: times in l²/h, velocities in V, displacements in V l²/h.
  use bw_course, only: beam_energy, course_type, free_modes, held_at_tip => held_modes, leaves_range, move
  use bw_double_double, only: accurate_sum, dd, to_dd, operator(+), operator(*)
  use bw_event, only: contact_event, event_type
  use bw_held_modes, only: held_modes, held_set
  use bw_kinds, only: dp
  use bw_modal_flow, only: flow
  use bw_mode_set, only: mode_set
  use bw_release, only: mass_energy
  use bw_signal, only: signal_type
  implicit none (type, external)
  private
  public :: follow_contacts

  real(dp), parameter :: grazing = 1.0e-9_dp      !! of V: an approach below it is no contact
  real(dp), parameter :: finest = 1.0e-13_dp      !! of the record: to this its times are found
  real(dp), parameter :: unseen = 1.0e-12_dp      !! of V times the record: rebounds that stay below it are left out

  type, public :: contacts_type
    !! What became of the mass.
    type(event_type), allocatable :: events(:)
    type(course_type), allocatable :: courses(:)
    type(held_set), allocatable :: held           !! unallocated where no contact lasted
    logical :: out_of_range = .false.             !! the motion grew so much that the search ended
    logical :: cut = .false.                      !! more contacts came than were asked for
    logical :: lasting = .false.                  !! the last contact had not ended when the record did
  end type contacts_type

  type :: body_state
    !! Beam and mass at a time.
    type(dd) :: time
    real(dp), allocatable :: q(:), rate(:)
    real(dp) :: place = 0.0_dp, speed = 0.0_dp    !! of the mass
  end type body_state

contains

  subroutine follow_contacts(free, gamma, restitution, omega, start_rate, mass_rate, longest, most, contacts)
    !! From the state just after the impact.
    class(mode_set), intent(in) :: free           !! modes of the beam alone
    real(dp), intent(in) :: gamma, restitution    !! γ > 0, e
    real(dp), intent(in) :: omega                 !! angular velocity in the plane of the motion, else 0
    real(dp), intent(in) :: start_rate(:)         !! modal velocities, (modes)
    real(dp), intent(in) :: mass_rate             !! velocity of the mass
    real(dp), intent(in) :: longest               !! the record
    integer, intent(in) :: most                   !! contacts that are followed
    type(contacts_type), intent(out) :: contacts
    type(body_state) :: state
    type(event_type) :: event
    logical :: found, pressed
    integer :: opening
    state = body_state(dd(), 0.0_dp*start_rate, start_rate, 0.0_dp, mass_rate)
    allocate (contacts%events(0), contacts%courses(0))
    pressed = .false.
    if (stays(free, restitution, omega, longest, state)) call begin_contact(state, event, pressed)
    opening = 1
    do
      if (pressed) then
        call hold(free, gamma, omega, longest, state, event, contacts)
        contacts%events = [contacts%events, event]
        if (contacts%lasting) exit
        opening = 3
      end if
      if (.not. pressed .or. opening == 3) contacts%courses = [contacts%courses, course_of(state)]
      call fly(free, omega, longest, opening, state, found, contacts%out_of_range)
      if (.not. found) exit
      if (size(contacts%events) == most) then
        contacts%cut = .true.
        exit
      end if
      call begin_contact(state, event, pressed)
      call rebound(free, gamma, restitution, state, event)
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
      event%energy_before = energy_of(free, gamma, omega, state)
      event%momentum_before = momentum_of(free, gamma, state)
    end subroutine begin_contact
    subroutine end_contact(state, event)
      type(body_state), intent(in) :: state
      type(event_type), intent(inout) :: event
      event%energy_after = energy_of(free, gamma, omega, state)
      event%momentum_after = momentum_of(free, gamma, state)
    end subroutine end_contact
  end subroutine follow_contacts

  pure type(course_type) function course_of(state) result(course)
    type(body_state), intent(in) :: state
    course = course_type(free_modes, state%time, state%q, state%rate)
  end function course_of

  pure real(dp) function energy_of(free, gamma, omega, state) result(energy)
    !! The Jacobi energy ½ΣM(q̇² + β²q²) + ½m_j(ẏ² − ω²y²), which never grows.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: gamma, omega
    type(body_state), intent(in) :: state
    energy = beam_energy(free, state%q, state%rate) + mass_energy(gamma, state%place, state%speed, omega)
  end function energy_of

  pure real(dp) function momentum_of(free, gamma, state) result(momentum)
    !! Generalised, of the first mode, per unit of its tip displacement.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: gamma
    type(body_state), intent(in) :: state
    momentum = free%modal_mass(1)*state%rate(1)/free%tip(1) + gamma*state%speed
  end function momentum_of

  subroutine rebound(free, gamma, restitution, state, event)
    !! The blow: H = (1+e)u/(1/m_j + Σφ_i(1)²/M_i), u the velocity of approach.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: gamma, restitution
    type(body_state), intent(inout) :: state
    type(event_type), intent(inout) :: event
    real(dp) :: approach
    approach = max(0.0_dp, state%speed - dot_product(free%tip, state%rate))
    event%impulse = (1.0_dp + restitution)*approach/(1.0_dp/gamma + accurate_sum(free%tip**2/free%modal_mass))
    state%rate = state%rate + free%tip*event%impulse/free%modal_mass
    state%speed = state%speed - event%impulse/gamma
    state%place = dot_product(free%tip, state%q)
  end subroutine rebound

  logical function stays(free, restitution, omega, longest, state)
    !! The mass is pressed against the tip, and all further rebounds would stay below what can be seen: with the
    !! relative acceleration a they take 2s/a/(1−e) in all, s the velocity of separation, and reach no further than
    !! s²/2a; a must not change in that time.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: restitution, omega, longest
    type(body_state), intent(in) :: state
    type(signal_type) :: gap
    real(dp) :: separation, pull, rest
    gap = gap_of(free, omega, state)
    separation = max(0.0_dp, gap%derivative(1))
    pull = -gap%derivative(2)
    stays = .false.
    if (restitution == 0.0_dp .or. separation <= grazing) then
      stays = pull > 0.0_dp
      if (pull == 0.0_dp) stays = gap%derivative(3) < 0.0_dp
    else if (restitution < 1.0_dp .and. pull > 0.0_dp) then
      rest = 2.0_dp*separation/pull/(1.0_dp - restitution)
      stays = separation*rest <= unseen*longest .and. abs(gap%derivative(3))*rest <= 0.5_dp*pull
    end if
  end function stays

  pure type(signal_type) function gap_of(free, omega, state) result(gap)
    !! v_tip − y from a contact on: its modes, then the mass.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: omega
    type(body_state), intent(in) :: state
    gap%beta_squared = [free%beta_squared, to_dd(omega)*(-omega)]
    gap%u = [free%tip*state%q, -state%place]
    gap%u_dot = [free%tip*state%rate, -state%speed]
    gap%c = 0.0_dp*gap%u
    if (allocated(free%damping)) gap%c(:free%count) = free%damping
  end function gap_of

  subroutine fly(free, omega, longest, opening, state, found, out_of_range)
    !! Free motion to the next contact.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: omega, longest
    integer, intent(in) :: opening                !! the first derivative of the gap that is not zero
    type(body_state), intent(inout) :: state
    logical, intent(out) :: found
    logical, intent(out) :: out_of_range
    type(signal_type) :: gap
    type(body_state) :: arrived
    real(dp) :: left, time, start, passing
    integer :: order
    left = longest - state%time%hi
    out_of_range = leaves_range(free, to_dd(left)) .or. omega*left > 300.0_dp
    found = .false.
    if (out_of_range) return
    gap = gap_of(free, omega, state)
    order = opening
    call settle(gap, order)
    start = 0.0_dp
    passing = 1.0e3_dp*finest*longest
    do
      if (start == 0.0_dp .and. order <= 3) then
        call gap%first_zero(start, left, finest*longest, found, time, order)
      else
        call gap%first_zero(max(start, passing), left, finest*longest, found, time)
      end if
      if (.not. found) return
      arrived = state_at(free, omega, state, time)
      if (is_contact(free, omega, arrived)) exit
      start = time + passing                        ! a graze: look for the next one from where the gap has opened
      passing = 2.0_dp*passing
    end do
    state = arrived
  end subroutine fly

  subroutine settle(gap, order)
    !! At the start of a flight the gap is exactly zero, and so are those of its derivatives that the contact has made
    !! so: take their roundings off. The first that is positive opens the gap; 4 where none is.
    type(signal_type), intent(inout) :: gap
    integer, intent(inout) :: order
    integer :: mass
    mass = size(gap%u)
    gap%u(mass) = -accurate_sum(gap%u(:mass - 1))
    if (order == 1 .and. gap%derivative(1) > grazing) return
    gap%u_dot(mass) = -accurate_sum(gap%u_dot(:mass - 1))
    order = max(order, 2)
    do while (order <= 3)
      if (gap%derivative(order) > 0.0_dp) return
      order = order + 1
    end do
  end subroutine settle

  logical function is_contact(free, omega, state)
    !! The mass approaches the tip, or is pressed against it, where the gap has closed.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: omega
    type(body_state), intent(in) :: state
    type(signal_type) :: gap
    gap = gap_of(free, omega, state)
    is_contact = -gap%derivative(1) >= grazing .or. gap%derivative(2) < 0.0_dp
  end function is_contact

  type(body_state) function state_at(free, omega, state, elapsed) result(later)
    !! After a time of free motion.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: omega, elapsed
    type(body_state), intent(in) :: state
    later = state
    later%time = state%time + to_dd(elapsed)
    call move(free, to_dd(elapsed), later%q, later%rate)
    call flow(to_dd(omega)*(-omega), 0.0_dp, to_dd(elapsed), later%place, later%speed)
  end function state_at

  subroutine hold(free, gamma, omega, longest, state, event, contacts)
    !! A contact that lasts: beam and mass together until the force between them falls to zero, or to the end.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: gamma, omega, longest
    type(body_state), intent(inout) :: state
    type(event_type), intent(inout) :: event
    type(contacts_type), intent(inout) :: contacts
    type(signal_type) :: force
    real(dp), dimension(free%count) :: z, z_rate
    real(dp) :: left, time, before, swept
    logical :: ends
    if (.not. allocated(contacts%held)) allocate (contacts%held)
    if (contacts%held%count == 0) call held_modes(free, gamma, omega, contacts%held)
    associate (held => contacts%held)
      before = state%speed + event%impulse/gamma             ! of the mass, when it arrived
      call held%take(state%q, state%rate, state%place, state%speed, z, z_rate)
      contacts%courses = [contacts%courses, course_type(held_at_tip, state%time, z, z_rate)]
      left = longest - state%time%hi
      ends = .false.
      time = left
      if (.not. leaves_range(held, to_dd(left))) then
        force = force_of(held, omega, z, z_rate)
        if (force%start > 0.0_dp) then
          call force%first_zero(0.0_dp, left, finest*longest, ends, time)
        else
          call force%first_zero(0.0_dp, left, finest*longest, ends, time, opening=1)
        end if
        swept = dot_product(held%tip, integral(held, z, z_rate, to_dd(time)))
        call move(held, to_dd(time), z, z_rate)
        event%impulse = gamma*(before - dot_product(held%tip, z_rate) + omega**2*swept)
      else
        contacts%out_of_range = .true.
        time = 0.0_dp
      end if
      contacts%lasting = .not. ends
      call held%give(z, z_rate, state%q, state%rate)
      state%place = dot_product(held%tip, z)
      state%speed = dot_product(held%tip, z_rate)
    end associate
    state%time = state%time + to_dd(time)
    event%end_time = merge(state%time%hi, longest, ends)
    event%energy_after = energy_of(free, gamma, omega, state)
    event%momentum_after = momentum_of(free, gamma, state)
  end subroutine hold

  pure type(signal_type) function force_of(held, omega, z, z_rate) result(force)
    !! What presses the mass against the tip, positive while it does: the acceleration with which the gap would close,
    !! −φᵀ(q̈ of the beam alone) + ω²y. Undamped, that is the force m_jΣΦ_k(1)(β_k² + ω²)z_k times 1/m_j + Σφ_i(1)²/M_i;
    !! damped, the held modes are taken as uncoupled, and only this tells when the gap really opens.
    type(held_set), intent(in) :: held
    real(dp), intent(in) :: omega, z(:), z_rate(:)
    real(dp), dimension(size(z)) :: square, by_place, by_rate
    square = held%beta_squared%hi
    by_rate = 0.0_dp*z
    by_place = held%tip*(square + omega**2)
    if (allocated(held%damping)) then
      by_place = matmul(held%free%tip*held%free%beta_squared%hi, held%mixing) + omega**2*held%tip
      by_rate = matmul(held%free%tip*held%free%damping, held%mixing)
    end if
    force%beta_squared = held%beta_squared
    force%c = 0.0_dp*z
    if (allocated(held%damping)) force%c = held%damping
    force%u = by_place*z + by_rate*z_rate
    force%u_dot = by_place*z_rate - by_rate*(force%c*z_rate + square*z)
    force%start = max(0.0_dp, accurate_sum(force%u))
  end function force_of

  pure function integral(held, z, z_rate, time) result(sums)
    !! ∫z dt = −(Δż + cΔz)/β².
    type(held_set), intent(in) :: held
    real(dp), intent(in) :: z(:), z_rate(:)
    type(dd), intent(in) :: time
    real(dp), dimension(size(z)) :: sums, later, later_rate, c
    c = 0.0_dp
    if (allocated(held%damping)) c = held%damping
    later = z
    later_rate = z_rate
    call move(held, time, later, later_rate)
    where (abs(held%beta_squared%hi)*time%hi**2 > 1.0e-6_dp)
      sums = -((later_rate - z_rate) + c*(later - z))/held%beta_squared%hi
    elsewhere
      sums = time%hi*(0.5_dp*(z + later) + time%hi*(z_rate - later_rate)/12.0_dp)    ! Hermite's rule
    end where
  end function integral

end module bw_recontact
