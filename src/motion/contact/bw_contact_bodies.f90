module bw_contact_bodies
  !! A beam and a mass in lasting contact or flying beside it: modes and mass are oscillators, on which a contact force
  !! acts with Φ_k(ξ₀)/M_k and −1/m_j. The mass is the last; it moves in a guide that rotates with the hub, y'' = ω²y in
  !! the plane of rotation. The gap v(ξ₀) − y is the sum with weights Φ_k(ξ₀) and −1. Units of bw_segment.
  use bw_acting_loads, only: acting_loads, gap_degree
  use bw_change_of_bodies, only: beam_state
  use bw_double_double, only: accurate_sum, dd, to_dd, operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_mode_set, only: damping_rates, first_struck_mode, mean_rate, mode_set
  use bw_monitor, only: monitor_type, stops
  use bw_oscillators, only: moving_state, oscillators, oscillators_of, weighted_sum
  use bw_segment, only: shape_term
  use bw_signal, only: signal_of, signal_type
  implicit none (type, external)
  private
  public :: bodies_after, bodies_of

  type, public :: contact_bodies
    type(oscillators) :: parts
    real(dp), allocatable :: weight(:)            !! in the gap; 0: mode takes no part, (modes + 1)
    real(dp), allocatable :: inertia(:)           !! M_k, and m_j
    integer :: first = 1                          !! first mode with motion at the struck point
    real(dp) :: turn_of_hub = 0.0_dp              !! hub rotation of the first mode, on a free hub
    type(moving_state) :: state
    type(acting_loads), allocatable :: loads      !! unallocated: only the contact acts
    real(dp) :: held = 0.0_dp                     !! equilibrium deflection of the struck point
    real(dp) :: level = 0.0_dp                    !! energy of the equilibrium shape
    type(shape_term), allocatable :: shape(:)     !! that shape; unallocated: straight
  contains
    procedure :: gap
    procedure :: rounding
    procedure :: separation
    procedure :: energy
    procedure :: momentum
    procedure :: hub_rate
    procedure :: pace
    procedure :: fly
  end type contact_bodies

  type, public :: first_motion
    !! The initial motion of beam and mass.
    real(dp), allocatable :: q(:), rate(:)        !! of the modes
    real(dp) :: speed = 1.0_dp                    !! of the mass
    real(dp) :: others = 0.0_dp                   !! largest speed of bodies that arrive later
    type(acting_loads), allocatable :: loads      !! unallocated: none
  end type first_motion

  integer, parameter :: most_orders = 4           !! of derivatives of a closed gap

