module bw_line_reader
  !! Reading of a text file line by line, with one block of it in memory.
  use bw_descriptors, only: close_file, open_regular, read_bytes
  use bw_error, only: error_type, fail, status_bad_file
  use bw_files, only: cannot_be_read
  use bw_kinds, only: i1, i8
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: text_between

  integer, parameter :: piece = 2**20                      !! bytes read at a time
  integer, parameter, public :: longest_line = 2**21       !! bytes
  integer(i1), parameter :: line_feed = 10_i1, carriage_return = 13_i1
  integer(i1), parameter :: blank = 32_i1, no_break = int(-96, i1), before_no_break = int(-62, i1)
    !! a no-break space is the second of these alone in Latin 1, and after the third in UTF-8
  integer(i1), parameter :: byte_order_mark(3) = int([-17, -69, -65], i1)

  type, public :: line_reader
    character(:), allocatable :: path
    integer(i1), allocatable :: bytes(:)                   !! the buffer
    integer :: first = 1, last = 0                         !! of the line in `bytes`, without its line end
    integer(i8) :: line = 0                                !! its number in the file, from 1
    integer, private :: descriptor = -1
    integer(i8), private :: offset = 0                     !! bytes read from the file
    integer :: have = 0                                    !! bytes in memory
    integer, private :: next = 1                           !! start of the next line in `bytes`
    logical, private :: ended = .false.                    !! the end of the file is reached
  contains
    procedure :: open => open_reader
    procedure :: next_line
    procedure :: close => close_reader
    procedure, private :: refill
  end type line_reader

contains

  subroutine open_reader(self, path, error)
    !! Open a file and skip a byte-order mark. **Errors**: `status_bad_file`.
    class(line_reader), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    call self%close()
    self%path = path
    self%line = 0
    self%offset = 0
    self%next = 1
    self%have = 0
    self%ended = .false.
    call open_regular(path, self%descriptor, error)
    if (allocated(error)) return
    if (.not. allocated(self%bytes)) allocate (self%bytes(2*piece))
    call self%refill(error)
    if (self%have < 3 .or. allocated(error)) return
    if (all(self%bytes(:3) == byte_order_mark)) self%next = 4
  end subroutine open_reader

  subroutine close_reader(self)
    !! Close the file, if one is open.
    class(line_reader), intent(inout) :: self
    integer :: ignored
    ignored = close_file(self%descriptor)
  end subroutine close_reader

  subroutine next_line(self, there, error)
    !! Read the next line; the last one may lack a line end.
    !! **Errors**: `status_bad_file` if the file cannot be read, or a line is longer than `longest_line`.
    class(line_reader), intent(inout) :: self
    logical, intent(out) :: there
    type(error_type), allocatable, intent(inout) :: error
    integer :: at, searched
    searched = self%next
    there = .false.
    do
      at = line_end(self%bytes, searched, self%have)
      if (at <= self%have) exit                            ! a line feed
      if (self%ended) exit
      searched = self%have - self%next + 1                 ! bytes of this line without a line feed
      call self%refill(error)
      if (allocated(error)) return
      searched = self%next + searched
    end do
    there = self%next <= self%have
    if (.not. there) return
    self%first = self%next
    self%last = at - 1
    self%next = at + 1
    self%line = self%line + 1
    do while (self%last >= self%first)
      if (self%bytes(self%last) /= carriage_return) return
      self%last = self%last - 1
    end do
  end subroutine next_line

  pure integer function line_end(bytes, first, last) result(at)
    !! Return the first line feed in a range; the position after the range if there is none.
    integer(i1), intent(in) :: bytes(:)
    integer, intent(in) :: first, last
    do at = first, last
      if (bytes(at) == line_feed) return
    end do
  end function line_end

  subroutine refill(self, error)
    !! Drop processed lines, and read on.
    class(line_reader), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    integer(i1), allocatable :: wider(:)
    integer(i8) :: got
    integer :: kept, problem
    kept = self%have - self%next + 1
    self%bytes(:kept) = self%bytes(self%next:self%have)
    self%next = 1
    self%have = kept
    if (kept > longest_line) then
      call fail(error, status_bad_file, self%path//':'//text_of(self%line + 1)//': the line is longer than '// &
                text_of(longest_line)//' bytes; accepted: a text of lines, or NetCDF')
      return
    end if
    if (kept + piece > size(self%bytes)) then
      allocate (wider(2*size(self%bytes)))
      wider(:kept) = self%bytes(:kept)
      call move_alloc(wider, self%bytes)
    end if
    problem = read_bytes(self%descriptor, self%offset, self%bytes(kept + 1:kept + piece), got)
    if (problem /= 0) call cannot_be_read(error, self%path, problem)
    self%offset = self%offset + got
    self%have = kept + int(got)
    call make_blank(self%bytes(max(1, kept):self%have))
    self%ended = got < piece
  end subroutine refill

  pure subroutine make_blank(bytes)
    !! Replace no-break spaces by blanks. After any other byte above 127 the same byte is part of a letter.
    integer(i1), intent(inout) :: bytes(:)
    integer(i1) :: before
    integer :: at
    if (.not. any(bytes == no_break)) return
    before = blank
    do at = 1, size(bytes)
      if (bytes(at) == no_break .and. (before >= 0 .or. before == before_no_break)) then
        bytes(at) = blank
        if (before == before_no_break) bytes(max(1, at - 1)) = blank
      end if
      before = bytes(at)
    end do
  end subroutine make_blank

  pure function text_between(bytes, first, last) result(text)
    !! Return bytes as characters.
    integer(i1), intent(in) :: bytes(:)
    integer, intent(in) :: first, last
    character(:), allocatable :: text
    integer :: i
    allocate (character(max(0, last - first + 1)) :: text)
    do i = first, last
      text(i - first + 1:i - first + 1) = transfer(bytes(i), 'a')
    end do
  end function text_between

end module bw_line_reader
