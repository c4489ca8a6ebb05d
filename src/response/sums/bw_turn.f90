module bw_turn
  !! Phases of modes at samples, in turns, reduced before they are rounded: whole turns carry no information, however
  !! many there are.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, rounder, operator(*)
  implicit none (type, external)
  private
  public :: phase_angles, turn_fractions

contains

  pure function turn_fractions(cycles) result(fraction)
    !! Cycles less the nearest whole number: −½ … ½.
    type(dd), intent(in) :: cycles(:)
    type(dd) :: fraction(size(cycles))
    real(dp), parameter :: most = 2.0_dp**50         ! turns that `rounder` rounds
    real(dp) :: part, sum
    integer :: k
    do k = 1, size(cycles)
      part = cycles(k)%hi - ((cycles(k)%hi + rounder) - rounder)
      sum = part + cycles(k)%lo
      fraction(k)%hi = sum - ((sum + rounder) - rounder)
      fraction(k)%lo = cycles(k)%lo - (sum - part)     ! exact: `part` is zero or larger than what it is added to
    end do
    do k = 1, size(cycles)
      if (abs(cycles(k)%hi) < most) cycle
      part = cycles(k)%hi - aint(cycles(k)%hi)
      sum = part + cycles(k)%lo
      fraction(k) = dd(sum - anint(sum), cycles(k)%lo - (sum - part))
    end do
  end function turn_fractions

  pure function phase_angles(cycles, sample) result(angle)
    !! 2π·cycles·sample less whole turns, rad.
    type(dd), intent(in) :: cycles(:)        !! turns per sample
    integer, intent(in) :: sample
    real(dp) :: angle(size(cycles))
    type(dd) :: phase(size(cycles))
    phase = turn_fractions(cycles*real(sample, dp))
    angle = 2.0_dp*dd_pi%hi*(phase%hi + phase%lo)
  end function phase_angles

end module bw_turn
