module bw_scene_tokens
  !! The elements of the text of a scene: classes of characters, and tokens, which are spans of the text without copies.
  use bw_text, only: lower, read_letter
  implicit none (type, external)
  private
  public :: ends_word, is_ascii, is_name, is_utf8, lines_up_to, name_in, span, stray_control

  character(*), parameter, public :: line_feed = achar(10)
  character(*), parameter :: tab = achar(9), return = achar(13)
  character(*), parameter, public :: blanks = ' '//tab//return//line_feed
  character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
  character(*), parameter, public :: name_characters = letters//'0123456789_'

  integer, parameter, public :: group_token = 1  !! `&beam`; the span is the name alone
  integer, parameter, public :: end_token = 2    !! `/`
  integer, parameter, public :: equals_token = 3 !! `=`
  integer, parameter, public :: comma_token = 4  !! `,`
  integer, parameter, public :: word_token = 5   !! a name, a number, a logical
  integer, parameter, public :: text_token = 6   !! a text between quotes; the span excludes them
  integer, parameter, public :: bad_token = 7    !! replaces something whose error was reported
  integer, parameter, public :: bad_group_token = 8 !! likewise, for the opening of a group

  type, public :: token
    integer :: kind = bad_token
    integer :: first = 1, last = 0               !! span in the text
    integer :: line = 0
    logical :: glued = .false.                   !! follows the token before it without a blank
    character :: quote = ' '                     !! of a text
  end type token

contains

  pure function span(text, piece)
    !! Return the characters of a token.
    character(*), intent(in) :: text
    type(token), intent(in) :: piece
    character(piece%last - piece%first + 1) :: span
    span = text(piece%first:piece%last)
  end function span

  pure function name_in(text, piece) result(name)
    !! Return the characters of a token in lower case.
    character(*), intent(in) :: text
    type(token), intent(in) :: piece
    character(:), allocatable :: name
    name = lower(text(piece%first:piece%last))
  end function name_in

  pure logical function ends_word(c)
    !! Return whether this character ends a bare word.
    character, intent(in) :: c
    ends_word = index(blanks//',/=!;&''"', c) > 0
  end function ends_word

  pure logical function is_name(text)
    !! Return whether a text is a Fortran name: a letter, then letters, digits and underscores.
    character(*), intent(in) :: text
    is_name = .false.
    if (len(text) == 0) return
    is_name = verify(text, name_characters) == 0 .and. index(letters, text(1:1)) > 0
  end function is_name

  pure logical function is_ascii(text)
    !! Return whether all characters have seven bits.
    character(*), intent(in) :: text
    integer :: i
    is_ascii = all([(iachar(text(i:i)) < 128, i=1, len(text))])
  end function is_ascii

  pure integer function stray_control(text) result(at)
    !! Return the first byte that is not text: a control character other than tab and the line ends LF and CR LF; 0 for none.
    !! A carriage return alone counts, since editors show it as a line end and Fortran does not.
    character(*), intent(in) :: text
    do at = 1, len(text)
      select case (iachar(text(at:at)))
      case (9, 10)
        cycle
      case (13)
        if (at == len(text)) cycle
        if (text(at + 1:at + 1) /= line_feed) return
      case (0:8, 11:12, 14:31, 127)
        return
      case default
        cycle
      end select
    end do
    at = 0
  end function stray_control

  pure integer function lines_up_to(text, at) result(lines)
    !! Return the number of the line that holds a character.
    character(*), intent(in) :: text
    integer, intent(in) :: at
    integer :: i
    lines = 1
    do i = 1, at - 1
      if (text(i:i) == line_feed) lines = lines + 1
    end do
  end function lines_up_to

  pure logical function is_utf8(text)
    !! Return whether every byte above 127 belongs to a well-formed UTF-8 sequence (RFC 3629).
    character(*), intent(in) :: text
    integer :: at, letter, length
    logical :: plain
    is_utf8 = .true.
    at = 1
    do while (at <= len(text) .and. is_utf8)
      call read_letter(text(at:min(at + 3, len(text))), length, plain, letter)
      is_utf8 = length > 1 .or. letter < 128
      at = at + length
    end do
  end function is_utf8

end module bw_scene_tokens
