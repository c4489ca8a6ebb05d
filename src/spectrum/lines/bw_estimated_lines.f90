module bw_estimated_lines
  !! Statistics of the lines of a record: bounds in the noise found, intervals that include drift, and the status of lines that are
  !! not single steady modes.
  !!
  !! The bound is the Cramér–Rao standard deviation. The interval is a quantile of it; for a drifting line it also covers the change
  !! from the blow to the end of the line's life.
  use bw_constants, only: pi
  use bw_found_lines, only: find_record_lines, found_lines
  use bw_kinds, only: dp
  use bw_line, only: life_of, line_type, pole_at
  use bw_line_errors, only: amplitude_deviation, amplitude_noise, drift_deviation, line_errors, line_errors_of, pole_deviation
  use bw_line_names, only: at_edge, close_pair, drifting, estimated_line, harmonic, name_lines
  use bw_line_windows, only: windows_of
  use bw_model, only: colour_at, model_type
  use bw_monitor, only: monitor_type, stops
  use bw_noise, only: gain_of
  use bw_order, only: ascending
  use bw_pure_record, only: rounding
  use bw_quantile, only: student_quantile
  use bw_refit, only: cluster_of, refit, refit_type, span_of_model
  use bw_samples, only: samples_type
  implicit none (type, external)
  private
  public :: at_edge, close_pair, drifting, estimate_lines, estimated_line, harmonic

  real(dp), parameter :: life = 3                !! decay times after which a line has died out
  real(dp), parameter :: most_share = 0.9_dp     !! largest share of noise in a line's squared amplitudes
  real(dp), parameter, public :: undetermined = 1.0e100_dp  !! a bound that the record does not determine

