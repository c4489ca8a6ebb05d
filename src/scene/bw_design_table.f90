module bw_design_table
  !! Read the table of a `&design`: column names and numbers, with every faulty cell reported by its line.
  use bw_error, only: error_type
  use bw_kinds, only: dp, i1
  use bw_line_reader, only: line_reader, text_between
  use bw_missing, only: missing
  use bw_scene_messages, only: message_list, shown
  use bw_table_row, only: row_form, says_nothing, scan_row
  use bw_text, only: lower, string, text_of
  use bw_text_fields, only: blanks, fields_of, is_missing_word, number_marks, tab
  implicit none (type, external)
  private
  public :: read_design_table

  integer, parameter :: most_rows = 1000000
  character, parameter :: separators(*) = [tab, ';', ','] !! the first one in the header line applies; else blanks

  type, public :: design_table
    type(string), allocatable :: names(:)      !! in lower case, (columns)
    integer :: line = 0                        !! line of the header; 0: there is none
    integer, allocatable :: lines(:)           !! line of each row, (rows)
    real(dp), allocatable :: numbers(:, :)     !! `missing` in a faulty cell, (columns, rows)
  end type design_table

contains

  subroutine read_design_table(path, line, table, messages, error)
    !! Read a table from front to back. Every cell that is no number is reported, with its place `path:LINE`.
    !! **Errors**: `status_bad_file` if the table cannot be read.
    character(*), intent(in) :: path
    integer, intent(in) :: line                !! of the scene, which names the table
    type(design_table), intent(out) :: table
    type(message_list), intent(inout) :: messages
    type(error_type), allocatable, intent(inout) :: error
    type(line_reader) :: reader
    type(row_form) :: form
    logical :: there
    integer :: rows
    rows = 0
    allocate (table%names(0), table%lines(0), table%numbers(0, 0))
    call reader%open(path, error)
    do while (.not. (allocated(error) .or. messages%cut))
      call reader%next_line(there, error)
      if (.not. there) exit
      if (says_nothing(reader%bytes, reader%first, reader%last)) cycle
      call messages%enter_row(path, int(reader%line), line)
      if (table%line == 0) then
        call read_names(text_between(reader%bytes, reader%first, reader%last), form, table, messages)
        table%line = int(reader%line)
        if (size(table%names) == 0) exit
        call grow(table)
      else if (rows == most_rows) then
        call messages%add(line, 'row '//text_of(rows + 1), 'is one too many; accepted: at most '//text_of(most_rows)//' rows')
        exit
      else
        rows = rows + 1
        call read_row(reader, form, rows, table, messages)
      end if
    end do
    call reader%close()
    call messages%enter_row(path, 0, line)
    if (.not. allocated(error) .and. rows == 0 .and. (table%line == 0 .or. size(table%names) > 0)) call messages%add(line, 'text', &
      'holds no rows; accepted: a line of names as group%name, then a line of numbers for each case')
    call messages%leave_row()
    table%lines = table%lines(:rows)
    table%numbers = table%numbers(:, :rows)
  end subroutine read_design_table

  subroutine read_names(text, form, table, messages)
    !! Read the header line: the separator and the column names. A line that is not text is reported and gives no names.
    character(*), intent(in) :: text
    type(row_form), intent(out) :: form
    type(design_table), intent(inout) :: table
    type(message_list), intent(inout) :: messages
    character :: separator
    integer :: i
    separator = blanks
    do i = size(separators), 1, -1
      if (index(text, separators(i)) > 0) separator = separators(i)
    end do
    if (any([(iachar(text(i:i)) < 32 .and. text(i:i) /= tab, i=1, len(text))])) then
      call messages%add(messages%table_line, 'text', 'is binary, or its lines do not end with LF or CR LF; accepted: a table '// &
                        'as text in UTF-8, as "CSV UTF-8" of spreadsheets')
      return
    end if
    table%names = fields_of(text, separator)
    do i = 1, size(table%names)
      table%names(i)%text = lower(table%names(i)%text)
    end do
    form = row_form(iachar(separator, i1), blank=separator == blanks, columns=size(table%names))
    form%slot = [(i, i=1, size(table%names))]
  end subroutine read_names

  subroutine read_row(reader, form, row, table, messages)
    !! Read the current line of the reader as a row.
    type(line_reader), intent(in) :: reader
    type(row_form), intent(in) :: form
    integer, intent(in) :: row
    type(design_table), intent(inout) :: table
    type(message_list), intent(inout) :: messages
    real(dp) :: numbers(form%columns)
    integer :: decades(form%columns)
    logical :: good
    if (row > size(table%lines)) call grow(table)
    call scan_row(form, reader%bytes, reader%first, reader%last, numbers, decades, good)
    if (.not. good) then
      numbers = missing
      call refuse_row(table%names, fields_of(text_between(reader%bytes, reader%first, reader%last), achar(form%separator)), &
                      messages)
    end if
    table%lines(row) = int(reader%line)
    table%numbers(:, row) = numbers
  end subroutine read_row

  pure subroutine grow(table)
    !! Double the capacity for rows.
    type(design_table), intent(inout) :: table
    real(dp), allocatable :: numbers(:, :)
    integer, allocatable :: lines(:)
    integer :: rows
    rows = size(table%lines)
    allocate (numbers(size(table%names), max(16, 2*rows)), lines(max(16, 2*rows)))
    if (rows > 0) numbers(:, :rows) = table%numbers
    lines(:rows) = table%lines
    call move_alloc(numbers, table%numbers)
    call move_alloc(lines, table%lines)
  end subroutine grow

  subroutine refuse_row(names, fields, messages)
    !! Report what is wrong with each cell of a row that could not be read. A column without a name is reported as such.
    type(string), intent(in) :: names(:), fields(:)
    type(message_list), intent(inout) :: messages
    character(:), allocatable :: problem
    integer :: i
    if (size(fields) /= size(names)) then
      call messages%add(messages%table_line, 'row', 'has '//text_of(size(fields))//' of '//text_of(size(names))// &
                        ' columns; accepted: a number in each column, with a decimal point')
      return
    end if
    do i = 1, size(fields)
      if (names(i)%text == '') cycle
      problem = cell_problem(fields(i)%text)
      if (problem /= '') call messages%add(messages%table_line, names(i)%text, problem// &
                                           '; accepted: a finite number as 2.5 or -1e-3')
    end do
  end subroutine refuse_row

  function cell_problem(field) result(problem)
    !! Return why a cell holds no valid number; empty if it holds one.
    character(*), intent(in) :: field
    character(:), allocatable :: problem, marks
    problem = ''
    marks = number_marks(field)
    if (field == '') then
      problem = 'the number is missing'
    else if (marks == ',' .or. marks == 'x') then
      problem = shown(field)//' has a decimal comma or thousands separators'
    else if (marks == '' .and. (is_missing_word(field) .or. verify(field, '0123456789+-.eEdD') == 0)) then
      problem = shown(field)//' is not a finite number'
    else if (marks == '') then
      problem = shown(field)//' is not a number'
    end if
  end function cell_problem

end module bw_design_table
