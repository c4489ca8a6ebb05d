module bw_unknown_input
  !! What to say of groups and names that are not in the table: the known ones, and the one that was likely meant.
  use bw_did_you_mean, only: suggestion
  use bw_input_name, only: name_length
  use bw_input_table, only: group_table, name_table, names_of
  implicit none (type, external)
  private
  public :: unknown_group, unknown_name

contains

  pure function unknown_group(group) result(text)
    !! Message for a group that is not in the table.
    character(*), intent(in) :: group
    character(:), allocatable :: text
    integer :: i
    text = 'is no known group'//suggestion(group, group_table%name, '&')//'; accepted:'
    do i = 1, size(group_table)
      text = text//' &'//trim(group_table(i)%name)
    end do
  end function unknown_group

  pure function unknown_name(group, name) result(text)
    !! Message for a name that is not in its group.
    character(*), intent(in) :: group, name
    character(:), allocatable :: text
    character(name_length), allocatable :: names(:)
    integer :: i
    names = names_of(group)
    text = suggestion(name, names, '')
    i = findloc(name_table%name, name, dim=1)
    if (text == '' .and. i > 0) text = ' (it belongs to &'//trim(name_table(i)%group)//')'
    if (index(name, '%') > 0) text = ' (write the group as &group and its names alone)'
    if (index(name, '(') > 0) text = ' (write the values of a list without an index, as points = 0.5, 1.0)'
    text = 'is no known name'//text//'; accepted:'
    do i = 1, size(names)
      text = text//' '//trim(names(i))
    end do
    if (size(names) == 0) text = text//' none'
  end function unknown_name

end module bw_unknown_input
