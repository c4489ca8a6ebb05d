module bw_classic_reader
  !! The head of a classic NetCDF file, read as far as needed to identify its result and to detect a truncated file.
  use bw_classic_head, only: bytes_of, letters, reals
  use bw_descriptors, only: read_bytes
  use bw_kinds, only: i1, i8
  use bw_text, only: append, string
  implicit none (type, external)
  private

  integer(i8), parameter :: most = 2_i8**40      !! of any count: more is damage
  integer(i8), parameter :: at_once = 65536      !! bytes read first

  type, public :: classic_reader
    logical :: is_sound = .false.                !! the head is complete and valid
    integer(i8) :: length = 0                    !! expected length of the file
    integer(i8) :: place = 0, bytes = 0          !! of the numbers of the requested variable; 0: absent
    type(string), allocatable, private :: names(:), texts(:)        !! of the file
    integer, private :: at = 0, width = 4
  contains
    procedure :: read_file
    procedure :: read => read_head
    procedure :: text_of
    procedure, private :: next, number, name, read_attributes
  end type classic_reader

contains

  subroutine read_file(self, descriptor, bytes, variable, start, problem)
    !! Read the head of a file; it is not sound if invalid.
    class(classic_reader), intent(out) :: self
    integer, intent(in) :: descriptor
    integer(i8), intent(in) :: bytes                         !! of the file
    character(*), intent(in) :: variable
    character(:), allocatable, intent(out) :: start          !! first bytes of the file
    integer, intent(out) :: problem                          !! as in `bw_files`
    integer(i1), allocatable :: letters(:)
    integer(i8) :: wanted, have
    wanted = at_once
    do
      allocate (letters(min(wanted, bytes)))
      problem = read_bytes(descriptor, 0_i8, letters, have)
      if (allocated(start)) deallocate (start)
      allocate (character(have) :: start)
      start = transfer(letters(:have), start)
      deallocate (letters)
      if (problem /= 0) return
      call self%read(start, variable)
      if (self%is_sound .or. wanted >= bytes) return
      wanted = 4*wanted                                      ! the head is longer
    end do
  end subroutine read_file

  subroutine read_head(self, start, variable)
    !! Parse a head from the first bytes of a file; it is not sound if they are too few.
    class(classic_reader), intent(out) :: self
    character(*), intent(in) :: start, variable
    character(:), allocatable :: word, skipped
    integer(i8) :: i, place, bytes
    allocate (self%names(0), self%texts(0))
    word = start(:min(4, len(start)))
    self%is_sound = any(word == ['CDF'//char(2), 'CDF'//char(5)])
    self%at = len(word)
    if (word == 'CDF'//char(5)) self%width = 8
    i = self%number(start, self%width)                ! record dimension
    do i = 1, self%number(start, 4, self%width)       ! dimensions
      skipped = self%name(start)//self%next(start, int(self%width, i8))
      if (.not. self%is_sound) return
    end do
    call self%read_attributes(start, .true.)
    do i = 1, self%number(start, 4, self%width)       ! variables
      word = self%name(start)
      skipped = self%next(start, self%width*self%number(start, self%width))       ! its dimensions
      call self%read_attributes(start, .false.)
      bytes = self%number(start, 4, self%width)       ! after the type
      place = self%number(start, 8)
      if (.not. self%is_sound) return
      self%length = max(self%length, place + bytes)
      if (word == variable) self%place = place
      if (word == variable) self%bytes = bytes
    end do
  end subroutine read_head

  subroutine read_attributes(self, start, of_file)
    !! Parse a list of attributes; those of the file are stored.
    class(classic_reader), intent(inout) :: self
    character(*), intent(in) :: start
    logical, intent(in) :: of_file
    character(:), allocatable :: name, value
    integer(i8) :: kind, a
    do a = 1, self%number(start, 4, self%width)
      name = self%name(start)
      kind = self%number(start, 4)
      self%is_sound = self%is_sound .and. kind >= letters .and. kind <= reals
      if (.not. self%is_sound) return
      value = self%next(start, self%number(start, self%width)*bytes_of(kind))
      value = value//char(0)
      if (of_file) call append(self%names, name)
      if (of_file) call append(self%texts, value(:index(value, char(0)) - 1))
    end do
  end subroutine read_attributes

  function text_of(self, name) result(text)
    !! Return a text of the file; empty if it has none of that name.
    class(classic_reader), intent(in) :: self
    character(*), intent(in) :: name
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(self%names)
      if (self%names(i)%text == name) text = self%texts(i)%text
    end do
  end function text_of

  function name(self, start) result(text)
    !! Parse the next name, preceded by its length.
    class(classic_reader), intent(inout) :: self
    character(*), intent(in) :: start
    character(:), allocatable :: text
    text = self%next(start, self%number(start, self%width))
  end function name

  function next(self, start, length) result(bytes)
    !! Return the next bytes, and skip the padding to words of four; empty if they are not there.
    class(classic_reader), intent(inout) :: self
    character(*), intent(in) :: start
    integer(i8), intent(in) :: length
    character(:), allocatable :: bytes
    bytes = ''
    self%is_sound = self%is_sound .and. length >= 0 .and. length <= len(start) - self%at
    if (.not. self%is_sound) return
    bytes = start(self%at + 1:self%at + length)
    self%at = self%at + int(4*((length + 3)/4))
  end function next

  integer(i8) function number(self, start, width, width_behind)
    !! Parse the next integer of so many bytes, at most `most`; 0 if it is not there.
    class(classic_reader), intent(inout) :: self
    character(*), intent(in) :: start
    integer, intent(in) :: width
    integer, intent(in), optional :: width_behind     !! bytes of a second integer, which is the one returned
    character(:), allocatable :: bytes
    integer :: i
    bytes = self%next(start, int(width, i8))
    if (present(width_behind)) bytes = self%next(start, int(width_behind, i8))
    number = 0
    do i = 1, len(bytes)
      number = min(most, 256*number + ichar(bytes(i:i)))
    end do
  end function number

end module bw_classic_reader
