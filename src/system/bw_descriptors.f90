module bw_descriptors
  !! Open files by the system's descriptors: written data is held by the system and survives the process. A `problem` is
  !! as in `bw_files`.
  use, intrinsic :: iso_c_binding, only: c_int64_t, c_loc, c_null_char
  use bw_error, only: error_type, fail, status_bad_file
  use bw_files, only: cannot_be_read, path_state
  use bw_kinds, only: i1, i8
  use bw_system_calls, only: bw_close, bw_is_terminal, bw_look_at, bw_open, bw_read, bw_write, is_directory, &
    is_file, new_file, to_change, to_read, flush_file => bw_flush
  implicit none (type, external)
  private
  public :: open_file, open_regular, close_file, read_bytes, write_text, flush_file, look_at_open
  public :: is_terminal
  public :: is_file, new_file, to_change, to_read

  integer, parameter, public :: standard_output = 1, standard_error = 2

contains

  integer function open_file(path, way, descriptor) result(problem)
    !! Open a file. The `way` is `to_read`, `new_file` (which must not exist) or `to_change` (which must not be a link).
    character(*), intent(in) :: path
    integer, intent(in) :: way
    integer, intent(out) :: descriptor     !! −1 if there is a problem
    problem = bw_open(path//c_null_char, way, descriptor)
  end function open_file

  subroutine open_regular(path, descriptor, error)
    !! Open a regular file, which can be read repeatedly and at any position.
    !! **Errors**: `status_bad_file` if it cannot be opened, or is a directory, a pipe or a device, which may be endless.
    character(*), intent(in) :: path
    integer, intent(out) :: descriptor     !! −1 after an error
    type(error_type), allocatable, intent(inout) :: error
    type(path_state) :: state
    integer :: problem, ignored
    problem = open_file(path, to_read, descriptor)
    if (problem == 0) problem = look_at_open(descriptor, state)
    if (problem /= 0) then
      call cannot_be_read(error, path, problem)
    else if (state%kind == is_directory) then
      call fail(error, status_bad_file, path//': is a directory; accepted: a file')
    else if (state%kind /= is_file) then
      call fail(error, status_bad_file, path//': is a pipe or a device; accepted: a file')
    end if
    if (allocated(error)) ignored = close_file(descriptor)
  end subroutine open_regular

  integer function close_file(descriptor) result(problem)
    !! Close a file. Some file systems report write errors only now.
    integer, intent(inout) :: descriptor   !! −1 afterwards; nothing is done with −1
    problem = 0
    if (descriptor >= 0) problem = bw_close(descriptor)
    descriptor = -1
  end function close_file

  integer function read_bytes(descriptor, offset, bytes, have) result(problem)
    !! Read bytes at any position.
    integer, intent(in) :: descriptor
    integer(i8), intent(in) :: offset      !! from 0
    integer(i1), intent(inout), contiguous, target :: bytes(:)
    integer(i8), intent(out) :: have       !! their number
    problem = bw_read(descriptor, c_loc(bytes), size(bytes, kind=i8), offset, have)
  end function read_bytes

  integer function write_text(descriptor, text) result(problem)
    !! Append text, unbuffered. gfortran's own units ignore a failure of their last buffer.
    integer, intent(in) :: descriptor      !! `standard_output`, `standard_error`, or an open file's
    character(*), intent(in), target :: text
    problem = 0
    if (len(text) > 0) problem = bw_write(descriptor, c_loc(text), len(text, i8))
  end function write_text

  integer function look_at_open(descriptor, state) result(problem)
    !! Identify the file of a descriptor.
    integer, intent(in) :: descriptor
    type(path_state), intent(out) :: state
    integer(c_int64_t) :: found(5)
    problem = bw_look_at(descriptor, c_null_char, 0, found)
    if (problem == 0) state = path_state(int(found(1)), found(2), found(3), found(4), found(5))
  end function look_at_open

  logical function is_terminal(descriptor)
    !! Return whether a stream goes to a terminal.
    integer, intent(in) :: descriptor      !! `standard_output` or `standard_error`
    is_terminal = bw_is_terminal(descriptor) == 1
  end function is_terminal

end module bw_descriptors
