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
    !! Find them by divide and conquer, columns from the longest to the shortest, so that small values keep their digits as far as
    !! columns are short. Where the rounding of the largest value is too much of the smallest that is asked for even so, as with
    !! bodies that are a million times heavier than the beam, find them by Jacobi's method: each then keeps its own digits, for
    !! several times the work.
    real(dp), contiguous, intent(in) :: matrix(:, :)                  !! not fewer rows than columns
    integer, intent(in) :: count                                      !! ≥ 1, at most as many as columns
    real(dp), allocatable, intent(out) :: values(:)                   !! descending
    real(dp), allocatable, intent(out) :: left(:, :), right(:, :)     !! (rows, count), (columns, count)
    integer, intent(out) :: info                                      !! 0: LAPACK had no trouble
    real(dp), parameter :: loss = 1.0e-9_dp        ! tuned: of a value; Rayleigh's quotients err by its square
    real(dp), allocatable :: a(:, :), s(:), u(:, :), v(:, :), work(:)
    integer, allocatable :: iwork(:), order(:)
    integer :: j, m, n
    logical :: halts
    m = size(matrix, 1)
    n = size(matrix, 2)
    allocate (s(n), u(m, n), v(n, n), work(4*n**2 + 8*n + 64*(m + n)), iwork(m + 8*n))
    order = ascending([(-norm2(matrix(:, j)), j=1, n)])
    a = matrix(:, order)
    call dgesdd('S', m, n, a, m, s, u, m, v, n, work, size(work), iwork, info)
    if (info == 0 .and. epsilon(loss)*s(1) <= loss*s(count)) then
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
