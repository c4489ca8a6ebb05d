module bw_scene_tokens
  !! What the text of a scene is made of: classes of characters, and tokens, which are spans of it with nothing copied.
  use bw_text, only: lower
  implicit none (type, external)
  private
  public :: ends_word, is_ascii, is_name, is_utf8, lines_up_to, name_in, span, stray_control

  character(*), parameter, public :: line_feed = achar(10)
  character(*), parameter :: tab = achar(9), return = achar(13)
  character(*), parameter, public :: blanks = ' '//tab//return//line_feed
  character(*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'
  character(*), parameter, public :: name_characters = letters//'0123456789_'

  integer, parameter, public :: group_token = 1  !! `&beam`, the span being the name alone
  integer, parameter, public :: end_token = 2    !! `/`
  integer, parameter, public :: equals_token = 3 !! `=`
  integer, parameter, public :: comma_token = 4  !! `,`
  integer, parameter, public :: word_token = 5   !! a name, a number, a logical
  integer, parameter, public :: text_token = 6   !! a text between quotes, the span without them
  integer, parameter, public :: bad_token = 7    !! stands where something was, of which an error was reported
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
    !! The characters of a token.
    character(*), intent(in) :: text
    type(token), intent(in) :: piece
    character(piece%last - piece%first + 1) :: span
    span = text(piece%first:piece%last)
  end function span

  pure function name_in(text, piece) result(name)
    !! The characters of a token in lower case.
    character(*), intent(in) :: text
    type(token), intent(in) :: piece
    character(:), allocatable :: name
    name = lower(text(piece%first:piece%last))
  end function name_in

  pure logical function ends_word(c)
    !! Does this character end a bare word?
    character, intent(in) :: c
    ends_word = index(blanks//',/=!;&''"', c) > 0
  end function ends_word

  pure logical function is_name(text)
    !! A Fortran name: letters, digits and underscores after a letter.
    character(*), intent(in) :: text
    is_name = .false.
    if (len(text) == 0) return
    is_name = verify(text, name_characters) == 0 .and. index(letters, text(1:1)) > 0
  end function is_name

  pure logical function is_ascii(text)
    !! All characters are of seven bits.
    character(*), intent(in) :: text
    integer :: i
    do i = 1, len(text)
      is_ascii = iachar(text(i:i)) < 128
      if (.not. is_ascii) return
    end do
    is_ascii = .true.
  end function is_ascii

  pure integer function stray_control(text) result(at)
    !! First byte that is no text: a control character other than tab and the line ends LF and CR LF;
    !! 0 where there is none. A carriage return alone counts, since editors show it as a line end
    !! where Fortran sees none.
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
    !! Number of the line in which a character stands.
    character(*), intent(in) :: text
    integer, intent(in) :: at
    integer :: i
    lines = 1
    do i = 1, at - 1
      if (text(i:i) == line_feed) lines = lines + 1
    end do
  end function lines_up_to

  pure logical function is_utf8(text)
    !! Every byte above 127 belongs to a well-formed UTF-8 sequence (RFC 3629).
    character(*), intent(in) :: text
    integer :: at, more
    is_utf8 = .false.
    at = 1
    do while (at <= len(text))
      more = continuation_bytes(text(at:min(at + 1, len(text))))
      if (more < 0 .or. at + more > len(text)) return
      if (.not. all_continue(text(at + 1:at + more))) return
      at = at + more + 1
    end do
    is_utf8 = .true.
  end function is_utf8

  pure integer function continuation_bytes(start)
    !! Bytes that follow the first of a UTF-8 sequence; −1 where none can start so. The second byte decides
    !! on overlong forms, surrogates and values beyond U+10FFFF.
    character(*), intent(in) :: start         !! one byte or two
    integer :: first, second
    first = iachar(start(1:1))
    second = iachar(start(len(start):))
    select case (first)
    case (0:127); continuation_bytes = 0
    case (194:223); continuation_bytes = 1
    case (224); continuation_bytes = merge(2, -1, second >= 160)
    case (237); continuation_bytes = merge(2, -1, second < 160)
    case (225:236, 238:239); continuation_bytes = 2
    case (240); continuation_bytes = merge(3, -1, second >= 144)
    case (241:243); continuation_bytes = 3
    case (244); continuation_bytes = merge(3, -1, second < 144)
    case default; continuation_bytes = -1
    end select
  end function continuation_bytes

  pure logical function all_continue(bytes)
    !! Every byte goes on with a UTF-8 sequence: 10xxxxxx.
    character(*), intent(in) :: bytes
    integer :: i
    all_continue = all([(iachar(bytes(i:i)) >= 128 .and. iachar(bytes(i:i)) < 192, i=1, len(bytes))])
  end function all_continue

end module bw_scene_tokens
