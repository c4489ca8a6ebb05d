module bw_vector_noise
  !! The cost of sensors that move together, as noise alone: a vector autoregression, which describes the motion of a driven beam.
  !!
  !! A lattice predicts all sensors from all, one sample further back at each order; each stage is a least-squares fit of the
  !! prediction errors before it. Source: Strand (1977), IEEE Trans. Autom. Control 22; Kay, Modern Spectral Estimation (1988).
  use bw_kinds, only: dp
  use bw_lapack, only: dgemm, dpotrf, dtrsm
  implicit none (type, external)
  private
  public :: vector_noise_cost

  integer, parameter :: patience = 8             !! tuned: orders without a gain after which the lattice ends
  real(dp), parameter :: least_part = 1.0e-13_dp !! of the variances: smallest error
  integer, parameter :: chunk = 2048             !! rows handled at once

contains

  function vector_noise_cost(ahead, highest, penalty) result(least)
    !! The least −2 ln L + penalty of all coefficients over all orders; huge if there is none.
    real(dp), allocatable, intent(inout) :: ahead(:, :)  !! (N, S), without mean; overwritten
      !! errors of samples p + 1 … N predicted from the p before each, from row p + 1 on
    integer, intent(in) :: highest               !! order
    real(dp), intent(in) :: penalty              !! of a coefficient
    real(dp) :: least
    real(dp), allocatable :: behind(:, :)        ! errors of samples 1 … N − p predicted from the p after each
    real(dp), dimension(size(ahead, 2), size(ahead, 2)) :: of_ahead, of_behind, across, forth, back, root
    real(dp) :: logarithms, total, cost
    integer :: n, s, p, best, rows, info
    n = size(ahead, 1)
    s = size(ahead, 2)
    least = huge(1.0_dp)
    behind = ahead
    logarithms = 0
    total = 0
    best = 0
    do p = 0, highest
      if (p - best > patience) exit
      rows = n - p
      call squares_of(ahead, ahead, p + 1, p + 1, rows, of_ahead)
      root = of_ahead/rows
      call dpotrf('L', s, root, s, info)
      if (info /= 0) exit
      cost = logarithms + total + rows*(log_determinant(root) + s) + penalty*(real(s, dp)*s*p + 0.5_dp*s*(s - 1))
      if (cost < least) then
        least = cost
        best = p
      end if
      logarithms = logarithms + log_determinant(root)
      total = total + length_in(root, ahead(p + 1, :))
      rows = rows - 1
      call squares_of(ahead, ahead, p + 2, p + 2, rows, of_ahead)
      call squares_of(behind, behind, 1, 1, rows, of_behind)
      call squares_of(ahead, behind, p + 2, 1, rows, across)
      if (.not. solved(of_behind, transpose(across), forth)) exit
      if (.not. solved(of_ahead, across, back)) exit
      call add_stage(p + 1, rows, forth, back, ahead, behind)
    end do
    least = least - n*s                          ! as for single sensors, without the squares of the errors
  end function vector_noise_cost

  subroutine add_stage(order, rows, forth, back, ahead, behind)
    !! Extend the predictors by one sample.
    integer, intent(in) :: order, rows
    real(dp), intent(in) :: forth(:, :), back(:, :)
    real(dp), allocatable, intent(inout) :: ahead(:, :), behind(:, :)
    real(dp) :: part(chunk, size(forth, 1))
    integer :: first, k, n, s
    n = size(ahead, 1)
    s = size(forth, 1)
    do first = 1, rows, chunk
      k = min(chunk, rows - first + 1)
      part(:k, :) = ahead(order + first:order + first + k - 1, :)
      call dgemm('N', 'N', k, s, s, -1.0_dp, behind(first, 1), n, forth, s, 1.0_dp, ahead(order + first, 1), n)
      call dgemm('N', 'N', k, s, s, -1.0_dp, part, chunk, back, s, 1.0_dp, behind(first, 1), n)
    end do
  end subroutine add_stage

  subroutine squares_of(one, other, first, first_other, rows, products)
    !! Scalar products of columns over `rows` rows.
    real(dp), allocatable, intent(in) :: one(:, :), other(:, :)
    integer, intent(in) :: first, first_other, rows
    real(dp), intent(out) :: products(:, :)
    integer :: n, s
    n = size(one, 1)
    s = size(one, 2)
    call dgemm('T', 'N', s, s, rows, 1.0_dp, one(first, 1), n, other(first_other, 1), n, 0.0_dp, products, s)
  end subroutine squares_of

  logical function solved(matrix, right, x)
    !! Find matrix⁻¹·right for a positive definite matrix.
    real(dp), intent(in) :: matrix(:, :), right(:, :)
    real(dp), intent(out) :: x(:, :)
    real(dp) :: root(size(matrix, 1), size(matrix, 1))
    integer :: info, i, s
    s = size(matrix, 1)
    root = matrix
    do i = 1, s
      root(i, i) = root(i, i)*(1 + least_part) + tiny(1.0_dp)
    end do
    call dpotrf('L', s, root, s, info)
    solved = info == 0
    if (.not. solved) return
    x = right
    call dtrsm('L', 'L', 'N', 'N', s, s, 1.0_dp, root, s, x, s)
    call dtrsm('L', 'L', 'T', 'N', s, s, 1.0_dp, root, s, x, s)
  end function solved

  pure real(dp) function log_determinant(root)
    !! The logarithm of the determinant of LLᵀ.
    real(dp), intent(in) :: root(:, :)
    integer :: i
    log_determinant = 2*sum([(log(root(i, i)), i=1, size(root, 1))])
  end function log_determinant

  pure real(dp) function length_in(root, x)
    !! The square xᵀ(LLᵀ)⁻¹x.
    real(dp), intent(in) :: root(:, :), x(:)
    real(dp) :: y(size(x))
    integer :: i
    do i = 1, size(x)
      y(i) = (x(i) - dot_product(root(i, :i - 1), y(:i - 1)))/root(i, i)
    end do
    length_in = sum(y**2)
  end function length_in

end module bw_vector_noise
