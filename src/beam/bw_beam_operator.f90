module bw_beam_operator
  !! The beam and what acts on its modes, without dimensions: lengths in l, times in l²/h, masses in m_i = ρAl.
  !!
  !! With the deflection v, the turning ψ of the sections and β² the square of an angular frequency,
  !!
  !! - in plane: \( s^{-2}(v''-\psi') + (Tv')' + (\beta^2+\Omega^2)v = 0 \),
  !!   \( \psi'' + s^{-2}(v'-\psi) + r^2\beta^2\psi = 0 \): the section's energy is ½ρI(ω + ψ̇)², so that no Ω² stands with ψ;
  !! - out of plane: \( s^{-2}(v''-\psi') + (Tv')' + \beta^2v = 0 \),
  !!   \( \psi'' + s^{-2}(v'-\psi) + r^2(\beta^2+\Omega^2)\psi = 0 \);
  !! - tip: \( s^{-2}(v'-\psi) + Tv' = \gamma(\beta^2 [+\Omega^2])v \), \( \psi' = J\beta^2\psi \) in either plane.
  !!
  !! Without shear v' = ψ and r = 0.
  use bw_kinds, only: dp
  use bw_double_double, only: dd
  implicit none (type, external)
  private

  type, public :: shear_numbers
    real(dp) :: compliance = 0.0_dp              !! s² = EI/(κGAl²)
    real(dp) :: rotary = 0.0_dp                  !! r² = I/(Al²)
  end type shear_numbers

  type, public :: beam_operator
    !! An unallocated component is an effect that is absent.
    real(dp) :: gamma = 0.0_dp                   !! mass at the tip γ
    type(dd), allocatable :: omega               !! Ω = |ω|l²/h
    logical :: in_plane = .false.                !! the beam rotates and bends in the plane of rotation
    real(dp), allocatable :: tension(:)          !! T(ξ) = t_0 + t_1ξ + t_2ξ² in EI/l², (3)
    real(dp) :: hub_radius = 0.0_dp              !! R in l, where there is tension
    type(shear_numbers), allocatable :: shear
    real(dp), allocatable :: tip_inertia         !! J of the body at the tip in m_i l²
  end type beam_operator

end module bw_beam_operator
