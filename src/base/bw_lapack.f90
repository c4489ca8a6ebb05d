module bw_lapack
  !! Interfaces of BLAS and LAPACK procedures, all declared here so that the compiler checks every call. Names and
  !! arguments are those of the libraries' documentation. dgeqrt, dgemqrt and dgelsy fail only for wrong
  !! arguments, for which LAPACK itself stops: their info needs no check.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: ddot, dgbsvx, dgemm, dgesv, dgetrf, dgetrs, dtrsm
  public :: dpotrf, dpbtrf, dpotri, dgejsv, dgesdd, dgeqrt, dgemqrt, dgelsy, dlasrt, dsyev, dsygv, dsterf, zgbsv, zgeev, &
    & zgesv, zgesvd

  interface

    ! BLAS

    pure real(dp) function ddot(n, x, incx, y, incy)
      !! Σ x y.
      import :: dp
      integer, intent(in) :: n, incx, incy
      real(dp), intent(in) :: x(*), y(*)
    end function ddot

    pure subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
      !! C ← alpha·A B + beta·C, A and B as they are or transposed.
      import :: dp
      character, intent(in) :: transa, transb
      integer, intent(in) :: m, n, k, lda, ldb, ldc
      real(dp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)
      real(dp), intent(inout) :: c(ldc, *)
    end subroutine dgemm

    subroutine dtrsm(side, uplo, transa, diag, m, n, alpha, a, lda, b, ldb)
      !! B ← alpha·A⁻¹B or alpha·B A⁻¹, A triangular, as it is or transposed.
      import :: dp
      character, intent(in) :: side, uplo, transa, diag
      integer, intent(in) :: m, n, lda, ldb
      real(dp), intent(in) :: alpha, a(lda, *)
      real(dp), intent(inout) :: b(ldb, *)
    end subroutine dtrsm

    ! LAPACK

    subroutine dpotrf(uplo, n, a, lda, info)
      !! Cholesky's factor of a symmetric positive definite matrix; info > 0: it is not positive definite.
      import :: dp
      character, intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(dp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotrf

    subroutine dpbtrf(uplo, n, kd, ab, ldab, info)
      !! Cholesky's factor of a symmetric positive definite band matrix; info > 0: it is not positive definite.
      import :: dp
      character, intent(in) :: uplo
      integer, intent(in) :: n, kd, ldab
      real(dp), intent(inout) :: ab(ldab, *)
      integer, intent(out) :: info
    end subroutine dpbtrf

    subroutine dgejsv(joba, jobu, jobv, jobr, jobt, jobp, m, n, a, lda, sva, u, ldu, v, ldv, work, lwork, iwork, info)
      !! Singular values and vectors by Jacobi's method, each to its own digits where a matrix is a well conditioned one between two
      !! diagonal ones; values are work(1)/work(2)·sva.
      import :: dp
      character, intent(in) :: joba, jobu, jobv, jobr, jobt, jobp
      integer, intent(in) :: m, n, lda, ldu, ldv, lwork
      real(dp), intent(inout) :: a(lda, *)
      real(dp), intent(out) :: sva(*), u(ldu, *), v(ldv, *), work(*)
      integer, intent(out) :: iwork(*), info
    end subroutine dgejsv

    subroutine dgesdd(jobz, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, iwork, info)
      !! Singular values and vectors, to rounding of the largest value.
      import :: dp
      character, intent(in) :: jobz
      integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
      real(dp), intent(inout) :: a(lda, *)
      real(dp), intent(out) :: s(*), u(ldu, *), vt(ldvt, *), work(*)
      integer, intent(out) :: iwork(*), info
    end subroutine dgesdd

    subroutine dpotri(uplo, n, a, lda, info)
      !! The inverse of a symmetric positive definite matrix from Cholesky's factor; info > 0: there is none.
      import :: dp
      character, intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(dp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotri

    pure subroutine dgetrf(m, n, a, lda, ipiv, info)
      !! The factors of A by elimination; info > 0: A is singular.
      import :: dp
      integer, intent(in) :: m, n, lda
      real(dp), intent(inout) :: a(lda, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine dgetrf

    pure subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
      !! The solution of A X = B with the factors of dgetrf.
      import :: dp
      character, intent(in) :: trans
      integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
      real(dp), intent(in) :: a(lda, *)
      real(dp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dgetrs

    pure subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
      !! The solution of A X = B by elimination; info > 0: A is singular.
      import :: dp
      integer, intent(in) :: n, nrhs, lda, ldb
      real(dp), intent(inout) :: a(lda, *), b(ldb, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine dgesv

    pure subroutine dgbsvx(fact, trans, n, kl, ku, nrhs, ab, ldab, afb, ldafb, ipiv, equed, r, c, b, ldb, x, ldx, rcond, &
                           ferr, berr, work, iwork, info)
      !! Solve a banded system, equilibrated, with iterative refinement.
      import :: dp
      character, intent(in) :: fact, trans
      integer, intent(in) :: n, kl, ku, nrhs, ldab, ldafb, ldb, ldx
      real(dp), intent(inout) :: ab(ldab, *), afb(ldafb, *), r(*), c(*), b(ldb, *)
      real(dp), intent(out) :: x(ldx, *), rcond, ferr(*), berr(*), work(*)
      integer, intent(inout) :: ipiv(*)
      character, intent(inout) :: equed
      integer, intent(out) :: iwork(*), info
    end subroutine dgbsvx

    subroutine dgeqrt(m, n, nb, a, lda, t, ldt, work, info)
      !! A = QR by Householder reflections in blocks of nb columns.
      import :: dp
      integer, intent(in) :: m, n, nb, lda, ldt
      real(dp), intent(inout) :: a(lda, *), t(ldt, *), work(*)
      integer, intent(out) :: info
    end subroutine dgeqrt

    subroutine dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
      !! Eigenvalues and vectors of A x = w B x, both symmetric, B positive definite.
      import :: dp
      integer, intent(in) :: itype, n, lda, ldb, lwork
      character, intent(in) :: jobz, uplo
      real(dp), intent(inout) :: a(lda, *), b(ldb, *)
      real(dp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsygv

    subroutine dgemqrt(side, trans, m, n, k, nb, v, ldv, t, ldt, c, ldc, work, info)
      !! C ← QC, QᵀC, CQ or CQᵀ, Q from dgeqrt.
      import :: dp
      character, intent(in) :: side, trans
      integer, intent(in) :: m, n, k, nb, ldv, ldt, ldc
      real(dp), intent(in) :: v(ldv, *), t(ldt, *)
      real(dp), intent(inout) :: c(ldc, *), work(*)
      integer, intent(out) :: info
    end subroutine dgemqrt

    subroutine dgelsy(m, n, nrhs, a, lda, b, ldb, jpvt, rcond, rank, work, lwork, info)
      !! The shortest solution of least squares for a matrix that may lack rank.
      import :: dp
      integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
      real(dp), intent(inout) :: a(lda, *), b(ldb, *), work(*)
      integer, intent(inout) :: jpvt(*)
      real(dp), intent(in) :: rcond
      integer, intent(out) :: rank, info
    end subroutine dgelsy

    pure subroutine dlasrt(id, n, d, info)
      !! Numbers sorted, ascending where id is I.
      import :: dp
      character, intent(in) :: id
      integer, intent(in) :: n
      real(dp), intent(inout) :: d(*)
      integer, intent(out) :: info
    end subroutine dlasrt

    subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      !! All eigenvalues of a symmetric matrix, ascending, and with jobz = 'V' its eigenvectors in A.
      import :: dp
      character, intent(in) :: jobz, uplo
      integer, intent(in) :: n, lda, lwork
      real(dp), intent(inout) :: a(lda, *)
      real(dp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsyev

    subroutine dsterf(n, d, e, info)
      !! All eigenvalues of a symmetric tridiagonal matrix, ascending, without vectors.
      import :: dp
      integer, intent(in) :: n
      real(dp), intent(inout) :: d(*), e(*)
      integer, intent(out) :: info
    end subroutine dsterf

    subroutine zgeev(jobvl, jobvr, n, a, lda, w, vl, ldvl, vr, ldvr, work, lwork, rwork, info)
      !! Eigenvalues of a complex matrix, and their vectors where asked for.
      import :: dp
      character, intent(in) :: jobvl, jobvr
      integer, intent(in) :: n, lda, ldvl, ldvr, lwork
      complex(dp), intent(inout) :: a(lda, *), w(*), vl(ldvl, *), vr(ldvr, *), work(*)
      real(dp), intent(inout) :: rwork(*)
      integer, intent(out) :: info
    end subroutine zgeev

    pure subroutine zgbsv(n, kl, ku, nrhs, ab, ldab, ipiv, b, ldb, info)
      !! The solution of A X = B, A a band of kl diagonals below and ku above its own: A(i, j) is ab(kl + ku + 1 + i − j, j).
      import :: dp
      integer, intent(in) :: n, kl, ku, nrhs, ldab, ldb
      complex(dp), intent(inout) :: ab(ldab, *), b(ldb, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine zgbsv

    pure subroutine zgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
      !! The solution of A X = B by elimination; info > 0: A is singular.
      import :: dp
      integer, intent(in) :: n, nrhs, lda, ldb
      complex(dp), intent(inout) :: a(lda, *), b(ldb, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine zgesv

    subroutine zgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, rwork, info)
      !! All singular values of a complex matrix with their vectors.
      import :: dp
      character, intent(in) :: jobu, jobvt
      integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
      complex(dp), intent(inout) :: a(lda, *), u(ldu, *), vt(ldvt, *), work(*)
      real(dp), intent(inout) :: s(*), rwork(*)
      integer, intent(out) :: info
    end subroutine zgesvd
  end interface

end module bw_lapack
