module bw_reach
  !! Bounds of the displacement or velocity of a mode over an interval of time, from its initial state.
  use bw_double_double, only: dd, sqrt, operator(-)
  use bw_kinds, only: dp
  use bw_modal_flow, only: fast_exponent, slow_exponent, turning_square
  implicit none (type, external)
  private
  public :: amplitude_of, turns

  type, public :: stretch_type
    !! The samples of an interval, times in l²/h since the start of the motion.
    real(dp) :: start = 0.0_dp                   !! first sample
    real(dp) :: end = 0.0_dp                     !! one step after the last
    real(dp) :: step = 0.0_dp                    !! sampling interval
  end type stretch_type

  real(dp), parameter :: furthest = 600.0_dp
    !! exponent limit, near the overflow of histories, so that estimates do not overflow

contains

  elemental logical function turns(beta_squared, c)
    !! Return whether a mode oscillates; its phase is then practically random.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c
    type(dd) :: square
    square = turning_square(beta_squared, c)
    turns = square%hi > 0.0_dp
  end function turns

  elemental real(dp) function damped_reach(beta_squared, c, stretch, velocity) result(reach)
    !! Return the largest e^(−ct/2)|S| of a damped mode over the interval, or of its rate. Of two real exponentials only
    !! the slower one counts.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    type(dd) :: root, slow
    real(dp) :: fast, left
    slow = slow_exponent(beta_squared, c)
    if (turns(beta_squared, c)) then
      root = sqrt(turning_square(beta_squared, c))
      left = exp(slow%hi*stretch%start)
      reach = min(stretch%end, 1.0_dp/root%hi)*left
      if (velocity) reach = left*(1.0_dp + 0.5_dp*c*min(stretch%end, 1.0_dp/root%hi))
      return
    end if
    fast = fast_exponent(beta_squared, c)
    left = exp(min(furthest, slow%hi*merge(stretch%end, stretch%start, slow%hi > 0.0_dp)))
    reach = min(stretch%end, 1.0_dp/max(slow%hi - fast, 1.0_dp/stretch%end))*left
    if (velocity) reach = max(abs(slow%hi)*reach, exp(fast*stretch%start))
  end function damped_reach

  elemental real(dp) function amplitude_of(beta_squared, c, q, rate, stretch, velocity) result(amplitude)
    !! Bound the largest displacement or velocity of a mode over the interval, closely.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c, q, rate
    type(stretch_type), intent(in) :: stretch
    logical, intent(in) :: velocity
    type(dd) :: root, slow
    real(dp) :: swing
    if (c == 0.0_dp .and. beta_squared%hi > 0.0_dp) then      ! most modes
      swing = min(stretch%end, 1.0_dp/sqrt(beta_squared%hi))
      if (velocity) then
        amplitude = sqrt(rate**2 + (beta_squared%hi*q*swing)**2)
      else
        amplitude = sqrt(q**2 + (rate*swing)**2)
      end if
    else if (turns(beta_squared, c)) then
      root = sqrt(turning_square(beta_squared, c))
      slow = slow_exponent(beta_squared, c)
      swing = min(stretch%end, 1.0_dp/root%hi)                ! a slow mode does not reach its amplitude
      if (velocity) then
        amplitude = hypot(rate, (0.5_dp*c*abs(rate) + beta_squared%hi*abs(q))*swing)
      else
        amplitude = hypot(q, (abs(rate) + 0.5_dp*c*abs(q))*swing)
      end if
      amplitude = amplitude*exp(slow%hi*stretch%start)
    else if (velocity) then
      amplitude = abs(rate)*damped_reach(beta_squared, c, stretch, .true.) &
        + abs(q*beta_squared%hi)*damped_reach(beta_squared, c, stretch, .false.)
    else
      amplitude = (abs(rate) + c*abs(q))*damped_reach(beta_squared, c, stretch, .false.) &
        + abs(q)*damped_reach(beta_squared, c, stretch, .true.)
    end if
  end function amplitude_of

end module bw_reach
