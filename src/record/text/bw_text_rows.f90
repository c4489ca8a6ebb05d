module bw_text_rows
  !! Rows of a record's table: the form in which they are read, and errors of rows that could not be read.
  use bw_kinds, only: i1
  use bw_table_row, only: row_form
  use bw_text, only: shortened, string, text_of
  use bw_text_fields, only: blanks, fields_of, is_missing_word
  use bw_text_layout, only: text_layout
  implicit none (type, external)
  private
  public :: judge_row, prepared

contains

  pure type(row_form) function prepared(layout, columns) result(form)
    !! Return the form in which some columns are read.
    type(text_layout), intent(in) :: layout
    integer, intent(in) :: columns(:)
    integer :: i
    form%separator = iachar(layout%separator, i1)
    form%mark = iachar(layout%mark, i1)
    form%blank = layout%separator == blanks
    form%closed = layout%closed
    form%columns = size(layout%columns)
    allocate (form%slot(form%columns), source=0)
    do i = 1, size(columns)
      form%slot(columns(i)) = i
    end do
  end function prepared

  pure subroutine judge_row(layout, columns, line, lacks, problem)
    !! Find what is wrong with a row that could not be read.
    type(text_layout), intent(in) :: layout
    integer, intent(in) :: columns(:)          !! requested columns
    character(*), intent(in) :: line
    logical, intent(out) :: lacks(:)           !! where a number is missing, (columns)
    character(:), allocatable, intent(out) :: problem    !! '' if nothing else is wrong
    type(string), allocatable :: fields(:)
    integer :: n, c
    lacks = .false.
    fields = fields_of(line, layout%separator)
    n = size(fields)
    if (layout%closed .and. n == size(layout%columns) + 1) n = n - 1
    if (n /= size(layout%columns)) then
      problem = 'has '//text_of(n)//' of '//text_of(size(layout%columns))//' columns'
      if (n > size(layout%columns)) problem = 'has '//text_of(n)//' columns, and the rows before '// &
        text_of(size(layout%columns))
      problem = problem//'; accepted: rows of one length'
      return
    end if
    do c = 1, size(columns)
      associate (field => fields(columns(c))%text)
        lacks(c) = is_missing_word(field)
        if (is_number_here(field, layout%mark) .or. lacks(c)) cycle
        problem = named(layout, columns(c))// &
          ": '"//shortened(field)//"' is not a finite number; accepted: as in 2.5, -1e-3, 1.0D+03"
        if (n > 1 .and. scan(line, '0123456789') == 0) problem = 'is not a row of numbers; accepted: one table '// &
          '(beamwave-record converts texts of several)'
        return
      end associate
    end do
    problem = 'is not a row of numbers; accepted: finite numbers'
    if (any(lacks)) problem = ''
  end subroutine judge_row

  pure logical function is_number_here(field, mark)
    !! Return whether a field has the form of a number, for a message; its size is not checked.
    character(*), intent(in) :: field
    character, intent(in) :: mark
    is_number_here = field /= '' .and. verify(field, '0123456789+-eEdD'//mark) == 0 .and. scan(field, '0123456789') > 0 &
      .and. .not. is_too_large(field)
  end function is_number_here

  pure logical function is_too_large(field)
    !! Return whether an exponent is too large for double precision.
    character(*), intent(in) :: field
    integer :: letter, exponent, stat
    is_too_large = .false.
    letter = scan(field, 'eEdD')
    if (letter == 0) return
    read (field(letter + 1:), *, iostat=stat) exponent
    is_too_large = stat /= 0 .or. exponent > 290
  end function is_too_large

  pure function named(layout, column) result(text)
    !! Return a column as a message shows it: `column 3 (acc)`.
    type(text_layout), intent(in) :: layout
    integer, intent(in) :: column
    character(:), allocatable :: text
    text = 'column '//text_of(column)
    if (layout%columns(column)%name /= '') text = text//' ('//shortened(layout%columns(column)%name)//')'
  end function named

end module bw_text_rows
