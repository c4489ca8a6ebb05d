module bw_number_scan
  !! Numbers parsed in place in a text: fast, and correctly rounded to double precision.
  !!
  !! A mantissa below 2⁵³ and a power of ten up to 22 are both exact in double precision, so that one product or quotient is
  !! correctly rounded (Clinger, How to read floating point numbers accurately, 1990). A longer mantissa of up to 18 digits takes
  !! quadruple precision, where the product is exact. The quotient is exactly midway between two doubles, or its relative distance
  !! from a midpoint is at least 2⁻¹⁰⁶, which rounding to 113 bits does not cross. C's `strtod` parses all other numbers.
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_loc, c_null_char, c_ptr
  use bw_kinds, only: dp, i1, i8, qp
  implicit none (type, external)
  private
  public :: largest_power, scan_number

  integer(i1), parameter :: zero = iachar('0', i1), nine = iachar('9', i1), plus = iachar('+', i1), minus = iachar('-', i1)
  integer(i1), parameter :: letters(*) = iachar(['e', 'E', 'd', 'D'], i1)
  integer, parameter :: exact_power = 22, most_digits = 18
  integer(i8), parameter :: exact_mantissa = 2_i8**53
  integer, parameter :: largest_exponent = 99999           !! larger exponents count as this one
  integer, parameter :: largest_power = 308                !! numbers are below ten to this power
  integer :: i
  real(dp), parameter :: tens(0:exact_power) = [(10.0_dp**i, i=0, exact_power)]

  interface
    pure real(c_double) function strtod(text, behind) bind(c, name='strtod')
      !! C's parser; it ends at the first character after the number.
      import :: c_double, c_ptr
      implicit none (type, external)
      type(c_ptr), value :: text, behind
    end function strtod
  end interface

contains

  pure subroutine scan_number(bytes, at, last, mark, value, decade, power, good)
    !! Parse `[sign] digits [mark digits] [e|d [sign] digits]` at a position. A number of 1e308 or more, near overflow,
    !! is not good.
    integer(i1), intent(in) :: bytes(:)
    integer, intent(inout) :: at               !! first byte; on return the one after the number
    integer, intent(in) :: last                !! last byte of the line
    integer(i1), intent(in) :: mark            !! decimal mark
    real(dp), intent(out) :: value
    integer, intent(out) :: decade             !! power of ten of the last digit
    integer, intent(out) :: power              !! the number is below ten to this power; 0 for 0
    logical, intent(out) :: good
    integer(i8) :: mantissa
    integer :: first, digits, exponent
    logical :: negative
    first = at
    value = 0.0_dp
    decade = 0
    power = 0
    mantissa = 0
    digits = 0
    negative = .false.
    good = at <= last
    if (.not. good) return
    negative = bytes(at) == minus
    if (negative .or. bytes(at) == plus) at = at + 1
    exponent = at
    call scan_digits(bytes, at, last, mantissa, digits)
    exponent = at - exponent                   ! number of digits, for now; they may be zeros
    if (at <= last) then
      if (bytes(at) == mark) then
        at = at + 1
        decade = at
        call scan_digits(bytes, at, last, mantissa, digits)
        decade = decade - at
      end if
    end if
    good = exponent - decade > 0
    if (.not. good) return
    exponent = 0
    if (at <= last) call scan_exponent(bytes, at, last, exponent, good)
    if (.not. good) return
    decade = decade + exponent
    if (digits == 0) return
    power = digits + decade
    good = power <= largest_power
    if (.not. good) return
    if (digits > most_digits .or. abs(decade) > exact_power) then
      value = by_library(bytes(first:at - 1), mark)
      return
    else if (mantissa > exact_mantissa) then
      if (decade < 0) value = real(real(mantissa, qp)/tens(-decade), dp)
      if (decade >= 0) value = real(real(mantissa, qp)*tens(decade), dp)
    else
      value = real(mantissa, dp)
      if (decade < 0) value = value/tens(-decade)
      if (decade > 0) value = value*tens(decade)
    end if
    if (negative) value = -value
  end subroutine scan_number

  pure subroutine scan_digits(bytes, at, last, mantissa, digits)
    !! Parse digits; leading zeros do not count.
    integer(i1), intent(in) :: bytes(:)
    integer, intent(inout) :: at
    integer, intent(in) :: last
    integer(i8), intent(inout) :: mantissa     !! invalid with more than `most_digits`
    integer, intent(inout) :: digits
    integer :: digit
    do while (at <= last)
      digit = int(bytes(at)) - zero            ! bytes above 127 are negative
      if (digit < 0 .or. digit > 9) return
      at = at + 1
      if (digits == 0 .and. digit == 0) cycle
      digits = digits + 1
      if (digits <= most_digits) mantissa = 10*mantissa + digit
    end do
  end subroutine scan_digits

  pure subroutine scan_exponent(bytes, at, last, exponent, good)
    !! Parse an exponent such as `e-3`, if present.
    integer(i1), intent(in) :: bytes(:)
    integer, intent(inout) :: at
    integer, intent(in) :: last
    integer, intent(out) :: exponent
    logical, intent(inout) :: good             !! digits follow the letter
    logical :: negative
    integer :: first
    exponent = 0
    if (.not. any(bytes(at) == letters)) return
    at = at + 1
    negative = .false.
    if (at <= last) then
      negative = bytes(at) == minus
      if (negative .or. bytes(at) == plus) at = at + 1
    end if
    first = at
    do while (at <= last)
      if (bytes(at) < zero .or. bytes(at) > nine) exit
      exponent = min(10*exponent + (bytes(at) - zero), largest_exponent)
      at = at + 1
    end do
    good = at > first
    if (negative) exponent = -exponent
  end subroutine scan_exponent

  pure real(dp) function by_library(bytes, mark) result(value)
    !! Parse by C's `strtod`, with e for the exponent letter and a point as decimal mark.
    integer(i1), intent(in) :: bytes(:)
    integer(i1), intent(in) :: mark
    character(kind=c_char), target :: text(size(bytes) + 1)
    integer :: i
    do i = 1, size(bytes)
      text(i) = achar(bytes(i))
      if (bytes(i) == mark) text(i) = '.'
      if (any(bytes(i) == letters)) text(i) = 'e'
    end do
    text(size(text)) = c_null_char
    value = strtod(c_loc(text), transfer(0_i8, c_loc(text)))
  end function by_library

end module bw_number_scan
