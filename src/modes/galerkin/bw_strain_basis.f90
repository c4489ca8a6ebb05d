module bw_strain_basis
  !! What strains are written in: orthonormal Legendre polynomials p_j on [0, 1], j = 0, 1, …, and beside them the deflection
  !! and the turning of the tip.
  !!
  !! Functions are lists of coefficients, and integrals from the clamped end, products with ξ and their transposes are exact and
  !! banded: ∫₀^ξ p_j = c_{j+1}p_{j+1} − c_jp_{j−1}, c_j = ½/√(4j² − 1), and ½p_0 + c_1p_1 for j = 0.
  !!
  !! Of the orthonormal strains z only three move the tip: ψ(1) = z_1 and v(1) = ½z_1 − (√3/6)z_2 + s z_{n+1}, the last with shear.
  !! Where a body is at the tip, v(1) and ψ(1) stand in their place, as in a beam element, whose stiffness (4, −6, 12 without
  !! shear) they have, and with shear a third that moves neither; all others are at right angles to them. Then mass and inertia of
  !! the body stand in one place each, and the heaviest of bodies takes no digit off anything else.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: integral, integral_transposed, times_quadratic, basis_values, tip_value, slope_of, tip_coordinates_of

  type, public :: tip_coordinates
    !! Unknowns of which v(1) and ψ(1) are the last two.
    integer :: deflection = 0                      !! the unknown v(1); it and `turning` are the last two
    integer :: turning = 0                         !! the unknown ψ(1)
    integer, allocatable, private :: mover(:)      !! strains that move the tip
    integer, allocatable, private :: other(:)      !! strains that do not
    real(dp), allocatable, private :: share(:, :)  !! of each strain that moves the tip in each of the last unknowns
  contains
    procedure :: to_columns
    procedure :: to_rows
    procedure :: from_rows
  end type tip_coordinates

contains

  elemental real(dp) function c(j)
    !! c_j of the integral of p_j.
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

  pure function slope_of(n, strain, compliance) result(slope)
    !! Coefficients of the slope v' = ψ + the shear strain, (n + 1).
    integer, intent(in) :: n               !! functions of each strain
    real(dp), intent(in) :: strain(:)      !! curvatures, and with shear the shear strains over s, (n) or (2n)
    real(dp), intent(in) :: compliance     !! s²
    real(dp) :: slope(n + 1)
    slope = integral(strain(:n))
    if (size(strain) > n) slope(:n) = slope(:n) + sqrt(compliance)*strain(n + 1:)
  end function slope_of

  ! The tip

  pure type(tip_coordinates) function tip_coordinates_of(functions, shear, turning_last) result(tip)
    !! The unknowns of the tip in a system of n functions of each strain.
    integer, intent(in) :: functions               !! n, of each strain
    real(dp), intent(in), optional :: shear        !! s; absent: the only strains are curvatures
    logical, intent(in) :: turning_last            !! ψ(1) is the last unknown, else v(1)
    real(dp) :: lever(2)                           ! v(1) of the second and the third strain
    integer :: j, last, unknowns
    last = merge(3, 2, present(shear))
    lever = [-sqrt(3.0_dp)/6.0_dp, 0.0_dp]
    tip%mover = [1, 2]
    unknowns = functions
    if (present(shear)) then
      lever(2) = shear
      tip%mover = [1, 2, functions + 1]
      unknowns = 2*functions
    end if
    tip%other = pack([(j, j=1, unknowns)], [(all(tip%mover /= j), j=1, unknowns)])
    tip%deflection = merge(unknowns - 1, unknowns, turning_last)
    tip%turning = merge(unknowns, unknowns - 1, turning_last)
    allocate (tip%share(last, last), source=0.0_dp)
    associate (v => tip%share(:, tip%deflection - unknowns + last), psi => tip%share(:, tip%turning - unknowns + last))
      v(2:) = lever(:last - 1)/sum(lever**2)
      psi(1) = 1.0_dp
      psi(2:) = -0.5_dp*v(2:)
    end associate
    if (present(shear)) tip%share(2:, 1) = [lever(2), -lever(1)]/norm2(lever)
  end function tip_coordinates_of

  pure subroutine to_columns(self, matrix)
    !! Turn columns for the strains into columns for the unknowns.
    class(tip_coordinates), intent(in) :: self
    real(dp), intent(inout) :: matrix(:, :)        !! (any, unknowns)
    real(dp) :: moved(size(matrix, 1), size(self%mover))
    moved = matmul(matrix(:, self%mover), self%share)
    matrix(:, :size(self%other)) = matrix(:, self%other)
    matrix(:, size(self%other) + 1:) = moved
  end subroutine to_columns

  pure subroutine to_rows(self, matrix)
    !! Turn rows for the strains into rows for the unknowns.
    class(tip_coordinates), intent(in) :: self
    real(dp), intent(inout) :: matrix(:, :)        !! (unknowns, any)
    real(dp) :: moved(size(self%mover), size(matrix, 2))
    moved = matmul(transpose(self%share), matrix(self%mover, :))
    matrix(:size(self%other), :) = matrix(self%other, :)
    matrix(size(self%other) + 1:, :) = moved
  end subroutine to_rows

  pure subroutine from_rows(self, matrix)
    !! Turn unknowns, row by row, into strains.
    class(tip_coordinates), intent(in) :: self
    real(dp), intent(inout) :: matrix(:, :)        !! (unknowns, any)
    real(dp) :: moved(size(self%mover), size(matrix, 2))
    moved = matmul(self%share, matrix(size(self%other) + 1:, :))
    matrix(self%other, :) = matrix(:size(self%other), :)
    matrix(self%mover, :) = moved
  end subroutine from_rows

end module bw_strain_basis
