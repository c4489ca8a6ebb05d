module bw_hub_par
  !! `&hub`: the beam is fixed to a rigid hub that rotates freely about its axis and recoils.
  use bw_input_name, only: input_group, input_name, not_negative, positive, real_input
  use bw_input_values, only: group_values, position_of
  use bw_kinds, only: dp
  use bw_scene_messages, only: message_list
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: check_hub, complete_hub, hub_text

  type, public :: hub_par
    real(dp) :: rotary_inertia = 0.0_dp   !! J about the axis [kg m²], > 0
    real(dp) :: radius = 0.0_dp           !! R, distance of the root from the axis [m], ≥ 0
  end type hub_par

  type(input_group), parameter, public :: hub_group = input_group( &
    'hub', excludes='recontact', is_effect=.true., builds_up=.true., changes_shapes=.true., &
    absent='the hub''s motion is prescribed: it does not recoil', &
    physics='A rigid hub with the moment of inertia J, free to turn, recoils when the beam is struck: J times its angular '// &
    'acceleration is the moment of the root''s reactions about the axis.', &
    example='&rotation angular_velocity = 50 /|&stiffening hub_radius = 0.1 /|&hub rotary_inertia = 2 /', &
    rules='The root is clamped to the hub, or held on it by the springs of `&support`. Without loads angular momentum is '// &
    'conserved; `&force` and `&base` are external and turn beam and hub. Mode 1 is the rigid rotation, which has no frequency '// &
    'and no waves. Displacements and shapes are measured from the undeformed axis of the beam, which turns with the hub. Only '// &
    'motion in the plane of rotation couples with the hub. A beam that rotates in that plane needs `&stiffening`: without '// &
    'tension the rigid rotation would be unstable. Springs of `&body` and `&tip_support` are refused, since they are fixed to '// &
    'a frame that does not recoil.')

  type(input_name), parameter, public :: hub_names(*) = [ &
    input_name('hub', 'rotary_inertia', real_input, 'kg m2', positive, required=.true., swept=.true., &
               meaning='moment of inertia of the hub about its axis'), &
    input_name('hub', 'radius', real_input, 'm', not_negative, swept=.true., &
               meaning='distance of the root from the axis, else `hub_radius` or 0')]

contains

  pure subroutine complete_hub(groups)
    !! Set the radius, if not given, to that of `&stiffening`, else to 0.
    type(group_values), intent(inout) :: groups(:)
    integer :: hub, stiffening
    hub = position_of(groups, 'hub')
    if (hub == 0) return
    if (groups(hub)%given('radius')) return
    stiffening = position_of(groups, 'stiffening')
    if (stiffening == 0) then
      call groups(hub)%derive('radius', 0.0_dp, 0)
    else
      associate (radius => groups(stiffening)%values(groups(stiffening)%at('hub_radius')))
        if (radius%known) call groups(hub)%derive('radius', radius%numbers(1), radius%sweeps(1))
      end associate
    end if
  end subroutine complete_hub

  pure subroutine check_hub(groups, messages)
    !! Check a case's combination of the hub with groups that act on a frame without recoil.
    type(group_values), intent(in) :: groups(:)       !! of one case, complete
    type(message_list), intent(inout) :: messages
    integer :: hub, other, g
    hub = position_of(groups, 'hub')
    if (hub == 0) return
    other = position_of(groups, 'rotation')
    if (other > 0) then
      if (groups(other)%text('plane') == 'out') then
        call messages%add(groups(hub)%line, '&hub', 'couples only with motion in the plane of rotation, and plane is ''out''; '// &
                          'accepted: plane = ''in'', or without &hub')
      else if (position_of(groups, 'stiffening') == 0 .and. groups(other)%number('angular_velocity') /= 0.0_dp) then
        call messages%add(groups(hub)%line, '&hub', 'needs &stiffening if the beam rotates: without tension the rigid rotation '// &
                          'would be unstable; accepted: with &stiffening, or angular_velocity = 0')
      end if
    end if
    other = position_of(groups, 'stiffening')
    if (other > 0) then
      if (groups(hub)%number('radius') /= groups(other)%number('hub_radius')) &
        call messages%add(groups(hub)%line_of('radius'), 'hub%radius', 'is '//shortest(groups(hub)%number('radius'), 15)// &
                          ', and hub_radius of &stiffening is '//shortest(groups(other)%number('hub_radius'), 15)// &
                          '; accepted: the same, or without radius')
    end if
    do g = 1, size(groups)
      if (holds(groups(g), 'stiffness') .or. holds(groups(g), 'rotational_stiffness')) &
        call messages%add(groups(g)%line, '&'//trim(groups(g)%group), 'has a spring to a frame that does not recoil, and '// &
                          'excludes &hub; accepted: without springs, or without &hub')
    end do
  end subroutine check_hub

  pure logical function holds(group, name)
    !! Return whether a spring of a body, or the support of the tip, acts on the beam.
    type(group_values), intent(in) :: group
    character(*), intent(in) :: name
    holds = .false.
    if (group%group == 'body') holds = group%number(name) > 0.0_dp
    if (group%group == 'tip_support') holds = .not. group%known(name) .or. group%number(name) > 0.0_dp
  end function holds

  pure function hub_text(values) result(text)
    !! Return the text of a report: `free hub (2 kg m2, radius 0.3 m)`.
    type(group_values), intent(in) :: values
    character(:), allocatable :: text
    text = 'free hub ('//values%number_or_swept('rotary_inertia', ' kg m2')//', radius '// &
      values%number_or_swept('radius', ' m')//')'
  end function hub_text

end module bw_hub_par
