module bw_line_projection
  !! Variable projection (Golub and Pereyra, 1973): for given exponents of lines all other unknowns are linear. One triangle R of
  !! [columns of amplitudes, columns of slopes] and the rotated record give the residual, the Gauss–Newton step and the covariance,
  !! since all sensors share the columns.
  use bw_kinds, only: dp
  use bw_lapack, only: dgelsy
  use bw_triangle, only: dependent, eliminate, length_of, scaled, solved, triangulate
  implicit none (type, external)
  private
  public :: deviation_of, find_step, project

  type, public :: projected_type
    !! The projection of a record's rows onto columns.
    integer :: linear = 0                        !! columns of amplitudes, offset and slope; those of slopes follow
    real(dp), allocatable :: triangle(:, :)      !! R, for columns of length 1
    real(dp), allocatable :: length(:)           !! of the columns
    real(dp), allocatable :: rotated(:, :)       !! Qᵀ times the record, (rows of R, S)
    real(dp), allocatable :: linear_part(:, :)   !! amplitudes, offset and slope, (linear, S)
    real(dp), allocatable :: left(:)             !! squares of the residual, (S)
  end type projected_type

contains

  subroutine project(matrix, rows, linear, projected)
    !! Find amplitudes, offset and slope, and the residual.
    real(dp), intent(inout), contiguous :: matrix(:, :)   !! columns; scaled to length 1
    real(dp), intent(in) :: rows(:, :)           !! the record, (rows, S)
    integer, intent(in) :: linear
    class(projected_type), intent(inout) :: projected
    integer :: k, held
    projected%linear = linear
    projected%length = [(length_of(matrix(:, k)), k=1, size(matrix, 2))]
    where (projected%length <= 0) projected%length = 1
    do k = 1, size(matrix, 2)
      matrix(:, k) = matrix(:, k)/projected%length(k)
    end do
    call triangulate(matrix, rows, projected%triangle, projected%rotated, projected%left)
    held = min(linear, size(projected%triangle, 1))
    associate (r => projected%triangle, x => projected%rotated, left => projected%left)
      if (allocated(projected%linear_part)) deallocate (projected%linear_part)
      allocate (projected%linear_part(linear, size(rows, 2)), source=0.0_dp)
      projected%linear_part(:held, :) = solved(r(:held, :held), x(:held, :))
      left = left + sum(x(held + 1:, :)**2, dim=1)
      do k = 1, held                             ! a number that the triangle does not determine leaves a residual
        if (abs(r(k, k)) > dependent) cycle
        left = left + (x(k, :) - matmul(r(k, k:held), projected%linear_part(k:held, :)))**2
      end do
    end associate
    do k = 1, linear
      projected%linear_part(k, :) = projected%linear_part(k, :)/projected%length(k)
    end do
  end subroutine project

  subroutine find_step(slopes, right, step, gain)
    !! Find the Gauss–Newton step of the unknowns, and the decrease of the squares that it predicts.
    real(dp), intent(in) :: slopes(:, :)         !! of the residual by the unknowns, (rows, unknowns)
    real(dp), intent(in) :: right(:)             !! the residual
    real(dp), intent(out) :: step(:), gain
    real(dp), allocatable :: matrix(:, :), factors(:, :), x(:, :), length(:), work(:)
    integer :: pivot(size(slopes, 2)), rank, info, n
    step = 0
    gain = 0
    if (size(slopes) == 0) return
    n = size(slopes, 2)
    matrix = slopes
    length = scaled(matrix)
    allocate (x(max(size(slopes, 1), n), 1), work(64*(sum(shape(slopes)) + 1)))
    x = 0
    x(:size(right), 1) = right
    pivot = 0
    factors = matrix
    call dgelsy(size(slopes, 1), n, 1, factors, size(slopes, 1), x, size(x, 1), pivot, dependent, rank, work, size(work), info)
    gain = norm2(matmul(matrix, x(:n, 1)))**2
    step = x(:n, 1)/length
  end subroutine find_step

  pure real(dp) function deviation_of(triangle, length, gradient) result(deviation)
    !! The standard deviation of gradient·x in noise of variance 1; huge if it is not determined.
    real(dp), intent(in) :: triangle(:, :), length(:), gradient(:)
    real(dp) :: y(size(length))
    logical :: determined
    call eliminate(triangle, length, gradient, y, determined)
    deviation = huge(1.0_dp)
    if (determined) deviation = norm2(y)
  end function deviation_of

end module bw_line_projection
