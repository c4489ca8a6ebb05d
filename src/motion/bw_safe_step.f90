module bw_safe_step
  !! How far a sum of modal motions that is positive stays so for certain: with u the sum, its value and slope at hand, and
  !! |ü| ≤ B from the amplitudes, u > 0 as long as u + u̇h − ½Bh² > 0. Motions of high frequency are taken by their amplitude
  !! alone where that gives the longer step.
  use bw_double_double, only: dd, sqrt
  use bw_kinds, only: dp
  use bw_modal_flow, only: turning_square
  implicit none (type, external)
  private
  public :: instant_of, longest_step, safe_step

  type, public :: instant
    !! What a step is made from.
    real(dp) :: value = 0.0_dp
    real(dp), allocatable :: u(:), u_dot(:), reach(:), rate(:)   !! of the parts; reach times rate^m bounds derivatives
    logical, allocatable :: turning(:)
  end type instant

  real(dp), parameter :: growth = exp(0.5_dp)      !! of a part that does not turn, over a quarter of 1/rate
  real(dp), parameter, public :: quarter = 0.25_dp

contains

  pure type(instant) function instant_of(beta_squared, c, value, u, u_dot) result(now)
    !! From the parts, their sum and its rates.
    type(dd), intent(in) :: beta_squared(:)        !! (parts)
    real(dp), intent(in) :: c(:), value, u(:), u_dot(:)
    type(dd) :: square(size(u))
    square = turning_square(beta_squared, c)
    now%value = value
    now%u = u
    now%u_dot = u_dot
    now%turning = square%hi > 0.0_dp
    now%rate = merge(sqrt(max(0.0_dp, beta_squared%hi)), c + sqrt(abs(beta_squared%hi)), now%turning)
    allocate (now%reach(size(u)))
    where (now%turning)
      now%reach = hypot(u, (u_dot + 0.5_dp*c*u)/sqrt(max(tiny(1.0_dp), square%hi)))
    elsewhere (now%rate > 0.0_dp)
      now%reach = growth*(abs(u) + abs(u_dot)/max(tiny(1.0_dp), now%rate))
    elsewhere
      now%reach = 0.0_dp                           ! a steady drift has no further derivatives
    end where
  end function instant_of

  pure real(dp) function longest_step(now, change) result(step)
    !! For how long the slope changes by no more than that.
    type(instant), intent(in) :: now
    real(dp), intent(in) :: change                 !! ≥ 0
    real(dp) :: curvature, fast
    curvature = sum(now%reach*now%rate**2)
    fast = maxval(now%rate, mask=.not. now%turning .and. now%rate > 0.0_dp)
    step = huge(step)
    if (curvature > 0.0_dp) step = change/max(curvature, tiny(step))
    if (fast > 0.0_dp) step = min(step, quarter/fast)
  end function longest_step

  pure real(dp) function safe_step(now, longest) result(step)
    !! How far the signal stays positive for certain.
    type(instant), intent(in) :: now
    real(dp), intent(in) :: longest
    real(dp) :: above, fast
    integer :: low, n
    n = size(now%u)
    fast = maxval(now%rate, mask=.not. now%turning .and. now%rate > 0.0_dp)
    step = 0.0_dp
    low = n
    do
      above = now%value - sum(now%reach(low + 1:) + abs(now%u(low + 1:)), mask=now%turning(low + 1:))
      if (above >= 0.0_dp) step = max(step, parabola(above, slope(low), curvature(low)))
      if (low == 0) exit
      low = low/2
    end do
    if (fast > 0.0_dp) step = min(step, quarter/fast)
    step = min(step, longest)
  contains
    pure real(dp) function slope(low)
      !! Rate of the sum without motions above number `low` that turn.
      integer, intent(in) :: low
      slope = sum(now%u_dot(:low)) + sum(now%u_dot(low + 1:), mask=.not. now%turning(low + 1:))
    end function slope
    pure real(dp) function curvature(low)
      !! A bound of the second derivative of the same.
      integer, intent(in) :: low
      curvature = sum(now%reach(:low)*now%rate(:low)**2) &
        + sum(now%reach(low + 1:)*now%rate(low + 1:)**2, mask=.not. now%turning(low + 1:))
    end function curvature
    pure real(dp) function parabola(value, slope, curvature) result(root)
      !! The first zero of value + slope h − ½ curvature h².
      real(dp), intent(in) :: value, slope, curvature
      real(dp) :: both
      both = sqrt(slope**2 + 2.0_dp*curvature*value)
      if (slope >= 0.0_dp) then
        root = huge(1.0_dp)
        if (curvature > (slope + both)/longest) root = (slope + both)/curvature
      else
        root = 2.0_dp*value/(both - slope)
      end if
    end function parabola
  end function safe_step

end module bw_safe_step
