module funit_lists
  !! Numbers of any kind and rank as one flat list, and an element's place and value as text.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64, real128
  implicit none (type, external)
  private
  public :: list_of, place_of, text_of

  interface list_of
    !! The elements in array order; one element for a scalar.
    module procedure :: list_of_reals, list_of_integers, list_of_longs
  end interface list_of

contains

  function list_of_reals(values) result(list)
    real(real64), intent(in) :: values(..)
    real(real128), allocatable :: list(:)
    include 'flatten.inc'
  end function list_of_reals

  function list_of_integers(values) result(list)
    integer(int32), intent(in) :: values(..)
    real(real128), allocatable :: list(:)
    include 'flatten.inc'
  end function list_of_integers

  function list_of_longs(values) result(list)
    integer(int64), intent(in) :: values(..)
    real(real128), allocatable :: list(:)
    include 'flatten.inc'
  end function list_of_longs

  pure function place_of(position, extents) result(text)
    !! ` at index (3,1)` for a position in array order; nothing for a scalar.
    integer, intent(in) :: position      !! 1 … product(extents)
    integer, intent(in) :: extents(:)    !! the array's shape, of size 0 for a scalar
    character(:), allocatable :: text
    integer :: rest, d
    text = ''
    if (size(extents) == 0) return
    rest = position - 1
    text = ' at index ('
    do d = 1, size(extents)
      if (d > 1) text = text//','
      text = text//text_of(real(1 + modulo(rest, extents(d)), real128))
      rest = rest/extents(d)
    end do
    text = text//')'
  end function place_of

  pure function text_of(value) result(text)
    !! Whole numbers without a point, others with 17 digits.
    real(real128), intent(in) :: value
    character(:), allocatable :: text
    character(40) :: buffer
    if (ieee_is_finite(value) .and. abs(value) < 2.0_real128**63 .and. value == aint(value)) then
      write (buffer, '(i0)') int(value, int64)
    else
      write (buffer, '(es24.16e3)') real(value, real64)
    end if
    text = trim(adjustl(buffer))
  end function text_of

end module funit_lists
