module bw_descriptor
  !! Files by the system's descriptors: what a call has written lies with the system and survives the process, any place can
  !! be read and written, and other processes may do the same at the same time.
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_int64_t, c_loc, c_null_char, c_ptr, &
    c_size_t
  use bw_kinds, only: i1, i8
  implicit none (type, external)
  private
  public :: new_file, open_to_read, open_to_change, close_descriptor
  public :: write_bytes, write_bytes_at, read_bytes_at, bytes_in_file, set_length, copy_bytes, put_on_disk

  integer, parameter :: appending = 1, placing = 2, reading = 3
  integer(i8), parameter :: copied_at_once = 262144    !! bytes: fits into a cache; tuned

  interface
    integer(c_int) function c_creat(path, mode) bind(c, name='creat')
      import :: c_char, c_int
      implicit none (type, external)
      character(c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function c_creat
    integer(c_size_t) function c_write(descriptor, bytes, count) bind(c, name='write')   ! ssize_t has the same size
      import :: c_int, c_ptr, c_size_t
      implicit none (type, external)
      integer(c_int), value :: descriptor
      type(c_ptr), value :: bytes
      integer(c_size_t), value :: count
    end function c_write
    integer(c_size_t) function c_pwrite(descriptor, bytes, count, offset) bind(c, name='pwrite')
      import :: c_int, c_int64_t, c_ptr, c_size_t
      implicit none (type, external)
      integer(c_int), value :: descriptor
      type(c_ptr), value :: bytes
      integer(c_size_t), value :: count
      integer(c_int64_t), value :: offset
    end function c_pwrite
    integer(c_size_t) function c_pread(descriptor, bytes, count, offset) bind(c, name='pread')
      import :: c_int, c_int64_t, c_ptr, c_size_t
      implicit none (type, external)
      integer(c_int), value :: descriptor
      type(c_ptr), value :: bytes
      integer(c_size_t), value :: count
      integer(c_int64_t), value :: offset
    end function c_pread
    integer(c_int64_t) function c_lseek(descriptor, offset, whence) bind(c, name='lseek')
      import :: c_int, c_int64_t
      implicit none (type, external)
      integer(c_int), value :: descriptor
      integer(c_int64_t), value :: offset
      integer(c_int), value :: whence
    end function c_lseek
    integer(c_int) function c_ftruncate(descriptor, length) bind(c, name='ftruncate')
      import :: c_int, c_int64_t
      implicit none (type, external)
      integer(c_int), value :: descriptor
      integer(c_int64_t), value :: length
    end function c_ftruncate
    integer(c_int) function c_fsync(descriptor) bind(c, name='fsync')
      import :: c_int
      implicit none (type, external)
      integer(c_int), value :: descriptor
    end function c_fsync
    type(c_ptr) function c_fopen(path, mode) bind(c, name='fopen')
      import :: c_char, c_ptr
      implicit none (type, external)
      character(c_char), intent(in) :: path(*), mode(*)
    end function c_fopen
    integer(c_int) function c_fileno(file) bind(c, name='fileno')
      import :: c_int, c_ptr
      implicit none (type, external)
      type(c_ptr), value :: file
    end function c_fileno
    integer(c_int) function c_fclose(file) bind(c, name='fclose')
      import :: c_int, c_ptr
      implicit none (type, external)
      type(c_ptr), value :: file
    end function c_fclose
    integer(c_int) function c_dup(descriptor) bind(c, name='dup')
      import :: c_int
      implicit none (type, external)
      integer(c_int), value :: descriptor
    end function c_dup
    integer(c_int) function c_close(descriptor) bind(c, name='close')
      import :: c_int
      implicit none (type, external)
      integer(c_int), value :: descriptor
    end function c_close
  end interface

contains

  integer function new_file(path) result(descriptor)
    !! An empty file to be written; -1 where it cannot be made.
    character(*), intent(in) :: path
    descriptor = c_creat(path//c_null_char, int(o'666', c_int))     ! less the caller's umask
  end function new_file

  integer function open_to_read(path) result(descriptor)
    !! A file that is there; -1 where it cannot be read.
    character(*), intent(in) :: path
    descriptor = open_in_mode(path, 'r')
  end function open_to_read

  integer function open_to_change(path) result(descriptor)
    !! A file to be read and written in any place, made where it is not there; -1 where it cannot be.
    character(*), intent(in) :: path
    descriptor = open_in_mode(path, 'r+')
    if (descriptor >= 0) return
    call close_descriptor(new_file(path))
    descriptor = open_in_mode(path, 'r+')
  end function open_to_change

  integer function open_in_mode(path, mode) result(descriptor)
    character(*), intent(in) :: path, mode
    type(c_ptr) :: file                         ! C's open takes any number of arguments, which Fortran cannot call
    integer(c_int) :: ignored
    descriptor = -1
    file = c_fopen(path//c_null_char, mode//c_null_char)
    if (.not. c_associated(file)) return
    descriptor = c_dup(c_fileno(file))
    ignored = c_fclose(file)
  end function open_in_mode

  subroutine close_descriptor(descriptor)
    !! Close a file, or give a lock back.
    integer, intent(in) :: descriptor           !! nothing is done with -1
    integer(c_int) :: ignored
    if (descriptor >= 0) ignored = c_close(int(descriptor, c_int))
  end subroutine close_descriptor

  logical function write_bytes(descriptor, address, count) result(written)
    !! Write where the descriptor stands. False where the system refuses any of it: a full disk.
    integer, intent(in) :: descriptor
    type(c_ptr), intent(in) :: address
    integer(i8), intent(in) :: count
    written = moved(appending, descriptor, 0_i8, address, count)
  end function write_bytes

  logical function write_bytes_at(descriptor, offset, address, count) result(written)
    !! Write in any place. False as above.
    integer, intent(in) :: descriptor           !! of `open_to_change`
    integer(i8), intent(in) :: offset           !! of the first byte, from 0
    type(c_ptr), intent(in) :: address
    integer(i8), intent(in) :: count
    written = moved(placing, descriptor, offset, address, count)
  end function write_bytes_at

  logical function read_bytes_at(descriptor, offset, address, count) result(done)
    !! Read from any place. False where the system refuses it, or the file ends before.
    integer, intent(in) :: descriptor           !! of `open_to_read` or `open_to_change`
    integer(i8), intent(in) :: offset           !! of the first byte, from 0
    type(c_ptr), intent(in) :: address
    integer(i8), intent(in) :: count
    done = moved(reading, descriptor, offset, address, count)
  end function read_bytes_at

  logical function moved(way, descriptor, offset, address, count)
    !! All bytes were written or read: by one call, unless they are very many, a disk is filling up or a file ends.
    integer, intent(in) :: way                  !! appending, placing or reading
    integer, intent(in) :: descriptor
    integer(i8), intent(in) :: offset, count
    type(c_ptr), intent(in) :: address
    integer(i1), pointer, contiguous :: bytes(:)
    integer(i8) :: have, more
    call c_f_pointer(address, bytes, [count])
    have = 0
    do while (have < count)
      select case (way)
      case (appending); more = c_write(int(descriptor, c_int), c_loc(bytes(have + 1)), count - have)
      case (placing); more = c_pwrite(int(descriptor, c_int), c_loc(bytes(have + 1)), count - have, offset + have)
      case default; more = c_pread(int(descriptor, c_int), c_loc(bytes(have + 1)), count - have, offset + have)
      end select
      if (more <= 0) exit
      have = have + more
    end do
    moved = have == count
  end function moved

  integer(i8) function bytes_in_file(descriptor) result(bytes)
    !! How long it is by now; 0 where the system does not say.
    integer, intent(in) :: descriptor
    integer(c_int), parameter :: from_the_end = 2        ! SEEK_END
    bytes = max(0_i8, c_lseek(int(descriptor, c_int), 0_i8, from_the_end))
  end function bytes_in_file

  logical function set_length(descriptor, bytes) result(done)
    !! Cut a file, or lengthen it with zeros that take no room.
    integer, intent(in) :: descriptor           !! of `new_file` or `open_to_change`
    integer(i8), intent(in) :: bytes
    done = c_ftruncate(int(descriptor, c_int), bytes) == 0
  end function set_length

  logical function copy_bytes(from, to, offset, count) result(done)
    !! Copy a stretch of a file to the same place of another. False where the system refuses it.
    integer, intent(in) :: from, to             !! descriptors
    integer(i8), intent(in) :: offset, count    !! bytes
    integer(i1), allocatable, target :: bytes(:)
    integer(i8) :: have, more
    allocate (bytes(min(count, copied_at_once)))
    done = .true.
    have = 0
    do while (done .and. have < count)
      more = min(count - have, copied_at_once)
      done = read_bytes_at(from, offset + have, c_loc(bytes), more)
      if (done) done = write_bytes_at(to, offset + have, c_loc(bytes), more)
      have = have + more
    end do
  end function copy_bytes

  logical function put_on_disk(path) result(done)
    !! Wait until all of a file that is there would outlive the machine. False where the system refuses it.
    character(*), intent(in) :: path
    integer :: descriptor
    descriptor = open_to_read(path)
    done = descriptor >= 0
    if (done) done = c_fsync(int(descriptor, c_int)) == 0
    call close_descriptor(descriptor)
  end function put_on_disk

end module bw_descriptor
