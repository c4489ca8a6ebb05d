module bw_table_row
  !! One row of a text table: the numbers of the requested columns, parsed in place.
  use bw_kinds, only: dp, i1
  use bw_number_scan, only: scan_number
  implicit none (type, external)
  private
  public :: scan_row, says_nothing

  integer(i1), parameter :: space = iachar(' ', i1), tabulator = 9_i1, hash = iachar('#', i1), per_cent = iachar('%', i1), &
                            quote = iachar('"', i1), apostrophe = iachar("'", i1)

  type, public :: row_form
    !! The format of rows.
    integer(i1) :: separator = space, mark = iachar('.', i1)
    logical :: blank = .true.                  !! blanks separate
    logical :: closed = .false.                !! a separator may follow the last field
    integer :: columns = 0
    integer, allocatable :: slot(:)            !! index of each column's number; 0: not read, (columns)
  end type row_form

contains

  pure logical function says_nothing(bytes, first, last)
    !! Return whether the line is empty or a comment.
    integer(i1), intent(in) :: bytes(:)
    integer, intent(in) :: first, last
    integer :: at
    at = behind_blanks(bytes, first, last, .true.)
    says_nothing = at > last
    if (.not. says_nothing) says_nothing = bytes(at) == hash .or. bytes(at) == per_cent
  end function says_nothing

  pure integer function behind_blanks(bytes, first, last, tabs) result(at)
    !! Return the first byte that is not blank.
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
    real(dp), intent(inout) :: numbers(:)      !! at the indices of `slot`
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
    integer :: power
    quoted = .false.
    if (at <= last) then
      mine = bytes(at)
      quoted = mine == quote .or. mine == apostrophe
    end if
    if (quoted) at = at + 1
    call scan_number(bytes, at, last, mark, number, decade, power, good)
    if (.not. quoted .or. .not. good) return
    good = at <= last
    if (good) good = bytes(at) == mine
    at = at + 1
  end subroutine scan_field

  pure integer function behind_field(form, bytes, first, last) result(at)
    !! Return the separator after a field that is not read, or the end of the line.
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

end module bw_table_row
