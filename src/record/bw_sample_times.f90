module bw_sample_times
  !! Times of samples: they rise, a part of them is used, and even ones are known as such although their digits were cut.
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: even_interval, first_fall, nearest_even, used_part

  real(dp), parameter :: slack = 4.0_dp      !! roundings of a time that somebody computed
  integer, parameter :: most_steps = 100     !! in which an end of what fits is found
  integer, parameter :: window = 32          !! neighbours by whose intervals the grain of a clock is told

contains

  pure integer(i8) function first_fall(times) result(row)
    !! The first time that is not later than the one before; 0 where all rise.
    real(dp), intent(in) :: times(:)
    do row = 2, size(times, kind=i8)
      if (.not. times(row) > times(row - 1)) return
    end do
    row = 0
  end function first_fall

  pure subroutine used_part(times, start, end, first, last)
    !! First and last of the times from start to end, both included but for rounding; last < first where there are none.
    real(dp), intent(in) :: times(:)         !! [s], rising
    real(dp), intent(in) :: start, end       !! [s]
    integer(i8), intent(out) :: first, last
    do first = 1, size(times, kind=i8)
      if (times(first) >= start - slack*spacing(times(first))) exit
    end do
    do last = size(times, kind=i8), 1, -1
      if (times(last) <= end + slack*spacing(times(last))) exit
    end do
  end subroutine used_part

  pure real(dp) function even_interval(times, steps) result(interval)
    !! The interval of times that are even but for the digits that were cut; 0 where they are not even.
    !!
    !! Times t_j of n samples, each known to half of its last digit, or of the grain of its clock where that is coarser, h_j, are
    !! even with the interval d where one number a has |t_j − a − j d| ≤ h_j for all j. Of all that fit, the roundest is taken: the
    !! sampling rate, or the interval, with as few digits as fit; so that 1/3 ms printed with three digits is 3000 Hz.
    real(dp), intent(in) :: times(:)         !! [s], rising
    real(dp), intent(in) :: steps(:)         !! what the last digit of each stands for [s]; 0: all digits are there
    interval = 0.0_dp
    if (size(times) < 2) return
    interval = roundest(times, steps)
    if (interval > 0.0_dp) return
    interval = roundest(times, max(steps, grains(times, steps, fitted_interval(times))))
  end function even_interval

  pure real(dp) function roundest(times, steps) result(interval)
    !! The roundest interval that fits, as a rate or as it is; 0 where none does.
    real(dp), intent(in) :: times(:), steps(:)
    real(dp) :: low, high
    integer :: digits, few
    integer, parameter :: most_digits = 15
    interval = 0.0_dp
    few = min(size(times), 64)               ! a look at a few times, since most uneven ones are far from even
    call find_range(times(:few), steps(:few), low, high)
    if (low <= high) call find_range(times, steps, low, high)
    if (low > high .or. .not. high > sqrt(tiny(high))) return
    do digits = 1, most_digits
      interval = 1.0_dp/rounded_to(2.0_dp/(low + high), digits)
      if (low <= interval .and. interval <= high) return
      interval = rounded_to(0.5_dp*(low + high), digits)
      if (low <= interval .and. interval <= high) return
    end do
    interval = 0.5_dp*(low + high)
  end function roundest

  pure subroutine nearest_even(times, interval, off)
    !! Even times near to uneven ones, and how far off them these are at most. The interval is the roundest that has them no
    !! more than twice as far off as that of least squares.
    real(dp), intent(in) :: times(:)         !! [s], rising
    real(dp), intent(out) :: interval, off   !! [s]
    real(dp) :: low, high
    interval = fitted_interval(times)
    call measure_rest(times, interval, low, high)
    off = 0.5_dp*(high - low)
    low = roundest(times, spread(4*off, 1, size(times)))
    if (low > 0.0_dp) interval = low
    call measure_rest(times, interval, low, high)
    off = 0.5_dp*(high - low)
  end subroutine nearest_even

  pure subroutine measure_rest(times, interval, low, high)
    !! The least and the largest of t_j − t_1 − (j − 1) d.
    real(dp), intent(in) :: times(:), interval
    real(dp), intent(out) :: low, high
    real(dp) :: rest
    integer(i8) :: j
    low = 0.0_dp
    high = 0.0_dp
    do j = 2, size(times, kind=i8)
      rest = (times(j) - times(1)) - (j - 1)*interval
      low = min(low, rest)
      high = max(high, rest)
    end do
  end subroutine measure_rest

  pure function grains(times, steps, interval) result(grain)
    !! The grain of the clock at each time: the largest step of which all intervals of some neighbours, before or behind, are
    !! multiples; 0 where there is none, or where it is more than half of the interval, and could be the interval itself.
    !!
    !! Zeros that only fill a stamp up say nothing of its clock, nor do the digits of a difference: t − t₁ has as many as t₁,
    !! and t may have had fewer. Neighbours are looked at, since stamps of so many digits become coarser with time.
    real(dp), intent(in) :: times(:), steps(:)
    real(dp), intent(in) :: interval         !! between neighbours, about
    real(dp) :: grain(size(times))
    integer(i8), allocatable :: ahead(:), back(:)      ! divisors of the intervals from one to the end of its block, and from the
    integer(i8) :: largest                             ! begin of its block to one; any window is the end of one and the begin of
    real(dp) :: unit
    integer :: j, m
    grain = 0.0_dp
    unit = unit_of(times, steps)
    if (.not. interval > 2*unit .or. unit == 0.0_dp) return
    m = size(times) - 1                      ! another block
    ahead = nint((times(2:) - times(:m))/unit, i8)
    back = ahead
    do j = m - 1, 1, -1
      if (mod(j, window) /= 0) ahead(j) = common_divisor(ahead(j), ahead(j + 1))
    end do
    do j = 2, m
      if (mod(j - 1, window) /= 0) back(j) = common_divisor(back(j), back(j - 1))
    end do
    do j = 1, size(times)
      largest = common_divisor(ahead(max(1, j - window)), back(max(min(window, m), j - 1)))
      if (j + window - 1 <= m) largest = max(largest, common_divisor(ahead(j), back(j + window - 1)))
      if (largest*unit <= 0.5_dp*interval) grain(j) = largest*unit
    end do
  end function grains

  pure real(dp) function unit_of(times, steps) result(unit)
    !! A power of ten [s] of which all intervals are multiples: the finest of the last digits, or of 1 ns and coarser ones; 0
    !! where there is none.
    real(dp), intent(in) :: times(:), steps(:)
    real(dp) :: rounding, count
    integer(i8) :: j
    rounding = slack*spacing(max(abs(times(1)), abs(times(size(times)))))
    unit = max(minval(steps), 1.0e-9_dp)
    do while (unit < 10*rounding)
      unit = 10*unit
    end do
    do j = 2, size(times, kind=i8)
      count = (times(j) - times(j - 1))/unit
      if (abs(count - anint(count))*unit <= rounding .and. count >= 0.5_dp .and. count < 1.0e15_dp) cycle
      unit = 0.0_dp
      return
    end do
  end function unit_of

  pure elemental integer(i8) function common_divisor(first, second) result(divisor)
    !! The largest whole number that divides two positive ones.
    integer(i8), intent(in) :: first, second
    integer(i8) :: other, rest
    divisor = first
    other = second
    do while (other /= 0)
      rest = mod(divisor, other)
      divisor = other
      other = rest
    end do
  end function common_divisor

  pure real(dp) function fitted_interval(times) result(interval)
    !! The slope of the times over their numbers, by least squares.
    real(dp), intent(in) :: times(:)
    real(dp) :: middle, straight, sum_of_rests
    integer(i8) :: j, n
    n = size(times, kind=i8)
    middle = 0.5_dp*(n + 1)
    straight = (times(n) - times(1))/(n - 1)
    sum_of_rests = 0.0_dp
    do j = 1, n
      sum_of_rests = sum_of_rests + (j - middle)*((times(j) - times(1)) - (j - 1)*straight)
    end do
    interval = straight + sum_of_rests/(real(n, dp)*(real(n, dp)**2 - 1)/12)
  end function fitted_interval

  pure subroutine find_range(times, steps, low, high)
    !! The least and the largest interval d with which some offset brings all times within half of their last digit; low > high
    !! where there is none. The excess max (t_j − h_j − j d) − min (t_j + h_j − j d) is a convex polygon over d: Newton's steps
    !! come to its roots from either side, and never beyond but for rounding.
    real(dp), intent(in) :: times(:), steps(:)
    real(dp), intent(out) :: low, high
    real(dp) :: rounding
    integer :: j
    rounding = slack*spacing(max(abs(times(1)), abs(times(size(times)))))
    low = 0.0_dp
    call approach(1, low)
    high = minval([(bound_by(j), j=1, min(2, size(times) - 1))])   ! a first time of 0 may have few digits
    if (low < high) call approach(-1, high)

  contains

    pure real(dp) function bound_by(j)
      !! The largest interval that one time and the last allow.
      integer, intent(in) :: j
      integer :: n
      n = size(times)
      bound_by = (times(n) - times(j) + 0.5_dp*(steps(n) + steps(j)) + 2*rounding)/(n - j)
    end function bound_by

    pure subroutine approach(side, d)
      !! The end of the range on one side; beyond the other where it is empty.
      integer, intent(in) :: side            !! 1: from below, −1: from above
      real(dp), intent(inout) :: d
      real(dp) :: half, rest, lower, upper, before
      integer :: i, j, up, down
      before = d
      do i = 1, most_steps
        lower = -huge(lower)
        upper = huge(upper)
        up = 1
        down = 1
        do j = 1, size(times)
          half = 0.5_dp*steps(j) + rounding
          rest = (times(j) - times(1)) - (j - 1)*d
          if (rest - half > lower) up = j
          lower = max(lower, rest - half)
          if (rest + half < upper) down = j
          upper = min(upper, rest + half)
        end do
        if (lower - upper <= rounding) return
        if (side*(up - down) > 0) then
          before = d
          d = d + (lower - upper)/(up - down)
        else
          d = 0.5_dp*(before + d)            ! rounding carried the step beyond
        end if
      end do
      d = side*huge(d)                       ! even the best is none
    end subroutine approach

  end subroutine find_range

  pure real(dp) function rounded_to(value, digits) result(number)
    !! A positive number with so many digits.
    real(dp), intent(in) :: value
    integer, intent(in) :: digits
    character(32) :: text, form
    write (form, '(a,i0,a)') '(es32.', digits - 1, 'e3)'
    write (text, form) value
    read (text, *) number
  end function rounded_to

end module bw_sample_times
