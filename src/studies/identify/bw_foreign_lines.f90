module bw_foreign_lines
  !! How probable it is, before any beam is asked, that a line is no mode of it: a few are; more of those that do not decay as
  !! the others do, and of those at a multiple of the mains' frequency.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: foreign_chance

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter, public :: usual_chance = 0.05_dp  !! chosen: few lines are foreign
  real(dp), parameter :: steady_odds = 25.0_dp   !! chosen: half of foreign lines are driven and do not decay; of modes one in 50
  real(dp), parameter :: hums = 0.3_dp           !! chosen: share of foreign lines that are a hum
  real(dp), parameter :: mains(2) = [50.0_dp, 60.0_dp]   !! Hz
  real(dp), parameter :: wander = 5.0e-4_dp      !! of the mains' frequency

contains

  pure function foreign_chance(frequency, deviation, decay, decay_deviation) result(chance)
    !! Of each line of a record.
    real(dp), intent(in) :: frequency(:)         !! [rad/s], > 0, (lines)
    real(dp), intent(in) :: deviation(:)         !! its standard deviation, (lines)
    real(dp), intent(in) :: decay(:)             !! [1/s], (lines)
    real(dp), intent(in) :: decay_deviation(:)   !! (lines)
    real(dp) :: chance(size(frequency)), odds(size(frequency)), usual(size(frequency))
    usual = median(decay/frequency)*frequency
    odds = usual_chance/(1 - usual_chance)
    where (decay + 2*decay_deviation < usual/20) odds = odds*steady_odds
    where (decay - 3*decay_deviation < usual/5) odds = odds*mains_odds(frequency/(2*pi), deviation/(2*pi))
    chance = odds/(1 + odds)
  end function foreign_chance

  elemental real(dp) function mains_odds(frequency, deviation) result(odds)
    !! How much more probable it is that a foreign line is here than that a mode is, which may be anywhere.
    real(dp), intent(in) :: frequency, deviation !! Hz
    real(dp) :: width
    odds = 1
    width = max(2*deviation, wander*frequency)
    if (frequency < minval(mains) - width) return
    if (all(abs(frequency - mains*max(1, nint(frequency/mains))) > width)) return
    odds = max(1.0_dp, hums/sum(2*width/mains))
  end function mains_odds

  pure real(dp) function median(values)
    !! The middle one in the order of size; the lower one of two; 0 of none.
    real(dp), intent(in) :: values(:)
    integer :: i, half
    half = (size(values) + 1)/2
    median = 0
    do i = 1, size(values)
      if (count(values < values(i)) < half .and. count(values <= values(i)) >= half) median = values(i)
    end do
  end function median

end module bw_foreign_lines
