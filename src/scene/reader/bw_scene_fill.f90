module bw_scene_fill
  !! Statements as values: each is matched with its row of the table and read.
  use bw_input_name, only: place_of
  use bw_input_table, only: group_row, group_table, name_table, rows_of, unknown_group, unknown_name
  use bw_input_values, only: group_values
  use bw_scene_entries, only: read_value
  use bw_scene_items, only: item, read_items
  use bw_scene_lexer, only: tokenise
  use bw_scene_messages, only: message_list
  use bw_scene_parser, only: opened_group, parsed_scene, statement
  use bw_scene_tokens, only: bad_group_token, bad_token, name_in, token
  use bw_text, only: joined, shortened, text_of
  implicit none (type, external)
  private
  public :: fill_groups

contains

  pure subroutine fill_groups(text, tokens, parsed, groups, messages)
    !! Return the groups of a scene with all given values, and defaults for the others.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)
    type(parsed_scene), intent(in) :: parsed
    type(group_values), allocatable, intent(out) :: groups(:)
    type(message_list), intent(inout) :: messages
    integer :: rows(parsed%groups_found), i, n, s
    logical :: implied(size(group_table))
    rows = known_groups(text, tokens, parsed)
    do i = 1, size(rows)
      if (messages%cut) exit
      if (rows(i) > 0 .or. tokens(parsed%groups(i)%name)%kind == bad_group_token) cycle
      call report_group(name_in(text, tokens(parsed%groups(i)%name)), parsed%groups, i, rows, messages)
    end do
    implied = [(group_table(i)%implied .and. .not. any(rows == i), i=1, size(group_table))]
    if (any(rows == group_row('record')) .and. .not. any(rows == group_row('beam'))) implied(group_row('modes')) = .false.
    allocate (groups(count(rows > 0) + count(implied)))
    n = 0
    do i = 1, size(rows)
      if (rows(i) == 0) cycle
      n = n + 1
      call open_group(rows(i), parsed%groups(i)%line, groups(n))
      do s = parsed%groups(i)%first, parsed%groups(i)%last
        if (messages%cut) exit
        call fill_value(text, tokens, parsed%statements(s), groups(n), messages)
      end do
    end do
    do i = 1, size(implied)
      if (.not. implied(i)) cycle
      n = n + 1
      call open_group(i, 0, groups(n))
    end do
    do i = 1, size(groups)
      call fill_defaults(groups(i))
    end do
  end subroutine fill_groups

  pure function known_groups(text, tokens, parsed) result(rows)
    !! Return the row of each opened group in the table; 0 if it is unknown or repeated without permission.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)
    type(parsed_scene), intent(in) :: parsed
    integer :: rows(parsed%groups_found)
    integer :: i
    do i = 1, size(rows)
      rows(i) = group_row(name_in(text, tokens(parsed%groups(i)%name)))
      if (rows(i) == 0) cycle
      if (.not. group_table(rows(i))%repeatable .and. any(rows(:i - 1) == rows(i))) rows(i) = 0
    end do
  end function known_groups

  pure subroutine report_group(group, opened, i, rows, messages)
    !! Report that group i is unknown or repeated.
    character(*), intent(in) :: group
    type(opened_group), intent(in) :: opened(:)
    integer, intent(in) :: i, rows(:)
    type(message_list), intent(inout) :: messages
    integer :: first
    if (group_row(group) == 0) then
      call messages%add(opened(i)%line, '&'//shortened(group), unknown_group(group))
    else
      first = findloc(rows, group_row(group), dim=1)
      call messages%add(opened(i)%line, '&'//group, 'is given again, after line '//text_of(opened(first)%line)// &
                        '; accepted: each group once, except '// &
                        joined(pack(group_table%name, group_table%repeatable), '&'))
    end if
  end subroutine report_group

  pure subroutine open_group(row, line, group)
    !! Make a group without values.
    integer, intent(in) :: row, line
    type(group_values), intent(out) :: group
    integer, allocatable :: rows(:)
    rows = rows_of(group_table(row)%name)
    group%group = group_table(row)%name
    group%row = row
    group%line = line
    allocate (group%values(size(rows)))
    group%values%row = rows
    group%values%name = name_table(rows)%name
  end subroutine open_group

  pure subroutine fill_value(text, tokens, source, group, messages)
    !! Read the value of one statement.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)
    type(statement), intent(in) :: source
    type(group_values), intent(inout) :: group
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: name, place
    type(item), allocatable :: items(:)
    integer :: i, line
    if (tokens(source%name)%kind == bad_token) return
    name = name_in(text, tokens(source%name))
    line = tokens(source%name)%line
    place = trim(group%group)//'%'//shortened(name)
    i = group%at(name)
    if (i == 0) then
      call messages%add(line, place, unknown_name(trim(group%group), name))
    else if (group%values(i)%given) then
      call messages%add(line, place, 'is given again, after line '//text_of(group%values(i)%line)//'; accepted: once')
    else
      group%values(i)%given = .true.
      group%values(i)%line = line
      call read_items(text, tokens(source%first:source%last), line, place, items, messages)
      if (size(items) == 0) return
      call read_value(name_table(group%values(i)%row), text, items, group%values(i), messages)
    end if
  end subroutine fill_value

  pure subroutine fill_defaults(group)
    !! Read defaults as if the scene gave them, also in a faulty scene.
    type(group_values), intent(inout) :: group
    type(message_list) :: messages               ! stays empty: defaults are valid
    type(token), allocatable :: tokens(:)
    type(item), allocatable :: items(:)
    integer :: i
    do i = 1, size(group%values)
      associate (row => name_table(group%values(i)%row))
        if (group%values(i)%given .or. row%default == '') cycle
        call tokenise(row%default, .true., tokens, messages)
        call read_items(row%default, tokens, 0, place_of(row), items, messages)
        call read_value(row, row%default, items, group%values(i), messages)
      end associate
    end do
  end subroutine fill_defaults

end module bw_scene_fill
