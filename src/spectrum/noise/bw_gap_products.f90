module bw_gap_products
  !! Contributions of missing samples' covariances to squares of prediction errors: quadratic forms of a predictor in
  !! G_ij = Σ C(n + i, n + j), which follows from sums of covariances at given lags, and from those at both ends.
  use bw_kinds, only: dp
  implicit none (type, external)
  private

  type, public :: gap_products
    integer, private :: order = -1               !! m, of G
    real(dp), allocatable, private :: lag(:)     !! Σ C(n, n + d), (0:reach)
    real(dp), allocatable, private :: first(:, :), last(:, :)   !! C of the first samples of pieces, and of the last ones in
      !! reverse order, (0:reach, 0:reach)
    real(dp), allocatable, private :: gram(:, :) !! G, n = 1 … N − m, (0:reach, 0:reach) of which (0:m, 0:m)
  contains
    procedure :: start
    procedure :: add
    procedure :: scale
    procedure :: add_sums
  end type gap_products

contains

  pure subroutine start(self, reach)
    !! Start with no covariances.
    class(gap_products), intent(inout) :: self
    integer, intent(in) :: reach                 !! order of a predictor plus 1
    allocate (self%lag(0:reach), self%first(0:reach, 0:reach), self%last(0:reach, 0:reach), self%gram(0:reach, 0:reach), &
      & source=0.0_dp)
  end subroutine start

  pure subroutine add(self, place, count, covariance)
    !! Add the covariances of a piece, which is longer than `reach`.
    class(gap_products), intent(inout) :: self
    integer, intent(in) :: place(:)              !! of missing samples in the piece, ascending
    integer, intent(in) :: count                 !! number of samples of the piece
    real(dp), intent(in) :: covariance(0:, :)    !! of missing samples j and j + k, (0:band, missing)
    integer :: j, k, d, reach
    reach = ubound(self%lag, 1)
    do j = 1, size(place)
      do k = 0, min(ubound(covariance, 1), size(place) - j)
        d = place(j + k) - place(j)
        if (d > reach) exit
        self%lag(d) = self%lag(d) + covariance(k, j)
        if (place(j + k) <= reach + 1) call put(place(j) - 1, place(j + k) - 1, covariance(k, j), self%first)
        if (place(j) >= count - reach) call put(count - place(j), count - place(j + k), covariance(k, j), self%last)
      end do
    end do
  end subroutine add

  pure subroutine put(i, j, value, matrix)
    !! Add to two elements of a symmetric matrix.
    integer, intent(in) :: i, j
    real(dp), intent(in) :: value
    real(dp), intent(inout) :: matrix(0:, 0:)
    matrix(i, j) = matrix(i, j) + value
    if (i /= j) matrix(j, i) = matrix(j, i) + value
  end subroutine put

  pure subroutine scale(self, factor)
    !! Multiply all covariances by a factor.
    class(gap_products), intent(inout) :: self
    real(dp), intent(in) :: factor
    self%lag = factor*self%lag
    self%first = factor*self%first
    self%last = factor*self%last
  end subroutine scale

  pure subroutine add_sums(self, h, sums)
    !! Add the contributions to Σ a², Σ ab and Σ b² of the errors ahead of a predictor, and of those behind at the next sample.
    class(gap_products), intent(inout) :: self
    real(dp), intent(in) :: h(0:)                !! of no lower order than in earlier calls
    real(dp), intent(inout) :: sums(3)
    real(dp), dimension(0:size(h)) :: ahead, behind, product
    integer :: m
    do while (self%order < size(h))
      m = self%order
      associate (g => self%gram)
        g(0, m + 1) = self%lag(m + 1)
        if (m >= 0) g(1:m + 1, m + 1) = g(:m, m) - self%first(:m, m)
        if (m >= 0) g(:m, :m) = g(:m, :m) - self%last(m:0:-1, m:0:-1)
        g(m + 1, :m) = g(:m, m + 1)
      end associate
      self%order = m + 1
    end do
    ahead = [h, 0.0_dp]
    behind = ahead(size(h):0:-1)
    m = size(h)
    product = matmul(self%gram(:m, :m), ahead)
    sums(1:2) = sums(1:2) + [dot_product(ahead, product), dot_product(behind, product)]
    sums(3) = sums(3) + dot_product(behind, matmul(self%gram(:m, :m), behind))
  end subroutine add_sums

end module bw_gap_products
