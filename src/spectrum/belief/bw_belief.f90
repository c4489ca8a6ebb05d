module bw_belief
  !! What can be believed of the lines of a record: bounds in the noise found, intervals that hold what the record shows of
  !! drift, and names for lines that are no single steady mode.
  !!
  !! The bound is the Cramér–Rao standard deviation. The interval is a quantile of it, or what the likelihood says where noise
  !! moves a line too far for that. Frequency and decay of a line that drifts are those at the time at which the record tells them
  !! best; the interval reaches to where they are at both ends of the record, or of the line's life if that is shorter.
  use bw_band_fit, only: reduce
  use bw_common_noise, only: parts_of
  use bw_damped_line, only: damped_line, most_powers
  use bw_drift, only: drift_of, drift_type
  use bw_found_lines, only: found_lines
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band, own_rows, weight_of
  use bw_line_errors, only: amplitude_deviation, amplitude_noise, best_time, decay_deviation, frequency_deviation, line_errors, &
    & line_errors_of, noise_share, sensors_of
  use bw_line_names, only: at_edge, believed_line, close_pair, drifting, harmonic, name_lines
  use bw_line_windows, only: steady_at, window_end, window_start, windows_of
  use bw_order, only: ascending
  use bw_ordinates, only: ordinates_type
  use bw_profile_width, only: profile_widths
  use bw_pure_record, only: rounding
  use bw_quantile, only: normal_quantile
  use bw_recorded_sensors, only: undetermined
  use bw_samples, only: bent_factor, centre_of, samples_type, span_of
  use bw_whitening, only: gain_of
  implicit none (type, external)
  private
  public :: at_edge, believed_line, believed_lines, close_pair, drifting, harmonic

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: life = 3              !! decay times after which a line is taken for gone
  real(dp), parameter :: told = 0.1_dp         !! bins of a window, of the bound of a frequency that the window tells
  real(dp), parameter :: near = 4              !! bins on either side of a line in which its shape leaves something
  integer, parameter :: beyond = 2             !! powers of time that a drift may have beside those that are fitted; from trials
  integer, parameter :: looks = 16             !! times, less one, at which a drifting line is looked at

