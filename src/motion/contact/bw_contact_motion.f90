module bw_contact_motion
  !! A beam and a mass flying beside its tip: modes and mass are oscillators, uncoupled except at contacts. The mass
  !! moves in a guide that rotates with the hub, y'' = ω²y in the plane of rotation and y'' = 0 out of it; it is the
  !! last oscillator. The gap v_tip − y is the sum with weights Φ_k(1) and −1. Units of bw_segment.
  use bw_double_double, only: accurate_sum, dd, to_dd, operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_missing, only: scaled
  use bw_modal_flow, only: energy_gain
  use bw_mode_set, only: damping_rates, first_struck_mode, mode_set
  use bw_oscillators, only: moving_state, oscillators, oscillators_of, weighted_sum
  use bw_segment, only: alone, energy_type, known_energy, more_accurate, together, operator(+)
  implicit none (type, external)
  private
  public :: motion_of

  type, public :: contact_motion
    integer :: modes = 0                          !! of the beam; the mass comes after them
    type(oscillators) :: parts(together)          !! modes and mass; modes of both together after the first lasting contact
    type(weighted_sum) :: gap
    real(dp), allocatable :: inertia(:)           !! M_k, and m_j
    real(dp) :: heavier = 1.0_dp                  !! mass over `heaviest`, if larger
    real(dp) :: restitution = 0.0_dp              !! e
    integer :: first = 1                          !! first mode of the beam alone with motion at the tip
    type(moving_state) :: state
    type(energy_type) :: energy_left              !! of what the mass brought, after impacts and damping
  contains
    procedure :: separation
    procedure :: pull
    procedure :: is_pressed
    procedure :: yield
    procedure :: share
    procedure :: strike
    procedure :: lose
    procedure :: damp
    procedure :: energy
    procedure :: momentum
  end type contact_motion

  real(dp), parameter :: heaviest = 1.0e30_dp     !! in beam masses: beyond it no digit of the beam's mass counts

