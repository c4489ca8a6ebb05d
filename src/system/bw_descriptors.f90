module bw_descriptors
  !! Open files by the system's descriptors: what a call has written lies with the system and survives the process. A
  !! `problem` is that of `bw_files`.
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
    !! Open a file. The `way` is `to_read`, `new_file` (which must not be there) or `to_change` (which is no link).
    character(*), intent(in) :: path
    integer, intent(in) :: way
    integer, intent(out) :: descriptor     !! −1 where there is a problem
    problem = bw_open(path//c_null_char, way, descriptor)
  end function open_file

  subroutine open_regular(path, descriptor, error)
    !! Open a file to read that may be read again and from any place.
    !! **Errors**: `status_bad_file` where it cannot be opened, or is a directory, a pipe or a device, which may have no end.
    character(*), intent(in) :: path
    integer, intent(out) :: descriptor     !! −1 where there is an error
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
    !! Close a file. Some file systems tell only now that what was written could not be kept.
    integer, intent(inout) :: descriptor   !! −1 afterwards; nothing is done with −1
    problem = 0
    if (descriptor >= 0) problem = bw_close(descriptor)
    descriptor = -1
  end function close_file

  integer function read_bytes(descriptor, offset, bytes, have) result(problem)
    !! Read bytes from any place.
    integer, intent(in) :: descriptor
    integer(i8), intent(in) :: offset      !! from 0
    integer(i1), intent(inout), contiguous, target :: bytes(:)
    integer(i8), intent(out) :: have       !! how many there are
    problem = bw_read(descriptor, c_loc(bytes), size(bytes, kind=i8), offset, have)
  end function read_bytes

  integer function write_text(descriptor, text) result(problem)
    !! Write text behind what was written before, at once. gfortran's own units forget a failure of their last buffer.
    integer, intent(in) :: descriptor      !! `standard_output`, `standard_error`, or an open file's
    character(*), intent(in), target :: text
    problem = 0
    if (len(text) > 0) problem = bw_write(descriptor, c_loc(text), len(text, i8))
  end function write_text

  integer function look_at_open(descriptor, state) result(problem)
    !! Find out which file a descriptor is.
    integer, intent(in) :: descriptor
    type(path_state), intent(out) :: state
    integer(c_int64_t) :: found(5)
    problem = bw_look_at(descriptor, c_null_char, 0, found)
    if (problem == 0) state = path_state(int(found(1)), found(2), found(3), found(4), found(5))
  end function look_at_open

  logical function is_terminal(descriptor)
    !! Whether a stream goes to a terminal, where somebody may be reading along.
    integer, intent(in) :: descriptor      !! `standard_output` or `standard_error`
    is_terminal = bw_is_terminal(descriptor) == 1
  end function is_terminal

end module bw_descriptors
