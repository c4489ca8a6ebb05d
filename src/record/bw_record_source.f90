module bw_record_source
  !! A file of histories in any format: a table with a row for each instant, and columns.
  use bw_error, only: error_type
  use bw_kinds, only: dp, i8
  use bw_record, only: column_type
  use bw_text, only: string
  implicit none (type, external)
  private

  type, abstract, public :: record_source
    character(:), allocatable :: path
    type(column_type), allocatable :: columns(:)
    logical :: is_labelled = .false.             !! the file gives the quantities of columns; they are not inferred from units
    integer(i8) :: rows = 0                      !! number of rows; 0: not known before reading
    type(string), allocatable :: notes(:)        !! oddities in its description of the columns
  contains
    procedure(open_interface), deferred :: open
    procedure(times_interface), deferred :: read_times
    procedure(values_interface), deferred :: read_values
    procedure(place_interface), deferred :: place_of_row
    procedure(close_interface), deferred :: close
  end type record_source

  abstract interface
    subroutine open_interface(self, path, error)
      !! Open a file and find its columns. **Errors**: `status_bad_file`, `status_bad_input`, here and in all that follow.
      import :: error_type, record_source
      implicit none (type, external)
      class(record_source), intent(inout) :: self
      character(*), intent(in) :: path
      type(error_type), allocatable, intent(inout) :: error
    end subroutine open_interface

    subroutine times_interface(self, column, rows, times, steps, error)
      !! Read the times of all rows, or only count the rows.
      import :: dp, error_type, i8, record_source
      implicit none (type, external)
      class(record_source), intent(inout) :: self
      integer, intent(in) :: column                        !! of the times; 0: none, the rows are counted
      integer(i8), intent(out) :: rows
      real(dp), allocatable, intent(out) :: times(:)       !! [s], (rows), or of size 0 without a column
      real(dp), allocatable, intent(out) :: steps(:)       !! last digit of each [s], (rows)
      type(error_type), allocatable, intent(inout) :: error
    end subroutine times_interface

    subroutine values_interface(self, columns, first, values, error)
      !! Read some columns of some rows. Numbers that are not finite are rejected with their place.
      import :: dp, error_type, i8, record_source
      implicit none (type, external)
      class(record_source), intent(inout) :: self
      integer, intent(in) :: columns(:)
      integer(i8), intent(in) :: first                     !! row
      real(dp), intent(inout), contiguous :: values(:, :)              !! (rows, size(columns))
      type(error_type), allocatable, intent(inout) :: error
    end subroutine values_interface

    function place_interface(self, row) result(place)
      !! Return a row as a message shows it: `FILE:LINE`.
      import :: i8, record_source
      implicit none (type, external)
      class(record_source), intent(inout) :: self
      integer(i8), intent(in) :: row
      character(:), allocatable :: place
    end function place_interface

    subroutine close_interface(self)
      !! Close the file.
      import :: record_source
      implicit none (type, external)
      class(record_source), intent(inout) :: self
    end subroutine close_interface
  end interface

end module bw_record_source
