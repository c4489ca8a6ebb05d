module bw_classic_file
  !! A classic NetCDF file whose numbers have known places, so that any process can put its own or read those of others,
  !! by variable or by case.
  use bw_classic_head, only: classic_head
  use bw_kinds, only: dp, i8
  use bw_number_file, only: number_file
  use bw_text, only: fitted
  implicit none (type, external)
  private

  integer, parameter :: small_row = 512              !! numbers of a case below which neighbouring cases are read together
  integer(i8), parameter :: at_once = 262144         !! bytes copied at a time, or those of a case

  type, public :: classic_file
    type(classic_head) :: head
    type(number_file) :: file
  contains
    procedure :: variable, length_of, place_of, get, get_column, copy_rows, set_text, get_text
  end type classic_file

contains

  pure integer function variable(self, name) result(v)
    !! Return the number of a variable; 0 if the file has none of that name.
    class(classic_file), intent(in) :: self
    character(*), intent(in) :: name
    do v = self%head%count, 1, -1
      if (self%head%variables(v)%name == name) return
    end do
  end function variable

  pure integer function length_of(self, dimension) result(length)
    !! Return the length of a dimension; 0 if the file has none of that name.
    class(classic_file), intent(in) :: self
    character(*), intent(in) :: dimension
    length = sum(pack(self%head%lengths, self%head%dimension_names == dimension))
  end function length_of

  pure integer(i8) function place_of(self, variable, case) result(place)
    !! Return the offset of a variable's numbers, or of those of a case if it depends on the case.
    class(classic_file), intent(in) :: self
    integer, intent(in) :: variable          !! its number
    integer(i8), intent(in) :: case          !! from 1
    place = self%head%variables(variable)%place + (case - 1)*self%head%variables(variable)%step
  end function place_of

  function get(self, name, case) result(values)
    !! Get the numbers of a variable, or those of a case if it depends on the case, as stored.
    class(classic_file), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(in) :: case
    real(dp), allocatable :: values(:)
    integer :: v
    v = self%variable(name)
    allocate (values(self%head%variables(v)%room))
    call self%file%get_numbers(self%place_of(v, case), self%head%variables(v)%width, values)
  end function get

  subroutine get_column(self, variable, element, first, values)
    !! Get one of the numbers that a variable has in each of several consecutive cases.
    class(classic_file), intent(inout) :: self
    integer, intent(in) :: variable          !! its number
    integer, intent(in) :: element           !! index of the number, from 1
    integer(i8), intent(in) :: first         !! case
    real(dp), intent(out), contiguous :: values(:)
    real(dp), allocatable :: all(:)
    integer :: i
    associate (n => self%head%variables(variable)%room, width => self%head%variables(variable)%width)
      if (n <= small_row) then
        allocate (all(n*size(values)))
        call self%file%get_numbers(self%place_of(variable, first), width, all)
        values = all(element::n)
      else
        do i = 1, size(values)
          call self%file%get_numbers(self%place_of(variable, first + i - 1) + (element - 1)*width, width, values(i:i))
        end do
      end if
    end associate
  end subroutine get_column

  subroutine copy_rows(self, other, variable, cases)
    !! Copy a variable's numbers or letters in some cases from another file of the same layout. They are written with
    !! the file.
    class(classic_file), intent(inout) :: self, other
    integer, intent(in) :: variable          !! its number
    integer, intent(in) :: cases(:)          !! ascending
    character(:), allocatable :: theirs
    integer(i8) :: from
    integer :: i, first, last
    call self%file%hold()
    associate (step => self%head%variables(variable)%step)
      last = 0
      do while (last < size(cases))
        first = last + 1
        last = last + count(cases(first:) < cases(first) + max(1_i8, at_once/step))
        theirs = repeat(' ', int(step*(cases(last) - cases(first) + 1)))
        call other%file%get_text(self%place_of(variable, int(cases(first), i8)), theirs)
        do i = first, last
          from = step*(cases(i) - cases(first))
          call self%file%put_text(self%place_of(variable, int(cases(i), i8)), theirs(from + 1:from + step))
        end do
      end do
    end associate
  end subroutine copy_rows

  subroutine set_text(self, name, text)
    !! Put a text of the file into its reserved room, cut if it is longer.
    class(classic_file), intent(inout) :: self
    character(*), intent(in) :: name, text
    integer(i8) :: place
    integer :: length
    call self%head%find_text(name, place, length)
    call self%file%put_text(place, fitted(text, length))
  end subroutine set_text

  subroutine get_text(self, name, text)
    !! Get a text of the file that has reserved room.
    class(classic_file), intent(inout) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(out) :: text
    integer(i8) :: place
    integer :: length
    call self%head%find_text(name, place, length)
    allocate (character(length) :: text)
    call self%file%get_text(place, text)
    text = text(:index(text//char(0), char(0)) - 1)
  end subroutine get_text

end module bw_classic_file
