module bw_gauss
  !! Gauss's rule for integrals over [0, 1]: nodes are the eigenvalues of the matrix of ξ in Legendre's polynomials, by
  !! LAPACK, weights 1/Σp_j² there (Golub and Welsch 1969).
  use bw_kinds, only: dp
  use bw_strain_basis, only: basis_values
  implicit none (type, external)
  private
  public :: gauss_rule

  interface
    subroutine dsterf(n, d, e, info)
      import :: dp
      implicit none (type, external)
      integer, intent(in) :: n
      real(dp), intent(inout) :: d(*), e(*)
      integer, intent(out) :: info
    end subroutine dsterf
  end interface

contains

  subroutine gauss_rule(n, node, weight)
    !! Exact for polynomials up to degree 2n − 1.
    integer, intent(in) :: n                             !! ≥ 1
    real(dp), allocatable, intent(out) :: node(:), weight(:)   !! ascending, (n)
    real(dp) :: below(n)
    integer :: j, info
    allocate (node(n), source=0.5_dp)
    below = [(0.5_dp*j/sqrt((2.0_dp*j - 1.0_dp)*(2.0_dp*j + 1.0_dp)), j=1, n)]
    call dsterf(n, node, below, info)
    weight = 1.0_dp/sum(basis_values(n, node)**2, dim=1)
  end subroutine gauss_rule

end module bw_gauss
