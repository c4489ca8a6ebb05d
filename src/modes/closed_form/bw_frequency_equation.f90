module bw_frequency_equation
  !! Roots of the frequency equations 8 and 19 of a clamped beam with a tip mass,
  !! \( 1 + \cos\alpha\cosh\alpha + \alpha\gamma(\cos\alpha\sinh\alpha - \sin\alpha\cosh\alpha) = 0 \),
  !! γ = 0 for the beam alone.
  !!
  !! A root is an integer number of eighths of a cycle and a remainder, α = q π/4 + δ, so that sin and cos of αξ lose no
  !! digits for high mode numbers:
  !!
  !! - k = 1: q = 0; Newton on a polynomial in x = α⁴, exact as γ → ∞ where x → 3/γ;
  !! - γα ≤ 1: q = 4k − 2, α = (k − ½)π + δ;
  !! - γα > 1: q = 4k − 3, α = (k − ¾)π + δ, the equation divided by γα; δ → 1/(2γα) − e^(−2α).
  !!
  !! Power series replace the functions where their closed forms cancel, α, z ≲ 2:
  !!
  !! - with \(T_j(x) = \sum_m (-4x)^m/(4m+j)!\) and x = α⁴, 1 + cos α cosh α = 1 + T₀, sin α sinh α = 2α² T₂,
  !!   sin α cosh α − cos α sinh α = 4α³ T₃;
  !! - with \(U_j(y) = \sum_m y^m/(4m+j)!\) and y = z⁴, cosh z − cos z = 2z² U₂, sinh z − sin z = 2z³ U₃.
  !!
  !! **Errors**: α within 2 units in the last place for k ≤ 10⁸ and every finite γ ≥ 0. **Source**: Eqs 8 and 19,
  !! scaled by 1/cosh α.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, operator(*), operator(+)
  implicit none (type, external)
  private
  public :: solve_root, root_value, first_slope, is_light
  public :: alternating_series, growing_series

  integer, parameter, public :: highest_mode = 100000000  !! eighths of a cycle of its root still fit an integer
  integer, parameter :: newton_steps = 30                 !! limit; 3 to 5 suffice

  integer, parameter :: last_term = 7
    !! of the series: the term after it is below 1e-18 of the first for x ≤ 15 (checked by test_bw_frequency_equation)
  real(dp), parameter :: factorial(0:4) = [1.0_dp, 1.0_dp, 2.0_dp, 6.0_dp, 24.0_dp]

  type, public :: root_type
    !! α_k = eighths·π/4 + remainder
    integer :: k = 0              !! mode number, from 1
    integer :: eighths = 0        !! q: 0 for k = 1, else 4k − 2 or 4k − 3
    real(dp) :: remainder = 0.0_dp   !! δ; α itself for k = 1
    real(dp) :: gamma = 0.0_dp    !! mass ratio γ of the equation it solves
    real(dp) :: gamma_low = 0.0_dp   !! low part of γ, for roots in extended precision only
  end type root_type