contains

  pure type(contact_motion) function motion_of(free, mass_ratio, restitution, omega) result(motion)
    !! Set the initial state: the mass arrives with velocity 1 at a beam at rest.
    class(mode_set), intent(in) :: free           !! modes of the beam alone, accurate for any duration
    real(dp), intent(in) :: mass_ratio            !! γ > 0
    real(dp), intent(in) :: restitution           !! e
    type(dd), intent(in) :: omega                 !! angular velocity in the plane of the motion, else 0
    integer :: n
    n = free%count
    motion%modes = n
    motion%first = first_struck_mode(free)
    motion%restitution = restitution
    motion%inertia = [free%modal_mass, min(mass_ratio, heaviest)]
    motion%heavier = max(1.0_dp, mass_ratio/heaviest)
    motion%gap = weighted_sum([free%struck, -1.0_dp], spread(0.0_dp, 1, n + 1))
    motion%parts(alone) = oscillators_of([free%beta_squared, -(omega*omega)], [damping_rates(free), 0.0_dp])
    allocate (motion%state%u(n + 1), motion%state%v(n + 1), source=0.0_dp)
    motion%state%v(n + 1) = 1.0_dp
    motion%energy_left%value = 0.5_dp*motion%inertia(n + 1)
  end function motion_of

  pure real(dp) function separation(self)
    !! Return the rate of the gap; positive if it opens.
    class(contact_motion), intent(in) :: self
    separation = self%parts(alone)%derivative(self%gap, self%state, 1)
  end function separation

  pure real(dp) function pull(self)
    !! Return the closing acceleration of the gap; positive if the mass is pressed against the tip.
    class(contact_motion), intent(in) :: self
    pull = -self%parts(alone)%derivative(self%gap, self%state, 2)
  end function pull

  pure logical function is_pressed(self)
    !! Return whether the mass is pressed against the tip, now or in the next instant.
    class(contact_motion), intent(in) :: self
    real(dp) :: pull
    pull = self%pull()
    is_pressed = pull > 0.0_dp
    if (pull == 0.0_dp) is_pressed = self%parts(alone)%derivative(self%gap, self%state, 3) < 0.0_dp
  end function is_pressed

  pure real(dp) function yield(self)
    !! Return the impulse per change of the gap's rate, 1/(1/m_j + Σφ_k(1)²/M_k).
    class(contact_motion), intent(in) :: self
    associate (n => self%modes)
      yield = self%inertia(n + 1)/(1.0_dp + self%inertia(n + 1)*sum(self%gap%a(:n)**2/self%inertia(:n)))
    end associate
  end function yield

  pure function share(self)
    !! Return the changes of velocity per change of the gap's rate, Φ_k(1)/M_k times `yield`.
    class(contact_motion), intent(in) :: self
    real(dp) :: share(self%modes + 1)
    associate (n => self%modes, yield => self%yield())
      share = [self%gap%a(:n)/self%inertia(:n)*yield, -(yield/self%inertia(n + 1))]
    end associate
  end function share

  pure subroutine strike(self, impulse)
    !! Apply an impact: H = (1+e)u/(1/m_j + Σφ_k(1)²/M_k) with the closing speed u.
    class(contact_motion), intent(inout) :: self
    real(dp), intent(out) :: impulse
    real(dp) :: separation
    separation = self%separation()
    impulse = -(1.0_dp + self%restitution)*separation*self%yield()
    call self%lose(0.5_dp*(1.0_dp - self%restitution**2)*separation**2*self%yield())
    self%state%v = self%state%v - self%share()*((1.0_dp + self%restitution)*separation)
  end subroutine strike

  pure subroutine lose(self, energy)
    !! Subtract the energy lost in an impact.
    class(contact_motion), intent(inout) :: self
    real(dp), intent(in) :: energy
    if (energy > 0.0_dp) self%energy_left = self%energy_left + energy_type(-energy, 0.0_dp)
  end subroutine lose

  pure subroutine damp(self, kind, mass, from, time)
    !! Subtract the energy dissipated in a time.
    class(contact_motion), intent(inout) :: self
    integer, intent(in) :: kind                   !! configuration that moves
    real(dp), intent(in) :: mass(:)               !! of its oscillators
    type(moving_state), intent(in) :: from
    real(dp), intent(in) :: time
    real(dp) :: gain(size(mass))
    associate (parts => self%parts(kind))
      if (.not. any(parts%c > 0.0_dp)) return
      gain = 0.5_dp*mass*energy_gain(parts%beta_squared, parts%c, to_dd(time), from%u, from%v)
    end associate
    self%energy_left = self%energy_left + energy_type(accurate_sum(gain), 16*epsilon(gain)*sum(abs(gain)))
  end subroutine damp

  pure real(dp) function energy(self)
    !! Return the Jacobi energy ½ΣM(q̇² + β²q²) + ½m_j(ẏ² − ω²y²), which never grows; missing with fewer than three digits.
    class(contact_motion), intent(in) :: self
    real(dp), dimension(self%modes + 1) :: moving, bent
    type(energy_type) :: of_state
    moving = 0.5_dp*self%inertia*self%state%v**2
    bent = 0.5_dp*self%inertia*self%parts(alone)%beta_squared%hi*self%state%u**2
    of_state = energy_type(accurate_sum(moving + bent), 16*epsilon(moving)*sum(moving + abs(bent)))
    energy = scaled(known_energy(more_accurate(self%energy_left, of_state)), self%heavier)
  end function energy

  pure real(dp) function momentum(self)
    !! Return the generalised momentum of the first struck mode, per unit of its displacement there.
    class(contact_motion), intent(in) :: self
    associate (mass => self%modes + 1, k => self%first)
      momentum = self%inertia(k)*self%state%v(k)/self%gap%a(k) + self%inertia(mass)*self%state%v(mass)
    end associate
    momentum = scaled(momentum, self%heavier)
  end function momentum

end module bw_contact_motion
