module bw_scene_items
  !! The items of a statement: `2*0.5, 1.0,` holds the item 0.5, twice, and the item 1.0.
  !!
  !! Commas and blanks separate; values may continue on further lines; one trailing comma is accepted. An omitted value
  !! (`1,,2`, `2*`), which to Fortran means 'keep the old value', is an error.
  use bw_scene_messages, only: message_list, shown
  use bw_scene_tokens, only: bad_token, comma_token, equals_token, text_token, token, word_token
  implicit none (type, external)
  private
  public :: read_items

  type, public :: item
    integer :: repeat = 1
    integer :: first = 1, last = 0        !! span in the text, without quotes
    integer :: line = 0
    character :: quote = ' '              !! of a text; blank for a bare word
  end type item

  integer, parameter :: most_digits = 9   !! of a repeat count, which fits a default integer

contains

  pure subroutine read_items(text, tokens, line, place, items, messages)
    !! Return the items of one statement; none if there is an error, which is reported.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)         !! those after the equals sign
    integer, intent(in) :: line                  !! of the name
    character(*), intent(in) :: place
    type(item), allocatable, intent(out) :: items(:)
    type(message_list), intent(inout) :: messages
    type(item), allocatable :: found(:)
    character(:), allocatable :: problem
    integer :: at
    allocate (items(0))
    if (size(tokens) == 0) then
      call messages%add(line, place, 'the value is missing')
      return
    end if
    call parse_items(text, tokens, found, at, problem)
    if (problem /= '') then
      call messages%add(tokens(min(at, size(tokens)))%line, place, problem)
    else if (at > size(tokens)) then
      items = found
    end if
  end subroutine read_items

  pure subroutine parse_items(text, tokens, found, at, problem)
    !! Parse items up to the first problem, or up to a token whose error was reported before.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)
    type(item), allocatable, intent(out) :: found(:)
    integer, intent(out) :: at                   !! the token after the last item
    character(:), allocatable, intent(out) :: problem
    type(item) :: parsed
    logical :: comma
    integer :: n
    allocate (found(size(tokens)))
    problem = ''
    comma = .true.
    n = 0
    at = 1
    do while (at <= size(tokens) .and. problem == '')
      select case (tokens(at)%kind)
      case (comma_token)
        if (comma) problem = 'a value is missing before a comma'
        comma = .true.
        at = at + 1
      case (word_token, text_token)
        call parse_item(text, tokens, at, parsed, problem)
        comma = .false.
        n = n + 1
        found(n) = parsed
      case (equals_token)
        problem = "a second '='"
      case default
        exit
      end select
    end do
    found = found(:n)
  end subroutine parse_items

  pure subroutine parse_item(text, tokens, i, parsed, problem)
    !! Parse one word or text with its repeat count, if any; `i` moves past it.
    character(*), intent(in) :: text
    type(token), intent(in) :: tokens(:)
    integer, intent(inout) :: i
    type(item), intent(out) :: parsed
    character(:), allocatable, intent(inout) :: problem
    integer :: star
    parsed = item(first=tokens(i)%first, last=tokens(i)%last, line=tokens(i)%line, quote=tokens(i)%quote)
    star = 0
    if (tokens(i)%kind == word_token) star = index(text(parsed%first:parsed%last), '*')
    if (star > 0) then
      call parse_count(text(parsed%first:parsed%first + star - 2), parsed%repeat, problem)
      if (problem /= '') return
      parsed%first = parsed%first + star
      if (parsed%first > parsed%last) call parse_repeated_text(tokens, i, parsed, problem)
      if (problem /= '') return
    end if
    i = i + 1
    if (i > size(tokens)) return
    if (tokens(i)%glued .and. any(tokens(i)%kind == [word_token, text_token, bad_token])) then
      problem = 'no comma or blank between '//shown(text(parsed%first:parsed%last))//' and '// &
                shown(text(tokens(i)%first:tokens(i)%last))
    end if
  end subroutine parse_item

  pure subroutine parse_count(digits, count, problem)
    !! Parse the repeat count before a star.
    character(*), intent(in) :: digits
    integer, intent(inout) :: count
    character(:), allocatable, intent(inout) :: problem
    if (digits == '' .or. verify(digits, '0123456789') > 0) then
      problem = shown(digits//'*')//' is not a repeat count; accepted: as in 2*0.5'
    else if (len(digits) > most_digits) then
      problem = 'the repeat count '//shown(digits)//' is too large'
    else
      read (digits, *) count
      if (count == 0) problem = 'a repeat count of 0; accepted: 1 or more'
    end if
  end subroutine parse_count

  pure subroutine parse_repeated_text(tokens, i, parsed, problem)
    !! Parse a text in quotes, which has to follow `2*` without a blank.
    type(token), intent(in) :: tokens(:)
    integer, intent(inout) :: i
    type(item), intent(inout) :: parsed
    character(:), allocatable, intent(inout) :: problem
    problem = "no value behind '*' of a repeat count; accepted: as in 2*0.5"
    if (i == size(tokens)) return
    if (tokens(i + 1)%kind /= text_token .or. .not. tokens(i + 1)%glued) return
    i = i + 1
    parsed%first = tokens(i)%first
    parsed%last = tokens(i)%last
    parsed%quote = tokens(i)%quote
    problem = ''
  end subroutine parse_repeated_text

end module bw_scene_items
