module bw_spurious_lines
  !! The probability that a line is spurious, before modes are considered: low in general, higher for lines that do not
  !! decay as the others do, and for those at a multiple of a far stronger line.
  !!
  !! A nonlinear sensor or clamp produces weak multiples of a strong line. A weak line is one of them with probability
  !! π, and then is normally distributed about the nearest multiple of the strong line's frequency g, with the deviation
  !! w of their distance; else it may lie anywhere. The likelihood ratio of the two is L = g exp(−z²/2)/(w√(2π)), with
  !! its distance z in units of w. The record itself gives π of a line, from the other weak lines (expectation
  !! maximisation of a mixture, leaving each line out of its own).
  use bw_constants, only: pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: spurious_chance

  real(dp), parameter, public :: usual_chance = 0.05_dp  !! chosen: few lines are spurious
  real(dp), parameter :: steady_odds = 25.0_dp   !! chosen: half of spurious lines are driven and do not decay; one mode in 50
  real(dp), parameter :: weaker = 0.01_dp        !! chosen: amplitude ratio below which a line may be a multiple

contains

  pure function spurious_chance(frequency, deviation, decay, decay_deviation, strength) result(chance)
    !! Return the probability for each line of a record.
    real(dp), intent(in) :: frequency(:)         !! [rad/s], > 0, (lines)
    real(dp), intent(in) :: deviation(:)         !! its standard deviation, (lines)
    real(dp), intent(in) :: decay(:)             !! [1/s], (lines)
    real(dp), intent(in) :: decay_deviation(:)   !! (lines)
    real(dp), intent(in), optional :: strength(:)   !! amplitude, if known, (lines)
    real(dp) :: chance(size(frequency)), odds(size(frequency)), usual(size(frequency))
    usual = median(decay/frequency)*frequency
    odds = usual_chance/(1 - usual_chance)
    where (decay + 2*decay_deviation < usual/20) odds = odds*steady_odds
    if (present(strength)) odds = odds + multiple_odds(frequency, deviation, strength)
    chance = odds/(1 + odds)
  end function spurious_chance

  pure function multiple_odds(frequency, deviation, strength) result(odds)
    !! Return the odds of each line to be a multiple of a far stronger one: Lπ/(1 − π).
    real(dp), intent(in) :: frequency(:), deviation(:), strength(:)   !! (lines)
    real(dp) :: odds(size(frequency))
    integer, parameter :: rounds = 30            !! enough for the expectations to converge
    real(dp) :: ratio(size(frequency)), share(size(frequency)), expected(size(frequency))
    logical :: weak(size(frequency))
    integer :: i, round
    weak = [(any(strength(i) < weaker*strength .and. frequency < frequency(i)), i=1, size(frequency))]
    ratio = 0
    do i = 1, size(frequency)
      if (weak(i)) ratio(i) = maxval(multiple_ratio(frequency(i), deviation(i), frequency, deviation), &
                                     mask=strength(i) < weaker*strength)
    end do
    share = usual_chance
    do round = 1, rounds
      expected = share*ratio/(share*ratio + 1 - share)
      share = (usual_chance + sum(expected) - expected)/(1 + max(0, count(weak) - 1))
    end do
    odds = ratio*share/(1 - share)
  end function multiple_odds

  elemental real(dp) function multiple_ratio(frequency, deviation, strong, strong_deviation) result(ratio)
    !! Return the likelihood ratio L of a line as a multiple of a strong one and as a mode.
    real(dp), intent(in) :: frequency, deviation, strong, strong_deviation
    real(dp) :: width
    integer :: times
    ratio = 0
    times = nint(frequency/strong)
    if (times < 2) return
    width = hypot(deviation, times*strong_deviation)
    if (sqrt(2*pi)*width < strong) ratio = strong/(sqrt(2*pi)*width)*exp(-0.5_dp*((frequency - times*strong)/width)**2)
  end function multiple_ratio

  pure real(dp) function median(values)
    !! Return the middle value; the lower one of two; 0 of none.
    real(dp), intent(in) :: values(:)
    integer :: i, half
    half = (size(values) + 1)/2
    median = 0
    do i = 1, size(values)
      if (count(values < values(i)) < half .and. count(values <= values(i)) >= half) median = values(i)
    end do
  end function median

end module bw_spurious_lines
