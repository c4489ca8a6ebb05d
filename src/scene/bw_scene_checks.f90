module bw_scene_checks
  !! The rules between the names of a group, between the groups of a scene, and for each of its cases.
  use bw_body_par, only: check_bodies
  use bw_hub_par, only: check_hub
  use bw_input_name, only: accepted_text, has_word, is_simulated, place_of
  use bw_input_table, only: group_row, group_table, name_table
  use bw_input_values, only: group_values, position_of
  use bw_kinds, only: dp
  use bw_scene, only: method_name, scene_type
  use bw_scene_groups, only: check_rules, check_rules_together
  use bw_scene_messages, only: message_list
  use bw_scene_scales, only: check_scales
  use bw_text, only: lines_of, shortest, string, text_of, words_of
  implicit none (type, external)
  private
  public :: check_case, check_group, check_groups

  integer, parameter :: most_galerkin_modes = 500   !! limit for a given number of modes: seconds of work

contains

  pure subroutine check_groups(groups, messages)
    !! Make all checks of a scene that do not depend on values of sweeps.
    type(group_values), intent(in) :: groups(:)   !! without &sweep
    type(message_list), intent(inout) :: messages
    type(string), allocatable :: needs(:)
    integer :: i, n
    do i = 1, size(groups)
      call check_group(groups(i), messages)
      needs = words_of(group_table(groups(i)%row)%needs)
      do n = 1, size(needs)
        call check_need(groups, i, needs(n)%text, messages)
      end do
      call check_excluded_groups(groups, i, messages)
    end do
    do i = 1, size(group_table)
      if (group_table(i)%required .and. position_of(groups, group_table(i)%name) == 0) call say_missing(groups, i, messages)
    end do
    call check_rules_together(groups, messages)
  end subroutine check_groups

  pure subroutine say_missing(groups, row, messages)
    !! Report a required group that is absent. If another group excuses it, report each effect or event, which needs it.
    type(group_values), intent(in) :: groups(:)
    integer, intent(in) :: row                    !! row of the absent group
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: name
    integer :: i
    name = '&'//trim(group_table(row)%name)
    if (position_of(groups, group_table(row)%unless) == 0) then
      call messages%add(0, name, 'is missing; accepted: a scene with this group')
      return
    end if
    do i = 1, size(groups)
      if (.not. is_simulated(group_table(groups(i)%row))) cycle
      call messages%add(groups(i)%line, '&'//trim(groups(i)%group), 'needs '//name//', which is absent; accepted: both, or '// &
                        'neither')
    end do
  end subroutine say_missing

  pure subroutine check_excluded_groups(groups, i, messages)
    !! Report the groups that group i excludes.
    type(group_values), intent(in) :: groups(:)
    integer, intent(in) :: i
    type(message_list), intent(inout) :: messages
    integer :: j
    do j = 1, size(groups)
      if (.not. has_word(group_table(groups(i)%row)%excludes, groups(j)%group)) cycle
      call messages%add(groups(i)%line, '&'//trim(groups(i)%group), 'excludes &'//trim(groups(j)%group)//' of line '// &
                        text_of(groups(j)%line)//'; accepted: one or the other')
    end do
  end subroutine check_excluded_groups

  pure subroutine check_need(groups, i, need, messages)
    !! Report if group i lacks a group that it needs, or all of several.
    type(group_values), intent(in) :: groups(:)
    integer, intent(in) :: i
    character(*), intent(in) :: need              !! `a`, or `a|b|c`
    type(message_list), intent(inout) :: messages
    type(string), allocatable :: either(:)
    character(:), allocatable :: names
    integer :: n
    if (index(need, '|') == 0) then
      if (position_of(groups, need) > 0) return
      call messages%add(groups(i)%line, '&'//trim(groups(i)%group), 'needs &'//need//', which is absent ('// &
                        trim(group_table(group_row(need))%absent)//'); accepted: a scene with &'//need//', or without &'// &
                        trim(groups(i)%group))
    else
      either = lines_of(need, '|')
      names = ''
      do n = 1, size(either)
        if (position_of(groups, either(n)%text) > 0) return
        if (n > 1) names = names//trim(merge(' or', ',  ', n == size(either)))//' '
        names = names//'&'//either(n)%text
      end do
      call messages%add(groups(i)%line, '&'//trim(groups(i)%group), 'needs '//names//', which are absent ('// &
                        trim(group_table(group_row(either(1)%text))%absent)//'); accepted: with one of them, or without &'// &
                        trim(groups(i)%group))
    end if
  end subroutine check_need

  pure subroutine check_group(group, messages)
    !! Check which names are required or exclude each other, then the group's own rules.
    type(group_values), intent(in) :: group
    type(message_list), intent(inout) :: messages
    integer :: i
    integer :: absent          ! line for absent names: that of the group if there may be several
    absent = merge(group%line, 0, group_table(group%row)%repeatable)
    do i = 1, size(group%values)
      associate (row => name_table(group%values(i)%row))
        if (row%required .and. .not. group%values(i)%given .and. &
            .not. any(group%values%given .and. has_word(row%unless, group%values%name))) then
          call messages%add(absent, place_of(row), 'is missing; accepted: '//accepted_text(row))
        end if
        if (group%values(i)%given) call check_excluded(group, i, row%excludes, messages)
      end associate
    end do
    call check_rules(group, messages)
  end subroutine check_group

  pure subroutine check_excluded(group, i, excludes, messages)
    !! Report, at the later line, if value i and a name that it excludes are both given.
    type(group_values), intent(in) :: group
    integer, intent(in) :: i
    character(*), intent(in) :: excludes
    type(message_list), intent(inout) :: messages
    integer :: j
    associate (mine => group%values(i))
      do j = 1, size(group%values)
        associate (other => group%values(j))
          if (.not. other%given .or. .not. has_word(excludes, other%name)) cycle
          if (other%line > mine%line .or. (other%line == mine%line .and. j > i)) cycle
          call messages%add(mine%line, trim(group%group)//'%'//trim(mine%name), 'excludes '//trim(other%name)// &
                            ' of line '//text_of(other%line)//'; accepted: one or the other')
        end associate
      end do
    end associate
  end subroutine check_excluded

  pure subroutine check_case(scene, messages)
    !! Check what may differ from case to case.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    if (position_of(scene%groups, 'beam') == 0) return
    call check_held(scene, messages)
    call check_struck(scene, messages)
    call check_hub(scene%groups, messages)
    call check_bodies(scene%groups, messages)
    call check_initial_motion(scene, messages)
    if (method_name(scene) == 'galerkin') then
      call check_count(scene, 'before', scene%modes%before, messages)
      call check_count(scene, 'after', scene%modes%after, messages)
    end if
    call check_modal_model(scene, messages)
    call check_scales(scene, messages)
  end subroutine check_case

  pure subroutine check_held(scene, messages)
    !! Check that a rotating beam is held in the plane of rotation. Otherwise an unsupported beam rests or drifts.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    if (.not. (allocated(scene%support) .and. allocated(scene%rotation))) return
    if (scene%rotation%plane /= 'in' .or. scene%rotation%angular_velocity == 0.0_dp) return
    associate (root => scene%support)
      if (.not. (allocated(root%stiffness) .and. allocated(root%rotational_stiffness))) return
      if (root%stiffness > 0.0_dp .or. root%rotational_stiffness > 0.0_dp) return
    end associate
    if (allocated(scene%tip_support)) then
      if (holds(scene%tip_support%stiffness) .or. holds(scene%tip_support%rotational_stiffness)) return
    end if
    if (allocated(scene%bodies)) then
      if (any(scene%bodies%stiffness > 0.0_dp .or. scene%bodies%rotational_stiffness > 0.0_dp)) return
    end if
    call messages%add(scene%groups(position_of(scene%groups, 'support'))%line_of('stiffness'), 'support%stiffness', &
                      'is 0, and so is rotational_stiffness: nothing holds the beam, which rotates in its plane; accepted: '// &
                      'one of them above 0 or left out (rigid), a &tip_support, or a spring of a &body')
  contains
    pure logical function holds(stiffness)
      real(dp), intent(in), optional :: stiffness  !! absent: rigid
      holds = .true.
      if (present(stiffness)) holds = stiffness > 0.0_dp
    end function holds
  end subroutine check_held

  pure subroutine check_struck(scene, messages)
    !! Check that the beam is not struck at a rigid support, where a blow moves nothing.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    if (.not. (allocated(scene%impact) .and. allocated(scene%tip_support))) return
    if (allocated(scene%tip_support%stiffness) .or. scene%impact%position < 1.0_dp) return
    call messages%add(scene%groups(position_of(scene%groups, 'impact'))%line_of('position'), 'impact%position', &
                      'is 1, the tip, which &tip_support holds rigidly: a blow there moves nothing; accepted: > 0 and < 1, or '// &
                      'a stiffness of &tip_support')
  end subroutine check_struck

  pure subroutine check_initial_motion(scene, messages)
    !! Check that a beam clamped to a frame of prescribed motion has no initial rotation.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    logical :: turns
    real(dp) :: radius, speed                     ! of the place of impact
    if (.not. allocated(scene%initial)) return
    if (allocated(scene%impact) .and. .not. allocated(scene%contact)) then
      radius = scene%impact%position*scene%beam%length
      if (allocated(scene%hub)) radius = radius + scene%hub%radius
      speed = scene%initial%angular_velocity*radius
      associate (impact => scene%groups(position_of(scene%groups, 'impact')), velocity => scene%impact%approach_velocity)
        if (velocity /= 0.0_dp .and. speed/velocity >= 1.0_dp) call messages%add(impact%line_of('approach_velocity'), &
          'impact%approach_velocity', 'is '//shortest(velocity, 6)//' m/s, and the beam moves away from the mass at '// &
          shortest(speed, 6)//' m/s there; accepted: a larger one')
      end associate
    end if
    associate (initial => scene%groups(position_of(scene%groups, 'initial')))
      turns = allocated(scene%hub)
      if (allocated(scene%support)) turns = turns .or. allocated(scene%support%rotational_stiffness)
      if (initial%known('angular_velocity') .and. .not. turns) call messages%add(initial%line_of('angular_velocity'), &
        'initial%angular_velocity', 'needs a beam that can turn, and the root is clamped; accepted: with a '// &
        'rotational_stiffness of &support, 0 for a hinge, or with &hub')
    end associate
  end subroutine check_initial_motion

  pure subroutine check_count(scene, name, count, messages)
    !! Check that a Galerkin basis can have this many modes.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: name
    integer, intent(in) :: count
    type(message_list), intent(inout) :: messages
    associate (modes => scene%groups(position_of(scene%groups, 'modes')))
      if (count <= most_galerkin_modes .or. .not. modes%given(name)) return
      call messages%add(modes%line_of(name), 'modes%'//name, 'is '//text_of(count)// &
                        ', more than the Galerkin basis can represent; accepted: 1 to '//text_of(most_galerkin_modes))
    end associate
  end subroutine check_count

  pure subroutine check_modal_model(scene, messages)
    !! Check that a modal model has points at which forces act, and simulated modes.
    type(scene_type), intent(in) :: scene
    type(message_list), intent(inout) :: messages
    integer, parameter :: most_modes = 4000, most_points = 200     !! seconds of work, proportional to their squares
    character(:), allocatable :: what
    integer :: modes, points
    if (.not. scene%modes%modal_model) return
    points = 0
    if (allocated(scene%frequency_response)) points = size(scene%frequency_response%points)
    if (allocated(scene%response)) points = size(scene%response%points)
    modes = max(scene%modes%before, scene%modes%after)
    if (allocated(scene%record)) then
      what = 'needs simulated modes, and excludes &record; accepted: .false.'
    else if (points == 0) then
      what = 'needs points at which forces act; accepted: with &response or &frequency_response, or .false.'
    else if (points > most_points) then
      what = 'takes at most '//text_of(most_points)//' points, and there are '//text_of(points)//'; accepted: fewer, or .false.'
    else if (modes > most_modes) then
      what = 'takes at most '//text_of(most_modes)//' modes, and there are '//text_of(modes)//'; accepted: fewer, or .false.'
    else
      return
    end if
    call messages%add(scene%groups(position_of(scene%groups, 'modes'))%line_of('modal_model'), 'modes%modal_model', what)
  end subroutine check_modal_model

end module bw_scene_checks
