module bw_record_lines
  !! The lines of a record in SI with their errors, and the candidates that were rejected: the interface of this folder to the rest
  !! of the program.
  use bw_estimated_lines, only: estimated_line, undetermined
  use bw_constants, only: two_pi
  use bw_found_lines, only: found_lines
  use bw_kinds, only: dp
  use bw_line_windows, only: window_start
  use bw_missing, only: is_missing, missing
  use bw_model, only: add_lines, at_sensors
  use bw_noise, only: gain_of
  use bw_polar_intervals, only: length_error, phase_error
  use bw_quantile, only: normal_quantile
  use bw_samples, only: place_of, samples_type, span_of
  implicit none (type, external)
  private
  public :: fitted_history, lines_in_si, noise_level

  real(dp), parameter :: same_place = 0.5_dp     !! bins within which candidates are one

  character(*), parameter, public :: status_words(*) = [character(10) :: 'line', 'close_pair', 'harmonic', 'drifting', 'at_edge']
    !! bits 1, 2, 4, …; `line` means none of the others
  character(*), parameter, public :: reason_words(*) = [character(12) :: 'not_needed', 'noise_colour']
    !! by number, from 1
  character(*), parameter, public :: reason_texts(*) = [character(64) :: &
    'not significant: the lines and noise explain it', &
    'a driven motion or coloured noise explains it equally well']

  type, public :: rejected_candidate
    !! A place in the spectrum that was examined and is no line.
    real(dp) :: angular_frequency = 0             !! rad/s
    real(dp) :: ordinate = 0                      !! half its likelihood gain
    integer :: reason = 0                         !! index in `reason_words`
  end type rejected_candidate

  type, public :: record_lines
    !! Lines by ascending frequency: sensor s moves as Re A_s e^(−δt + iβt). An error is the half-width of the interval at the
    !! requested confidence, a bound the Cramér–Rao standard deviation in the noise found.
    real(dp), allocatable :: angular_frequency(:), angular_frequency_error(:), angular_frequency_bound(:)   !! β, rad/s, (lines)
    real(dp), allocatable :: decay_rate(:), decay_rate_error(:), decay_rate_bound(:)      !! δ, 1/s; negative grows, (lines)
    complex(dp), allocatable :: amplitude(:, :)   !! A at the first blow, in the sensor's SI unit, (sensors, lines)
    real(dp), allocatable :: amplitude_error(:, :), amplitude_bound(:, :)                 !! of |A|, (sensors, lines)
    real(dp), allocatable :: amplitude_noise(:, :)
      !! standard deviation of the real part of A, and of its imaginary part, at known β and δ, (sensors, lines)
    complex(dp), allocatable :: noise_correlation(:, :, :)
      !! correlation of these parts between sensors, (sensors, sensors, lines); allocated if sensors share noise
    logical, allocatable :: own(:)
      !! the sensor is neither constant, nor left out, nor a multiple of an earlier one, (sensors)
    real(dp), allocatable :: phase_error(:, :), phase_bound(:, :)                         !! of arg A, rad, (sensors, lines)
    real(dp), allocatable :: drift(:), drift_bound(:)
      !! change of β from the blow to the last sample, or over three decay times if these are shorter, rad/s, (lines)
    real(dp), allocatable :: windows(:, :, :)
      !! β, δ and their bounds from each half and quarter of the record alone, `missing` if it does not determine them,
      !! (4, windows, lines)
    integer, allocatable :: status(:)             !! sum of bits of `status_words`, (lines)
    type(rejected_candidate), allocatable :: rejected(:)
    real(dp), allocatable :: noise_deviation(:)
      !! standard deviation of each sensor's residual; `missing` if it was left out: its amplitudes are not known, (sensors)
    real(dp) :: quantile = 1                      !! of a standard normal number, used for the errors
    real(dp), allocatable :: blow(:)              !! times of the blows since the first sample, s, (blows)
    real(dp) :: contact = 0                       !! s after each blow that are left out
    logical :: driven = .false.                   !! the motion is no free decay, and has no lines
    integer :: left_out = 0                       !! number of weaker lines that are not among these
    logical :: converged = .true.                 !! .false.: the search was ended before it converged
  end type record_lines

