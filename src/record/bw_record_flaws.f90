module bw_record_flaws
  !! Flawed samples of a sensor, which do not follow the motion: it was stuck at a value, or clipped, or a sample is a spike.
  !!
  !! Equal consecutive samples are no flaw by themselves: resolution is finite, noise is small, motions have crests. Let q be
  !! the smallest step between neighbours. A run of L equal samples is a flaw if neither of the following explains it:
  !!
  !! - **Noise.** Let p be the fraction of equal neighbours before or after the run, over three times its length, whichever is
  !! larger (a decaying motion ends on few digits). Then n samples contain n p^(L−1) such runs by chance. This number must be
  !! below `chance`.
  !! - **Smooth motion.** If the motion is flat over the run, like a crest (second order) or a terrace (third order), it stays
  !! within q for half the run, and so departs by at most 3³ q = 27 q within a further run length on either side.
  !! The record must depart by more than `reach` q there.
  !!
  !! A sensor clips at its largest or smallest value if more samples have this value than lie within `reach` steps of it, since
  !! a crest passes slowly there; or if a run of L ≥ 3 has steep sides: a crest that is flat over it falls by at most
  !! ((L+2)/L)² q < 3 q to the adjacent samples.
  !!
  !! A spike is one sample or two, farther from all others than ten times their range. A blow is none: the motion after it is large.
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: find_flaws, find_spikes, mark_flaws

  real(dp), parameter :: chance = 1.0e-6_dp      !! expected number of runs by noise, per sensor
  real(dp), parameter :: reach = 30.0_dp         !! steps
  real(dp), parameter :: crest_fall = 4.0_dp     !! steps
  integer, parameter :: least_run = 3            !! samples
  integer, parameter :: around = 3               !! run lengths
  real(dp), parameter :: far_off = 10            !! ranges of the other samples, from a spike to them
  integer, parameter :: longest_spike = 2        !! samples
  integer, parameter :: ends = 8                 !! samples at either end of a record, in which spikes are not sought

  type, public :: flaws_type
    !! The flaws of one sensor. Places are numbers of samples, from 1.
    logical :: is_constant = .false.             !! all samples are equal
    integer(i8) :: stuck_runs = 0                !! number of runs in which it was stuck
    integer(i8) :: stuck_first = 0, stuck_last = 0   !! the longest of them
    integer(i8) :: clipped_high = 0              !! samples at the largest value if clipped, else 0
    integer(i8) :: clipped_low = 0               !! at the smallest value
    real(dp) :: highest = 0.0_dp, lowest = 0.0_dp   !! but for spikes
    integer(i8) :: spikes = 0                    !! samples
    integer(i8) :: spike = 0                     !! place of the largest
  end type flaws_type

