module bw_short_lines
  !! Lines that are gone long before the record ends, or begin long after it starts: in a transform of all of it noise hides them.
  !!
  !! A bank of decays d = 8/N, 16/N, … Samples that are multiplied by e^(−dτ) have an ordinate at a line's frequency that noise has
  !! with probability e^(−x) as well, over a level that is the noise's, seen through the line's own width: its covariance times
  !! e^(−d·lag). The noise is judged where such lines are gone, in the last part of the record; for lines that grow, in the first.
  use bw_damped_line, only: damped_line
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_noise_level, only: find_level, level_at, level_knots
  use bw_order, only: local_maxima, vertex
  use bw_ordinates, only: find_power, least_ordinate, padded_length, remainder
  use bw_samples, only: place_of, samples_type, span_of
  implicit none (type, external)
  private
  public :: cap_noise, short_lines

  real(dp), parameter :: first_decay = 8       !! over the record; others are seen well enough in all of it
  real(dp), parameter :: fastest = 0.2_dp      !! decay per step
  real(dp), parameter :: lives = 5             !! decay times that are looked at
  real(dp), parameter :: alike = sqrt(3.0_dp)/2  !! bins, at decay 1, of the record whose times scatter as those of such a line
  real(dp), parameter :: freedom = 48          !! ordinates that tell the noise's level
  integer, parameter :: fewest = 64            !! samples
  integer, parameter :: long_enough = 256      !! samples that tell of the noise
  integer, parameter :: most_ordinates = 4096  !! at which its level is known
  real(dp), parameter :: most_loud = 2         !! times the noise's variance where short lines are gone, that it has in all of the
                                               !! record; scatter alone makes no more
  real(dp), parameter :: least_level = tiny(1.0_dp)*1.0e50_dp
  real(dp), parameter :: pi = acos(-1.0_dp)

