module bw_error
  !! Errors as values: a procedure that can fail fills `error` and returns; only `app/` prints and stops.
  implicit none (type, external)
  private
  public :: fail

  integer, parameter, public :: status_done = 0        !! success
  integer, parameter, public :: status_bad_input = 2   !! the command line or a scene is wrong
  integer, parameter, public :: status_bad_file = 3    !! a file could not be read or written, or memory ran out
  integer, parameter, public :: status_not_trusted = 4 !! some numbers cannot be trusted
  integer, parameter, public :: status_stopped = 5     !! stopped in order, finished work is saved
  integer, parameter, public :: status_fault = 70      !! a fault in the program itself

  type, public :: error_type
    !! One failure. An unallocated `error_type` means success.
    integer :: status = status_done        !! one of the exit statuses above
    character(:), allocatable :: message   !! place, error, accepted values; may hold several lines
  end type error_type

contains

  pure subroutine fail(error, status, message)
    !! Fill `error`; the caller then returns.
    type(error_type), allocatable, intent(out) :: error
    integer, intent(in) :: status          !! one of the exit statuses of this module
    character(*), intent(in) :: message
    error = error_type(status, message)
  end subroutine fail

end module bw_error
