module bw_random_effects
  !! One number measured several times, each time with its own standard deviation, with more scatter than these explain: the
  !! random-effects model x_k = μ + b_k + e_k, var b = τ², var e_k = s_k². τ² is estimated by the method of Paule & Mandel (1982),
  !! the interval by that of Hartung & Knapp (2001).
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_order, only: ascending
  use bw_quantile, only: normal, squares_deviation, student_quantile
  implicit none (type, external)
  private
  public :: middle_of, pooled_number

  real(dp), parameter :: most_weight = 2   !! of one repeat relative to the median one; tuned so that intervals hold 95 % where
                                           !! standard deviations differ by a factor of 10, and scatter is as large as some

  type, public :: pooled_value
    !! The pooled value of a number; `missing` if fewer than two repeats have it.
    real(dp) :: value = missing        !! μ
    real(dp) :: error = missing        !! half-width of the interval for μ
    real(dp) :: next = missing         !! half-width of the interval about μ for the value of one more repeat
    real(dp) :: scatter = missing      !! τ, the standard deviation between repeats beyond their own
    real(dp) :: drift = 0              !! part of `error` that is due to a change along each repeat
    integer :: count = 0               !! repeats that have a value
    logical :: scatters = .false.      !! they scatter more than their own standard deviations explain
  end type pooled_value

contains

  pure type(pooled_value) function pooled_number(value, deviation, confidence, false_alarm) result(pooled)
    !! Pool the values whose standard deviations are not `missing`. If these are equal, the interval is Student's. It is never
    !! narrower than the standard deviations allow, so that two repeats that agree by chance do not give a narrow one. No repeat
    !! weighs more than twice the median one, as one with too small an error would dominate. One more has the median deviation.
    real(dp), intent(in) :: value(:), deviation(:)   !! standard deviations above 0
    real(dp), intent(in) :: confidence               !! of the intervals, 0 … 1
    real(dp), intent(in) :: false_alarm              !! probability that consistent repeats are reported to scatter
    real(dp), allocatable :: x(:), variance(:)
    real(dp) :: between, own, usual, student, known, squares
    x = pack(value, .not. is_missing(deviation))
    variance = pack(deviation, .not. is_missing(deviation))**2
    pooled%count = size(x)
    if (size(x) < 2) return
    squares = squares_of(x, variance)
    pooled%scatters = erfc(squares_deviation(squares, size(x) - 1)/sqrt(2.0_dp))/2 < false_alarm
    usual = middle_of(variance)
    variance = max(variance, usual/most_weight)
    between = between_variance(x, variance)
    pooled%value = mean_of(x, variance + between)
    pooled%scatter = sqrt(between)
    student = student_quantile(confidence, size(x) - 1)*sqrt(min(1.0_dp, squares_of(x, variance)/(size(x) - 1)))
    known = student_quantile(confidence, normal)
    own = 1/sum(1/variance)
    pooled%error = max(student/sqrt(sum(1/(variance + between))), known*sqrt(own))
    pooled%next = max(student*sqrt(usual + between + 1/sum(1/(variance + between))), known*sqrt(usual + own))
  end function pooled_number

  pure real(dp) function between_variance(x, variance) result(between)
    !! The τ² ≥ 0 at which the weighted sum of squares equals its expectation, by Newton's method from below: the sum falls with
    !! τ² and is convex, so that no step overshoots.
    real(dp), intent(in) :: x(:), variance(:)
    integer, parameter :: most = 200
    real(dp) :: excess, step
    integer :: i
    between = 0
    do i = 1, most
      associate (total => variance + between)
        excess = squares_of(x, total) - (size(x) - 1)
        if (excess <= 0) exit
        step = excess/sum(((x - mean_of(x, total))/total)**2)
      end associate
      between = between + step
      if (step <= epsilon(step)*between) exit
    end do
  end function between_variance

  pure real(dp) function squares_of(x, variance) result(squares)
    !! Sum of squared distances from the weighted mean over the variances.
    real(dp), intent(in) :: x(:), variance(:)
    squares = sum((x - mean_of(x, variance))**2/variance)
  end function squares_of

  pure real(dp) function mean_of(x, variance) result(mean)
    !! The mean weighted by 1/variance, computed relative to the first number to limit rounding.
    real(dp), intent(in) :: x(:), variance(:)
    mean = x(1) + sum((x - x(1))/variance)/sum(1/variance)
  end function mean_of

  pure real(dp) function middle_of(x) result(middle)
    !! The median.
    real(dp), intent(in) :: x(:)
    real(dp) :: sorted(size(x))
    sorted = x(ascending(x))
    middle = (sorted((size(x) + 1)/2) + sorted(size(x)/2 + 1))/2
  end function middle_of

end module bw_random_effects
