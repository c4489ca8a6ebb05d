module bw_shape_price
  !! What a drift, or a second line in a peak, must take off the weighted squares to be taken for real.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: least_gain, price_of_drift

  real(dp), parameter :: places = 8             !! independent places of a second line in a peak; from trials on noise

contains

  pure real(dp) function price_of_drift(powers, false_alarm) result(price)
    !! What a drift must take off the weighted squares: as much as noise gives to two unknowns with that probability for each power
    !! above the first, and for the first of them as much more as a pair pays for its places, since a drift that is fitted without
    !! need makes decays uncertain.
    integer, intent(in) :: powers
    real(dp), intent(in) :: false_alarm
    price = 0
    if (powers > 1) price = -2*log(false_alarm)*(powers - 1) + 2*log(places)
  end function price_of_drift

  pure real(dp) function least_gain(sensors, false_alarm) result(gain)
    !! What a second line must take off the weighted squares: noise gives more with that probability. Decay, frequency and an
    !! amplitude at each sensor are 2 + 2S normal numbers, at about `places` places.
    integer, intent(in) :: sensors
    real(dp), intent(in) :: false_alarm
    real(dp) :: low, high, term, tail
    integer :: i, j
    low = 0
    high = 2000.0_dp + 20*sensors
    do i = 1, 60
      gain = (low + high)/2
      term = exp(-gain/2)
      tail = term
      do j = 1, sensors
        term = term*gain/(2*j)
        tail = tail + term
      end do
      if (tail*places > false_alarm) then
        low = gain
      else
        high = gain
      end if
    end do
  end function least_gain

end module bw_shape_price
