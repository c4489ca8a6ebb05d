module bw_result_body
  !! The result of a sweep with long histories, whose numbers are written straight into their places.
  !!
  !! The head is a NetCDF file of the result without its cases: names, attributes, coordinates, inputs, and room for the
  !! numbers, which takes none of the disk. It is made once, gets its name when it is whole, and is never changed. Where the
  !! numbers of each field lie in it is asked of HDF5, and proved by marks. The body is the result under way: numbers of cases
  !! at the same places, written by any process on this machine, no library having it open. In the end what lies between the
  !! places is copied there from the head.
  !!
  !! A kill loses nothing, whenever it comes. The long fields of a case lie with the system before its record is written to a
  !! journal, and the record holds their checksum: there is either a record and all that belongs to it, or a case that is
  !! done again and puts the same bits into the same places. Short fields are in the record itself. What comes between the
  !! places is copied from the head again by whoever goes on. After a machine has crashed, checksums tell which cases arrived.
  use, intrinsic :: iso_c_binding, only: c_loc, c_ptr
  use bw_case_block, only: case_block
  use bw_case_fields, only: long_values
  use bw_case_places, only: case_places
  use bw_case_result, only: case_result
  use bw_descriptor, only: bytes_in_file, close_descriptor, copy_bytes, open_to_change, open_to_read, read_bytes_at, &
    set_length, write_bytes_at
  use bw_error, only: error_type, fail, fail_to_write, status_bad_file
  use bw_kinds, only: dp, i4, i8
  use bw_missing, only: missing
  use bw_word_file, only: as_words, checksum
  implicit none (type, external)
  private

  type, extends(case_places), public :: result_body
    character(:), allocatable :: path
    integer, private :: descriptor = -1
  contains
    procedure :: open => open_body
    procedure :: close => close_body
    procedure :: put_long
    procedure :: put_long_numbers
    procedure :: get_long_numbers
    procedure :: has_all
    procedure :: put_block
    procedure :: complete
    procedure, private :: put_numbers
  end type result_body

