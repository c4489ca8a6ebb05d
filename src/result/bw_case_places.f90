module bw_case_places
  !! Where in a file the numbers of a sweep's cases lie, field by field.
  use, intrinsic :: iso_c_binding, only: c_loc
  use bw_case_fields, only: case_field, case_length, fields_of, short_fields
  use bw_descriptor, only: close_descriptor, open_to_read, read_bytes_at
  use bw_hdf5_offsets, only: data_offsets
  use bw_kinds, only: dp, i4, i8
  use bw_result_layout, only: result_layout
  implicit none (type, external)
  private
  public :: mark_of

  type, public :: case_places
    type(case_field), allocatable :: fields(:)
    integer(i8), allocatable :: begins(:)       !! bytes, from 0, of each field of the first case; unallocated: not known
    integer(i8) :: cases = 0
    integer :: short = 0                        !! how many fields are not long
  contains
    procedure :: plan
    procedure :: has_long
    procedure :: find
    procedure :: forget
    procedure :: known
    procedure :: case_length => numbers_of_case
    procedure :: short_length
    procedure :: bytes_of
    procedure :: place_of
    procedure, private :: is_marked
  end type case_places

contains

  pure real(dp) function mark_of(i) result(mark)
    !! What the last case of a head holds in its i-th field, here and as an integer.
    integer, intent(in) :: i
    mark = -987654321 - i
  end function mark_of

  pure subroutine plan(self, layout)
    !! The fields, whose places are not known yet.
    class(case_places), intent(inout) :: self
    type(result_layout), intent(in) :: layout
    allocate (self%fields, source=fields_of(layout))
    self%short = short_fields(self%fields)
    self%cases = layout%cases
  end subroutine plan

  subroutine find(self, head)
    !! The places of all fields, or of none where HDF5 does not tell.
    class(case_places), intent(inout) :: self
    character(*), intent(in) :: head            !! path of a file that has them
    integer :: file, i
    logical :: sound
    file = open_to_read(head)
    if (file < 0) return
    self%begins = data_offsets(head, self%fields%name)
    sound = all(self%begins > 0)
    do i = 1, size(self%fields)
      if (sound) sound = self%is_marked(file, i)
    end do
    if (.not. sound) call self%forget()
    call close_descriptor(file)
  end subroutine find

  logical function is_marked(self, file, i)
    !! The last number of a field is the mark that NetCDF has put there.
    class(case_places), intent(in) :: self
    integer, intent(in) :: file, i
    integer(i8) :: last
    real(dp), target :: number
    integer(i4), target :: whole
    last = self%place_of(i, self%cases + 1)
    if (self%fields(i)%is_integer) then
      is_marked = read_bytes_at(file, last - self%bytes_of(i), c_loc(whole), self%bytes_of(i))
      if (is_marked) is_marked = whole == nint(mark_of(i))
    else
      is_marked = read_bytes_at(file, last - self%bytes_of(i), c_loc(number), self%bytes_of(i))
      if (is_marked) is_marked = number == mark_of(i)
    end if
  end function is_marked

  pure logical function has_long(self)
    !! Some field is long.
    class(case_places), intent(in) :: self
    has_long = self%short < size(self%fields)
  end function has_long

  pure subroutine forget(self)
    !! The places are not to be used.
    class(case_places), intent(inout) :: self
    if (allocated(self%begins)) deallocate (self%begins)
  end subroutine forget

  pure logical function known(self)
    !! Cases can be put into their places.
    class(case_places), intent(in) :: self
    known = allocated(self%begins)
  end function known

  pure integer(i8) function numbers_of_case(self) result(numbers)
    !! All numbers of a case.
    class(case_places), intent(in) :: self
    numbers = case_length(self%fields)
  end function numbers_of_case

  pure integer(i8) function short_length(self) result(numbers)
    !! Those of fields that are not long.
    class(case_places), intent(in) :: self
    numbers = case_length(self%fields(:self%short))
  end function short_length

  pure integer(i8) function bytes_of(self, i) result(bytes)
    !! One number of a field.
    class(case_places), intent(in) :: self
    integer, intent(in) :: i
    bytes = merge(4, 8, self%fields(i)%is_integer)
  end function bytes_of

  pure integer(i8) function place_of(self, i, index) result(place)
    !! Where a field of a case begins in the file, bytes from 0.
    class(case_places), intent(in) :: self
    integer, intent(in) :: i
    integer(i8), intent(in) :: index
    place = self%begins(i) + (index - 1)*self%fields(i)%length*self%bytes_of(i)
  end function place_of

end module bw_case_places
