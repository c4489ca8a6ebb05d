module gauss_legendre
  !! Gauss–Legendre quadrature on panels of [0, 1].
  use bw_constants, only: pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: panel_rule


contains

  subroutine panel_rule(panels, order, nodes, weights)
    !! Nodes and weights of `panels` equal panels with `order` nodes each: exact to rounding where the integrand turns
    !! by less than a full turn in a panel of 12 nodes, 20 turns in one of 64.
    integer, intent(in) :: panels, order
    real(dp), allocatable, intent(out) :: nodes(:), weights(:)     !! (order·panels)
    real(dp) :: x(order), slope(order)
    integer :: p
    call legendre_roots(x, slope)
    nodes = [((p + 0.5_dp*(1.0_dp + x))/panels, p=0, panels - 1)]
    weights = [(1.0_dp/((1.0_dp - x**2)*slope**2*panels), p=1, panels)]
  end subroutine panel_rule

  subroutine legendre_roots(x, slope)
    !! Roots of the Legendre polynomial and its derivative there, by Newton's method.
    real(dp), intent(out) :: x(:), slope(:)
    real(dp), dimension(size(x)) :: value, last, next
    integer :: i, n, order
    order = size(x)
    x = cos(pi*([(i, i=1, order)] - 0.25_dp)/(order + 0.5_dp))
    do i = 1, 6
      last = 1.0_dp
      value = x
      do n = 2, order
        next = ((2*n - 1)*x*value - (n - 1)*last)/n
        last = value
        value = next
      end do
      slope = order*(x*value - last)/(x**2 - 1.0_dp)
      x = x - value/slope
    end do
  end subroutine legendre_roots

end module gauss_legendre
