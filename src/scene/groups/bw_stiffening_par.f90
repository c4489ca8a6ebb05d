module bw_stiffening_par
  !! `&stiffening`: the tension that rotation causes in the beam.
  use bw_input_name, only: input_group, input_name, not_negative, real_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: stiffening_text

  type, public :: stiffening_par
    real(dp) :: hub_radius = 0.0_dp   !! distance of the root from the axis [m], ≥ 0
  end type stiffening_par

  type(input_group), parameter, public :: stiffening_group = input_group( &
    'stiffening', needs='rotation', is_effect=.true., changes_shapes=.true., &
    absent='no tension: rotation leaves the stiffness of the beam as it is', &
    physics='Rotation causes the tension T(x), the centrifugal force of all mass beyond x: of the beam, its bodies and a '// &
    'captured mass. It adds -(T v_x)_x to the equation of motion and raises the frequencies.', &
    example='&rotation angular_velocity = 50, plane = ''out'' /|&stiffening hub_radius = 0.3 /')

  type(input_name), parameter, public :: stiffening_names(*) = [ &
    input_name('stiffening', 'hub_radius', real_input, 'm', not_negative, '0', swept=.true., &
               meaning='distance of the root from the axis of rotation')]

contains

  pure function stiffening_text(values) result(text)
    !! Return the text of a report: `stiffening (hub radius 0.1 m)`.
    type(group_values), intent(in) :: values
    character(:), allocatable :: text
    text = 'stiffening (hub radius '//values%number_or_swept('hub_radius', ' m')//')'
  end function stiffening_text

end module bw_stiffening_par
