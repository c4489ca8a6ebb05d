module bw_contact_modes
  !! Modes of the beam with a mass that is pressed against its tip: the n modes of the beam alone under v_tip = y, mass
  !! matrix M + m_jφφᵀ, stiffness that of the beam alone.
  !!
  !! With λ = β² + ω², M's square roots taken out and x = D^(−½)t, D = diag λ_i, the eigenproblem is that of
  !! D⁻¹ + m_jψψᵀ, ψ_i = φ_i(1)/√(M_iλ_i): a rank-one update, whose secular equation 1/m_j + Σψ_i²/(1/λ_i − μ) = 0 is
  !! solved for the distance of μ from the nearer pole, in binary128. **Limits**: of the damping that couples them only the
  !! diagonal is taken.
  use bw_contact_motion, only: contact_motion
  use bw_double_double, only: dd, to_dd
  use bw_kinds, only: dp, qp
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, stops
  use bw_oscillators, only: oscillators, weighted_sum
  implicit none (type, external)
  private
  public :: find_contact_modes

  type, extends(mode_set), public :: contact_set
    class(mode_set), allocatable :: free       !! modes of the beam alone
    type(oscillators) :: parts                 !! these modes in binary128
    real(qp), allocatable :: mixing(:, :)      !! how much of each mode of the beam alone is in a mode, (free modes, modes)
    real(qp), allocatable :: tip_in_full(:)    !! Φ_k(1), (modes)
    real(qp), allocatable :: onto(:, :)        !! weights of a state's projection: MΦ/M̄, m_jΦ_k(1)/M̄, (free modes + 1, modes)
    type(weighted_sum) :: force                !! what presses the mass against the tip (see `force_of`)
  contains
    procedure :: some_shapes => contact_shapes
    procedure :: some_curvatures => contact_curvatures
    procedure :: overlap_with_mass => contact_overlap_with_mass
    procedure :: overlap_of_beam => contact_overlap_of_beam
    procedure :: elastic => contact_elastic
  end type contact_set

