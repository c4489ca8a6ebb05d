module bw_strain_system
  !! A beam with tension, shear, and mass and inertia at its tip, in a basis of strains.
  !!
  !! The unknowns are the coefficients z = (a, b) of the curvature κ = Σa_jp_j and, with shear, of the shear strain
  !! sΣb_jp_j. From the clamped end ψ = ∫κ, v' = ψ (+ shear strain), v = ∫v', so
  !!
  !! - the elastic stiffness is the identity: no locking;
  !! - mass is M = BᵀB, the rows of B being the coefficients of v and of rψ, and √γ v(1) and √J ψ(1): exact;
  !! - what tension adds is exact too, T being quadratic.
  !!
  !! With a body at the tip v(1) and ψ(1) stand for the strains that move it (bw_strain_basis).
  !!
  !! With the modes' equation A x = β²M x, S = A + σM is positive definite for the shift σ chosen here, even beyond a
  !! critical speed. With S = LLᵀ the singular values of B L⁻ᵀ are (β² + σ)^(−½) and its left singular vectors hold the
  !! coefficients of v and ψ: neither M nor v is ever a difference of large numbers, and all modes keep their digits.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_double_double, only: dd, operator(*)
  use bw_strain_basis, only: integral, integral_transposed, times_quadratic, tip_coordinates, tip_coordinates_of
  implicit none (type, external)
  private
  public :: build_system

  real(dp), parameter :: weak_turning = 0.25_dp
    !! (rΩ)² up to which the turning of the sections out of plane leaves A positive definite: π²/4 at most

  type, public :: strain_system
    integer :: functions = 0                    !! n, of each strain
    real(dp), allocatable :: stiffness(:, :)    !! S, (unknowns, unknowns)
    real(dp), allocatable :: mass_root(:, :)    !! B, (rows, unknowns): n + 2 for v, then what there is of ψ, γ and J
    integer :: turn_row = 0                     !! where the n + 1 rows of rψ begin; 0: none
    integer :: tip_row = 0                      !! the row √γ v(1); 0: none
    integer :: inertia_row = 0                  !! the row √J ψ(1); 0: none
    type(tip_coordinates), allocatable :: tip   !! unknowns of the tip; unallocated: there are none
    real(dp), allocatable :: force(:)           !! the row of v(1) in S, without the mass; unallocated where there is none
    real(dp), allocatable :: pushed(:)          !! the column of v(1) in B, likewise
    real(dp) :: mass = 0.0_dp                   !! γ at the tip
    real(dp) :: mass_weight = 0.0_dp            !! by which the mass enters S beside the shift
    type(dd) :: shift                           !! σ
  end type strain_system

  type :: shift_weights
    !! By how much the rows of B enter S beside what A has of them and the shift.
    real(dp) :: deflection = 0.0_dp, turning = 0.0_dp, inertia = 0.0_dp
  end type shift_weights

