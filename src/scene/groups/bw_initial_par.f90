module bw_initial_par
  !! `&initial`: initial conditions, a static deflection or a rigid rotation.
  use bw_input_name, only: any_number, input_group, input_name, off_the_root, real_input
  use bw_input_values, only: group_values
  use bw_kinds, only: dp
  use bw_scene_messages, only: message_list
  implicit none (type, external)
  private
  public :: build_initial, check_initial, initial_text

  type, public :: initial_par
    real(dp) :: force = 0.0_dp              !! F [N], released at t = 0 from its static deflection
    real(dp) :: position = 1.0_dp           !! ξ where it acts
    real(dp) :: angular_velocity = 0.0_dp   !! of a rigid rotation about the root, or of hub and beam [rad/s]
  end type initial_par

  type(input_group), parameter, public :: initial_group = input_group( &
    'initial', excludes='recontact record', is_event=.true., &
    absent='the beam is straight and at rest when the motion begins', &
    physics='The beam does not start straight and at rest: it is released from a static deflection, or it turns.', &
    example='&initial force = 100, position = 1 /          ! plucked at the tip|&response duration = 0.5, samples = 8192 '// &
    '/', &
    rules='Give `force`, `angular_velocity` or both. The static deflection under a force is released at t = 0, like a plucked '// &
    'string; every mode must be stable. A `&hub` is held until then, and released together with the beam. An angular velocity '// &
    'requires a beam that can turn: about its root (`&support`), or with its `&hub` as one rigid body. Accelerations and shear '// &
    'forces do not converge with this group, and are refused. With `&impact` the mass arrives with `approach_velocity` in the '// &
    'rotating frame and strikes a moving beam; the blow depends on their closing speed. With `&contact` the mass starts in '// &
    'touch with the deflected beam; if the two do not approach each other, it flies beside the beam until they meet, also with '// &
    '`approach_velocity` 0.')

  type(input_name), parameter, public :: initial_names(*) = [ &
    input_name('initial', 'force', real_input, 'N', any_number, swept=.true., &
               meaning='force whose static deflection is released'), &
    input_name('initial', 'position', real_input, '1', off_the_root, '1', swept=.true., &
               meaning='place of the force: x/l, 1 at the tip'), &
    input_name('initial', 'angular_velocity', real_input, 'rad s-1', any_number, swept=.true., &
               meaning='rigid rotation about root or hub, besides `&rotation`')]

contains

  pure subroutine check_initial(values, messages)
    !! Check that something is given, and a place only with a force.
    type(group_values), intent(in) :: values
    type(message_list), intent(inout) :: messages
    if (.not. (values%given('force') .or. values%given('angular_velocity'))) call messages%add(values%line, '&initial', &
      'has neither force nor angular_velocity; accepted: one or both; without the group the beam is straight and at rest')
    if (values%given('position') .and. .not. values%given('force')) call messages%add(values%line_of('position'), &
      'initial%position', 'is the place of a force, which is not given; accepted: with force, or without position')
  end subroutine check_initial

  pure type(initial_par) function build_initial(values) result(initial)
    !! Build the initial conditions from checked values.
    type(group_values), intent(in) :: values
    if (values%known('force')) initial%force = values%number('force')
    if (values%known('position')) initial%position = values%number('position')
    if (values%known('angular_velocity')) initial%angular_velocity = values%number('angular_velocity')
  end function build_initial

  pure function initial_text(values) result(text)
    !! Return the text of a report: `let go from under 1000 N at xi = 1`.
    type(group_values), intent(in) :: values
    character(:), allocatable :: text
    text = ''
    if (values%known('force')) then
      text = ', released from under '//values%number_or_swept('force', ' N')//' at xi = '// &
        values%number_or_swept('position', '', digits=15)
    end if
    if (values%known('angular_velocity')) text = text//', initially turning at '// &
      values%number_or_swept('angular_velocity', ' rad/s')
    text = text(3:)
  end function initial_text

end module bw_initial_par
