module bw_rotation
  !! Rotation at a constant angular velocity. In plane the term −ω²v of Eq. 1 is taken off the square of every
  !! frequency; out of plane there is no such term, and without tension or shear rotation changes nothing.
  use bw_beam_units, only: beam_units
  use bw_double_double, only: dd, to_dd, operator(*)
  use bw_rotation_par, only: rotation_par
  implicit none (type, external)
  private
  public :: acts_in_plane, dimensionless_speed

contains

  pure logical function acts_in_plane(rotation)
    type(rotation_par), intent(in) :: rotation
    acts_in_plane = rotation%plane == 'in'
  end function acts_in_plane

  pure type(dd) function dimensionless_speed(rotation, units) result(omega)
    !! |ω| l²/h.
    type(rotation_par), intent(in) :: rotation
    type(beam_units), intent(in) :: units
    omega = to_dd(abs(rotation%angular_velocity))*units%time
  end function dimensionless_speed

end module bw_rotation