contains

  subroutine find_contact_modes(free, motion, modes, monitor)
    !! All modes that the beam's own allow.
    class(mode_set), intent(in) :: free        !! of the beam alone
    type(contact_motion), intent(in) :: motion !! of that beam and the mass
    type(contact_set), intent(out) :: modes
    class(monitor_type), intent(inout), optional :: monitor   !! the modes mean nothing where it asks to stop
    real(qp), parameter :: at_rest = 1.0e-27_qp    ! of the first frequencies' squares: what nothing holds is held by that much
    real(qp), dimension(free%count) :: pole, weight, inertia, mixed
    real(qp) :: gamma, scale, mass
    integer :: k, n
    n = free%count
    gamma = motion%inertia(n + 1)
    inertia = motion%inertia(:n)
    allocate (modes%free, source=free)
    modes%count = n
    modes%gamma = real(gamma, dp)
    allocate (modes%mixing(n, n), modes%onto(n + 1, n), modes%tip_in_full(n), modes%modal_mass(n), modes%parts%square(n))
    pole = motion%parts%square(:n) + motion%omega**2
    pole = 1.0_qp/max(pole, at_rest*maxval(pole(:min(n, 3))))
    do k = 2, n
      pole(k) = min(pole(k), pole(k - 1)*(1.0_qp - 4.0_qp*epsilon(pole)))      ! the same frequency twice is so only to rounding
    end do
    weight = motion%gap%a(:n)**2*pole/inertia
    do k = 1, n
      if (stops(monitor)) return
      call find_distances(pole, weight, 1.0_qp/gamma, k, mixed, modes%parts%square(k))
      modes%parts%square(k) = 1.0_qp/modes%parts%square(k) - motion%omega**2
      mixed = motion%gap%a(:n)*pole/mixed/inertia
      scale = merge(-1.0_qp, 1.0_qp, mod(k, 2) == 0)/sqrt(sum(inertia*mixed**2))
      modes%mixing(:, k) = scale*mixed
      modes%tip_in_full(k) = -scale/gamma       ! by the secular equation: the sum itself would cancel
      mass = 1.0_qp + gamma*modes%tip_in_full(k)**2
      modes%onto(:, k) = [inertia*modes%mixing(:, k), gamma*modes%tip_in_full(k)]/mass
      modes%modal_mass(k) = real(mass, dp)
    end do
    modes%struck = real(modes%tip_in_full, dp)
    call find_damping(motion, modes)
    call find_errors(motion, modes)
    modes%force = force_of(motion, modes)
  end subroutine find_contact_modes

  pure subroutine find_damping(motion, modes)
    !! The diagonal of what damps them.
    type(contact_motion), intent(in) :: motion
    type(contact_set), intent(inout) :: modes
    integer :: k, n
    n = modes%count
    modes%beta_squared = to_dd(modes%parts%square)
    allocate (modes%parts%c(n))
    do k = 1, n
      modes%parts%c(k) = sum(motion%parts%c(:n)*modes%onto(:n, k)*modes%mixing(:, k))
    end do
    call modes%parts%ready()
    if (.not. allocated(modes%free%damping)) return
    modes%damping = real(modes%parts%c, dp)
    modes%damped_squared = to_dd(modes%parts%square - 0.25_qp*modes%parts%c**2)
  end subroutine find_damping

  pure subroutine find_errors(motion, modes)
    !! By which β² and c may be off where those of the beam alone are, and its modal masses.
    type(contact_motion), intent(in) :: motion
    type(contact_set), intent(inout) :: modes
    real(dp), dimension(modes%count) :: share, stiffness
    integer :: k, n
    n = modes%count
    stiffness = real(motion%parts%square(:n) + motion%omega**2, dp)
    allocate (modes%parts%square_error(n), modes%parts%c_error(n))
    do k = 1, n
      share = real(modes%onto(:n, k)*modes%mixing(:, k), dp)
      modes%parts%square_error(k) = sum(share*(motion%parts%square_error(:n) + motion%inertia_error(:n)*stiffness))
      modes%parts%c_error(k) = sum(share*(motion%parts%c_error(:n) + motion%inertia_error(:n)*real(motion%parts%c(:n), dp)))
    end do
  end subroutine find_errors

  pure type(weighted_sum) function force_of(motion, modes) result(force)
    !! What presses the mass against the tip, positive while it does: the acceleration with which the gap would close,
    !! −φᵀ(q̈ of the beam alone) + ω²y: the force between them times 1/m_j + Σφ_i(1)²/M_i. Where they are damped, and the modes
    !! modes are taken as uncoupled, only this tells when the gap really opens.
    type(contact_motion), intent(in) :: motion
    type(contact_set), intent(in) :: modes
    integer :: k, n
    n = modes%count
    allocate (force%a(n), force%b(n))
    do k = 1, n
      force%b(k) = sum(motion%gap%a(:n)*motion%parts%c(:n)*modes%mixing(:, k))
      force%a(k) = sum(motion%gap%a(:n)*motion%parts%square(:n)*modes%mixing(:, k)) + motion%omega**2*modes%tip_in_full(k)
    end do
  end function force_of

  pure subroutine find_distances(pole, weight, lightness, k, distance, value)
    !! Of every pole from the eigenvalue above pole k, pole − μ, and that eigenvalue. Poles descend.
    real(qp), intent(in) :: pole(:)            !! 1/λ_i
    real(qp), intent(in) :: weight(:)          !! ψ_i² > 0
    real(qp), intent(in) :: lightness          !! 1/m_j
    integer, intent(in) :: k
    real(qp), intent(out) :: distance(:), value
    real(qp) :: origin(size(pole)), last, x
    integer :: near
    near = k
    origin = pole - pole(k)
    if (k == 1) then                           ! it is no further above its pole than all weights together
      last = sum(weight)/lightness
    else
      last = 0.5_qp*(pole(k - 1) - pole(k))
      if (lightness + sum(weight/(origin - last)) < 0.0_qp) then    ! it lies nearer to the pole above
        near = k - 1
        origin = pole - pole(near)
        last = -last
      end if
    end if
    call find_offset(origin, weight, lightness, near, last, x)
    distance = origin - x
    value = pole(near) + x
  end subroutine find_distances

  pure subroutine find_offset(origin, weight, lightness, near, last, x)
    !! The root x of 1/m_j + Σψ_i²/(p_i − p − x) = 0 between 0 and `last`, by Newton's steps on x times that, which has no
    !! pole there, in a form that keeps small roots; by halving where one leads out.
    real(qp), intent(in) :: origin(:), weight(:), lightness    !! p_i − p, ψ_i², 1/m_j
    integer, intent(in) :: near                !! the pole p itself
    real(qp), intent(in) :: last
    real(qp), intent(out) :: x
    real(qp), dimension(size(origin)) :: term, pull
    real(qp) :: low, high, slope, next
    integer, parameter :: most = 400
    integer :: i
    low = 0.0_qp                               ! where the value is negative
    high = last
    x = high
    do i = 1, most
      term = weight/(origin - x)
      pull = term/(origin - x)
      term(near) = 0.0_qp
      pull(near) = 0.0_qp
      if (x*(lightness + sum(term)) < weight(near)) then
        low = x
      else
        high = x
      end if
      slope = lightness + sum(term) + x*sum(pull)
      next = (weight(near) + x**2*sum(pull))/slope
      if (.not. (abs(next - low) <= abs(high - low) .and. abs(next - high) <= abs(high - low))) next = 0.5_qp*(low + high)
      if (abs(next - x) <= 2.0_qp*epsilon(x)*abs(x)) exit
      x = next
    end do
  end subroutine find_offset

  pure function contact_shapes(self, first, last, xi) result(values)
    !! Φ_k(ξ): the shapes of the beam alone, mixed.
    class(contact_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    values = matmul(transpose(real(self%mixing(:, first:last), dp)), self%free%some_shapes(1, self%free%count, xi))
  end function contact_shapes

  pure function contact_curvatures(self, first, last, xi) result(values)
    class(contact_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    values = matmul(transpose(real(self%mixing(:, first:last), dp)), self%free%some_curvatures(1, self%free%count, xi))
  end function contact_curvatures

  function contact_overlap_of_beam(self, from, amplitude, monitor) result(sums)
    !! What these modes see of a motion with the beam's own weight: what those of the beam alone see, mixed.
    class(contact_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    sums = matmul(self%free%overlap_of_beam(from, amplitude, monitor), real(self%mixing, dp))
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

  pure function contact_elastic(self) result(squares)
    !! K_kk/M_kk: elastic energy is that of the beam alone.
    class(contact_set), intent(in) :: self
    type(dd) :: squares(self%count), free(self%free%count)
    free = self%free%elastic()
    squares = to_dd(matmul(self%free%modal_mass*free%hi, real(self%mixing, dp)**2)/self%modal_mass)
  end function contact_elastic

end module bw_contact_modes
