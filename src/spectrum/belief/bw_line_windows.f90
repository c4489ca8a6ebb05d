module bw_line_windows
  !! The lines of a band in halves and quarters of the record: what each part says by itself of their frequencies and decays.
  !!
  !! A part tells of a line that stands out of its noise: what the line takes off the squares there is more than the search for lines
  !! asks for. Noise takes its share of that, one for each sensor, since the amplitudes are fitted to it too: of the ordinate x only
  !! x − S is the line's. The slope of the ordinates at their peak scatters by the noise beside the line, and by the noise beside
  !! noise, in the ratio (x − S) to S, so that the variance is (x/(x − S))² times what the fitted amplitudes promise.
  use bw_band, only: band_type, cut_band
  use bw_band_fit, only: fit_band, fit_type, reduce, reduced_type
  use bw_damped_line, only: damped_line
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band
  use bw_line_errors, only: decay_deviation, frequency_deviation, line_errors, line_errors_of
  use bw_ordinates, only: least_ordinate
  use bw_samples, only: centre_of, samples_type, span_of
  implicit none (type, external)
  private
  public :: steady_at, windows_of

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: least_apart = 0.7_dp  !! bins of a window between lines that it is fitted with
  real(dp), parameter :: untold(4) = [0.0_dp, 0.0_dp, huge(1.0_dp), huge(1.0_dp)]  !! what a window says that does not tell
  real(dp), parameter, public :: window_start(6) = [0.0_dp, 0.5_dp, 0.0_dp, 0.25_dp, 0.5_dp, 0.75_dp]
  real(dp), parameter, public :: window_end(6) = [0.5_dp, 1.0_dp, 0.25_dp, 0.5_dp, 0.75_dp, 1.0_dp]
    !! halves and quarters of the record

contains

  function windows_of(samples, band, rows, weight, own, shape, false_alarm) result(windows)
    !! Frequency, decay and their bounds of a band's lines, all fitted to each window, (4, windows, lines). Where a window does not
    !! tell, its bounds are huge.
    type(samples_type), intent(in) :: samples
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: rows(:, :)         !! of the band, without the lines that are not its own
    real(dp), intent(in) :: weight(:)          !! one over the noise's variance, (S)
    type(damped_line), intent(in) :: own(:)
    real(dp), intent(in) :: shape              !! sensors of independent noise
    real(dp), intent(in) :: false_alarm        !! that noise alone is taken for a line in a window
    real(dp) :: windows(4, size(window_start), size(own))
    type(band_type) :: part
    type(fit_type) :: fit
    real(dp), allocatable :: part_rows(:, :)
    real(dp) :: bins, least
    integer :: i, j
    windows = spread(spread(untold, 2, size(windows, 2)), 3, size(own))
    do i = 1, size(window_start)
      bins = span_of(samples)*(window_end(i) - window_start(i))
      least = least_ordinate(shape, bins/2, false_alarm)
      call cut_band(band%band, rows, window_start(i), window_end(i), part, part_rows)
      if (size(part_rows, 1) < 6*size(own) + 2) cycle
      if (closest(own%frequency)*bins < least_apart) cycle
      fit%lines = [(steady_at(samples, own(j), window_start(i) + window_end(i) - 1), j=1, size(own))]
      call fit_band(samples, part, part_rows, weight, band%with_still, fit)
      windows(:, i, :) = judged(fit%lines)
    end do

  contains

    function judged(lines) result(window)
      !! What a fit to the window says of those of its lines that stand out.
      type(damped_line), intent(in) :: lines(:)
      real(dp) :: window(4, size(lines))
      type(reduced_type) :: without
      type(line_errors) :: errors
      integer, allocatable :: others(:)
      real(dp) :: pays, factor
      integer :: k, m
      errors = line_errors_of(reduce(samples, part, part_rows, lines, band%with_still), weight)
      window = spread(untold, 2, size(lines))
      do k = 1, size(lines)
        others = pack([(m, m=1, size(lines))], [(m /= k, m=1, size(lines))])
        without = reduce(samples, part, part_rows, lines(others), band%with_still, 0*others)
        pays = sum(weight*(without%left - errors%reduced%left))/2
        if (pays < least) cycle
        factor = pays/(pays - shape)
        window(:, k) = [lines(k)%frequency, lines(k)%decay, factor*frequency_deviation(errors, k)/(2*pi*centre_of(samples)), &
          & factor*decay_deviation(errors, k)/centre_of(samples)]
      end do
    end function judged

  end function windows_of

  pure type(damped_line) function steady_at(samples, line, u) result(steady)
    !! The line without its drift, at the place that it has at the time u.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: line
    real(dp), intent(in) :: u
    complex(dp) :: rate
    integer :: m
    steady = line
    rate = sum([(m*line%bend(m)*u**(m - 1), m=2, line%powers)])
    steady%decay = line%decay - rate%re/centre_of(samples)
    steady%frequency = line%frequency + rate%im/(2*pi*centre_of(samples))
    steady%powers = 1
    steady%bend = 0
  end function steady_at

  pure real(dp) function closest(frequency)
    !! The least distance between two of several frequencies.
    real(dp), intent(in) :: frequency(:)
    integer :: i
    closest = sqrt(huge(1.0_dp))
    do i = 2, size(frequency)
      closest = min(closest, minval(abs(frequency(:i - 1) - frequency(i))))
    end do
  end function closest

end module bw_line_windows
