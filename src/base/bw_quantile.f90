module bw_quantile
  !! Quantiles of the normal and of Student's distribution, and tail probabilities of χ².
  use bw_constants, only: pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: chi_squared_tail, normal_quantile, squares_deviation, student_quantile

  integer, parameter, public :: normal = huge(1)   !! degrees of freedom that stand for the normal distribution

contains

  pure real(dp) function normal_quantile(probability) result(x)
    !! Return the quantile of the standard normal distribution, by Newton's method.
    real(dp), intent(in) :: probability
    real(dp) :: below
    integer :: i
    x = 0
    do i = 1, 60
      below = erfc(-x/sqrt(2.0_dp))/2
      x = x - max(-1.0_dp, min(1.0_dp, (below - probability)*sqrt(2*pi)*exp(x*x/2)))
    end do
  end function normal_quantile

  pure real(dp) function student_quantile(confidence, freedom) result(quantile)
    !! Return t such that an interval of ±t standard deviations, estimated with these degrees of freedom, contains the
    !! true value with this probability; by bisection of t/(1 + t).
    real(dp), intent(in) :: confidence         !! 0 … 1
    integer, intent(in) :: freedom             !! ≥ 1, or `normal`
    real(dp) :: low, high, middle
    if (freedom == normal) then
      quantile = normal_quantile((1 + confidence)/2)
      return
    end if
    low = 0
    high = 1
    do
      middle = (low + high)/2
      if (middle <= low .or. middle >= high) exit
      if (held(middle/(1 - middle), freedom) < confidence) then
        low = middle
      else
        high = middle
      end if
    end do
    quantile = low/(1 - low)
  end function student_quantile

  pure real(dp) function held(t, freedom)
    !! Return the probability that Student's t lies between −t and t: finite sums for integer degrees of freedom
    !! (Abramowitz & Stegun 26.7.3 and 26.7.4), and the normal distribution for very many.
    real(dp), intent(in) :: t
    integer, intent(in) :: freedom
    real(dp) :: angle, term
    integer :: j
    if (freedom > 10000) then
      held = erf(t/sqrt(2.0_dp))
      return
    end if
    angle = atan(t/sqrt(real(freedom, dp)))
    held = 0
    term = merge(cos(angle), 1.0_dp, mod(freedom, 2) == 1)
    do j = merge(3, 2, mod(freedom, 2) == 1), freedom, 2
      held = held + term
      term = term*cos(angle)**2*(j - 1)/j
    end do
    held = held*sin(angle)
    if (mod(freedom, 2) == 1) held = 2/pi*(angle + held)
  end function held

  pure real(dp) function squares_deviation(squares, freedom) result(deviation)
    !! Transform a sum of squared normal deviates to an approximately standard normal one (Wilson & Hilferty 1931).
    real(dp), intent(in) :: squares
    integer, intent(in) :: freedom             !! ≥ 1
    real(dp) :: variance
    variance = 2/(9.0_dp*freedom)
    deviation = ((max(squares, 0.0_dp)/freedom)**(1/3.0_dp) - 1 + variance)/sqrt(variance)
  end function squares_deviation

  pure real(dp) function chi_squared_tail(x, freedom) result(tail)
    !! Return the probability that a sum of squared standard normal deviates exceeds x: by recursion from 1 or 2 degrees
    !! of freedom, Q(n) = Q(n − 2) + (x/2)^(n/2 − 1) e^(−x/2)/Γ(n/2).
    real(dp), intent(in) :: x                    !! ≥ 0
    integer, intent(in) :: freedom               !! ≥ 1
    integer :: n
    if (mod(freedom, 2) == 1) then
      tail = erfc(sqrt(0.5_dp*x))
    else
      tail = exp(-0.5_dp*x)
    end if
    if (.not. x > 0.0_dp) return
    do n = 3 + mod(freedom + 1, 2), freedom, 2
      tail = tail + exp((0.5_dp*n - 1)*log(0.5_dp*x) - 0.5_dp*x - log_gamma(0.5_dp*n))
    end do
  end function chi_squared_tail

end module bw_quantile
