module bw_ordinates
  !! What lines leave of a record, seen by frequency: the ordinates of all sensors together over the level of their noise.
  use bw_damped_line, only: damped_line
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_noise_level, only: find_level, level_knots, quantile_of
  use bw_remainder, only: find_remainder, motion_type, tabulated
  use bw_samples, only: centre_of, place_of, samples_type, span_of
  use bw_uneven_fourier, only: uneven_transform
  implicit none (type, external)
  private
  public :: find_ordinates, find_power, least_ordinate, padded_length

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

  subroutine find_ordinates(samples, lines, still, plan, plain, tapered)
    !! Take the lines, offset and slope out of every sensor's samples, transform what is left and judge its noise, without and with
    !! Hann's window. A taper keeps the leakage of strong lines from hiding others and sees less of weak ones; its noise is taken
    !! for white in each window of frequencies.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)        !! (2, S)
    type(real_fourier), intent(inout) :: plan
    type(ordinates_type), intent(inout) :: plain, tapered
    real(dp), allocatable :: left(:), power(:)
    complex(dp), allocatable :: spectrum(:)
    real(dp), allocatable :: fitted(:)
    type(motion_type) :: motion
    real(dp) :: taper_square, floor
    integer :: s, length
    length = padded_length(samples)
    call prepare(length, size(samples%value, 2), plain)
    call prepare(length, size(samples%value, 2), tapered)
    allocate (spectrum(0:length/2), power(0:length/2))
    taper_square = mean_square(samples, length)
    fitted = numbers_of(lines, size(samples%value, 2))
    motion = tabulated(samples, lines, still)
    do s = 1, size(samples%value, 2)
      call find_remainder(samples, motion, s, left)
      plain%deviation(s) = sqrt(dot_product(left, left)/size(left))
      associate (value => samples%value(:samples%count, s))
        floor = max(rounding**2*dot_product(value, value)/size(left), tiny(1.0_dp)*1.0e50_dp)
      end associate
      call transform(samples, left, plan, spectrum)
      power = (spectrum%re**2 + spectrum%im**2)/size(left)
      call add_sensor(span_of(samples), power, .true., fitted, floor, s, plain)
      call taper(spectrum, 4*pi*centre_of(samples)/length)
      power = (spectrum%re**2 + spectrum%im**2)/(size(left)*taper_square)
      call add_sensor(span_of(samples), power, .false., fitted, floor, s, tapered)
    end do
    tapered%deviation = plain%deviation
    call allow_for_common_noise(plain, nint(span_of(samples)/2), size(samples%value, 2))
    call allow_for_common_noise(tapered, nint(span_of(samples)/2), size(samples%value, 2))
  end subroutine find_ordinates

  subroutine prepare(length, sensors, ordinates)
    !! Make room, and begin the sum over sensors.
    integer, intent(in) :: length, sensors
    type(ordinates_type), intent(inout) :: ordinates
    if (ordinates%length /= length) then
      ordinates = ordinates_type(length)
      allocate (ordinates%total(0:length/2), ordinates%deviation(sensors))
      allocate (ordinates%noise%level(0:min(length/2, most_knots), sensors))
    end if
    ordinates%total = 0
  end subroutine prepare

  subroutine add_sensor(span, power, coloured, fitted, floor, s, ordinates)
    !! Find the level of one sensor's noise, and add its ordinates over it.
    real(dp), intent(in) :: span               !! of the samples
    real(dp), intent(in) :: power(0:)
    logical, intent(in) :: coloured
    real(dp), intent(in) :: fitted(:)          !! frequencies of numbers that have been fitted
    real(dp), intent(in) :: floor
    integer, intent(in) :: s
    type(ordinates_type), intent(inout) :: ordinates
    real(dp), allocatable :: level(:)
    integer, allocatable :: sampled(:), at_knot(:)
    integer :: half, ranked, knots, k
    half = size(power) - 1
    ranked = min(half, most_ranked)
    knots = ubound(ordinates%noise%level, 1)
    sampled = [(nint(k*(real(half, dp)/ranked)), k=0, ranked)]
    at_knot = [(nint(k*(real(ranked, dp)/knots)), k=0, knots)]
    allocate (level(0:ranked))
    call find_level(power(sampled), min(max(1, nint(span/2)), size(sampled)/2), coloured, fitted, floor, level)
    ordinates%noise%level(:, s) = level(at_knot)
    call add_ratio(power, ordinates%noise%level(:, s), ordinates%total)
  end subroutine add_sensor

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

  pure real(dp) function mean_square(samples, length)
    !! Of Hann's window at the samples.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: length              !! M
    real(dp) :: centre
    integer :: n
    centre = centre_of(samples)
    mean_square = sum([(cos(2*pi*(place_of(samples, n) - centre)/length)**4, n=1, samples%count)])/samples%count
  end function mean_square

  pure subroutine taper(spectrum, turn)
    !! Turn the transform of samples into that of samples times Hann's window, ½(1 + cos(4π(τ − τ_c)/M)), which is as long as the
    !! record or a little longer: half of each ordinate and a quarter of those of one more and one fewer period in the window.
    complex(dp), intent(inout) :: spectrum(0:)
    real(dp), intent(in) :: turn               !! 4πτ_c/M
    complex(dp) :: before(-2:-1), after, factor
    integer :: m, half
    half = ubound(spectrum, 1)
    factor = exp(cmplx(0, turn, dp))/4
    before = conjg(spectrum(2:1:-1))
    do m = 0, half
      if (m + 2 <= half) then
        after = spectrum(m + 2)
      else if (m < half) then
        after = conjg(spectrum(m))
      else
        after = conjg(before(-2))
      end if
      associate (now => spectrum(m))
        after = now/2 + conjg(factor)*before(-2) + factor*after
        before(-2) = before(-1)
        before(-1) = now
        now = after
      end associate
    end do
  end subroutine taper

  subroutine transform(samples, left, plan, spectrum)
    !! The padded transform of one sensor.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: left(:)            !! (N)
    type(real_fourier), intent(inout) :: plan
    complex(dp), intent(out) :: spectrum(0:)   !! (0:M/2)
    if (allocated(samples%place)) then
      call uneven_transform(samples%place, left, 2*(size(spectrum) - 1), plan, spectrum)
    else
      call plan%prepare(2*(size(spectrum) - 1))
      plan%samples(:size(left)) = left
      plan%samples(size(left) + 1:) = 0
      call plan%transform()
      spectrum = plan%spectrum
    end if
  end subroutine transform

  subroutine find_power(samples, left, plan, spectrum, power)
    !! The ordinates |X|²/N of one sensor's numbers at even frequencies from 0 to half the sampling rate. Memory that is there is
    !! used again.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: left(:)            !! (N)
    type(real_fourier), intent(inout) :: plan
    complex(dp), allocatable, intent(inout) :: spectrum(:)
    real(dp), allocatable, intent(inout) :: power(:)
    integer :: last
    last = padded_length(samples)/2
    if (allocated(spectrum)) then
      if (ubound(spectrum, 1) /= last) deallocate (spectrum, power)
    end if
    if (.not. allocated(spectrum)) allocate (spectrum(0:last), power(0:last))
    call transform(samples, left, plan, spectrum)
    power = (spectrum%re**2 + spectrum%im**2)/size(left)
  end subroutine find_power

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
