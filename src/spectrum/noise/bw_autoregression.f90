module bw_autoregression
  !! Autoregressions of noise: Burg's recursion over runs of valid samples, and Levinson's from a spectrum's level.
  !!
  !! The prediction error of order p is e_n = Σ h_i x_(n+i), i = 0 … p, h_0 = 1: each sample is predicted from those behind it. Noise
  !! has the same predictor in both directions of time. But a free decay begins at once, and this way no sample after the blow is lost.
  !! Source: Burg (1975); Kay, Modern Spectral Estimation (1988).
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_order, only: quantile_of
  implicit none (type, external)
  private
  public :: burg, robust_levels, running_median

  real(dp), parameter :: least_part = 1.0e-14_dp  !! of the variance, that a predictor leaves
  integer, parameter :: patience = 24             !! tuned: orders without a gain after which Burg's recursion ends
  integer, parameter :: robust_order = 24         !! tuned: of the first guess, which smooth levels need

  type, public :: autoregression
    !! Noise of one sensor.
    real(dp), allocatable :: predictor(:)         !! h, (0:p)
    real(dp) :: variance = 0                      !! of its prediction error
    real(dp) :: cost = 0                          !! −2 ln L, and the price of its coefficients
  end type autoregression

contains

  pure subroutine burg(x, valid, highest, price, noise)
    !! Fit the autoregression whose order makes −2 ln L + order·price least. L is exact: the last samples of a run are predicted from
    !! fewer, with the variance that this leaves, and all variances together are scaled to fit best. So a motion that begins loudly and
    !! dies is no noise, however well it can be predicted.
    real(dp), intent(in) :: x(:)
    integer, intent(in) :: valid(:, :)            !! first and last sample of each run that counts, (2, runs)
    integer, intent(in) :: highest                !! order
    real(dp), intent(in) :: price                 !! of a coefficient
    type(autoregression), intent(out) :: noise
    real(dp), allocatable :: ahead(:), behind(:)  !! prediction errors of x_n from what follows, and of x_(n+p) from what is before
    real(dp) :: reflection(highest), products, squares, variance, cost, logarithms, total, level
    integer, allocatable :: runs(:, :)            !! that are longer than the order
    integer :: p, r, n, count, best, rows
    runs = valid
    count = max(1, sum(runs(2, :) - runs(1, :) + 1))
    rows = count
    ahead = x
    variance = max(sum_of_squares()/count, tiny(1.0_dp))
    noise%variance = variance
    noise%cost = count*log(variance)
    logarithms = 0
    total = 0
    best = 0
    behind = x
    do p = 1, highest
      if (p - best > patience) exit
      runs = runs(:, pack([(r, r=1, size(runs, 2))], runs(2, :) - runs(1, :) + 1 >= p))  ! as many have a sample number p
      if (size(runs, 2) == 0) exit
      logarithms = logarithms + size(runs, 2)*log(variance)
      total = total + sum(ahead(runs(2, :) - p + 1)**2)/variance
      rows = rows - size(runs, 2)
      products = 0
      squares = 0
      do r = 1, size(runs, 2)
        associate (a => ahead(runs(1, r):runs(2, r) - p), b => behind(runs(1, r) + 1:runs(2, r) - p + 1))
          products = products + product_of(a, b)
          squares = squares + product_of(a, a) + product_of(b, b)
        end associate
      end do
      if (.not. squares > 0) exit
      reflection(p) = -2*products/squares
      do r = 1, size(runs, 2)
        do n = runs(1, r), runs(2, r) - p         ! behind(n) is then that of x_(n+p)
          associate (a => ahead(n), b => behind(n + 1))
            behind(n) = b + reflection(p)*a
            ahead(n) = a + reflection(p)*b
          end associate
        end do
      end do
      variance = variance*max(1 - reflection(p)**2, least_part)
      runs(2, :) = runs(2, :) - p
      level = (total + sum_of_squares()/variance)/count
      runs(2, :) = runs(2, :) + p
      cost = logarithms + rows*log(variance) + count*log(level) + p*price
      if (cost >= noise%cost) cycle
      best = p
      noise%cost = cost
      noise%variance = variance*level
    end do
    allocate (noise%predictor(0:best), source=predictor_of(reflection(:best)))

  contains

    pure real(dp) function sum_of_squares()
      !! Of the prediction errors of all runs.
      integer :: i
      sum_of_squares = sum([(product_of(ahead(runs(1, i):runs(2, i)), ahead(runs(1, i):runs(2, i))), i=1, size(runs, 2))])
    end function sum_of_squares

  end subroutine burg

  pure real(dp) function product_of(a, b) result(total)
    !! Σ ab, in eight sums side by side, which a processor adds at once.
    real(dp), intent(in), contiguous :: a(:), b(:)
    real(dp) :: part(8)
    integer :: n
    part = 0
    do n = 1, size(a) - 7, 8
      part = part + a(n:n + 7)*b(n:n + 7)
    end do
    total = sum(part) + dot_product(a(n:), b(n:))
  end function product_of

  pure function predictor_of(reflection) result(h)
    !! The predictor h of given reflection coefficients, (0:p).
    real(dp), intent(in) :: reflection(:)
    real(dp) :: h(0:size(reflection))
    integer :: p
    h = 0
    h(0) = 1
    do p = 1, size(reflection)
      h(:p) = h(:p) + reflection(p)*h(p:0:-1)
    end do
  end function predictor_of

  subroutine robust_levels(x, price, fourier, noise)
    !! Fit an autoregression to the running median of a periodogram, which lines do not lift.
    real(dp), intent(in) :: x(:)
    real(dp), intent(in) :: price                 !! of a coefficient
    type(real_fourier), intent(inout) :: fourier
    type(autoregression), intent(out) :: noise
    real(dp), allocatable :: power(:), level(:), window(:)
    real(dp) :: lag(0:robust_order), reflection(robust_order), h(0:robust_order), variance, cost, least
    integer :: n, p, k, best, half
    n = size(x)
    window = [(sin(acos(-1.0_dp)*k/n)**2, k=0, n - 1)]
    call fourier%prepare(n)
    fourier%samples(:) = window*x
    call fourier%transform()
    power = abs(fourier%spectrum)**2/sum(window**2)
    half = max(12, nint(1.5_dp*sqrt(real(n, dp))))  ! tuned: bins, more than lines fill
    level = running_median(power(min(3, size(power)):), half)/log(2.0_dp)
    do p = 0, robust_order                        ! the level's transform: correlations
      lag(p) = 0
      do k = 1, size(level)
        lag(p) = lag(p) + level(k)*cos(acos(-1.0_dp)*p*(k - 0.5_dp)/size(level))
      end do
      lag(p) = lag(p)/size(level)
    end do
    variance = max(lag(0), tiny(1.0_dp))
    least = n*log(variance)
    noise%variance = variance
    best = 0
    h = 0
    h(0) = 1
    do p = 1, min(robust_order, n/16)
      reflection(p) = -dot_product(h(:p - 1), lag(p:1:-1))/variance
      h(:p) = h(:p) + reflection(p)*h(p:0:-1)
      variance = variance*max(1 - reflection(p)**2, 1.0e-12_dp)
      cost = n*log(variance) + p*price
      if (cost >= least) cycle
      least = cost
      best = p
      noise%variance = variance
    end do
    allocate (noise%predictor(0:best), source=predictor_of(reflection(:best)))
    noise%cost = least
  end subroutine robust_levels

  pure function running_median(power, half) result(level)
    !! Medians of so many neighbours on either side, every half of these, and geometric means between.
    real(dp), intent(in) :: power(:)
    integer, intent(in) :: half
    real(dp) :: level(size(power)), before, now
    integer :: first, last, n, k
    n = size(power)
    last = 1
    before = median_at(1)
    do while (last < n)
      first = last
      last = min(n, first + max(1, half/2))
      now = median_at(last)
      level(first:last) = [(exp(before + (now - before)*(k - first)/(last - first)), k=first, last)]
      before = now
    end do

  contains

    pure real(dp) function median_at(place)
      integer, intent(in) :: place
      median_at = log(max(quantile_of(power(max(1, place - half):min(n, place + half)), 0.5_dp), tiny(1.0_dp)))
    end function median_at

  end function running_median

end module bw_autoregression
