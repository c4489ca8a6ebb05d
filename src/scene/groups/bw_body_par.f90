module bw_body_par
  !! `&body`: a rigid body attached to the beam, and springs from there to the rotating frame.
  use bw_input_name, only: any_number, input_group, input_name, not_negative, positive, real_input, unit_interval
  use bw_input_values, only: group_values, position_of, positions_of
  use bw_kinds, only: dp, qp
  use bw_mass_or_ratio, only: build_mass, check_mass, mass_par
  use bw_missing, only: missing
  use bw_scene_messages, only: message_list
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: bodies_text, build_body, check_bodies, check_body, comes_or_leaves

  type, extends(mass_par), public :: body_par
    !! Its mass, given or derived, and
    real(dp) :: position = 0.0_dp                !! ξ, 0 ≤ ξ ≤ 1; 0 for springs alone
    real(dp) :: rotary_inertia = 0.0_dp          !! J about its place [kg m²], ≥ 0
    real(dp) :: stiffness = 0.0_dp               !! k_v of a deflection spring [N/m], ≥ 0
    real(dp) :: rotational_stiffness = 0.0_dp    !! k_θ of a rotational spring [N m/rad], ≥ 0
    real(dp) :: from = missing                   !! time of attachment [s]; `missing`: from the beginning
    real(dp) :: until = missing                  !! time of release [s]; `missing`: never
    real(dp) :: velocity = missing               !! its velocity at `from` [m/s]; `missing`: that of the beam there
  end type body_par

  type(input_group), parameter, public :: body_group = input_group( &
    'body', repeatable=.true., along='body', is_effect=.true., builds_up=.true., changes_shapes=.true., &
    absent='nothing is attached to the beam', &
    physics='A rigid body of mass m and moment of inertia J that moves with the beam at a point, with springs to the '// &
    'rotating frame: at its place the shear force jumps by m v_tt + k v, and the moment by J times the angular '// &
    'acceleration of the section.', &
    example='&body position = 0.95, mass = 0.02 /          ! an accelerometer|&body position = 0.4, mass = 0, stiffness = '// &
    '1e5 /   ! and a spring', &
    rules='Write one group for each body. Give `mass` or `mass_ratio`, 0 for springs alone. Springs are fixed to the rotating '// &
    'frame. At the root, position 0, only springs are allowed, in addition to a `&support` that is not rigid. Several bodies '// &
    'may share a place, also with the striking mass. A body comes at `from` and leaves at `until`. It takes on the motion of '// &
    'the beam there, or strikes the beam with `velocity` and stays. Its springs are unstressed at the deflection of the beam '// &
    'when it comes. Loads keep acting through these changes, and a contact (`&contact`) continues. A sample at exactly such a '// &
    'time shows the beam after the change. A sweep names a body by its number in the scene, as `body(2)%mass`; a single body '// &
    'needs no number.')

  type(input_name), parameter, public :: body_names(*) = [ &
    input_name('body', 'position', real_input, '1', unit_interval, required=.true., swept=.true., &
               meaning='place on the beam: x/l, 1 at the tip'), &
    input_name('body', 'mass', real_input, 'kg', not_negative, swept=.true., excludes='mass_ratio', &
               meaning='mass of the body'), &
    input_name('body', 'mass_ratio', real_input, '1', not_negative, swept=.true., excludes='mass', &
               meaning='mass over the mass of the beam'), &
    input_name('body', 'rotary_inertia', real_input, 'kg m2', not_negative, '0', swept=.true., &
               meaning='moment of inertia of the body about its place'), &
    input_name('body', 'stiffness', real_input, 'N m-1', not_negative, '0', swept=.true., &
               meaning='stiffness of a spring against deflection'), &
    input_name('body', 'rotational_stiffness', real_input, 'N m rad-1', not_negative, '0', swept=.true., &
               meaning='stiffness of a spring against rotation'), &
    input_name('body', 'from', real_input, 's', not_negative, swept=.true., meaning='time at which it comes; absent: always '// &
      'there'), &
    input_name('body', 'until', real_input, 's', positive, swept=.true., meaning='time at which it leaves; absent: it stays'), &
    input_name('body', 'velocity', real_input, 'm s-1', any_number, swept=.true., &
               meaning='its velocity at `from`; absent: that of the beam there')]

  character(*), parameter :: and = ' and '

