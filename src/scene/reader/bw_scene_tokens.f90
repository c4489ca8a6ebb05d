module bw_scene_tokens
  !! Tokens of a scene: spans of its text, with nothing copied.
  use bw_text, only: lower
  implicit none (type, external)
  private
  public :: name_in, span

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

end module bw_scene_tokens
