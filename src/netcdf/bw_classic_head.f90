module bw_classic_head
  !! The head of a classic NetCDF file, byte for byte as specified (NetCDF Users Guide, File Format Specifications):
  !! dimensions, attributes and variables, each with the offset of its numbers, stored one after another. It is laid out
  !! once and then never grows.
  !!
  !! The NetCDF library writes the same bytes, but does not report offsets, which processes that share a file need; loading it
  !! also takes longer than most scenes. Only variables with a fixed place are supported, no record dimension.
  use bw_kinds, only: i4, i8
  use bw_missing, only: missing
  use bw_text, only: text_builder
  implicit none (type, external)
  private

  integer, parameter, public :: letters = 2, wholes = 4, reals = 6       !! NetCDF's types: char, int, double
  integer, parameter, public :: bytes_of(letters:reals) = [1, 2, 4, 4, 8]       !! per value, short and float being between them
  integer, parameter :: list_of_dimensions = 10, list_of_variables = 11, list_of_attributes = 12     !! tags
  integer(i8), parameter, public :: most_bytes = 2_i8**32 - 4            !! of a variable if sizes have 32 bits

  type, public :: variable_type
    character(:), allocatable :: name
    integer :: kind = reals
    integer, allocatable :: dimensions(:)  !! in the file's order, the last fastest
    integer(i8) :: count = 1               !! numbers or letters
    integer(i8) :: room = 1                !! numbers per case; all of them if it does not depend on the case
    integer(i8) :: step = 0                !! bytes from one case to the next
    integer(i8) :: place = 0               !! offset in the file, after `lay_out`
    integer :: width = 8                   !! bytes of a number
    integer, private :: at = 0             !! position of its offset in the bytes of all variables
  end type variable_type

  type, public :: classic_head
    integer :: width = 4                                 !! bytes of a size: 8 where a variable has more than `most_bytes`
    integer :: count = 0                                 !! number of variables
    character(64), allocatable :: dimension_names(:)
    integer, allocatable :: lengths(:)                   !! of dimensions
    type(variable_type), allocatable :: variables(:)
    integer(i8) :: bytes = 0                             !! length of the file, after `lay_out`
    type(text_builder), private :: of_file, of_variable, all_variables       !! attributes, and variables with theirs
    integer, private :: of_file_count = 0, of_variable_count = 0
    character(32), allocatable, private :: text_names(:) !! texts of the file that may change, with their offsets and lengths
    integer, allocatable, private :: text_places(:), text_lengths(:)
  contains
    procedure :: add_dimension, dimensions_of, add_variable, add_text, add_room, add_wholes, add_fill
    procedure :: lay_out, find_text, blank_texts
    procedure, private :: add_attribute, end_variable
  end type classic_head

