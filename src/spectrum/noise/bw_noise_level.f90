module bw_noise_level
  !! The noise of one sensor from what lines leave of its transform: a smooth level over frequency.
  !!
  !! Noise of a few resonances is an autoregression (Yule and Walker, from the transform itself); what that leaves of the level
  !! is a mean over windows of many ordinates. Ordinates are cut off a few times above the level, which takes lines that
  !! nobody has found yet out of it, and the mean is corrected for the cut.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: find_level, level_at, mean_deviation, quantile_of, window_width

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: cut = 4               !! of the level, above which an ordinate of noise lies once in 55
  real(dp), parameter :: least_free = 0.1_dp
  real(dp), parameter :: most_crowded = 1.4_dp !! mean over median: where lines crowd the cut mean fails, and the median less so
  real(dp), parameter :: most_coloured = 3     !! of a window's median; more is taken for lines that nobody has found yet
  integer, parameter :: fewest_bins = 48       !! in a window
  integer, parameter :: most_windows = 64
  integer, parameter :: most_cells = 4096      !! the autoregression sees means over as many cells
  integer, parameter :: highest_order = 8
  integer, parameter :: rounds = 4
  integer, parameter :: most_ranked = 301      !! ordinates of a window whose median is taken

  type, public :: level_knots
    !! The noise's variance per sample at evenly spaced frequencies from 0 to half the sampling rate.
    real(dp), allocatable :: level(:, :)       !! (0:K, S)
  end type level_knots

