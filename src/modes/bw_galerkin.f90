module bw_galerkin
  !! Modes of a beam whose shapes have no closed form: with tension, with shear, or with a body at the tip that has
  !! rotary inertia.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_critical_speed, only: critical_speed_of
  use bw_damping, only: damping_law
  use bw_double_double, only: dd, to_dd, operator(*), operator(-), operator(/)
  use bw_local_waves, only: find_waves
  use bw_mode_set, only: mode_set, mode_source
  use bw_missing, only: missing
  use bw_strain_basis, only: basis_values, integral, tip_value
  use bw_strain_modes, only: solve_strain_modes, strain_modes
  implicit none (type, external)
  private
  public :: galerkin_modes, galerkin_source_of

  type :: tip_body
    !! What the energy of the body at the tip takes, beside its mass.
    real(dp) :: inertia = 0.0_dp                   !! J in m_i l²
    real(dp) :: spin_squared = 0.0_dp              !! Ω² out of plane, where it acts on the turning; else 0
    real(dp) :: pull = 0.0_dp                      !! T(1), tension that the body's mass brings
    real(dp) :: compliance = 0.0_dp                !! s² of the beam
  end type tip_body

  type, extends(mode_set), public :: galerkin_set
    !! Shapes have ∫Φ² dξ = 1 and a tip value of sign (−1)^k.
    real(dp), allocatable :: deflection(:, :)      !! coefficients of Φ, (functions, n)
    real(dp), allocatable :: turning(:, :)         !! coefficients of rψ; unallocated without shear, (functions, n)
    real(dp), allocatable :: strain(:, :)          !! curvatures, and shear strains over s, of modes of mass 1, (unknowns, n)
    type(tip_body) :: body
  contains
    procedure :: some_shapes => galerkin_shapes
    procedure :: overlap_with_mass
    procedure :: overlap_of_beam
    procedure :: elastic => galerkin_elastic
    procedure :: coupling
    procedure :: body_energy => energy_of_body
  end type galerkin_set

  type, extends(mode_source), public :: galerkin_source
    type(galerkin_set) :: solved                   !! the first modes, from which others are taken
  contains
    procedure :: find => find_among_solved
  end type galerkin_source

  real(dp), parameter :: heavy = 1.0e-4_dp
    !! γ from which √γ v(1) carries more digits of v(1) than the sum of its coefficients

