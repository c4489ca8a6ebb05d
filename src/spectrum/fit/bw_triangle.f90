module bw_triangle
  !! Triangles R of QR factorisations of columns scaled to length 1, for solutions of least-squares problems and their covariances.
  use bw_kinds, only: dp
  use bw_lapack, only: dgemqrt, dgeqrt
  implicit none (type, external)
  private
  public :: dependent, eliminate, length_of, scaled, solved, triangle_of, triangulate

  real(dp), parameter :: dependent = 1.0e-12_dp  !! columns this close to the others are left out of a solution
  integer, parameter :: stretch = 512            !! rows at a time, as fit a processor's cache
  integer, parameter :: block = 16               !! columns of Householder reflections at a time

contains

  pure real(dp) function length_of(column) result(length)
    !! The length of a vector. If squares may have underflowed or overflowed, by a slower method that avoids this.
    real(dp), contiguous, intent(in) :: column(:)
    length = sqrt(dot_product(column, column))
    if (.not. (length > 1.0e-140_dp .and. length < 1.0e140_dp)) length = norm2(column)
  end function length_of

  function scaled(matrix) result(length)
    !! The lengths of a matrix's columns, which are scaled to length 1; 1 for a column of zeros.
    real(dp), intent(inout) :: matrix(:, :)
    real(dp) :: length(size(matrix, 2))
    integer :: k
    length = norm2(matrix, dim=1)
    where (.not. length > 0) length = 1
    do k = 1, size(matrix, 2)
      matrix(:, k) = matrix(:, k)/length(k)
    end do
  end function scaled

  pure function solved(triangle, right) result(x)
    !! R⁻¹ times the right-hand sides; elements that R does not determine are 0.
    real(dp), intent(in) :: triangle(:, :), right(:, :)
    real(dp) :: x(size(right, 1), size(right, 2))
    integer :: i, j
    do j = 1, size(right, 2)
      do i = size(right, 1), 1, -1
        x(i, j) = right(i, j) - dot_product(triangle(i, i + 1:size(right, 1)), x(i + 1:, j))
        if (abs(triangle(i, i)) > dependent) then
          x(i, j) = x(i, j)/triangle(i, i)
        else
          x(i, j) = 0
        end if
      end do
    end do
  end function solved

  subroutine triangle_of(matrix, triangle, length)
    !! The triangle R of matrix·diag(1/length) = QR, which gives the covariance of a fit; zeros if there are fewer rows than
    !! columns.
    real(dp), intent(in) :: matrix(:, :)
    real(dp), allocatable, intent(out) :: triangle(:, :)
    real(dp), allocatable, intent(out) :: length(:)  !! of the columns
    real(dp), allocatable :: factors(:, :), t(:, :), work(:)
    integer :: info, n
    n = size(matrix, 2)
    factors = matrix
    length = scaled(factors)
    allocate (triangle(n, n), source=0.0_dp)
    if (size(matrix, 1) < n .or. n == 0) return
    allocate (t(block, n), work(block*n))
    call dgeqrt(size(matrix, 1), n, min(block, n), factors, size(matrix, 1), t, block, work, info)
    triangle = factors(:n, :)
  end subroutine triangle_of

  subroutine triangulate(matrix, right, triangle, turned, beyond)
    !! Find the triangle R of matrix = QR, with fewer rows than columns if the matrix has fewer, Qᵀ·right in its rows, and the
    !! squares of the rows of Qᵀ·right below it. Many rows are factored block by block, each below the triangle of those before.
    real(dp), intent(in) :: matrix(:, :), right(:, :)
    real(dp), allocatable, intent(out) :: triangle(:, :), turned(:, :)
    real(dp), allocatable, intent(out) :: beyond(:)  !! (right-hand sides)
    real(dp), allocatable :: part(:, :), side(:, :), t(:, :), work(:)
    integer :: n, s, rows, most, held, first, last, k, columns, info
    n = size(matrix, 2)
    s = size(right, 2)
    most = min(size(matrix, 1), n + stretch)
    allocate (part(most, n), side(most, s), t(block, n), work(block*max(n, s)), beyond(s))
    beyond = 0
    held = 0
    last = 0
    do
      first = last + 1
      last = min(size(matrix, 1), last + most - held)
      rows = held + last - first + 1
      part(held + 1:rows, :) = matrix(first:last, :)
      side(held + 1:rows, :) = right(first:last, :)
      held = min(n, rows)
      if (n > 0) then
        columns = min(block, held)
        call dgeqrt(rows, n, columns, part, most, t, block, work, info)
        call dgemqrt('L', 'T', rows, s, held, columns, part, most, t, block, side, most, work, info)
      end if
      beyond = beyond + sum(side(held + 1:rows, :)**2, dim=1)
      if (last == size(matrix, 1)) exit
      do k = 1, n
        part(k + 1:held, k) = 0
      end do
    end do
    triangle = part(:held, :)
    turned = side(:held, :)
  end subroutine triangulate

  pure subroutine eliminate(triangle, length, gradient, y, determined)
    !! Find y = R⁻ᵀ (gradient/length), whose length is the standard deviation of gradient·x in noise of variance 1, and whether the
    !! fit determines gradient·x.
    real(dp), intent(in) :: triangle(:, :), length(:)  !! R, and the lengths of its columns before scaling
    real(dp), intent(in) :: gradient(:)
    real(dp), intent(out) :: y(:)
    logical, intent(out) :: determined
    integer :: i
    determined = .true.
    do i = 1, size(y)
      y(i) = gradient(i)/length(i) - dot_product(triangle(:i - 1, i), y(:i - 1))
      if (abs(triangle(i, i)) > dependent) then
        y(i) = y(i)/triangle(i, i)
      else
        determined = determined .and. abs(y(i)) <= dependent
        y(i) = 0
      end if
    end do
  end subroutine eliminate

end module bw_triangle
