module bw_contact_bodies
  !! A beam and a mass that touches it for some time or flies beside it: the modes of the beam and the mass are oscillators that
  !! a force between them drives, by Φ_k(ξ₀)/M_k and −1/m_j. The mass comes last; it runs in a guide that turns with the hub, y'' = ω²y
  !! in the plane of rotation. The gap v(ξ₀) − y is the sum with Φ_k(ξ₀) and −1. Units of bw_segment.
  use bw_double_double, only: accurate_sum, dd, to_dd, operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_mode_set, only: first_struck, mean_rate, mode_set
  use bw_monitor, only: monitor_type
  use bw_oscillators, only: moving_state, oscillators, oscillators_of, weighted_sum
  use bw_signal, only: signal_of, signal_type
  implicit none (type, external)
  private
  public :: bodies_of

  type, public :: contact_bodies
    type(oscillators) :: parts
    real(dp), allocatable :: weight(:)            !! in the gap, 0 of a mode that takes no part, (modes + 1)
    real(dp), allocatable :: inertia(:)           !! M_k, and m_j
    integer :: first = 1                          !! mode that the mass strikes
    real(dp) :: turn_of_hub = 0.0_dp              !! in the first mode, of a hub that is free
    type(moving_state) :: state
  contains
    procedure :: gap
    procedure :: separation
    procedure :: energy
    procedure :: momentum
    procedure :: hub_rate
    procedure :: pace
    procedure :: fly
  end type contact_bodies

  type, public :: first_motion
    !! What moves when the mass is let go beside the beam.
    real(dp), allocatable :: q(:), rate(:)        !! of the modes
    real(dp) :: speed = 1.0_dp                    !! of the mass
  end type first_motion

contains

  pure type(contact_bodies) function bodies_of(free, taking_part, mass_ratio, omega, first) result(bodies)
    !! The mass touches the beam, as bent as it is then.
    class(mode_set), intent(in) :: free           !! modes of the beam alone
    integer, intent(in) :: taking_part            !! how many of them do; the others stay at rest
    real(dp), intent(in) :: mass_ratio            !! γ > 0
    type(dd), intent(in) :: omega                 !! angular velocity in the plane of the motion, else 0
    type(first_motion), intent(in), optional :: first   !! absent: the mass arrives with velocity 1 at a beam at rest
    real(dp) :: damping(free%count), struck(free%count)
    integer :: n
    n = free%count
    damping = 0.0_dp
    if (allocated(free%damping)) damping = free%damping
    struck = free%struck
    struck(taking_part + 1:) = 0.0_dp
    bodies%first = first_struck(free)
    bodies%turn_of_hub = mean_rate(free, [1.0_dp])
    bodies%inertia = [free%modal_mass, mass_ratio]
    bodies%weight = [struck, -1.0_dp]
    bodies%parts = oscillators_of([free%beta_squared, -(omega*omega)], [damping, 0.0_dp])
    allocate (bodies%state%u(n + 1), bodies%state%v(n + 1), source=0.0_dp)
    bodies%state%v(n + 1) = 1.0_dp
    if (.not. present(first)) return
    bodies%state%u(:taking_part) = first%q(:taking_part)
    bodies%state%u(n + 1) = sum(struck*bodies%state%u(:n))
    bodies%state%v(:taking_part) = first%rate(:taking_part)
    bodies%state%v(n + 1) = first%speed
  end function bodies_of

  pure real(dp) function pace(self)
    !! How fast the mass and the place that it strikes may meet: the mass at its speed, and all modes at their amplitudes, out of phase.
    class(contact_bodies), intent(in) :: self
    pace = norm2(self%weight*hypot(self%state%v, sqrt(max(0.0_dp, self%parts%beta_squared%hi))*self%state%u))
  end function pace

  pure real(dp) function gap(self)
    !! Negative where mass and beam are pressed into each other.
    class(contact_bodies), intent(in) :: self
    gap = accurate_sum(self%weight*self%state%u)
  end function gap

  pure real(dp) function separation(self)
    !! Rate of the gap: positive where it opens.
    class(contact_bodies), intent(in) :: self
    separation = accurate_sum(self%weight*self%state%v)
  end function separation

  pure real(dp) function energy(self)
    !! The Jacobi energy ½ΣM(q̇² + β²q²) + ½m_j(ẏ² − ω²y²).
    class(contact_bodies), intent(in) :: self
    energy = 0.5_dp*accurate_sum(self%inertia*(self%state%v**2 + self%parts%beta_squared%hi*self%state%u**2))
  end function energy

  pure real(dp) function momentum(self)
    !! Generalised, of the first mode that the mass strikes, per unit of its displacement there.
    class(contact_bodies), intent(in) :: self
    associate (mass => size(self%weight), k => self%first)
      momentum = self%inertia(k)*self%state%v(k)/self%weight(k) + self%inertia(mass)*self%state%v(mass)
    end associate
  end function momentum

  pure real(dp) function hub_rate(self)
    !! The mean angular velocity of a hub that is free.
    class(contact_bodies), intent(in) :: self
    hub_rate = self%turn_of_hub*self%state%v(1)
  end function hub_rate

  subroutine fly(self, damping, last, found, monitor)
    !! Free motion until a force acts again, or to the end. Where damping has taken a contact's force away while the bodies are still
    !! pressed into each other, it comes back when 1 + cδ̇ is positive again.
    class(contact_bodies), intent(inout) :: self
    real(dp), intent(in) :: damping               !! c of the contact
    real(dp), intent(in) :: last                  !! the end of the search
    logical, intent(out) :: found                 !! a contact before that
    class(monitor_type), intent(inout), optional :: monitor   !! what is found means nothing where it asks to stop
    type(signal_type) :: signal
    type(oscillators) :: parts
    real(dp) :: back, time
    logical :: comes_back
    integer :: order
    associate (none => 0.0_dp*self%weight, left => (last - self%state%time%hi) - self%state%time%lo)
      order = 0
      if (self%gap() < 0.0_dp .and. damping > 0.0_dp) then
        found = damping*self%separation() <= 1.0_dp
        if (found) return
        parts = oscillators_of([self%parts%beta_squared, to_dd(0.0_dp)], [self%parts%c, 0.0_dp])
        signal = signal_of(parts, weighted_sum([none, -1.0_dp], [damping*self%weight, 0.0_dp]), &
                           moving_state([self%state%u, 1.0_dp], [self%state%v, 0.0_dp], self%state%time), 0)
        call signal%first_zero(left, comes_back, back, monitor)
        signal = signal_of(self%parts, weighted_sum(-self%weight, none), self%state, 0)
        call signal%first_zero(min(back, left), found, time, monitor)
        call self%parts%move(time, self%state)
        if (.not. found) then
          found = comes_back
          return
        end if
        order = 1
      else if (self%gap() <= 0.0_dp) then
        order = 1
        found = self%separation() <= 0.0_dp
        if (found) return
      end if
    end associate
    signal = signal_of(self%parts, weighted_sum(self%weight, 0.0_dp*self%weight), self%state, order)
    call signal%first_zero((last - self%state%time%hi) - self%state%time%lo, found, time, monitor)
    call self%parts%move(time, self%state)
  end subroutine fly

end module bw_contact_bodies