contains

  pure subroutine check_body(body, messages)
    !! Check that the mass is given in one of its two ways, and a velocity only with the time of attachment.
    type(group_values), intent(in) :: body
    type(message_list), intent(inout) :: messages
    call check_mass(body, body%line, ', 0 for springs alone', messages)
    if (body%given('velocity') .and. .not. body%given('from')) call messages%add(body%line_of('velocity'), 'body%velocity', &
      'is that of a body that comes later; accepted: with from, or without velocity')
  end subroutine check_body

  pure logical function comes_or_leaves(groups)
    !! Return whether some body is attached or released during the motion.
    type(group_values), intent(in) :: groups(:)
    integer :: g
    comes_or_leaves = .false.
    do g = 1, size(groups)
      if (groups(g)%group == 'body') comes_or_leaves = comes_or_leaves .or. groups(g)%given('from') .or. groups(g)%given('until')
    end do
  end function comes_or_leaves

  pure subroutine check_bodies(groups, messages)
    !! Check for one case that times are in order and that only springs with an effect are attached to the root.
    type(group_values), intent(in) :: groups(:)
    type(message_list), intent(inout) :: messages
    integer :: g, support
    support = position_of(groups, 'support')
    do g = 1, size(groups)
      if (groups(g)%group /= 'body') cycle
      associate (body => groups(g))
        if (body%known('from') .and. body%known('until')) then
          if (body%number('until') <= body%number('from')) call messages%add(body%line_of('until'), 'body%until', 'is '// &
            shortest(body%number('until'), 15)//', not after from, '//shortest(body%number('from'), 15)// &
            '; accepted: a later time')
        end if
        if (body%number('position') > 0.0_dp) cycle
        if (is_heavy(body)) call messages%add(body%line_of('position'), 'body%position', 'is 0, the root, where only springs '// &
          'can be attached; accepted: > 0, or a body with mass = 0 and without rotary_inertia')
        if (held('stiffness')) call messages%add(body%line_of('stiffness'), 'body%stiffness', 'acts on a root that is rigidly '// &
          'held against deflection; accepted: 0, or a &support with a stiffness')
        if (held('rotational_stiffness')) call messages%add(body%line_of('rotational_stiffness'), 'body%rotational_stiffness', &
          'acts on a root that is rigidly held against rotation; accepted: 0, or a &support with a rotational_stiffness')
      end associate
    end do
  contains
    pure logical function held(name)
      !! Return whether a spring of this body at the root has no effect.
      character(*), intent(in) :: name
      held = groups(g)%number(name) > 0.0_dp
      if (held .and. support > 0) held = .not. groups(support)%known(name)
    end function held
  end subroutine check_bodies

  pure subroutine build_body(values, beam_mass, body, messages)
    !! Build a body from checked values.
    type(group_values), intent(in) :: values
    real(qp), intent(in) :: beam_mass            !! m_i [kg], > 0
    type(body_par), intent(out) :: body
    type(message_list), intent(inout) :: messages
    body%position = values%number('position')
    body%rotary_inertia = values%number('rotary_inertia')
    body%stiffness = values%number('stiffness')
    body%rotational_stiffness = values%number('rotational_stiffness')
    if (values%known('from')) body%from = values%number('from')
    if (values%known('until')) body%until = values%number('until')
    if (values%known('velocity')) body%velocity = values%number('velocity')
    call build_mass(values, beam_mass, body%mass_par, messages)
  end subroutine build_body

  pure logical function is_heavy(body)
    !! Return whether it has mass or inertia.
    type(group_values), intent(in) :: body
    is_heavy = body%number('rotary_inertia') > 0.0_dp
    if (body%known('mass')) is_heavy = is_heavy .or. body%number('mass') > 0.0_dp
    if (body%known('mass_ratio')) is_heavy = is_heavy .or. body%number('mass_ratio') > 0.0_dp
  end function is_heavy

  pure function bodies_text(groups) result(text)
    !! Return the text of a report: `body of 0.2 kg at xi = 0.8`, or the number of bodies if they are many.
    type(group_values), intent(in) :: groups(:)  !! of a scene with at least one
    character(:), allocatable :: text
    integer, parameter :: most = 3
    integer, allocatable :: bodies(:)
    integer :: b
    bodies = positions_of(groups, 'body')
    if (size(bodies) > most) then
      text = text_of(size(bodies))//' bodies'
      return
    end if
    text = body_text(groups(bodies(1)))
    do b = 2, size(bodies)
      text = text//', '//body_text(groups(bodies(b)))
    end do
  end function bodies_text

  pure function body_text(values) result(text)
    !! Return the text of one body, with its mass, inertia and springs.
    type(group_values), intent(in) :: values
    character(:), allocatable :: text
    character(:), allocatable :: place
    text = part(values, 'mass', 'body of ', ' kg', ' mass')// &
      part(values, 'mass_ratio', 'body of ', ' of the beam''s mass', ' mass ratio')// &
      part(values, 'rotary_inertia', 'rotary inertia ', ' kg m2', '')// &
      part(values, 'stiffness', 'spring of ', ' N/m', ' stiffness')// &
      part(values, 'rotational_stiffness', 'rotational spring of ', ' N m/rad', ' stiffness')
    if (text == '') text = and//'body without mass'
    place = ' at xi = '//values%number_or_swept('position', '', digits=15)
    if (values%is_swept('position')) place = ' at swept xi'
    text = text(len(and) + 1:)//place
    if (values%known('from')) text = text//' from '//values%number_or_swept('from', ' s')
    if (values%known('velocity')) text = text//' with '//values%number_or_swept('velocity', ' m/s')
    if (values%known('until')) text = text//' until '//values%number_or_swept('until', ' s')
  end function body_text

  pure function part(values, name, what, unit, swept) result(text)
    !! Return a number and its meaning, after `and`; nothing if it is 0 in every case.
    type(group_values), intent(in) :: values
    character(*), intent(in) :: name
    character(*), intent(in) :: what              !! precedes the number
    character(*), intent(in) :: unit              !! follows it
    character(*), intent(in) :: swept             !! follows the word `swept`
    character(:), allocatable :: text
    text = ''
    if (.not. values%known(name)) return
    if (values%number(name) == 0.0_dp .and. .not. values%is_swept(name)) return
    text = and//what//values%number_or_swept(name, unit)
    if (values%is_swept(name)) text = text//swept
  end function part

end module bw_body_par
