module bw_root_difference
  !! Differences of roots of two frequency equations, relatively accurate also where the roots nearly agree.
  !!
  !! Eq. 26 divides by α_i⁴ − ᾱ_k⁴. For i = k and a light mass the two roots agree to all digits, so their
  !! difference is solved for itself.
  use bw_kinds, only: dp
  use bw_double_double, only: dd
  use bw_frequency_equation, only: root_type, root_value
  use bw_small_series, only: alternating_series
  implicit none (type, external)
  private
  public :: fourth_power_difference

  real(dp), parameter :: pi = acos(-1.0_dp)

contains

  elemental real(dp) function fourth_power_difference(free, loaded) result(difference)
    !! α⁴ − ᾱ⁴ for a root α of the free beam (γ = 0) and a root ᾱ of the beam with a tip mass (γ ≥ 0).
    !! Zero only for the same k and γ = 0.
    type(root_type), intent(in) :: free    !! solves Eq. 8
    type(root_type), intent(in) :: loaded  !! solves Eq. 19
    real(dp) :: alpha, alpha_bar, drop
    type(dd) :: whole
    if (free%k == 1 .and. loaded%k == 1) then
      difference = first_drop(free%rest**4, loaded)
      return
    end if
    whole = root_value(free)
    alpha = whole%hi
    whole = root_value(loaded)
    alpha_bar = whole%hi
    if (free%k == loaded%k .and. free%eighths == loaded%eighths) then
      drop = light_drop(free, loaded, alpha, alpha_bar)
    else
      drop = 0.25_dp*pi*(free%eighths - loaded%eighths) + (free%rest - loaded%rest)
    end if
    difference = drop*(alpha + alpha_bar)*(alpha**2 + alpha_bar**2)
  end function fourth_power_difference

  elemental real(dp) function first_drop(x_free, loaded) result(drop)
    !! y = x₀ − x of the first roots, x = α⁴: subtracting 1 + T₀(x₀) = 0 from 1 + T₀(x) = 4γxT₃(x) leaves
    !! y = −4γxT₃(x)/T₀[x, x₀] with the divided difference of T₀, whose terms are sums of like signs.
    real(dp), intent(in) :: x_free
    type(root_type), intent(in) :: loaded
    real(dp) :: x, term, powers, divided
    integer :: m
    integer, parameter :: last_term = 8     ! as in bw_small_series, on differences
    x = loaded%rest**4
    powers = 1.0_dp                         ! Σ_j x^j x₀^(m−1−j)
    term = -1.0_dp/6.0_dp                   ! (−4)^m/(4m)!
    divided = term
    do m = 2, last_term
      powers = powers*x_free + x**(m - 1)
      term = -4.0_dp*term/real(4*m*(4*m - 1)*(4*m - 2)*(4*m - 3), dp)
      divided = divided + term*powers
    end do
    drop = -4.0_dp*loaded%gamma*x*alternating_series(3, x)/divided
  end function first_drop

  elemental real(dp) function light_drop(free, loaded, alpha, alpha_bar) result(drop)
    !! d = α_k − ᾱ_k, both anchored at (k − ½)π, by subtracting the two equations for δ:
    !! 2 sin(d/2) [cos(δ_m) − (−1)^k (sinh(d/2)/sin(d/2)) sinh α_m/(cosh α cosh ᾱ)] = ᾱγ (sin δ̄ tanh ᾱ + cos δ̄),
    !! δ_m and α_m the means. The ratio of sines is 1 + O(d²) and is taken from the plain difference.
    type(root_type), intent(in) :: free, loaded
    real(dp), intent(in) :: alpha, alpha_bar
    real(dp) :: half, ratio, mean, sech, sign, mass_term
    half = 0.5_dp*(free%rest - loaded%rest)
    ratio = 1.0_dp
    if (half > 0.0_dp) ratio = sinh(half)/sin(half)
    mean = 0.5_dp*(alpha + alpha_bar)
    sign = merge(1.0_dp, -1.0_dp, mod(free%k, 2) == 0)
    sech = 2.0_dp*exp(-mean)*(1.0_dp - exp(-2.0_dp*mean)) &
      /((1.0_dp + exp(-2.0_dp*alpha))*(1.0_dp + exp(-2.0_dp*alpha_bar)))
    mass_term = alpha_bar*loaded%gamma*(sin(loaded%rest)*tanh(alpha_bar) + cos(loaded%rest))
    drop = 2.0_dp*asin(0.5_dp*mass_term/(cos(0.5_dp*(free%rest + loaded%rest)) - sign*ratio*sech))
  end function light_drop

end module bw_root_difference
