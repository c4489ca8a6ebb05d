module bw_contact_modes
  !! Modes of a beam with a mass pressed against its tip: the n modes of the beam alone with the constraint v_tip = y,
  !! mass matrix M + m_jφφᵀ, and the stiffness of the beam alone.
  !!
  !! With λ = β² + ω², mass-normalised, and x = D^(−½)t, D = diag λ_i, this is the eigenproblem of D⁻¹ + m_jψψᵀ, ψ_i =
  !! φ_i(1)/√(M_iλ_i): a rank-one update. Its secular equation 1 + Σm_jψ_i²/(1/λ_i − μ) = 0 is solved for the distance
  !! of μ from the nearer pole. **Limits**: only the diagonal of the modal damping matrix is used.
  use bw_contact_motion, only: contact_motion
  use bw_double_double, only: dd, to_dd, operator(*), operator(+), operator(-)
  use bw_kinds, only: dp
  use bw_modal_flow, only: turning_square
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, stops
  use bw_oscillators, only: weighted_sum
  use bw_segment, only: alone
  implicit none (type, external)
  private
  public :: find_contact_modes

  type, extends(mode_set), public :: contact_set
    class(mode_set), allocatable :: free       !! modes of the beam alone
    real(dp), allocatable :: mixing(:, :)      !! coefficients of the modes of the beam alone, (free modes, modes)
    real(dp), allocatable :: onto(:, :)        !! weights for projecting a state: MΦ/M̄, m_jΦ_k(1)/M̄, (free modes + 1, modes)
    real(dp), allocatable :: rates(:)          !! c_k, 0 if undamped, (modes)
    type(weighted_sum) :: force                !! force between mass and tip (see `force_of`)
  contains
    procedure :: some_shapes => contact_shapes
    procedure :: some_curvatures => contact_curvatures
    procedure :: overlap => contact_overlap
    procedure :: elastic => contact_elastic
    procedure :: number_errors => contact_errors
  end type contact_set

