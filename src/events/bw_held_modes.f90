module bw_held_modes
  !! Modes of the beam with a mass that is pressed against its tip: the n modes of the beam alone under v_tip = y, mass
  !! matrix M + m_jφφᵀ, stiffness that of the beam alone.
  !!
  !! With λ = β² + ω², M's square roots taken out and x = D^(−½)t, D = diag λ_i, the eigenproblem is that of
  !! D⁻¹ + m_jψψᵀ, ψ_i = φ_i(1)/√(M_iλ_i): a rank-one update, whose secular equation 1 + m_jΣψ_i²/(1/λ_i − μ) = 0 is
  !! solved for the distance of μ from the nearer pole. **Limits**: frequencies in binary64; the shapes are sums of n.
  use bw_double_double, only: dd, to_dd, operator(-)
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, stops
  implicit none (type, external)
  private
  public :: held_modes

  type, extends(mode_set), public :: held_set
    class(mode_set), allocatable :: free       !! modes of the beam alone
    real(dp), allocatable :: mixing(:, :)      !! how much of each is in a mode, (free modes, modes)
  contains
    procedure :: some_shapes => held_shapes
    procedure :: overlap_with_mass => held_overlap_with_mass
    procedure :: overlap_of_beam => held_overlap_of_beam
    procedure :: elastic => held_elastic
    procedure :: take => take_state
    procedure :: give => give_state
  end type held_set

  integer, parameter :: most_halvings = 1100   !! from the largest distance to the smallest number

contains

  subroutine held_modes(free, gamma, speed, held, monitor)
    !! All modes that the beam's own allow.
    class(mode_set), intent(in) :: free        !! of the beam alone
    real(dp), intent(in) :: gamma              !! mass ratio > 0
    real(dp), intent(in) :: speed              !! angular velocity in the plane of the motion, else 0
    type(held_set), intent(out) :: held
    class(monitor_type), intent(inout), optional :: monitor   !! the modes mean nothing where it asks to stop
    real(dp), dimension(free%count) :: pole, weight, mixed
    real(dp) :: scale
    integer :: k, n
    n = free%count
    allocate (held%free, source=free)
    held%count = n
    held%gamma = gamma
    allocate (held%mixing(n, n), held%beta_squared(n), held%tip(n), held%modal_mass(n))
    pole = 1.0_dp/(free%beta_squared%hi + speed**2)
    weight = free%tip*sqrt(pole/free%modal_mass)
    do k = 1, n
      if (stops(monitor)) return
      mixed = distances(pole, gamma*weight**2, k)
      held%beta_squared(k) = to_dd(1.0_dp/(pole(closest(mixed)) - mixed(closest(mixed)))) - to_dd(speed**2)
      mixed = weight/mixed*sqrt(pole/free%modal_mass)
      scale = merge(-1.0_dp, 1.0_dp, mod(k, 2) == 0)/sqrt(sum(free%modal_mass*mixed**2))
      held%mixing(:, k) = scale*mixed
      held%tip(k) = -scale/gamma               ! by the secular equation: the sum itself would cancel
      held%modal_mass(k) = 1.0_dp + gamma*held%tip(k)**2
    end do
    if (.not. allocated(free%damping)) return
    allocate (held%damping(n))
    do k = 1, n
      held%damping(k) = sum(free%modal_mass*free%damping*held%mixing(:, k)**2)/held%modal_mass(k)
    end do
  end subroutine held_modes

  pure integer function closest(distance)
    real(dp), intent(in) :: distance(:)
    closest = minloc(abs(distance), 1)
  end function closest

  pure function distances(pole, weight, k) result(distance)
    !! Of every pole from the eigenvalue above pole k: pole − μ. Poles descend.
    real(dp), intent(in) :: pole(:)            !! 1/λ_i
    real(dp), intent(in) :: weight(:)          !! m_jψ_i² > 0
    integer, intent(in) :: k
    real(dp) :: distance(size(pole)), origin(size(pole)), low, high, middle
    integer :: i
    high = sum(weight)                         ! the largest eigenvalue is no further above its pole
    if (k > 1) high = pole(k - 1) - pole(k)
    origin = pole - pole(k)
    low = 0.0_dp
    if (k > 1) then
      if (secular(origin - 0.5_dp*high, weight) < 0.0_dp) then    ! it lies nearer to the pole above
        origin = pole - pole(k - 1)
        low = -0.5_dp*high
        high = 0.0_dp
      else
        high = 0.5_dp*high
      end if
    end if
    do i = 1, most_halvings
      middle = 0.5_dp*(low + high)
      if (middle == low .or. middle == high) exit
      if (secular(origin - middle, weight) < 0.0_dp) then
        low = middle
      else
        high = middle
      end if
    end do
    distance = origin - merge(high, low, low == 0.0_dp)
  end function distances

  pure real(dp) function secular(distance, weight)
    !! 1 + Σw/(pole − μ): rises with μ between two poles.
    real(dp), intent(in) :: distance(:), weight(:)
    secular = 1.0_dp + sum(weight/distance)
  end function secular

  pure subroutine take_state(self, q, rate, mass_place, mass_rate, z, z_rate)
    !! The state of beam and mass in these modes: its projection with the weight of both, as a blow without rebound
    !! leaves it.
    class(held_set), intent(in) :: self
    real(dp), intent(in) :: q(:), rate(:)             !! of the beam alone
    real(dp), intent(in) :: mass_place, mass_rate     !! of the mass
    real(dp), intent(out) :: z(:), z_rate(:)
    z = (matmul(self%free%modal_mass*q, self%mixing) + self%gamma*mass_place*self%tip)/self%modal_mass
    z_rate = (matmul(self%free%modal_mass*rate, self%mixing) + self%gamma*mass_rate*self%tip)/self%modal_mass
  end subroutine take_state

  pure subroutine give_state(self, z, z_rate, q, rate)
    !! The same in the modes of the beam alone; the mass is at the tip.
    class(held_set), intent(in) :: self
    real(dp), intent(in) :: z(:), z_rate(:)
    real(dp), intent(out) :: q(:), rate(:)
    q = matmul(self%mixing, z)
    rate = matmul(self%mixing, z_rate)
  end subroutine give_state

  pure function held_shapes(self, first, last, xi) result(values)
    class(held_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    values = matmul(transpose(self%mixing(:, first:last)), self%free%shapes(xi))
  end function held_shapes

  function held_overlap_of_beam(self, from, amplitude, monitor) result(sums)
    class(held_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    sums = matmul(self%free%overlap_of_beam(from, amplitude, monitor), self%mixing)
  end function held_overlap_of_beam

  function held_overlap_with_mass(self, from, amplitude, monitor) result(sums)
    class(held_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    sums = self%overlap_of_beam(from, amplitude, monitor) &
      + self%gamma*self%tip*dot_product(from%tip(:size(amplitude)), amplitude)
  end function held_overlap_with_mass

  pure function held_elastic(self) result(squares)
    class(held_set), intent(in) :: self
    type(dd) :: squares(self%count), free(self%free%count)
    free = self%free%elastic()
    squares = to_dd(matmul(self%free%modal_mass*free%hi, self%mixing**2)/self%modal_mass)
  end function held_elastic

end module bw_held_modes
