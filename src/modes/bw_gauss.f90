module bw_gauss
  !! Gauss's rule for integrals over [0, 1], by LAPACK: nodes are the eigenvalues of the matrix of ξ in Legendre's
  !! polynomials, weights the squares of the first components of its vectors (Golub and Welsch 1969).
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: gauss_rule

  interface
    subroutine dsteqr(compz, n, d, e, z, ldz, work, info)
      import :: dp
      implicit none (type, external)
      character, intent(in) :: compz
      integer, intent(in) :: n, ldz
      real(dp), intent(inout) :: d(*), e(*), z(ldz, *), work(*)
      integer, intent(out) :: info
    end subroutine dsteqr
  end interface

contains

  subroutine gauss_rule(n, node, weight)
    !! Exact for polynomials up to degree 2n − 1.
    integer, intent(in) :: n                             !! ≥ 1
    real(dp), allocatable, intent(out) :: node(:), weight(:)   !! ascending, (n)
    real(dp) :: below(n), vectors(n, n), work(2*n)
    integer :: j, info
    allocate (node(n), source=0.5_dp)
    below = [(0.5_dp*j/sqrt((2.0_dp*j - 1.0_dp)*(2.0_dp*j + 1.0_dp)), j=1, n)]
    call dsteqr('I', n, node, below, vectors, n, work, info)
    weight = vectors(1, :)**2
  end subroutine gauss_rule

end module bw_gauss
