module bw_autoregression
  !! Autoregressions of noise: Burg's recursion over runs of valid samples, and Levinson's from a smooth spectrum.
  !!
  !! The prediction error of order p is e_n = Σ h_i x_(n+i), i = 0 … p, h_0 = 1: each sample is predicted from those after it. Noise
  !! has the same predictor in both directions of time, but a free decay begins suddenly: this way no sample after a blow is lost.
  !! Source: Burg (1975); Kay, Modern Spectral Estimation (1988).
  use bw_constants, only: pi
  use bw_fourier, only: real_fourier
  use bw_gap_products, only: gap_products
  use bw_kinds, only: dp
  use bw_lag_products, only: lag_products
  use bw_order, only: quantile_of
  implicit none (type, external)
  private
  public :: burg, robust_levels, running_median

  integer, parameter, public :: samples_per_order = 10   !! tuned: fewer do not determine so high an order
  real(dp), parameter :: least_part = 1.0e-14_dp  !! of the variance: smallest prediction error
  real(dp), parameter :: least_level = 1.0e-12_dp !! of the variance, that a predictor from correlations leaves
  integer, parameter :: patience = 24             !! tuned: orders without a gain after which Burg's recursion ends
  integer, parameter :: robust_order = 24         !! tuned: order of the first estimate, enough for smooth levels
  integer, parameter :: work_of_form = 4          !! tuned: work of a product of samples in a form, in that of a prediction error

  type, public :: autoregression
    !! Noise of one sensor.
    real(dp), allocatable :: predictor(:)         !! h, (0:p)
    real(dp) :: variance = 0                      !! of its prediction error
    real(dp) :: cost = 0                          !! −2 ln L plus the penalty of its coefficients
  end type autoregression

