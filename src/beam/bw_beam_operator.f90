module bw_beam_operator
  !! What the effects of a scene make of its beam: the operator whose modes are sought, without dimensions: lengths in l,
  !! times in l²/h, masses in m_i = ρAl.
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
  use bw_beam_units, only: beam_units, body_inertia, shear_numbers, shear_of
  use bw_double_double, only: dd, operator(==)
  use bw_kinds, only: dp
  use bw_rotation, only: acts_in_plane, dimensionless_speed, tension_of
  use bw_scene, only: scene_type
  implicit none (type, external)
  private
  public :: operator_of, shear_numbers

  type, public :: beam_operator
    !! An unallocated component is an effect that is absent. A component that is added here stands in `same_operator`, too.
    real(dp) :: gamma = 0.0_dp                   !! mass at the tip γ
    type(dd), allocatable :: omega               !! Ω = |ω|l²/h
    logical :: in_plane = .false.                !! the beam rotates and bends in the plane of rotation
    real(dp), allocatable :: tension(:)          !! T(ξ) = t_0 + t_1ξ + t_2ξ² in EI/l², (3)
    real(dp) :: hub_radius = 0.0_dp              !! R in l, where there is tension
    type(shear_numbers), allocatable :: shear
    real(dp), allocatable :: tip_inertia         !! J of the body at the tip in m_i l²
  contains
    procedure, private :: same_operator
    generic :: operator(==) => same_operator
  end type beam_operator

contains

  pure type(beam_operator) function operator_of(scene, units, loaded) result(operator)
    !! The operator of the beam with the effects that a scene names; the others are unallocated.
    type(scene_type), intent(in) :: scene          !! without sweeps
    type(beam_units), intent(in) :: units
    logical, intent(in) :: loaded            !! the captured body is at the tip and turns with the section there
    if (loaded) then
      operator%gamma = scene%impact%mass_ratio
      if (scene%capture%rotary_inertia > 0.0_dp) operator%tip_inertia = body_inertia(scene%capture%rotary_inertia, units)
    end if
    if (allocated(scene%rotation)) then
      operator%omega = dimensionless_speed(scene%rotation, units)
      operator%in_plane = acts_in_plane(scene%rotation)
    end if
    if (allocated(scene%stiffening)) then
      operator%hub_radius = scene%stiffening%hub_radius/units%length
      operator%tension = tension_of(operator%omega%hi, operator%hub_radius, operator%gamma)
    end if
    if (allocated(scene%shear)) operator%shear = shear_of(scene%shear, scene%beam)
  end function operator_of

  elemental logical function same_operator(self, other) result(same)
    !! Both have the same effects with the same numbers, so that their modes are the same to the bit.
    class(beam_operator), intent(in) :: self
    type(beam_operator), intent(in) :: other
    same = self%gamma == other%gamma .and. self%hub_radius == other%hub_radius .and. (self%in_plane .eqv. other%in_plane) &
      .and. (allocated(self%omega) .eqv. allocated(other%omega)) &
      .and. (allocated(self%tension) .eqv. allocated(other%tension)) &
      .and. (allocated(self%shear) .eqv. allocated(other%shear)) &
      .and. (allocated(self%tip_inertia) .eqv. allocated(other%tip_inertia))
    if (.not. same) return
    if (allocated(self%omega)) same = self%omega == other%omega
    if (allocated(self%tension)) same = same .and. all(self%tension == other%tension)
    if (allocated(self%shear)) same = same .and. self%shear%compliance == other%shear%compliance &
      .and. self%shear%rotary == other%shear%rotary
    if (allocated(self%tip_inertia)) same = same .and. self%tip_inertia == other%tip_inertia
  end function same_operator

end module bw_beam_operator
