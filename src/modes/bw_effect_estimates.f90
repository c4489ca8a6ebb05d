module bw_effect_estimates
  !! What an effect that is left out would do to a mode, to first order in it: no second solve. Tension, inertia of the sections
  !! and shear weigh integrals of the squares of a shape's derivatives over the beam, which are known in closed form.
  !!
  !! Φ'''' = α⁴Φ lets the shape be split into p = ½(Φ + Φ''/α²), p'' = α²p, and q = ½(Φ − Φ''/α²), q'' = −α²q.
  !! Then p'² − α²p² and q'² + α²q² are constant along the beam, 2p'q' = (pq)'' and 2α²pq = (p'q − pq')', so that every
  !! integral follows from values at the ends, by parts.
  !!
  !! All in the beam's own units. **Errors** of the integrals: 1e-10 relatively, for k to 10⁵; 1e-7 for mode 1 where γ > 10⁵.
  !! **Source**: Rayleigh's quotient of the shape without the effect.
  use bw_kinds, only: dp
  use bw_shape, only: shape_type
  implicit none (type, external)
  private
  public :: shear_shift, tension_shift
  public :: slope_integrals_of                      ! for its own test

  type, public :: slope_integrals
    real(dp) :: slope(0:2) = 0.0_dp     !! ∫₀¹ ξⁿΦ'² dξ, n = 0, 1, 2
    real(dp) :: third = 0.0_dp          !! ∫₀¹ Φ'''² dξ over α⁴
  end type slope_integrals

  type :: end_values
    !! p and q with their derivatives at one end.
    real(dp) :: p = 0.0_dp, p_slope = 0.0_dp, q = 0.0_dp, q_slope = 0.0_dp
  end type end_values

  real(dp), parameter :: static_below = 0.04_dp   !! α of mode 1 below which its shape is that of a force at the tip to 1e-7

contains

  pure real(dp) function tension_shift(shape, tension) result(shift)
    !! What a tension T(ξ) = t_0 + t_1ξ + t_2ξ² adds to β²: ∫TΦ'²/M, an upper bound for the lowest mode.
    type(shape_type), intent(in) :: shape
    real(dp), intent(in) :: tension(3)           !! t_0, t_1, t_2 in EI/l²
    type(slope_integrals) :: integrals
    integrals = slope_integrals_of(shape)
    shift = dot_product(tension, integrals%slope)/shape%modal_mass
  end function tension_shift

  pure real(dp) function shear_shift(shape, compliance, rotary) result(shift)
    !! What shear and the inertia of the sections add to β², < 0.
    !!
    !! Of a long wave they take the fraction s²α² + r²α² off α⁴, at the ends ∫Φ'''²/α⁴ and ∫Φ'² over M in place of α²; of
    !! a short one the lower root of Timoshenko's relation \( r^2s^2\beta^4 - (1 + (r^2+s^2)\alpha^2)\beta^2 + \alpha^4 = 0 \)
    !! is taken, so that no wave is faster than sound.
    type(shape_type), intent(in) :: shape
    real(dp), intent(in) :: compliance           !! s² = EI/(κGAl²)
    real(dp), intent(in) :: rotary               !! r² = I/(Al²)
    type(slope_integrals) :: integrals
    real(dp) :: square, sum, discriminant
    integrals = slope_integrals_of(shape)
    square = shape%alpha**4
    sum = 1.0_dp + (rotary*integrals%slope(0) + compliance*integrals%third)/shape%modal_mass
    discriminant = max(0.0_dp, sum**2 - 4.0_dp*rotary*compliance*square)
    shift = square*(2.0_dp/(sum + sqrt(discriminant)) - 1.0_dp)
  end function shear_shift

  ! Integrals

  elemental type(slope_integrals) function slope_integrals_of(shape) result(integrals)
    !! The integrals of one mode; of the first with a very heavy mass those of a force at the tip.
    type(shape_type), intent(in) :: shape
    type(end_values) :: root, tip
    real(dp) :: growing(0:2), turning(0:2), both(0:2)
    if (shape%alpha < static_below) then
      integrals%slope = shape%tip**2*[1.2_dp, 0.825_dp, 87.0_dp/140.0_dp]     ! Φ = Φ(1)(3ξ² − ξ³)/2
      integrals%third = 9.0_dp*shape%tip**2/shape%alpha**4
      return
    end if
    root = end_values(-1.0_dp, shape%sigma*shape%alpha, 1.0_dp, -shape%sigma*shape%alpha)
    tip = end_values(0.5_dp*shape%tip, 0.5_dp*(shape%tip_slope - shape%alpha*shape%tip_force), &
                     0.5_dp*shape%tip, 0.5_dp*(shape%tip_slope + shape%alpha*shape%tip_force))
    growing = square_moments(root%p, root%p_slope, tip%p, tip%p_slope, shape%alpha**2)
    turning = square_moments(root%q, root%q_slope, tip%q, tip%q_slope, -shape%alpha**2)
    both = product_moments(root, tip, shape%alpha)
    integrals%slope = growing + turning + both
    integrals%third = growing(0) + turning(0) - both(0)
  end function slope_integrals_of

  pure function square_moments(root, root_slope, tip, tip_slope, square) result(moments)
    !! ∫ξⁿf'² dξ, n = 0, 1, 2, of an f with f'' = `square` f.
    real(dp), intent(in) :: root, root_slope, tip, tip_slope, square
    real(dp) :: moments(0:2)
    real(dp) :: constant, product, of_value
    constant = root_slope**2 - square*root**2
    product = tip*tip_slope
    moments(0) = 0.5_dp*(product - root*root_slope) + 0.5_dp*constant
    of_value = (moments(0) - constant)/square                        ! ∫f²
    moments(1) = 0.5_dp*product - 0.25_dp*(tip**2 - root**2) + 0.25_dp*constant
    moments(2) = 0.5_dp*product - 0.5_dp*tip**2 + 0.5_dp*of_value + constant/6.0_dp
  end function square_moments

  pure function product_moments(root, tip, alpha) result(moments)
    !! 2∫ξⁿp'q' dξ, n = 0, 1, 2.
    type(end_values), intent(in) :: root, tip
    real(dp), intent(in) :: alpha
    real(dp) :: moments(0:2)
    real(dp) :: slope, product, of_values
    slope = tip%p*tip%q_slope + tip%p_slope*tip%q
    product = tip%p*tip%q
    of_values = (tip%p_slope*tip%q - tip%p*tip%q_slope - (root%p_slope*root%q - root%p*root%q_slope))/(2.0_dp*alpha**2)
    moments(0) = slope - (root%p*root%q_slope + root%p_slope*root%q)
    moments(1) = slope - (product - root%p*root%q)
    moments(2) = slope - 2.0_dp*(product - of_values)
  end function product_moments

end module bw_effect_estimates
