module bw_scene_parser
  !! Groups tokens into input groups and their statements `name = values`.
  use bw_scene_messages, only: message_list, shown
  use bw_scene_tokens, only: bad_group_token, bad_token, end_token, equals_token, group_token, name_in, span, text_token, &
                             token, word_token
  use bw_text, only: shortened, text_of
  implicit none (type, external)
  private
  public :: parse

  integer, parameter :: most_groups = 1000    !! far more than there are names to sweep

  type, public :: opened_group
    integer :: name = 0                  !! its token
    integer :: line = 0
    integer :: first = 1, last = 0       !! its statements
  end type opened_group

  type, public :: statement
    integer :: name = 0                  !! token of the name
    integer :: first = 1, last = 0       !! tokens of the values, including commas
  end type statement

  type, public :: parsed_scene
    integer :: groups_found = 0, statements_found = 0
    type(opened_group), allocatable :: groups(:)
    type(statement), allocatable :: statements(:)
  end type parsed_scene

contains

  pure subroutine parse(text, tokens, parsed, messages)
    !! Report what is no statement, and groups that are not closed; keep everything that can be checked further.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)
    type(parsed_scene), intent(out) :: parsed
    type(message_list), intent(inout) :: messages
    logical :: open
    integer :: i
    allocate (parsed%groups(count(tokens%kind == group_token .or. tokens%kind == bad_group_token)))
    allocate (parsed%statements(count(tokens%kind == equals_token)))
    open = .false.
    i = 1
    do while (i <= size(tokens) .and. .not. messages%cut)
      if (parsed%groups_found == most_groups) then
        call messages%add(tokens(i)%line, 'text', 'more than '//text_of(most_groups)//' groups, too many for a scene')
        return
      end if
      select case (tokens(i)%kind)
      case (group_token, bad_group_token)
        call open_group(text, tokens, i, open, parsed, messages)
      case (end_token)
        open = .false.
        i = i + 1
      case default
        call parse_statement(text, tokens, i, parsed, messages)
      end select
    end do
    if (open) call report_open(text, tokens, parsed, messages)
  end subroutine parse

  pure subroutine open_group(text, tokens, i, open, parsed, messages)
    !! Open a group at token i, or report an `&end`, which is not accepted.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)
    integer, intent(inout) :: i
    logical, intent(inout) :: open
    type(parsed_scene), intent(inout) :: parsed
    type(message_list), intent(inout) :: messages
    if (name_in(text, tokens(i)) == 'end') then
      call messages%add(tokens(i)%line, '&end', "is not accepted; a group ends with '/'")
      open = .false.
    else
      if (open) call report_open(text, tokens, parsed, messages)
      open = .true.
      associate (n => parsed%groups_found, m => parsed%statements_found)
        n = n + 1
        parsed%groups(n) = opened_group(name=i, line=tokens(i)%line, first=m + 1, last=m)
      end associate
    end if
    i = i + 1
  end subroutine open_group

  pure subroutine report_open(text, tokens, parsed, messages)
    !! Report that the group opened last is not closed.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)
    type(parsed_scene), intent(in) :: parsed
    type(message_list), intent(inout) :: messages
    associate (group => parsed%groups(parsed%groups_found))
      if (tokens(group%name)%kind == bad_group_token) return
      call messages%add(group%line, '&'//shortened(name_in(text, tokens(group%name))), &
                        "is not closed; a group ends with '/'")
    end associate
  end subroutine report_open

  pure subroutine parse_statement(text, tokens, i, parsed, messages)
    !! Parse `name = values` up to the next name, group or end. It belongs to the group opened last.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)
    integer, intent(inout) :: i
    type(parsed_scene), intent(inout) :: parsed
    type(message_list), intent(inout) :: messages
    integer :: last
    if (starts_statement(tokens, i)) then
      call check_separation(text, tokens, i, messages)
      last = last_of_statement(tokens, i + 1)
      associate (n => parsed%statements_found)
        n = n + 1
        parsed%statements(n) = statement(name=i, first=i + 2, last=last)
        if (parsed%groups_found > 0) parsed%groups(parsed%groups_found)%last = n
      end associate
    else
      last = last_of_statement(tokens, i)
      if (tokens(i)%kind /= bad_token) then
        call messages%add(tokens(i)%line, 'text', shown(span(text, tokens(i)))// &
                          " is not a name; accepted: name = value, or '/' to end the group")
      end if
    end if
    i = last + 1
  end subroutine parse_statement

  pure subroutine check_separation(text, tokens, i, messages)
    !! Check that a name is separated from the text before it: Fortran, too, rejects `plane='in'title=`.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)
    integer, intent(in) :: i
    type(message_list), intent(inout) :: messages
    if (i == 1 .or. .not. tokens(i)%glued) return
    if (tokens(i - 1)%kind /= text_token) return
    call messages%add(tokens(i)%line, 'text', 'no comma or blank between '//shown(span(text, tokens(i - 1)))// &
                      ' and '//shown(span(text, tokens(i))))
  end subroutine check_separation

  pure logical function starts_statement(tokens, i)
    !! Return whether this token is a name followed by an equals sign.
    type(token), intent(in) :: tokens(:)
    integer, intent(in) :: i
    starts_statement = .false.
    if (i < size(tokens)) starts_statement = any(tokens(i)%kind == [word_token, bad_token]) &
      .and. tokens(i + 1)%kind == equals_token
  end function starts_statement

  pure integer function last_of_statement(tokens, first) result(last)
    !! Return the last token before the next name, group or end.
    type(token), intent(in) :: tokens(:)
    integer, intent(in) :: first
    last = first
    do while (last < size(tokens))
      if (any(tokens(last + 1)%kind == [group_token, bad_group_token, end_token])) return
      if (starts_statement(tokens, last + 1)) return
      last = last + 1
    end do
  end function last_of_statement

end module bw_scene_parser
