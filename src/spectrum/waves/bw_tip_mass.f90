module bw_tip_mass
  !! The mass at the tip that a wave number α = P l implies (Eq. 19), and the range of α of each mode for any mass. All modes
  !! of one beam imply the same mass.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: alpha_range, mass_angle, mode_near

  real(dp), parameter :: margin = 1.0e-3_dp      !! roots lie between (k−¾)π and (k−½)π, or so near these
  real(dp), parameter :: first_mode(2) = [1.0e-3_dp, 1.8752_dp]
  real(dp), parameter :: small = 0.5_dp          !! α below which sin α cosh α − cos α sinh α is summed as a series

contains

  elemental integer function mode_near(alpha)
    !! The number of the mode whose range of α, for any tip mass, is nearest.
    real(dp), intent(in) :: alpha
    mode_near = max(1, nint(min(alpha, 1.0e8_dp)/pi + 0.625_dp))
  end function mode_near

  pure function alpha_range(mode) result(range)
    !! The ends of a mode's range of α for tip masses from infinity to 0.
    integer, intent(in) :: mode
    real(dp) :: range(2)
    range = first_mode
    if (mode > 1) range = [(mode - 0.75_dp)*pi - margin, (mode - 0.5_dp)*pi + margin]
  end function alpha_range

  pure real(dp) function mass_angle(alpha, mode)
    !! The angle whose tangent is γ = (1 + cos α cosh α)/(α (sin α cosh α − cos α sinh α)), Eq. 19. It falls smoothly from π/2
    !! (γ infinite) to 0 (no mass) as α rises through the mode's range, and continues beyond both ends.
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
    !! The bracket sin α cosh α − cos α sinh α = ⅔α³ − α⁷/315 + … = 4 Σ (−4)ⁿ α^(4n+3)/((4n+2)! (4n+3)).
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
