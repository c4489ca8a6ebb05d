module bw_number_file
  !! A file whose numbers have known places: big-endian reals of eight bytes and integers of four, and texts. Written
  !! data is held by the system and survives the process; `flush` brings it to the disk. After a failure nothing more is
  !! written, and `problem` is as in `bw_files`.
  use, intrinsic :: iso_c_binding, only: c_associated, c_int, c_loc, c_null_ptr, c_ptr
  use bw_descriptors, only: close_file, flush_file, look_at_open, new_file, open_file, read_bytes, to_change
  use bw_error, only: error_type, fail, status_bad_file
  use bw_files, only: cannot_be_written, look_at, path_state, remove_file, same_file
  use bw_kinds, only: dp, i1, i8
  use bw_system_calls, only: bw_get_numbers, bw_hold, bw_kind_of_error, bw_open_numbers, bw_put, bw_release, &
    bw_reserve, bw_write_gathered, error_not_offered
  implicit none (type, external)
  private

  integer, parameter, public :: real_width = 8, whole_width = 4      !! bytes of a number

  type, public :: number_file
    character(:), allocatable :: path
    integer :: problem = 0
    integer, private :: descriptor = -1
    logical, private :: is_shared = .false.  !! other processes put numbers between those of this one
    type(c_ptr), private :: buffer = c_null_ptr
  contains
    procedure :: make
    procedure :: open => open_numbers
    procedure :: hold
    procedure :: put_numbers
    procedure :: put_text
    procedure :: get_numbers
    procedure :: get_text
    procedure :: write => write_gathered
    procedure :: flush => flush_numbers
    procedure :: close => close_numbers
    procedure, private :: note
  end type number_file

contains

  subroutine make(self, path, bytes, reserved, error)
    !! Create a file of that length, and reserve disk space for its first bytes.
    !! **Errors**: something of that name is there, the disk has not the room, or the system refuses it; then nothing is left.
    class(number_file), intent(inout) :: self
    character(*), intent(in) :: path
    integer(i8), intent(in) :: bytes, reserved
    type(error_type), allocatable, intent(inout) :: error
    integer :: ignored
    self%path = path
    call self%note(open_file(path, new_file, self%descriptor))
    if (self%problem == 0) call self%note(bw_reserve(int(self%descriptor, c_int), reserved, bytes))
    if (self%problem == 0) call self%note(bw_open_numbers(int(self%descriptor, c_int), self%buffer))
    if (self%problem == 0) return
    call cannot_be_written(error, path, self%problem)
    if (self%descriptor >= 0) ignored = remove_file(path)
    call self%close()
  end subroutine make

  subroutine open_numbers(self, path, shared, bytes, error)
    !! Open an existing file for reading and writing.
    !! **Errors**: the system refuses it.
    class(number_file), intent(inout) :: self
    character(*), intent(in) :: path
    logical, intent(in) :: shared            !! other processes put numbers between those of this one
    integer(i8), intent(out) :: bytes        !! its length
    type(error_type), allocatable, intent(inout) :: error
    type(path_state) :: state
    self%path = path
    call self%note(open_file(path, to_change, self%descriptor))
    if (self%problem == 0) call self%note(look_at_open(self%descriptor, state))
    bytes = state%bytes
    if (self%problem == 0) call self%note(bw_open_numbers(int(self%descriptor, c_int), self%buffer))
    if (self%problem == 0 .and. shared) then
      self%is_shared = bw_kind_of_error(bw_hold(self%buffer)) /= error_not_offered
      call self%write()
    end if
    if (self%problem /= 0) call cannot_be_written(error, path, self%problem)
  end subroutine open_numbers

  subroutine hold(self)
    !! Keep other processes from putting numbers until `write` has written those that follow. On a file system without
    !! locks, rows interleaved with those of others are written one by one.
    class(number_file), intent(inout) :: self
    if (self%problem == 0 .and. self%is_shared) self%problem = bw_hold(self%buffer)
  end subroutine hold

  subroutine note(self, problem)
    !! Store the first problem.
    class(number_file), intent(inout) :: self
    integer, intent(in) :: problem
    if (self%problem == 0) self%problem = problem
  end subroutine note

  subroutine put_numbers(self, place, width, values)
    !! Put numbers from an offset on.
    class(number_file), intent(inout) :: self
    integer(i8), intent(in) :: place                 !! bytes, from 0
    integer, intent(in) :: width                     !! `real_width`, or `whole_width` to put integers
    real(dp), intent(in), contiguous, target :: values(:)
    if (self%problem == 0) self%problem = bw_put(self%buffer, place, int(width, c_int), c_loc(values), size(values, kind=i8))
  end subroutine put_numbers

  subroutine put_text(self, place, text)
    !! Put letters from an offset on.
    class(number_file), intent(inout) :: self
    integer(i8), intent(in) :: place
    character(*), intent(in), target :: text
    if (self%problem == 0) self%problem = bw_put(self%buffer, place, 1_c_int, c_loc(text), len(text, i8))
  end subroutine put_text

  subroutine get_numbers(self, place, width, values)
    !! Get numbers from an offset on.
    class(number_file), intent(inout) :: self
    integer(i8), intent(in) :: place
    integer, intent(in) :: width
    real(dp), intent(out), contiguous :: values(:)
    if (self%problem == 0) self%problem = bw_get_numbers(self%buffer, place, int(width, c_int), values, size(values, kind=i8))
  end subroutine get_numbers

  subroutine get_text(self, place, text)
    !! Get letters from an offset on; blanks after the end of the file.
    class(number_file), intent(inout) :: self
    integer(i8), intent(in) :: place
    character(*), intent(out) :: text
    integer(i1), allocatable :: bytes(:)
    integer(i8) :: have
    text = ''
    call self%write()
    if (self%problem /= 0) return
    allocate (bytes(len(text)))
    self%problem = read_bytes(self%descriptor, place, bytes, have)
    if (self%problem == 0) text(:have) = transfer(bytes(:have), text(:have))
  end subroutine get_text

  subroutine write_gathered(self)
    !! Pass the gathered data to the system.
    class(number_file), intent(inout) :: self
    if (self%problem == 0) self%problem = bw_write_gathered(self%buffer)
  end subroutine write_gathered

  subroutine flush_numbers(self, error)
    !! Bring all data to the disk.
    !! **Errors**: the system refuses it, now or before; or the file has lost its name.
    class(number_file), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    type(path_state) :: mine, named
    call self%write()
    if (self%problem == 0) self%problem = flush_file(self%descriptor)
    if (self%problem == 0) self%problem = look_at_open(self%descriptor, mine)
    if (self%problem == 0) self%problem = look_at(self%path, named)
    if (self%problem /= 0) then
      call cannot_be_written(error, self%path, self%problem)
    else if (.not. same_file(mine, named) .and. .not. allocated(error)) then
      call fail(error, status_bad_file, self%path// &
                ': is gone: somebody has removed it while it was written, or its file system is no longer there')
    end if
  end subroutine flush_numbers

  subroutine close_numbers(self)
    !! Close the file; data not flushed is kept as far as the system keeps it.
    class(number_file), intent(inout) :: self
    integer :: ignored
    if (c_associated(self%buffer)) then
      call self%write()
      call bw_release(self%buffer)
    end if
    self%buffer = c_null_ptr
    self%is_shared = .false.
    ignored = close_file(self%descriptor)
    self%problem = 0
  end subroutine close_numbers

end module bw_number_file