contains

  pure type(flaws_type) function find_flaws(values) result(flaws)
    !! Find the flaws of one sensor, whose samples are in the order of time.
    real(dp), intent(in) :: values(:)
    logical :: sound(size(values))
    call look(values, sound, flaws)
  end function find_flaws

  pure subroutine mark_flaws(values, sound)
    !! Mark flawed samples of one sensor: those where it was stuck or clipped.
    real(dp), intent(in) :: values(:)
    logical, intent(inout) :: sound(:)             !! false for these samples; others are unchanged
    type(flaws_type) :: flaws
    call look(values, sound, flaws)
  end subroutine mark_flaws

  pure subroutine look(values, sound, flaws)
    !! Find the flaws of one sensor, and mark the samples.
    real(dp), intent(in) :: values(:)
    logical, intent(inout) :: sound(:)
    type(flaws_type), intent(out) :: flaws
    real(dp), allocatable :: smooth(:)
    logical, allocatable :: is_spike(:)
    integer(i8) :: i
    call find_spikes(values, is_spike)
    if (.not. allocated(is_spike)) then
      call look_beside_spikes(values, sound, flaws)
      return
    end if
    smooth = values
    do i = 2, size(values, kind=i8)
      if (is_spike(i)) smooth(i) = smooth(i - 1)
    end do
    call look_beside_spikes(smooth, sound, flaws)
    where (is_spike) sound = .false.
    flaws%spikes = count(is_spike, kind=i8)
    flaws%spike = maxloc(abs(values), dim=1, mask=is_spike, kind=i8)
  end subroutine look

  pure subroutine find_spikes(values, is_spike)
    !! Find the spikes of one sensor, the largest ones first, as these hide smaller ones.
    real(dp), intent(in) :: values(:)
    logical, allocatable, intent(out) :: is_spike(:)   !! not allocated: there are none
    logical, dimension(size(values)) :: far, sound !! from the first sample, which is no spike; no spikes
    real(dp) :: low, high, distance
    integer :: n, run, i
    n = size(values)
    sound = .true.
    low = minval(values)
    high = maxval(values)
    distance = high/far_off - low/far_off
    do
      far = sound .and. abs(values/2 - values(1)/2) > distance/2
      if (.not. any(far) .or. any(far(:min(n, ends))) .or. any(far(max(1, n - ends + 1):))) exit
      run = 0
      do i = 1, n
        run = merge(run + 1, 0, far(i))
        if (run > longest_spike) exit
      end do
      if (run > longest_spike) exit
      low = minval(values, mask=sound .and. .not. far)
      high = maxval(values, mask=sound .and. .not. far)
      if (.not. high > low) exit
      distance = distance/far_off
      if (any(far .and. max(values/far_off - high/far_off, low/far_off - values/far_off) <= high - low)) cycle
      sound = sound .and. .not. far
      distance = high/far_off - low/far_off
    end do
    if (.not. all(sound)) is_spike = .not. sound
  end subroutine find_spikes

  pure subroutine look_beside_spikes(values, sound, flaws)
    !! Find the other flaws of one sensor, and mark the samples.
    real(dp), intent(in) :: values(:)
    logical, intent(inout) :: sound(:)
    type(flaws_type), intent(inout) :: flaws
    real(dp) :: step
    integer(i8) :: n, first, last
    logical :: clips(2), at_end(2)                ! high, low
    n = size(values, kind=i8)
    flaws%highest = maxval(values)
    flaws%lowest = minval(values)
    flaws%is_constant = flaws%highest == flaws%lowest
    if (flaws%is_constant) return
    step = smallest_step(values)
    clips = [piles_up(flaws%highest - values, step), piles_up(values - flaws%lowest, step)]
    last = 0
    do while (last < n)
      first = last + 1
      last = end_of_run(values, first)
      if (last - first + 1 < least_run) cycle
      at_end = [values(first) == flaws%highest, values(first) == flaws%lowest]
      if (any(at_end) .and. has_steep_sides(values, first, last, step)) clips = clips .or. at_end
      if (any(at_end .and. clips)) cycle
      if (.not. is_stuck(values, first, last, step)) cycle
      sound(first:last) = .false.
      flaws%stuck_runs = flaws%stuck_runs + 1
      if (last - first <= flaws%stuck_last - flaws%stuck_first .and. flaws%stuck_runs > 1) cycle
      flaws%stuck_first = first
      flaws%stuck_last = last
    end do
    if (clips(1)) flaws%clipped_high = count(values == flaws%highest, kind=i8)
    if (clips(2)) flaws%clipped_low = count(values == flaws%lowest, kind=i8)
    where ((clips(1) .and. values == flaws%highest) .or. (clips(2) .and. values == flaws%lowest)) sound = .false.
  end subroutine look_beside_spikes

  pure logical function piles_up(below, step)
    !! Return whether more samples are at an end of the range than just inside it.
    real(dp), intent(in) :: below(:)              !! distance from the end
    real(dp), intent(in) :: step
    integer(i8) :: at_it
    at_it = count(below <= 0.0_dp, kind=i8)
    piles_up = at_it >= least_run .and. at_it > count(below > 0.0_dp .and. below < reach*step, kind=i8)
  end function piles_up

  pure logical function has_steep_sides(values, first, last, step)
    !! Return whether the samples adjacent to a run are far from it.
    real(dp), intent(in) :: values(:)
    integer(i8), intent(in) :: first, last
    real(dp), intent(in) :: step
    associate (beside => [max(1_i8, first - 1), min(size(values, kind=i8), last + 1)])
      has_steep_sides = all(abs(values(beside) - values(first)) > crest_fall*step .or. beside == [first, last])
    end associate
  end function has_steep_sides

  pure real(dp) function smallest_step(values) result(step)
    !! Return the smallest step between neighbours that differ; the largest number if none do.
    real(dp), intent(in) :: values(:)
    real(dp) :: change
    integer(i8) :: j
    step = huge(step)
    do j = 2, size(values, kind=i8)
      change = abs(values(j) - values(j - 1))
      if (change > 0.0_dp) step = min(step, change)
    end do
  end function smallest_step

  pure integer(i8) function end_of_run(values, first) result(last)
    !! Return the last sample of the run of equal samples that begins at `first`.
    real(dp), intent(in) :: values(:)
    integer(i8), intent(in) :: first
    last = first
    do while (last < size(values, kind=i8))
      if (values(last + 1) /= values(first)) return
      last = last + 1
    end do
  end function end_of_run

  pure logical function is_stuck(values, first, last, step)
    !! Return whether neither noise nor a smooth motion explains a run.
    real(dp), intent(in) :: values(:)
    integer(i8), intent(in) :: first, last
    real(dp), intent(in) :: step
    real(dp) :: share
    integer(i8) :: n, length
    n = size(values, kind=i8)
    length = last - first + 1
    share = max(equal_share(values(max(1_i8, first - around*length):first - 1)), &
                equal_share(values(last + 1:min(n, last + around*length))))
    is_stuck = log(real(n, dp)) + (length - 1)*log(share) <= log(chance)
    if (is_stuck) is_stuck = goes_beyond(values, first, last, length, reach*step)
  end function is_stuck

  pure real(dp) function equal_share(values) result(share)
    !! Estimate the fraction of equal neighbours from a few samples, by the rule of succession: above 0 and below 1.
    real(dp), intent(in) :: values(:)
    integer(i8) :: n
    n = max(1_i8, size(values, kind=i8)) - 1
    share = 0.0_dp
    if (n > 0) share = real(count(values(2:) == values(:n), kind=i8), dp)
    share = (share + 1)/(n + 2)
  end function equal_share

  pure logical function goes_beyond(values, first, last, length, distance)
    !! Return whether the record departs from the value of a run by more than a distance, within `length` samples beside it.
    real(dp), intent(in) :: values(:)
    integer(i8), intent(in) :: first, last, length
    real(dp), intent(in) :: distance
    integer(i8) :: a, b
    a = max(1_i8, first - length)
    b = min(size(values, kind=i8), last + length)
    goes_beyond = any(abs(values(a:first - 1) - values(first)) > distance)
    if (.not. goes_beyond) goes_beyond = any(abs(values(last + 1:b) - values(first)) > distance)
  end function goes_beyond

end module bw_record_flaws
