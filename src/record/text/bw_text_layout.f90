module bw_text_layout
  !! The layout of a table in a text, found from its first lines: the separator of columns, the decimal mark, the first row,
  !! and the names of the columns.
  !!
  !! Each separator is tried; the one that makes most fields numbers is chosen. Rows have as many fields as most lines with
  !! numbers, and begin at the first such line with numbers wherever most lines have them. The lines before are the header.
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kinds, only: dp
  use bw_probed_lines, only: any_number, is_row, number_columns, numbers_in, probe, probed_line, usual_count
  use bw_record, only: column_type
  use bw_text, only: string, text_of
  use bw_text_fields, only: blanks, number_marks, tab
  use bw_text_header, only: name_columns
  implicit none (type, external)
  private
  public :: find_layout

  integer, parameter, public :: most_probed = 200              !! lines from which the layout is found
  character, parameter :: separators(*) = [tab, ';', ',', blanks]

  type, public :: text_layout
    character :: separator = blanks                            !! one of those above
    character :: mark = '.'                                    !! decimal mark
    logical :: closed = .false.                                !! a separator follows the last field, too
    integer :: header = 0                                      !! lines before the first row
    type(column_type), allocatable :: columns(:)
  end type text_layout

contains

  subroutine find_layout(path, lines, layout, error)
    !! Find the layout. **Errors**: `status_bad_file` if there are no rows of numbers, or the decimal mark is ambiguous.
    character(*), intent(in) :: path
    type(string), intent(in) :: lines(:)                       !! the first lines of the file
    type(text_layout), intent(out) :: layout
    type(error_type), allocatable, intent(inout) :: error
    type(probed_line) :: probed(size(lines))
    integer :: i, n, numbers, most, columns
    character(:), allocatable :: where_text
    real(dp) :: share, largest_share
    most = 0
    largest_share = 0.0_dp
    do i = 1, size(separators)
      call probe_all(lines, separators(i), probed)
      columns = usual_count(probed)
      numbers = numbers_in(probed, number_columns(probed, columns))
      share = real(numbers, dp)/max(1, columns*count([(size(probed(n)%fields) == columns .and. any(probed(n)%numeric), &
                                                   n=1, size(lines))]))
      if (numbers < most .or. (numbers == most .and. share <= largest_share)) cycle
      most = numbers
      largest_share = share
      layout%separator = separators(i)
    end do
    if (most == 0) then
      where_text = ''
      if (size(lines) > 0) where_text = ' in its first '//text_of(size(lines))//' lines'
      call fail(error, status_bad_file, path//': has no rows of numbers'//where_text// &
                '; accepted: columns of numbers separated by commas, semicolons, tabs or blanks, or NetCDF '// &
                '(beamwave-record converts the texts of loggers and UFF 58, .mat, .npy and .wav files)')
      return
    end if
    call probe_all(lines, layout%separator, probed)
    call choose_columns(path, lines, probed, layout, error)
  end subroutine find_layout

  subroutine probe_all(lines, separator, probed)
    !! Split lines at a separator.
    type(string), intent(in) :: lines(:)
    character, intent(in) :: separator
    type(probed_line), intent(inout) :: probed(:)
    integer :: n
    do n = 1, size(lines)
      call probe(lines(n)%text, separator, probed(n))
    end do
  end subroutine probe_all

  subroutine choose_columns(path, lines, probed, layout, error)
    !! Find the first row, the decimal mark and the columns, given the separator.
    character(*), intent(in) :: path
    type(string), intent(in) :: lines(:)
    type(probed_line), intent(in) :: probed(:)                 !! split at that separator
    type(text_layout), intent(inout) :: layout
    type(error_type), allocatable, intent(inout) :: error
    logical, allocatable :: numeric(:)                         !! columns of numbers
    integer :: columns, i
    columns = usual_count(probed)
    numeric = number_columns(probed, columns)
    layout%header = first_row(probed, numeric) - 1
    if (layout%header < size(probed) - 1) then
      if (counts_columns(probed(:layout%header + 2), numeric)) layout%header = layout%header + 1
    end if
    associate (row => probed(layout%header + 1)%fields)
      layout%closed = columns > 1 .and. layout%separator /= blanks .and. row(columns)%text == '' &
        .and. .not. any_number(probed, columns)
    end associate
    if (layout%closed) columns = columns - 1
    allocate (layout%columns(columns))
    do i = 1, columns
      layout%columns(i)%name = ''
      layout%columns(i)%unit = ''
      layout%columns(i)%is_numeric = numeric(i)
    end do
    call name_columns(lines(:layout%header), layout%separator, layout%closed, layout%columns)
    call find_mark(path, probed(layout%header + 1:), layout, error)
  end subroutine choose_columns

  pure integer function first_row(probed, numeric) result(n)
    !! Return the first row; if every line has a word among its numbers, the first with a number, which is rejected when read. A
    !! line below the names that begins with a number is a row, too: a logger writes a word for a value out of range.
    type(probed_line), intent(in) :: probed(:)
    logical, intent(in) :: numeric(:)                          !! columns of numbers
    integer :: row, line
    do row = 1, size(probed)
      if (.not. is_row(probed(row), numeric)) cycle
      n = row
      do line = row - 1, 1, -1
        if (size(probed(line)%fields) /= size(numeric)) return
        if (.not. any(probed(line)%numeric)) n = line + 1      ! below names, or their units
        if (.not. probed(line)%numeric(1)) return
      end do
      return
    end do
    do n = 1, size(probed) - 1
      if (size(probed(n)%fields) == size(numeric) .and. any(probed(n)%numeric)) return
    end do
  end function first_row

  logical function counts_columns(probed, numeric) result(counts)
    !! Return whether the last line but one has the numbers of the columns for names, as `0,1,2` or `,0,1`: consecutive whole
    !! numbers, above a row with decimals and below no names.
    type(probed_line), intent(in) :: probed(:)
    logical, intent(in) :: numeric(:)                          !! columns of numbers
    character :: mark
    logical :: decimals
    integer :: n, i, first
    counts = .false.
    n = size(probed)
    if (.not. is_row(probed(n), numeric)) return
    do i = 1, n - 2
      if (size(probed(i)%fields) == size(numeric)) return
    end do
    decimals = .false.
    do i = 1, size(numeric)
      mark = number_marks(probed(n)%fields(i)%text)
      decimals = decimals .or. mark == '.' .or. mark == ','
    end do
    if (.not. decimals) return
    associate (fields => probed(n - 1)%fields)
      first = merge(2, 1, fields(1)%text == '')
      if (size(numeric) < 3 .or. verify(fields(first)%text, '01') > 0) return
      do i = first, size(numeric)
        if (fields(i)%text == '' .and. i == size(numeric)) cycle   ! after a separator that ends the line
        if (fields(i)%text /= text_of(i - first + index('1', fields(first)%text))) return
      end do
    end associate
    counts = .true.
  end function counts_columns

  subroutine find_mark(path, rows, layout, error)
    !! Find whether the decimal mark is a point or a comma. **Errors**: `status_bad_file` if both occur, if all commas may
    !! separate thousands, or if `0,025` may have been split into two columns.
    character(*), intent(in) :: path
    type(probed_line), intent(in) :: rows(:)
    type(text_layout), intent(inout) :: layout
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: marks
    logical :: points, commas, certain, decimals
    integer :: n, i
    points = .false.
    commas = .false.
    decimals = .false.
    certain = .false.
    do n = 1, size(rows)
      do i = 1, min(size(rows(n)%fields), size(layout%columns))
        marks = number_marks(rows(n)%fields(i)%text)
        points = points .or. marks == '.'
        if (marks == '0') decimals = decimals .or. begins_with_zeros(rows(n)%fields(i)%text)
        if (marks /= ',') cycle                    ! in a table with commas, such a number is in quotes
        commas = .true.
        certain = certain .or. .not. parts_thousands(rows(n)%fields(i)%text)
      end do
    end do
    if (layout%separator == ',' .and. decimals .and. .not. (points .or. commas)) call fail(error, status_bad_file, path// &
      ': its commas are decimal marks, or separate integers with leading zeros; accepted: decimal points, or semicolons '// &
      'between columns')
    if (.not. commas) return
    layout%mark = ','
    if (points) then
      call fail(error, status_bad_file, path//': mixes decimal points and decimal commas; accepted: one decimal mark')
    else if (.not. certain) then
      call fail(error, status_bad_file, path//': its commas may be decimal marks or separate thousands; '// &
                'accepted: decimal points')
    end if
  end subroutine find_mark

  pure logical function begins_with_zeros(field)
    !! Recognise `025`: digits with a leading zero.
    character(*), intent(in) :: field
    begins_with_zeros = len(field) > 1 .and. verify(field, '0123456789') == 0 .and. field(1:1) == '0'
  end function begins_with_zeros

  pure logical function parts_thousands(field)
    !! Recognise `12,345`: the comma may separate thousands.
    character(*), intent(in) :: field
    integer :: comma, first
    first = max(1, verify(field, '+-'))
    comma = index(field, ',')
    parts_thousands = comma - first >= 1 .and. comma - first <= 3 .and. len(field) == comma + 3 .and. field(first:first) /= '0'
    if (parts_thousands) parts_thousands = verify(field(comma + 1:), '0123456789') == 0
  end function parts_thousands

end module bw_text_layout
