module bw_small_series
  !! Power series of the cantilever's functions where the closed forms cancel: α, z ≲ 2.
  !!
  !! With \(T_j(x) = \sum_m (-4x)^m/(4m+j)!\) and x = α⁴:
  !! 1 + cos α cosh α = 1 + T₀, sin α sinh α = 2α² T₂, sin α cosh α − cos α sinh α = 4α³ T₃.
  !! With \(U_j(y) = \sum_m y^m/(4m+j)!\) and y = z⁴: cosh z − cos z = 2z² U₂, sinh z − sin z = 2z³ U₃.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: alternating_series, growing_series

  integer, parameter :: last_term = 7
    !! the term after it is below 1e-18 of the first for x ≤ 15 (checked by test_small_series)

  real(dp), parameter :: factorial(0:4) = [1.0_dp, 1.0_dp, 2.0_dp, 6.0_dp, 24.0_dp]

contains

  elemental real(dp) function alternating_series(j, x) result(sum)
    !! T_j(x), 0 ≤ x ≤ 15.
    integer, intent(in) :: j      !! 0 … 4
    real(dp), intent(in) :: x
    sum = factorial_series(j, -4.0_dp*x)
  end function alternating_series

  elemental real(dp) function growing_series(j, y) result(sum)
    !! U_j(y), 0 ≤ y ≤ 15.
    integer, intent(in) :: j      !! 0 … 4
    real(dp), intent(in) :: y
    sum = factorial_series(j, y)
  end function growing_series

  elemental real(dp) function factorial_series(j, y) result(sum)
    !! Σ yᵐ/(4m+j)! by Horner's rule on the ratios of neighbouring terms.
    integer, intent(in) :: j
    real(dp), intent(in) :: y
    integer :: m, n
    sum = 1.0_dp
    do m = last_term, 1, -1
      n = 4*m + j
      sum = 1.0_dp + sum*y/real(n*(n - 1)*(n - 2)*(n - 3), dp)
    end do
    sum = sum/factorial(j)
  end function factorial_series

end module bw_small_series
