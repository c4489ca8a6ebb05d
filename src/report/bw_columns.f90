module bw_columns
  !! Tables of printed reports, and formats of numbers in them.
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_screen, only: detail_mark, row_mark
  use bw_text, only: lines_of, shortest, string, text_builder, text_of
  implicit none (type, external)
  private
  public :: fixed, note_rest, pair_cells, right, seconds_text, short, table_of, to_its_error, to_width, wrapped

  character, parameter :: mark = '|'                !! between the cells of a row
  integer, parameter, public :: most_rows = 40      !! of a list, whatever its length
  integer, parameter, public :: text_width = 110    !! letters of a line of words

  type, public :: text_table
    !! Columns with a name and a unit each. Text is right-aligned, or left-aligned if the width is negative; a last
    !! column of width 0 holds text of any length after three blanks.
    private
    character(:), allocatable :: names, units
    integer, allocatable :: widths(:)
    logical, allocatable :: shown(:)
    logical :: is_list = .true.
  contains
    procedure :: put_head, put_row, put_numbers
    procedure, private :: line_of
  end type text_table

contains

  pure function wrapped(text, width, hang) result(lines)
    !! Wrap a text at blanks to at most `width` letters; a longer word is not split.
    character(*), intent(in) :: text
    integer, intent(in) :: width
    integer, intent(in) :: hang                   !! blanks before each line but the first
    character(:), allocatable :: lines
    integer :: first, blank, room
    lines = ''
    first = 1
    room = width
    do while (len(text) - first >= room)
      blank = index(text(first:first + room), ' ', back=.true.)
      if (blank == 0) blank = index(text(first:), ' ')
      if (blank == 0) exit
      lines = lines//text(first:first + blank - 2)//new_line('a')//repeat(' ', hang)
      first = first + blank
      room = width - hang
    end do
    lines = lines//text(first:)
  end function wrapped

  pure function seconds_text(seconds) result(text)
    !! Format seconds: whole ms below a second, else three digits.
    real(dp), intent(in) :: seconds
    character(:), allocatable :: text
    if (seconds < 1.0_dp) then
      text = text_of(nint(1000.0_dp*seconds))//' ms'
    else
      text = shortest(seconds, 3)//' s'
    end if
  end function seconds_text

  pure function fixed(value) result(text)
    !! Format a number with seven digits, aligned at the point if possible; five digits if very large or small; a dash
    !! if missing.
    real(dp), intent(in) :: value
    character(:), allocatable :: text
    character(20) :: buffer
    text = '-'
    if (is_missing(value)) return
    if (value == 0.0_dp) then
      text = '0'
    else if (abs(value) >= 1.0e-3_dp .and. abs(value) < 1.0e6_dp) then
      write (buffer, '(f20.'//text_of(max(0, 6 - floor(log10(abs(value)))))//')') value
      text = trim(adjustl(buffer))
    else
      text = shortest(value, 5)
    end if
  end function fixed

  pure function right(text, width) result(field)
    !! Right-align a text; the field grows if the text is longer.
    character(*), intent(in) :: text
    integer, intent(in) :: width
    character(:), allocatable :: field
    field = repeat(' ', max(1, width - len(text)))//text
  end function right

  pure type(text_table) function table_of(names, units, widths, shown, is_list) result(table)
    !! Define a table by its columns.
    character(*), intent(in) :: names, units      !! of all columns, `|` between them; no units: they have no line
    integer, intent(in) :: widths(:)
    logical, intent(in), optional :: shown(:)     !! visible columns; absent: all
    logical, intent(in), optional :: is_list      !! rows are of one kind, so that the first stand for all; absent: they are
    table%names = names
    table%units = units
    table%widths = widths
    allocate (table%shown(size(widths)), source=.true.)
    if (present(shown)) table%shown = shown
    if (present(is_list)) table%is_list = is_list
  end function table_of

  subroutine put_head(self, lines)
    !! Print the lines of names and units.
    class(text_table), intent(in) :: self
    type(text_builder), intent(inout) :: lines
    call lines%append_line(self%line_of(self%names))
    if (self%units /= '') call lines%append_line(self%line_of(self%units))
  end subroutine put_head

  subroutine put_row(self, lines, cells, remark, detail)
    !! Print the line of a row.
    class(text_table), intent(in) :: self
    type(text_builder), intent(inout) :: lines
    character(*), intent(in) :: cells             !! of all columns, `|` between them; the last ones may be left out
    character(*), intent(in), optional :: remark  !! any text after the cells
    logical, intent(in), optional :: detail       !! the row is a detail; absent: it is none
    character(:), allocatable :: line, kind
    line = self%line_of(cells)
    if (present(remark)) line = trim(line//remark)
    kind = ''
    if (self%is_list) kind = row_mark
    if (present(detail)) then
      if (detail) kind = detail_mark
    end if
    call lines%append_line(line//kind)
  end subroutine put_row

  pure function line_of(self, cells) result(line)
    !! Align cells in their columns, without trailing blanks.
    class(text_table), intent(in) :: self
    character(*), intent(in) :: cells
    character(:), allocatable :: line
    type(string), allocatable :: words(:)
    type(text_builder) :: built
    integer :: c
    words = lines_of(cells, mark)
    do c = 1, size(words)
      if (.not. self%shown(c)) cycle
      if (self%widths(c) > 0) then
        call built%append(right(words(c)%text, self%widths(c)))
      else if (self%widths(c) < 0) then
        call built%append(words(c)%text//repeat(' ', max(1, -self%widths(c) - len(words(c)%text))))
      else
        call built%append('   '//words(c)%text)
      end if
    end do
    line = trim(built%text())
  end function line_of

  subroutine put_numbers(self, lines, most, columns, rounded, count)
    !! Print the head and numbered rows; those beyond `most` are details.
    class(text_table), intent(in) :: self
    type(text_builder), intent(inout) :: lines
    integer, intent(in) :: most
    real(dp), intent(in) :: columns(:, :)         !! (rows, columns)
    integer, intent(in), optional :: rounded      !! a column of errors, of which two digits are enough
    integer, intent(in), optional :: count        !! number of rows; absent: the length of the columns
    character(:), allocatable :: cells
    integer :: k, c, errors, rows
    rows = size(columns, 1)
    if (present(count)) rows = count
    errors = 0
    if (present(rounded)) errors = rounded
    call self%put_head(lines)
    do k = 1, min(most_rows, size(columns, 1))
      cells = text_of(k)
      do c = 1, size(columns, 2)
        if (c == errors) cells = cells//mark//shortest(columns(k, c), 2)
        if (c /= errors) cells = cells//mark//fixed(columns(k, c))
      end do
      call self%put_row(lines, cells, detail=k > most)
    end do
    call note_rest(lines, rows, min(most_rows, size(columns, 1)))
  end subroutine put_numbers

  subroutine note_rest(lines, count, most)
    !! Print the number of rows, if not all are shown.
    type(text_builder), intent(inout) :: lines
    integer, intent(in) :: count, most
    if (count > most) call lines%append_line('   ...  '//text_of(count)//' in the file')
  end subroutine note_rest

  pure function short(value, digits) result(text)
    !! Format a number with few digits; a dash if it is missing.
    real(dp), intent(in) :: value
    integer, intent(in), optional :: digits       !! absent: two, as of an error
    character(:), allocatable :: text
    text = '-'
    if (is_missing(value)) return
    text = shortest(value, 2)
    if (present(digits)) text = shortest(value, digits)
  end function short

  pure function pair_cells(value, error) result(cells)
    !! Format a number and half its interval; dashes if missing.
    real(dp), intent(in) :: value, error
    character(:), allocatable :: cells
    cells = '-|-'
    if (.not. is_missing(value)) cells = to_its_error(value, error)//mark//short(error)
  end function pair_cells

  pure function to_its_error(value, error) result(text)
    !! Format a number with the digits justified by its error, of which two digits count.
    real(dp), intent(in) :: value, error
    character(:), allocatable :: text
    character(40) :: buffer
    integer :: digits
    digits = 15
    if (is_missing(error)) then
      text = shortest(value, 4)
      return
    end if
    if (error > 0) digits = 1 - floor(log10(error))
    if (digits > 12 .or. abs(value) >= 1.0e9_dp) then
      text = shortest(value, 15)
    else
      write (buffer, '(f40.'//text_of(max(0, digits))//')') value
      text = trim(adjustl(buffer))
      if (text(1:1) == '.') text = '0'//text
      if (text(len(text):) == '.') text = text(:len(text) - 1)
      if (index(text, '-.') == 1) text = '-0'//text(2:)
    end if
  end function to_its_error

  pure function to_width(value, width) result(text)
    !! Format a number with the digits justified by the width of its interval, at least two; a dash if missing.
    real(dp), intent(in) :: value, width
    character(:), allocatable :: text
    integer :: digits
    text = '-'
    if (is_missing(value)) return
    digits = 15
    if (width > 0.0_dp .and. abs(value) > 0.0_dp) digits = 3 + floor(log10(abs(value))) - floor(log10(width))
    text = shortest(value, max(2, min(15, digits)))
  end function to_width
end module bw_columns
