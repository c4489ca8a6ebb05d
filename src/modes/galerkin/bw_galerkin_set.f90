module bw_galerkin_set
  !! Modes that are known by the coefficients of their strains: shapes, overlaps and energies are sums of products, the
  !! polynomials being orthonormal.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, to_dd, operator(+)
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_strain_basis, only: basis_values, slope_of
  use bw_strain_set, only: products, strain_set
  implicit none (type, external)
  private

  type, public :: tip_body
    !! What the energy of the body at the tip depends on, beside its mass.
    real(dp) :: inertia = 0.0_dp                   !! J in m_i l²
    real(dp) :: pull = 0.0_dp                      !! T(1) = Ω²γ(1 + R), tension that the body's mass brings
    real(dp) :: compliance = 0.0_dp                !! s² of the beam
  end type tip_body

  type, extends(strain_set), public :: galerkin_set
    !! Of a uniform beam.
    real(dp), allocatable :: deflection(:, :)      !! coefficients of Φ, (functions, n)
    real(dp), allocatable :: turning(:, :)         !! coefficients of rψ; unallocated without shear, (functions, n)
    real(dp), allocatable :: strain(:, :)          !! curvatures, and shear strains over s, of modes of mass 1, (unknowns, n)
    type(tip_body) :: body
  contains
    procedure :: choose => choose_modes
    procedure :: some_shapes => galerkin_shapes
    procedure :: some_curvatures => galerkin_curvatures
    procedure :: overlap_with_mass
    procedure :: overlap_of_beam
    procedure :: elastic => galerkin_elastic
    procedure :: works => works_of_strains
    procedure :: body_energy => energy_of_body
  end type galerkin_set

contains

  subroutine choose_modes(self, number, chosen)
    class(galerkin_set), intent(in) :: self
    integer, intent(in) :: number(:)
    class(strain_set), allocatable, intent(out) :: chosen
    type(galerkin_set), allocatable :: found
    allocate (found)
    call found%take_numbers(self, number)
    found%body = self%body
    found%deflection = self%deflection(:, number)
    found%strain = self%strain(:, number)
    if (allocated(self%turning)) found%turning = self%turning(:, number)
    call move_alloc(found, chosen)
  end subroutine choose_modes

  pure function galerkin_shapes(self, first, last, xi) result(values)
    !! Φ_k(ξ): exactly 0 at the root, exactly `tip` at the tip.
    class(galerkin_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    integer :: p
    values = matmul(transpose(self%deflection(:, first:last)), basis_values(size(self%deflection, 1), xi))
    do p = 1, size(xi)
      if (xi(p) == 0.0_dp) values(:, p) = 0.0_dp
      if (xi(p) == 1.0_dp) values(:, p) = self%struck(first:last)
    end do
  end function galerkin_shapes

  pure function galerkin_curvatures(self, first, last, xi) result(values)
    !! Φ_k''(ξ), with shear ψ_k'(ξ): the first of the strains that the modes are known by. Exactly 0 at a tip that no body turns.
    class(galerkin_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    integer :: n, p
    n = size(self%deflection, 1) - 2
    values = matmul(transpose(self%strain(:n, first:last)), basis_values(n, xi))
    do p = 1, size(xi)
      values(:, p) = sqrt(self%modal_mass(first:last))*values(:, p)
      if (xi(p) == 1.0_dp .and. self%body%inertia == 0.0_dp) values(:, p) = 0.0_dp
    end do
  end function galerkin_curvatures

  function overlap_of_beam(self, from, amplitude, monitor) result(sums)
    !! ∫Φ_kφ_i dξ, and with shear of rψ too, from products of coefficients, p_j being orthonormal.
    class(galerkin_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor     ! not asked: it takes no time
    real(dp) :: sums(self%count)
    select type (from)
    class is (galerkin_set)
      sums = products(self%deflection, from%deflection, amplitude)
      if (allocated(self%turning)) sums = sums + products(self%turning, from%turning, amplitude)
      if (present(monitor)) continue
    class default
      error stop 'bw_galerkin: modes found in different ways have no overlap'
    end select
  end function overlap_of_beam

  function overlap_with_mass(self, from, amplitude, monitor) result(sums)
    !! `overlap_of_beam` and γΣ_i a_iΦ_k(1)φ_i(1) of the mass at the tip. A body's rotary inertia has no part: it arrives
    !! without spin.
    class(galerkin_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    sums = self%overlap_of_beam(from, amplitude, monitor) &
      + self%gamma*self%struck*sum(from%struck(:size(amplitude))*amplitude)
  end function overlap_with_mass

  pure function galerkin_elastic(self) result(squares)
    !! λ_k ≥ 0, from the strains, or from β² less what rotation adds where that is the smaller part and nothing cancels:
    !! exactly β² where nothing turns.
    class(galerkin_set), intent(in) :: self
    type(dd) :: squares(self%count)
    squares = to_dd(sum(self%strain**2, dim=1))
    where (abs(self%rotation) <= squares%hi) squares = self%beta_squared + to_dd(-self%rotation)
  end function galerkin_elastic

  pure function works_of_strains(self) result(works)
    class(galerkin_set), intent(in) :: self
    real(dp) :: works(self%count, self%count)
    works = matmul(transpose(self%strain), self%strain)
  end function works_of_strains

  pure function energy_of_body(self, q, rate) result(energy)
    !! ½Jψ̇² at the tip, and ½T(1)∫v'² dξ: how far the centrifugal force of the body has been drawn inwards. Rotation does no
    !! work on the turning of the body: in plane (ω + ψ̇)² leaves none, and out of plane the body is isotropic.
    class(galerkin_set), intent(in) :: self
    real(dp), intent(in) :: q(:), rate(:)          !! (modes)
    real(dp) :: energy(2)
    real(dp) :: strain(size(self%strain, 1))
    integer :: n
    n = size(self%deflection, 1) - 2
    strain = matmul(self%strain, sqrt(self%modal_mass)*q)
    associate (body => self%body, tip_rate => dot_product(self%strain(1, :), sqrt(self%modal_mass)*rate))
      energy(1) = 0.5_dp*body%inertia*tip_rate**2            ! ψ(1) is the first coefficient of the curvature
      energy(2) = 0.5_dp*body%pull*sum(slope_of(n, strain, body%compliance)**2)
    end associate
  end function energy_of_body

end module bw_galerkin_set
