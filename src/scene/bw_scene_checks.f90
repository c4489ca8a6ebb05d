module bw_scene_checks
  !! What the names of a group, and the groups of a scene, have to do with each other.
  use bw_beam_par, only: check_beam
  use bw_damping_par, only: check_damping, settle_damping
  use bw_impact_par, only: check_impact
  use bw_input_name, only: accepted_text, has_word
  use bw_input_table, only: group_row, group_table, name_table, rows_of
  use bw_input_values, only: group_values, is_new, position_of
  use bw_modes_par, only: settle_modes
  use bw_recontact_par, only: check_recontact
  use bw_response_par, only: check_response
  use bw_scene_entries, only: place_of
  use bw_scene_messages, only: message_list
  use bw_shear_par, only: check_shear, settle_shear
  use bw_spectrum_par, only: check_spectrum
  use bw_sweep_par, only: check_sweep
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: check_group, check_groups, settle_groups

contains

  pure subroutine check_groups(groups, messages)
    !! All checks of a scene that no value of a sweep changes.
    type(group_values), intent(in) :: groups(:)   !! without &sweep
    type(message_list), intent(inout) :: messages
    integer :: i
    do i = 1, size(groups)
      call check_group(groups(i), messages)
      call check_needs(groups, i, messages)
    end do
    do i = 1, size(group_table)
      if (group_table(i)%required .and. position_of(groups, group_table(i)%name) == 0) then
        call messages%add(0, '&'//trim(group_table(i)%name), 'is missing; accepted: a scene with this group')
      end if
    end do
    call check_shear(groups, messages)
    call check_spectrum(groups, messages)
    call check_recontact(groups, messages)
  end subroutine check_groups

  pure subroutine check_needs(groups, i, messages)
    !! The groups without which group i has no meaning.
    type(group_values), intent(in) :: groups(:)
    integer, intent(in) :: i
    type(message_list), intent(inout) :: messages
    integer :: row, j
    row = group_row(groups(i)%group)
    do j = 1, size(group_table)
      if (.not. has_word(group_table(row)%needs, group_table(j)%name)) cycle
      if (position_of(groups, group_table(j)%name) > 0) cycle
      call messages%add(groups(i)%line, '&'//trim(groups(i)%group), 'needs &'//trim(group_table(j)%name)// &
                        ', which is absent ('//trim(group_table(j)%absent)//'); accepted: both, or neither')
    end do
  end subroutine check_needs

  pure subroutine check_group(group, messages)
    !! Names that are required or stand instead of each other, then the group's own rules.
    type(group_values), intent(in) :: group
    type(message_list), intent(inout) :: messages
    integer, allocatable :: rows(:)
    integer :: i
    integer :: absent          ! line for what is absent: that of the group where there may be several
    rows = rows_of(group%group)
    absent = merge(group%line, 0, group_table(group_row(group%group))%repeatable)
    do i = 1, size(rows)
      associate (row => name_table(rows(i)))
        if (row%required .and. .not. group%values(i)%given) then
          call messages%add(absent, place_of(row), 'is missing; accepted: '//accepted_text(row))
        end if
        if (group%values(i)%given) call check_excluded(group, i, row%excludes, messages)
      end associate
    end do
    select case (group%group)
    case ('beam'); call check_beam(group, messages)
    case ('damping'); call check_damping(group, messages)
    case ('impact'); call check_impact(group, messages)
    case ('response'); call check_response(group, messages)
    case ('sweep'); call check_sweep(group, messages)
    case default                                   ! the others have no rules of their own
    end select
  end subroutine check_group

  pure subroutine check_excluded(group, i, excludes, messages)
    !! Value i is given, and so is one that it stands instead of: reported at the later of the two.
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

  pure subroutine settle_groups(groups, messages)
    !! Fill in the values of new groups that follow from others, which may change from case to case.
    type(group_values), intent(inout) :: groups(:)   !! of one case
    type(message_list), intent(inout) :: messages
    logical :: struck, captured
    if (is_new(groups, 'damping')) call settle_damping(groups)
    if (is_new(groups, 'shear')) call settle_shear(groups)
    if (.not. is_new(groups, 'modes')) return
    struck = position_of(groups, 'impact') > 0
    captured = struck .and. position_of(groups, 'capture') > 0
    associate (modes => groups(position_of(groups, 'modes')))
      call settle_modes(modes, struck .and. .not. captured, captured, position_of(groups, 'response') > 0, &
                        messages)
    end associate
  end subroutine settle_groups

end module bw_scene_checks
