module bw_posix
  !! The few calls of the operating system that Fortran lacks.
  use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_int, c_loc, c_null_char, c_null_funptr, c_null_ptr, &
    c_funptr, c_ptr, c_size_t
  use bw_descriptor, only: close_descriptor, new_file, write_bytes
  use bw_kinds, only: i8
  use bw_text, only: string
  implicit none (type, external)
  private
  public :: make_directory, rename_file, remove_file, remove_directory, is_terminal, file_exists, is_directory, files_in
  public :: write_text, lock_file, pause, loaded_procedure

  integer(c_int), parameter, public :: standard_output = 1, standard_error = 2
  integer(c_int), parameter :: f_ok = 0
  integer(c_int), parameter :: all_permissions = int(o'777', c_int)   ! less the caller's umask

  integer, parameter :: spare = 16   ! more members than any library has

  type, bind(c) :: glob_type
    !! glob_t of <glob.h>: the members that POSIX names, and room for what a library adds.
    integer(c_size_t) :: path_count = 0
    type(c_ptr) :: paths = c_null_ptr
    integer(c_size_t) :: offset = 0
    integer(c_size_t) :: room(spare) = 0
  end type glob_type

  interface
    integer(c_int) function c_glob(pattern, flags, on_error, found) bind(c, name='glob')
      import :: c_char, c_funptr, c_int, glob_type
      implicit none (type, external)
      character(c_char), intent(in) :: pattern(*)
      integer(c_int), value :: flags
      type(c_funptr), value :: on_error
      type(glob_type), intent(inout) :: found
    end function c_glob
    subroutine c_globfree(found) bind(c, name='globfree')
      import :: glob_type
      implicit none (type, external)
      type(glob_type), intent(inout) :: found
    end subroutine c_globfree
    integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
      import :: c_ptr, c_size_t
      implicit none (type, external)
      type(c_ptr), value :: text
    end function c_strlen
    integer(c_int) function c_usleep(microseconds) bind(c, name='usleep')
      import :: c_int
      implicit none (type, external)
      integer(c_int), value :: microseconds
    end function c_usleep
    integer(c_int) function c_flock(descriptor, operation) bind(c, name='flock')
      import :: c_int
      implicit none (type, external)
      integer(c_int), value :: descriptor, operation
    end function c_flock
    integer(c_int) function c_mkdir(path, mode) bind(c, name='mkdir')
      import :: c_char, c_int
      implicit none (type, external)
      character(c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function c_mkdir
    integer(c_int) function c_rename(from, to) bind(c, name='rename')
      import :: c_char, c_int
      implicit none (type, external)
      character(c_char), intent(in) :: from(*), to(*)
    end function c_rename
    integer(c_int) function c_unlink(path) bind(c, name='unlink')
      import :: c_char, c_int
      implicit none (type, external)
      character(c_char), intent(in) :: path(*)
    end function c_unlink
    integer(c_int) function c_rmdir(path) bind(c, name='rmdir')
      import :: c_char, c_int
      implicit none (type, external)
      character(c_char), intent(in) :: path(*)
    end function c_rmdir
    integer(c_int) function c_access(path, mode) bind(c, name='access')
      import :: c_char, c_int
      implicit none (type, external)
      character(c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function c_access
    type(c_funptr) function c_dlsym(library, name) bind(c, name='dlsym')
      import :: c_char, c_funptr, c_ptr
      implicit none (type, external)
      type(c_ptr), value :: library
      character(c_char), intent(in) :: name(*)
    end function c_dlsym
    integer(c_int) function c_isatty(descriptor) bind(c, name='isatty')
      import :: c_int
      implicit none (type, external)
      integer(c_int), value :: descriptor
    end function c_isatty
  end interface

contains

  logical function write_text(descriptor, text) result(written)
    !! Write to an open descriptor at once. gfortran's own units forget a failure of their last buffer.
    integer(c_int), intent(in) :: descriptor    !! `standard_output` or `standard_error`
    character(*), intent(in), target :: text
    written = .true.
    if (len(text) > 0) written = write_bytes(int(descriptor), c_loc(text(1:1)), len(text, i8))
  end function write_text

  subroutine pause(microseconds)
    !! Leave the processor to others for a moment.
    integer, intent(in) :: microseconds         !! below a million
    integer(c_int) :: ignored
    ignored = c_usleep(int(microseconds, c_int))
  end subroutine pause

  subroutine lock_file(path, descriptor, held)
    !! Take a lock that ends with the process, however it ends.
    character(*), intent(in) :: path
    integer, intent(out) :: descriptor          !! for `close_descriptor`; -1 where there is no lock
    logical, intent(out) :: held                !! another process holds it
    integer(c_int), parameter :: exclusive_at_once = 6        ! LOCK_EX + LOCK_NB
    held = .false.
    descriptor = new_file(path)
    if (descriptor < 0) return
    held = c_flock(int(descriptor, c_int), exclusive_at_once) /= 0
    if (.not. held) return
    call close_descriptor(descriptor)
    descriptor = -1
  end subroutine lock_file

  logical function make_directory(path) result(there)
    !! Make a directory and its parents; true if it is there afterwards.
    character(*), intent(in) :: path
    integer :: i
    integer(c_int) :: ignored
    do i = 2, len(path)
      if (path(i:i) == '/') ignored = c_mkdir(path(:i - 1)//c_null_char, all_permissions)
    end do
    ignored = c_mkdir(path//c_null_char, all_permissions)
    there = is_directory(path)
  end function make_directory

  logical function rename_file(from, to) result(done)
    !! Move a file over another at once, within one file system.
    character(*), intent(in) :: from, to
    done = c_rename(from//c_null_char, to//c_null_char) == 0
  end function rename_file

  subroutine remove_file(path)
    !! Remove a file if it is there.
    character(*), intent(in) :: path
    integer(c_int) :: ignored
    ignored = c_unlink(path//c_null_char)
  end subroutine remove_file

  subroutine remove_directory(path)
    !! Remove a directory if it is there and empty.
    character(*), intent(in) :: path
    integer(c_int) :: ignored
    ignored = c_rmdir(path//c_null_char)
  end subroutine remove_directory

  logical function file_exists(path)
    !! Something of that name is there, whatever it is.
    character(*), intent(in) :: path
    file_exists = c_access(path//c_null_char, f_ok) == 0
  end function file_exists

  logical function is_directory(path)
    !! A directory of that name is there.
    character(*), intent(in) :: path
    is_directory = file_exists(path//'/.')
  end function is_directory

  function files_in(directory, suffix) result(paths)
    !! The files of a directory whose names end so, in the order of their names.
    character(*), intent(in) :: directory, suffix
    type(string), allocatable :: paths(:)
    type(glob_type) :: found
    type(c_ptr), pointer :: texts(:)
    integer :: i
    allocate (paths(0))
    if (c_glob(escaped(directory)//'/*'//suffix//c_null_char, 0_c_int, c_null_funptr, found) /= 0) return
    call c_f_pointer(found%paths, texts, [found%path_count])
    deallocate (paths)
    allocate (paths(found%path_count))
    do i = 1, size(paths)
      call copy_text(texts(i), paths(i)%text)
    end do
    call c_globfree(found)
  end function files_in

  pure function escaped(path) result(pattern)
    !! A pattern that matches just this path.
    character(*), intent(in) :: path
    character(:), allocatable :: pattern
    integer :: i
    pattern = ''
    do i = 1, len(path)
      if (scan(path(i:i), '*?[\') > 0) pattern = pattern//'\'
      pattern = pattern//path(i:i)
    end do
  end function escaped

  subroutine copy_text(address, text)
    !! Fortran's copy of C's text.
    type(c_ptr), intent(in) :: address
    character(:), allocatable, intent(out) :: text
    character(c_char), pointer :: letters(:)
    integer :: i, length
    length = int(c_strlen(address))
    call c_f_pointer(address, letters, [length])
    allocate (character(length) :: text)
    do i = 1, length
      text(i:i) = letters(i)
    end do
  end subroutine copy_text

  type(c_funptr) function loaded_procedure(name) result(address)
    !! A procedure of a library that the program has loaded; the null pointer where none has it.
    character(*), intent(in) :: name
    address = c_dlsym(c_null_ptr, name//c_null_char)
  end function loaded_procedure

  logical function is_terminal(descriptor)
    !! Somebody may be reading along.
    integer(c_int), intent(in) :: descriptor    !! `standard_output` or `standard_error`
    is_terminal = c_isatty(descriptor) == 1
  end function is_terminal

end module bw_posix
