module bw_contact_modes
  !! Modes of the beam with a mass that is pressed against its tip: the n modes of the beam alone under v_tip = y, mass
  !! matrix M + m_jφφᵀ, stiffness that of the beam alone.
  !!
  !! With λ = β² + ω², M's square roots taken out and x = D^(−½)t, D = diag λ_i, the eigenproblem is that of
  !! D⁻¹ + m_jψψᵀ, ψ_i = φ_i(1)/√(M_iλ_i): a rank-one update, whose secular equation 1 + Σm_jψ_i²/(1/λ_i − μ) = 0 is
  !! solved for the distance of μ from the nearer pole. **Limits**: of the damping that couples them only the diagonal is taken.
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
    real(dp), allocatable :: mixing(:, :)      !! how much of each mode of the beam alone is in a mode, (free modes, modes)
    real(dp), allocatable :: onto(:, :)        !! weights of a state's projection: MΦ/M̄, m_jΦ_k(1)/M̄, (free modes + 1, modes)
    real(dp), allocatable :: rates(:)          !! c_k, 0 where nothing damps, (modes)
    type(weighted_sum) :: force                !! what presses the mass against the tip (see `force_of`)
  contains
    procedure :: some_shapes => contact_shapes
    procedure :: some_curvatures => contact_curvatures
    procedure :: overlap_with_mass => contact_overlap_with_mass
    procedure :: overlap_of_beam => contact_overlap_of_beam
    procedure :: elastic => contact_elastic
    procedure :: number_errors => contact_errors
  end type contact_set

contains

  subroutine find_contact_modes(free, motion, modes, monitor)
    !! All modes that the beam's own allow.
    class(mode_set), intent(in) :: free        !! of the beam alone
    type(contact_motion), intent(in) :: motion !! of that beam and the mass
    type(contact_set), intent(out) :: modes
    class(monitor_type), intent(inout), optional :: monitor   !! the modes are invalid if it requests a stop
    real(dp), parameter :: at_rest = 1.0e-27_dp    ! of the first frequencies' squares: what nothing holds is held by that much
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
    pole = 1.0_dp/max(pole, at_rest*maxval(pole(:min(n, 3))))
    do k = 2, n
      pole(k) = min(pole(k), pole(k - 1)*(1.0_dp - 4.0_dp*epsilon(pole)))      ! the same frequency twice is so only to rounding
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
      modes%struck(k) = -value                 ! by the secular equation: the sum itself would cancel
      modes%modal_mass(k) = 1.0_dp + gamma*value**2
      modes%onto(:, k) = [inertia*modes%mixing(:, k), gamma*modes%struck(k)]/modes%modal_mass(k)
    end do
    call find_damping(motion, modes)
    modes%force = force_of(motion, modes, stiffness)
  end subroutine find_contact_modes

  pure subroutine find_damping(motion, modes)
    !! The diagonal of what damps them.
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
    !! What presses the mass against the tip, positive while it does: the acceleration with which the gap would close,
    !! −φᵀ(q̈ of the beam alone) + ω²y: the force between them times 1/m_j + Σφ_i(1)²/M_i. Without damping the force is
    !! −m_j(ÿ − ω²y), of which nothing cancels. Where they are damped, and the modes are taken as uncoupled, only the
    !! acceleration tells when the gap really opens.
    type(contact_motion), intent(in) :: motion
    type(contact_set), intent(in) :: modes
    real(dp), intent(in) :: stiffness(:)       !! β² + ω², (modes)
    integer :: n
    n = modes%count
    force%a = modes%gamma/motion%yield()*stiffness*modes%struck
    force%b = matmul(motion%gap%a(:n)*motion%parts(alone)%c(:n), modes%mixing)
  end function force_of

  pure subroutine find_distances(pole, weight, k, distance, value)
    !! Of every pole from the eigenvalue above pole k, pole − μ, and that eigenvalue. Poles descend.
    real(dp), intent(in) :: pole(:)            !! 1/λ_i
    real(dp), intent(in) :: weight(:)          !! m_jψ_i² ≥ 0
    integer, intent(in) :: k
    real(dp), intent(out) :: distance(:), value
    real(dp) :: origin(size(pole)), last, x
    integer :: near
    near = k
    origin = pole - pole(k)
    if (k == 1) then                           ! it is no further above its pole than all weights together
      last = sum(weight)
    else
      last = 0.5_dp*(pole(k - 1) - pole(k))
      if (1.0_dp + sum(weight/(origin - last)) < 0.0_dp) then    ! it lies nearer to the pole above
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
    !! The root x of 1 + Σm_jψ_i²/(p_i − p − x) = 0 between 0 and `last`, by Newton's steps on x times that, which has no
    !! pole there, in a form that keeps small roots; by halving where one leads out.
    real(dp), intent(in) :: origin(:), weight(:)   !! p_i − p, m_jψ_i²
    integer, intent(in) :: near                !! the pole p itself
    real(dp), intent(in) :: last
    real(dp), intent(out) :: x
    real(dp), dimension(size(origin)) :: term, pull
    real(dp) :: low, high, slope, next
    integer, parameter :: most = 400
    integer :: i
    low = 0.0_dp                               ! where the value is negative
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
    !! Φ_k(ξ): the shapes of the beam alone, mixed.
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

  function contact_overlap_of_beam(self, from, amplitude, monitor) result(sums)
    !! What these modes see of a motion with the beam's own weight: what those of the beam alone see, mixed.
    class(contact_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    sums = matmul(self%free%overlap_of_beam(from, amplitude, monitor), self%mixing)
  end function contact_overlap_of_beam

  function contact_overlap_with_mass(self, from, amplitude, monitor) result(sums)
    !! The same with the weight of the mass at the tip.
    class(contact_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    sums = self%overlap_of_beam(from, amplitude, monitor) &
      + self%gamma*self%struck*dot_product(from%struck(:size(amplitude)), amplitude)
  end function contact_overlap_with_mass

  pure subroutine contact_errors(self, square_error, mass_error)
    !! By which β² and damping may be off where those of the beam alone are, and its modal masses; and rounding.
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
    !! K_kk/M_kk: elastic energy is that of the beam alone.
    class(contact_set), intent(in) :: self
    type(dd) :: squares(self%count), free(self%free%count)
    free = self%free%elastic()
    squares = to_dd(matmul(self%free%modal_mass*free%hi, self%mixing**2)/self%modal_mass)
  end function contact_elastic

end module bw_contact_modes
