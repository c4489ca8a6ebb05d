module bw_rotation
  !! Rotation at constant angular velocity. In plane the term −ω²v of Eq. 1 lowers the square of every frequency; out of plane,
  !! without tension or shear, rotation has no effect. In either plane it brings a tension into the beam, which stiffens it.
  use bw_beam_units, only: beam_units
  use bw_double_double, only: dd, to_dd, operator(*)
  use bw_kinds, only: dp
  use bw_rotation_par, only: rotation_par
  implicit none (type, external)
  private
  public :: acts_in_plane, dimensionless_speed, full_speed_in_plane, speed_in_plane

contains

  pure logical function acts_in_plane(rotation)
    !! Return whether the beam moves in the plane of rotation, where the centrifugal force acts on its deflection.
    type(rotation_par), intent(in) :: rotation
    acts_in_plane = rotation%plane == 'in'
  end function acts_in_plane

  pure type(dd) function dimensionless_speed(rotation, units) result(omega)
    !! Return |ω| l²/h.
    type(rotation_par), intent(in) :: rotation
    type(beam_units), intent(in) :: units
    omega = to_dd(abs(rotation%angular_velocity))*units%time
  end function dimensionless_speed

  pure real(dp) function speed_in_plane(rotation, units) result(speed)
    !! Return |ω| l²/h if rotation acts in the plane of motion, else 0.
    type(rotation_par), intent(in), optional :: rotation
    type(beam_units), intent(in) :: units
    type(dd) :: full
    full = full_speed_in_plane(rotation, units)
    speed = full%hi
  end function speed_in_plane

  pure type(dd) function full_speed_in_plane(rotation, units) result(speed)
    !! Return the same in double-double.
    type(rotation_par), intent(in), optional :: rotation
    type(beam_units), intent(in) :: units
    if (.not. present(rotation)) return
    if (acts_in_plane(rotation)) speed = dimensionless_speed(rotation, units)
  end function full_speed_in_plane

end module bw_rotation
