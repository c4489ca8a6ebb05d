module bw_chi_squared
  !! The distribution of sums of squares of standard normal deviates.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: chi_squared_tail

contains

  pure real(dp) function chi_squared_tail(x, freedom) result(tail)
    !! Probability that a sum of squares of so many standard normal deviates is above x: from 1 or 2 degrees of freedom
    !! upwards by Q(n) = Q(n − 2) + (x/2)^(n/2 − 1) e^(−x/2)/Γ(n/2).
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

end module bw_chi_squared
