module bw_strain_basis
  !! Orthonormal Legendre polynomials p_j on [0, 1], j = 0, 1, …: what strains are written in. Functions are lists of
  !! coefficients, and integrals from the clamped end, products with ξ and their transposes are exact and banded.
  !!
  !! ∫₀^ξ p_j = c_{j+1}p_{j+1} − c_jp_{j−1}, c_j = ½/√(4j² − 1), and ½p_0 + c_1p_1 for j = 0.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: integral, integral_transposed, times_quadratic, basis_values, tip_value

contains

  elemental real(dp) function c(j)
    integer, intent(in) :: j               !! ≥ 1
    c = 0.5_dp/sqrt((2.0_dp*j - 1.0_dp)*(2.0_dp*j + 1.0_dp))
  end function c

  pure function integral(f) result(g)
    !! Coefficients of ∫₀^ξ f, (n + 1).
    real(dp), intent(in) :: f(0:)          !! (n)
    real(dp) :: g(0:size(f))
    integer :: j, n
    n = size(f)
    g(0) = 0.5_dp*f(0)
    g(1:n) = [(c(j)*f(j - 1), j=1, n)]
    g(0:n - 2) = g(0:n - 2) - [(c(j)*f(j), j=1, n - 1)]
  end function integral

  pure function integral_transposed(g) result(f)
    !! The transpose of `integral`: f_j = ∫ g ∫p_j, (n).
    real(dp), intent(in) :: g(0:)          !! (n + 1)
    real(dp) :: f(0:size(g) - 2)
    integer :: j, n
    n = size(f)
    f = [(c(j + 1)*g(j + 1), j=0, n - 1)]
    f(0) = f(0) + 0.5_dp*g(0)
    f(1:) = f(1:) - [(c(j)*g(j - 1), j=1, n - 1)]
  end function integral_transposed

  pure function times_quadratic(t, f) result(g)
    !! Coefficients of (t_0 + t_1ξ + t_2ξ²)f that are of no higher degree than f's, (n).
    real(dp), intent(in) :: t(3)
    real(dp), intent(in) :: f(0:)          !! (n)
    real(dp) :: g(0:size(f) - 1)
    real(dp), allocatable :: once(:), twice(:)
    once = times_xi(f)
    twice = times_xi(once)
    g = t(1)*f + t(2)*once(:size(f)) + t(3)*twice(:size(f))
  end function times_quadratic

  pure function times_xi(f) result(g)
    !! Coefficients of ξf: ξp_j = ½p_j + (j + 1)c_{j+1}p_{j+1} + jc_jp_{j−1}, (n + 1).
    real(dp), intent(in) :: f(0:)          !! (n)
    real(dp) :: g(0:size(f))
    integer :: j, n
    n = size(f)
    g(:n - 1) = 0.5_dp*f
    g(n) = 0.0_dp
    g(1:) = g(1:) + [(j*c(j)*f(j - 1), j=1, n)]
    g(:n - 2) = g(:n - 2) + [(j*c(j)*f(j), j=1, n - 1)]
  end function times_xi

  pure function basis_values(n, xi) result(values)
    !! p_j(ξ), j = 0 … n − 1, (n, points), by the recurrence of Legendre's polynomials.
    integer, intent(in) :: n               !! ≥ 2
    real(dp), intent(in) :: xi(:)          !! 0 ≤ ξ ≤ 1
    real(dp) :: values(0:n - 1, size(xi))
    real(dp) :: x(size(xi))
    integer :: j
    x = 2.0_dp*xi - 1.0_dp
    values(0, :) = 1.0_dp
    values(1, :) = x
    do j = 1, n - 2
      values(j + 1, :) = ((2*j + 1)*x*values(j, :) - j*values(j - 1, :))/(j + 1)
    end do
    do j = 1, n - 1
      values(j, :) = sqrt(2.0_dp*j + 1.0_dp)*values(j, :)
    end do
  end function basis_values

  pure real(dp) function tip_value(f)
    !! f(1): p_j(1) = √(2j + 1).
    real(dp), intent(in) :: f(0:)
    integer :: j
    tip_value = sum([(sqrt(2.0_dp*j + 1.0_dp)*f(j), j=0, size(f) - 1)])
  end function tip_value

end module bw_strain_basis
