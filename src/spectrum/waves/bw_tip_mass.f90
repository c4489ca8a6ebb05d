module bw_tip_mass
  !! The mass at the tip that the wave number of a mode implies: γ = (1 + cos α cosh α)/(α (sin α cosh α − cos α sinh α)),
  !! Eq. 19. All modes of one beam imply the same.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: mass_angle

  real(dp), parameter :: small = 0.5_dp          !! α below which the bracket is summed as a series

contains

  pure real(dp) function mass_angle(alpha, mode)
    !! The angle whose tangent is γ: it falls smoothly from π/2 (γ infinite) to 0 (no mass) as α rises through the mode's range,
    !! and goes on beyond both ends of it.
    real(dp), intent(in) :: alpha                !! > 0
    integer, intent(in) :: mode                  !! k ≥ 1
    real(dp) :: cosine, bracket, sign_of_range
    sign_of_range = merge(1.0_dp, -1.0_dp, mod(mode, 2) == 1)
    cosine = 1/cosh(min(alpha, 700.0_dp)) + cos(alpha)
    if (alpha < small) then
      bracket = bracket_by_series(alpha)/cosh(alpha)
    else
      bracket = sin(alpha) - cos(alpha)*tanh(alpha)
    end if
    mass_angle = atan2(sign_of_range*cosine, sign_of_range*alpha*bracket)
  end function mass_angle

  pure real(dp) function bracket_by_series(alpha) result(total)
    !! sin α cosh α − cos α sinh α = ⅔α³ − α⁷/315 + … = 4 Σ (−4)ⁿ α^(4n+3)/((4n+2)! (4n+3)).
    real(dp), intent(in) :: alpha
    real(dp) :: power
    integer :: n
    power = 2*alpha**3                           ! 4 (−4)ⁿ α^(4n+3)/(4n+2)!
    total = power/3
    n = 0
    do while (abs(power) > epsilon(1.0_dp)*total)
      n = n + 1
      power = -4*power*alpha**4/(real(4*n - 1, dp)*(4*n)*(4*n + 1)*(4*n + 2))
      total = total + power/(4*n + 3)
    end do
  end function bracket_by_series

end module bw_tip_mass