contains

  pure function lines_in_si(samples, found, estimated, confidence, most) result(lines)
    !! The strongest lines, converted from periods and e-folds per step to SI.
    type(samples_type), intent(in) :: samples     !! only their times are used
    type(found_lines), intent(in) :: found
    type(estimated_line), intent(in) :: estimated(:)
    real(dp), intent(in) :: confidence            !! of the intervals, 0 … 1
    integer, intent(in) :: most                   !! largest number of lines
    type(record_lines) :: lines
    integer, allocatable :: chosen(:)
    real(dp) :: turn, rate
    integer :: i
    chosen = strongest(estimated, most)
    lines%quantile = normal_quantile((1 + confidence)/2)
    rate = 1/samples%step
    turn = two_pi/samples%step
    lines%left_out = size(estimated) - size(chosen)
    lines%converged = found%outcome%converged
    lines%driven = found%outcome%driven
    lines%contact = samples%step*found%outcome%contact
    lines%blow = samples%step*[(place_of(samples, found%model%stretches(1, i)), i=1, ubound(found%model%stretches, 2))]
    lines%angular_frequency = turn*estimated(chosen)%frequency
    lines%angular_frequency_error = in_unit(estimated(chosen)%frequency_error, turn)
    lines%angular_frequency_bound = in_unit(estimated(chosen)%frequency_bound, turn)
    lines%decay_rate = rate*estimated(chosen)%decay
    lines%decay_rate_error = in_unit(estimated(chosen)%decay_error, rate)
    lines%decay_rate_bound = in_unit(estimated(chosen)%decay_bound, rate)
    lines%drift = turn*estimated(chosen)%drift
    lines%drift_bound = in_unit(estimated(chosen)%drift_bound, turn)
    lines%status = merge(2*estimated(chosen)%status, 1, estimated(chosen)%status > 0)
    associate (sensors => size(found%distinct%place), n => size(chosen))
      allocate (lines%amplitude(sensors, n), lines%amplitude_bound(sensors, n), lines%phase_bound(sensors, n), &
                lines%amplitude_noise(sensors, n))
      allocate (lines%windows(4, size(window_start), n))
    end associate
    do i = 1, size(chosen)
      associate (line => estimated(chosen(i)))
        lines%amplitude(:, i) = line%amplitude
        lines%amplitude_bound(:, i) = in_unit(line%amplitude_bound, 1.0_dp)
        lines%amplitude_noise(:, i) = line%amplitude_noise
        lines%phase_bound(:, i) = line%phase_bound
        lines%windows(:, :, i) = windows_in_si(line%windows, turn, rate)
      end associate
    end do
    lines%amplitude_error = length_error(abs(lines%amplitude), lines%amplitude_bound, lines%phase_bound*abs(lines%amplitude), &
      & lines%quantile)
    lines%phase_error = phase_error(lines%phase_bound, lines%quantile, confidence)
    if (any([(allocated(estimated(i)%noise_correlation), i=1, size(estimated))])) &
      & lines%noise_correlation = reshape([(estimated(chosen(i))%noise_correlation, i=1, size(chosen))], &
      & [size(found%distinct%place), size(found%distinct%place), size(chosen)])
    lines%own = [(any(found%distinct%kept == i), i=1, size(found%distinct%place))]
    lines%rejected = candidates_in_si(found, same_place*two_pi/span_of(samples), rate)
    associate (distinct => found%distinct)
      lines%noise_deviation = abs(distinct%factor)*found%deviation(max(1, distinct%place))
      where (distinct%place == 0) lines%noise_deviation = merge(missing, 0.0_dp, is_missing(distinct%constant))
    end associate
  end function lines_in_si

  elemental real(dp) function in_unit(deviation, unit)
    !! A standard deviation or error in another unit; `missing` if the record does not determine it.
    real(dp), intent(in) :: deviation, unit
    in_unit = missing
    if (deviation < undetermined/100) in_unit = unit*deviation
  end function in_unit

  pure function candidates_in_si(found, resolution, rate) result(candidates)
    !! The rejected candidates by descending gain, each frequency once.
    type(found_lines), intent(in) :: found
    real(dp), intent(in) :: resolution                 !! rad per step; closer candidates are one
    real(dp), intent(in) :: rate                  !! steps per second
    type(rejected_candidate), allocatable :: candidates(:)
    logical :: excluded(size(found%outcome%poles))
    real(dp) :: omega(size(excluded))             ! no associate name: gfortran 12 takes the real parts for it
    integer :: i, best
    omega = found%outcome%poles%im
    associate (gain => found%outcome%gains)
      excluded = [(any(abs([omega(i + 1:), found%model%lines%pole%im] - omega(i)) < resolution) &
        & .or. .not. omega(i) > resolution .or. .not. gain(i) > 1, i=1, size(omega))]
      allocate (candidates(0))
      do i = 1, count(.not. excluded)
        best = maxloc(gain, dim=1, mask=.not. excluded)
        excluded(best) = .true.
        candidates = [candidates, rejected_candidate(rate*omega(best), gain(best)/2, merge(2, 1, gain(best) > found%needed))]
      end do
    end associate
  end function candidates_in_si

  pure function windows_in_si(windows, turn, rate) result(converted)
    !! Frequencies and decay rates of windows; `missing` where the bounds are huge.
    real(dp), intent(in) :: windows(:, :)         !! (4, windows)
    real(dp), intent(in) :: turn, rate
    real(dp) :: converted(size(windows, 1), size(windows, 2))
    integer :: w
    converted = missing
    do w = 1, size(windows, 2)
      if (windows(3, w) < 1 .and. windows(4, w) < 1) converted([1, 3], w) = turn*windows([1, 3], w)
      if (windows(3, w) < 1 .and. windows(4, w) < 1) converted([2, 4], w) = rate*windows([2, 4], w)
    end do
  end function windows_in_si

  pure function strongest(estimated, most) result(chosen)
    !! Indices of the lines of largest amplitude, all sensors combined, in their order.
    type(estimated_line), intent(in) :: estimated(:)
    integer, intent(in) :: most
    integer, allocatable :: chosen(:)
    real(dp) :: strength(size(estimated))
    integer :: i
    strength = [(norm2(abs(estimated(i)%amplitude)), i=1, size(estimated))]
    chosen = pack([(i, i=1, size(estimated))], [(count(strength > strength(i)) < most, i=1, size(estimated))])
  end function strongest

  function fitted_history(samples, found, s) result(history)
    !! The history of one sensor that the lines, an offset and a slope give, at all samples of the record.
    type(samples_type), intent(in) :: samples     !! of the whole record; their values are not used
    type(found_lines), intent(in) :: found
    integer, intent(in) :: s
    real(dp), allocatable :: history(:)
    real(dp), allocatable :: motion(:, :)
    integer :: b, n, own
    allocate (history(samples%count), source=found%distinct%constant(s))
    own = found%distinct%place(s)
    if (own == 0) return
    allocate (motion(samples%count, 1), source=0.0_dp)
    associate (model => found%model)
      call add_lines(model%stretches, at_sensors(model%lines, [own]), 1.0_dp, motion, model%place)
      do b = 0, ubound(model%stretches, 2)
        do n = model%stretches(1, b), model%stretches(2, b)
          motion(n, 1) = motion(n, 1) + model%trend(1, own, b) &
            & + model%trend(2, own, b)*(place_of(samples, n) - place_of(samples, model%stretches(1, b)))
        end do
      end do
    end associate
    history = found%distinct%factor(s)*motion(:, 1)
  end function fitted_history

  pure real(dp) function noise_level(samples, found, frequency, s) result(level)
    !! The standard deviation of white noise that is as strong as a sensor's noise at a frequency.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    real(dp), intent(in) :: frequency             !! Hz
    integer, intent(in) :: s
    real(dp) :: power, share
    integer :: c, own, bin
    level = 0
    own = found%distinct%place(s)
    if (own == 0) return
    associate (model => found%model)
      power = 0
      do c = 1, size(found%distinct%kept)
        share = merge(1.0_dp, 0.0_dp, c == own)
        if (allocated(model%noise%mixing)) share = model%noise%unmixing(c, own)
        power = power + (share/abs(gain_of(model%noise%filter(:model%noise%order(c), c), &
          & cmplx(0, two_pi*frequency*samples%step, dp))))**2
      end do
      if (allocated(model%level)) then
        bin = max(1, min(size(model%level, 1), nint(2*frequency*samples%step*size(model%level, 1))))
        power = power*model%level(bin, own)
      end if
      level = abs(found%distinct%factor(s))*sqrt(power)
    end associate
  end function noise_level

end module bw_record_lines
