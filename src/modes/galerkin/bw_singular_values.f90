module bw_singular_values
  !! The largest singular values of a matrix with their vectors, by LAPACK.
  use, intrinsic :: ieee_exceptions, only: ieee_get_halting_mode, ieee_overflow, ieee_set_flag, ieee_set_halting_mode
  use bw_kinds, only: dp
  use bw_lapack, only: dgejsv, dgesdd
  use bw_order, only: ascending
  implicit none (type, external)
  private
  public :: singular_values

contains

  subroutine singular_values(matrix, count, values, left, right, info)
    !! Find them by divide and conquer, with columns in order of decreasing length, which keeps the digits of values for
    !! short columns. If lengths drop by a step, as after the column of a heavy body, smaller values lose digits to
    !! larger ones; then Jacobi's method keeps those of each value and component, at several times the cost.
    real(dp), contiguous, intent(in) :: matrix(:, :)                  !! at least as many rows as columns
    integer, intent(in) :: count                                      !! ≥ 1, at most the number of columns
    real(dp), allocatable, intent(out) :: values(:)                   !! descending
    real(dp), allocatable, intent(out) :: left(:, :), right(:, :)     !! (rows, count), (columns, count)
    integer, intent(out) :: info                                      !! LAPACK's; 0: success
    real(dp), parameter :: loss = 2.0e-13_dp       ! tuned: error of shapes beyond a step
    real(dp) :: length(size(matrix, 2))
    real(dp), allocatable :: a(:, :), s(:), u(:, :), v(:, :), work(:)
    integer, allocatable :: iwork(:), order(:)
    integer :: m, n
    logical :: halts
    m = size(matrix, 1)
    n = size(matrix, 2)
    allocate (s(n), u(m, n), v(n, n), work(4*n**2 + 8*n + 64*(m + n)), iwork(m + 8*n))
    length = norm2(matrix, dim=1)
    order = ascending(-length)
    length = length(order)
    if (all(epsilon(loss)*length(:count - 1) <= loss*length(2:count))) then
      a = matrix(:, order)
      call dgesdd('S', m, n, a, m, s, u, m, v, n, work, size(work), iwork, info)
      values = s(:count)
      allocate (right(n, count))
      right(order, :) = transpose(v(:count, :))
    else
      a = matrix
      call ieee_get_halting_mode(ieee_overflow, halts)
      call ieee_set_halting_mode(ieee_overflow, .false.)     ! the largest number over a length is compared with a bound
      call dgejsv('F', 'U', 'V', 'R', 'N', 'N', m, n, a, m, s, u, m, v, n, work, size(work), iwork, info)
      call ieee_set_flag(ieee_overflow, .false.)
      call ieee_set_halting_mode(ieee_overflow, halts)
      values = work(1)/work(2)*s(:count)
      right = v(:, :count)
    end if
    left = u(:, :count)
  end subroutine singular_values

end module bw_singular_values
