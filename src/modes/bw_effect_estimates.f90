module bw_effect_estimates
  !! What an effect that is left out would do to a mode, to first order in it: no second solve.
  !!
  !! All in the beam's own units. **Source**: Rayleigh's quotient of the shape without the effect.
  use bw_kinds, only: dp
  use bw_shape, only: shape_type
  use bw_slope_integrals, only: slope_integrals, slope_integrals_of
  implicit none (type, external)
  private
  public :: shear_shift, tension_shift

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
    !! Of a long wave they take the part (s²α² + r²α²) off α⁴, at the ends ∫Φ'''²/α⁴ and ∫Φ'² over M in place of α²; of
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

end module bw_effect_estimates
