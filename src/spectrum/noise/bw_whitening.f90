module bw_whitening
  !! Samples with coloured noise turned into samples with white noise: what an autoregression does not foresee.
  !!
  !! The autoregression of each sensor comes from what the lines leave (Burg, 1975), its order from the Bayesian criterion. The
  !! filter h changes a line's amplitude by a factor and neither its decay nor its frequency, so that the fit of the filtered
  !! samples is the maximum likelihood in such noise, but for the first samples, one for each order, that are used up.
  use bw_damped_line, only: damped_line
  use bw_kinds, only: dp
  use bw_remainder, only: find_remainder, motion_type, tabulated
  use bw_samples, only: phase_factor, samples_type
  implicit none (type, external)
  private
  public :: find_whitening, freedom_of_level, gain_of, is_even, is_steep, judge_noise, judged_order, no_whitening, whiten

  integer, parameter :: highest_order = 128
  integer, parameter :: usual_order = 16       !! higher ones are for noise that is as strong all along the record
  integer, parameter :: looked_ahead = 16      !! orders beyond twice the best so far
  real(dp), parameter :: worth = 0.99_dp        !! of the noise's variance: a filter that leaves more changes nothing
  integer, parameter, public :: longest = 65536         !! samples that tell enough of the noise
  integer, parameter :: samples_per_order = 8  !! fewer do not tell of so high an order
  integer, parameter :: samples_per_usual = 32 !! nor of an order that is not high
  integer, parameter :: places = 128           !! frequencies from 0 to half the sampling rate, at which they are looked for
  real(dp), parameter :: steep = 2.0e4_dp      !! highest level over the lowest
  real(dp), parameter :: most_uneven = 8       !! variances of two quarters of the record

  type, public :: whitening_type
    !! One sensor's filter y'_n = Σ_i h_i y_(n−i), i = 0 … order.
    integer :: order = 0
    real(dp) :: coefficient(0:highest_order) = 0
    integer :: lost = 0                          !! samples at the start that the record has lost by it
  end type whitening_type

