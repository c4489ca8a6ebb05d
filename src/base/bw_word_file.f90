module bw_word_file
  !! Files of words of eight bytes: written at once and whole, so that what is written survives the process, and read in
  !! any place, also while another process writes on.
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_int64_t, c_loc, c_null_char, c_ptr, c_size_t
  use bw_kinds, only: i8
  implicit none (type, external)
  private
  public :: new_file, write_words, open_for_reading, words_in_file, read_words

  integer, parameter :: word = 8              !! bytes

  interface
    integer(c_int) function c_creat(path, mode) bind(c, name='creat')
      import :: c_char, c_int
      implicit none (type, external)
      character(c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
    end function c_creat
    integer(c_size_t) function c_write(descriptor, words, count) bind(c, name='write')   ! ssize_t has the same size
      import :: c_int, c_ptr, c_size_t
      implicit none (type, external)
      integer(c_int), value :: descriptor
      type(c_ptr), value :: words
      integer(c_size_t), value :: count
    end function c_write
    integer(c_size_t) function c_pread(descriptor, words, count, offset) bind(c, name='pread')
      import :: c_int, c_int64_t, c_ptr, c_size_t
      implicit none (type, external)
      integer(c_int), value :: descriptor
      type(c_ptr), value :: words
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
  end interface

contains

  integer function new_file(path) result(descriptor)
    !! An empty file, open for `write_words`; -1 where it cannot be made.
    character(*), intent(in) :: path
    descriptor = c_creat(path//c_null_char, int(o'666', c_int))     ! less the caller's umask
  end function new_file

  logical function write_words(descriptor, words) result(written)
    !! Write to an open descriptor, at once and whole: what is written survives the process.
    integer, intent(in) :: descriptor           !! of `new_file`
    integer(i8), intent(in), contiguous, target :: words(:)
    integer(i8) :: first
    integer(c_size_t) :: bytes, count
    bytes = word*size(words, kind=c_size_t)
    first = 1
    count = c_write(int(descriptor, c_int), c_loc(words), bytes)
    do while (count > 0 .and. count < bytes .and. mod(count, int(word, c_size_t)) == 0)   ! very long, or a disk filling up
      first = first + count/word
      bytes = bytes - count
      count = c_write(int(descriptor, c_int), c_loc(words(first)), bytes)
    end do
    written = count == bytes
  end function write_words

  integer function open_for_reading(path) result(descriptor)
    !! A file that is there, open for `read_words`; -1 where it cannot be read.
    character(*), intent(in) :: path
    type(c_ptr) :: file                         ! C's open takes any number of arguments, which Fortran cannot call
    integer(c_int) :: ignored
    descriptor = -1
    file = c_fopen(path//c_null_char, 'r'//c_null_char)
    if (.not. c_associated(file)) return
    descriptor = c_dup(c_fileno(file))
    ignored = c_fclose(file)
  end function open_for_reading

  integer(i8) function words_in_file(descriptor) result(words)
    !! How many whole words it has by now; 0 where the system does not say.
    integer, intent(in) :: descriptor           !! of `open_for_reading`
    integer(c_int), parameter :: from_the_end = 2        ! SEEK_END
    words = max(0_i8, c_lseek(int(descriptor, c_int), 0_i8, from_the_end)/word)
  end function words_in_file

  logical function read_words(descriptor, position, words) result(done)
    !! Read from any place. False where the system refuses it, or the file ends before.
    integer, intent(in) :: descriptor           !! of `open_for_reading`
    integer(i8), intent(in) :: position         !! of the first word, from 1
    integer(i8), intent(out), contiguous, target :: words(:)
    integer(i8) :: have
    integer(c_size_t) :: count
    have = 0
    do while (have < size(words, kind=i8))
      count = c_pread(int(descriptor, c_int), c_loc(words(have + 1)), word*(size(words, kind=c_size_t) - have), &
                      word*(position - 1 + have))
      if (count < word) exit
      have = have + count/word
    end do
    done = have == size(words, kind=i8)
  end function read_words

end module bw_word_file
