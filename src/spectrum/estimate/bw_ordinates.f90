module bw_ordinates
  !! What lines leave of a record, seen by frequency: the ordinates of all sensors together over the level of their noise.
  use bw_damped_line, only: damped_line, subtract_lines
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_noise_level, only: find_level, level_knots, quantile_of
  use bw_samples, only: centre_of, place_of, samples_type, span_of
  use bw_uneven_fourier, only: uneven_transform
  implicit none (type, external)
  private
  public :: chance_of, find_ordinates, least_ordinate, padded_length, remainder

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: most_knots = 4096
  integer, parameter :: most_ranked = 32768    !! ordinates that the noise's level is found from
  real(dp), parameter :: quartile = 0.67449_dp !! of a normal number, in standard deviations
  real(dp), parameter :: rounding = 4*epsilon(1.0_dp)  !! of a sample, over the record's root mean square

  type, public :: ordinates_type
    integer :: length = 0                      !! M of the padded transform; ordinate m is at m/M periods per step
    real(dp), allocatable :: total(:)          !! Σ_s |X_s|²/(N·level): of noise alone a sum of S numbers e^(−x), (0:M/2)
    type(level_knots) :: noise
    real(dp) :: shape = 1                      !! as many sensors of independent noise have ordinates that scatter so
    real(dp), allocatable :: deviation(:)      !! of what is left, (S)
  end type ordinates_type

