module funit_numbers
  !! Numbers of any kind and rank in one type, for assertions that treat them alike.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64, real128
  implicit none (type, external)
  private
  public :: numbers_of, text_of

  type, public :: numbers_type
    !! A scalar or an array. Binary128 holds every binary64 and every 64-bit integer.
    real(real128), allocatable :: list(:)  !! the elements in array order; one for a scalar
    integer, allocatable :: extents(:)     !! the shape; of size 0 for a scalar
  contains
    procedure :: fits
    procedure :: place_of
  end type numbers_type

  interface numbers_of
    module procedure :: numbers_of_reals, numbers_of_integers, numbers_of_longs
  end interface numbers_of

contains

  function numbers_of_reals(values) result(numbers)
    real(real64), intent(in) :: values(..)
    type(numbers_type) :: numbers
    include 'flatten.inc'
  end function numbers_of_reals

  function numbers_of_integers(values) result(numbers)
    integer(int32), intent(in) :: values(..)
    type(numbers_type) :: numbers
    include 'flatten.inc'
  end function numbers_of_integers

  function numbers_of_longs(values) result(numbers)
    integer(int64), intent(in) :: values(..)
    type(numbers_type) :: numbers
    include 'flatten.inc'
  end function numbers_of_longs

  pure logical function fits(self, other)
    !! Whether this is a scalar, or an array of the other's shape.
    class(numbers_type), intent(in) :: self
    type(numbers_type), intent(in) :: other
    fits = size(self%extents) == 0
    if (size(self%extents) == size(other%extents)) fits = all(self%extents == other%extents)
  end function fits

  pure function place_of(self, position) result(text)
    !! ` at index (3,1)` for a position in the list; nothing for a scalar.
    class(numbers_type), intent(in) :: self
    integer, intent(in) :: position
    character(:), allocatable :: text
    integer :: rest, d
    text = ''
    if (size(self%extents) == 0) return
    rest = position - 1
    text = ' at index ('
    do d = 1, size(self%extents)
      if (d > 1) text = text//','
      text = text//text_of(real(1 + modulo(rest, self%extents(d)), real128))
      rest = rest/self%extents(d)
    end do
    text = text//')'
  end function place_of

  pure function text_of(value) result(text)
    !! Whole numbers without a point, others with 17 digits.
    real(real128), intent(in) :: value
    character(:), allocatable :: text
    character(24) :: buffer
    if (ieee_is_finite(value) .and. abs(value) < 2.0_real128**63 .and. value == aint(value)) then
      write (buffer, '(i0)') int(value, int64)
    else
      write (buffer, '(es24.16e3)') real(value, real64)
    end if
    text = trim(adjustl(buffer))
  end function text_of

end module funit_numbers
