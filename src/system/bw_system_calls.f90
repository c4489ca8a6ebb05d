module bw_system_calls
  !! Interfaces of bw_system.c, where each function is described, and of some system functions. A path ends with
  !! `c_null_char`; an integer result is 0, or the system's error number.
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int64_t, c_ptr
  implicit none (type, external)
  public

  integer(c_int), parameter :: error_not_there = 1, error_is_there = 2, error_is_held = 3, error_not_offered = 4
  integer(c_int), parameter :: error_nobody_reads = 5
    !! kinds of errors by `bw_kind_of_error`: name does not exist, name exists, held by another process, not supported
    !! by the file system, the reader of a pipe has closed it; 0: any other
  integer(c_int), parameter :: to_read = 1, new_file = 2, to_change = 3
    !! ways of `bw_open`: read; create a file that must not exist; change an existing file that is no link
  integer(c_int), parameter :: to_remove = 1, to_make_directory = 2, to_remove_directory = 3, may_be_written = 4, &
    to_flush_names = 5, to_rename = 6, to_link = 7
    !! operations and queries of `bw_do` on a path; the last two take a second one
  integer, parameter :: is_file = 1, is_directory = 2      !! kinds of objects of a path; others are above

  interface
    pure integer(c_int) function bw_kind_of_error(number) bind(c)
      import :: c_int
      integer(c_int), value :: number
    end function bw_kind_of_error
    integer(c_int) function bw_reserve(descriptor, reserved, bytes) bind(c)
      import :: c_int, c_int64_t
      integer(c_int), value :: descriptor
      integer(c_int64_t), value :: reserved, bytes
    end function bw_reserve
    integer(c_int) function bw_open_numbers(descriptor, file) bind(c)
      import :: c_int, c_ptr
      integer(c_int), value :: descriptor
      type(c_ptr), intent(out) :: file
    end function bw_open_numbers
    integer(c_int) function bw_hold(file) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function bw_hold
    integer(c_int) function bw_put(file, place, width, values, count) bind(c)
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: file, values
      integer(c_int64_t), value :: place, count
      integer(c_int), value :: width
    end function bw_put
    integer(c_int) function bw_get_numbers(file, place, width, values, count) bind(c)
      import :: c_double, c_int, c_int64_t, c_ptr
      type(c_ptr), value :: file
      integer(c_int64_t), value :: place, count
      integer(c_int), value :: width
      real(c_double), intent(out) :: values(*)
    end function bw_get_numbers
    integer(c_int) function bw_write_gathered(file) bind(c)
      import :: c_int, c_ptr
      type(c_ptr), value :: file
    end function bw_write_gathered
    subroutine bw_error_text(number, text, length) bind(c)
      import :: c_char, c_int
      integer(c_int), value :: number, length
      character(c_char), intent(out) :: text(*)
    end subroutine bw_error_text
    integer(c_int) function bw_open(path, way, descriptor) bind(c)
      import :: c_char, c_int
      character(c_char), intent(in) :: path(*)
      integer(c_int), value :: way
      integer(c_int), intent(out) :: descriptor
    end function bw_open
    integer(c_int) function bw_close(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end function bw_close
    integer(c_int) function bw_read(descriptor, bytes, count, offset, have) bind(c)
      import :: c_int, c_int64_t, c_ptr
      integer(c_int), value :: descriptor
      type(c_ptr), value :: bytes
      integer(c_int64_t), value :: count, offset
      integer(c_int64_t), intent(out) :: have
    end function bw_read
    integer(c_int) function bw_write(descriptor, bytes, count) bind(c)
      import :: c_int, c_int64_t, c_ptr
      integer(c_int), value :: descriptor
      type(c_ptr), value :: bytes
      integer(c_int64_t), value :: count
    end function bw_write
    integer(c_int) function bw_flush(descriptor) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor
    end function bw_flush
    integer(c_int) function bw_do(what, path, to) bind(c)
      import :: c_char, c_int
      integer(c_int), value :: what
      character(c_char), intent(in) :: path(*), to(*)
    end function bw_do
    integer(c_int) function bw_look_at(descriptor, path, itself, state) bind(c)
      import :: c_char, c_int, c_int64_t
      integer(c_int), value :: descriptor, itself
      character(c_char), intent(in) :: path(*)
      integer(c_int64_t), intent(out) :: state(5)
    end function bw_look_at
    integer(c_int) function bw_list(path, suffix, text, length) bind(c)
      import :: c_char, c_int, c_int64_t, c_ptr
      character(c_char), intent(in) :: path(*), suffix(*)
      type(c_ptr), intent(out) :: text
      integer(c_int64_t), intent(out) :: length
    end function bw_list
    subroutine bw_release(memory) bind(c, name='free')
      import :: c_ptr
      type(c_ptr), value :: memory
    end subroutine bw_release
    integer(c_int) function bw_lock(descriptor, reading) bind(c)
      import :: c_int
      integer(c_int), value :: descriptor, reading
    end function bw_lock
    subroutine bw_host(name, length) bind(c)
      import :: c_char, c_int
      character(c_char), intent(out) :: name(*)
      integer(c_int), value :: length
    end subroutine bw_host
    integer(c_int64_t) function bw_process() bind(c)
      import :: c_int64_t
    end function bw_process
    integer(c_int64_t) function bw_beginning_of(process) bind(c)
      import :: c_int64_t
      integer(c_int64_t), value :: process
    end function bw_beginning_of
    subroutine bw_open_standard_streams() bind(c)
    end subroutine bw_open_standard_streams
    subroutine bw_watch() bind(c)
    end subroutine bw_watch
    subroutine bw_stop_after(seconds) bind(c)
      import :: c_double
      real(c_double), value :: seconds
    end subroutine bw_stop_after
    integer(c_int) function bw_stop_asked() bind(c)
      import :: c_int
    end function bw_stop_asked
    subroutine bw_leave(status) bind(c, name='_exit')
      import :: c_int
      integer(c_int), value :: status
    end subroutine bw_leave
    integer(c_int64_t) function bw_listen(channel, bytes, most, milliseconds) bind(c)
      import :: c_int, c_int64_t, c_ptr
      integer(c_int), value :: channel, milliseconds
      type(c_ptr), value :: bytes
      integer(c_int64_t), value :: most
    end function bw_listen
    integer(c_int) function bw_is_terminal(descriptor) bind(c, name='isatty')
      import :: c_int
      integer(c_int), value :: descriptor
    end function bw_is_terminal
    subroutine bw_pause(microseconds) bind(c)
      import :: c_int
      integer(c_int), value :: microseconds
    end subroutine bw_pause
    integer(c_int64_t) function bw_free_disk(path) bind(c)
      import :: c_char, c_int64_t
      character(c_char), intent(in) :: path(*)
    end function bw_free_disk
    integer(c_int64_t) function bw_free_memory() bind(c)
      import :: c_int64_t
    end function bw_free_memory
    integer(c_int) function bw_prepare_openblas(bytes) bind(c)
      import :: c_int, c_int64_t
      integer(c_int64_t), value :: bytes
    end function bw_prepare_openblas
    subroutine bw_set_environment(name, value) bind(c)
      import :: c_char
      character(c_char), intent(in) :: name(*), value(*)
    end subroutine bw_set_environment
  end interface

end module bw_system_calls
