module bw_contact_motion
  !! A beam and a mass that moves freely beside its tip, in binary128: the beam's modes and the mass are oscillators that move
  !! without each other but at a contact. The mass runs in a guide that turns with the hub, y'' = ω²y in the plane of rotation
  !! and y'' = 0 out of it; it comes last among them. The gap v_tip − y is the sum with Φ_k(1) and −1. Units of bw_segment.
  use bw_kinds, only: dp, qp
  use bw_missing, only: missing, rounded
  use bw_mode_set, only: first_struck, full_numbers, mode_set
  use bw_oscillators, only: moving_state, oscillators, weighted_sum
  use bw_perturbations, only: perturbations
  implicit none (type, external)
  private
  public :: motion_of

  type, public :: contact_motion
    integer :: modes = 0                          !! of the beam; the mass is the oscillator after them
    type(oscillators) :: parts
    type(weighted_sum) :: gap
    real(qp), allocatable :: inertia(:)           !! M_k, and m_j
    real(dp), allocatable :: inertia_error(:)     !! by which they may be off, as a part of them
    real(qp), allocatable :: share(:)             !! of a change of the gap's rate that a blow makes: Φ_k(1)/M_k over their sum
    real(qp) :: mobility = 0.0_qp                 !! Σφ_k(1)²/M_k + 1/m_j
    real(qp) :: restitution = 0.0_qp              !! e
    real(qp) :: omega = 0.0_qp                    !! angular velocity in the plane of the motion, else 0
    integer :: first = 1                          !! mode of the beam alone that the mass strikes
    type(moving_state) :: state
    type(perturbations) :: near                   !! what it might be instead
    real(qp) :: lost = 0.0_qp                     !! energy, in blows
  contains
    procedure :: separation
    procedure :: pull
    procedure :: jerk
    procedure :: strike
    procedure :: energy
    procedure :: momentum
    procedure :: data_error
  end type contact_motion

contains

  pure type(contact_motion) function motion_of(free, mass_ratio, restitution, omega) result(motion)
    !! The mass arrives with velocity 1 at a beam at rest.
    class(mode_set), intent(in) :: free           !! modes of the beam alone, found for a record without end
    real(qp), intent(in) :: mass_ratio            !! γ > 0
    real(dp), intent(in) :: restitution           !! e
    real(qp), intent(in) :: omega                 !! angular velocity in the plane of the motion, else 0
    type(full_numbers) :: numbers
    integer :: n
    n = free%count
    call free%in_full(numbers)
    motion%modes = n
    motion%first = first_struck(free)
    motion%restitution = restitution
    motion%omega = omega
    motion%inertia = [numbers%mass, mass_ratio]
    motion%inertia_error = [numbers%mass_error, 0.0_dp]
    motion%gap%a = [real(free%struck, qp), -1.0_qp]
    motion%gap%b = 0.0_qp*motion%gap%a
    motion%parts%square = [numbers%square, -omega**2]
    motion%parts%c = [numbers%damping, 0.0_qp]
    motion%parts%square_error = [numbers%square_error, epsilon(1.0_dp)**2*real(omega, dp)**2]
    motion%parts%c_error = [numbers%damping_error, 0.0_dp]
    call motion%parts%ready()
    motion%mobility = sum(motion%gap%a**2/motion%inertia)
    motion%share = motion%gap%a/motion%inertia/motion%mobility
    allocate (motion%state%u(n + 1), motion%state%v(n + 1), source=0.0_qp)
    motion%state%v(n + 1) = 1.0_qp
    call motion%near%start(n + 1)
  end function motion_of

  pure real(qp) function separation(self)
    !! Rate of the gap: positive where it opens.
    class(contact_motion), intent(in) :: self
    separation = self%parts%derivative(self%gap, self%state, 1)
  end function separation

  pure real(qp) function pull(self)
    !! With which acceleration the gap would close: positive where the mass is pressed against the tip.
    class(contact_motion), intent(in) :: self
    pull = -self%parts%derivative(self%gap, self%state, 2)
  end function pull

  pure real(qp) function jerk(self)
    !! Third derivative of the gap.
    class(contact_motion), intent(in) :: self
    jerk = self%parts%derivative(self%gap, self%state, 3)
  end function jerk

  pure subroutine strike(self, impulse)
    !! A blow: H = (1+e)u/(1/m_j + Σφ_i(1)²/M_i), u the velocity of approach; the neighbours' too.
    class(contact_motion), intent(inout) :: self
    real(dp), intent(out) :: impulse
    real(qp) :: change
    real(dp) :: share(size(self%share)), off(size(self%share)), parted
    integer :: p
    change = -(1.0_qp + self%restitution)*self%separation()
    impulse = real(change/self%mobility, dp)
    self%lost = self%lost + 0.5_qp*(1.0_qp - self%restitution**2)*self%separation()**2/self%mobility
    self%state%v = self%state%v + self%share*change
    share = real(self%share, dp)
    do p = 1, size(self%near%lag)
      associate (v => self%near%v(:, p))
        off = -self%near%sign(:, p)*self%inertia_error
        off = share*(off - sum(real(self%gap%a, dp)*share*off))
        parted = -real(1.0_qp + self%restitution, dp)*dot_product(real(self%gap%a, dp), v)
        v = v + share*parted + off*real(change, dp)
      end associate
    end do
  end subroutine strike

  pure real(dp) function energy(self)
    !! The Jacobi energy ½ΣM(q̇² + β²q²) + ½m_j(ẏ² − ω²y²), which never grows. Without damping it is what the mass brought less
    !! what blows have taken, of which nothing cancels; with damping it is missing where fewer than three digits are left.
    class(contact_motion), intent(in) :: self
    real(qp), dimension(self%modes + 1) :: moving, bent
    real(qp), parameter :: worth = 1.0e-28_qp      ! three digits and more above rounding
    if (all(self%parts%c <= 0.0_qp)) then
      energy = rounded(0.5_qp*self%inertia(self%modes + 1) - self%lost)
      return
    end if
    moving = self%inertia*self%state%v**2
    bent = self%inertia*self%parts%square*self%state%u**2
    energy = missing
    if (abs(sum(moving + bent)) > worth*sum(moving + abs(bent))) energy = rounded(0.5_qp*sum(moving + bent))
  end function energy

  pure real(qp) function momentum(self)
    !! Generalised, of the first mode that the mass strikes, per unit of its displacement there.
    class(contact_motion), intent(in) :: self
    associate (mass => self%modes + 1, k => self%first)
      momentum = self%inertia(k)*self%state%v(k)/self%gap%a(k) + self%inertia(mass)*self%state%v(mass)
    end associate
  end function momentum

  pure real(dp) function data_error(self) result(error)
    !! By which the numbers that the motion follows from may be off, the worst of them, as a part of themselves. That nothing
    !! holds a mode is known exactly.
    class(contact_motion), intent(in) :: self
    real(dp) :: elastic(self%modes)
    associate (n => self%modes)
      elastic = real(self%parts%square(:n) + self%omega**2, dp)
      where (elastic == 0.0_dp) elastic = huge(elastic)
      error = maxval(self%parts%square_error(:n)/elastic + self%inertia_error(:n))
    end associate
  end function data_error

end module bw_contact_motion
