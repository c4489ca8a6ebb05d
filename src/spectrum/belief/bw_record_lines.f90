module bw_record_lines
  !! The lines of a record in SI, with all that is known of their errors, and what was looked at and is no line: what the rest
  !! of the program takes from this folder.
  use bw_belief, only: believed_line
  use bw_damped_line, only: damped_line
  use bw_found_lines, only: found_lines, rejected_line
  use bw_kinds, only: dp
  use bw_line_windows, only: window_start
  use bw_missing, only: missing
  use bw_noise_level, only: level_at
  use bw_polar_intervals, only: length_error, phase_error
  use bw_quantile, only: normal_quantile
  use bw_recorded_sensors, only: undetermined
  use bw_remainder, only: find_remainder, tabulated
  use bw_samples, only: centre_of, samples_type, span_of
  use bw_whitening, only: gain_of
  implicit none (type, external)
  private
  public :: fitted_history, lines_in_si, noise_level

  real(dp), parameter :: two_pi = 2*acos(-1.0_dp)
  real(dp), parameter :: same_place = 0.5_dp     !! bins between candidates that are one

  character(*), parameter, public :: status_words(*) = [character(10) :: 'line', 'close_pair', 'harmonic', 'drifting', 'at_edge']
    !! bit by bit, 1, 2, 4, …; `line` is one that is none of the others
  character(*), parameter, public :: reason_words(*) = [character(12) :: 'not_needed', 'too_broad', 'beside_drift', 'uncertain', &
    'noise_colour']
    !! by number, from 1
  character(*), parameter, public :: reason_texts(*) = [character(64) :: &
    'as much is explained without it, but for noise', &
    'too broad to be told from the colour of the noise', &
    'beside a line whose frequency drifts, and explained by that', &
    'its interval reaches to 0, or over a line of more energy', &
    'the colour of the noise explains it as well']

  type, public :: rejected_candidate
    !! A place in the spectrum that was looked at, and is no line.
    real(dp) :: angular_frequency = 0             !! rad/s
    real(dp) :: ordinate = 0                      !! power over that of the noise there, as of a `rejected_line`
    integer :: reason = 0                         !! place among `reason_words`
  end type rejected_candidate

  type, public :: record_lines
    !! Lines by ascending frequency: sensor s moves as Re A_s e^(−δt + iβt). An error is half the width of the interval at the
    !! confidence asked for, a bound the Cramér–Rao standard deviation in the noise found.
    real(dp), allocatable :: angular_frequency(:), angular_frequency_error(:), angular_frequency_bound(:)   !! β, rad/s, (lines)
    real(dp), allocatable :: decay_rate(:), decay_rate_error(:), decay_rate_bound(:)      !! δ, 1/s; negative grows, (lines)
    complex(dp), allocatable :: amplitude(:, :)   !! A at the record's first sample, in the sensor's SI unit, (sensors, lines)
    real(dp), allocatable :: amplitude_error(:, :), amplitude_bound(:, :)                 !! of |A|, (sensors, lines)
    real(dp), allocatable :: amplitude_noise(:, :)
      !! standard deviation of the real part of A, and of its imaginary part, at known β and δ, (sensors, lines)
    complex(dp), allocatable :: noise_correlation(:, :, :)
      !! of these parts at each pair of sensors, (sensors, sensors, lines); allocated where sensors share noise
    logical, allocatable :: own(:)                !! the sensor is neither constant nor a multiple of one before it, (sensors)
    real(dp), allocatable :: phase_error(:, :), phase_bound(:, :)                         !! of arg A, rad, (sensors, lines)
    real(dp), allocatable :: drift(:), drift_bound(:)
      !! change of β from the first sample to the last, or over three decay times where these are shorter, rad/s, (lines)
    real(dp), allocatable :: windows(:, :, :)
      !! β and δ and their bounds in each half and quarter of the record by itself, `missing` where that does not tell,
      !! (4, windows, lines)
    integer, allocatable :: status(:)             !! sum of bits of `status_words`, (lines)
    type(rejected_candidate), allocatable :: rejected(:)
    real(dp), allocatable :: noise_deviation(:)   !! of what the lines leave of each sensor, (sensors)
    real(dp) :: quantile = 1                      !! of the errors: standard deviations of a normal number
    real(dp) :: unsteady = 0                      !! part of a sensor's squares that is neither lines nor steady noise
    integer :: left_out = 0                       !! weaker lines that are not among these
    logical :: at_rest = .true.                   !! .false.: the search was given up
  end type record_lines