contains

  function believed_lines(samples, found, confidence, false_alarm) result(believed)
    !! The lines by ascending frequency.
    type(samples_type), intent(in) :: samples  !! as `find_damped_lines` has left them
    type(found_lines), intent(in) :: found
    real(dp), intent(in) :: confidence         !! of the intervals, 0 … 1
    real(dp), intent(in) :: false_alarm        !! that a steady line is said to drift
    type(believed_line), allocatable :: believed(:)
    integer :: i
    allocate (believed(size(found%lines)))
    do i = 1, size(found%bands)
      if (size(found%bands(i)%member) > 0) call judge_band(samples, found, found%bands(i), confidence, false_alarm, believed)
    end do
    believed = believed(ascending(believed%frequency))
    call name_lines(samples, believed)
  end function believed_lines

  subroutine judge_band(samples, found, band, confidence, false_alarm, believed)
    !! Bounds, drift and intervals of the lines of one band.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: confidence, false_alarm
    type(believed_line), intent(inout) :: believed(:)
    type(line_errors) :: errors
    real(dp), allocatable :: rows(:, :), windows(:, :, :)
    type(damped_line), allocatable :: own(:)
    type(damped_line) :: steady
    real(dp) :: half, quantile, share, at, deviation(2), width(2)
    integer :: j
    logical :: oscillates
    own = found%lines(band%member)
    rows = own_rows(samples, found%lines, found%still, band)
    errors = line_errors_of(reduce(samples, band%band, rows, own, band%with_still), &
      & weight_of(found%ordinates%noise, band, size(samples%value, 2)))
    half = centre_of(samples)
    do j = 1, size(own)
      associate (line => believed(band%member(j)))
        line%number = band%member(j)
        at = best_time(errors, j)
        share = noise_share(errors, j)
        quantile = student_quantile(confidence, span_of(samples), sensors_of(errors, j))/sqrt(1 - share)
        steady = steady_at(samples, own(j), at)
        deviation = [decay_deviation(errors, j, at), frequency_deviation(errors, j, at)]/sqrt(1 - share)
        line%frequency = steady%frequency
        line%decay = steady%decay
        line%decay_bound = min(deviation(1)/half, undetermined)
        line%frequency_bound = min(deviation(2)/(2*pi*half), undetermined)
        oscillates = line%frequency_bound < undetermined
        if (.not. oscillates) line%frequency_bound = 1/span_of(samples)  ! e^(−dτ) is at 0, as far as a record tells
        line%decay_error = quantile*line%decay_bound
        line%frequency_error = quantile*line%frequency_bound
        if (oscillates .and. found%at_rest) then  ! elsewhere the squares that are left tell nothing of noise
          width = profile_widths(samples, band, rows, errors%weight, own, j, deviation, quantile)
          line%decay_error = width(1)/half
          line%frequency_error = width(2)/(2*pi*half)
        end if
        line%decay_error = line%decay_error + 2*pi*rounding*line%frequency
        line%frequency_error = line%frequency_error + rounding*line%frequency
        call judge_amplitude(errors, found, own(j), j, centre_of(samples) + maxval(found%whitening%lost)/2.0_dp, line)
        if (oscillates) call judge_drift(samples, drift_of(samples, band, rows, errors%weight, own, j, max(own(j)%powers, 2)), &
          & own(j)%powers > 1, false_alarm, line)
        if (iand(line%status, drifting) > 0) call reach_ends(samples, &
          & drift_of(samples, band, rows, errors%weight, own, j, min(max(own(j)%powers, 2) + beyond, most_powers)), &
          & quantile, own(j), line)
      end associate
    end do
    windows = windows_of(samples, band, rows, errors%weight, own, found%ordinates%shape, false_alarm)
    do j = 1, size(own)
      believed(band%member(j))%windows = windows(:, :, j)
      call widen(samples, found%ordinates, false_alarm/size(found%lines), believed(band%member(j)))
    end do
  end subroutine judge_band

  subroutine widen(samples, ordinates, false_alarm, line)
    !! Let the intervals also hold what halves and quarters of the record say, and scale them where the line's shape leaves more
    !! beside it than the noise has; both only where noise would hardly do so.
    type(samples_type), intent(in) :: samples
    type(ordinates_type), intent(in) :: ordinates
    real(dp), intent(in) :: false_alarm        !! that noise does so to this line
    type(believed_line), intent(inout) :: line
    real(dp) :: sigmas, away(2), mean, freedom
    integer :: i, first, last
    sigmas = normal_quantile(1 - false_alarm/(4*size(window_start)))
    do i = 1, size(window_start)
      if (line%windows(3, i) > told/(span_of(samples)*(window_end(i) - window_start(i)))) cycle
      away = abs(line%windows(1:2, i) - [line%frequency, line%decay])
      if (away(1) > sigmas*line%windows(3, i)) line%frequency_error = max(line%frequency_error, away(1))
      if (away(2) > sigmas*line%windows(4, i)) line%decay_error = max(line%decay_error, away(2))
    end do
    first = max(0, nint((line%frequency - near/span_of(samples))*ordinates%length))
    last = min(ubound(ordinates%total, 1), nint((line%frequency + near/span_of(samples))*ordinates%length))
    mean = sum(ordinates%total(first:last))/((last - first + 1)*ordinates%shape)
    freedom = 2*ordinates%shape*(last - first)*span_of(samples)/ordinates%length
    if (mean <= (1 - 2/(9*freedom) + normal_quantile(1 - false_alarm)*sqrt(2/(9*freedom)))**3) return
    line%frequency_error = line%frequency_error*sqrt(mean)
    line%decay_error = line%decay_error*sqrt(mean)
  end subroutine widen

  subroutine judge_drift(samples, drift, fitted, false_alarm, line)
    !! Say whether a line drifts, and how far over the record, or over its life if that is shorter.
    type(samples_type), intent(in) :: samples
    type(drift_type), intent(in) :: drift
    logical, intent(in) :: fitted              !! the drift is among the line's unknowns
    real(dp), intent(in) :: false_alarm
    type(believed_line), intent(inout) :: line
    real(dp) :: half, u(2), slope(size(drift%value))
    integer :: m
    half = centre_of(samples)
    u = life_of(line, half)
    slope = 0
    slope(2::2) = [(m*(u(2)**(m - 1) - u(1)**(m - 1)), m=1, size(slope)/2)]
    line%drift = dot_product(slope, drift%value)/(2*pi*half)
    line%drift_bound = sqrt(dot_product(slope, matmul(drift%covariance, slope)))/(2*pi*half)
    if (.not. (fitted .or. drift%gain > -2*log(false_alarm))) return
    if (norm2(drift%value) <= rounding*2*pi*line%frequency*half) return
    line%status = ior(line%status, drifting)
  end subroutine judge_drift

  subroutine reach_ends(samples, drift, quantile, own, line)
    !! Let the intervals of a line that drifts reach to where it is anywhere in the record, or in its life if that is shorter.
    type(samples_type), intent(in) :: samples
    type(drift_type), intent(in) :: drift      !! with powers of time beyond those that it pays for: what a fit leaves out because
                                               !! noise may explain it is largest at the ends
    real(dp), intent(in) :: quantile
    type(damped_line), intent(in) :: own       !! the line as it was fitted
    type(believed_line), intent(inout) :: line
    real(dp) :: half, u(2), slope(size(drift%value)), reach(2), at, away(2)
    integer :: i, k, m
    half = centre_of(samples)
    u = life_of(line, half)
    away = [own%decay - line%decay, 2*pi*(line%frequency - own%frequency)]*half
    reach = 0
    do i = 0, looks
      at = u(1) + (u(2) - u(1))*i/looks
      do k = 1, 2
        slope = 0
        slope(k::2) = [(m*at**(m - 1), m=1, size(slope)/2)]
        reach(k) = max(reach(k), abs(dot_product(slope, drift%value) - away(k)) &
          & + quantile*sqrt(dot_product(slope, matmul(drift%covariance, slope))))
      end do
    end do
    line%decay_error = max(line%decay_error, reach(1)/half)
    line%frequency_error = max(line%frequency_error, reach(2)/(2*pi*half))
    if (.not. allocated(samples%place)) &
      & line%frequency_error = min(line%frequency_error, max(line%frequency, 0.5_dp - line%frequency))  ! nothing lies beyond
  end subroutine reach_ends

  pure function life_of(line, half) result(u)
    !! From when to when a line is there, u = −1 … 1 over the record.
    type(believed_line), intent(in) :: line
    real(dp), intent(in) :: half               !! of the record, in steps
    real(dp) :: u(2)
    u = [-1.0_dp, 1.0_dp]
    if (line%decay*2*half > life) u(2) = -1 + life/(line%decay*half)
    if (-line%decay*2*half > life) u(1) = 1 + life/(line%decay*half)
  end function life_of

  subroutine judge_amplitude(errors, found, own, j, centre, line)
    !! Amplitudes at the first sample of the record as it was, and the bounds of their lengths and phases. Each is a sum over what
    !! the sensors were separated into, where they share noise.
    type(line_errors), intent(in) :: errors
    type(found_lines), intent(in) :: found
    type(damped_line), intent(in) :: own
    integer, intent(in) :: j                   !! its place among the band's lines
    real(dp), intent(in) :: centre             !! time in the middle of the record as it was, in steps
    type(believed_line), intent(inout) :: line
    complex(dp) :: factor(size(own%amplitude)), gain(size(found%whitening)), turn
    complex(dp) :: noises(size(own%amplitude), size(found%whitening))  ! in each sensor of what the sensors were separated into
    complex(dp) :: start
    real(dp) :: noise(size(own%amplitude)), length
    integer :: s
    start = exp(2*min(own%decay, 0.0_dp)*centre)*bent_factor(own%bend(:own%powers), -1.0_dp)
    gain = gain_of(found%whitening, own)
    noise = [(min(amplitude_noise(errors, j, s), undetermined), s=1, size(noise))]
    allocate (line%amplitude(size(gain)))
    allocate (line%amplitude_bound(size(gain)), line%phase_bound(size(gain)), line%amplitude_noise(size(gain)))
    do s = 1, size(gain)
      factor = parts_of(found%mixture, s, size(factor))*start/gain(s)
      line%amplitude(s) = sum(factor*own%amplitude)
      length = abs(line%amplitude(s))
      turn = 1
      if (length > 0) turn = line%amplitude(s)/length
      line%amplitude_noise(s) = norm2(abs(factor)*noise)
      noises(:, s) = factor*noise/max(line%amplitude_noise(s), tiny(1.0_dp))
      line%amplitude_bound(s) = min(amplitude_deviation(errors, j, plane(turn*conjg(factor))), undetermined)
      turn = cmplx(-turn%im, turn%re, dp)
      line%phase_bound(s) = min(amplitude_deviation(errors, j, plane(turn*conjg(factor))), pi*length)/max(length, tiny(1.0_dp))
    end do
    if (allocated(found%mixture%mixed)) line%noise_correlation = matmul(transpose(noises), conjg(noises))

  contains

    pure function plane(direction)
      !! Real and imaginary parts.
      complex(dp), intent(in) :: direction(:)
      real(dp) :: plane(2, size(direction))
      plane(1, :) = real(direction, dp)
      plane(2, :) = aimag(direction)
    end function plane

  end subroutine judge_amplitude

  pure real(dp) function student_quantile(confidence, span, sensors) result(quantile)
    !! How many standard deviations hold so much of a normal number whose deviation is known from the noise of a window only. Where
    !! it is a mean over sensors, of which each has a weight from its own noise, these weights are off as well: with f numbers in a
    !! window their means over sensors make the deviation look 1/f too small, and it is 1/f more than that of the best weights.
    real(dp), intent(in) :: confidence, span
    real(dp), intent(in) :: sensors            !! that tell the line, 1 or more
    real(dp) :: freedom
    freedom = max(10.0_dp, min(span, 96.0_dp))
    quantile = normal_quantile((1 + confidence)/2)
    quantile = quantile + (quantile**3 + quantile)/(4*freedom*sensors)
    quantile = quantile*(1 + (1 - 1/sensors)*2/freedom)
  end function student_quantile

end module bw_belief