contains

  subroutine estimate_lines(samples, confidence, false_alarm, found, estimated, monitor)
    !! Find the lines of a record with their intervals, by ascending frequency.
    type(samples_type), intent(inout) :: samples   !! loses sensors that are constant or multiples of others
    real(dp), intent(in) :: confidence             !! of the intervals, 0 … 1
    real(dp), intent(in) :: false_alarm            !! probability that noise alone yields any line
    type(found_lines), intent(out) :: found
    type(estimated_line), allocatable, intent(out) :: estimated(:)
    class(monitor_type), intent(inout), optional :: monitor  !! results are undefined after a stop request
    call find_record_lines(samples, false_alarm, found, monitor)
    allocate (estimated(0))
    if (stops(monitor)) return
    call judge_lines(found%model, confidence, false_alarm, estimated)
    estimated = estimated(ascending(estimated%frequency))
    call name_lines(samples, false_alarm, estimated)
    call add_multiples(found, estimated)
  end subroutine estimate_lines

  subroutine judge_lines(model, confidence, false_alarm, estimated)
    !! Judge all lines; those that overlap are fitted together.
    type(model_type), intent(in) :: model
    real(dp), intent(in) :: confidence, false_alarm
    type(estimated_line), allocatable, intent(inout) :: estimated(:)
    logical :: done(size(model%lines)), own(size(model%lines))
    type(refit_type) :: found
    type(line_errors) :: errors
    type(estimated_line) :: line
    real(dp), allocatable :: windows(:, :, :)
    integer :: j, k
    done = .false.
    do while (.not. all(done))
      own = cluster_of(model, findloc(done, .false., dim=1))
      done = done .or. own
      call refit(model, own, pack(model%lines, own), 0, found)
      if (.not. any(found%reduced%stretch >= 1)) cycle   ! no samples to fit them to
      errors = line_errors_of(pack(model%lines, own), found%reduced)
      windows = windows_of(model, pack(model%lines, own), false_alarm)
      j = 0
      do k = 1, size(own)
        if (.not. own(k)) cycle
        j = j + 1
        line = judged_line(model, errors, j, confidence)
        if (.not. is_in_band(line, student_quantile(confidence, freedom_of(model))/span_of_model(model))) cycle
        line%windows = windows(:, :, j)
        estimated = [estimated, line]
      end do
    end do
  end subroutine judge_lines

  pure logical function is_in_band(line, unresolved)
    !! Whether a line's frequency is certainly between 0 and half the sampling rate, to within the resolution. If not, the line
    !! represents something else.
    type(estimated_line), intent(in) :: line
    real(dp), intent(in) :: unresolved             !! half-width of the interval of a frequency at the record's resolution
    real(dp), parameter :: middle = 0.25_dp        ! of the band, periods per step
    is_in_band = abs(line%frequency - middle) + line%frequency_error <= middle + 2*unresolved
  end function is_in_band

  type(estimated_line) function judged_line(model, errors, j, confidence) result(line)
    !! Frequency and decay at the time at which they are known best. Intervals of a drifting line cover the values from the blow
    !! to the end of its life.
    type(model_type), intent(in) :: model
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp), intent(in) :: confidence
    complex(dp) :: ends(2), pole
    real(dp) :: at, deviation(2), reach(2), quantile, wider
    associate (own => errors%lines(j))
      at = life_of(own, life, span_of_model(model))
      ends = [own%pole, pole_at(own, at)]
      wider = sqrt(colour_at(model, own%pole%im)/(1 - noise_share(errors, j)))
      deviation = limited(wider, max(pole_deviation(errors, j, 0.0_dp), pole_deviation(errors, j, at)))
      quantile = student_quantile(confidence, freedom_of(model))
      pole = pole_at(own, best_time(errors, j, at))
      reach = max(abs([real(ends(1) - pole, dp), aimag(ends(1) - pole)]), abs([real(ends(2) - pole, dp), aimag(ends(2) - pole)]))
      line%frequency = pole%im/(2*pi)
      line%frequency_bound = deviation(2)/(2*pi)
      if (.not. deviation(2) < undetermined .or. .not. own%pole%im > 0) line%frequency_bound = 1/span_of_model(model)
      line%frequency_error = reach(2)/(2*pi) + quantile*line%frequency_bound + rounding*line%frequency
      line%decay = -pole%re
      line%decay_bound = deviation(1)
      line%decay_error = reach(1) + quantile*deviation(1) + 2*pi*rounding*line%frequency
      if (own%steady) then                         ! it is taken as 0
        line%decay_bound = undetermined
        line%decay_error = undetermined
      end if
      if (size(own%courses) > 0) then
        line%status = drifting
        line%drift = (ends(2)%im - ends(1)%im)/(2*pi)
        line%drift_bound = limited(wider/(2*pi), drift_deviation(errors, j, at))
      end if
      call judge_amplitude(model, errors, j, wider, line)
    end associate
  end function judged_line

  elemental real(dp) function limited(factor, deviation)
    !! A deviation times a factor, at most `undetermined`; that of a number that is not determined is huge.
    real(dp), intent(in) :: factor, deviation
    limited = undetermined
    if (deviation < undetermined) limited = min(factor*deviation, undetermined)
  end function limited

  pure real(dp) function best_time(errors, j, last) result(best)
    !! The time after the blow at which the pole of line j is known best; 0 if it does not drift.
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp), intent(in) :: last                 !! steps
    integer, parameter :: trials = 32
    real(dp) :: deviation, least
    integer :: i
    best = 0
    if (size(errors%lines(j)%courses) == 0) return
    least = huge(1.0_dp)
    do i = 0, trials
      deviation = maxval(pole_deviation(errors, j, last*i/trials))
      if (.not. deviation < least) cycle
      least = deviation
      best = last*i/trials
    end do
  end function best_time

  pure integer function freedom_of(model) result(freedom)
    !! Degrees of freedom of the noise level at one frequency: an autoregression of order p estimates it from about N/p values
    !! of each sensor (Kay, Modern Spectral Estimation, 1988).
    type(model_type), intent(in) :: model
    freedom = max(4, size(model%white)/(1 + maxval(model%noise%order)))
  end function freedom_of

  pure real(dp) function noise_share(errors, j) result(share)
    !! The share of line j's squared amplitudes that noise is expected to contribute. The slopes of a fit are proportional to the
    !! amplitudes found, so that the true information is F (1 − share) instead of F: estimates scatter by more than the bound for
    !! known amplitudes (Stoica and Nehorai, 1990).
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j
    real(dp) :: squares, added
    integer :: p
    squares = tiny(1.0_dp)
    added = 0
    do p = 1, size(errors%reduced)
      associate (a => errors%reduced(p)%linear_part)
        squares = squares + sum(a(2*j - 1:2*j, :)**2)
        added = added + 2*size(a, 2)*min(amplitude_noise(errors, p, j), sqrt(undetermined))**2
      end associate
    end do
    share = min(most_share, added/squares)
    if (.not. added < undetermined) share = 0
  end function noise_share

  subroutine judge_amplitude(model, errors, j, wider, line)
    !! Find amplitudes at the blow and the bounds of their moduli and phases. Each is a sum over the components of the noise.
    type(model_type), intent(in) :: model
    type(line_errors), intent(in) :: errors
    integer, intent(in) :: j                       !! index of the line in the fit
    real(dp), intent(in) :: wider                  !! factor of all bounds
    type(estimated_line), intent(inout) :: line
    complex(dp) :: factor(size(model%white, 2), size(model%white, 2)), noises(size(model%white, 2), size(model%white, 2)), turn
    real(dp) :: noise(size(model%white, 2)), length
    integer :: s, p, stretch
    stretch = minval(errors%reduced%stretch, mask=errors%reduced%stretch >= 1)
    factor = factors_of(model, errors%lines(j))
    do p = 1, size(errors%reduced)
      associate (own => errors%reduced(p))
        if (own%stretch == stretch) noise(own%sensors(1):own%sensors(2)) = limited(wider, amplitude_noise(errors, p, j))
      end associate
    end do
    line%amplitude = errors%lines(j)%amplitude(:, 1 + stretch)
    allocate (line%amplitude_bound(size(factor, 1)), line%phase_bound(size(factor, 1)), line%amplitude_noise(size(factor, 1)))
    do s = 1, size(factor, 1)
      length = abs(line%amplitude(s))
      turn = 1
      if (length > 0) turn = line%amplitude(s)/length
      line%amplitude_noise(s) = norm2(noise*abs(factor(s, :)))
      noises(:, s) = factor(s, :)*noise/max(line%amplitude_noise(s), tiny(1.0_dp))
      line%amplitude_bound(s) = limited(wider, amplitude_deviation(errors, stretch, j, plane(turn*conjg(factor(s, :)))))
      turn = cmplx(-turn%im, turn%re, dp)
      line%phase_bound(s) = limited(wider, amplitude_deviation(errors, stretch, j, plane(turn*conjg(factor(s, :)))))
      line%phase_bound(s) = min(line%phase_bound(s), pi*length)/max(length, tiny(1.0_dp))
    end do
    if (allocated(model%noise%mixing)) line%noise_correlation = matmul(transpose(noises), conjg(noises))

  contains

    pure function plane(direction)
      !! Real and imaginary parts.
      complex(dp), intent(in) :: direction(:)
      real(dp) :: plane(2, size(direction))
      plane(1, :) = real(direction, dp)
      plane(2, :) = aimag(direction)
    end function plane

  end subroutine judge_amplitude

  pure function factors_of(model, line) result(factor)
    !! The amplitudes at the sensors of a line whose whitened amplitude is 1 in one component, (S, components).
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: line
    complex(dp) :: factor(size(model%white, 2), size(model%white, 2))
    integer :: c
    factor = 0
    do c = 1, size(factor, 2)
      factor(c, c) = 1
      if (allocated(model%noise%mixing)) factor(:, c) = model%noise%unmixing(c, :)
      factor(:, c) = factor(:, c)/gain_of(model%noise%filter(:model%noise%order(c), c), line%pole)
    end do
  end function factors_of

  subroutine add_multiples(found, estimated)
    !! Extend the lines to sensors that are multiples of others. Constant sensors do not determine amplitudes.
    type(found_lines), intent(in) :: found
    type(estimated_line), intent(inout) :: estimated(:)  !! noise correlations are those of the sensors kept, else 0
    complex(dp), allocatable :: correlation(:, :)
    integer, allocatable :: source(:)
    integer :: k
    associate (distinct => found%distinct)
      if (size(distinct%kept) == size(distinct%place)) return
      source = max(distinct%place, 1)
      do k = 1, size(estimated)
        associate (line => estimated(k), is_constant => distinct%place == 0)
          line%amplitude = merge((0.0_dp, 0.0_dp), distinct%factor*line%amplitude(source), is_constant)
          line%amplitude_bound = merge(undetermined, abs(distinct%factor)*line%amplitude_bound(source), is_constant)
          line%amplitude_noise = merge(undetermined, abs(distinct%factor)*line%amplitude_noise(source), is_constant)
          line%phase_bound = merge(pi, line%phase_bound(source), is_constant)
          if (.not. allocated(line%noise_correlation)) cycle
          allocate (correlation(size(source), size(source)), source=(0.0_dp, 0.0_dp))
          correlation(distinct%kept, distinct%kept) = line%noise_correlation
          call move_alloc(correlation, line%noise_correlation)
        end associate
      end do
    end associate
  end subroutine add_multiples

end module bw_estimated_lines