contains

  pure elemental real(dp) function level_at_knot(low, high, part)
    !! Between two knots the logarithm is a straight line.
    real(dp), intent(in) :: low, high, part
    level_at_knot = low*(high/low)**part
  end function level_at_knot

  pure function level_at(knots, frequency, sensors) result(level)
    !! The noise's variance of each sensor at a frequency in periods per step, (S); 1 while nothing is known.
    type(level_knots), intent(in) :: knots
    real(dp), intent(in) :: frequency
    integer, intent(in) :: sensors
    real(dp) :: level(sensors), place
    integer :: k, last
    level = 1
    if (.not. allocated(knots%level)) return
    last = ubound(knots%level, 1)
    place = min(max(2*frequency, 0.0_dp), 1.0_dp)*last
    k = min(int(place), last - 1)
    level = level_at_knot(knots%level(k, :), knots%level(k + 1, :), place - k)
  end function level_at

  pure function mean_deviation(knots) result(deviation)
    !! The geometric mean over frequency of the root of each sensor's level, (S).
    type(level_knots), intent(in) :: knots
    real(dp) :: deviation(size(knots%level, 2))
    deviation = exp(sum(log(knots%level), dim=1)/(2*size(knots%level, 1)))
  end function mean_deviation

  subroutine find_level(power, bins, coloured, taken, each, floor, level)
    !! Find the level at the ordinates.
    real(dp), intent(in) :: power(0:)          !! ordinates |X|²/N at even frequencies from 0 to half the sampling rate
    integer, intent(in) :: bins                !! of 1/span among them: fewer than ordinates where the transform was padded
    logical, intent(in) :: coloured            !! the level may change within a window
    real(dp), intent(in) :: taken(:)           !! frequencies (periods per step) of lines that have been fitted to the sensor
    real(dp), intent(in) :: each               !! real numbers that were fitted for each
    real(dp), intent(in) :: floor              !! rounding
    real(dp), intent(out) :: level(0:)         !! at the same ordinates
    real(dp), allocatable :: window(:), clipped(:), ranked(:)
    integer :: windows, skipped, i
    skipped = 2*(size(power) - 1)/bins         ! offset and slope have been taken out of these
    windows = nint(bins/window_width(real(bins, dp)))
    allocate (window(windows), clipped(0:size(power) - 1))
    level = 1
    call window_medians(power, skipped, window)
    call spread(max(window, floor), level)
    ranked = level
    do i = 1, rounds
      clipped = min(power, cut*min(level, most_coloured*ranked))
      clipped(:skipped - 1) = clipped(skipped)
      if (coloured .and. bins >= 2*fewest_bins) call autoregression(clipped, 2*bins, level)
      call correct(power, skipped, free_part(taken, each, bins, windows), level, window)
    end do
    level = max(level, floor)
  end subroutine find_level

  pure real(dp) function window_width(bins)
    !! How many bins of so many are in a window.
    real(dp), intent(in) :: bins
    window_width = bins/max(1, min(most_windows, int(bins/fewest_bins)))
  end function window_width

  subroutine window_medians(power, skipped, window)
    !! The level of each window by its median, which is ln 2 of the mean.
    real(dp), intent(in) :: power(0:)
    integer, intent(in) :: skipped
    real(dp), intent(out) :: window(:)
    integer :: first, last, stride, w
    do w = 1, size(window)
      call window_edges(size(power), skipped, size(window), w, first, last)
      stride = 1 + (last - first)/most_ranked
      window(w) = median(power(first:last:stride))/log(2.0_dp)
    end do
  end subroutine window_medians

  pure subroutine window_edges(ordinates, skipped, windows, w, first, last)
    !! The first and last ordinate of a window.
    integer, intent(in) :: ordinates, skipped, windows, w
    integer, intent(out) :: first, last
    real(dp) :: width
    width = real(ordinates - skipped, dp)/windows
    first = skipped + nint((w - 1)*width)
    last = min(ordinates - 1, skipped + nint(w*width) - 1)
  end subroutine window_edges

  pure subroutine spread(window, level)
    !! Multiply the level by the windows' factors, their logarithms joined by straight lines between the windows' middles.
    real(dp), intent(in) :: window(:)
    real(dp), intent(inout) :: level(0:)
    real(dp) :: place
    integer :: m, w
    do m = 0, size(level) - 1
      if (size(window) == 1) then
        level(m) = level(m)*window(1)
        cycle
      end if
      place = min(max((m + 0.5_dp)*size(window)/size(level) + 0.5_dp, 1.0_dp), real(size(window), dp))
      w = min(int(place), size(window) - 1)
      level(m) = level(m)*level_at_knot(window(w), window(w + 1), place - w)
    end do
  end subroutine spread

  pure function free_part(taken, each, bins, windows) result(free)
    !! The part of each window's real numbers, two for each bin, that are left after those of lines have been fitted.
    real(dp), intent(in) :: taken(:), each
    integer, intent(in) :: bins, windows
    real(dp) :: free(windows)
    integer :: lines(windows), i, w
    lines = 0
    do i = 1, size(taken)
      w = min(windows, 1 + int(2*taken(i)*windows))
      lines(w) = lines(w) + 1
    end do
    free = max(1 - lines*each*windows/(2.0_dp*bins), least_free)
  end function free_part

  subroutine correct(power, skipped, free, level, window)
    !! Bring the mean of the cut ordinates of each window to what noise of that level has, 1 − e^(−cut), less what has been fitted.
    real(dp), intent(in) :: power(0:)
    integer, intent(in) :: skipped
    real(dp), intent(in) :: free(:)            !! part of each window's numbers that have not been fitted
    real(dp), intent(inout) :: level(0:)
    real(dp), intent(out) :: window(:)
    real(dp) :: middle, ratio(size(power))
    integer :: first, last, stride, w, i
    do w = 1, size(window)
      call window_edges(size(power), skipped, size(window), w, first, last)
      window(w) = 1
      associate (own => ratio(:last - first + 1))
        own = power(first:last)/level(first:last)
        do i = 1, rounds
          window(w) = sum(min(own, cut*window(w)))/(size(own)*(1 - exp(-cut))*free(w))
          if (.not. window(w) > 0) exit
        end do
        stride = 1 + (last - first)/most_ranked
        middle = median(own(::stride))/log(2.0_dp)/free(w)
      end associate
      if (window(w) > most_crowded*middle) window(w) = middle
    end do
    where (.not. window > tiny(1.0_dp)) window = tiny(1.0_dp)
    call spread(window, level)
  end subroutine correct

  subroutine autoregression(power, samples, level)
    !! The spectrum of an autoregression, of the order that the Bayesian criterion likes best.
    real(dp), intent(in) :: power(0:)          !! ordinates without lines
    integer, intent(in) :: samples
    real(dp), intent(out) :: level(0:)
    real(dp) :: covariance(0:highest_order), a(highest_order), best(highest_order), before(highest_order)
    real(dp) :: error, reflection, criterion, least, best_error, mean
    complex(dp) :: turn, wave, step
    integer :: cells, c, m, p, i, first, last, order
    covariance = 0
    cells = min(most_cells, size(power) - 1)
    do c = 1, cells
      first = int((c - 1)*real(size(power), dp)/cells)
      last = int(c*real(size(power), dp)/cells) - 1
      mean = sum(power(first:last))/(last - first + 1)
      turn = exp(cmplx(0, pi*(c - 0.5_dp)/cells, dp))
      wave = mean
      do i = 0, highest_order
        covariance(i) = covariance(i) + wave%re
        wave = wave*turn
      end do
    end do
    covariance = covariance/cells
    a = 0
    best = 0
    order = 0
    error = covariance(0)
    best_error = error
    least = samples*log(max(error, tiny(1.0_dp)))
    do p = 1, min(highest_order, samples/20)
      if (.not. error > 0) exit
      reflection = (covariance(p) - dot_product(a(:p - 1), covariance(p - 1:1:-1)))/error
      if (.not. abs(reflection) < 1) exit
      before = a
      a(p) = reflection
      a(:p - 1) = before(:p - 1) - reflection*before(p - 1:1:-1)
      error = error*(1 - reflection**2)
      criterion = samples*log(max(error, tiny(1.0_dp))) + p*log(real(samples, dp))
      if (criterion >= least) cycle
      least = criterion
      best = a
      best_error = error
      order = p
    end do
    level = max(best_error, tiny(1.0_dp))
    if (order == 0) return
    step = exp(cmplx(0, -pi/(size(level) - 1), dp))
    do m = 0, size(level) - 1
      if (modulo(m, 64) == 0) then              ! so that no error builds up
        turn = exp(cmplx(0, -pi*m/(size(level) - 1), dp))
      else
        turn = turn*step
      end if
      wave = 0
      do i = order, 1, -1
        wave = (wave + best(i))*turn
      end do
      level(m) = level(m)/max((1 - wave%re)**2 + wave%im**2, tiny(1.0_dp))
    end do
  end subroutine autoregression

  pure real(dp) function median(values)
    !! The middle one by value.
    real(dp), intent(in) :: values(:)
    median = quantile_of(values, 0.5_dp)
  end function median

  pure real(dp) function quantile_of(values, part) result(quantile)
    !! The value that so large a part of them is below, by halving the range until only one is left in it.
    real(dp), intent(in) :: values(:), part
    real(dp) :: list(size(values)), pivot, swap
    integer :: low, high, i, j, k
    list = values
    low = 1
    high = size(list)
    k = max(1, min(size(list), nint(part*(size(list) + 1))))
    do while (low < high)
      pivot = list((low + high)/2)
      i = low
      j = high
      do while (i <= j)
        do while (list(i) < pivot)
          i = i + 1
        end do
        do while (pivot < list(j))
          j = j - 1
        end do
        if (i > j) exit
        swap = list(i)
        list(i) = list(j)
        list(j) = swap
        i = i + 1
        j = j - 1
      end do
      if (k <= j) then
        high = j
      else if (k >= i) then
        low = i
      else
        exit
      end if
    end do
    quantile = list(k)
  end function quantile_of

end module bw_noise_level