contains

  function short_lines(samples, lines, still, shape, false_alarm) result(best)
    !! The line that stands out most, without an amplitude, or none.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    real(dp), intent(in) :: shape              !! sensors of independent noise
    real(dp), intent(in) :: false_alarm
    type(damped_line), allocatable :: best(:)
    type(samples_type) :: left
    type(real_fourier) :: plan
    real(dp), allocatable :: levels(:, :)
    real(dp) :: decay, highest, frequency, ordinate
    integer :: way
    allocate (best(0))
    if (samples%count < fewest) return
    highest = least_ordinate(shape, 4*alike*span_of(samples)/first_decay, false_alarm/2)
    highest = freedom*(exp(highest/freedom) - 1)
    do way = 1, -1, -2
      left = what_is_left(samples, lines, still, way)
      call find_quiet_levels(left, plan, levels)
      decay = first_decay/span_of(samples)
      do while (decay < fastest)
        call look(left, levels, decay, plan, frequency, ordinate)
        if (ordinate*shape/size(levels, 2) > highest) then
          highest = ordinate*shape/size(levels, 2)
          best = [line_at(frequency, way*decay, size(levels, 2))]
        end if
        decay = 2*decay
      end do
    end do
  end function short_lines

  subroutine cap_noise(samples, lines, still, noise, capped)
    !! Lower the noise's level to what it can be where short lines are gone: what these leave is in the level of the whole record.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    type(level_knots), intent(inout) :: noise
    logical, intent(out) :: capped             !! at a short line
    type(real_fourier) :: plan
    type(level_knots) :: quiet
    real(dp), dimension(size(still, 2)) :: level, before
    real(dp), allocatable :: short(:)          !! frequencies
    integer :: way, k, last
    capped = .false.
    if (samples%count < fewest) return
    last = ubound(noise%level, 1)
    do way = 1, -1, -2
      short = pack(lines%frequency, way*lines%decay*span_of(samples) > first_decay)
      if (size(short) == 0) cycle
      call find_quiet_levels(what_is_left(samples, lines, still, way), plan, quiet%level)
      do k = 1, size(short)
        before = level_at(noise, short(k), size(level))
        level = level_at(quiet, short(k), size(level))
        capped = capped .or. any(before > most_loud*level)
      end do
      do k = 0, last
        noise%level(k, :) = min(noise%level(k, :), most_loud*level_at(quiet, 0.5_dp*k/last, size(level)))
      end do
    end do
  end subroutine cap_noise

  pure type(damped_line) function line_at(frequency, decay, sensors) result(line)
    !! A line whose amplitudes are not known yet.
    real(dp), intent(in) :: frequency, decay
    integer, intent(in) :: sensors
    line%frequency = frequency
    line%decay = decay
    allocate (line%amplitude(sensors))
    line%amplitude = 0
  end function line_at

  subroutine look(left, levels, decay, plan, frequency, ordinate)
    !! Find the highest ordinate of the samples seen through a decay, all sensors together, and where it is. It is 0 if there is none.
    type(samples_type), intent(in) :: left
    real(dp), intent(in) :: levels(0:, :)
    real(dp), intent(in) :: decay              !! per step
    type(real_fourier), intent(inout) :: plan
    real(dp), intent(out) :: frequency, ordinate
    type(samples_type) :: part
    real(dp), allocatable :: power(:), total(:), weight(:)
    real(dp) :: seen(size(levels, 1))
    integer, allocatable :: peak(:)
    real(dp) :: place
    integer :: s, m, n, k, best
    n = count([(place_of(left, m) < lives/decay, m=1, left%count)])
    part%count = n
    if (allocated(left%place)) part%place = left%place(:n)
    allocate (total(0:padded_length(part)/2), source=0.0_dp)
    weight = exp(-decay*[(place_of(left, m), m=1, n)])
    do s = 1, size(left%value, 2)
      call find_power(part, weight*left%value(:n, s), plan, power)
      power = power*(n/sum(weight**2))
      seen = seen_through(levels(:, s), decay, plan)
      do m = 0, size(total) - 1
        place = m*real(size(seen) - 1, dp)/(size(total) - 1)
        k = min(int(place), size(seen) - 2)
        total(m) = total(m) + power(m + 1)/(seen(k + 1)*(k + 1 - place) + seen(k + 2)*(place - k))
      end do
    end do
    peak = local_maxima(total, 0.0_dp)
    peak = pack(peak, pi*peak > decay*(size(total) - 1) .and. pi*(size(total) - 1 - peak) > decay*(size(total) - 1))
    frequency = 0
    ordinate = 0
    if (size(peak) == 0) return
    best = peak(maxloc(total(peak), dim=1))
    frequency = (best + vertex(total(best - 1:best + 1)))/(2*(size(total) - 1))
    ordinate = total(best)
  end subroutine look

  function seen_through(level, decay, plan) result(seen)
    !! The level of noise that is multiplied by a decay.
    real(dp), intent(in) :: level(0:)
    real(dp), intent(in) :: decay
    type(real_fourier), intent(inout) :: plan
    real(dp) :: seen(0:size(level) - 1)
    integer :: last, k
    last = size(level) - 1
    call plan%prepare(2*last)
    plan%samples = [level, level(last - 1:1:-1)]
    call plan%transform()
    seen = plan%spectrum%re/(2*last)*exp(-decay*[(k, k=0, last)])
    plan%samples = [seen, seen(last - 1:1:-1)]
    call plan%transform()
    seen = max(plan%spectrum%re, minval(level))
  end function seen_through

  function what_is_left(samples, lines, still, way) result(left)
    !! What lines leave of the samples, from the first to the last or the other way.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    integer, intent(in) :: way
    type(samples_type) :: left
    integer :: s, n
    n = samples%count
    left%count = n
    if (allocated(samples%place)) then
      left%place = samples%place(:n)
      if (way < 0) left%place = samples%place(n) - samples%place(n:1:-1)
    end if
    allocate (left%value(n, size(samples%value, 2)))
    do s = 1, size(left%value, 2)
      left%value(:, s) = remainder(samples, lines, still, s)
      if (way < 0) left%value(:, s) = left%value(n:1:-1, s)
    end do
  end function what_is_left

  subroutine find_quiet_levels(left, plan, levels)
    !! The noise's variance at even frequencies from 0 to half the sampling rate, from the last half of the samples, or of few
    !! samples more, (0:K, S).
    type(samples_type), intent(in) :: left
    type(real_fourier), intent(inout) :: plan
    real(dp), allocatable, intent(out) :: levels(:, :)
    type(samples_type) :: part
    real(dp), allocatable :: power(:), level(:)
    integer, allocatable :: at(:)
    integer :: first, s, k, last
    first = 1 + max(left%count/4, min(left%count/2, left%count - long_enough))
    part%count = left%count - first + 1
    if (allocated(left%place)) part%place = left%place(first:) - left%place(first)
    part%value = left%value(first:, :)
    last = min(padded_length(part)/2, most_ordinates)
    allocate (levels(0:last, size(part%value, 2)), level(0:last))
    at = [(1 + nint(k*(real(padded_length(part)/2, dp)/last)), k=0, last)]
    do s = 1, size(part%value, 2)
      call find_power(part, part%value(:, s), plan, power)
      call find_level(power(at), min(max(1, nint(span_of(part)/2)), last/2), .true., [real(dp) ::], least_level, level)
      levels(:, s) = level
    end do
  end subroutine find_quiet_levels

end module bw_short_lines