contains

  pure function no_whitening(sensors) result(whitening)
    !! The filters that leave samples as they are, (S).
    integer, intent(in) :: sensors
    type(whitening_type) :: whitening(sensors)
    whitening%coefficient(0) = 1
  end function no_whitening

  subroutine find_whitening(samples, lines, still, whitening)
    !! Find each sensor's filter from what lines, offset and slope leave.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    type(whitening_type), intent(inout) :: whitening(:)
    real(dp), allocatable :: left(:)
    real(dp) :: cost
    type(motion_type) :: motion
    integer :: s, first
    motion = tabulated(samples, lines, still)
    do s = 1, size(whitening)
      call find_remainder(samples, motion, s, left)
      first = max(0, (size(left) - longest)/2)
      associate (middle => left(first + 1:size(left) - first))
        call burg(middle, log(real(size(middle), dp)), highest_of(middle, samples_per_usual), worth, whitening(s), cost)
      end associate
    end do
    whitening%lost = maxval(whitening%order)
  end subroutine find_whitening

  pure integer function highest_of(left, per_order) result(highest)
    !! The highest order that noise may have. A filter with steep edges, or with zeros, takes a high one. But what a mode leaves that
    !! no line describes looks the same by frequency; it dies away, and noise does not.
    real(dp), intent(in) :: left(:)
    integer, intent(in) :: per_order           !! samples for each usual order
    highest = min(usual_order, size(left)/per_order)
    if (is_even(left)) highest = max(highest, min(highest_order, size(left)/samples_per_order))
  end function highest_of

  pure logical function is_even(left)
    !! Whether numbers are as large all along the record.
    real(dp), intent(in) :: left(:)
    real(dp) :: quarter(4)
    integer :: n, i
    n = size(left)
    quarter = [(sum(left(1 + (i - 1)*n/4:i*n/4)**2), i=1, 4)]
    is_even = maxval(quarter) < most_uneven*minval(quarter)
  end function is_even

  pure integer function judged_order(left) result(highest)
    !! The highest order that noise may have where lines are judged: the usual one, unless the Bayesian criterion likes a higher one
    !! best for what all lines leave; for an autoregression of a high order describes damped lines in noise that has no colour.
    real(dp), intent(in) :: left(:)
    type(whitening_type) :: whitening
    real(dp) :: cost
    highest = highest_of(left, samples_per_usual/2)
    call burg(left, log(real(size(left), dp)), highest, 1.0_dp, whitening, cost)
    if (whitening%order <= usual_order) highest = min(usual_order, 2*size(left)/samples_per_usual)
  end function judged_order

  pure subroutine judge_noise(left, highest, whitening, cost)
    !! Find the filter of noise, and what noise costs: minus twice the logarithm of its likelihood, and two for each coefficient
    !! (Akaike, 1974).
    real(dp), intent(in) :: left(:)
    integer, intent(in) :: highest             !! order
    type(whitening_type), intent(out) :: whitening
    real(dp), intent(out) :: cost
    call burg(left, 2.0_dp, highest, 1.0_dp, whitening, cost)
  end subroutine judge_noise

  pure subroutine burg(left, cost_of_order, highest, worth_it, whitening, least)
    !! Fit autoregressions of rising order; the one that a criterion likes best stays.
    real(dp), intent(in) :: left(:)
    real(dp), intent(in) :: cost_of_order      !! log n in the Bayesian criterion, 2 in Akaike's
    integer, intent(in) :: highest             !! order
    real(dp), intent(in) :: worth_it           !! part of the variance: what leaves more changes nothing
    type(whitening_type), intent(inout) :: whitening
    real(dp), intent(out) :: least             !! the criterion
    real(dp) :: forward(size(left)), backward(size(left)), kept
    real(dp) :: h(0:highest_order), before(0:highest_order), power, reflection, criterion
    integer :: n, p, i
    n = size(left)
    forward = left
    backward = left
    h = 0
    h(0) = 1
    power = sum(left**2)/n
    least = n*log(max(power, tiny(1.0_dp)))
    whitening%order = 0
    whitening%coefficient = h
    do p = 1, highest
      if (p > 2*whitening%order + looked_ahead) exit
      reflection = sum(forward(p + 1:)**2) + sum(backward(p:n - 1)**2)
      if (.not. reflection > 0) exit
      reflection = -2*dot_product(forward(p + 1:), backward(p:n - 1))/reflection
      before = h
      do i = 1, p
        h(i) = before(i) + reflection*before(p - i)
      end do
      do i = n, p + 1, -1
        kept = forward(i)
        forward(i) = kept + reflection*backward(i - 1)
        backward(i) = backward(i - 1) + reflection*kept
      end do
      power = power*(1 - reflection**2)
      criterion = n*log(max(power, tiny(1.0_dp))) + p*cost_of_order
      if (criterion >= least .or. power > worth_it*sum(left**2)/n) cycle
      least = criterion
      whitening%order = p
      whitening%coefficient = h
    end do
  end subroutine burg

  pure elemental logical function is_steep(whitening)
    !! Whether the highest level of the noise that a filter evens out is more than 20 000 times the lowest: steep filters let through
    !! less beyond their band, while it is 10 000 times in noise whose neighbours have a correlation of 0.98.
    type(whitening_type), intent(in) :: whitening
    real(dp) :: power(0:places)
    integer :: k, i
    associate (h => whitening%coefficient)
      power = [(abs(sum([(h(i)*phase_factor(0.5_dp*k/places, -i), i=0, whitening%order)]))**2, k=0, places)]
    end associate
    is_steep = maxval(power) > steep*minval(power)
  end function is_steep

  pure real(dp) function freedom_of_level(whitening, frequency, count) result(freedom)
    !! One over the variance of the logarithm of the noise's level at a frequency, where an autoregression of so many samples tells it:
    !! so many ordinates' mean would scatter as much. The inverse of the covariance of its p coefficients is that of p samples
    !! times their number (Mann and Wald), which the coefficients give (Gohberg and Semencul).
    type(whitening_type), intent(in) :: whitening
    real(dp), intent(in) :: frequency
    integer, intent(in) :: count
    real(dp) :: slope(whitening%order), variance
    complex(dp) :: response
    integer :: i, p
    p = whitening%order
    associate (h => whitening%coefficient)
      response = sum([(h(i)*phase_factor(frequency, -i), i=0, p)])
      slope = [(2*real(phase_factor(frequency, -i)/response, dp), i=1, p)]
      variance = 2
      do i = 1, p
        variance = variance + dot_product(h(:p - i), slope(i:))**2 - dot_product(h(p:i:-1), slope(i:))**2
      end do
    end associate
    freedom = count/variance
  end function freedom_of_level

  subroutine whiten(samples, whitening, lines)
    !! Filter the samples in their memory, and the amplitudes of the lines with them. Fewer samples remain.
    type(samples_type), intent(inout) :: samples
    type(whitening_type), intent(in) :: whitening(:)
    type(damped_line), intent(inout) :: lines(:)
    integer :: s, n, k, lost, order
    do s = 1, size(whitening)
      order = whitening(s)%order
      lost = whitening(s)%lost
      do n = 1, samples%count - lost
        samples%value(n, s) = dot_product(whitening(s)%coefficient(order:0:-1), samples%value(n + lost - order:n + lost, s))
      end do
    end do
    samples%count = samples%count - whitening(1)%lost
    do k = 1, size(lines)
      lines(k)%amplitude = lines(k)%amplitude*gain_of(whitening, lines(k))
    end do
  end subroutine whiten

  pure function gain_of(whitening, line) result(gain)
    !! The factors of a line's amplitudes by the filters, (S). Phases are those at the first sample, of which there are fewer now.
    type(whitening_type), intent(in) :: whitening(:)
    type(damped_line), intent(in) :: line
    complex(dp) :: gain(size(whitening))
    integer :: s, i, away
    gain = 0
    do s = 1, size(whitening)
      do i = 0, whitening(s)%order
        away = merge(-i, whitening(s)%lost - i, line%decay < 0)
        gain(s) = gain(s) + whitening(s)%coefficient(i)*exp(-line%decay*away)* &
          & phase_factor(line%frequency, whitening(s)%lost - i)
      end do
    end do
  end function gain_of

end module bw_whitening
