module bw_shape
  !! Mode shapes in closed form, Eqs 7 and 18, accurate for every mode number.
  !!
  !! \( \Phi(\xi) = \cos\alpha\xi - \cosh\alpha\xi - \sigma(\sin\alpha\xi - \sinh\alpha\xi) \) is evaluated as
  !! cos αξ − σ sin αξ − ½(1+σ)e^(−αξ) − ½(1−σ)e^α e^(−α(1−ξ)), near the root as a power series. Its curvature over α² differs in
  !! the sign of the first two terms.
  !!
  !! **Errors**: Φ(ξ) and Φ''(ξ)/α² within 1e-14 absolutely, Φ(1), the modal mass and (1−σ)e^α within 1e-14 relatively, k to 10⁶ and
  !! beyond, every γ ≥ 0; where σ passes through 1 (for k = 1 at γ = 2.34) (1−σ)e^α is so absolutely only.
  !! **Source**: Eqs 7, 9, 18, 20, 21.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_double_double, only: dd, two_product
  use bw_frequency_equation, only: alternating_series, growing_series, is_light, root_type
  use bw_root_list, only: root_values
  implicit none (type, external)
  private
  public :: shape_of, shapes_of, shape_value, shape_values, slope_values, curvature_values

  real(dp), parameter :: series_below = 0.5_dp   !! αξ below which the closed form loses a digit
  real(dp), parameter :: longest_decay = 400.0_dp  !! e^(−400) is negligible beside 1, and its square underflows

  type, public :: shape_type
    !! One mode shape, its tip and its mass, without dimensions.
    type(root_type) :: root
    real(dp) :: alpha = 0.0_dp        !! α
    real(dp) :: sigma = 0.0_dp        !! σ, Eqs 9 and 20
    real(dp) :: grow = 0.0_dp         !! (1 − σ)e^α, without underflow
    real(dp) :: tip = 0.0_dp          !! Φ(1); ±2 for γ = 0
    real(dp) :: tip_slope = 0.0_dp    !! Φ'(1) = dΦ/dξ
    real(dp) :: tip_force = 0.0_dp    !! αγΦ(1) = −Φ'''(1)/α³, without overflow
    real(dp) :: modal_mass = 0.0_dp   !! M/m_i = ∫Φ² dξ + γΦ(1)², Eq. 21
  end type shape_type

contains

  elemental type(shape_type) function shape_of(root) result(shape)
    !! Return the shape of a root of the frequency equation.
    type(root_type), intent(in) :: root
    type(shape_type) :: list(1)
    list = shapes_of([root])
    shape = list(1)
  end function shape_of

  pure function shapes_of(root) result(shape)
    !! Return `shape_of` of a list, in vector registers.
    type(root_type), intent(in) :: root(:)     !! ascending
    type(shape_type) :: shape(size(root))
    integer :: first, k
    first = count(root%k == 1)
    do k = 1, first
      call set_first(root(k), shape(k))
    end do
    call set_higher(root(first + 1:), shape(first + 1:))
  end function shapes_of

  pure subroutine set_first(root, shape)
    !! Find the shape of mode 1, α ≤ 1.8752, by power series, exact also for γ → ∞, where α → 0.
    type(root_type), intent(in) :: root
    type(shape_type), intent(out) :: shape
    real(dp) :: a, x, denominator
    a = root%remainder
    shape%root = root
    shape%alpha = a
    x = a**4
    denominator = sin(a) + sinh(a)
    shape%sigma = (cos(a) + cosh(a))/denominator
    shape%grow = (sin(a) - cos(a) - exp(-a))/denominator*exp(a)
    shape%tip = -8.0_dp*a**3*alternating_series(3, x)/denominator
    shape%tip_force = a*(root%gamma*shape%tip)
    shape%tip_slope = -4.0_dp*a**3*alternating_series(2, x)/denominator
    shape%modal_mass = mass_of(a, shape%tip, shape%tip_force, 2.0_dp*a**2*alternating_series(2, x)/denominator)
  end subroutine set_first

  pure subroutine set_higher(root, shape)
    !! Find shapes of modes from the second on, scaled by e^(−α).
    type(root_type), intent(in) :: root(:)
    type(shape_type), intent(out) :: shape(:)
    real(dp), dimension(size(root)) :: sine, cosine, difference, decay, sech, th, denominator, tip, force, gamma
    type(dd) :: alpha(size(root))
    logical :: light(size(root))
    light = is_light(root)
    call end_angles(root%k, light, root%remainder, sine, cosine, difference)
    alpha = root_values(root)
    gamma = root%gamma
    decay = exp(-min(0.5_dp*alpha%hi, longest_decay))**2      ! may underflow, slowly in a plain exponential
    decay = decay*(1.0_dp - alpha%lo)          ! rounding of α is up to α units in the last place here
    sech = 2.0_dp*decay/(1.0_dp + decay**2)
    th = (1.0_dp - decay**2)/(1.0_dp + decay**2)
    denominator = sine*sech + th                       ! (sin α + sinh α)/cosh α
    where (light)
      tip = 2.0_dp*(cosine*th - sine)/denominator
      force = alpha%hi*gamma*tip
    elsewhere                                          ! the direct form would cancel
      force = -2.0_dp*(sech + cosine)/denominator
      tip = force/alpha%hi/gamma
    end where
    shape%root = root
    shape%alpha = alpha%hi
    shape%grow = (difference - decay)/(decay*sine + 0.5_dp*(1.0_dp - decay**2))
    shape%sigma = 1.0_dp - shape%grow*decay
    shape%tip = tip
    shape%tip_force = force
    shape%tip_slope = -2.0_dp*alpha%hi*sine*th/denominator
    shape%modal_mass = mass_of(alpha%hi, tip, force, sine*th/denominator)
  end subroutine set_higher

  elemental real(dp) function mass_of(alpha, tip, tip_force, end_ratio) result(mass)
    !! Return M/m_i = ¼(1+γ)Φ(1)² + 2(1 + cos α cosh α) sin α sinh α/(sin α + sinh α)², which is ¼Φ(1)(Φ(1) + N/α) −
    !! N·(sin α sinh α/(sin α + sinh α)) with N = αγΦ(1) by the frequency equation: two terms ≥ 0.
    real(dp), intent(in) :: alpha, tip, tip_force
    real(dp), intent(in) :: end_ratio    !! sin α sinh α/(sin α + sinh α)
    mass = 0.25_dp*tip*(tip + tip_force/alpha) - tip_force*end_ratio
  end function mass_of

  pure subroutine end_angles(k, light, remainder, sine, cosine, difference)
    !! Find sin α, cos α and sin α − cos α from the remainder of the root, k ≥ 2.
    integer, intent(in) :: k(:)
    logical, intent(in) :: light(:)
    real(dp), intent(in) :: remainder(:)
    real(dp), intent(out) :: sine(:), cosine(:), difference(:)
    real(dp), dimension(size(k)) :: sign, c, s
    sign = merge(-1.0_dp, 1.0_dp, mod(k, 2) == 0)       ! −(−1)^k
    c = sign*cos(remainder)
    s = sign*sin(remainder)
    where (light)
      sine = c
      cosine = -s
      difference = c + s
    elsewhere
      sine = sqrt(0.5_dp)*(c + s)
      cosine = sqrt(0.5_dp)*(c - s)
      difference = sqrt(2.0_dp)*s
    end where
  end subroutine end_angles

  elemental real(dp) function shape_value(shape, xi) result(value)
    !! Return Φ(ξ): exactly 0 at the root, exactly `tip` at the tip.
    type(shape_type), intent(in) :: shape
    real(dp), intent(in) :: xi           !! 0 ≤ ξ ≤ 1
    real(dp) :: list(1)
    list = shape_values([shape], xi)
    value = list(1)
  end function shape_value

  pure function shape_values(shape, xi) result(values)
    !! Return `shape_value` of a list, in vector registers.
    type(shape_type), intent(in) :: shape(:)
    real(dp), intent(in) :: xi           !! 0 ≤ ξ ≤ 1
    real(dp) :: values(size(shape))
    integer :: k
    if (xi == 1.0_dp) then
      values = shape%tip
      return
    end if
    call evaluate(shape, xi, values)
    do k = 1, size(shape)
      if (shape(k)%alpha*xi < series_below .or. shape(k)%root%k == 1) values(k) = series_value(shape(k), xi)
    end do
  end function shape_values

  pure function curvature_values(shape, xi) result(values)
    !! Return Φ''(ξ)/α² of a list: exactly −2 at the root, exactly 0 at the tip with its point mass.
    type(shape_type), intent(in) :: shape(:)
    real(dp), intent(in) :: xi           !! 0 ≤ ξ ≤ 1
    real(dp) :: values(size(shape))
    integer :: k
    values = 0.0_dp
    if (xi == 1.0_dp) return
    values = -2.0_dp
    if (xi == 0.0_dp) return
    call evaluate(shape, xi, values, turned=-1.0_dp)
    do k = 1, size(shape)
      if (shape(k)%root%k > 1) cycle     ! for a heavy mass σ and e^α(1 − σ) are large and nearly equal
      associate (z => shape(k)%alpha*xi)
        values(k) = -(cos(z) + cosh(z)) + shape(k)%sigma*(sin(z) + sinh(z))
      end associate
    end do
  end function curvature_values

  pure function slope_values(shape, xi) result(values)
    !! Return Φ'(ξ)/α of a list: exactly 0 at the root, exactly `tip_slope` over α at the tip.
    type(shape_type), intent(in) :: shape(:)
    real(dp), intent(in) :: xi           !! 0 ≤ ξ ≤ 1
    real(dp) :: values(size(shape))
    real(dp) :: angle, z
    integer :: k
    values = 0.0_dp
    if (xi == 1.0_dp) values = shape%tip_slope/shape%alpha
    if (xi == 0.0_dp .or. xi == 1.0_dp) return
    do k = 1, size(shape)
      associate (self => shape(k))
        z = self%alpha*xi
        if (z < series_below .or. self%root%k == 1) then
          values(k) = 2.0_dp*z*(self%sigma*z*growing_series(2, z**4) - growing_series(1, z**4))
        else
          angle = angle_at(self%root, xi)
          values(k) = -sin(angle) - self%sigma*cos(angle) + 0.5_dp*(1.0_dp + self%sigma)*exp(-min(z, longest_decay)) &
            - 0.5_dp*self%grow*exp(-min(self%alpha*(1.0_dp - xi), longest_decay))
        end if
      end associate
    end do
  end function slope_values

  pure subroutine evaluate(shape, xi, values, turned)
    !! Evaluate Φ(ξ) or Φ''(ξ)/α² in closed form, for αξ not small.
    type(shape_type), intent(in) :: shape(:)
    real(dp), intent(in) :: xi
    real(dp), intent(out) :: values(:)
    real(dp), intent(in), optional :: turned   !! −1: curvature; absent: shape
    real(dp), dimension(size(shape)) :: angle, c, s, rising, falling
    angle = angle_at(shape%root, xi)
    c = cos(angle)
    s = sin(angle)
    if (present(turned)) then
      c = turned*c
      s = turned*s
    end if
    falling = exp(-min(shape%alpha*xi, longest_decay))
    rising = exp(-min(shape%alpha*(1.0_dp - xi), longest_decay))
    values = c - shape%sigma*s - 0.5_dp*(1.0_dp + shape%sigma)*falling - 0.5_dp*shape%grow*rising
  end subroutine evaluate

  elemental real(dp) function series_value(shape, xi) result(value)
    !! Return Φ(ξ) by power series, for αξ ≲ 2.
    type(shape_type), intent(in) :: shape
    real(dp), intent(in) :: xi
    real(dp) :: z
    z = shape%alpha*xi
    value = 2.0_dp*z**2*(shape%sigma*z*growing_series(3, z**4) - growing_series(2, z**4))
  end function series_value

  elemental real(dp) function angle_at(root, xi) result(angle)
    !! Return αξ modulo 2π. Whole eighths of a cycle are multiplied and reduced exactly.
    type(root_type), intent(in) :: root
    real(dp), intent(in) :: xi
    real(dp) :: eighths, remainder
    call two_product(real(root%eighths, dp), xi, eighths, remainder)
    eighths = eighths - 8.0_dp*aint(0.125_dp*eighths)
    angle = 0.25_dp*pi*(eighths + remainder) + root%remainder*xi
  end function angle_at

end module bw_shape
