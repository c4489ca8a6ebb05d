module bw_least_squares
  !! This module solves small dense least-squares problems by LAPACK.
  use bw_kinds, only: dp
  use bw_lapack, only: dgelsy, dgeqrf
  implicit none (type, external)
  private
  public :: least_squares, factorise, gradient_length

  real(dp), parameter :: dependent = 1.0e-13_dp   !! columns this close to the others are left out of a solution

contains

  function least_squares(matrix, right) result(solution)
    !! The shortest x that makes |matrix x − right| least, with columns scaled to length 1 first; (n, right sides).
    real(dp), intent(in) :: matrix(:, :)     !! (m, n)
    real(dp), intent(in) :: right(:, :)      !! (m, right sides)
    real(dp) :: solution(size(matrix, 2), size(right, 2))
    real(dp) :: a(size(matrix, 1), size(matrix, 2)), b(max(size(matrix, 1), size(matrix, 2)), size(right, 2))
    real(dp) :: length(size(matrix, 2)), work(64*(sum(shape(matrix)) + size(right, 2)))
    integer :: pivot(size(matrix, 2)), rank, info, i
    length = column_lengths(matrix)
    do i = 1, size(a, 2)
      a(:, i) = matrix(:, i)/length(i)
    end do
    b = 0
    b(:size(matrix, 1), :) = right
    pivot = 0
    work = 0
    call dgelsy(size(a, 1), size(a, 2), size(b, 2), a, size(a, 1), b, size(b, 1), pivot, dependent, rank, &
      & work, size(work), info)
    do i = 1, size(b, 2)
      solution(:, i) = b(:size(a, 2), i)/length
    end do
  end function least_squares

  pure function column_lengths(matrix) result(length)
    !! The Euclidean length of each column, 1 for a column of zeros.
    real(dp), intent(in) :: matrix(:, :)
    real(dp) :: length(size(matrix, 2))
    length = norm2(matrix, dim=1)
    where (length == 0) length = 1
  end function column_lengths

  subroutine factorise(matrix, triangle, length)
    !! Find the triangle R of matrix·diag(1/length) = QR, which gives the covariance of a fit.
    real(dp), intent(in) :: matrix(:, :)     !! (m, n), m ≥ n
    real(dp), intent(out) :: triangle(:, :)  !! (n, n), its upper part
    real(dp), intent(out) :: length(:)       !! lengths of the columns, (n)
    real(dp) :: a(size(matrix, 1), size(matrix, 2)), tau(size(matrix, 2)), work(64*size(matrix, 2))
    integer :: info, i
    length = column_lengths(matrix)
    do i = 1, size(a, 2)
      a(:, i) = matrix(:, i)/length(i)
    end do
    work = 0
    tau = 0
    call dgeqrf(size(a, 1), size(a, 2), a, size(a, 1), tau, work, size(work), info)
    triangle = a(:size(a, 2), :)
  end subroutine factorise

  pure real(dp) function gradient_length(triangle, length, gradient)
    !! The standard deviation of gradient·x where the right side has noise of standard deviation 1, |R⁻ᵀ (gradient/length)|.
    !! It is huge if the fit does not determine that number.
    real(dp), intent(in) :: triangle(:, :), length(:)  !! from `factorise`
    real(dp), intent(in) :: gradient(:)
    real(dp) :: y(size(gradient))
    integer :: i
    gradient_length = huge(1.0_dp)
    do i = 1, size(y)
      y(i) = gradient(i)/length(i) - dot_product(triangle(:i - 1, i), y(:i - 1))
      if (abs(triangle(i, i)) > dependent) then
        y(i) = y(i)/triangle(i, i)
      else if (abs(y(i)) > dependent) then
        return
      else
        y(i) = 0
      end if
    end do
    gradient_length = norm2(y)
  end function gradient_length

end module bw_least_squares
