module bw_late_values
  !! Values that are written once a whole file is defined: a change between defining and writing costs NetCDF-4 a pass over
  !! all that is there.
  use bw_error, only: error_type
  use bw_kinds, only: dp
  use bw_netcdf, only: check
  use netcdf, only: nf90_put_var
  implicit none (type, external)
  private

  integer, parameter :: at_once = 65536           !! numbers of a variable in memory

  type :: late_value
    integer :: variable = 0
    logical :: is_scalar = .false.
    integer :: count = 0                          !! how many numbers it holds
    real(dp), allocatable :: values(:)            !! all of them, or what they run through again and again, …
    integer :: each = 1                           !! … each so many times in a row; 0: they count from 1
  end type late_value

  type, public :: late_values
    private
    integer :: count = 0
    type(late_value), allocatable :: list(:)
  contains
    procedure :: add
    procedure :: add_repeated
    procedure :: add_numbers
    procedure :: put_all
    procedure, private :: append
  end type late_values

contains

  pure subroutine add(self, variable, values, is_scalar)
    !! Keep what a variable will hold; integers as reals, which hold them exactly.
    class(late_values), intent(inout) :: self
    integer, intent(in) :: variable               !! NetCDF's number
    real(dp), intent(in) :: values(:)
    logical, intent(in), optional :: is_scalar    !! the variable has no dimension
    type(late_value) :: late
    late%variable = variable
    late%count = size(values)
    allocate (late%values, source=values)
    if (present(is_scalar)) late%is_scalar = is_scalar
    call self%append(late)
  end subroutine add

  pure subroutine add_repeated(self, variable, values, each, count)
    !! A variable that runs through some values again and again, each several times in a row: they are made as they are
    !! written, so that they may be many.
    class(late_values), intent(inout) :: self
    integer, intent(in) :: variable               !! NetCDF's number
    real(dp), intent(in) :: values(:)
    integer, intent(in) :: each                   !! times in a row
    integer, intent(in) :: count                  !! of all
    type(late_value) :: late
    late%variable = variable
    late%count = count
    late%each = each
    allocate (late%values, source=values)
    call self%append(late)
  end subroutine add_repeated

  pure subroutine add_numbers(self, variable, count)
    !! A variable that counts from 1.
    class(late_values), intent(inout) :: self
    integer, intent(in) :: variable               !! NetCDF's number
    integer, intent(in) :: count
    type(late_value) :: late
    late%variable = variable
    late%count = count
    late%each = 0
    call self%append(late)
  end subroutine add_numbers

  pure subroutine append(self, late)
    class(late_values), intent(inout) :: self
    type(late_value), intent(in) :: late
    type(late_value), allocatable :: longer(:)
    if (.not. allocated(self%list)) allocate (self%list(50))
    if (self%count == size(self%list)) then
      allocate (longer(2*self%count))
      longer(:self%count) = self%list
      call move_alloc(longer, self%list)
    end if
    self%count = self%count + 1
    self%list(self%count) = late
  end subroutine append

  subroutine put_all(self, file, path, error)
    !! Write all of them.
    class(late_values), intent(in) :: self
    integer, intent(in) :: file                   !! NetCDF's number
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    integer :: first, i, n
    do i = 1, self%count
      associate (late => self%list(i))
        if (late%is_scalar .and. .not. allocated(error)) then
          call check(nf90_put_var(file, late%variable, late%values(1)), path, error)
          cycle
        end if
        do first = 1, late%count, at_once
          if (allocated(error)) return
          n = min(at_once, late%count - first + 1)
          call check(nf90_put_var(file, late%variable, part_of(late, first, n), start=[first], count=[n]), path, error)
        end do
      end associate
    end do
  end subroutine put_all

  pure function part_of(late, first, n) result(values)
    !! Some of the numbers of a variable.
    type(late_value), intent(in) :: late
    integer, intent(in) :: first, n
    real(dp) :: values(n)
    integer :: i
    if (late%each == 0) then
      values = [(real(first + i, dp), i=0, n - 1)]
    else
      values = [(late%values(mod((first - 1 + i)/late%each, size(late%values)) + 1), i=0, n - 1)]
    end if
  end function part_of

end module bw_late_values
