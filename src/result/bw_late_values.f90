module bw_late_values
  !! Values that are written once a whole file is defined: a change between defining and writing costs NetCDF-4 a pass over
  !! all that is there.
  use bw_error, only: error_type
  use bw_kinds, only: dp
  use bw_netcdf, only: check
  use netcdf, only: nf90_put_var
  implicit none (type, external)
  private

  type :: late_value
    integer :: variable = 0
    logical :: is_scalar = .false.
    real(dp), allocatable :: values(:)
  end type late_value

  type, public :: late_values
    private
    integer :: count = 0
    type(late_value), allocatable :: list(:)
  contains
    procedure :: add
    procedure :: put_all
  end type late_values

contains

  pure subroutine add(self, variable, values, is_scalar)
    !! Keep what a variable will hold; integers as reals, which hold them exactly.
    class(late_values), intent(inout) :: self
    integer, intent(in) :: variable               !! NetCDF's number
    real(dp), intent(in) :: values(:)
    logical, intent(in), optional :: is_scalar    !! the variable has no dimension
    type(late_value), allocatable :: longer(:)
    if (.not. allocated(self%list)) allocate (self%list(50))
    if (self%count == size(self%list)) then
      allocate (longer(2*self%count))
      longer(:self%count) = self%list
      call move_alloc(longer, self%list)
    end if
    self%count = self%count + 1
    associate (last => self%list(self%count))
      last%variable = variable
      allocate (last%values, source=values)
      if (present(is_scalar)) last%is_scalar = is_scalar
    end associate
  end subroutine add

  subroutine put_all(self, file, path, error)
    !! Write all of them.
    class(late_values), intent(in) :: self
    integer, intent(in) :: file                   !! NetCDF's number
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    do i = 1, self%count
      if (allocated(error)) return
      associate (late => self%list(i))
        if (late%is_scalar) then
          call check(nf90_put_var(file, late%variable, late%values(1)), path, error)
        else
          call check(nf90_put_var(file, late%variable, late%values), path, error)
        end if
      end associate
    end do
  end subroutine put_all

end module bw_late_values
