module bw_noise_with_gaps
  !! Autoregressions of noise with missing samples, by expectation and maximisation.
  !!
  !! Missing samples are replaced by their conditional expectations under an autoregression, and Burg's recursion over whole
  !! stretches, with the conditional covariances added to its sums, gives the next one. Each step lowers the exact −2 ln L of the
  !! valid samples: the squares with missing samples filled, and the determinant of the block Q of the precision matrix for missing
  !! samples, whose inverse is their covariance. Sources: Dempster, Laird and Rubin (1977), J. R. Stat. Soc. B 39; Siddiqui (1958),
  !! Ann. Math. Stat. 29, for the precision matrix; Erisman and Tinney (1975), Commun. ACM 18, for parts of an inverse.
  use bw_autoregression, only: autoregression, burg
  use bw_gap_products, only: gap_products
  use bw_kinds, only: dp
  use bw_missing_samples, only: factorise, solve
  use bw_noise, only: whiten
  implicit none (type, external)
  private
  public :: fit_with_gaps

  integer, parameter :: most_steps = 8
  integer, parameter :: ample = 10               !! orders: so long runs lose little at a gap between them
  real(dp), parameter :: enough = 1             !! penalty of a coefficient, that a step must gain for another

contains

  subroutine fit_with_gaps(x, runs, stretches, highest, penalty, noise)
    !! Fit the autoregression whose order minimises −2 ln L + order·penalty. Runs of valid samples are independent across gaps
    !! longer than the highest order, and in short parts.
    real(dp), intent(in) :: x(:)                 !! 0 where a sample is missing
    integer, intent(in) :: runs(:, :)            !! first and last sample of each run of valid samples, (2, runs)
    integer, intent(in) :: stretches(:, :)       !! first and last sample of each, (2, stretches)
    integer, intent(in) :: highest               !! order
    real(dp), intent(in) :: penalty              !! per coefficient
    type(autoregression), intent(inout) :: noise   !! with the initial predictor, if there is one
    type(autoregression) :: next
    type(gap_products) :: covariances
    integer, allocatable :: pieces(:, :)
    logical, allocatable :: valid(:)
    real(dp) :: filled(size(x)), gain
    integer :: r, step
    pieces = pieces_of(runs, stretches, highest)
    if (allocated(noise%predictor)) then
      if (ubound(noise%predictor, 1) > highest) deallocate (noise%predictor)
    end if
    if (size(pieces, 2) == size(runs, 2) .or. .not. allocated(noise%predictor)) call burg(x, runs, highest, penalty, noise)
    if (size(pieces, 2) == size(runs, 2)) return
    allocate (valid(size(x)), source=.false.)
    do r = 1, size(runs, 2)
      valid(runs(1, r):runs(2, r)) = .true.
    end do
    call expect(x, valid, pieces, highest, penalty, noise, filled, covariances)
    do step = 1, most_steps
      call burg(filled, pieces, highest, penalty, next, covariances)
      call expect(x, valid, pieces, highest, penalty, next, filled, covariances)
      gain = noise%cost - next%cost
      if (gain > 0) noise = next
      if (gain < enough*penalty) return
    end do
  end subroutine fit_with_gaps

  pure function pieces_of(runs, stretches, highest) result(pieces)
    !! Join runs across short gaps unless both are long; where that gives no long piece, keep the single runs.
    integer, intent(in) :: runs(:, :), stretches(:, :)
    integer, intent(in) :: highest
    integer, allocatable :: pieces(:, :)
    integer :: first, last, used
    allocate (pieces(2, size(runs, 2)))
    used = 0
    last = 0
    do while (last < size(runs, 2))
      first = last + 1
      last = first
      do while (last < size(runs, 2))
        if (runs(1, last + 1) - runs(2, last) > highest) exit
        if (all(runs(2, last:last + 1) - runs(1, last:last + 1) > ample*highest)) exit
        if (any(stretches(1, :) > runs(2, last) .and. stretches(1, :) <= runs(1, last + 1))) exit
        last = last + 1
      end do
      if (runs(2, last) - runs(1, first) > 2*highest + 2) then
        used = used + 1
        pieces(:, used) = [runs(1, first), runs(2, last)]
      else
        pieces(:, used + 1:used + last - first + 1) = runs(:, first:last)
        used = used + last - first + 1
      end if
    end do
    pieces = pieces(:, :used)
  end function pieces_of

  subroutine expect(x, valid, pieces, highest, penalty, noise, filled, covariances)
    !! Fill missing samples with their expectations, and find their covariances and the noise's variance and cost.
    real(dp), intent(in) :: x(:)
    logical, intent(in) :: valid(:)
    integer, intent(in) :: pieces(:, :)
    integer, intent(in) :: highest
    real(dp), intent(in) :: penalty
    type(autoregression), intent(inout) :: noise
    real(dp), intent(out) :: filled(:)
    type(gap_products), intent(out) :: covariances   !! over the variance, until that is known
    real(dp), allocatable :: rows(:), inverse(:, :)
    integer, allocatable :: place(:)
    real(dp) :: squares, logarithms, part, logarithm
    integer :: i, k, valid_count
    filled = x
    valid_count = 0
    squares = 0
    logarithms = 0
    call covariances%start(highest + 1)
    do i = 1, size(pieces, 2)
      associate (first => pieces(1, i), last => pieces(2, i), p => ubound(noise%predictor, 1))
        place = pack([(k, k=1, last - first + 1)], .not. valid(first:last))
        valid_count = valid_count + last - first + 1 - size(place)
        if (size(place) > 0) then
          call fill(noise%predictor, place, highest + 1, filled(first:last), inverse, logarithm)
          logarithms = logarithms + logarithm
          call covariances%add(place, last - first + 1, inverse)
        end if
        rows = filled(first:last)
        call whiten(noise%predictor, rows)
        call find_last(noise%predictor, filled(max(first, last - p + 1):last), part, logarithm)
        squares = squares + sum(rows**2) + part
        logarithms = logarithms + logarithm
      end associate
    end do
    noise%variance = max(squares/max(1, valid_count), tiny(1.0_dp))
    noise%cost = valid_count*log(noise%variance) + logarithms + ubound(noise%predictor, 1)*penalty
    call covariances%scale(noise%variance)
  end subroutine expect

  subroutine fill(h, place, reach, x, inverse, logarithm)
    !! Fill the missing samples of a piece, and find a band of Q⁻¹ and the logarithm of the determinant of Q.
    real(dp), intent(in) :: h(0:)
    integer, intent(in) :: place(:)              !! of missing samples in the piece, ascending
    integer, intent(in) :: reach                 !! of covariances, at least the order
    real(dp), intent(inout) :: x(:)
    real(dp), allocatable, intent(out) :: inverse(:, :)   !! of missing samples j and j + k, (0:band, missing)
    real(dp), intent(out) :: logarithm
    real(dp), allocatable :: root(:, :)
    real(dp) :: correlation(0:ubound(h, 1)), value(1, size(place))
    integer :: p, d, j, k, n, band, wide
    n = size(x)
    p = ubound(h, 1)
    correlation = [(dot_product(h(:p - d), h(d:)), d=0, p)]
    band = band_within(place, p)
    wide = band_within(place, reach)
    allocate (root(0:band, size(place)), source=0.0_dp)
    do j = 1, size(place)
      associate (g => place(j))
        do k = 0, min(band, size(place) - j)
          if (place(j + k) - g <= p) root(k, j) = precision_of(g, place(j + k))
        end do
        if (g > p .and. g <= n - p) then
          value(1, j) = -dot_product(correlation(1:), x(g + 1:g + p) + x(g - 1:g - p:-1))
        else
          value(1, j) = -sum([(precision_of(min(g, k), max(g, k))*x(k), k=max(1, g - p), min(n, g + p))])
        end if
      end associate
    end do
    call factorise(root, bounded=.true.)
    call solve(root, value)
    x(place) = value(1, :)
    logarithm = 2*sum(log(root(0, :)))
    allocate (inverse(0:wide, size(place)), source=0.0_dp)
    do j = size(place), 1, -1
      associate (last => min(band, size(place) - j), m => min(wide, size(place) - j))
        do d = 1, last                             ! Σ root(d, j)·inverse of j + d and j + k: d ≤ k, then d > k
          do k = d, m
            inverse(k, j) = inverse(k, j) + root(d, j)*inverse(k - d, j + d)
          end do
        end do
        do k = 1, last - 1
          inverse(k, j) = inverse(k, j) + dot_product(root(k + 1:last, j), inverse(1:last - k, j + k))
        end do
        inverse(1:m, j) = -inverse(1:m, j)/root(0, j)
        inverse(0, j) = (1/root(0, j) - dot_product(root(1:last, j), inverse(1:last, j)))/root(0, j)
      end associate
    end do

  contains

    pure real(dp) function precision_of(u, v)
      !! The element of the inverse covariance of two samples u ≤ v of a piece, over the variance.
      integer, intent(in) :: u, v
      integer :: last
      last = min(p - (v - u), u - 1, n - v)
      if (last == p - (v - u)) then
        precision_of = correlation(v - u)
      else
        precision_of = dot_product(h(:last), h(v - u:v - u + last))
      end if
    end function precision_of

  end subroutine fill

  pure integer function band_within(place, reach) result(band)
    !! The largest number of missing samples that follow one within `reach` samples.
    integer, intent(in) :: place(:), reach
    integer :: j, k
    band = 0
    j = 1
    do k = 2, size(place)
      do while (place(k) - place(j) > reach)
        j = j + 1
      end do
      band = max(band, k - j)
    end do
  end function band_within

  pure subroutine find_last(h, x, squares, logarithm)
    !! Find the squares of prediction errors of the last samples of a piece, each from those after it, relative to the variance of
    !! the whole predictor, and the logarithms of their variances.
    real(dp), intent(in) :: h(0:)
    real(dp), intent(in) :: x(:)                 !! as many as the order, or all of a short piece
    real(dp), intent(out) :: squares, logarithm
    real(dp) :: lower(0:ubound(h, 1)), ratio, reflection
    integer :: q, n
    n = size(x)
    squares = 0
    logarithm = 0
    lower = h/h(0)
    ratio = 1
    do q = ubound(h, 1), 1, -1                   ! from order q to q − 1
      reflection = lower(q)
      ratio = ratio/max(1 - reflection**2, tiny(1.0_dp))
      lower(:q - 1) = (lower(:q - 1) - reflection*lower(q:1:-1))/max(1 - reflection**2, tiny(1.0_dp))
      if (q > n) cycle
      squares = squares + dot_product(lower(:q - 1), x(n - q + 1:n))**2/ratio
      logarithm = logarithm + log(ratio)
    end do
  end subroutine find_last

end module bw_noise_with_gaps
