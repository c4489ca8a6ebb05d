module bw_sample_times
  !! Times of samples: whether they increase, which are used, and whether they are evenly spaced to within rounding.
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: even_interval, first_fall, nearest_even, used_part

  real(dp), parameter :: slack = 4.0_dp      !! rounding errors allowed in a computed time
  integer, parameter :: most_steps = 100     !! most iterations for an end of the range of intervals
  integer, parameter :: window = 32          !! neighbours whose intervals show the resolution of a clock

contains

  pure integer(i8) function first_fall(times) result(row)
    !! Return the first time that is not later than the one before; 0 if all increase.
    real(dp), intent(in) :: times(:)
    do row = 2, size(times, kind=i8)
      if (.not. times(row) > times(row - 1)) return
    end do
    row = 0
  end function first_fall

  pure subroutine used_part(times, start, end, first, last)
    !! Find the first and last of the times from start to end, both included within rounding; last < first if there are none.
    real(dp), intent(in) :: times(:)         !! [s], increasing
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
    !! Return the interval of times that are evenly spaced to within rounding; 0 if they are uneven.
    !!
    !! Let each of n times t_j be known to h_j: half of its last digit, or of the resolution of its clock if that is coarser. They
    !! are evenly spaced at d if some a gives |t_j − a − j d| ≤ h_j for all j. Of all such intervals the roundest is returned, with
    !! the fewest digits as a sampling rate or as an interval: 1/3 ms printed with three digits is 3000 Hz.
    real(dp), intent(in) :: times(:)         !! [s], increasing
    real(dp), intent(in) :: steps(:)         !! last digit of each [s]; 0: all digits are known
    interval = 0.0_dp
    if (size(times) < 2) return
    interval = roundest(times, steps)
    if (interval > 0.0_dp) return
    interval = roundest(times, max(steps, grains(times, steps, fitted_interval(times))))
  end function even_interval

  pure real(dp) function roundest(times, steps) result(interval)
    !! Return the roundest interval that fits, as a rate or as an interval; 0 if none does.
    real(dp), intent(in) :: times(:), steps(:)
    real(dp) :: low, high
    integer :: digits, few
    integer, parameter :: most_digits = 15
    interval = 0.0_dp
    few = min(size(times), 64)               ! a first test: most uneven times fail within a few
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
    !! Fit evenly spaced times to uneven ones, and return the largest deviation. The interval is the roundest whose largest
    !! deviation is at most twice that of least squares.
    real(dp), intent(in) :: times(:)         !! [s], increasing
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
    !! Return the least and the largest of t_j − t_1 − (j − 1) d.
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
    !! Return the resolution of the clock at each time: the largest step that divides all intervals of some neighbours, before
    !! or after; 0 if there is none, or if it exceeds half of the interval, since it could then be the interval itself.
    !!
    !! Padding zeros of a time stamp do not show the resolution, nor do the digits of a difference: t − t₁ has as many as t₁,
    !! and t may have had fewer. Only neighbours are used, since stamps with a fixed number of digits become coarser with time.
    real(dp), intent(in) :: times(:), steps(:)
    real(dp), intent(in) :: interval         !! approximate, between neighbours
    real(dp) :: grain(size(times))
    integer(i8), allocatable :: ahead(:), back(:)      ! common divisors from an interval to the end of its block,
    integer(i8) :: largest                             ! and from the start of its block to it; a window spans two blocks
    real(dp) :: unit
    integer :: j, m
    grain = 0.0_dp
    unit = unit_of(times, steps)
    if (.not. interval > 2*unit .or. unit == 0.0_dp) return
    m = size(times) - 1
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
    !! Return a power of ten [s] that divides all intervals: the finest last digit, at least 1 ns, made coarser until it
    !! exceeds rounding; 0 if it does not divide them.
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
    !! Return the greatest common divisor of two positive numbers.
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
    !! Return the slope of the times over their indices, by least squares.
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
    !! Find the least and the largest interval d for which some offset brings all times within half of their last digit;
    !! low > high if there is none. The excess max (t_j − h_j − j d) − min (t_j + h_j − j d) is convex and piecewise linear in
    !! d: Newton's method approaches its roots from either side and never passes them, except by rounding.
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
      !! Return the largest interval that one time and the last allow.
      integer, intent(in) :: j
      integer :: n
      n = size(times)
      bound_by = (times(n) - times(j) + 0.5_dp*(steps(n) + steps(j)) + 2*rounding)/(n - j)
    end function bound_by

    pure subroutine approach(side, d)
      !! Find the end of the range on one side; past the other end if the range is empty.
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
          d = 0.5_dp*(before + d)            ! rounding made the step too long
        end if
      end do
      d = side*huge(d)                       ! the least excess is positive
    end subroutine approach

  end subroutine find_range

  pure real(dp) function rounded_to(value, digits) result(number)
    !! Round a positive number to this many significant digits.
    real(dp), intent(in) :: value
    integer, intent(in) :: digits
    character(32) :: text, form
    write (form, '(a,i0,a)') '(es32.', digits - 1, 'e3)'
    write (text, form) value
    read (text, *) number
  end function rounded_to

end module bw_sample_times
