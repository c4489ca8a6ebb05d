module bw_double_double
  !! Numbers as unevaluated sums of two binary64 numbers, about 32 digits, at a few flops an operation.
  !!
  !! Used if one number per mode needs more digits than binary64: roots, frequencies, phases. Every product must be
  !! rounded separately: compile with `-ffp-contract=off`. Scaling an operand by a power of two scales the result
  !! exactly, within the range \(2^{\pm 900}\).
  !!
  !! **Source**: Dekker (1971), doi:10.1007/BF01397083; Joldes, Muller, Popescu (2017), doi:10.1145/3121432.
  use bw_kinds, only: dp, qp
  implicit none (type, external)
  private
  public :: two_sum, two_product, two_products, accurate_sum, add_exactly, to_dd, to_quad, sqrt
  public :: operator(+), operator(-), operator(*), operator(/), operator(==)

  type, public :: dd
    !! The number hi + lo, |lo| ≤ half a unit in the last place of hi.
    real(dp) :: hi = 0.0_dp
    real(dp) :: lo = 0.0_dp
  end type dd

  real(dp), parameter, public :: rounder = 1.5_dp*2.0_dp**52
    !! added and subtracted again it rounds numbers below 2⁵¹ to the nearest integer; `aint` and `anint`, which must not
    !! raise a flag, prevent vectorisation
  type(dd), parameter, public :: dd_pi = dd(3.141592653589793116_dp, 1.224646799147353207e-16_dp)

  interface to_dd
    module procedure :: dd_from_real, dd_from_quad
  end interface to_dd
  interface operator(+)
    module procedure :: add_dd, add_real, add_to_list, add_reals_to_list
  end interface
  interface operator(-)
    module procedure :: subtract_dd, negate_dd, subtract_from_list
  end interface
  interface operator(*)
    module procedure :: multiply_dd, multiply_real, multiply_list, multiply_lists, multiply_by_reals
  end interface
  interface operator(/)
    module procedure :: divide_dd
  end interface
  interface operator(==)
    module procedure :: same_dd
  end interface
  interface sqrt
    module procedure :: sqrt_dd, sqrt_of_list
  end interface

