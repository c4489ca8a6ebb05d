module bw_mode_demand
  !! What modes by strains must provide besides frequencies and shapes, and how many polynomials that needs.
  !!
  !! The Legendre coefficients of e^{iθx} and e^{−θx} on 0 ≤ x ≤ 1 are spherical Bessel functions j_n(z) and
  !! i_n(z)e^{−z}, z = θ/2, with logarithms √(n² − z²) − n arcosh(n/z), n > z, and √(n² + z²) − z − n arsinh(n/z), up to
  !! powers of n (Debye's expansions, Abramowitz and Stegun 9.3.7, 9.7.7).
  use bw_kinds, only: dp
  implicit none (type, external)
  private

  type, public :: mode_demand
    integer :: digits = 11
      !! of shapes: in a norm of 1 their last coefficients are below 10^(−digits). Errors of frequencies are about the
      !! square, but at least rounding.
    logical :: waves = .true.
      !! wave numbers, velocities and critical speed; otherwise arrays are unallocated and the speed is 0
  contains
    procedure :: negligible
    procedure :: functions
  end type mode_demand

contains

  pure real(dp) function negligible(self)
    !! Return the largest last coefficient of a resolved mode.
    class(mode_demand), intent(in) :: self
    negligible = 10.0_dp**(-self%digits)
  end function negligible

  elemental integer function functions(self, wave, layer) result(n)
    !! Return the number of polynomials for a piece.
    class(mode_demand), intent(in) :: self
    real(dp), intent(in) :: wave                !! phase of the shortest wave across the piece, rad
    real(dp), intent(in) :: layer               !! length of the piece over the thickness of its boundary layers
    integer, parameter :: fewest = 3
    real(dp) :: z
    n = max(fewest, ceiling(0.5_dp*wave))
    z = max(0.5_dp*wave, epsilon(z))
    do while (n*acosh(n/z) - sqrt((n - z)*(n + z)) < -log(self%negligible()))
      n = n + 1
    end do
    z = max(0.5_dp*layer, epsilon(z))
    do while (n*asinh(n/z) - sqrt(n**2 + z**2) + z < -log(self%negligible()))
      n = n + 1
    end do
  end function functions

end module bw_mode_demand