contains

  pure subroutine add_dimension(self, name, length)
    !! Add a dimension.
    class(classic_head), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: length          !! above 0
    if (.not. allocated(self%lengths)) allocate (self%lengths(0), self%dimension_names(0))
    self%lengths = [self%lengths, length]
    self%dimension_names = [character(64) :: self%dimension_names, name]
  end subroutine add_dimension

  pure function dimensions_of(self, names) result(numbers)
    !! Return the numbers of dimensions in the order of their names; 0 for an unknown name.
    class(classic_head), intent(in) :: self
    character(*), intent(in) :: names      !! separated by spaces
    integer, allocatable :: numbers(:)
    integer :: first, gap
    allocate (numbers(0))
    first = 1
    do while (first <= len_trim(names))
      gap = index(names(first:)//' ', ' ')
      numbers = [numbers, findloc(self%dimension_names == names(first:first + gap - 2), .true., dim=1)]
      first = first + gap
    end do
  end function dimensions_of

  subroutine add_variable(self, name, kind, dimensions, cases)
    !! Add a variable; attributes added after it are its own.
    class(classic_head), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: kind            !! `letters`, `wholes` or `reals`
    integer, intent(in) :: dimensions(:)   !! numbers, in the file's order; empty for a scalar
    integer, intent(in) :: cases           !! length of the first dimension if it counts cases; else 1
    type(variable_type), allocatable :: longer(:)
    integer(i8) :: count
    integer :: d
    if (.not. allocated(self%variables)) allocate (self%variables(128))
    if (self%count == size(self%variables)) then
      allocate (longer(2*self%count))
      longer(:self%count) = self%variables
      call move_alloc(longer, self%variables)
    end if
    call self%end_variable()
    self%count = self%count + 1
    count = product(int(self%lengths(dimensions), i8))
    associate (variable => self%variables(self%count))
      variable = variable_type(name, kind, dimensions, count, count/cases, count/cases*bytes_of(kind), width=bytes_of(kind))
      call self%all_variables%append(name_bytes(name, self%width)//in_bytes(size(dimensions, kind=i8), self%width))
      do d = 1, size(dimensions)
        call self%all_variables%append(in_bytes(dimensions(d) - 1_i8, self%width))
      end do
    end associate
  end subroutine add_variable

  subroutine end_variable(self)
    !! Complete the last variable, whose attributes are all there.
    class(classic_head), intent(inout) :: self
    if (self%count == 0) return
    associate (variable => self%variables(self%count))
      call self%all_variables%append(list_bytes(list_of_attributes, self%of_variable_count, self%width)// &
                                     self%of_variable%text()//in_bytes(int(variable%kind, i8), 4)// &
                                     in_bytes(padded(variable%count*variable%width), self%width))
      variable%at = self%all_variables%length()
      call self%all_variables%append(in_bytes(0_i8, 8))
    end associate
    self%of_variable = text_builder()
    self%of_variable_count = 0
  end subroutine end_variable

  subroutine add_attribute(self, of_file, name, kind, bytes)
    !! Add an attribute to the file, or to the last variable.
    class(classic_head), intent(inout) :: self
    logical, intent(in) :: of_file
    character(*), intent(in) :: name, bytes
    integer, intent(in) :: kind
    character(:), allocatable :: all
    all = name_bytes(name, self%width)//in_bytes(int(kind, i8), 4)// &
          in_bytes(len(bytes, i8)/bytes_of(kind), self%width)//padded_bytes(bytes)
    if (of_file) then
      self%of_file_count = self%of_file_count + 1
      call self%of_file%append(all)
    else
      self%of_variable_count = self%of_variable_count + 1
      call self%of_variable%append(all)
    end if
  end subroutine add_attribute

  subroutine add_text(self, name, text, of_file)
    !! Add a text attribute.
    class(classic_head), intent(inout) :: self
    character(*), intent(in) :: name, text
    logical, intent(in), optional :: of_file       !! absent: belongs to the last variable
    call self%add_attribute(present(of_file), name, letters, text)
  end subroutine add_text

  subroutine add_room(self, name, length)
    !! Reserve room for a text of the file, which `find_text` locates. It is zeros until it is put.
    class(classic_head), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: length
    call self%add_attribute(.true., name, letters, repeat(char(0), length))
    if (.not. allocated(self%text_names)) allocate (self%text_names(0), self%text_places(0), self%text_lengths(0))
    self%text_names = [character(32) :: self%text_names, name]
    self%text_lengths = [self%text_lengths, length]
    self%text_places = [self%text_places, self%of_file%length() - int(padded(int(length, i8)))]
  end subroutine add_room

  subroutine add_wholes(self, name, values, of_file)
    !! Add an attribute of integers.
    class(classic_head), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i4), intent(in) :: values(:)
    logical, intent(in), optional :: of_file       !! absent: belongs to the last variable
    character(4*size(values)) :: bytes
    integer :: i
    do i = 1, size(values)
      bytes(4*i - 3:4*i) = in_bytes(int(values(i), i8), 4)
    end do
    call self%add_attribute(present(of_file), name, wholes, bytes)
  end subroutine add_wholes

  subroutine add_fill(self)
    !! Add the fill value of the last variable.
    class(classic_head), intent(inout) :: self
    call self%add_attribute(.false., '_FillValue', reals, in_bytes(transfer(missing, 0_i8), 8))
  end subroutine add_fill

  subroutine lay_out(self, bytes)
    !! Assign offsets to all variables and texts of the file.
    class(classic_head), intent(inout) :: self
    character(:), allocatable, intent(out) :: bytes      !! the head, as at the beginning of the file
    type(text_builder) :: dimensions
    integer :: before, v
    call self%end_variable()
    do v = 1, size(self%lengths)
      call dimensions%append(name_bytes(trim(self%dimension_names(v)), self%width)//in_bytes(int(self%lengths(v), i8), self%width))
    end do
    bytes = 'CDF'//char(merge(2, 5, self%width == 4))//in_bytes(0_i8, self%width)// &       ! no record dimension
            list_bytes(list_of_dimensions, size(self%lengths), self%width)//dimensions%text()// &
            list_bytes(list_of_attributes, self%of_file_count, self%width)
    if (allocated(self%text_places)) self%text_places = self%text_places + len(bytes)
    bytes = bytes//self%of_file%text()//list_bytes(list_of_variables, self%count, self%width)
    before = len(bytes)
    bytes = bytes//self%all_variables%text()
    self%bytes = len(bytes)
    do v = 1, self%count
      associate (variable => self%variables(v), at => before + self%variables(v)%at)
        variable%place = self%bytes
        bytes(at + 1:at + 8) = in_bytes(variable%place, 8)
        self%bytes = self%bytes + padded(variable%count*variable%width)
      end associate
    end do
  end subroutine lay_out

  pure subroutine find_text(self, name, place, length)
    !! Find the offset and length of a text of the file that may change.
    class(classic_head), intent(in) :: self
    character(*), intent(in) :: name
    integer(i8), intent(out) :: place
    integer, intent(out) :: length
    integer :: i
    i = findloc(self%text_names == name, .true., dim=1)
    place = self%text_places(i)
    length = self%text_lengths(i)
  end subroutine find_text

  pure subroutine blank_texts(self, bytes)
    !! Reset the changeable texts in the head of a file.
    class(classic_head), intent(in) :: self
    character(*), intent(inout) :: bytes
    integer :: i
    if (.not. allocated(self%text_places)) return
    do i = 1, size(self%text_places)
      bytes(self%text_places(i) + 1:self%text_places(i) + self%text_lengths(i)) = repeat(char(0), self%text_lengths(i))
    end do
  end subroutine blank_texts

  pure integer(i8) function padded(bytes)
    !! Round a number of bytes up to words of four.
    integer(i8), intent(in) :: bytes
    padded = 4*((bytes + 3)/4)
  end function padded

  pure function padded_bytes(bytes) result(all)
    !! Pad bytes with zeros to words of four.
    character(*), intent(in) :: bytes
    character(:), allocatable :: all
    all = bytes//repeat(char(0), int(padded(len(bytes, i8))) - len(bytes))
  end function padded_bytes

  pure function in_bytes(number, width) result(bytes)
    !! Return an integer in so many bytes, big-endian.
    integer(i8), intent(in) :: number
    integer, intent(in) :: width
    character(width) :: bytes
    integer :: i
    do i = 1, width
      bytes(i:i) = char(iand(shiftr(number, 8*(width - i)), 255_i8))
    end do
  end function in_bytes

  pure function name_bytes(name, width) result(bytes)
    !! Return a name, preceded by its length.
    character(*), intent(in) :: name
    integer, intent(in) :: width
    character(:), allocatable :: bytes
    bytes = in_bytes(len(name, i8), width)//padded_bytes(name)
  end function name_bytes

  pure function list_bytes(tag, count, width) result(bytes)
    !! Return the beginning of a list.
    integer, intent(in) :: tag, count, width
    character(:), allocatable :: bytes
    bytes = in_bytes(int(merge(tag, 0, count > 0), i8), 4)//in_bytes(int(count, i8), width)
  end function list_bytes

end module bw_classic_head
