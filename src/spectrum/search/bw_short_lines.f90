module bw_short_lines
  !! Lines that are gone long before the record ends, or begin long after it starts: in a transform of all of it noise hides them.
  !!
  !! A bank of decays d = 8/N, 16/N, … Samples that are multiplied by e^(−dτ) have an ordinate at a line's frequency that noise has
  !! with probability e^(−x) as well, over a level that is the noise's, seen through the line's own width: its covariance times
  !! e^(−d·lag). The noise is judged where such lines are gone, in the last part of the record; for lines that grow, in the first.
  !!
  !! The level of a window of ν ordinates scatters as a sum of 2ν squares does. Of one sensor the ordinate over it passes
  !! ν(e^(x/ν) − 1) with the probability e^(−x) (Fisher's distribution). Of S sensors, whose levels scatter by themselves, large sums
  !! scatter as over one level of ν(S + 1)/2 ordinates: drawn with ν from 24 to 48, S to 64 and probabilities to 1e-5, what passes is
  !! 0.98 to 1.27 times as likely as it should be.
  use bw_damped_line, only: damped_line
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_noise_level, only: find_level, level_at, level_knots, window_width
  use bw_order, only: local_maxima, vertex
  use bw_ordinates, only: add_ratio, least_ordinate, padded_length, square, transform
  use bw_remainder, only: find_remainder, motion_type, tabulated
  use bw_samples, only: place_of, samples_type, span_of
  implicit none (type, external)
  private
  public :: cap_noise, short_lines

  real(dp), parameter :: first_decay = 8       !! over the record; others are seen well enough in all of it
  real(dp), parameter :: fastest = 0.2_dp      !! decay per step
  real(dp), parameter :: lives = 4             !! decay times that are looked at
  real(dp), parameter :: alike = sqrt(3.0_dp)/2  !! bins, at decay 1, of the record whose times scatter as those of such a line
  integer, parameter :: fewest = 64            !! samples
  integer, parameter :: long_enough = 256      !! samples that tell of the noise
  integer, parameter :: most_ordinates = 4096  !! at which its level is known
  real(dp), parameter :: most_loud = 2         !! times the noise's variance where short lines are gone, that it has in all of the
                                               !! record; scatter alone makes no more
  real(dp), parameter :: least_level = tiny(1.0_dp)*1.0e50_dp
  real(dp), parameter :: pi = acos(-1.0_dp)

  type :: view_type
    !! The samples seen through one decay, from the first on or from the last back, and all sensors together so far.
    real(dp) :: decay = 0                      !! per step
    type(samples_type) :: part                 !! their times, without values
    real(dp), allocatable :: weight(:)         !! e^(−dτ), (samples of the part)
    real(dp), allocatable :: total(:)          !! ordinates over the level of their noise, (0:K)
    type(real_fourier) :: plan
  end type view_type

contains

  function short_lines(samples, lines, still, shape, false_alarm) result(best)
    !! The line that stands out most, without an amplitude, or none.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    real(dp), intent(in) :: shape              !! sensors of independent noise
    real(dp), intent(in) :: false_alarm
    type(damped_line), allocatable :: best(:)
    type(view_type), allocatable :: views(:)
    real(dp) :: highest, freedom, frequency, ordinate
    integer :: way, i, sensors
    allocate (best(0))
    if (samples%count < fewest) return
    sensors = size(samples%value, 2)
    highest = least_ordinate(shape, 4*alike*span_of(samples)/first_decay, false_alarm/2)
    freedom = window_width(real(quiet_bins(samples), dp))*(shape + 1)/2
    highest = freedom*(exp(highest/freedom) - 1)
    do way = 1, -1, -2
      call look(samples, tabulated(samples, lines, still), way, views)
      do i = 1, size(views)
        call find_highest(views(i), frequency, ordinate)
        if (ordinate*shape/sensors <= highest) cycle
        highest = ordinate*shape/sensors
        best = [line_at(frequency, way*views(i)%decay, sensors)]
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
      call find_quiet_levels(samples, tabulated(samples, lines, still), way, quiet%level)
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

  subroutine look(samples, motion, way, views)
    !! See what is left of all sensors through all decays, from the first sample to the last or the other way.
    type(samples_type), intent(in) :: samples
    type(motion_type), intent(in) :: motion
    integer, intent(in) :: way                 !! 1 or −1
    type(view_type), allocatable, intent(out) :: views(:)
    type(samples_type) :: times
    type(real_fourier) :: plan, quiet          ! of two lengths
    real(dp), allocatable :: left(:), level(:)
    integer :: s, i
    times = times_of(samples, way)
    call prepare(times, views)
    do s = 1, size(samples%value, 2)
      call find_left(samples, motion, way, s, left)
      call find_quiet_level(times, left, quiet, level)
      do i = 1, size(views)
        call add_sensor(left, level, plan, views(i))
      end do
    end do
  end subroutine look

  subroutine prepare(times, views)
    !! Make room for all decays.
    type(samples_type), intent(in) :: times
    type(view_type), allocatable, intent(out) :: views(:)
    integer :: i, m
    allocate (views(max(0, ceiling(log(fastest*span_of(times)/first_decay)/log(2.0_dp)))))
    do i = 1, size(views)
      associate (view => views(i), part => views(i)%part)
        view%decay = first_decay/span_of(times)*2.0_dp**(i - 1)
        part%count = min(times%count, ceiling(lives/view%decay))
        if (allocated(times%place)) part%count = count(times%place < lives/view%decay)
        if (allocated(times%place)) part%place = times%place(:part%count)
        view%weight = exp(-view%decay*[(place_of(times, m), m=1, part%count)])
        allocate (view%total(0:padded_length(part)/2), source=0.0_dp)
      end associate
    end do
  end subroutine prepare

  subroutine add_sensor(left, level, plan, view)
    !! Add one sensor's ordinates over the level of its noise.
    real(dp), intent(in) :: left(:)
    real(dp), intent(in) :: level(0:)
    type(real_fourier), intent(inout) :: plan
    type(view_type), intent(inout) :: view
    call transform(view%part, left(:view%part%count), view%plan, view%weight)
    call add_ratio(view%plan%spectrum(0:ubound(view%total, 1)), sum(view%weight**2)*seen_through(level, view%decay, plan), &
      & view%total)
  end subroutine add_sensor

  pure subroutine find_highest(view, frequency, ordinate)
    !! Find the highest ordinate of the samples seen through a decay, all sensors together, and where it is. It is 0 if there is none.
    type(view_type), intent(in) :: view
    real(dp), intent(out) :: frequency, ordinate
    integer, allocatable :: peak(:)
    integer :: best, half
    half = ubound(view%total, 1)
    peak = local_maxima(view%total, 0.0_dp)
    peak = pack(peak, pi*peak > view%decay*half .and. pi*(half - peak) > view%decay*half)
    frequency = 0
    ordinate = 0
    if (size(peak) == 0) return
    best = peak(maxloc(view%total(peak), dim=1))
    frequency = (best + vertex(view%total(best - 1:best + 1)))/(2*half)
    ordinate = view%total(best)
  end subroutine find_highest

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

  pure type(samples_type) function times_of(samples, way) result(times)
    !! Times without values, from the first sample to the last or the other way.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: way
    times%count = samples%count
    if (.not. allocated(samples%place)) return
    times%place = samples%place(:times%count)
    if (way < 0) times%place = times%place(times%count) - times%place(times%count:1:-1)
  end function times_of

  subroutine find_left(samples, motion, way, s, left)
    !! What lines leave of a sensor's samples, from the first to the last or the other way.
    type(samples_type), intent(in) :: samples
    type(motion_type), intent(in) :: motion
    integer, intent(in) :: way, s
    real(dp), allocatable, intent(inout) :: left(:)
    call find_remainder(samples, motion, s, left)
    if (way < 0) left = left(size(left):1:-1)
  end subroutine find_left

  subroutine find_quiet_levels(samples, motion, way, levels)
    !! The noise's variance of all sensors where short lines are gone, at even frequencies from 0 to half the sampling rate, (0:K, S).
    type(samples_type), intent(in) :: samples
    type(motion_type), intent(in) :: motion
    integer, intent(in) :: way
    real(dp), allocatable, intent(out) :: levels(:, :)
    type(samples_type) :: times
    type(real_fourier) :: plan
    real(dp), allocatable :: left(:), level(:)
    integer :: s
    times = times_of(samples, way)
    do s = 1, size(samples%value, 2)
      call find_left(samples, motion, way, s, left)
      call find_quiet_level(times, left, plan, level)
      if (.not. allocated(levels)) allocate (levels(0:ubound(level, 1), size(samples%value, 2)))
      levels(:, s) = level
    end do
  end subroutine find_quiet_levels

  subroutine find_quiet_level(times, left, plan, level)
    !! The noise's variance of one sensor at even frequencies from 0 to half the sampling rate, (0:K). Of a long record that is even
    !! a short transform gives these ordinates: the samples before it are added up whenever its length has passed.
    type(samples_type), intent(in) :: times
    real(dp), intent(in) :: left(:)
    type(real_fourier), intent(inout) :: plan
    real(dp), allocatable, intent(inout) :: level(:)
    type(samples_type) :: part
    integer :: k, n, half, last
    part = quiet_part(times)
    half = padded_length(part)/2
    last = min(half, most_ordinates)
    associate (quiet => left(times%count - part%count + 1:))
      if (half > last .and. .not. allocated(times%place)) then
        half = last
        call plan%prepare(2*half)
        plan%samples = 0
        do n = 0, part%count - 1, 2*half
          associate (sums => plan%samples(:min(2*half, part%count - n)))
            sums = sums + quiet(n + 1:n + size(sums))
          end associate
        end do
        call plan%transform()
      else
        call transform(part, quiet, plan)
      end if
    end associate
    if (.not. allocated(level)) allocate (level(0:last))
    call find_level([(square(plan%spectrum(nint(k*(real(half, dp)/last))))/part%count, k=0, last)], quiet_bins(times), .true., &
      & [real(dp) ::], 0.0_dp, least_level, level)
  end subroutine find_quiet_level

  pure type(samples_type) function quiet_part(times) result(part)
    !! The samples without values that tell the noise's level, from the last half of the record, or of few samples more.
    type(samples_type), intent(in) :: times
    integer :: first
    first = 1 + max(times%count/4, min(times%count/2, times%count - long_enough))
    part%count = times%count - first + 1
    if (allocated(times%place)) part%place = times%place(first:times%count) - times%place(first)
  end function quiet_part

  pure integer function quiet_bins(times) result(bins)
    !! Independent ordinates that the noise's level is found from.
    type(samples_type), intent(in) :: times
    type(samples_type) :: part
    part = quiet_part(times)
    bins = min(max(1, nint(span_of(part)/2)), padded_length(part)/4, most_ordinates/2)
  end function quiet_bins

end module bw_short_lines
