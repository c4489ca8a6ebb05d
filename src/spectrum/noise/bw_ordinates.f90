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
  public :: add_ratio, find_ordinates, least_ordinate, padded_length, square, transform

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: most_knots = 4096
  integer, parameter :: most_ranked = 32768    !! ordinates that the noise's level is found from
  integer, parameter :: most_seen = 4096       !! that correlations of the sensors' noise are found from
  real(dp), parameter :: quartile = 0.67449_dp !! of a normal number, in standard deviations
  real(dp), parameter :: numbers_of_line = 2   !! real ones that a line's amplitude is at each sensor
  real(dp), parameter :: numbers_of_all = 2    !! frequency and decay, which all sensors share
  real(dp), parameter :: rounding = 4*epsilon(1.0_dp)  !! of a sample, over the record's root mean square

  type, public :: ordinates_type
    integer :: length = 0                      !! M of the padded transform; ordinate m is at m/M periods per step
    real(dp), allocatable :: total(:)          !! Σ_s |X_s|²/(N·level): of noise alone a sum of S numbers e^(−x), (0:M/2)
    type(level_knots) :: noise
    real(dp) :: shape = 1                      !! as many sensors of independent noise have ordinates that scatter so
    real(dp), allocatable :: deviation(:)      !! of what is left, (S)
    complex(dp), allocatable :: seen(:, :)     !! X_s/√(N·level) at places a period or more apart, (places, S); without a taper
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
    real(dp), allocatable :: left(:)
    complex(dp), allocatable :: seen(:)
    type(motion_type) :: motion
    real(dp) :: taper_square, floor
    integer :: s, length
    length = padded_length(samples)
    call prepare(length, size(samples%value, 2), plain)
    call prepare(length, size(samples%value, 2), tapered)
    if (.not. allocated(plain%seen)) &
      & allocate (plain%seen(min(most_seen, max(1, nint(span_of(samples)/2) - 1)), size(samples%value, 2)))
    allocate (seen(0:length/2))
    taper_square = mean_square(samples, length)
    motion = tabulated(samples, lines, still)
    do s = 1, size(samples%value, 2)
      call find_remainder(samples, motion, s, left)
      plain%deviation(s) = sqrt(dot_product(left, left)/size(left))
      associate (value => samples%value(:samples%count, s))
        floor = max(rounding**2*dot_product(value, value)/size(left), tiny(1.0_dp)*1.0e50_dp)
      end associate
      call transform(samples, left, plan)
      call add_sensor(samples, plan%spectrum(0:length/2), 1.0_dp/size(left), .true., lines%frequency, floor, s, plain)
      call taper(plan%spectrum(0:length/2), 4*pi*centre_of(samples)/length, seen)
      call add_sensor(samples, seen, 1/(size(left)*taper_square), .false., lines%frequency, floor, s, tapered)
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

  subroutine add_sensor(samples, spectrum, scale, coloured, fitted, floor, s, ordinates)
    !! Find the level of one sensor's noise, and add its ordinates over it.
    type(samples_type), intent(in) :: samples
    complex(dp), intent(in) :: spectrum(0:)
    real(dp), intent(in) :: scale              !! of its squares, that makes ordinates of them
    logical, intent(in) :: coloured
    real(dp), intent(in) :: fitted(:)          !! frequencies of the lines
    real(dp), intent(in) :: floor
    integer, intent(in) :: s
    type(ordinates_type), intent(inout) :: ordinates
    real(dp), allocatable :: power(:), level(:)
    integer :: half, ranked, knots, k
    half = size(spectrum) - 1
    ranked = min(half, most_ranked)
    knots = ubound(ordinates%noise%level, 1)
    allocate (power(0:ranked), level(0:ranked))
    do k = 0, ranked
      power(k) = scale*square(spectrum(nint(k*(real(half, dp)/ranked))))
    end do
    call find_level(power, min(max(1, nint(span_of(samples)/2)), size(power)/2), coloured, fitted, &
      & numbers_of_line + numbers_of_all/size(samples%value, 2), floor, level)
    do k = 0, knots
      ordinates%noise%level(k, s) = level(nint(k*(real(ranked, dp)/knots)))
    end do
    call add_ratio(spectrum, ordinates%noise%level(:, s)/scale, ordinates%total)
    if (.not. allocated(ordinates%seen)) return
    do k = 1, size(ordinates%seen, 1)
      associate (part => k/(size(ordinates%seen, 1) + 1.0_dp))
        ordinates%seen(k, s) = spectrum(nint(part*half))*sqrt(scale/level(nint(part*ranked)))
      end associate
    end do
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

  pure subroutine add_ratio(spectrum, level, total)
    !! Add the squares of a spectrum over a level, whose inverse is a straight line between its knots.
    complex(dp), intent(in) :: spectrum(0:)
    real(dp), intent(in) :: level(0:)
    real(dp), intent(inout) :: total(0:)
    real(dp) :: spacing, slope
    integer :: m, k, first, last, knots, half
    knots = size(level) - 1
    half = size(total) - 1
    spacing = real(half, dp)/knots
    last = -1
    do k = 0, knots - 1
      first = last + 1
      last = merge(half, int((k + 1)*spacing), k == knots - 1)
      slope = (1/level(k + 1) - 1/level(k))/spacing
      do m = first, last
        total(m) = total(m) + square(spectrum(m))*(1/level(k) + (m - k*spacing)*slope)
      end do
    end do
  end subroutine add_ratio

  elemental real(dp) function square(value)
    !! Of the absolute value.
    complex(dp), intent(in) :: value
    square = value%re**2 + value%im**2
  end function square

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

  pure subroutine taper(spectrum, turn, seen)
    !! Turn the transform of samples into that of samples times Hann's window, ½(1 + cos(4π(τ − τ_c)/M)), which is as long as the
    !! record or a little longer: half of each ordinate and a quarter of those of one more and one fewer period in the window.
    complex(dp), intent(in) :: spectrum(0:)
    real(dp), intent(in) :: turn               !! 4πτ_c/M
    complex(dp), intent(out) :: seen(0:)
    complex(dp) :: factor
    integer :: m, half
    half = ubound(spectrum, 1)
    factor = exp(cmplx(0, turn, dp))/4
    do m = 2, half - 2
      seen(m) = spectrum(m)/2 + conjg(factor)*spectrum(m - 2) + factor*spectrum(m + 2)
    end do
    do m = 0, half
      if (m > 1 .and. m < half - 1) cycle      ! mirror images below 0 and beyond half the sampling rate
      seen(m) = spectrum(m)/2 + conjg(factor)*image(m - 2) + factor*image(m + 2)
    end do

  contains

    pure complex(dp) function image(m)
      integer, intent(in) :: m
      if (m < 0) then
        image = conjg(spectrum(-m))
      else if (m > half) then
        image = conjg(spectrum(2*half - m))
      else
        image = spectrum(m)
      end if
    end function image

  end subroutine taper

  subroutine transform(samples, left, plan, weight)
    !! The padded transform of one sensor's numbers, into the plan's spectrum, at even frequencies from 0 to half the sampling rate.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: left(:)            !! (N)
    type(real_fourier), intent(inout) :: plan
    real(dp), intent(in), optional :: weight(:)  !! of each number, (N)
    complex(dp), allocatable :: spectrum(:)
    integer :: length
    length = padded_length(samples)
    if (allocated(samples%place)) then
      allocate (spectrum(0:length/2))
      if (present(weight)) then
        call uneven_transform(samples%place, weight*left, length, plan, spectrum)
      else
        call uneven_transform(samples%place, left, length, plan, spectrum)
      end if
      plan%spectrum(0:length/2) = spectrum
    else
      call plan%prepare(length)
      if (present(weight)) then
        plan%samples(:size(left)) = weight*left
      else
        plan%samples(:size(left)) = left
      end if
      plan%samples(size(left) + 1:) = 0
      call plan%transform()
    end if
  end subroutine transform

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
