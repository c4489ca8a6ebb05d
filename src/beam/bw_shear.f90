module bw_shear
  !! Shear of the beam and rotary inertia of its sections (Timoshenko).
  use bw_beam_par, only: beam_par
  use bw_beam_units, only: slenderness
  use bw_kinds, only: dp
  use bw_shear_par, only: shear_par
  implicit none (type, external)
  private
  public :: shear_of

  type, public :: shear_numbers
    real(dp) :: compliance = 0.0_dp              !! s² = EI/(κGAl²)
    real(dp) :: rotary = 0.0_dp                  !! r² = I/(Al²)
  end type shear_numbers

contains

  pure type(shear_numbers) function shear_of(shear, beam) result(numbers)
    !! s² = EI/(κGAl²) = 2(1 + ν)r²/κ, the shear modulus being E/(2(1 + ν)).
    type(shear_par), intent(in) :: shear
    type(beam_par), intent(in) :: beam
    numbers%rotary = slenderness(beam)**2
    numbers%compliance = 2.0_dp*(1.0_dp + shear%poisson_ratio)/shear%shear_coefficient*numbers%rotary
  end function shear_of

end module bw_shear
