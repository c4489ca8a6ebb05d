module bw_scene_lexer
  !! Splits the text of a scene into tokens with line numbers.
  !!
  !! Text outside groups, unclosed quotes and characters that a namelist does not allow are reported here; the parser
  !! interprets tokens.
  use bw_scene_messages, only: message_list, shown
  use bw_scene_tokens, only: bad_group_token, bad_token, blanks, comma_token, end_token, ends_word, equals_token, &
    group_token, is_ascii, is_name, is_utf8, line_feed, lines_up_to, name_in, stray_control, text_token, token, word_token
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: tokenise

  type :: scanner
    integer :: at = 1                            !! next character
    integer :: line = 1
    integer :: past = 0                          !! first character after the last token
    logical :: inside = .false.                  !! inside a group
    integer :: count = 0
    type(token), allocatable :: tokens(:)
  end type scanner

  integer, parameter :: most_tokens = 2**22      !! more than two for each value that a scene may hold
  character(*), parameter :: byte_order_mark = char(239)//char(187)//char(191)

contains

  pure subroutine tokenise(text, inside, tokens, messages)
    !! Split a text; every token holds a span of `text`.
    character(*), intent(in) :: text
    logical, intent(in) :: inside                !! the text starts inside a group
    type(token), allocatable, intent(out) :: tokens(:)
    type(message_list), intent(inout) :: messages
    type(scanner) :: lex
    integer :: stray
    allocate (lex%tokens(64))
    lex%inside = inside
    if (index(text, byte_order_mark) == 1) lex%at = 1 + len(byte_order_mark)
    stray = stray_control(text)
    if (stray > 0) then
      call report_control(text, stray, messages)
      lex%at = len(text) + 1
    end if
    do while (lex%at <= len(text) .and. .not. messages%cut)
      if (lex%count == most_tokens) then
        call messages%add(lex%line, 'text', 'more than '//text_of(most_tokens)//' words and signs, too many for a scene')
        exit
      end if
      call lex_next(text, lex, messages)
    end do
    tokens = lex%tokens(:lex%count)
  end subroutine tokenise

  pure subroutine report_control(text, stray, messages)
    !! Report the first byte that is not text.
    character(*), intent(in) :: text
    integer, intent(in) :: stray
    type(message_list), intent(inout) :: messages
    integer :: line
    line = lines_up_to(text, stray)
    select case (iachar(text(stray:stray)))
    case (0)
      call messages%add(line, 'text', 'a NUL byte; accepted: a text file in UTF-8')
    case (13)
      call messages%add(line, 'text', 'a carriage return without a line feed; accepted: line ends LF or CR LF')
    case default
      call messages%add(line, 'text', 'a control character; accepted: a text file in UTF-8')
    end select
  end subroutine report_control

  pure subroutine lex_next(text, lex, messages)
    !! Read the next character, and the token that it starts.
    character(*), intent(in) :: text
    type(scanner), intent(inout) :: lex
    type(message_list), intent(inout) :: messages
    select case (text(lex%at:lex%at))
    case (line_feed)
      lex%line = lex%line + 1
      lex%at = lex%at + 1
    case (' ', achar(9), achar(13))
      lex%at = lex%at + 1
    case ('!')
      lex%at = line_end(text, lex%at)
    case ('&')
      call lex_group(text, lex, messages)
    case default
      if (lex%inside) then
        call lex_inside(text, lex, messages)
      else
        call lex_outside(text, lex, messages)
      end if
    end select
  end subroutine lex_next

  pure subroutine lex_inside(text, lex, messages)
    !! Read a token inside a group.
    character(*), intent(in) :: text
    type(scanner), intent(inout) :: lex
    type(message_list), intent(inout) :: messages
    if (text(lex%at:lex%at) == '#' .or. text(lex%at:min(lex%at + 1, len(text))) == '//') then
      call messages%add(lex%line, 'text', shown(text(lex%at:line_end(text, lex%at) - 1))// &
                        ' is not a comment here; a comment opens with !')
      lex%at = line_end(text, lex%at)              ! skip the rest of the line
      return
    end if
    select case (text(lex%at:lex%at))
    case ('/')
      call add_token(lex, end_token, lex%at, lex%at)
      lex%inside = .false.
    case ('=')
      call add_token(lex, equals_token, lex%at, lex%at)
    case (',')
      call add_token(lex, comma_token, lex%at, lex%at)
    case (';')
      call messages%add(lex%line, 'text', "';' separates nothing here; accepted: ',' or blanks between values, and a point in 0.5")
      lex%at = lex%at + 1
    case ('''', '"')
      call lex_text(text, lex, messages)
    case default
      call lex_word(text, lex, messages)
    end select
  end subroutine lex_inside

  pure subroutine add_token(lex, kind, first, last)
    !! Add a token and move past it.
    type(scanner), intent(inout) :: lex
    integer, intent(in) :: kind, first, last
    type(token), allocatable :: more(:)
    if (lex%count == size(lex%tokens)) then
      allocate (more(2*lex%count))
      more(:lex%count) = lex%tokens
      call move_alloc(more, lex%tokens)
    end if
    lex%count = lex%count + 1
    lex%tokens(lex%count) = token(kind=kind, first=first, last=last, line=lex%line, glued=lex%at == lex%past)
    lex%at = last + 1
    lex%past = lex%at
  end subroutine add_token

  pure subroutine lex_group(text, lex, messages)
    !! Read `&name`, which opens a group anywhere, or `&end`, which closes one (the parser rejects it).
    character(*), intent(in) :: text
    type(scanner), intent(inout) :: lex
    type(message_list), intent(inout) :: messages
    integer :: last
    last = word_end(text, lex%at + 1)
    if (.not. is_name(text(lex%at + 1:last))) then
      call messages%add(lex%line, 'text', &
                        shown(text(lex%at:last))//" names no group; accepted: '&' and a name, as &beam")
      call add_token(lex, bad_group_token, lex%at + 1, last)
    else
      call add_token(lex, group_token, lex%at + 1, last)
    end if
    lex%inside = name_in(text, lex%tokens(lex%count)) /= 'end'
  end subroutine lex_group

  pure subroutine lex_text(text, lex, messages)
    !! Read a text from quote to quote on one line; a doubled quote stands for one.
    character(*), intent(in) :: text
    type(scanner), intent(inout) :: lex
    type(message_list), intent(inout) :: messages
    integer :: first, last, closing
    first = lex%at + 1
    closing = closing_quote(text, lex%at)
    if (closing == 0) then
      last = line_end(text, lex%at) - 1
      call messages%add(lex%line, 'text', 'no closing quote on this line: '//shown(text(lex%at:last)))
      call add_token(lex, bad_token, first, last)
    else if (.not. is_utf8(text(first:closing - 1))) then
      call messages%add(lex%line, 'text', 'a text that is not UTF-8')
      call add_token(lex, bad_token, first, closing)
    else
      call add_token(lex, text_token, first, closing - 1)
      lex%tokens(lex%count)%quote = text(closing:closing)
      lex%at = closing + 1
      lex%past = lex%at
    end if
  end subroutine lex_text

  pure integer function closing_quote(text, opening) result(at)
    !! Return the place of the next such quote on the line that is not doubled; 0 for none.
    character(*), intent(in) :: text
    integer, intent(in) :: opening
    at = opening + 1
    do while (at <= len(text))
      if (text(at:at) == line_feed) exit
      if (text(at:at) == text(opening:opening)) then
        if (at == len(text)) return
        if (text(at + 1:at + 1) /= text(opening:opening)) return
        at = at + 1
      end if
      at = at + 1
    end do
    at = 0
  end function closing_quote

  pure subroutine lex_word(text, lex, messages)
    !! Read a bare word: a name, a number or a logical.
    character(*), intent(in) :: text
    type(scanner), intent(inout) :: lex
    type(message_list), intent(inout) :: messages
    integer :: last
    last = word_end(text, lex%at)
    if (is_ascii(text(lex%at:last))) then
      call add_token(lex, word_token, lex%at, last)
    else
      call messages%add(lex%line, 'text', shown(text(lex%at:last))// &
                        ' contains a non-ASCII character; accepted only inside quotes and comments')
      call add_token(lex, bad_token, lex%at, last)
    end if
  end subroutine lex_word

  pure subroutine lex_outside(text, lex, messages)
    !! Report text outside groups, once per line.
    character(*), intent(in) :: text
    type(scanner), intent(inout) :: lex
    type(message_list), intent(inout) :: messages
    integer :: last
    last = scan(text(lex%at:), '&!'//line_feed)
    last = merge(len(text), lex%at + last - 2, last == 0)
    associate (piece => text(lex%at:last))
      call messages%add(lex%line, 'text', shown(piece(:verify(piece, blanks, back=.true.)))// &
                        ' is outside the groups'//outside_hint(piece))
    end associate
    lex%at = last + 1
  end subroutine lex_outside

  pure function outside_hint(piece) result(hint)
    !! Suggest what text outside groups was meant to be: a comment of another language, or the denominator of a fraction.
    character(*), intent(in) :: piece
    character(:), allocatable :: hint
    character(2), parameter :: signs(*) = ['# ', '//', '/ ', '/*', '--', '% ', ';;', '{ ']
    integer :: i
    hint = '; a comment opens with !'
    do i = 1, size(signs)
      if (index(piece, trim(signs(i))) == 1) return
    end do
    hint = ': a group opens with &name and ends at the first /, so write 0.5 instead of 1/2'//hint
  end function outside_hint

  pure integer function word_end(text, first)
    !! Return the last character of the word that starts at `first`; first − 1 for none.
    character(*), intent(in) :: text
    integer, intent(in) :: first
    word_end = first - 1
    do while (word_end < len(text))
      if (ends_word(text(word_end + 1:word_end + 1))) exit
      word_end = word_end + 1
    end do
  end function word_end

  pure integer function line_end(text, at)
    !! Return the place of the line feed that ends the line of `at`; length + 1 for the last line.
    character(*), intent(in) :: text
    integer, intent(in) :: at
    line_end = index(text(at:), line_feed)
    line_end = merge(len(text) + 1, at + line_end - 1, line_end == 0)
  end function line_end

end module bw_scene_lexer