contains

  subroutine find_ordinates(samples, lines, still, tapered, plan, ordinates)
    !! Take the lines, offset and slope out of every sensor's samples, transform what is left and judge its noise. A taper keeps
    !! the leakage of strong lines from hiding others and sees less of weak ones; its noise is taken for white in each window.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)        !! (2, S)
    logical, intent(in) :: tapered             !! by Hann's window
    type(real_fourier), intent(inout) :: plan
    type(ordinates_type), intent(inout) :: ordinates
    real(dp), allocatable :: left(:), taper(:), power(:), level(:)
    real(dp) :: floor
    integer, allocatable :: sampled(:), at_knot(:)
    integer :: s, half, knots, ranked, k, bins
    ordinates%length = padded_length(samples)
    half = ordinates%length/2
    bins = max(1, nint(span_of(samples)/2))
    knots = min(half, most_knots)
    if (allocated(ordinates%total)) then
      if (size(ordinates%total) /= half + 1) deallocate (ordinates%total, ordinates%deviation, ordinates%noise%level)
    end if
    if (.not. allocated(ordinates%total)) then
      allocate (ordinates%total(0:half), ordinates%deviation(size(samples%value, 2)))
      allocate (ordinates%noise%level(0:knots, size(samples%value, 2)))
    end if
    ranked = min(half, most_ranked)
    allocate (taper(samples%count), source=1.0_dp)
    if (tapered) taper(:) = hann(samples)
    sampled = [(nint(k*(real(half, dp)/ranked)), k=0, ranked)]
    at_knot = [(nint(k*(real(ranked, dp)/knots)), k=0, knots)]
    allocate (level(0:ranked), power(0:half))
    ordinates%total = 0
    do s = 1, size(samples%value, 2)
      left = remainder(samples, lines, still, s)
      ordinates%deviation(s) = norm2(left)/sqrt(real(size(left), dp))
      call find_power(samples, left*taper, plan, power)
      floor = max((rounding*norm2(samples%value(:samples%count, s)))**2/size(left), tiny(1.0_dp)*1.0e50_dp)
      call find_level(power(sampled), min(bins, size(sampled)/2), .not. tapered, numbers_of(lines, size(samples%value, 2)), &
        & floor, level)
      ordinates%noise%level(:, s) = level(at_knot)
      call add_ratio(power, ordinates%noise%level(:, s), ordinates%total)
    end do
    call allow_for_common_noise(ordinates, bins, size(samples%value, 2))
  end subroutine find_ordinates

  subroutine allow_for_common_noise(ordinates, bins, sensors)
    !! Noise that sensors share makes their sum scatter more: like that of fewer sensors, each with a higher level. Their number
    !! is the shape of the gamma distribution whose quartiles have the same ratio (Wilson and Hilferty's cube).
    type(ordinates_type), intent(inout) :: ordinates
    integer, intent(in) :: bins, sensors
    real(dp) :: low, high, shape, ratio
    integer :: i, stride
    ordinates%shape = sensors
    if (sensors == 1) return
    stride = 1 + size(ordinates%total)/most_ranked
    ratio = (quantile_of(ordinates%total(::stride), 0.75_dp)/quantile_of(ordinates%total(::stride), 0.25_dp))**(1/3.0_dp)
    low = 0.5_dp
    high = 2.0_dp*sensors
    do i = 1, 50
      shape = (low + high)/2
      if ((1 - 1/(9*shape) + quartile/(3*sqrt(shape)))/(1 - 1/(9*shape) - quartile/(3*sqrt(shape))) > ratio) then
        low = shape
      else
        high = shape
      end if
    end do
    if (shape > sensors*(1 - 3*sqrt(5.0_dp/min(bins, most_ranked/2)))) return
    ordinates%shape = max(shape, 1.0_dp)
    ordinates%total = ordinates%total*(ordinates%shape/sensors)
    ordinates%noise%level = ordinates%noise%level*(sensors/ordinates%shape)
  end subroutine allow_for_common_noise

  pure subroutine add_ratio(power, level, total)
    !! Add the ordinates over their level, whose inverse is a straight line between its knots.
    real(dp), intent(in) :: power(0:), level(0:)
    real(dp), intent(inout) :: total(0:)
    real(dp) :: spacing, slope
    integer :: m, k, first, last, knots, half
    knots = size(level) - 1
    half = size(power) - 1
    spacing = real(half, dp)/knots
    last = -1
    do k = 0, knots - 1
      first = last + 1
      last = merge(half, int((k + 1)*spacing), k == knots - 1)
      slope = (1/level(k + 1) - 1/level(k))/spacing
      do m = first, last
        total(m) = total(m) + power(m)*(1/level(k) + (m - k*spacing)*slope)
      end do
    end do
  end subroutine add_ratio

  pure function numbers_of(lines, sensors) result(frequency)
    !! The frequency of each real number that has been fitted to one sensor: an amplitude's two, and two that all sensors share.
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: sensors
    real(dp), allocatable :: frequency(:)
    integer :: k
    frequency = [lines%frequency, lines%frequency, (lines(k)%frequency, lines(k)%frequency, k=1, size(lines), sensors)]
  end function numbers_of

  pure integer function padded_length(samples) result(length)
    !! The smallest product of 2 with small primes that holds the record twice.
    type(samples_type), intent(in) :: samples
    integer :: rest, p
    length = 2*ceiling(span_of(samples)) - 2
    do
      length = length + 2
      rest = length
      do p = 2, 7
        do while (modulo(rest, p) == 0)
          rest = rest/p
        end do
      end do
      if (rest == 1) return
    end do
  end function padded_length

  pure function hann(samples) result(taper)
    !! Hann's window at the samples' times, of mean square 1.
    type(samples_type), intent(in) :: samples
    real(dp) :: taper(samples%count)
    integer :: n
    taper = [(sin(pi*(place_of(samples, n) + 0.5_dp)/span_of(samples))**2, n=1, samples%count)]
    taper = taper*sqrt(samples%count/sum(taper**2))
  end function hann

  subroutine find_power(samples, left, plan, power)
    !! Find the ordinates |X|²/N of one sensor.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: left(:)            !! (N)
    type(real_fourier), intent(inout) :: plan
    real(dp), intent(out) :: power(0:)         !! (0:M/2)
    complex(dp), allocatable :: spectrum(:)
    if (allocated(samples%place)) then
      allocate (spectrum(0:size(power) - 1))
      call uneven_transform(samples%place, left, 2*(size(power) - 1), plan, spectrum)
      power = (spectrum%re**2 + spectrum%im**2)/size(left)
    else
      call plan%prepare(2*(size(power) - 1))
      plan%samples(:size(left)) = left
      plan%samples(size(left) + 1:) = 0
      call plan%transform()
      power = (plan%spectrum%re**2 + plan%spectrum%im**2)/size(left)
    end if
  end subroutine find_power

  pure function remainder(samples, lines, still, s) result(left)
    !! What lines, offset and slope leave of one sensor's samples, (N).
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    integer, intent(in) :: s
    real(dp), allocatable :: left(:)
    real(dp) :: centre, start, periods
    integer :: k, n
    left = samples%value(:samples%count, s)
    centre = centre_of(samples)
    if (allocated(samples%place)) then
      left = left - still(1, s) - still(2, s)*(samples%place/centre - 1)
      do k = 1, size(lines)
        start = 2*min(lines(k)%decay, 0.0_dp)*centre
        do n = 1, size(left)
          periods = lines(k)%frequency*samples%place(n)
          left(n) = left(n) - exp(start - lines(k)%decay*samples%place(n))* &
            & real(lines(k)%amplitude(s)*exp(cmplx(0, 2*pi*(periods - anint(periods)), dp)), dp)
        end do
      end do
      return
    end if
    left = left - still(1, s) - still(2, s)*([(n, n=0, size(left) - 1)]/centre - 1)
    call subtract_lines(lines, s, left)
  end function remainder

  pure real(dp) function chance_of(ordinate, shape, bins)
    !! How many ordinates of noise are expected to pass a value: Rice's formula for the transform between its bins.
    real(dp), intent(in) :: ordinate
    real(dp), intent(in) :: shape              !! sensors of independent noise
    real(dp), intent(in) :: bins
    chance_of = bins*sqrt(pi*ordinate/3)*exp(-ordinate + (shape - 1)*log(ordinate) - log_gamma(shape))
  end function chance_of

  pure real(dp) function least_ordinate(shape, bins, false_alarm)
    !! The ordinate that noise passes with that probability anywhere.
    real(dp), intent(in) :: shape              !! sensors of independent noise
    real(dp), intent(in) :: bins, false_alarm
    real(dp) :: low, high
    integer :: i
    low = shape
    high = 10*(shape + log(bins + 1) - log(false_alarm)) + 10
    do i = 1, 60
      least_ordinate = (low + high)/2
      if (chance_of(least_ordinate, shape, bins) > false_alarm) then
        low = least_ordinate
      else
        high = least_ordinate
      end if
    end do
  end function least_ordinate

end module bw_ordinates