contains

  pure function lines_in_si(samples, found, believed, confidence, most) result(lines)
    !! The strongest lines, from periods and e-folds per step to SI.
    type(samples_type), intent(in) :: samples     !! their step counts
    type(found_lines), intent(in) :: found
    type(believed_line), intent(in) :: believed(:)
    real(dp), intent(in) :: confidence            !! of the intervals, 0 … 1
    integer, intent(in) :: most                   !! lines
    type(record_lines) :: lines
    integer, allocatable :: chosen(:)
    real(dp) :: turn, rate
    integer :: i
    chosen = strongest(believed, most)
    lines%quantile = normal_quantile((1 + confidence)/2)
    rate = 1/samples%step
    turn = two_pi/samples%step
    lines%left_out = size(believed) - size(chosen)
    lines%at_rest = found%at_rest
    lines%unsteady = found%unsteady
    lines%angular_frequency = turn*believed(chosen)%frequency
    lines%angular_frequency_error = told(believed(chosen)%frequency_error, turn)
    lines%angular_frequency_bound = told(believed(chosen)%frequency_bound, turn)
    lines%decay_rate = rate*believed(chosen)%decay
    lines%decay_rate_error = told(believed(chosen)%decay_error, rate)
    lines%decay_rate_bound = told(believed(chosen)%decay_bound, rate)
    lines%drift = turn*believed(chosen)%drift
    lines%drift_bound = told(believed(chosen)%drift_bound, turn)
    lines%status = merge(2*believed(chosen)%status, 1, believed(chosen)%status > 0)
    associate (sensors => size(found%deviation), n => size(chosen))
      allocate (lines%amplitude(sensors, n), lines%amplitude_bound(sensors, n), lines%phase_bound(sensors, n), &
                lines%amplitude_noise(sensors, n))
      allocate (lines%windows(4, size(window_start), n))
    end associate
    do i = 1, size(chosen)
      associate (line => believed(chosen(i)))
        lines%amplitude(:, i) = line%amplitude
        lines%amplitude_bound(:, i) = told(line%amplitude_bound, 1.0_dp)
        lines%amplitude_noise(:, i) = line%amplitude_noise
        lines%phase_bound(:, i) = line%phase_bound
        lines%windows(:, :, i) = windows_in_si(line%windows, turn, rate)
      end associate
    end do
    lines%amplitude_error = length_error(abs(lines%amplitude), lines%amplitude_bound, lines%phase_bound*abs(lines%amplitude), &
      & lines%quantile)
    lines%phase_error = phase_error(lines%phase_bound, lines%quantile, confidence)
    if (any([(allocated(believed(i)%noise_correlation), i=1, size(believed))])) &
      & lines%noise_correlation = reshape([(believed(chosen(i))%noise_correlation, i=1, size(chosen))], &
      & [size(found%own), size(found%own), size(chosen)])
    lines%own = found%own
    lines%rejected = candidates_in_si(found%rejected, same_place/span_of(samples), turn)
    lines%noise_deviation = [(deviation_of(samples, found, i), i=1, size(found%deviation))]
  end function lines_in_si

  elemental real(dp) function told(deviation, unit)
    !! A deviation in another unit; `missing` where the record does not tell.
    real(dp), intent(in) :: deviation, unit
    told = missing
    if (deviation < undetermined/100) told = unit*deviation
  end function told

  pure function candidates_in_si(rejected, apart, turn) result(candidates)
    !! Those that stand out most come first; what was rejected twice stands there once, with the last reason.
    type(rejected_line), intent(in) :: rejected(:)
    real(dp), intent(in) :: apart                 !! periods per step, between candidates that are not one
    real(dp), intent(in) :: turn
    type(rejected_candidate), allocatable :: candidates(:)
    logical :: again(size(rejected))
    integer :: i, best
    again = [(any(abs(rejected(i + 1:)%frequency - rejected(i)%frequency) < apart), i=1, size(rejected))]
    allocate (candidates(0))
    do i = 1, count(.not. again)
      best = maxloc(rejected%ordinate, dim=1, mask=.not. again)
      again(best) = .true.
      candidates = [candidates, rejected_candidate(turn*rejected(best)%frequency, rejected(best)%ordinate, rejected(best)%reason)]
    end do
  end function candidates_in_si

  pure function windows_in_si(windows, turn, rate) result(converted)
    !! Frequencies and decays of parts of the record; those whose bound is huge do not exist.
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

  pure function strongest(believed, most) result(chosen)
    !! The places of the lines of largest amplitude, all sensors together, in their order.
    type(believed_line), intent(in) :: believed(:)
    integer, intent(in) :: most
    integer, allocatable :: chosen(:)
    real(dp) :: strength(size(believed))
    integer :: i
    strength = [(norm2(abs(believed(i)%amplitude)), i=1, size(believed))]
    chosen = pack([(i, i=1, size(believed))], [(count(strength > strength(i)) < most, i=1, size(believed))])
  end function strongest

  function fitted_history(samples, found, s) result(history)
    !! What the lines, an offset and a slope make of one sensor, at all samples of the record.
    type(samples_type), intent(in) :: samples     !! of the record as it was; their values do not count
    type(found_lines), intent(in) :: found
    integer, intent(in) :: s
    real(dp), allocatable :: history(:)
    type(samples_type) :: nothing
    type(damped_line), allocatable :: lines(:)
    integer :: k
    nothing%count = samples%count
    nothing%step = samples%step
    if (allocated(samples%place)) nothing%place = samples%place
    allocate (nothing%value(samples%count, 1), source=0.0_dp)
    lines = found%lines
    do k = 1, size(lines)
      lines(k)%amplitude = [lines(k)%amplitude(s)/gain_at(found, found%lines(k), s)]
    end do
    call find_remainder(nothing, tabulated(nothing, lines, reshape(straight_part(samples, found, s), [2, 1])), 1, history)
    history = -history
  end function fitted_history

  pure function straight_part(samples, found, s) result(still)
    !! Offset and slope of a sensor over half the record, about its middle. They were found of samples y' that went through a
    !! filter h: of a + bn it makes (a + bn) Σh − b Σih.
    type(samples_type), intent(in) :: samples     !! of the record as it was
    type(found_lines), intent(in) :: found
    integer, intent(in) :: s
    real(dp) :: still(2), sum_h, sum_ih, slope, offset, centre
    integer :: i
    associate (filter => found%whitening(s))
      sum_h = sum(filter%coefficient(:filter%order))
      sum_ih = dot_product([(real(i, dp), i=0, filter%order)], filter%coefficient(:filter%order))
      centre = max(centre_of(samples) - filter%lost/2.0_dp, 0.5_dp)
      slope = found%still(2, s)/(centre*sum_h)
      offset = (found%still(1, s) - found%still(2, s) + slope*sum_ih)/sum_h - slope*filter%lost
    end associate
    still = [offset + slope*centre_of(samples), slope*centre_of(samples)]
  end function straight_part

  pure function noise_level(samples, found, frequency, s) result(level)
    !! The standard deviation that white noise would have which is as strong as a sensor's noise at a frequency.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    real(dp), intent(in) :: frequency             !! Hz
    integer, intent(in) :: s
    real(dp) :: level, levels(size(found%whitening))
    type(damped_line) :: steady
    steady%frequency = frequency*samples%step
    levels = level_at(found%ordinates%noise, steady%frequency, size(levels))
    levels = levels*found%ordinates%shape/size(levels)   ! noise that sensors share has raised it
    level = sqrt(levels(s))/abs(gain_at(found, steady, s))
  end function noise_level

  pure real(dp) function deviation_of(samples, found, s) result(deviation)
    !! The standard deviation of a sensor's noise: of what the lines leave, or of the level of its colour where the samples
    !! went through a filter.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    integer, intent(in) :: s
    integer, parameter :: places = 2048
    integer :: j
    deviation = found%ordinates%deviation(s)
    if (found%whitening(s)%order == 0) return
    deviation = norm2([(noise_level(samples, found, (j - 0.5_dp)/(2*places*samples%step), s), j=1, places)])/sqrt(real(places, dp))
  end function deviation_of

  pure complex(dp) function gain_at(found, line, s) result(gain)
    !! The factor of a line's amplitude at one sensor by the filter that its samples went through.
    type(found_lines), intent(in) :: found
    type(damped_line), intent(in) :: line
    integer, intent(in) :: s
    complex(dp) :: gains(1)
    gains = gain_of(found%whitening(s:s), line)
    gain = gains(1)
  end function gain_at

end module bw_record_lines
