module bw_strain_basis
  !! The basis of strains: orthonormal Legendre polynomials p_j on [0, 1], j = 0, 1, …
  !!
  !! Functions are lists of coefficients, and integrals from 0, products with polynomials and their transposes are exact and
  !! banded: ∫₀^x p_j = c_{j+1}p_{j+1} − c_jp_{j−1}, c_j = ½/√(4j² − 1), and ½p_0 + c_1p_1 for j = 0.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: integral, integral_transposed, times_polynomial, basis_values

contains

  elemental real(dp) function c(j)
    !! Return c_j of the integral of p_j.
    integer, intent(in) :: j               !! ≥ 1
    c = 0.5_dp/sqrt((2.0_dp*j - 1.0_dp)*(2.0_dp*j + 1.0_dp))
  end function c

  pure function integral(f) result(g)
    !! Return the coefficients of ∫₀^x f, (n + 1).
    real(dp), intent(in) :: f(0:)          !! (n)
    real(dp) :: g(0:size(f))
    integer :: j, n
    n = size(f)
    g(0) = 0.5_dp*f(0)
    g(1:n) = [(c(j)*f(j - 1), j=1, n)]
    g(0:n - 2) = g(0:n - 2) - [(c(j)*f(j), j=1, n - 1)]
  end function integral

  pure function integral_transposed(g) result(f)
    !! Apply the transpose of `integral`: f_j = ∫ g ∫p_j, (n).
    real(dp), intent(in) :: g(0:)          !! (n + 1)
    real(dp) :: f(0:size(g) - 2)
    integer :: j, n
    n = size(f)
    f = [(c(j + 1)*g(j + 1), j=0, n - 1)]
    f(0) = f(0) + 0.5_dp*g(0)
    f(1:) = f(1:) - [(c(j)*g(j - 1), j=1, n - 1)]
  end function integral_transposed

  pure function times_polynomial(t, f) result(g)
    !! Return the coefficients of (t_0 + t_1x + t_2x² + …)f up to the degree of f, (n).
    real(dp), intent(in) :: t(0:)
    real(dp), intent(in) :: f(0:)          !! (n)
    real(dp) :: g(0:size(f) - 1)
    real(dp) :: power(0:size(f) + size(t) - 2)
    integer :: i, n
    g = t(0)*f
    if (size(t) == 1) return
    n = size(f)
    power(:n - 1) = f
    do i = 1, size(t) - 1
      power(:n - 1 + i) = times_x(power(:n - 2 + i))
      g = g + t(i)*power(:n - 1)
    end do
  end function times_polynomial

  pure function times_x(f) result(g)
    !! Return the coefficients of xf: xp_j = ½p_j + (j + 1)c_{j+1}p_{j+1} + jc_jp_{j−1}, (n + 1).
    real(dp), intent(in) :: f(0:)          !! (n)
    real(dp) :: g(0:size(f))
    integer :: j, n
    n = size(f)
    g(:n - 1) = 0.5_dp*f
    g(n) = 0.0_dp
    g(1:) = g(1:) + [(j*c(j)*f(j - 1), j=1, n)]
    g(:n - 2) = g(:n - 2) + [(j*c(j)*f(j), j=1, n - 1)]
  end function times_x

  pure function basis_values(n, x) result(values)
    !! Return p_j(x), j = 0 … n − 1, (n, points), by the recurrence of Legendre polynomials.
    integer, intent(in) :: n               !! ≥ 2
    real(dp), intent(in) :: x(:)           !! 0 ≤ x ≤ 1
    real(dp) :: values(0:n - 1, size(x))
    real(dp) :: z(size(x))
    integer :: j
    z = 2.0_dp*x - 1.0_dp
    values(0, :) = 1.0_dp
    values(1, :) = z
    do j = 1, n - 2
      values(j + 1, :) = ((2*j + 1)*z*values(j, :) - j*values(j - 1, :))/(j + 1)
    end do
    do j = 1, n - 1
      values(j, :) = sqrt(2.0_dp*j + 1.0_dp)*values(j, :)
    end do
  end function basis_values

end module bw_strain_basis
