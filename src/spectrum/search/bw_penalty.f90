module bw_penalty
  !! Penalties of unknowns: the gain in −2 ln L that noise alone exceeds anywhere with the probability `false_alarm`.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: chi_squared, line_penalty

  real(dp), parameter, public :: chi_median = 0.4549_dp  !! median of χ² with one degree of freedom

contains

  pure real(dp) function line_penalty(false_alarm, samples, amplitudes)
    !! The penalty of a line with so many real amplitudes, anywhere in frequency and decay. The gain is a χ² field over both. For
    !! high x the probability that such a field exceeds x is its tail at one place times x/2 for each independent place (Adler and
    !! Taylor, 2007), of which there is about one for each sample.
    real(dp), intent(in) :: false_alarm
    integer, intent(in) :: samples, amplitudes
    integer :: i
    line_penalty = chi_squared(false_alarm/samples, amplitudes)
    do i = 1, 4
      line_penalty = chi_squared(false_alarm/(samples*line_penalty/2), amplitudes)
    end do
  end function line_penalty

  pure real(dp) function chi_squared(chance, freedom) result(x)
    !! The value that the sum of `freedom` squared normal numbers, an even number, exceeds with the probability `chance`.
    real(dp), intent(in) :: chance
    integer, intent(in) :: freedom
    real(dp) :: low, high, term, logarithm, total
    integer :: i, k
    x = 0
    if (freedom == 0) return
    low = 0
    high = 10*(freedom - log(chance)) + 10
    do i = 1, 60
      x = (low + high)/2
      logarithm = -x/2                           ! e^(−x/2) Σ (x/2)^k/k!, from the largest term on
      total = 0
      term = 1
      do k = 1, freedom/2
        total = total + term
        term = term*(x/2)/k
        if (total < 1.0e200_dp) cycle
        logarithm = logarithm + log(total)
        term = term/total
        total = 1
      end do
      if (logarithm + log(total) > log(chance)) then
        low = x
      else
        high = x
      end if
    end do
  end function chi_squared

end module bw_penalty
