module bw_margin
  !! How far a signal may be from what is computed of it, over the time since its start: where it comes closer to zero than
  !! this, nobody knows whether it reaches it.
  use bw_kinds, only: dp
  implicit none (type, external)
  private

  type, public :: margin_type
    !! The smaller of two bounds of what errors of the state make of the signal, and the noise of computing it.
    integer :: order = 0                 !! of the first derivative of the signal whose value at the start is in doubt
    real(dp) :: first = 0.0_dp           !! the doubt of that derivative
    real(dp) :: next = 0.0_dp            !! a bound of the one after it
    real(dp) :: swing = 0.0_dp           !! a bound of what parts that turn may do
    real(dp) :: drift = 0.0_dp           !! of the rate of what parts that do not turn may do
    real(dp) :: growth = 0.0_dp          !! rate at which such parts grow
    real(dp) :: blur = 0.0_dp            !! rate at which errors of frequencies add to it
    real(dp) :: noise = 0.0_dp           !! of rounding
    real(dp) :: noise_rate = 0.0_dp      !! the same soon after the start, over the time since then
  contains
    procedure :: until
  end type margin_type

contains

  elemental real(dp) function until(self, time) result(margin)
    !! A bound from the start to a time.
    class(margin_type), intent(in) :: self
    real(dp), intent(in) :: time                   !! since the start, ≥ 0
    real(dp) :: power, grown
    integer :: i
    power = 1.0_dp
    do i = 1, self%order
      power = power*time/i
    end do
    grown = time*exp(self%growth*time)
    margin = min(power*(self%first + self%next*grown/(self%order + 1)), self%swing + self%drift*grown) &
      + self%blur*grown + min(self%noise, self%noise_rate*time)
  end function until

end module bw_margin
