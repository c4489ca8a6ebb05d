module bw_sample_times
  !! Times of samples: they rise, a part of them is used, and even ones are known as such although their digits were cut.
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: even_interval, first_fall, used_part

  real(dp), parameter :: slack = 4.0_dp      !! roundings of a time that somebody computed

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
    !! Times t_j of n samples, each known to half of its last digit, h_j, are even with the interval d where one number a has
    !! |t_j − a − j d| ≤ h_j for all j. Least squares give d to about h n^(−3/2). Of all that fit, the roundest is taken: the
    !! sampling rate, or the interval, with as few digits as fit; so that 1/3 ms printed with three digits is 3000 Hz.
    real(dp), intent(in) :: times(:)         !! [s], rising
    real(dp), intent(in) :: steps(:)         !! what the last digit of each stands for [s]; 0: all digits are there
    real(dp) :: fitted, candidate
    integer :: digits
    integer, parameter :: most_digits = 15
    interval = 0.0_dp
    if (size(times) < 2) return
    fitted = fitted_interval(times)
    if (.not. could_fit(times, steps, fitted)) return
    do digits = 1, most_digits
      candidate = 1.0_dp/rounded_to(1.0_dp/fitted, digits)
      if (fits(times, steps, candidate)) interval = candidate
      if (interval > 0.0_dp) return
      candidate = rounded_to(fitted, digits)
      if (fits(times, steps, candidate)) interval = candidate
      if (interval > 0.0_dp) return
    end do
    if (fits(times, steps, fitted)) interval = fitted
  end function even_interval

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

  pure logical function could_fit(times, steps, interval)
    !! A look at a few times, since most uneven ones are far from even.
    real(dp), intent(in) :: times(:), steps(:), interval
    integer :: n
    n = min(size(times), 64)
    could_fit = interval > sqrt(tiny(interval))
    if (could_fit) could_fit = fits(times(:n), 4*steps(:n), interval)
  end function could_fit

  pure logical function fits(times, steps, interval)
    !! Some offset brings all times within half of their last digit.
    real(dp), intent(in) :: times(:), steps(:), interval
    real(dp) :: half, rest, low, high, rounding
    integer(i8) :: j
    low = -huge(low)
    high = huge(high)
    rounding = slack*spacing(max(abs(times(1)), abs(times(size(times)))))
    do j = 1, size(times, kind=i8)
      half = 0.5_dp*steps(j) + rounding
      rest = (times(j) - times(1)) - (j - 1)*interval
      low = max(low, rest - half)
      high = min(high, rest + half)
      if (low > high) exit
    end do
    fits = low <= high
  end function fits

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
