module bw_scene_operator
  !! What the effects of a scene make of its beam.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_beam_units, only: beam_units
  use bw_body_inertia, only: body_inertia
  use bw_double_double, only: dd
  use bw_rotation, only: acts_in_plane, dimensionless_speed
  use bw_scene, only: scene_type
  use bw_shear, only: shear_of, slenderness
  use bw_stiffening, only: tension_of
  implicit none (type, external)
  private
  public :: operator_of, axial_strain

contains

  pure type(beam_operator) function operator_of(scene, units, carries_mass) result(operator)
    !! The operator of the beam with the effects that a scene names; the others are unallocated.
    type(scene_type), intent(in) :: scene          !! without sweeps
    type(beam_units), intent(in) :: units
    logical, intent(in) :: carries_mass            !! the captured body is at the tip
    if (carries_mass) then
      operator%gamma = scene%impact%mass_ratio
      if (scene%capture%rotary_inertia > 0.0_dp) operator%tip_inertia = body_inertia(scene%capture, units)
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

  pure real(dp) function axial_strain(scene, units) result(measure)
    !! Ω√(I/A)/l, ΩD/(4l) for a solid circle: half its square is the largest strain that rotation brings into a beam
    !! without hub and mass. Linear theory wants 0.1 at most.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(dd) :: omega
    measure = 0.0_dp
    if (.not. allocated(scene%rotation)) return
    omega = dimensionless_speed(scene%rotation, units)
    measure = omega%hi*slenderness(scene%beam)
  end function axial_strain

end module bw_scene_operator
