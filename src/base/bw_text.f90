module bw_text
  !! Numbers as text, and composition and decomposition of texts.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_kinds, only: dp, qp, i8
  implicit none (type, external)
  private
  public :: append, fitted, joined, lines_of, lower, percent, printable, read_letter, replaced, shortened, shortest, string, &
    text_of, words_of

  type :: string
    !! A text of any length, for arrays of texts of different lengths.
    character(:), allocatable :: text
  end type string

  type, public :: text_builder
    !! A text that grows piece by piece in time proportional to its length.
    private
    character(:), allocatable :: buffer
    integer :: used = 0
  contains
    procedure :: append => append_piece
    procedure :: append_line
    procedure :: length => length_built
    procedure :: text => text_built
  end type text_builder

  interface text_of
    !! Return a number as the shortest text that reads back to the same bits.
    module procedure :: text_of_integer, text_of_long, text_of_real
  end interface text_of

contains

  pure function text_of_integer(value) result(text)
    !! Return an integer with digits and sign, without blanks.
    integer, intent(in) :: value
    character(:), allocatable :: text
    text = text_of_long(int(value, i8))
  end function text_of_integer

  pure function text_of_long(value) result(text)
    !! Return a long integer likewise.
    integer(i8), intent(in) :: value
    character(:), allocatable :: text
    character(24) :: buffer
    write (buffer, '(i0)') value
    text = trim(buffer)
  end function text_of_long

  pure function text_of_real(value) result(text)
    !! Return the shortest text of up to 17 digits that reads back to the same binary64 number.
    real(dp), intent(in) :: value
    character(:), allocatable :: text
    integer :: digits
    ! with up to 15 digits any number in the normal range reads back, and trailing zeros are dropped
    do digits = merge(1, 15, abs(value) < tiny(value)), 17
      text = shortest(value, digits)
      if (.not. ieee_is_finite(value)) return
      if (reads_back(text, value)) return
    end do
  end function text_of_real

  pure logical function reads_back(text, value)
    !! Return whether a text reads back; it is read in a wider range first, as digits rounded up may overflow.
    character(*), intent(in) :: text
    real(dp), intent(in) :: value           !! finite
    real(dp) :: again
    real(qp) :: wide
    integer :: stat
    reads_back = .false.
    read (text, *, iostat=stat) wide
    if (stat /= 0) return
    if (abs(wide) > huge(value)) return
    read (text, *, iostat=stat) again
    if (stat == 0) reads_back = again == value
  end function reads_back

  pure function shortest(value, digits) result(text)
    !! Return a real with that many significant digits, in plain notation if short (0.2, 50, 1.25e-7).
    real(dp), intent(in) :: value
    integer, intent(in) :: digits           !! significant digits, 1 … 17
    character(:), allocatable :: text
    character(40) :: buffer, form
    integer :: exponent, mark
    character(:), allocatable :: mantissa
    if (value == 0.0_dp) then
      text = '0'
      return
    end if
    write (form, '(a,i0,a)') '(es40.', digits - 1, 'e4)'
    write (buffer, form) value
    buffer = adjustl(buffer)
    mark = scan(buffer, 'E')
    if (mark == 0) then                     ! Infinity, NaN
      text = trim(buffer)
      return
    end if
    read (buffer(mark + 1:), *) exponent
    mantissa = strip_zeros(buffer(:mark - 1))
    if (exponent >= -3 .and. exponent < 7) then
      text = plain(mantissa, exponent)
    else
      text = mantissa//'e'//text_of_integer(exponent)
    end if
  end function shortest

  pure function strip_zeros(mantissa) result(text)
    !! Remove trailing zeros: `1.2500` → `1.25`, `1.000` → `1`.
    character(*), intent(in) :: mantissa
    character(:), allocatable :: text
    integer :: last
    last = len_trim(mantissa)
    if (index(mantissa, '.') > 0) last = verify(mantissa(:last), '0', back=.true.)
    if (mantissa(last:last) == '.') last = last - 1
    text = mantissa(:last)
  end function strip_zeros

  pure function plain(mantissa, exponent) result(text)
    !! Shift the point of `d.ddd` by `exponent` places, without changing a digit.
    character(*), intent(in) :: mantissa
    integer, intent(in) :: exponent
    character(:), allocatable :: text
    character(:), allocatable :: digits, sign
    sign = mantissa(:index(mantissa(1:1), '-'))
    digits = mantissa(len(sign) + 1:len(sign) + 1)//mantissa(len(sign) + 3:)
    if (exponent < 0) then
      text = sign//'0.'//repeat('0', -exponent - 1)//digits
    else if (len(digits) <= exponent + 1) then
      text = sign//digits//repeat('0', exponent + 1 - len(digits))
    else
      text = sign//digits(:exponent + 1)//'.'//digits(exponent + 2:)
    end if
  end function plain

  pure function percent(change) result(text)
    !! Return a relative change in per cent without its unit, with two digits and a sign: `+2.5`, `-0.13`.
    real(dp), intent(in) :: change
    character(:), allocatable :: text
    text = shortest(100.0_dp*change, 2)
    if (change > 0.0_dp) text = '+'//text
  end function percent

  pure subroutine append(list, text)
    !! Append a text to a list. (gfortran 12 corrupts the heap on `[list, string(text)]`.)
    type(string), allocatable, intent(inout) :: list(:)    !! unallocated: empty
    character(*), intent(in) :: text
    type(string), allocatable :: longer(:)
    integer :: i, n
    n = 0
    if (allocated(list)) n = size(list)
    allocate (longer(n + 1))
    do i = 1, n
      call move_alloc(list(i)%text, longer(i)%text)
    end do
    longer(n + 1)%text = text
    call move_alloc(longer, list)
  end subroutine append

  pure function joined(words, before) result(text)
    !! Join words with single spaces.
    character(*), intent(in) :: words(:)
    character(*), intent(in), optional :: before      !! prefix of each word; absent: none
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(words)
      if (i > 1) text = text//' '
      if (present(before)) text = text//before
      text = text//trim(words(i))
    end do
  end function joined

  pure function lines_of(text, separator) result(lines)
    !! Split a text into lines, without their ends; the last may lack its end. An empty text has none.
    character(*), intent(in) :: text
    character, intent(in), optional :: separator      !! line separator; absent: the line end
    type(string), allocatable :: lines(:)
    character :: ending
    integer :: first, last
    ending = new_line('a')
    if (present(separator)) ending = separator
    allocate (lines(0))
    first = 1
    do while (first <= len(text))
      last = index(text(first:), ending)
      last = merge(len(text), first + last - 2, last == 0)
      call append(lines, text(first:last))
      first = last + 2
    end do
  end function lines_of

  pure function words_of(text) result(words)
    !! Split a list of words at single blanks.
    character(*), intent(in) :: text
    type(string), allocatable :: words(:)
    words = lines_of(trim(text), ' ')
  end function words_of

  pure function replaced(text, mark, by) result(edited)
    !! Replace each mark in a text.
    character(*), intent(in) :: text
    character, intent(in) :: mark
    character(*), intent(in) :: by
    character(:), allocatable :: edited
    type(string), allocatable :: parts(:)
    integer :: i
    parts = lines_of(text//mark, mark)
    edited = ''
    do i = 1, size(parts)
      if (i > 1) edited = edited//by
      edited = edited//parts(i)%text
    end do
  end function replaced

  pure function lower(text) result(lowered)
    !! Convert ASCII letters to lower case.
    character(*), intent(in) :: text
    character(len(text)) :: lowered
    integer :: i
    do i = 1, len(text)
      lowered(i:i) = text(i:i)
      if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') lowered(i:i) = achar(iachar(text(i:i)) + 32)
    end do
  end function lower

  pure function shortened(text) result(piece)
    !! Return at most the first 80 bytes of a user's text, for a message, without splitting a UTF-8 letter.
    character(*), intent(in) :: text
    character(:), allocatable :: piece
    integer, parameter :: most = 80
    integer :: last
    last = min(len(text), most)
    if (last < len(text)) then
      do while (last > 0)
        if (iand(iachar(text(last + 1:last + 1)), 192) /= 128) exit       ! the next byte begins a letter
        last = last - 1
      end do
    end if
    piece = text(:last)
    if (last < len(text)) piece = piece//'...'
  end function shortened

  pure function printable(text, on_one_line) result(shown)
    !! Make a text safe for a terminal: bytes that control it, hide or reorder letters, or are not UTF-8 become `\x1b`
    !! and the like. Line ends and tabs stay.
    character(*), intent(in) :: text
    logical, intent(in), optional :: on_one_line      !! line ends are `\x0a`; absent: they stay
    character(:), allocatable :: shown
    character(*), parameter :: digits = '0123456789abcdef'
    type(text_builder) :: builder
    integer :: i, b, j, length
    logical :: plain
    i = 1
    do while (i <= len(text))
      call read_letter(text(i:min(len(text), i + 3)), length, plain)
      if (present(on_one_line)) plain = plain .and. .not. (on_one_line .and. text(i:i) == new_line('a'))
      if (plain) call builder%append(text(i:i + length - 1))
      do j = i, merge(i - 1, i + length - 1, plain)
        b = iachar(text(j:j))
        call builder%append('\x'//digits(b/16 + 1:b/16 + 1)//digits(mod(b, 16) + 1:mod(b, 16) + 1))
      end do
      i = i + length
    end do
    shown = builder%text()
  end function printable

  pure subroutine read_letter(text, length, plain, letter)
    !! Read the first UTF-8 letter of a text: its bytes, and whether it is printable. An invalid byte counts as a letter
    !! that is not.
    character(*), intent(in) :: text                  !! at least one byte
    integer, intent(out) :: length
    logical, intent(out) :: plain
    integer, intent(out), optional :: letter          !! its code; the byte itself if invalid
    integer, parameter :: least(4) = [0, int(z'80'), int(z'800'), int(z'10000')]      !! least code of 1, 2, 3 and 4 bytes
    integer, parameter :: invisible(2, 9) = reshape([ & ! first and last code: controls, then invisible format characters
      0, 8, 10 + 1, 31, 127, int(z'9F'), int(z'61C'), int(z'61C'), int(z'200B'), int(z'200F'), int(z'2028'), int(z'202E'), &
      int(z'2060'), int(z'206F'), int(z'FEFF'), int(z'FEFF'), int(z'E0000'), int(z'E0FFF')], [2, 9])
    integer :: code, i, byte
    length = 1
    code = iachar(text(1:1))
    if (code >= 240) length = 4
    if (code >= 224 .and. code < 240) length = 3
    if (code >= 192 .and. code < 224) length = 2
    plain = .not. (code >= 128 .and. code < 192) .and. code < 248 .and. length <= len(text)
    if (length > 1) code = iand(code, 2**(7 - length) - 1)
    do i = 2, length
      if (.not. plain) exit
      byte = iachar(text(i:i))
      plain = iand(byte, 192) == 128
      code = 64*code + iand(byte, 63)
    end do
    if (plain) plain = code >= least(length) .and. code <= int(z'10FFFF') .and. (code < int(z'D800') .or. code > int(z'DFFF'))
    if (.not. plain) length = 1
    if (.not. plain) code = iachar(text(1:1))
    if (present(letter)) letter = code
    if (plain) plain = .not. any(code >= invisible(1, :) .and. code <= invisible(2, :))
  end subroutine read_letter

  pure function fitted(text, room) result(letters)
    !! Fit a text into so many bytes: pad a shorter one with zeros, cut a longer one and append '…', without splitting a
    !! UTF-8 letter.
    character(*), intent(in) :: text
    integer, intent(in) :: room
    character(room) :: letters
    character(*), parameter :: more = '…'
    integer :: last
    if (len(text) <= room) then
      letters = text//repeat(achar(0), room - len(text))
      return
    end if
    last = max(0, room - len(more))
    do while (last > 0)
      if (iand(iachar(text(last + 1:last + 1)), 192) /= 128) exit         ! the next byte begins a letter
      last = last - 1
    end do
    letters = text(:last)//more//repeat(achar(0), room)
  end function fitted

  pure subroutine append_piece(self, piece)
    !! Append a piece to the text.
    class(text_builder), intent(inout) :: self
    character(*), intent(in) :: piece
    character(:), allocatable :: wider
    if (.not. allocated(self%buffer)) allocate (character(1024) :: self%buffer)
    if (self%used + len(piece) > len(self%buffer)) then
      allocate (character(2*(self%used + len(piece))) :: wider)
      wider(:self%used) = self%buffer(:self%used)
      call move_alloc(wider, self%buffer)
    end if
    self%buffer(self%used + 1:self%used + len(piece)) = piece
    self%used = self%used + len(piece)
  end subroutine append_piece

  pure subroutine append_line(self, piece)
    !! Append a piece and a line end.
    class(text_builder), intent(inout) :: self
    character(*), intent(in) :: piece
    call self%append(piece)
    call self%append(new_line('a'))
  end subroutine append_line

  pure integer function length_built(self) result(length)
    !! Return the length of the text.
    class(text_builder), intent(in) :: self
    length = self%used
  end function length_built

  pure function text_built(self) result(text)
    !! Return the text.
    class(text_builder), intent(in) :: self
    character(:), allocatable :: text
    text = ''
    if (allocated(self%buffer)) text = self%buffer(:self%used)
  end function text_built

end module bw_text