contains

  subroutine find_contact_modes(free, motion, modes, monitor)
    !! Find as many modes as the beam alone has.
    class(mode_set), intent(in) :: free        !! of the beam alone
    type(contact_motion), intent(in) :: motion !! of that beam and the mass
    type(contact_set), intent(out) :: modes
    class(monitor_type), intent(inout), optional :: monitor   !! the modes are invalid if it requests a stop
    real(dp), parameter :: least_stiffness = 1.0e-27_dp    ! of the lowest squared frequencies: least stiffness for rigid modes
    real(dp), dimension(free%count) :: pole, weight, inertia, mixed, stiffness
    type(dd) :: square, spin
    real(dp) :: gamma, value
    integer :: k, n
    n = free%count
    gamma = motion%inertia(n + 1)
    inertia = motion%inertia(:n)
    allocate (modes%free, source=free)
    modes%count = n
    modes%gamma = gamma
    allocate (modes%mixing(n, n), modes%onto(n + 1, n), modes%struck(n), modes%modal_mass(n), modes%beta_squared(n))
    spin = -motion%parts(alone)%beta_squared(n + 1)                          ! ω²
    do k = 1, n
      square = free%beta_squared(k) + spin
      pole(k) = square%hi
    end do
    pole = 1.0_dp/max(pole, least_stiffness*maxval(pole(:min(n, 3))))
    do k = 2, n
      pole(k) = min(pole(k), pole(k - 1)*(1.0_dp - 4.0_dp*epsilon(pole)))      ! separates equal frequencies by rounding
    end do
    weight = max(tiny(gamma), gamma*motion%gap%a(:n)**2*pole/inertia)
    do k = 1, n
      if (stops(monitor)) return
      call find_distances(pole, weight, k, mixed, value)
      stiffness(k) = 1.0_dp/value
      modes%beta_squared(k) = to_dd(stiffness(k)) - spin
      mixed = gamma*motion%gap%a(:n)*pole/mixed/inertia
      value = merge(-1.0_dp, 1.0_dp, mod(k, 2) == 0)/sqrt(sum(inertia*mixed**2))
      modes%mixing(:, k) = value*mixed
      modes%struck(k) = -value                 ! by the secular equation, without cancellation
      modes%modal_mass(k) = 1.0_dp + gamma*value**2
      modes%onto(:, k) = [inertia*modes%mixing(:, k), gamma*modes%struck(k)]/modes%modal_mass(k)
    end do
    call find_damping(motion, modes)
    modes%force = force_of(motion, modes, stiffness)
  end subroutine find_contact_modes

  pure subroutine find_damping(motion, modes)
    !! Set the diagonal of modal damping.
    type(contact_motion), intent(in) :: motion
    type(contact_set), intent(inout) :: modes
    integer :: k, n
    n = modes%count
    allocate (modes%rates(n))
    do k = 1, n
      modes%rates(k) = sum(motion%parts(alone)%c(:n)*modes%onto(:n, k)*modes%mixing(:, k))
    end do
    if (.not. allocated(modes%free%damping)) return
    modes%damping = modes%rates
    modes%damped_squared = turning_square(modes%beta_squared, modes%rates)
  end subroutine find_damping

  pure type(weighted_sum) function force_of(motion, modes, stiffness) result(force)
    !! Return the force between mass and tip, positive under pressure, up to the factor 1/m_j + Σφ_i(1)²/M_i: the acceleration
    !! with which the gap would close, −φᵀ(q̈ of the beam alone) + ω²y. Without damping that force is −m_j(ÿ − ω²y), which has
    !! no cancellation. With damping, treated as uncoupled, only the acceleration shows when the gap really opens.
    type(contact_motion), intent(in) :: motion
    type(contact_set), intent(in) :: modes
    real(dp), intent(in) :: stiffness(:)       !! β² + ω², (modes)
    integer :: n
    n = modes%count
    force%a = modes%gamma/motion%yield()*stiffness*modes%struck
    force%b = matmul(motion%gap%a(:n)*motion%parts(alone)%c(:n), modes%mixing)
  end function force_of

  pure subroutine find_distances(pole, weight, k, distance, value)
    !! Find the eigenvalue above pole k, and its distances from all poles, pole − μ. Poles descend.
    real(dp), intent(in) :: pole(:)            !! 1/λ_i
    real(dp), intent(in) :: weight(:)          !! m_jψ_i² ≥ 0
    integer, intent(in) :: k
    real(dp), intent(out) :: distance(:), value
    real(dp) :: origin(size(pole)), last, x
    integer :: near
    near = k
    origin = pole - pole(k)
    if (k == 1) then                           ! the sum of all weights bounds its distance
      last = sum(weight)
    else
      last = 0.5_dp*(pole(k - 1) - pole(k))
      if (1.0_dp + sum(weight/(origin - last)) < 0.0_dp) then    ! nearer to the pole above
        near = k - 1
        origin = pole - pole(near)
        last = -last
      end if
    end if
    call find_offset(origin, weight, near, last, x)
    distance = origin - x
    value = pole(near) + x
  end subroutine find_distances

  pure subroutine find_offset(origin, weight, near, last, x)
    !! Find the root x of 1 + Σm_jψ_i²/(p_i − p − x) = 0 between 0 and `last`. Newton steps on x times that function,
    !! which has no pole there, keep small roots accurate; bisection replaces steps out of the bracket.
    real(dp), intent(in) :: origin(:), weight(:)   !! p_i − p, m_jψ_i²
    integer, intent(in) :: near                !! index of the pole p
    real(dp), intent(in) :: last
    real(dp), intent(out) :: x
    real(dp), dimension(size(origin)) :: term, pull
    real(dp) :: low, high, slope, next
    integer, parameter :: most = 400
    integer :: i
    low = 0.0_dp                               ! the function is negative here
    high = last
    x = high
    do i = 1, most
      term = weight/(origin - x)
      pull = term/(origin - x)
      term(near) = 0.0_dp
      pull(near) = 0.0_dp
      if (x*(1.0_dp + sum(term)) < weight(near)) then
        low = x
      else
        high = x
      end if
      slope = 1.0_dp + sum(term) + x*sum(pull)
      next = (weight(near) + x**2*sum(pull))/slope
      if (.not. (abs(next - low) <= abs(high - low) .and. abs(next - high) <= abs(high - low))) next = 0.5_dp*(low + high)
      if (abs(next - x) <= 2.0_dp*epsilon(x)*abs(x)) exit
      x = next
    end do
  end subroutine find_offset

  pure function contact_shapes(self, first, last, xi) result(values)
    !! Return Φ_k(ξ), combinations of the shapes of the beam alone.
    class(contact_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    values = matmul(transpose(self%mixing(:, first:last)), self%free%some_shapes(1, self%free%count, xi))
  end function contact_shapes

  pure function contact_curvatures(self, first, last, xi) result(values)
    class(contact_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    values = matmul(transpose(self%mixing(:, first:last)), self%free%some_curvatures(1, self%free%count, xi))
  end function contact_curvatures

  function contact_overlap(self, from, amplitude, with_mass, monitor) result(sums)
    !! Return the overlaps with a motion: combinations of those of the beam alone, and the part of the mass at the tip.
    class(contact_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    logical, intent(in) :: with_mass
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    sums = matmul(self%free%overlap(from, amplitude, .false., monitor), self%mixing)
    if (with_mass) sums = sums + self%gamma*self%struck*dot_product(from%struck(:size(amplitude)), amplitude)
  end function contact_overlap

  pure subroutine contact_errors(self, square_error, mass_error)
    !! Return the errors of β², and relative errors of damping and modal mass: those of the beam alone, and rounding.
    class(contact_set), intent(in) :: self
    real(dp), intent(out) :: square_error(:), mass_error(:)
    real(dp), dimension(self%count) :: free_error, free_mass_error
    type(dd) :: elastic(self%count)
    call self%free%number_errors(free_error, free_mass_error)
    elastic = self%free%elastic()
    free_error = free_error + (free_mass_error + epsilon(1.0_dp))*(elastic%hi + abs(self%free%beta_squared%hi))
    square_error = matmul(free_error, self%onto(:self%count, :)*self%mixing)
    mass_error = matmul(free_mass_error, self%onto(:self%count, :)*self%mixing)
  end subroutine contact_errors

  pure function contact_elastic(self) result(squares)
    !! Return K_kk/M_kk. Elastic energy is that of the beam alone.
    class(contact_set), intent(in) :: self
    type(dd) :: squares(self%count), free(self%free%count)
    free = self%free%elastic()
    squares = to_dd(matmul(self%free%modal_mass*free%hi, self%mixing**2)/self%modal_mass)
  end function contact_elastic

end module bw_contact_modes
