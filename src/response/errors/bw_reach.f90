module bw_reach
  !! How far modes go over a stretch of time, from velocity 1 or from any state: bounds of their displacement or velocity.
  use bw_double_double, only: dd, sqrt, operator(-)
  use bw_kinds, only: dp
  use bw_modal_flow, only: fast_exponent, slow_exponent, turning_square
  implicit none (type, external)
  private
  public :: amplitude_of, turns

  type, public :: stretch_type
    !! Samples of a part of a history, times in l²/h from the start of the motion.
    real(dp) :: start = 0.0_dp                   !! the first sample after that
    real(dp) :: end = 0.0_dp                     !! a step after the last
    real(dp) :: step = 0.0_dp                    !! from sample to sample
  end type stretch_type

  real(dp), parameter :: furthest = 600.0_dp
    !! beyond it a history is near overflow; the estimate must not overflow itself

contains

  elemental logical function turns(beta_squared, c)
    !! The mode swings: its sign is as good as random.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c
    type(dd) :: square
    square = turning_square(beta_squared, c)
    turns = square%hi > 0.0_dp
  end function turns

  elemental real(dp) function damped_reach(beta_squared, c, stretch, velocity) result(reach)
    !! The largest e^(−ct/2)|S| of a damped mode over the stretch, or of its rate: of two real exponentials, the slower
    !! one alone.
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
    !! The largest displacement or velocity of a mode over the stretch, or a little more.
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
      swing = min(stretch%end, 1.0_dp/root%hi)                ! a slow mode does not come that far
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
