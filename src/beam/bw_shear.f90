module bw_shear
  !! Shear of the beam and rotary inertia of its sections (Timoshenko).
  use bw_kinds, only: dp
  use bw_beam_operator, only: shear_numbers
  use bw_beam_par, only: beam_par
  use bw_shear_par, only: shear_par
  implicit none (type, external)
  private
  public :: shear_of, slenderness

contains

  pure type(shear_numbers) function shear_of(shear, beam) result(numbers)
    !! s² = EI/(κGAl²) = 2(1 + ν)r²/κ, the shear modulus being E/(2(1 + ν)).
    type(shear_par), intent(in) :: shear
    type(beam_par), intent(in) :: beam
    numbers%rotary = slenderness(beam)**2
    numbers%compliance = 2.0_dp*(1.0_dp + shear%poisson_ratio)/shear%shear_coefficient*numbers%rotary
  end function shear_of

  pure real(dp) function slenderness(beam) result(r)
    !! r = √(I/A)/l: D/(4l) for a solid circle.
    type(beam_par), intent(in) :: beam
    if (beam%round) then
      r = 0.25_dp*beam%diameter/beam%length
    else
      r = sqrt(beam%second_moment/beam%area)/beam%length
    end if
  end function slenderness

end module bw_shear