contains

  elemental subroutine two_sum(a, b, sum, error)
    !! sum + error = a + b exactly (Knuth).
    real(dp), intent(in) :: a, b
    real(dp), intent(out) :: sum, error
    real(dp) :: t
    sum = a + b
    t = sum - a
    error = (a - (sum - t)) + (b - t)
  end subroutine two_sum

  elemental subroutine two_product(a, b, product, error)
    !! product + error = a·b exactly, unless a part of it under- or overflows (Dekker, Veltkamp).
    real(dp), intent(in) :: a, b
    real(dp), intent(out) :: product, error
    real(dp) :: a_hi, a_lo, b_hi, b_lo
    product = a*b
    call split(a, a_hi, a_lo)
    call split(b, b_hi, b_lo)
    error = ((a_hi*b_hi - product) + a_hi*b_lo + a_lo*b_hi) + a_lo*b_lo
  end subroutine two_product

  pure real(dp) function accurate_sum(values) result(total)
    !! Return the sum of many numbers with about one rounding error (Neumaier's compensated sum), as parallel sums of
    !! every eighth number.
    real(dp), intent(in) :: values(:)
    integer, parameter :: lanes = 8
    real(dp), dimension(lanes) :: sums, next, error, lost
    real(dp) :: rest(lanes), total_next, total_error
    integer :: i, whole
    sums = 0.0_dp
    lost = 0.0_dp
    whole = size(values) - mod(size(values), lanes)
    do i = 1, whole, lanes
      call two_sum(sums, values(i:i + lanes - 1), next, error)
      sums = next
      lost = lost + error
    end do
    rest = 0.0_dp
    rest(:size(values) - whole) = values(whole + 1:)
    total = 0.0_dp
    do i = 1, 2*lanes
      call two_sum(total, merge(sums(min(i, lanes)), rest(max(1, i - lanes)), i <= lanes), total_next, total_error)
      total = total_next
      lost(1) = lost(1) + total_error
    end do
    total = total + sum(lost)
  end function accurate_sum

  elemental subroutine split(a, hi, lo)
    !! Split a number into two halves of 26 bits each.
    real(dp), intent(in) :: a
    real(dp), intent(out) :: hi, lo
    real(dp), parameter :: splitter = 134217729.0_dp   ! 2²⁷ + 1
    real(dp) :: t
    t = splitter*a
    hi = t - (t - a)
    lo = a - hi
  end subroutine split

  elemental type(dd) function normal(hi, lo)
    !! Return hi + lo with parts that do not overlap; |hi| ≥ |lo| or hi = 0.
    real(dp), intent(in) :: hi, lo
    normal%hi = hi + lo
    normal%lo = lo - (normal%hi - hi)
  end function normal

  elemental type(dd) function dd_from_real(value)
    real(dp), intent(in) :: value
    dd_from_real = dd(value, 0.0_dp)
  end function dd_from_real

  elemental type(dd) function dd_from_quad(value)
    real(qp), intent(in) :: value
    dd_from_quad%hi = real(value, dp)
    dd_from_quad%lo = real(value - dd_from_quad%hi, dp)
  end function dd_from_quad

  elemental real(qp) function to_quad(value)
    !! Exact: binary128 holds both parts.
    type(dd), intent(in) :: value
    to_quad = real(value%hi, qp) + real(value%lo, qp)
  end function to_quad

  elemental logical function same_dd(a, b) result(same)
    !! Compare bit by bit; the parts of each number do not overlap.
    type(dd), intent(in) :: a, b
    same = a%hi == b%hi .and. a%lo == b%lo
  end function same_dd

  elemental type(dd) function add_dd(a, b) result(c)
    type(dd), intent(in) :: a, b
    real(dp) :: s, e, t, f
    call two_sum(a%hi, b%hi, s, e)
    call two_sum(a%lo, b%lo, t, f)
    c = normal(s, e + t)
    c = normal(c%hi, c%lo + f)
  end function add_dd

  elemental type(dd) function add_real(a, b) result(c)
    type(dd), intent(in) :: a
    real(dp), intent(in) :: b
    real(dp) :: s, e
    call two_sum(a%hi, b, s, e)
    c = normal(s, e + a%lo)
  end function add_real

  elemental type(dd) function negate_dd(a) result(c)
    type(dd), intent(in) :: a
    c = dd(-a%hi, -a%lo)
  end function negate_dd

  elemental type(dd) function subtract_dd(a, b) result(c)
    type(dd), intent(in) :: a, b
    c = add_dd(a, negate_dd(b))
  end function subtract_dd

  elemental type(dd) function multiply_dd(a, b) result(c)
    type(dd), intent(in) :: a, b
    real(dp) :: p, e
    call two_product(a%hi, b%hi, p, e)
    c = normal(p, e + (a%hi*b%lo + a%lo*b%hi))
  end function multiply_dd

  elemental type(dd) function multiply_real(a, b) result(c)
    type(dd), intent(in) :: a
    real(dp), intent(in) :: b
    real(dp) :: p, e
    call two_product(a%hi, b, p, e)
    c = normal(p, e + a%lo*b)
  end function multiply_real

  elemental type(dd) function divide_dd(a, b) result(c)
    !! b ≠ 0.
    type(dd), intent(in) :: a, b
    real(dp) :: q
    type(dd) :: remainder
    q = a%hi/b%hi
    remainder = subtract_dd(a, multiply_real(b, q))
    c = normal(q, (remainder%hi + remainder%lo)/b%hi)
  end function divide_dd

  elemental type(dd) function sqrt_dd(a) result(c)
    !! a ≥ 0.
    type(dd), intent(in) :: a
    real(dp), parameter :: least = 1.0e-162_dp      ! below the root of any number but 0
    real(dp) :: root
    type(dd) :: remainder
    root = sqrt(max(0.0_dp, a%hi))
    remainder = subtract_dd(a, multiply_real(dd(root, 0.0_dp), root))
    ! no branch, so that it vectorises
    c = normal(root, merge(0.5_dp, 0.0_dp, root > 0.0_dp)*((remainder%hi + remainder%lo)/max(root, least)))
  end function sqrt_dd

  ! Lists: those of these operations that millions of modes need, for arrays of rank one, where they take precedence over the
  ! elemental ones. An elemental procedure of another file is called for every element; here the loop is compiled with its
  ! operation, and vectorised.

  pure subroutine two_products(a, b, product, error)
    !! Apply `two_product` to a list and a number.
    real(dp), intent(in) :: a(:), b
    real(dp), intent(out) :: product(:), error(:)
    integer :: i
    do i = 1, size(a)
      call two_product(a(i), b, product(i), error(i))
    end do
  end subroutine two_products

  pure subroutine add_exactly(terms, sums, lost)
    !! Add one term to each of many sums, and the rounding errors to their corrections (as in `accurate_sum`).
    real(dp), intent(in) :: terms(:)
    real(dp), intent(inout) :: sums(:), lost(:)
    real(dp) :: next, error
    integer :: i
    do i = 1, size(terms)
      call two_sum(sums(i), terms(i), next, error)
      sums(i) = next
      lost(i) = lost(i) + error
    end do
  end subroutine add_exactly

  pure function add_to_list(a, b) result(c)
    type(dd), intent(in) :: a(:), b
    type(dd) :: c(size(a))
    c = add_dd(a, b)
  end function add_to_list

  pure function add_reals_to_list(a, b) result(c)
    type(dd), intent(in) :: a(:)
    real(dp), intent(in) :: b(:)
    type(dd) :: c(size(a))
    c = add_real(a, b)
  end function add_reals_to_list

  pure function subtract_from_list(a, b) result(c)
    type(dd), intent(in) :: a(:), b
    type(dd) :: c(size(a))
    c = subtract_dd(a, b)
  end function subtract_from_list

  pure function multiply_list(a, b) result(c)
    type(dd), intent(in) :: a(:), b
    type(dd) :: c(size(a))
    c = multiply_dd(a, b)
  end function multiply_list

  pure function multiply_lists(a, b) result(c)
    type(dd), intent(in) :: a(:), b(:)
    type(dd) :: c(size(a))
    c = multiply_dd(a, b)
  end function multiply_lists

  pure function multiply_by_reals(a, b) result(c)
    type(dd), intent(in) :: a
    real(dp), intent(in) :: b(:)
    type(dd) :: c(size(b))
    c = multiply_real(a, b)
  end function multiply_by_reals

  pure function sqrt_of_list(a) result(c)
    type(dd), intent(in) :: a(:)
    type(dd) :: c(size(a))
    c = sqrt_dd(a)
  end function sqrt_of_list

end module bw_double_double
