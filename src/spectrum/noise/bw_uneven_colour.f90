module bw_uneven_colour
  !! The colour of noise at uneven times: an autoregression of first order between samples, however far they are from each other.
  !!
  !! Noise whose correlation falls as e^(−λτ), as that of a particle on a spring in a liquid, has the likelihood of independent
  !! numbers y_n − φ_n y_(n−1) of variance 1 − φ_n², times one for all, with φ_n = e^(−λ(τ_n − τ_(n−1))) (Jones, 1980).
  use bw_kinds, only: dp
  use bw_whitening, only: whitening_type
  implicit none (type, external)
  private
  public :: judge_uneven_noise

  real(dp), parameter :: highest_rate = 4      !! λ per step: such noise is white
  integer, parameter :: rates = 24             !! that are tried first
  real(dp), parameter :: ratio = 1.6_dp        !! of one to the next; the lowest is e-folds in 16 000 steps
  integer, parameter :: halvings = 8           !! of their distance

contains

  pure subroutine judge_uneven_noise(left, place, whitening, cost)
    !! Find the colour of noise as a filter of samples one step apart, and what noise costs: minus twice the logarithm of its
    !! likelihood, and two for the rate if there is one.
    real(dp), intent(in) :: left(:)
    real(dp), intent(in) :: place(:)           !! times τ of the samples
    type(whitening_type), intent(out) :: whitening
    real(dp), intent(out) :: cost
    real(dp) :: rate, factor, trial, least, white
    integer :: i
    white = size(left)*log(max(sum(left**2)/size(left), tiny(1.0_dp)))
    least = huge(1.0_dp)
    rate = highest_rate
    do i = 1, rates
      trial = price(highest_rate/ratio**(i - 1))
      if (trial >= least) cycle
      least = trial
      rate = highest_rate/ratio**(i - 1)
    end do
    factor = ratio
    do i = 1, halvings
      factor = sqrt(factor)
      if (price(rate*factor) < least) then
        rate = rate*factor
      else if (price(rate/factor) < least) then
        rate = rate/factor
      end if
      least = price(rate)
    end do
    cost = min(white, least + 2)
    whitening%coefficient(0) = 1
    if (cost >= white) return
    whitening%order = 1
    whitening%coefficient(1) = -exp(-rate)

  contains

    pure real(dp) function price(lambda)
      !! Of noise with that rate.
      real(dp), intent(in) :: lambda
      real(dp) :: phi, part, squares, volume
      integer :: n
      squares = left(1)**2
      volume = 0
      do n = 2, size(left)
        phi = exp(-lambda*(place(n) - place(n - 1)))
        part = 1 - phi**2
        squares = squares + (left(n) - phi*left(n - 1))**2/part
        volume = volume + log(part)
      end do
      price = size(left)*log(max(squares/size(left), tiny(1.0_dp))) + volume
    end function price

  end subroutine judge_uneven_noise

end module bw_uneven_colour