contains

  subroutine burg(x, valid, highest, penalty, noise, covariances)
    !! Fit the autoregression whose order minimises −2 ln L + order·penalty. L is exact: the last samples of a run are predicted
    !! from fewer, with the variance of that prediction, and all variances together are scaled to fit best. A motion that begins
    !! loudly and decays is therefore unlikely as noise, however predictable it is.
    real(dp), intent(in) :: x(:)
    integer, intent(in) :: valid(:, :)            !! first and last sample of each run of valid samples, (2, runs)
    integer, intent(in) :: highest                !! order
    real(dp), intent(in) :: penalty               !! per coefficient
    type(autoregression), intent(out) :: noise
    type(gap_products), intent(inout), optional :: covariances   !! of samples filled with expectations
    real(dp), allocatable :: ahead(:), behind(:)  !! prediction errors of x_n from later samples, and of x_(n+p) from earlier ones
    real(dp) :: reflection(highest), h(0:highest), variance, cost, logarithms, total, level
    real(dp) :: sums(3)                           !! Σ a², Σ ab and Σ b² of errors ahead and behind that the next order pairs
    integer, allocatable :: runs(:, :)            !! longer than the order
    type(lag_products) :: products
    logical :: by_products                        !! the sums follow without errors, which from here on are not known
    integer :: p, r, count, best, rows
    runs = valid
    count = max(1, sum(runs(2, :) - runs(1, :) + 1))
    rows = count
    h = 0
    h(0) = 1
    by_products = size(runs, 2) == 1
    if (by_products) call products%start(x(runs(1, 1):runs(2, 1)))
    call find_sums(0)
    variance = max((sums(1) + sum(x(runs(2, :))**2))/count, tiny(1.0_dp))
    noise%variance = variance
    noise%cost = count*log(variance)
    logarithms = 0
    total = 0
    best = 0
    do p = 1, highest
      if (p - best > patience) exit
      runs = runs(:, pack([(r, r=1, size(runs, 2))], runs(2, :) - runs(1, :) + 1 >= p))  ! each has a sample number p
      if (size(runs, 2) == 0) exit
      logarithms = logarithms + size(runs, 2)*log(variance)
      total = total + sum(last_errors(p - 1)**2)/variance
      rows = rows - size(runs, 2)
      if (.not. sums(1) + sums(3) > 0) exit
      reflection(p) = -2*sums(2)/(sums(1) + sums(3))
      h(:p) = h(:p) + reflection(p)*h(p:0:-1)
      call find_sums(p)
      variance = variance*max(1 - reflection(p)**2, least_part)
      level = (total + (sums(1) + sum(last_errors(p)**2, mask=runs(2, :) - p >= runs(1, :)))/variance)/count
      cost = logarithms + rows*log(variance) + count*log(level) + p*penalty
      if (cost >= noise%cost) cycle
      best = p
      noise%cost = cost
      noise%variance = variance*level
    end do
    allocate (noise%predictor(0:best), source=predictor_of(reflection(:best)))

  contains

    subroutine find_sums(order)
      !! Find the sums of this order, one higher than in the call before.
      integer, intent(in) :: order
      call find_own_sums(order)
      if (present(covariances)) call covariances%add_sums(h(:order), sums)
    end subroutine find_sums

    subroutine find_own_sums(order)
      !! Find the sums from products, or from errors if that is less work or products lose too many digits.
      integer, intent(in) :: order
      integer :: q
      if (by_products) then
        call products%grow(x(runs(1, 1):runs(2, 1)))
        call products%find_sums(h(:order), sums, by_products)
        by_products = by_products .and. (order + 1)**2 < count/work_of_form
        if (by_products) return
      end if
      do q = merge(order, 0, allocated(ahead)), order
        sums = 0
        if (q == 0) ahead = x
        if (q == 0) behind = x
        do r = 1, size(runs, 2)                   ! behind(n) is then the error of x_(n+q)
          if (q == 0) call add_stage(0.0_dp, ahead(runs(1, r):runs(2, r)), behind(runs(1, r):runs(2, r)), sums)
          if (q > 0) call add_stage(reflection(q), ahead(runs(1, r):runs(2, r) - q), behind(runs(1, r):runs(2, r) - q + 1), sums)
        end do
      end do
    end subroutine find_own_sums

    pure function last_errors(order) result(errors)
      !! The error of the last sample of each run; 0 if the run has none of this order.
      integer, intent(in) :: order
      real(dp) :: errors(size(runs, 2))
      integer :: k
      do k = 1, size(runs, 2)
        associate (n => runs(2, k) - order)
          errors(k) = 0
          if (n < runs(1, k)) cycle
          if (by_products) errors(k) = dot_product(h(:order), x(n:n + order))
          if (.not. by_products) errors(k) = ahead(n)
        end associate
      end do
    end function last_errors

  end subroutine burg

  pure subroutine add_stage(reflection, ahead, behind, sums)
    !! Extend the predictor by one sample, and add the products of errors for the next stage: Σ a², Σ ab, Σ b² of a_n, b_(n+1).
    real(dp), intent(in) :: reflection
    real(dp), intent(inout), contiguous :: ahead(:)
    real(dp), intent(inout), contiguous :: behind(:)     !! (as many) before a first stage, otherwise one more
    real(dp), intent(inout) :: sums(3)
    integer, parameter :: lanes = 8               !! parallel sums, for vector instructions
    integer, parameter :: at_once = 128*lanes     !! rows that fit a processor's cache
    real(dp) :: part(lanes, 3), old, a(lanes), b(lanes)
    integer :: first, last, n, next, by
    by = size(behind) - size(ahead)
    part = 0
    next = 1
    do first = 1, size(ahead), at_once
      last = min(size(ahead), first + at_once - 1)
      do n = first, last
        old = behind(n + by)
        behind(n) = old + reflection*ahead(n)
        ahead(n) = ahead(n) + reflection*old
      end do
      do next = next, last - lanes, lanes
        a = ahead(next:next + lanes - 1)
        b = behind(next + 1:next + lanes)
        part(:, 1) = part(:, 1) + a*a
        part(:, 2) = part(:, 2) + a*b
        part(:, 3) = part(:, 3) + b*b
      end do
    end do
    do n = next, size(ahead) - 1
      part(1, :) = part(1, :) + [ahead(n)**2, ahead(n)*behind(n + 1), behind(n + 1)**2]
    end do
    sums = sums + sum(part, dim=1)
  end subroutine add_stage

  pure function predictor_of(reflection) result(h)
    !! The predictor h with given reflection coefficients, (0:p).
    real(dp), intent(in) :: reflection(:)
    real(dp) :: h(0:size(reflection))
    integer :: p
    h = 0
    h(0) = 1
    do p = 1, size(reflection)
      h(:p) = h(:p) + reflection(p)*h(p:0:-1)
    end do
  end function predictor_of

  subroutine robust_levels(x, valid_count, penalty, fourier, noise)
    !! Fit an autoregression to the running median of a periodogram, which lines hardly raise.
    real(dp), intent(in) :: x(:)                  !! 0 where a sample is missing
    integer, intent(in) :: valid_count            !! number of the others
    real(dp), intent(in) :: penalty               !! of a coefficient
    type(real_fourier), intent(inout) :: fourier
    type(autoregression), intent(out) :: noise
    real(dp), allocatable :: power(:), level(:), window(:)
    real(dp) :: lag(0:robust_order), reflection(robust_order), h(0:robust_order), variance, cost, least, turn
    integer :: n, p, k, best, half
    n = size(x)
    window = [(sin(pi*k/n)**2, k=0, n - 1)]
    call fourier%prepare(n)
    fourier%samples(:) = window*x
    call fourier%transform()
    power = abs(fourier%spectrum)**2/(sum(window**2)*max(1, valid_count)/n)
    half = max(12, nint(1.5_dp*sqrt(real(n, dp))))  ! tuned: number of bins, more than lines occupy
    level = running_median(power(min(3, size(power)):), half)/log(2.0_dp)
    lag = 0                                       ! correlations: the level times cos pθ, by recursion in p
    do k = 1, size(level)
      turn = cos(pi*(k - 0.5_dp)/size(level))
      h(:1) = level(k)*[1.0_dp, turn]
      do p = 2, robust_order
        h(p) = 2*turn*h(p - 1) - h(p - 2)
      end do
      lag = lag + h/size(level)
    end do
    variance = max(lag(0), tiny(1.0_dp))
    least = valid_count*log(variance)
    noise%variance = variance
    best = 0
    h = 0
    h(0) = 1
    do p = 1, min(robust_order, n/16)
      reflection(p) = -dot_product(h(:p - 1), lag(p:1:-1))/variance
      if (.not. variance*(1 - reflection(p)**2) > least_level*lag(0)) exit   ! the correlations have no more digits
      h(:p) = h(:p) + reflection(p)*h(p:0:-1)
      variance = variance*(1 - reflection(p)**2)
      cost = valid_count*log(variance) + p*penalty
      if (cost >= least) cycle
      least = cost
      best = p
      noise%variance = variance
    end do
    allocate (noise%predictor(0:best), source=predictor_of(reflection(:best)))
    noise%cost = least
  end subroutine robust_levels

  pure function running_median(power, half) result(level)
    !! Medians of `half` neighbours on either side, at every half of these, with geometric interpolation in between.
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
