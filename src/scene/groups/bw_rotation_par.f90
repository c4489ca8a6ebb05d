module bw_rotation_par
  !! `&rotation`: the root of the beam rotates at a constant rate.
  use bw_constants, only: pi
  use bw_input_name, only: any_number, input_group, input_name, real_input, text_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: build_rotation, rotation_text

  type, public :: rotation_par
    real(dp) :: angular_velocity = 0.0_dp   !! ω [rad/s], of either sign
    character(:), allocatable :: plane      !! 'in' or 'out': the beam bends in or out of the plane of rotation
  end type rotation_par

  type(input_group), parameter, public :: rotation_group = input_group( &
    'rotation', is_effect=.true., absent='the beam does not rotate', &
    physics='The hub turns at a constant angular velocity omega. In the frame that turns with it, motion in the plane of '// &
    'rotation has the additional inertia force rho A omega^2 v, which lowers every frequency: beta^2 = beta_0^2 - omega^2. '// &
    'Out of the plane that force is absent. The axial tension of rotation is `&stiffening`.', &
    example='&rotation angular_velocity = 50, plane = ''in'' /')

  type(input_name), parameter, public :: rotation_names(*) = [ &
    input_name('rotation', 'angular_velocity', real_input, 'rad s-1', any_number, required=.true., swept=.true., &
               meaning='constant angular velocity of the hub'), &
    input_name('rotation', 'plane', text_input, default="'in'", words='in out', &
               meaning='bending in the plane of rotation, or out of it')]

contains

  pure type(rotation_par) function build_rotation(values) result(rotation)
    !! Build the rotation from checked values.
    type(group_values), intent(in) :: values
    rotation%angular_velocity = values%number('angular_velocity')
    rotation%plane = values%text('plane')
  end function build_rotation

  pure function rotation_text(values) result(text)
    !! Return the text of a report: `rotation 50 rad/s (477.5 rpm) in plane`.
    type(group_values), intent(in) :: values
    character(:), allocatable :: text
    real(dp), parameter :: rpm = 30.0_dp/pi    ! revolutions per minute in 1 rad/s
    text = 'rotation '//values%number_or_swept('angular_velocity', ' rad/s ('// &
                                               shortest(rpm*values%number('angular_velocity'), 4)//' rpm)')// &
      trim(merge(' in plane    ', ' out of plane', values%text('plane') == 'in'))
  end function rotation_text

end module bw_rotation_par
