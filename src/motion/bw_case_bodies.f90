module bw_case_bodies
  !! The bodies of a case as changes of the beam need them, which of them it carries at a time, and the beam with these.
  use bw_beam_units, only: beam_units
  use bw_change_of_bodies, only: body_type
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_rotation, only: dimensionless_speed
  use bw_scene, only: scene_type
  use bw_scene_pieces, only: joints_of_bodies, pieces_of, varying_of
  use bw_timeline, only: carried_type
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: beam_of, bodies_of, presence, set_pull

contains

  pure type(varying_beam) function beam_of(scene, units, carried) result(given)
    !! Return the beam with what it carries in a configuration.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(carried_type), intent(in) :: carried
    given = varying_of(scene, units, pieces_of(scene, units, carried%captured, carried%body))
  end function beam_of

  function bodies_of(scene, units) result(bodies)
    !! Return the bodies of the scene, and last the striking mass if it is captured, without dimensions.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(body_type), allocatable :: bodies(:)
    integer :: b
    allocate (bodies(0))
    associate (joints => joints_of_bodies(scene))
      do b = 1, size(joints)
        bodies = [bodies, body_type(scene%bodies(b)%position, joints(b)%mass%hi, joints(b)%inertia%hi, joints(b)%stiffness%hi, &
                                    joints(b)%turning_stiffness%hi, scene%bodies(b)%velocity)]
      end do
    end associate
    if (allocated(scene%capture)) bodies = [bodies, body_type(scene%impact%position, scene%impact%mass_ratio, &
      scene%capture%rotary_inertia/units%mass/units%length**2)]
    call set_pull(scene, units, bodies)
  end function bodies_of

  pure subroutine set_pull(scene, units, bodies)
    !! Set the tension that each body brings into the beam as it rotates.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(body_type), intent(inout) :: bodies(:)
    type(dd) :: speed
    real(dp) :: radius, spin_squared
    if (.not. allocated(scene%stiffening)) return
    speed = dimensionless_speed(scene%rotation, units)
    spin_squared = speed%hi**2
    radius = scene%stiffening%hub_radius/units%length
    bodies%pull = spin_squared*bodies%mass*(radius + bodies%position)
  end subroutine set_pull

  pure function presence(scene, carried) result(there)
    !! Return which bodies the beam carries in a configuration, (bodies).
    type(scene_type), intent(in) :: scene
    type(carried_type), intent(in) :: carried
    logical, allocatable :: there(:)
    there = carried%body
    if (allocated(scene%capture)) there = [there, carried%captured]
  end function presence

end module bw_case_bodies
