module bw_text_fields
  !! Fields of a table's line, and their kinds. For header lines and the few rows by which the layout is detected; the
  !! other rows are read by bw_text_rows, which is fast.
  use bw_kinds, only: dp, i1
  use bw_number_scan, only: scan_number
  use bw_text, only: lower, string
  implicit none (type, external)
  private
  public :: fields_of, is_missing_word, number_marks

  character, parameter, public :: tab = achar(9)
  character, parameter, public :: blanks = ' '                 !! as a separator: any number of blanks and tabs
  character(*), parameter :: quotes = '"'''

contains

  pure function fields_of(line, separator) result(fields)
    !! Return the fields of a line without surrounding blanks and quotes; a separator in quotes does not count.
    character(*), intent(in) :: line
    character, intent(in) :: separator                         !! `,`, `;`, `tab` or `blanks`
    type(string), allocatable :: fields(:)
    integer :: pass, at, last, n
    do pass = 1, 2                                             ! the first pass counts
      n = 0
      at = 1
      do
        at = at + leading_blanks(line(at:), separator)
        if (at > len(line) .and. separator == blanks) exit
        last = last_of_field(line, at, separator)
        n = n + 1
        if (pass == 2) fields(n)%text = without_quotes(line(at:last))
        at = last + 2
        if (at > len(line) + 1) exit                           ! no separator follows the last field
      end do
      if (pass == 1) allocate (fields(n))
    end do
  end function fields_of

  pure integer function leading_blanks(text, separator) result(count)
    !! Count leading blanks; tabs too, unless they separate.
    character(*), intent(in) :: text
    character, intent(in) :: separator
    if (separator == tab) count = verify(text, ' ') - 1
    if (separator /= tab) count = verify(text, ' '//tab) - 1
    if (count < 0) count = len(text)
  end function leading_blanks

  pure integer function last_of_field(line, first, separator) result(last)
    !! Return the last byte of the field that begins at `first`, before the separator or the end of the line.
    character(*), intent(in) :: line
    integer, intent(in) :: first
    character, intent(in) :: separator
    character :: quote
    logical :: inside
    inside = .false.
    quote = ' '
    do last = first, len(line)
      associate (letter => line(last:last))
        if (inside) then
          inside = letter /= quote
        else if (last == first .and. index(quotes, letter) > 0) then
          quote = letter
          inside = index(line(last + 1:), quote) > 0
        else if (letter == separator .or. (separator == blanks .and. letter == tab)) then
          exit
        end if
      end associate
    end do
    last = last - 1
  end function last_of_field

  pure function without_quotes(text) result(field)
    !! Return the text within quotes, or the text itself, without surrounding blanks.
    character(*), intent(in) :: text
    character(:), allocatable :: field
    integer :: n
    n = verify(text, ' '//tab, back=.true.)
    field = text(:n)
    if (n < 2) return
    if (index(quotes, field(1:1)) > 0 .and. field(n:n) == field(1:1)) field = trim(adjustl(field(2:n - 1)))
  end function without_quotes

  function number_marks(field) result(marks)
    !! Return how a field is a number: '.' with a decimal point, ',' with a decimal comma, '0' with neither; 'x' with a
    !! thousands separator, as in 1,234.5, which cannot be read; '' if it is none.
    character(*), intent(in) :: field
    character(:), allocatable :: marks
    integer(i1) :: bytes(len(field))
    character :: mark
    real(dp) :: value
    integer :: at, decade, i, power
    logical :: good
    marks = ''
    mark = merge(',', '.', index(field, ',') > 0)
    do i = 1, len(field)
      bytes(i) = transfer(field(i:i), 0_i1)
    end do
    at = 1
    call scan_number(bytes, at, len(field), iachar(mark, i1), value, decade, power, good)
    if (parts_thousands(field)) marks = 'x'
    if (.not. good .or. at <= len(field)) return
    marks = '0'
    if (index(field, mark) > 0) marks = mark
  end function number_marks

  pure logical function parts_thousands(field)
    !! Return whether digits are grouped by threes with one mark, and decimals follow another one: 1,234.5 or 1.234,5.
    character(*), intent(in) :: field
    integer :: first, point
    parts_thousands = .false.
    if (verify(field, '+-0123456789.,') > 0) return
    first = scan(field, '.,')
    point = scan(field, '.,', back=.true.)
    if (first < 2 .or. first == point) return
    parts_thousands = field(first:first) /= field(point:point) .and. mod(point - first, 4) == 0
  end function parts_thousands

  pure logical function is_missing_word(field)
    !! Return whether a field marks a missing number: empty, `nan` and the like.
    character(*), intent(in) :: field
    select case (lower(field))
    case ('', 'nan', '-nan', '+nan', 'inf', '+inf', '-inf', 'infinity', 'na', 'n/a', 'null', 'none', '-', '--', '*', '?', &
          '#n/a', '1.#qnan', '-1.#ind', 'missing')
      is_missing_word = .true.
    case default
      is_missing_word = .false.
    end select
  end function is_missing_word

end module bw_text_fields
