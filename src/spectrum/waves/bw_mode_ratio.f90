module bw_mode_ratio
  !! The wave number α = P l that the ratio R of a mode's shape at midpoint and tip fixes through Φ(½) − R Φ(1) = 0 (Eqs 18, 20),
  !! and the mass at the tip that the wave number implies (Eq. 19). All modes of one beam imply the same mass.
  use bw_kinds, only: dp
  use bw_wave_shapes, only: tip_shape
  implicit none (type, external)
  private
  public :: alpha_of_ratio, alpha_range, mass_angle, mode_near

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: margin = 1.0e-3_dp      !! roots lie that near the ends (k−¾)π and (k−½)π, or between
  real(dp), parameter :: first_mode(2) = [1.0e-3_dp, 1.8752_dp]
  integer, parameter :: max_steps = 100
  real(dp), parameter :: small = 0.5_dp          !! α below which sin α cosh α − cos α sinh α is summed as a series

contains

  pure integer function mode_near(alpha)
    !! The number of the mode whose range of α, for any tip mass, is the nearest.
    real(dp), intent(in) :: alpha
    mode_near = max(1, nint(min(alpha, 1.0e8_dp)/pi + 0.625_dp))
  end function mode_near

  pure subroutine alpha_of_ratio(ratio, ratio_error, mode, alpha, alpha_error, found)
    !! Find the α of a mode that gives the ratio, and the error that an error of the ratio makes of it.
    real(dp), intent(in) :: ratio, ratio_error
    integer, intent(in) :: mode                   !! k ≥ 1
    real(dp), intent(out) :: alpha, alpha_error
    logical, intent(out) :: found                 !! some α in the mode's range gives a ratio within the error
    real(dp) :: low, high, range(2)
    range = alpha_range(mode)
    alpha = root(ratio, range)
    low = root(ratio - ratio_error, range)
    high = root(ratio + ratio_error, range)
    alpha_error = max(abs(alpha - low), abs(high - alpha)) + 8*epsilon(1.0_dp)*alpha
    found = any([low, alpha, high] > range(1) .and. [low, alpha, high] < range(2)) .or. abs(high - low) > 0
  end subroutine alpha_of_ratio

  pure function alpha_range(mode) result(range)
    !! The ends of a mode's range of α for tip masses from infinity to 0.
    integer, intent(in) :: mode
    real(dp) :: range(2)
    range = first_mode
    if (mode > 1) range = [(mode - 0.75_dp)*pi - margin, (mode - 0.5_dp)*pi + margin]
  end function alpha_range

  pure real(dp) function root(ratio, range)
    !! The zero of Φ(½) − R Φ(1) in the range by regula falsi (Illinois), or the nearer end of the range if there is none.
    real(dp), intent(in) :: ratio, range(2)
    real(dp) :: a, b, fa, fb, f
    integer :: i
    a = range(1)
    b = range(2)
    fa = mismatch(a, ratio)
    fb = mismatch(b, ratio)
    root = merge(a, b, abs(fa) < abs(fb))
    if ((fa < 0) .eqv. (fb < 0)) return
    do i = 1, max_steps
      root = b - fb*(b - a)/(fb - fa)
      f = mismatch(root, ratio)
      if (f == 0 .or. abs(root - b) <= spacing(b)) return
      if ((f < 0) .neqv. (fb < 0)) then
        a = b
        fa = fb
      else
        fa = fa/2
      end if
      b = root
      fb = f
    end do
  end function root

  pure real(dp) function mismatch(alpha, ratio)
    !! The number (Φ(½) − R Φ(1))/(1 + |R|), over α² if that is less than 1, which is 0 where the ratio is met.
    real(dp), intent(in) :: alpha, ratio
    complex(dp) :: shape(2)
    shape = tip_shape(cmplx(alpha, kind=dp), [0.5_dp, 1.0_dp], 1.0_dp)
    mismatch = (shape(1)%re - ratio*shape(2)%re)/(1 + abs(ratio))/min(alpha, 1.0_dp)**2
  end function mismatch

  pure real(dp) function mass_angle(alpha, mode)
    !! The angle whose tangent is γ = (1 + cos α cosh α)/(α (sin α cosh α − cos α sinh α)), Eq. 19. It falls smoothly from π/2
    !! (γ infinite) to 0 (no mass) as α rises through the mode's range, and goes on beyond both ends of it.
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

end module bw_mode_ratio
