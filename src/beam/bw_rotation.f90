module bw_rotation
  !! Rotation at a constant angular velocity. In plane the term −ω²v of Eq. 1 is taken off the square of every
  !! frequency; out of plane there is no such term, and without tension or shear rotation changes nothing.
  use bw_beam_units, only: beam_units
  use bw_double_double, only: dd, to_dd, to_quad, operator(*)
  use bw_kinds, only: dp, qp
  use bw_rotation_par, only: rotation_par
  implicit none (type, external)
  private
  public :: acts_in_plane, dimensionless_speed, full_speed_in_plane, speed_in_plane

contains

  pure logical function acts_in_plane(rotation)
    !! The beam moves in the plane of rotation, where the centrifugal force acts on its deflection.
    type(rotation_par), intent(in) :: rotation
    acts_in_plane = rotation%plane == 'in'
  end function acts_in_plane

  pure type(dd) function dimensionless_speed(rotation, units) result(omega)
    !! |ω| l²/h.
    type(rotation_par), intent(in) :: rotation
    type(beam_units), intent(in) :: units
    omega = to_dd(abs(rotation%angular_velocity))*units%time
  end function dimensionless_speed

  pure real(dp) function speed_in_plane(rotation, units) result(speed)
    !! |ω| l²/h where rotation acts in the plane of the motion, else 0.
    type(rotation_par), intent(in), optional :: rotation
    type(beam_units), intent(in) :: units
    speed = real(full_speed_in_plane(rotation, units), dp)
  end function speed_in_plane

  pure real(qp) function full_speed_in_plane(rotation, units) result(speed)
    !! The same in all its digits.
    type(rotation_par), intent(in), optional :: rotation
    type(beam_units), intent(in) :: units
    speed = 0.0_qp
    if (.not. present(rotation)) return
    if (acts_in_plane(rotation)) speed = to_quad(dimensionless_speed(rotation, units))
  end function full_speed_in_plane

end module bw_rotation