contains

  pure type(contact_bodies) function bodies_of(free, taking_part, mass_ratio, omega, first) result(bodies)
    !! Set the initial state: the mass touches the beam, deflected or not.
    class(mode_set), intent(in) :: free           !! modes of the beam alone
    integer, intent(in) :: taking_part            !! modes; the others stay at rest
    real(dp), intent(in) :: mass_ratio            !! γ > 0
    type(dd), intent(in) :: omega                 !! angular velocity in the plane of the motion, else 0
    type(first_motion), intent(in), optional :: first   !! absent: the mass arrives with velocity 1 at a beam at rest
    real(dp) :: struck(free%count)
    integer :: n
    n = free%count
    struck = free%struck
    struck(taking_part + 1:) = 0.0_dp
    bodies%first = first_struck_mode(free)
    bodies%turn_of_hub = mean_rate(free, [1.0_dp])
    bodies%inertia = [free%modal_mass, mass_ratio]
    bodies%weight = [struck, -1.0_dp]
    bodies%parts = oscillators_of([free%beta_squared, -(omega*omega)], [damping_rates(free), 0.0_dp])
    allocate (bodies%state%u(n + 1), bodies%state%v(n + 1), source=0.0_dp)
    bodies%state%v(n + 1) = 1.0_dp
    if (.not. present(first)) return
    bodies%state%u(:taking_part) = first%q(:taking_part)
    bodies%state%u(n + 1) = accurate_sum(struck*bodies%state%u(:n))
    bodies%state%v(:taking_part) = first%rate(:taking_part)
    bodies%state%v(n + 1) = first%speed
    if (.not. allocated(first%loads)) return
    bodies%loads = first%loads
    bodies%loads%drive(taking_part + 1:n, :) = 0.0_dp
    call bodies%loads%begin(bodies%parts)
  end function bodies_of

  pure type(contact_bodies) function bodies_after(modes, count, mass_ratio, omega, state, struck, beside, loads) result(bodies)
    !! Set the state after a change of the beam. The mass keeps its state; before t > 0 it touches the beam.
    class(mode_set), intent(in) :: modes          !! of the beam alone after the change
    integer, intent(in) :: count                  !! modes that take part
    real(dp), intent(in) :: mass_ratio
    type(dd), intent(in) :: omega
    type(beam_state), intent(in) :: state         !! of these modes
    real(dp), intent(in) :: struck                !! deflection of the equilibrium shape at the struck point
    type(moving_state), intent(in) :: beside      !! state of the mass, and the time
    type(acting_loads), allocatable, intent(in) :: loads   !! for these modes; unallocated: none
    type(first_motion) :: first
    first%q = state%q
    first%rate = state%rate
    first%speed = beside%v(1)
    if (allocated(loads)) first%loads = loads
    bodies = bodies_of(modes, count, mass_ratio, omega, first)
    if (size(state%shape) > 0) bodies%shape = state%shape
    bodies%held = struck
    bodies%level = state%level
    associate (mass => size(bodies%weight))
      bodies%state%u(mass) = bodies%state%u(mass) + struck
      if (beside%time%hi > 0.0_dp) bodies%state%u(mass) = beside%u(1)
    end associate
    bodies%state%time = beside%time
  end function bodies_after

  pure real(dp) function pace(self)
    !! Estimate the largest closing speed: the mass at its speed, and all modes at their amplitudes, out of phase.
    class(contact_bodies), intent(in) :: self
    pace = norm2(self%weight*hypot(self%state%v, sqrt(max(0.0_dp, self%parts%beta_squared%hi))*self%state%u))
    if (allocated(self%loads)) pace = hypot(pace, self%loads%pace(self%parts, self%weight))
  end function pace

  pure real(dp) function gap(self)
    !! Return the gap; negative if mass and beam overlap.
    class(contact_bodies), intent(in) :: self
    gap = accurate_sum(self%weight*self%state%u) + self%held
    if (allocated(self%loads)) gap = gap + self%loads%gap(self%state%time%hi, 0)
  end function gap

  pure real(dp) function rounding(self)
    !! Return the rounding error of the gap.
    class(contact_bodies), intent(in) :: self
    rounding = 16*epsilon(rounding)*(sum(abs(self%weight*self%state%u)) + abs(self%held))
  end function rounding

  pure real(dp) function separation(self)
    !! Return the rate of the gap; positive if it opens.
    class(contact_bodies), intent(in) :: self
    separation = accurate_sum(self%weight*self%state%v)
    if (allocated(self%loads)) separation = separation + self%loads%gap(self%state%time%hi, 1)
  end function separation

  pure real(dp) function energy(self)
    !! Return the Jacobi energy ½ΣM(q̇² + β²q²) + ½m_j(ẏ² − ω²y²).
    class(contact_bodies), intent(in) :: self
    energy = 0.5_dp*accurate_sum(self%inertia*(self%state%v**2 + self%parts%beta_squared%hi*self%state%u**2)) + self%level
  end function energy

  pure real(dp) function momentum(self)
    !! Return the generalised momentum of the first struck mode, per unit of its displacement there.
    class(contact_bodies), intent(in) :: self
    associate (mass => size(self%weight), k => self%first)
      momentum = self%inertia(k)*self%state%v(k)/self%weight(k) + self%inertia(mass)*self%state%v(mass)
    end associate
  end function momentum

  pure real(dp) function hub_rate(self)
    !! Return the mean angular velocity of a free hub.
    class(contact_bodies), intent(in) :: self
    hub_rate = self%turn_of_hub*self%state%v(1)
  end function hub_rate

  subroutine fly(self, damping, last, found, monitor)
    !! Move in flight until a contact force acts again, or to the end.
    class(contact_bodies), intent(inout) :: self
    real(dp), intent(in) :: damping               !! c of the contact
    real(dp), intent(in) :: last                  !! end of the search
    logical, intent(out) :: found                 !! a contact starts before it
    class(monitor_type), intent(inout), optional :: monitor   !! results are invalid if it requests a stop
    real(dp) :: until
    do
      until = last
      if (allocated(self%loads)) until = min(last, self%loads%calm_until(self%state%time%hi))
      call fly_smoothly(self, damping, until, found, monitor)
      if (stops(monitor)) return
      if (found .or. until >= last) return
      self%state%time = to_dd(until)
    end do
  end subroutine fly

  subroutine fly_smoothly(self, damping, last, found, monitor)
    !! Move over an interval with smooth loads. If damping made the contact force 0 while the bodies still overlap, the
    !! force returns once 1 + cδ̇ > 0.
    type(contact_bodies), intent(inout) :: self
    real(dp), intent(in) :: damping
    real(dp), intent(in) :: last
    logical, intent(out) :: found
    class(monitor_type), intent(inout), optional :: monitor
    type(signal_type) :: signal
    type(oscillators) :: parts
    type(moving_state) :: free
    real(dp), allocatable :: polynomial(:), other(:)   ! added to the sums of free motions; unallocated: no loads
    real(dp) :: back, time
    logical :: comes_back
    integer :: m, order
    associate (none => 0.0_dp*self%weight, left => (last - self%state%time%hi) - self%state%time%lo)
      order = 0
      call take_out_loads(self, free, polynomial)
      if (self%gap() < 0.0_dp .and. damping > 0.0_dp) then
        found = damping*self%separation() <= 1.0_dp
        if (found) return
        if (allocated(polynomial)) other = damping*[((m + 1)*polynomial(m + 1), m=0, ubound(polynomial, 1) - 1)]
        parts = oscillators_of([self%parts%beta_squared, to_dd(0.0_dp)], [self%parts%c, 0.0_dp])
        signal = signal_of(parts, weighted_sum([none, -1.0_dp], [damping*self%weight, 0.0_dp]), &
                           moving_state([free%u, 1.0_dp], [free%v, 0.0_dp], free%time), 0, other)
        call signal%first_zero(left, comes_back, back, monitor)
        if (allocated(polynomial)) other = -polynomial
        signal = signal_of(self%parts, weighted_sum(-self%weight, none), free, 0, other)
        call signal%first_zero(min(back, left), found, time, monitor)
        call move(self, time)
        if (.not. found) then
          found = comes_back
          return
        end if
        order = 1
        call take_out_loads(self, free, polynomial)
      else if (self%gap() <= 0.0_dp .or. self%state%time%hi <= 0.0_dp) then   ! closed to rounding at the start
        order = opening(self, free, polynomial)
        found = order == 0
        if (found) return
        if (order > most_orders) then              ! no motion
          call move(self, left)
          return
        end if
      end if
    end associate
    signal = signal_of(self%parts, weighted_sum(self%weight, 0.0_dp*self%weight), free, order, polynomial)
    call signal%first_zero((last - self%state%time%hi) - self%state%time%lo, found, time, monitor)
    call move(self, time)
  end subroutine fly_smoothly

  subroutine take_out_loads(self, free, polynomial)
    !! Split the gap into free motions and a polynomial due to loads, valid for a short interval.
    type(contact_bodies), intent(in) :: self
    type(moving_state), intent(out) :: free
    real(dp), allocatable, intent(out) :: polynomial(:)   !! in the time from now on; unallocated: 0, (0:degree)
    if (allocated(self%loads)) then
      allocate (polynomial(0:gap_degree))
      call self%loads%take_out(self%parts, self%weight, self%state, free, polynomial)
      polynomial(0) = polynomial(0) + self%held
    else
      free = self%state
      if (self%held == 0.0_dp) return
      allocate (polynomial(0:most_orders), source=0.0_dp)
      polynomial(0) = self%held
    end if
  end subroutine take_out_loads

  subroutine move(self, time)
    !! Move the state forward within an interval of smooth loads.
    type(contact_bodies), intent(inout) :: self
    real(dp), intent(in) :: time
    if (allocated(self%loads)) then
      call self%loads%move(self%parts, time, self%state)
    else
      call self%parts%move(time, self%state)
    end if
  end subroutine move

  pure integer function opening(self, free, polynomial) result(order)
    !! Return the order of the first nonzero derivative of a closed gap; 0 if that closes it further, `most_orders` + 1
    !! if nothing moves.
    type(contact_bodies), intent(in) :: self
    type(moving_state), intent(in) :: free
    real(dp), allocatable, intent(in) :: polynomial(:)    !! see `take_out_loads`
    real(dp) :: derivative
    do order = 1, most_orders
      derivative = self%parts%derivative(weighted_sum(self%weight, 0.0_dp*self%weight), free, order)
      if (allocated(polynomial)) derivative = derivative + gamma(order + 1.0_dp)*polynomial(order)
      if (derivative > 0.0_dp) return
      if (derivative < 0.0_dp) exit
    end do
    if (order <= most_orders) order = 0
  end function opening

end module bw_contact_bodies
