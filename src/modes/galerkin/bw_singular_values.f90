module bw_singular_values
  !! The largest singular values of a matrix with their vectors, by LAPACK, in steps between which the work can be left.
  !!
  !! LAPACK's dgesdd reduces a matrix to two diagonals, takes their singular values apart, and carries all vectors back. Here
  !! the reduction goes panel by panel, as in LAPACK's dgebrd, and only the vectors that are asked for are carried back.
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type, stops
  implicit none (type, external)
  private
  public :: singular_values

  integer, parameter :: panel = 32              !! columns that are reduced at a time, as LAPACK does
  integer, parameter :: fewest = 128            !! columns from which panels are worth it, as LAPACK has it
  integer, parameter :: some = 64               !! vectors that are carried back at a time

  interface
    subroutine dlabrd(m, n, nb, a, lda, d, e, tauq, taup, x, ldx, y, ldy)
      import :: dp
      implicit none (type, external)
      integer, intent(in) :: m, n, nb, lda, ldx, ldy
      real(dp), intent(inout) :: a(lda, *)
      real(dp), intent(out) :: d(*), e(*), tauq(*), taup(*), x(ldx, *), y(ldy, *)
    end subroutine dlabrd
    subroutine dgebrd(m, n, a, lda, d, e, tauq, taup, work, lwork, info)
      import :: dp
      implicit none (type, external)
      integer, intent(in) :: m, n, lda, lwork
      real(dp), intent(inout) :: a(lda, *), work(*)
      real(dp), intent(out) :: d(*), e(*), tauq(*), taup(*)
      integer, intent(out) :: info
    end subroutine dgebrd
    subroutine dbdsdc(uplo, compq, n, d, e, u, ldu, vt, ldvt, q, iq, work, iwork, info)
      import :: dp
      implicit none (type, external)
      character, intent(in) :: uplo, compq
      integer, intent(in) :: n, ldu, ldvt
      real(dp), intent(inout) :: d(*), e(*), u(ldu, *), vt(ldvt, *), q(*), work(*)
      integer, intent(inout) :: iq(*), iwork(*)
      integer, intent(out) :: info
    end subroutine dbdsdc
    subroutine dormbr(vect, side, trans, m, n, k, a, lda, tau, c, ldc, work, lwork, info)
      import :: dp
      implicit none (type, external)
      character, intent(in) :: vect, side, trans
      integer, intent(in) :: m, n, k, lda, ldc, lwork
      real(dp), intent(inout) :: a(lda, *), c(ldc, *), work(*)
      real(dp), intent(in) :: tau(*)
      integer, intent(out) :: info
    end subroutine dormbr
    subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
      import :: dp
      implicit none (type, external)
      character, intent(in) :: transa, transb
      integer, intent(in) :: m, n, k, lda, ldb, ldc
      real(dp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)
      real(dp), intent(inout) :: c(ldc, *)
    end subroutine dgemm
  end interface

  type :: two_diagonals
    !! A matrix as Q B Pᵀ, B upper bidiagonal.
    real(dp), allocatable :: d(:), e(:)         !! of B
    real(dp), allocatable :: tauq(:), taup(:)   !! factors of the reflections in Q and P, which stand in the matrix
  end type two_diagonals

contains

  subroutine singular_values(matrix, count, values, left, right, info, monitor)
    !! The largest, descending, with their vectors on either side.
    real(dp), contiguous, intent(inout) :: matrix(:, :)               !! destroyed; not fewer rows than columns
    integer, intent(in) :: count                                      !! at most as many as columns
    real(dp), allocatable, intent(out) :: values(:)
    real(dp), allocatable, intent(out) :: left(:, :), right(:, :)     !! (rows, count), (columns, count)
    integer, intent(out) :: info                                      !! 0: LAPACK had no trouble
    class(monitor_type), intent(inout), optional :: monitor           !! nothing is found where it asks to stop
    type(two_diagonals) :: reduced
    real(dp), allocatable :: u(:, :), vt(:, :), work(:)
    integer, allocatable :: iwork(:)
    real(dp) :: unused(1)
    integer :: unused_too(1), m, n
    m = size(matrix, 1)
    n = size(matrix, 2)
    call reduce(m, n, matrix, reduced, info, monitor)
    if (stops(monitor)) return
    if (info /= 0) return
    allocate (u(n, n), vt(n, n), work(3*n**2 + 4*n), iwork(8*n))
    call dbdsdc('U', 'I', n, reduced%d, reduced%e, u, n, vt, n, unused, unused_too, work, iwork, info)
    if (info /= 0) return
    values = reduced%d(:count)
    allocate (left(m, count), right(n, count))
    left(:n, :) = u(:, :count)
    left(n + 1:, :) = 0.0_dp
    right = transpose(vt(:count, :))
    call carry_back('Q', matrix, reduced%tauq, left, info, monitor)
    call carry_back('P', matrix, reduced%taup, right, info, monitor)
  end subroutine singular_values

  subroutine reduce(m, n, a, reduced, info, monitor)
    !! To two diagonals. After every panel two products change what is not reduced yet.
    integer, intent(in) :: m, n
    real(dp), intent(inout) :: a(m, n)
    type(two_diagonals), intent(out) :: reduced
    integer, intent(out) :: info
    class(monitor_type), intent(inout), optional :: monitor
    real(dp), allocatable :: x(:, :), y(:, :), work(:)
    integer :: i, j, rows, columns
    allocate (reduced%d(n), reduced%e(n), reduced%tauq(n), reduced%taup(n), x(m, panel), y(n, panel), work(panel*(m + n)))
    info = 0
    i = 1
    associate (d => reduced%d, e => reduced%e, tauq => reduced%tauq, taup => reduced%taup)
      do while (n - i + 1 > fewest)
        call dlabrd(m - i + 1, n - i + 1, panel, a(i, i), m, d(i), e(i), tauq(i), taup(i), x, m, y, n)
        j = i + panel
        rows = m - j + 1
        columns = n - j + 1
        call dgemm('N', 'T', rows, columns, panel, -1.0_dp, a(j, i), m, y(panel + 1, 1), n, 1.0_dp, a(j, j), m)
        call dgemm('N', 'N', rows, columns, panel, -1.0_dp, x(panel + 1, 1), m, a(i, j), m, 1.0_dp, a(j, j), m)
        i = j
        if (stops(monitor)) return
      end do
      call dgebrd(m - i + 1, n - i + 1, a(i, i), m, d(i), e(i), tauq(i), taup(i), work, size(work), info)
    end associate
  end subroutine reduce

  subroutine carry_back(side, a, tau, vectors, info, monitor)
    !! Vectors of the two diagonals as those of the matrix.
    character, intent(in) :: side               !! 'Q': on the left, 'P': on the right
    real(dp), intent(inout) :: a(:, :)          !! with the reflections
    real(dp), intent(in) :: tau(:)
    real(dp), intent(inout) :: vectors(:, :)
    integer, intent(inout) :: info
    class(monitor_type), intent(inout), optional :: monitor
    real(dp), allocatable :: work(:)
    integer :: first
    allocate (work(panel*some + 65*64))         ! what dormbr asks for: blocks, and their triangular factors
    do first = 1, size(vectors, 2), some
      if (stops(monitor)) return
      associate (part => vectors(:, first:min(first + some - 1, size(vectors, 2))))
        if (info == 0) call dormbr(side, 'L', 'N', size(part, 1), size(part, 2), size(a, 2), a, size(a, 1), tau, &
                                   part, size(part, 1), work, size(work), info)
      end associate
    end do
  end subroutine carry_back

end module bw_singular_values
