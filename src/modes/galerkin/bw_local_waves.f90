module bw_local_waves
  !! Wave number, phase and group velocity of a mode of a beam with tension or shear: those of the local propagating
  !! wave at the mode's frequency, averaged over the beam.
  !!
  !! With λ = β² + Ω² in plane and β² out of plane, ρ = r²β² in plane and r²(β² + Ω²) out of plane, the local wave
  !! number p = √y satisfies (1 + s²T)y² + [T(1 − s²ρ) − s²λ − ρ]y − λ(1 − s²ρ) = 0 (the larger root: bending waves,
  !! also if thickness-shear waves propagate). P is the mean of p over the beam, C_p = β/P and C_g = dβ/dP. Without
  !! tension and shear P⁴ = λ, Eq. 2; at high speeds P is that of a string.
  use bw_kinds, only: dp
  use bw_lapack, only: dsterf
  use bw_missing, only: no_number
  use bw_strain_basis, only: basis_values
  implicit none (type, external)
  private
  public :: gauss_rule, local_wave, mean_rule

  integer, parameter :: nodes = 200
    !! of the mean over a beam with tension: error 1e-12 for Ω to 1000, with T = 0 at the tip

  type, public :: wave_section
    !! Properties of the beam at one place.
    real(dp) :: stiffness = 1.0_dp               !! B = EI
    real(dp) :: mass = 1.0_dp                    !! m = ρA
    real(dp) :: compliance = 0.0_dp              !! s = 1/(κGA)
    real(dp) :: rotary = 0.0_dp                  !! ρI
    real(dp) :: tension = 0.0_dp                 !! T
  end type wave_section

  type :: rule_type
    !! Nodes and weights of a mean.
    real(dp), allocatable :: z(:), weight(:)
  end type rule_type

  type(rule_type) :: kept                        !! `mean_rule`, computed once

contains

  elemental subroutine local_wave(section, spin, in_plane, beta_squared, p, slope)
    !! Find p at one place, where y = p² is the larger root of ay² + by − c, and dp/dβ².
    type(wave_section), intent(in) :: section
    real(dp), intent(in) :: spin                 !! Ω²
    logical, intent(in) :: in_plane
    real(dp), intent(in) :: beta_squared
    real(dp), intent(out) :: p, slope
    real(dp) :: turning, lambda, rho, a, b, c, root, y, stiff, soft
    stiff = section%compliance*section%stiffness
    soft = stiff*section%mass
    lambda = beta_squared + merge(spin, 0.0_dp, in_plane)
    rho = section%rotary*(beta_squared + merge(0.0_dp, spin, in_plane))
    turning = 1.0_dp - section%compliance*rho
    a = section%stiffness + stiff*section%tension
    b = section%tension*turning - soft*lambda - rho
    c = section%mass*lambda*turning
    root = sqrt(max(0.0_dp, b**2 + 4.0_dp*a*c))
    if (b > 0.0_dp) then
      y = 2.0_dp*c/(b + root)
    else
      y = (root - b)/(2.0_dp*a)
    end if
    p = sqrt(max(0.0_dp, y))
    slope = 0.0_dp
    if (root <= 0.0_dp .or. p <= 0.0_dp) return       ! λ = 0: no wave; β² < 0: no velocity is needed
    slope = section%mass*(turning - section%compliance*section%rotary*lambda) &
      + y*(soft + section%rotary*(1.0_dp + section%compliance*section%tension))
    slope = slope/root/(2.0_dp*p)
  end subroutine local_wave

  subroutine mean_rule(z, weight)
    !! Return nodes z and weights of the mean over a piece of a beam with tension, 1 − ξ = z²: T may vanish at the tip.
    real(dp), allocatable, intent(out) :: z(:), weight(:)      !! (nodes)
    if (.not. allocated(kept%z)) then
      call gauss_rule(nodes, kept%z, kept%weight)
      kept%weight = 2.0_dp*kept%z*kept%weight
    end if
    z = kept%z
    weight = kept%weight
  end subroutine mean_rule

  subroutine gauss_rule(n, node, weight)
    !! Return nodes and weights of Gauss quadrature on [0, 1], exact for polynomials up to degree 2n − 1: nodes are the
    !! eigenvalues of the matrix of ξ in Legendre polynomials, weights 1/Σp_j² there (Golub and Welsch 1969).
    integer, intent(in) :: n                             !! ≥ 1
    real(dp), allocatable, intent(out) :: node(:), weight(:)   !! ascending, (n)
    real(dp) :: below(n)
    integer :: j, info
    allocate (node(n), source=0.5_dp)
    below = [(0.5_dp*j/sqrt((2.0_dp*j - 1.0_dp)*(2.0_dp*j + 1.0_dp)), j=1, n)]
    call dsterf(n, node, below, info)
    if (info /= 0) node = no_number()
    weight = 1.0_dp/sum(basis_values(n, node)**2, dim=1)
  end subroutine gauss_rule

end module bw_local_waves
