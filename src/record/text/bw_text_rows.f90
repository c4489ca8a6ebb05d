module bw_text_rows
  !! One row of a table of text: the numbers of the columns that are asked for, read where they stand.
  use bw_kinds, only: dp, i1
  use bw_number_scan, only: scan_number
  use bw_text_fields, only: blanks, fields_of, is_missing_word
  use bw_text_layout, only: text_layout
  use bw_text, only: shortened, string, text_of
  implicit none (type, external)
  private
  public :: prepared, scan_row, row_problem, says_nothing

  integer(i1), parameter :: space = iachar(' ', i1), tabulator = 9_i1, hash = iachar('#', i1), per_cent = iachar('%', i1), &
                            quote = iachar('"', i1), apostrophe = iachar("'", i1)

  type, public :: row_form
    !! What a row is read by.
    integer(i1) :: separator = space, mark = iachar('.', i1)
    logical :: blank = .true.                  !! blanks separate
    logical :: closed = .false.                !! a separator may stand behind the last field
    integer :: columns = 0
    integer, allocatable :: slot(:)            !! where the number of each column goes; 0: it is not read, (columns)
  end type row_form

contains

  pure type(row_form) function prepared(layout, columns) result(form)
    !! To read some columns.
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

  pure logical function says_nothing(bytes, first, last)
    !! The line is empty, or a comment.
    integer(i1), intent(in) :: bytes(:)
    integer, intent(in) :: first, last
    integer :: at
    at = behind_blanks(bytes, first, last, .true.)
    says_nothing = at > last
    if (.not. says_nothing) says_nothing = bytes(at) == hash .or. bytes(at) == per_cent
  end function says_nothing

  pure integer function behind_blanks(bytes, first, last, tabs) result(at)
    !! The first byte that is no blank.
    integer(i1), intent(in) :: bytes(:)
    integer, intent(in) :: first, last
    logical, intent(in) :: tabs                !! tabs are blanks
    do at = first, last
      if (bytes(at) /= space .and. .not. (tabs .and. bytes(at) == tabulator)) return
    end do
  end function behind_blanks

  subroutine scan_row(form, bytes, first, last, numbers, decades, good)
    !! Read the numbers of one row.
    type(row_form), intent(in) :: form
    integer(i1), intent(in) :: bytes(:)
    integer, intent(in) :: first, last         !! of the line
    real(dp), intent(inout) :: numbers(:)      !! in the places that the form says
    integer, intent(inout) :: decades(:)       !! power of ten of the last digit of each
    logical, intent(out) :: good               !! as many fields as columns, and numbers in those that are read
    integer :: at, c
    logical :: tabs
    tabs = form%separator /= tabulator
    good = .false.
    at = first
    do c = 1, form%columns
      at = behind_blanks(bytes, at, last, tabs)
      if (form%blank .and. at > last) return
      if (form%slot(c) > 0) then
        call scan_field(bytes, at, last, form%mark, numbers(form%slot(c)), decades(form%slot(c)), good)
        if (.not. good) return
      else
        at = behind_field(form, bytes, at, last)
      end if
      good = .false.
      if (at <= last) then                     ! a number ends at a blank, a separator or the end of the line
        if (bytes(at) == space .or. (tabs .and. bytes(at) == tabulator)) then
          at = behind_blanks(bytes, at, last, tabs)
        else if (bytes(at) /= form%separator) then
          return
        end if
      end if
      if (c == form%columns .or. form%blank) cycle
      if (at > last) return
      if (bytes(at) /= form%separator) return
      at = at + 1
    end do
    if (form%closed .and. at <= last) then
      if (bytes(at) == form%separator) at = behind_blanks(bytes, at + 1, last, tabs)
    end if
    good = at > last
  end subroutine scan_row

  subroutine scan_field(bytes, at, last, mark, number, decade, good)
    !! A number, which may stand in quotes.
    integer(i1), intent(in) :: bytes(:)
    integer, intent(inout) :: at
    integer, intent(in) :: last
    integer(i1), intent(in) :: mark
    real(dp), intent(out) :: number
    integer, intent(out) :: decade
    logical, intent(out) :: good
    logical :: quoted
    integer(i1) :: mine
    quoted = .false.
    if (at <= last) then
      mine = bytes(at)
      quoted = mine == quote .or. mine == apostrophe
    end if
    if (quoted) at = at + 1
    call scan_number(bytes, at, last, mark, number, decade, good)
    if (.not. quoted .or. .not. good) return
    good = at <= last
    if (good) good = bytes(at) == mine
    at = at + 1
  end subroutine scan_field

  pure integer function behind_field(form, bytes, first, last) result(at)
    !! The separator behind a field that is not read, or the end of the line.
    type(row_form), intent(in) :: form
    integer(i1), intent(in) :: bytes(:)
    integer, intent(in) :: first, last
    logical :: inside
    inside = .false.
    do at = first, last
      if (bytes(at) == quote) inside = .not. inside
      if (inside) cycle
      if (bytes(at) == form%separator .or. (form%blank .and. bytes(at) == tabulator)) return
    end do
  end function behind_field

  pure function row_problem(layout, columns, line) result(problem)
    !! What is wrong with a row that could not be read.
    type(text_layout), intent(in) :: layout
    integer, intent(in) :: columns(:)          !! that are read
    character(*), intent(in) :: line
    character(:), allocatable :: problem
    type(string), allocatable :: fields(:)
    integer :: n, c
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
    problem = 'is no row of numbers; accepted: finite numbers'
    do c = 1, size(columns)
      associate (field => fields(columns(c))%text)
        if (is_number_here(field, layout%mark)) cycle
        problem = named(layout, columns(c))//": '"//shortened(field)//"' is no finite number"
        if (field == '') problem = named(layout, columns(c))//': the number is missing'
        if (is_missing_word(field)) problem = problem//'; accepted: a record without gaps; leave such rows out, or cut them '// &
          'off by start and end'
        if (.not. is_missing_word(field)) problem = problem//'; accepted: as in 2.5, -1e-3, 1.0D+03'
        return
      end associate
    end do
  end function row_problem

  pure logical function is_number_here(field, mark)
    !! The form of a number, for a message; its size is not looked at.
    character(*), intent(in) :: field
    character, intent(in) :: mark
    is_number_here = field /= '' .and. verify(field, '0123456789+-eEdD'//mark) == 0 .and. scan(field, '0123456789') > 0 &
      .and. .not. is_too_large(field)
  end function is_number_here

  pure logical function is_too_large(field)
    !! An exponent of a kind that no double has.
    character(*), intent(in) :: field
    integer :: letter, exponent, stat
    is_too_large = .false.
    letter = scan(field, 'eEdD')
    if (letter == 0) return
    read (field(letter + 1:), *, iostat=stat) exponent
    is_too_large = stat /= 0 .or. exponent > 290
  end function is_too_large

  pure function named(layout, column) result(text)
    !! `column 3 (acc)`.
    type(text_layout), intent(in) :: layout
    integer, intent(in) :: column
    character(:), allocatable :: text
    text = 'column '//text_of(column)
    if (layout%columns(column)%name /= '') text = text//' ('//shortened(layout%columns(column)%name)//')'
  end function named

end module bw_text_rows