contains

  pure subroutine build_system(operator, functions, system)
    !! Build the factors of mass and stiffness for n functions of each strain.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: functions                 !! n ≥ 3
    type(strain_system), intent(out) :: system
    type(shift_weights) :: weights
    integer :: strains, rows, j
    strains = merge(2, 1, allocated(operator%shear))
    system%functions = functions
    call place_rows(operator, system, rows)
    call choose_shift(operator, system%shift, weights)
    allocate (system%stiffness(strains*functions, strains*functions), source=0.0_dp)
    allocate (system%mass_root(rows, strains*functions), source=0.0_dp)
    do j = 1, strains*functions
      call set_column(operator, weights, j, system)
    end do
    if (max(system%tip_row, system%inertia_row) > 0) call add_body(operator, weights, system)
  end subroutine build_system

  pure subroutine place_rows(operator, system, rows)
    !! Say which rows of B stand for what, and how many there are.
    type(beam_operator), intent(in) :: operator
    type(strain_system), intent(inout) :: system
    integer, intent(out) :: rows
    rows = system%functions + 2
    if (allocated(operator%shear)) then
      system%turn_row = rows + 1
      rows = rows + system%functions + 1
    end if
    if (operator%gamma > 0.0_dp) then
      rows = rows + 1
      system%tip_row = rows
    end if
    if (allocated(operator%tip_inertia)) then
      rows = rows + 1
      system%inertia_row = rows
    end if
  end subroutine place_rows

  pure subroutine choose_shift(operator, shift, weights)
    !! Choose σ. In plane A = K − Ω²(mass of v): σ = Ω² leaves K and Ω² times the other masses. Out of plane
    !! A = K − Ω²(inertia of ψ), which is positive definite without a shift where rotation is slow.
    type(beam_operator), intent(in) :: operator
    type(dd), intent(out) :: shift
    type(shift_weights), intent(out) :: weights
    real(dp) :: square
    if (.not. allocated(operator%omega)) return
    square = operator%omega%hi**2
    if (operator%in_plane) then
      shift = operator%omega*operator%omega
      weights = shift_weights(0.0_dp, square, square)
    else if (allocated(operator%shear)) then
      if (square*operator%shear%rotary <= weak_turning) then
        weights = shift_weights(0.0_dp, -square, 0.0_dp)
      else
        shift = operator%omega*operator%omega
        weights = shift_weights(square, 0.0_dp, square)
      end if
    end if
  end subroutine choose_shift

  pure subroutine set_column(operator, weights, j, system)
    !! Fill in column j of S and B: what strain j of size 1 does.
    type(beam_operator), intent(in) :: operator
    type(shift_weights), intent(in) :: weights
    integer, intent(in) :: j
    type(strain_system), intent(inout) :: system
    real(dp), dimension(system%functions + 1) :: psi, slope, force, moment
    real(dp) :: v(system%functions + 2)
    integer :: n
    n = system%functions
    call strain_motion(operator, n, j, psi, slope)
    v = integral(slope)
    force = weights%deflection*integral_transposed(v)
    moment = 0.0_dp
    if (allocated(operator%tension)) force = force + times_quadratic(operator%tension, slope)
    system%mass_root(:n + 2, j) = v
    if (allocated(operator%shear)) then
      moment = weights%turning*operator%shear%rotary*psi
      system%mass_root(system%turn_row:system%turn_row + n, j) = sqrt(operator%shear%rotary)*psi
      system%stiffness(n + 1:, j) = sqrt(operator%shear%compliance)*force(:n)
    end if
    system%stiffness(:n, j) = integral_transposed(force + moment)
    system%stiffness(j, j) = system%stiffness(j, j) + 1.0_dp
  end subroutine set_column

  pure subroutine strain_motion(operator, n, j, psi, slope)
    !! Find ψ and v' of strain j: a curvature, or beyond n a shear strain.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: n, j
    real(dp), intent(out) :: psi(:), slope(:)        !! (n + 1)
    real(dp) :: strain(n)
    strain = 0.0_dp
    strain(merge(j, j - n, j <= n)) = 1.0_dp
    psi = 0.0_dp
    if (j <= n) psi = integral(strain)
    slope = psi
    if (j > n) slope(:n) = sqrt(operator%shear%compliance)*strain
  end subroutine strain_motion

  pure subroutine add_body(operator, weights, system)
    !! Change to the unknowns of the tip, and add mass and inertia of the body there.
    type(beam_operator), intent(in) :: operator
    type(shift_weights), intent(in) :: weights
    type(strain_system), intent(inout) :: system
    real(dp) :: inertia
    inertia = 0.0_dp
    if (allocated(operator%tip_inertia)) inertia = operator%tip_inertia
    if (allocated(operator%shear)) then
      system%tip = tip_coordinates_of(system%functions, sqrt(operator%shear%compliance), inertia > operator%gamma/3.0_dp)
    else
      system%tip = tip_coordinates_of(system%functions, turning_last=inertia > operator%gamma/3.0_dp)
    end if
    call system%tip%to_columns(system%mass_root)
    call system%tip%to_columns(system%stiffness)
    call system%tip%to_rows(system%stiffness)
    associate (v => system%tip%deflection, psi => system%tip%turning)
      if (system%tip_row > 0) then
        system%force = system%stiffness(v, :)
        system%pushed = system%mass_root(:, v)
        system%mass = operator%gamma
        system%mass_weight = weights%deflection
        system%mass_root(system%tip_row, v) = sqrt(operator%gamma)
        system%stiffness(v, v) = system%stiffness(v, v) + weights%deflection*operator%gamma
      end if
      if (system%inertia_row > 0) then
        system%mass_root(system%inertia_row, psi) = sqrt(inertia)
        system%stiffness(psi, psi) = system%stiffness(psi, psi) + weights%inertia*inertia
      end if
    end associate
  end subroutine add_body

end module bw_strain_system