contains

  elemental type(root_type) function solve_root(k, gamma) result(root)
    !! Return the k-th root α_k.
    integer, intent(in) :: k         !! 1 … `highest_mode`
    real(dp), intent(in) :: gamma    !! mass ratio γ ≥ 0, finite
    root%k = k
    root%gamma = gamma
    if (k == 1) then
      root%remainder = sqrt(sqrt(first_root_fourth_power(gamma)))
    else if (gamma <= 1.0_dp/((k - 0.75_dp)*pi)) then
      root%eighths = 4*k - 2
      root%remainder = light_mass_remainder(k, gamma)
    else
      root%eighths = 4*k - 3
      root%remainder = heavy_mass_remainder(k, gamma)
    end if
  end function solve_root

  elemental type(dd) function root_value(root)
    !! Return α as a double-double number; rounding to binary64 loses half a unit in the last place.
    type(root_type), intent(in) :: root
    root_value = dd_pi*(0.25_dp*root%eighths) + root%remainder
  end function root_value

  elemental logical function is_light(root)
    !! Return whether γα ≲ 1, so that the root, k ≥ 2, is anchored at (k − ½)π.
    type(root_type), intent(in) :: root
    is_light = mod(root%eighths, 4) == 2
  end function is_light

  ! The first root

  elemental real(dp) function first_root_fourth_power(gamma) result(x)
    !! Return x = α₁⁴ from 1 + cos α cosh α − γ x·4T₃(x) = 0, divided by γ for γ > 1.
    real(dp), intent(in) :: gamma
    real(dp) :: free, mass, step
    integer :: i
    free = 1.0_dp/max(1.0_dp, gamma)
    mass = min(1.0_dp, gamma)
    x = 3.0_dp*free/(mass + 0.2427_dp*free)   ! Rayleigh's quotient of the static shape, within 0.1 %
    do i = 1, newton_steps
      step = (free*(1.0_dp + alternating_series(0, x)) - mass*x*4.0_dp*alternating_series(3, x)) &
        /first_slope(gamma, x)
      x = x - step
      if (abs(step) <= 4.0_dp*epsilon(x)*x) exit   ! the step after it is below rounding
    end do
  end function first_root_fourth_power

  elemental real(dp) function first_slope(gamma, x) result(slope)
    !! Return the derivative of the first root's equation with respect to x, divided by γ for γ > 1.
    real(dp), intent(in) :: gamma, x
    slope = slope_free(x)/max(1.0_dp, gamma) - min(1.0_dp, gamma)*slope_mass(x)
  end function first_slope

  elemental real(dp) function slope_free(x)
    !! Return d(1 + cos α cosh α)/dx = (cos α sinh α − sin α cosh α)/(4α³) = −T₃(x).
    real(dp), intent(in) :: x
    slope_free = -alternating_series(3, x)
  end function slope_free

  elemental real(dp) function slope_mass(x)
    !! Return d(α(sin α cosh α − cos α sinh α))/dx = [sin α cosh α − cos α sinh α + 2α sin α sinh α]/(4α³) = T₃ + T₂.
    real(dp), intent(in) :: x
    slope_mass = alternating_series(3, x) + alternating_series(2, x)
  end function slope_mass

  ! Higher roots

  elemental real(dp) function light_mass_remainder(k, gamma) result(delta)
    !! Return δ of α = (k − ½)π + δ, for γα ≲ 1.
    integer, intent(in) :: k
    real(dp), intent(in) :: gamma
    real(dp) :: c, value, slope, lower, upper
    integer :: i
    logical :: done
    lower = -0.25_dp*pi - 0.05_dp
    upper = 0.05_dp
    c = gamma*(k - 0.5_dp)*pi
    delta = -atan(c/(1.0_dp + c))
    do i = 1, newton_steps
      call light_equation(k, gamma, delta, value, slope)
      call newton_step(delta, value, slope, lower, upper, done)
      if (done) exit
    end do
  end function light_mass_remainder

  pure subroutine light_equation(k, gamma, delta, value, slope)
    !! Return sin δ (1 + αγ tanh α) + αγ cos δ + (−1)^k sech α at α = (k − ½)π + δ, and its derivative.
    integer, intent(in) :: k
    real(dp), intent(in) :: gamma, delta
    real(dp), intent(out) :: value, slope
    real(dp) :: alpha, c, sech, th
    alpha = (k - 0.5_dp)*pi + delta
    c = alpha*gamma
    sech = hyperbolic_secant(alpha)
    th = tanh(alpha)
    value = sin(delta)*(1.0_dp + c*th) + c*cos(delta) + alternate(k)*sech
    slope = cos(delta)*(1.0_dp + c*th) - c*sin(delta) + gamma*(sin(delta)*(th + alpha*sech**2) + cos(delta)) &
      - alternate(k)*sech*th
  end subroutine light_equation

  elemental real(dp) function heavy_mass_remainder(k, gamma) result(delta)
    !! Return δ of α = (k − ¾)π + δ, for γα ≳ 1.
    integer, intent(in) :: k
    real(dp), intent(in) :: gamma
    real(dp) :: value, slope, lower, upper
    integer :: i
    logical :: done
    lower = -0.05_dp
    upper = 0.25_dp*pi + 0.05_dp
    delta = 0.5_dp/((k - 0.75_dp)*pi)/gamma
    do i = 1, newton_steps
      call heavy_equation(k, gamma, delta, value, slope)
      call newton_step(delta, value, slope, lower, upper, done)
      if (done) exit
    end do
  end function heavy_mass_remainder

  pure subroutine heavy_equation(k, gamma, delta, value, slope)
    !! Return sin δ (2 + u − τ) − cos δ (u − τ) + √2 (−1)^k u sech α at α = (k − ¾)π + δ, with u = 1/(γα) and τ = 1 −
    !! tanh α, and its derivative.
    integer, intent(in) :: k
    real(dp), intent(in) :: gamma, delta
    real(dp), intent(out) :: value, slope
    real(dp) :: alpha, u, sech, tau, edge, change
    alpha = (k - 0.75_dp)*pi + delta
    u = 1.0_dp/alpha/gamma
    sech = hyperbolic_secant(alpha)
    tau = 2.0_dp*exp(-2.0_dp*alpha)/(1.0_dp + exp(-2.0_dp*alpha))
    edge = sqrt(2.0_dp)*alternate(k)*u*sech
    change = sech**2 - u/alpha                ! d(u − τ)/dα
    value = sin(delta)*(2.0_dp + u - tau) - cos(delta)*(u - tau) + edge
    slope = cos(delta)*(2.0_dp + u - tau) + sin(delta)*(u - tau) + change*(sin(delta) - cos(delta)) &
      - edge*(1.0_dp/alpha + tanh(alpha))
  end subroutine heavy_equation

  pure subroutine newton_step(x, value, slope, lower, upper, done)
    !! Take one Newton step inside a bracket in which the function rises.
    real(dp), intent(inout) :: x, lower, upper
    real(dp), intent(in) :: value, slope
    logical, intent(out) :: done            !! the step was below rounding
    real(dp) :: next
    next = x - value/slope
    done = abs(next - x) <= 4.0_dp*epsilon(x)*abs(next)
    if (.not. done) then
      if (value > 0.0_dp) then
        upper = x
      else
        lower = x
      end if
      if (next <= lower .or. next >= upper) next = 0.5_dp*(lower + upper)
    end if
    x = next
  end subroutine newton_step

  elemental real(dp) function hyperbolic_secant(alpha) result(sech)
    !! Return sech α without overflow.
    real(dp), intent(in) :: alpha
    sech = 2.0_dp*exp(-alpha)/(1.0_dp + exp(-2.0_dp*alpha))
  end function hyperbolic_secant

  elemental real(dp) function alternate(k)
    !! Return (−1)^k.
    integer, intent(in) :: k
    alternate = merge(1.0_dp, -1.0_dp, mod(k, 2) == 0)
  end function alternate

  ! Power series

  elemental real(dp) function alternating_series(j, x) result(sum)
    !! Return T_j(x) for 0 ≤ x ≤ 15.
    integer, intent(in) :: j      !! 0 … 4
    real(dp), intent(in) :: x
    sum = factorial_series(j, -4.0_dp*x)
  end function alternating_series

  elemental real(dp) function growing_series(j, y) result(sum)
    !! Return U_j(y) for 0 ≤ y ≤ 15.
    integer, intent(in) :: j      !! 0 … 4
    real(dp), intent(in) :: y
    sum = factorial_series(j, y)
  end function growing_series

  elemental real(dp) function factorial_series(j, y) result(sum)
    !! Return Σ yᵐ/(4m+j)! by Horner's rule on the ratios of successive terms.
    integer, intent(in) :: j
    real(dp), intent(in) :: y
    integer :: m, n
    sum = 1.0_dp
    do m = last_term, 1, -1
      n = 4*m + j
      sum = 1.0_dp + sum*y/real(n*(n - 1)*(n - 2)*(n - 3), dp)
    end do
    sum = sum/factorial(j)
  end function factorial_series

end module bw_frequency_equation