contains

  subroutine galerkin_modes(operator, count, set)
    !! The first `count` modes.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count                   !! ≥ 1
    type(galerkin_set), intent(out) :: set
    type(strain_modes) :: modes
    integer :: rows
    call solve_strain_modes(operator, count, modes)
    set%count = count
    set%gamma = operator%gamma
    set%body = body_of(operator)
    set%resolved = modes%resolved
    if (.not. set%resolved) then
      call leave_empty(set)
      return
    end if
    rows = modes%system%functions + 2
    set%deflection = modes%motion(:rows, :)
    if (modes%system%turn_row > 0) &
      set%turning = modes%motion(modes%system%turn_row:modes%system%turn_row + rows - 2, :)
    call move_alloc(modes%strain, set%strain)
    set%tip = tip_values(operator%gamma, modes)
    call normalise(set)
    set%beta_squared = squares_of(modes%period, modes%system%shift)
    allocate (set%alpha(count), set%phase_velocity(count), set%group_velocity(count))
    call find_waves(operator, set%beta_squared, set%alpha, set%phase_velocity, set%group_velocity)
    set%critical_speed = critical_speed_of(operator)
  end subroutine galerkin_modes

  pure subroutine leave_empty(set)
    !! A set whose modes could not be found: arrays of the right lengths, in which nothing moves.
    type(galerkin_set), intent(inout) :: set
    integer :: n
    n = set%count
    allocate (set%alpha(n), set%phase_velocity(n), set%group_velocity(n), source=missing)
    allocate (set%modal_mass(n), source=1.0_dp)
    allocate (set%tip(n), set%deflection(2, n), set%strain(2, n), source=0.0_dp)
    allocate (set%beta_squared(n), source=dd())
  end subroutine leave_empty

  pure type(tip_body) function body_of(operator) result(body)
    type(beam_operator), intent(in) :: operator
    if (allocated(operator%tip_inertia)) body%inertia = operator%tip_inertia
    if (allocated(operator%omega) .and. .not. operator%in_plane) body%spin_squared = operator%omega%hi**2
    if (allocated(operator%tension)) body%pull = sum(operator%tension)
    if (allocated(operator%shear)) body%compliance = operator%shear%compliance
  end function body_of

  pure function tip_values(gamma, modes) result(tip)
    !! v(1) of modes of norm 1, from the row of the tip mass or from the coefficients, whichever is sharper.
    real(dp), intent(in) :: gamma
    type(strain_modes), intent(in) :: modes
    real(dp) :: tip(size(modes%period))
    integer :: k
    if (gamma > heavy) then
      tip = modes%motion(modes%system%tip_row, :)/sqrt(gamma)
    else
      tip = [(tip_value(modes%motion(:modes%system%functions + 2, k)), k=1, size(tip))]
    end if
  end function tip_values

  pure subroutine normalise(set)
    !! From norm 1 of all that moves to ∫Φ² dξ = 1.
    type(galerkin_set), intent(inout) :: set
    real(dp) :: scale
    integer :: k
    allocate (set%modal_mass(set%count))
    do k = 1, set%count
      scale = 1.0_dp/norm2(set%deflection(:, k))
      set%modal_mass(k) = scale**2
      if (mod(k, 2) == 0 .neqv. set%tip(k) > 0.0_dp) scale = -scale
      if (scale < 0.0_dp) set%strain(:, k) = -set%strain(:, k)
      set%tip(k) = scale*set%tip(k)
      set%deflection(:, k) = scale*set%deflection(:, k)
      if (allocated(set%turning)) set%turning(:, k) = scale*set%turning(:, k)
    end do
  end subroutine normalise

  elemental type(dd) function squares_of(period, shift) result(beta_squared)
    real(dp), intent(in) :: period
    type(dd), intent(in) :: shift
    type(dd) :: p
    p = to_dd(period)
    beta_squared = to_dd(1.0_dp)/(p*p) - shift
  end function squares_of

  pure function galerkin_shapes(self, first, last, xi) result(values)
    class(galerkin_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    integer :: p
    values = matmul(transpose(self%deflection(:, first:last)), basis_values(size(self%deflection, 1), xi))
    do p = 1, size(xi)
      if (xi(p) == 0.0_dp) values(:, p) = 0.0_dp
      if (xi(p) == 1.0_dp) values(:, p) = self%tip(first:last)
    end do
  end function galerkin_shapes

  pure function overlap_of_beam(self, from, amplitude) result(sums)
    !! The coefficients' products: p_j are orthonormal.
    class(galerkin_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(self%count)
    select type (from)
    class is (galerkin_set)
      sums = products(self%deflection, from%deflection, amplitude)
      if (allocated(self%turning)) sums = sums + products(self%turning, from%turning, amplitude)
    class default
      error stop 'bw_galerkin: modes found in different ways have no overlap'
    end select
  end function overlap_of_beam

  pure function overlap_with_mass(self, from, amplitude) result(sums)
    !! A body's rotary inertia has no part: it arrives without spin.
    class(galerkin_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(self%count)
    sums = self%overlap_of_beam(from, amplitude) + self%gamma*self%tip*sum(from%tip*amplitude)
  end function overlap_with_mass

  pure function galerkin_elastic(self) result(squares)
    class(galerkin_set), intent(in) :: self
    real(dp) :: squares(self%count)
    squares = sum(self%strain**2, dim=1)
  end function galerkin_elastic

  real(dp) function coupling(self, law) result(ratio)
    !! The largest ratio of what damping couples two modes to what it takes from each, |C_ij|/√(C_iiC_jj): of a matrix that
    !! is taken as diagonal.
    class(galerkin_set), intent(in) :: self
    type(damping_law), intent(in) :: law           !! Rayleigh's: a ratio of each mode couples none
    real(dp) :: gram(self%count, self%count), rate(self%count)
    integer :: i, j
    gram = matmul(transpose(self%strain), self%strain)
    rate = law%rates(self%elastic())
    ratio = 0.0_dp
    do j = 1, self%count
      do i = 1, j - 1
        if (rate(i) > 0.0_dp .and. rate(j) > 0.0_dp) ratio = max(ratio, law%stiffness*abs(gram(i, j))/sqrt(rate(i)*rate(j)))
      end do
    end do
  end function coupling

  pure function energy_of_body(self, q, rate) result(energy)
    !! ½J(ψ̇² [− Ω²ψ²]) at the tip, and ½T(1)∫v'² dξ: how far the centrifugal force of the body has been drawn inwards.
    class(galerkin_set), intent(in) :: self
    real(dp), intent(in) :: q(:), rate(:)          !! (modes)
    real(dp) :: energy(2)
    real(dp) :: strain(size(self%strain, 1))
    integer :: n
    n = size(self%deflection, 1) - 2
    strain = matmul(self%strain, sqrt(self%modal_mass)*q)
    associate (body => self%body, tip_rate => dot_product(self%strain(1, :), sqrt(self%modal_mass)*rate))
      energy(1) = 0.5_dp*body%inertia*tip_rate**2            ! ψ(1) is the first coefficient of the curvature
      energy(2) = 0.5_dp*body%pull*slope_square(n, strain, body%compliance) &
        - 0.5_dp*body%inertia*body%spin_squared*strain(1)**2
    end associate
  end function energy_of_body

  pure real(dp) function slope_square(n, strain, compliance)
    !! ∫v'² dξ, v' = ψ and the shear strain.
    integer, intent(in) :: n                       !! functions of each strain
    real(dp), intent(in) :: strain(:)              !! (n), or (2n) with shear
    real(dp), intent(in) :: compliance             !! s²
    real(dp) :: slope(n + 1)
    slope = integral(strain(:n))
    if (size(strain) > n) slope(:n) = slope(:n) + sqrt(compliance)*strain(n + 1:)
    slope_square = sum(slope**2)
  end function slope_square

  pure function products(onto, from, amplitude) result(sums)
    real(dp), intent(in) :: onto(:, :), from(:, :)         !! coefficients, (functions, modes)
    real(dp), intent(in) :: amplitude(:)
    real(dp) :: sums(size(onto, 2))
    integer :: n
    n = min(size(onto, 1), size(from, 1))
    sums = matmul(matmul(from(:n, :), amplitude), onto(:n, :))
  end function products

  subroutine galerkin_source_of(operator, count, source)
    !! The first `count` modes, and none beyond them.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count
    type(galerkin_source), intent(out) :: source
    call galerkin_modes(operator, count, source%solved)
    source%gamma = operator%gamma
    source%highest = count
    source%decay = decay_of(operator, count)
  end subroutine galerkin_source_of

  pure real(dp) function decay_of(operator, count) result(decay)
    !! Of |Φ_k(1)Φ_k(ξ)|/(M_kβ_k) beyond mode `count`: k⁻³ in a beam that its tip mass holds, α being above 1/γ. Where
    !! the mass is light, or waves are those of shear or of a string, k⁻².
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count
    real(dp) :: alpha
    alpha = count*acos(-1.0_dp)
    decay = 3.0_dp
    if (alpha*operator%gamma < 1.0_dp .or. allocated(operator%shear)) decay = 2.0_dp
    if (.not. allocated(operator%tension)) return
    if (alpha**2 < operator%tension(1)) decay = 2.0_dp
  end function decay_of

  subroutine find_among_solved(self, number, modes, longest)
    !! `longest` has no use here: β² has the digits that it has.
    class(galerkin_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    type(galerkin_set), allocatable :: found
    allocate (found)
    associate (all => self%solved)
      found%count = size(number)
      found%gamma = all%gamma
      found%resolved = all%resolved
      found%body = all%body
      found%critical_speed = all%critical_speed
      found%alpha = all%alpha(number)
      found%beta_squared = all%beta_squared(number)
      found%tip = all%tip(number)
      found%modal_mass = all%modal_mass(number)
      found%phase_velocity = all%phase_velocity(number)
      found%group_velocity = all%group_velocity(number)
      found%deflection = all%deflection(:, number)
      found%strain = all%strain(:, number)
      if (allocated(all%turning)) found%turning = all%turning(:, number)
    end associate
    call found%damp(self%damping)
    if (present(longest)) continue
    call move_alloc(found, modes)
  end subroutine find_among_solved

end module bw_galerkin
