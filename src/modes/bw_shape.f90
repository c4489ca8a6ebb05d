module bw_shape
  !! Mode shapes in closed form, Eqs 7 and 18, in forms that keep their digits for every mode number.
  !!
  !! \( \Phi(\xi) = \cos\alpha\xi - \cosh\alpha\xi - \sigma(\sin\alpha\xi - \sinh\alpha\xi) \) is evaluated as
  !! cos αξ − σ sin αξ − ½(1+σ)e^(−αξ) − ½(1−σ)e^α e^(−α(1−ξ)), near the root as a power series.
  !!
  !! **Errors**: Φ(ξ) within 1e-14 absolutely, Φ(1), the modal mass and (1−σ)e^α within 1e-14 relatively, k to 10⁶ and
  !! beyond, every γ ≥ 0; where σ passes through 1 (for k = 1 at γ = 2.34) (1−σ)e^α is so absolutely only.
  !! **Source**: Eqs 7, 9, 18, 20, 21.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, two_product
  use bw_frequency_equation, only: is_light, root_type, root_value
  use bw_small_series, only: alternating_series, growing_series
  implicit none (type, external)
  private
  public :: shape_of, shape_value

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: series_below = 0.5_dp   !! αξ below which the closed form has lost a digit

  type, public :: shape_type
    !! One mode shape, its tip and its mass, without dimensions.
    type(root_type) :: root
    real(dp) :: alpha = 0.0_dp        !! α
    real(dp) :: sigma = 0.0_dp        !! σ, Eqs 9 and 20
    real(dp) :: grow = 0.0_dp         !! (1 − σ)e^α, which does not underflow
    real(dp) :: tip = 0.0_dp          !! Φ(1); ±2 for γ = 0
    real(dp) :: tip_slope = 0.0_dp    !! Φ'(1) = dΦ/dξ
    real(dp) :: tip_force = 0.0_dp    !! αγΦ(1) = −Φ'''(1)/α³, which does not overflow
    real(dp) :: modal_mass = 0.0_dp   !! M/m_i = ∫Φ² dξ + γΦ(1)², Eq. 21
  end type shape_type

contains

  elemental type(shape_type) function shape_of(root) result(shape)
    !! The shape that belongs to a root of the frequency equation.
    type(root_type), intent(in) :: root
    type(dd) :: alpha
    alpha = root_value(root)
    shape%root = root
    shape%alpha = alpha%hi
    if (root%k == 1) then
      call set_first(shape)
    else
      call set_higher(shape)
    end if
  end function shape_of

  pure subroutine set_first(shape)
    !! Mode 1, α ≤ 1.8752, through the power series: exact also as γ → ∞, where α → 0.
    type(shape_type), intent(inout) :: shape
    real(dp) :: a, x, denominator
    a = shape%alpha
    x = a**4
    denominator = sin(a) + sinh(a)
    shape%sigma = (cos(a) + cosh(a))/denominator
    shape%grow = (sin(a) - cos(a) - exp(-a))/denominator*exp(a)
    shape%tip = -8.0_dp*a**3*alternating_series(3, x)/denominator
    shape%tip_force = a*(shape%root%gamma*shape%tip)
    shape%tip_slope = -4.0_dp*a**3*alternating_series(2, x)/denominator
    shape%modal_mass = mass_of(shape, 2.0_dp*a**2*alternating_series(2, x)/denominator)
  end subroutine set_first

  pure subroutine set_higher(shape)
    !! Modes from the second on, with everything scaled by e^(−α).
    type(shape_type), intent(inout) :: shape
    real(dp) :: sine, cosine, difference, decay, sech, th, denominator
    type(dd) :: alpha
    call end_angle(shape%root, sine, cosine, difference)
    alpha = root_value(shape%root)
    decay = exp(-alpha%hi)*(1.0_dp - alpha%lo)         ! what rounding α took is up to α units in the last place here
    sech = 2.0_dp*decay/(1.0_dp + decay**2)
    th = (1.0_dp - decay**2)/(1.0_dp + decay**2)
    denominator = sine*sech + th                       ! (sin α + sinh α)/cosh α
    shape%grow = (difference - decay)/(decay*sine + 0.5_dp*(1.0_dp - decay**2))
    shape%sigma = 1.0_dp - shape%grow*decay
    if (is_light(shape%root)) then
      shape%tip = 2.0_dp*(cosine*th - sine)/denominator
      shape%tip_force = shape%alpha*shape%root%gamma*shape%tip
    else                                               ! the direct form would cancel
      shape%tip_force = -2.0_dp*(sech + cosine)/denominator
      shape%tip = shape%tip_force/shape%alpha/shape%root%gamma
    end if
    shape%tip_slope = -2.0_dp*shape%alpha*sine*th/denominator
    shape%modal_mass = mass_of(shape, sine*th/denominator)
  end subroutine set_higher

  pure real(dp) function mass_of(shape, end_ratio) result(mass)
    !! M/m_i = ¼(1+γ)Φ(1)² + 2(1 + cos α cosh α) sin α sinh α/(sin α + sinh α)², by the frequency equation
    !! ¼Φ(1)(Φ(1) + N/α) − N·(sin α sinh α/(sin α + sinh α)) with N = αγΦ(1): two terms ≥ 0.
    type(shape_type), intent(in) :: shape
    real(dp), intent(in) :: end_ratio    !! sin α sinh α/(sin α + sinh α)
    mass = 0.25_dp*shape%tip*(shape%tip + shape%tip_force/shape%alpha) - shape%tip_force*end_ratio
  end function mass_of

  pure subroutine end_angle(root, sine, cosine, difference)
    !! sin α, cos α and sin α − cos α from the remainder alone, k ≥ 2.
    type(root_type), intent(in) :: root
    real(dp), intent(out) :: sine, cosine, difference
    real(dp) :: sign
    sign = merge(-1.0_dp, 1.0_dp, mod(root%k, 2) == 0)       ! −(−1)^k
    if (is_light(root)) then
      sine = sign*cos(root%rest)
      cosine = -sign*sin(root%rest)
      difference = sine - cosine
    else
      sine = sign*sqrt(0.5_dp)*(cos(root%rest) + sin(root%rest))
      cosine = sign*sqrt(0.5_dp)*(cos(root%rest) - sin(root%rest))
      difference = sign*sqrt(2.0_dp)*sin(root%rest)
    end if
  end subroutine end_angle

  elemental real(dp) function shape_value(shape, xi) result(value)
    !! Φ(ξ): exactly 0 at the root, exactly `tip` at the tip.
    type(shape_type), intent(in) :: shape
    real(dp), intent(in) :: xi           !! 0 ≤ ξ ≤ 1
    real(dp) :: z, angle
    z = shape%alpha*xi
    if (xi == 1.0_dp) then
      value = shape%tip
    else if (z < series_below .or. shape%root%k == 1) then
      value = 2.0_dp*z**2*(shape%sigma*z*growing_series(3, z**4) - growing_series(2, z**4))
    else
      angle = angle_at(shape%root, xi)
      value = cos(angle) - shape%sigma*sin(angle) - 0.5_dp*(1.0_dp + shape%sigma)*exp(-z) &
        - 0.5_dp*shape%grow*exp(-shape%alpha*(1.0_dp - xi))
    end if
  end function shape_value

  elemental real(dp) function angle_at(root, xi) result(angle)
    !! αξ modulo 2π: the whole eighths of a turn are multiplied and reduced exactly.
    type(root_type), intent(in) :: root
    real(dp), intent(in) :: xi
    real(dp) :: eighths, rest
    call two_product(real(root%eighths, dp), xi, eighths, rest)
    eighths = eighths - 8.0_dp*anint(0.125_dp*eighths)
    angle = 0.25_dp*pi*(eighths + rest) + root%rest*xi
  end function angle_at

end module bw_shape
