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
  use bw_strain_basis, only: basis_values, tip_value
  use bw_strain_modes, only: solve_strain_modes, strain_modes
  implicit none (type, external)
  private
  public :: galerkin_modes, galerkin_source_of

  type, extends(mode_set), public :: galerkin_set
    !! Shapes have ∫Φ² dξ = 1 and a tip value of sign (−1)^k.
    real(dp), allocatable :: deflection(:, :)      !! coefficients of Φ, (functions, n)
    real(dp), allocatable :: turning(:, :)         !! coefficients of rψ; unallocated without shear, (functions, n)
    real(dp), allocatable :: strain(:, :)          !! curvatures, and shear strains over s, of modes of mass 1, (unknowns, n)
    logical :: resolved = .false.                  !! the basis could hold the modes
  contains
    procedure :: shapes => galerkin_shapes
    procedure :: overlap_with_mass
    procedure :: overlap_of_beam
    procedure :: elastic => galerkin_elastic
    procedure :: coupling
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
    rows = modes%system%functions + 2
    set%count = count
    set%gamma = operator%gamma
    set%resolved = modes%resolved
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

  pure function galerkin_shapes(self, xi) result(values)
    class(galerkin_set), intent(in) :: self
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(self%count, size(xi))
    integer :: p
    values = matmul(transpose(self%deflection), basis_values(size(self%deflection, 1), xi))
    do p = 1, size(xi)
      if (xi(p) == 0.0_dp) values(:, p) = 0.0_dp
      if (xi(p) == 1.0_dp) values(:, p) = self%tip
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
