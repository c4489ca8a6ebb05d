module bw_lag_products
  !! Sums of squared prediction errors without the errors: they are quadratic forms of a predictor in G_ij = Σ x_(n+i) x_(n+j),
  !! which follows from products of samples at given lags, and from the samples at both ends.
  !!
  !! One pass over a long record thus serves all orders. But a small error is a difference of large sums, and loses digits
  !! accordingly. Source: Vos (2013), A Fast Implementation of Burg's Method.
  use bw_kinds, only: dp
  use bw_lapack, only: ddot
  implicit none (type, external)
  private

  integer, parameter :: at_once = 1024             !! samples that fit a processor's cache
  integer, parameter :: group = 32                 !! lags found in one pass
  real(dp), parameter :: least_part = 1.0e-8_dp    !! of its terms; a smaller sum has lost half its digits

  type, public :: lag_products
    real(dp), allocatable, private :: lag(:)       !! Σ x_n x_(n+d) at d + 1
    real(dp), allocatable, private :: gram(:, :)   !! G, n = 1 … N − m, (0:m, 0:m)
  contains
    procedure :: start
    procedure :: grow
    procedure :: find_sums
  end type lag_products

contains

  pure subroutine start(self, x)
    !! Find G for m = 0.
    class(lag_products), intent(inout) :: self
    real(dp), intent(in), contiguous :: x(:)
    allocate (self%lag(0))
    call add_lags(x, self%lag)
    allocate (self%gram(0:0, 0:0), source=self%lag(1))
  end subroutine start

  pure subroutine grow(self, x)
    !! Extend G to the next m.
    class(lag_products), intent(inout) :: self
    real(dp), intent(in), contiguous :: x(:)
    real(dp), allocatable :: larger(:, :)
    integer :: m, n, j
    m = ubound(self%gram, 1)
    n = size(x)
    if (m + 2 > size(self%lag)) call add_lags(x, self%lag)
    allocate (larger(0:m + 1, 0:m + 1))
    do j = 0, m
      larger(:m, j) = self%gram(:, j) - x(n - m:)*x(n - m + j)
    end do
    larger(0, m + 1) = self%lag(m + 2)
    larger(1:, m + 1) = self%gram(:, m) - x(:m + 1)*x(m + 1)
    larger(m + 1, :m) = larger(:m, m + 1)
    call move_alloc(larger, self%gram)
  end subroutine grow

  pure subroutine add_lags(x, lag)
    !! Add products of samples at larger lags.
    real(dp), intent(in), contiguous :: x(:)
    real(dp), allocatable, intent(inout) :: lag(:)
    real(dp) :: more(group)
    integer :: first, k, n, d
    more = 0
    do first = 1, size(x), at_once
      do k = 1, group
        d = size(lag) + k - 1
        n = min(at_once, size(x) - d - first + 1)
        if (n > 0) more(k) = more(k) + ddot(n, x(first:), 1, x(first + d:), 1)
      end do
    end do
    lag = [lag, more]
  end subroutine add_lags

  pure subroutine find_sums(self, h, sums, accurate)
    !! Find Σ a², Σ ab and Σ b² of the errors ahead of a predictor of order m − 1, and of those behind at the next sample.
    class(lag_products), intent(in) :: self
    real(dp), intent(in) :: h(0:)                  !! (0:m − 1)
    real(dp), intent(out) :: sums(3)
    logical, intent(out) :: accurate               !! to some digits
    real(dp), dimension(0:size(h)) :: ahead, behind
    ahead = [h, 0.0_dp]
    behind = ahead(size(h):0:-1)
    sums = [dot_product(ahead, matmul(self%gram, ahead)), dot_product(ahead, matmul(self%gram, behind)), &
      & dot_product(behind, matmul(self%gram, behind))]
    accurate = min(sums(1), sums(3)) > least_part*sum(abs(h))**2*self%lag(1)
  end subroutine find_sums

end module bw_lag_products
