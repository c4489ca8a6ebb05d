module bw_modal_increment
  !! What a modal motion adds to where it was: near its start nothing of that is lost.
  use bw_double_double, only: dd, dd_pi, sqrt, to_dd, operator(-), operator(*), operator(/)
  use bw_kinds, only: dp
  use bw_modal_flow, only: flow, turning_square
  implicit none (type, external)
  private
  public :: increment

contains

  elemental real(dp) function increment(beta_squared, c, u, u_dot, time) result(change)
    !! u(t) − u(0).
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c, u, u_dot, time
    type(dd) :: square, root
    real(dp) :: x, less, sine, rate, now, now_dot
    square = turning_square(beta_squared, c)
    root = sqrt(square)
    if (square%hi <= 0.0_dp) root = sqrt(-square)
    x = root%hi*time
    if (square%hi <= 0.0_dp .and. x >= 1.0_dp) then
      now = u
      now_dot = u_dot
      call flow(beta_squared, c, to_dd(time), now, now_dot)
      change = now - u
      return
    end if
    sine = time
    if (square%hi > 0.0_dp) then
      x = reduced(root*time)
      less = -2.0_dp*sin(0.5_dp*x)**2                  ! cos x − 1
      sine = sin(x)/root%hi
    else
      less = 2.0_dp*sinh(0.5_dp*x)**2                  ! cosh x − 1
      if (x > 0.0_dp) sine = sinh(x)/root%hi
    end if
    rate = u_dot + 0.5_dp*c*u
    change = u*less + rate*sine
    if (c > 0.0_dp) change = change - 2.0_dp*exp(-0.25_dp*c*time)*sinh(0.25_dp*c*time)*(u + change)
  end function increment

  elemental real(dp) function reduced(phase) result(angle)
    !! A phase less whole turns.
    type(dd), intent(in) :: phase
    type(dd) :: turns
    angle = phase%hi
    if (abs(phase%hi) < 1.0_dp) return
    turns = phase/(dd_pi*2.0_dp)
    angle = 2.0_dp*dd_pi%hi*((turns%hi - anint(turns%hi)) + turns%lo)
  end function reduced

end module bw_modal_increment