contains

  subroutine open_body(self, path, error)
    !! Open the result under way, or begin it.
    !! **Errors**: it cannot be written.
    class(result_body), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    self%path = path
    self%descriptor = open_to_change(path)
    if (self%descriptor < 0) call fail_to_write(error, path)
  end subroutine open_body

  subroutine close_body(self)
    class(result_body), intent(inout) :: self
    call close_descriptor(self%descriptor)
    self%descriptor = -1
  end subroutine close_body

  subroutine put_long(self, index, result, total, error)
    !! The long fields of a case, from where they lie.
    !! **Errors**: they cannot be written.
    class(result_body), intent(in) :: self
    integer(i8), intent(in) :: index            !! of the case
    type(case_result), intent(in), target :: result
    integer(i8), intent(out) :: total           !! their checksum
    type(error_type), allocatable, intent(inout) :: error
    real(dp), allocatable, target :: none(:)
    real(dp), pointer, contiguous :: values(:)
    integer :: i
    total = 0
    do i = self%short + 1, size(self%fields)
      call long_values(result, self%fields(i), values)
      if (.not. associated(values)) then
        if (allocated(none)) deallocate (none)
        allocate (none(self%fields(i)%length), source=missing)
        values => none
      end if
      call self%put_numbers(i, index, values, error)
      total = joined(total, values)
    end do
  end subroutine put_long

  subroutine put_long_numbers(self, index, numbers, error)
    !! The long fields of a case as a journal holds them.
    !! **Errors**: they cannot be written.
    class(result_body), intent(in) :: self
    integer(i8), intent(in) :: index
    real(dp), intent(in), contiguous :: numbers(:)           !! all of the case
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    do i = self%short + 1, size(self%fields)
      associate (first => self%fields(i)%first, length => self%fields(i)%length)
        call self%put_numbers(i, index, numbers(first:first + length - 1), error)
      end associate
    end do
  end subroutine put_long_numbers

  subroutine get_long_numbers(self, index, numbers, total, done)
    !! What lies in the places of a case.
    class(result_body), intent(in) :: self
    integer(i8), intent(in) :: index
    real(dp), intent(inout), contiguous, target :: numbers(:)   !! all of the case: the long fields are set
    integer(i8), intent(out) :: total           !! their checksum
    logical, intent(out) :: done                !! false where they are not there
    integer :: i
    total = 0
    done = .true.
    do i = self%short + 1, size(self%fields)
      associate (first => self%fields(i)%first, length => self%fields(i)%length)
        if (done) done = read_bytes_at(self%descriptor, self%place_of(i, index), c_loc(numbers(first)), length*self%bytes_of(i))
        if (done) total = joined(total, numbers(first:first + length - 1))
      end associate
    end do
  end subroutine get_long_numbers

  logical function has_all(self, index, count, total, numbers)
    !! Whether those numbers of a case that are not in its record lie in their places, as they were written.
    class(result_body), intent(in) :: self
    integer(i8), intent(in) :: index
    integer(i8), intent(in) :: count            !! how many
    integer(i8), intent(in) :: total            !! their checksum
    real(dp), intent(inout), contiguous :: numbers(:)   !! all of the case: the long fields are set
    integer(i8) :: now
    has_all = count == 0
    if (has_all .or. .not. self%known()) return
    if (count /= size(numbers, kind=i8) - self%short_length()) return
    call self%get_long_numbers(index, numbers, now, has_all)
    has_all = has_all .and. now == total
  end function has_all

  subroutine put_numbers(self, i, index, numbers, error)
    !! One field of a case or of several.
    class(result_body), intent(in) :: self
    integer, intent(in) :: i
    integer(i8), intent(in) :: index            !! of the first case
    real(dp), intent(in), contiguous, target :: numbers(:)
    type(error_type), allocatable, intent(inout) :: error
    integer(i4), allocatable, target :: whole(:)
    type(c_ptr) :: address
    if (allocated(error)) return
    address = c_loc(numbers)
    if (self%fields(i)%is_integer) then
      allocate (whole, source=int(numbers, i4))
      address = c_loc(whole)
    end if
    if (.not. write_bytes_at(self%descriptor, self%place_of(i, index), address, size(numbers, kind=i8)*self%bytes_of(i))) &
      call fail_to_write(error, self%path)
  end subroutine put_numbers

  integer(i8) function joined(total, numbers)
    !! A checksum with that of one more field.
    integer(i8), intent(in) :: total
    real(dp), intent(in), contiguous, target :: numbers(:)
    joined = ieor(ishftc(total, 1), checksum(as_words(numbers)))
  end function joined

  subroutine put_block(self, first, block, error)
    !! The short fields of consecutive cases.
    !! **Errors**: they cannot be written.
    class(result_body), intent(in) :: self
    integer(i8), intent(in) :: first            !! number of the first of them
    type(case_block), intent(in) :: block
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    do i = 1, self%short
      associate (begin => block%begin_of(self%fields(i)), length => self%fields(i)%length*block%held)
        call self%put_numbers(i, first, block%numbers(begin:begin + length - 1), error)
      end associate
    end do
  end subroutine put_block

  subroutine complete(self, head, error)
    !! All that is not a case's comes from the head: the body is a NetCDF file.
    !! **Errors**: it cannot be written.
    class(result_body), intent(in) :: self
    character(*), intent(in) :: head            !! its path
    type(error_type), allocatable, intent(inout) :: error
    integer(i8) :: position, next, length
    integer :: file, i
    logical :: left(size(self%fields)), done
    if (allocated(error)) return
    file = open_to_read(head)
    if (file < 0) then
      call fail(error, status_bad_file, head//': cannot be read: is it gone?')
      return
    end if
    length = bytes_in_file(file)
    done = length > 0
    position = 0
    left = .true.
    do while (done)
      i = minloc(self%begins, dim=1, mask=left)
      next = length
      if (i > 0) next = self%begins(i)
      done = copy_bytes(file, self%descriptor, position, next - position)
      if (i == 0) exit
      position = self%place_of(i, self%cases + 1)
      left(i) = .false.
    end do
    if (done) done = set_length(self%descriptor, length)
    if (.not. done) call fail_to_write(error, self%path)
    call close_descriptor(file)
  end subroutine complete

end module bw_result_body
