module number_table
  !! The table of hard cases: for each the worst error found, and the bound that it has to keep.
  use bw_kinds, only: dp
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private

  integer, parameter :: columns = 5
  integer, parameter :: cell_length = 128

  type :: row_type
    character(cell_length) :: case = ''      !! what is computed
    character(cell_length) :: measure = ''   !! what errors are relative to
    real(dp) :: bound = 0.0_dp
    real(dp) :: worst = 0.0_dp
    integer :: values = 0                    !! how many errors were looked at
  end type row_type

  type, public :: table_type
    private
    type(row_type), allocatable :: rows(:)
  contains
    procedure :: begin
    generic :: note => note_one, note_each
    procedure :: note_many
    procedure :: all_kept
    procedure :: write_markdown
    procedure :: write_to_file
    procedure, private :: note_one
    procedure, private :: note_each
  end type table_type

contains

  subroutine begin(self, case, bound, measure)
    !! A new row, to which the errors that follow belong.
    class(table_type), intent(inout) :: self
    character(*), intent(in) :: case
    real(dp), intent(in) :: bound
    character(*), intent(in) :: measure
    if (.not. allocated(self%rows)) allocate (self%rows(0))
    self%rows = [self%rows, row_type(case, measure, bound)]
  end subroutine begin

  subroutine note_one(self, error)
    !! One error of the row that was begun last. NaN is the worst.
    class(table_type), intent(inout) :: self
    real(dp), intent(in) :: error        !! ≥ 0
    associate (row => self%rows(size(self%rows)))
      row%values = row%values + 1
      if (.not. error <= row%worst) row%worst = error
    end associate
  end subroutine note_one

  subroutine note_each(self, errors)
    class(table_type), intent(inout) :: self
    real(dp), intent(in) :: errors(:)
    integer :: i
    do i = 1, size(errors)
      call self%note_one(errors(i))
    end do
  end subroutine note_each

  subroutine note_many(self, error, values)
    !! The worst error of so many values.
    class(table_type), intent(inout) :: self
    real(dp), intent(in) :: error        !! ≥ 0
    integer, intent(in) :: values
    call self%note_one(error)
    self%rows(size(self%rows))%values = self%rows(size(self%rows))%values + values - 1
  end subroutine note_many

  logical function all_kept(self)
    !! No bound is missed, and no row is without values.
    class(table_type), intent(in) :: self
    all_kept = all(self%rows%worst <= self%rows%bound .and. self%rows%values > 0)
  end function all_kept

  subroutine write_to_file(self, path)
    class(table_type), intent(in) :: self
    character(*), intent(in) :: path
    integer :: unit
    open (newunit=unit, file=path, status='replace', action='write')
    call self%write_markdown(unit)
    close (unit)
  end subroutine write_to_file

  subroutine write_markdown(self, unit)
    class(table_type), intent(in) :: self
    integer, intent(in) :: unit
    character(cell_length) :: cells(columns, -1:size(self%rows))
    integer :: widths(columns), r, c
    cells(:, -1) = [character(cell_length) :: 'case', 'worst error found', 'bound', 'measured as', 'values']
    cells(:, 0) = '---'
    do r = 1, size(self%rows)
      associate (row => self%rows(r))
        cells(:, r) = [character(cell_length) :: row%case, error_text(row), shortest(row%bound, 3), row%measure, &
                       text_of(row%values)]
      end associate
    end do
    do c = 1, columns
      widths(c) = maxval([(width_of(cells(c, r)), r=-1, size(self%rows))])
    end do
    do r = -1, size(self%rows)
      write (unit, '(*(a))') '|', (' '//padded(cells(c, r), widths(c))//' |', c=1, columns)
    end do
  end subroutine write_markdown

  pure function error_text(row) result(text)
    type(row_type), intent(in) :: row
    character(:), allocatable :: text
    text = shortest(row%worst, 2)
    if (row%worst > row%bound) text = text//' MISSED'
  end function error_text

  pure integer function width_of(text) result(width)
    !! Characters, not bytes, of a text in UTF-8 without the blanks at its end.
    character(*), intent(in) :: text
    integer :: i
    width = count([(iand(iachar(text(i:i)), 192) /= 128, i=1, len_trim(text))])
  end function width_of

  pure function padded(text, width)
    character(*), intent(in) :: text
    integer, intent(in) :: width
    character(:), allocatable :: padded
    padded = trim(text)//repeat(' ', width - width_of(text))
  end function padded

end module number_table
