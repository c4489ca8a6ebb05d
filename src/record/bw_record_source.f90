module bw_record_source
  !! A file of histories, whatever its form: a table of rows, one for each instant, and of columns.
  use bw_error, only: error_type
  use bw_kinds, only: dp, i8
  use bw_record, only: column_type
  use bw_text, only: string
  implicit none (type, external)
  private

  type, abstract, public :: record_source
    character(:), allocatable :: path
    type(column_type), allocatable :: columns(:)
    logical :: is_labelled = .false.             !! what its columns measure is said by the file, not guessed by their units
    integer(i8) :: rows = 0                      !! how many it has; 0: only reading tells
    type(string), allocatable :: notes(:)        !! what is odd about what the file says of them
  contains
    procedure(open_interface), deferred :: open
    procedure(times_interface), deferred :: read_times
    procedure(values_interface), deferred :: read_values
    procedure(place_interface), deferred :: place_of_row
    procedure(close_interface), deferred :: close
  end type record_source

  abstract interface
    subroutine open_interface(self, path, error)
      !! Open a file and find its columns. **Errors**: `status_bad_file`, `status_bad_input`, as those of all that follows.
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
      integer, intent(in) :: column                        !! of the times; 0: there is none, the rows are counted
      integer(i8), intent(out) :: rows
      real(dp), allocatable, intent(out) :: times(:)       !! [s], (rows), or of size 0 without a column
      real(dp), allocatable, intent(out) :: steps(:)       !! what the last digit of each stands for [s], (rows)
      type(error_type), allocatable, intent(inout) :: error
    end subroutine times_interface

    subroutine values_interface(self, columns, first, values, error)
      !! Read some columns of some rows. What is no finite number is refused with its place.
      import :: dp, error_type, i8, record_source
      implicit none (type, external)
      class(record_source), intent(inout) :: self
      integer, intent(in) :: columns(:)
      integer(i8), intent(in) :: first                     !! row
      real(dp), intent(inout), contiguous :: values(:, :)              !! (rows, size(columns))
      type(error_type), allocatable, intent(inout) :: error
    end subroutine values_interface

    function place_interface(self, row) result(place)
      !! How a message names a row: `FILE:LINE`.
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
