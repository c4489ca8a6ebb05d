module bw_precise_flow
  !! The exact motion of oscillators where bw_modal_flow, in binary64, would lose too much of it: in binary128, and as what is
  !! added to where it was, of which nothing is lost near the start.
  !!
  !! Binary128 runs in software, a microsecond or two for each oscillator: it is for motions whose errors grow, of which every
  !! digit at the start is one more later.
  use bw_double_double, only: dd, dd_pi, sqrt, to_dd, operator(*), operator(-), operator(/)
  use bw_kinds, only: dp, qp
  use bw_modal_flow, only: flow, turning_square
  implicit none (type, external)
  private
  public :: extended_flow, increment

  real(qp), parameter :: joined_below = 1.0_qp   !! rt below which the two exponentials would cancel

contains

  elemental subroutine extended_flow(square, c, root, time, u, v)
    !! Move a state on by a time of either sign, by ü + cu̇ + β²u = 0.
    real(qp), intent(in) :: square           !! β²
    real(qp), intent(in) :: c                !! ≥ 0
    real(qp), intent(in) :: root             !! √|β² − c²/4|
    real(qp), intent(in) :: time
    real(qp), intent(inout) :: u, v
    real(qp) :: turning, x
    turning = square - 0.25_qp*c**2
    x = root*time
    if (turning > 0.0_qp) then
      call join(cos(x), sin(x)/root, turning, c, time, u, v)
    else if (abs(x) < joined_below) then
      call join(cosh(x), time*mean_hyperbolic_cosine(x), turning, c, time, u, v)
    else
      call part(square, c, root, time, u, v)
    end if
  end subroutine extended_flow

  elemental subroutine join(cosine, sine, turning, c, time, u, v)
    !! The state from C and S.
    real(qp), intent(in) :: cosine, sine, turning, c, time
    real(qp), intent(inout) :: u, v
    real(qp) :: start, rate, decay
    start = u
    rate = v + 0.5_qp*c*u
    u = start*cosine + rate*sine
    v = rate*cosine - turning*start*sine
    if (c == 0.0_qp) return
    decay = exp(-0.5_qp*c*time)
    u = decay*u
    v = decay*v - 0.5_qp*c*u
  end subroutine join

  elemental subroutine part(square, c, root, time, u, v)
    !! The state from the two exponentials, r − ½c = −β²/(r + ½c).
    real(qp), intent(in) :: square, c, root, time
    real(qp), intent(inout) :: u, v
    real(qp) :: slow, fast, growing, decaying
    fast = -(root + 0.5_qp*c)
    slow = square/fast
    growing = 0.5_qp*(v - fast*u)/root*exp(slow*time)
    decaying = 0.5_qp*(slow*u - v)/root*exp(fast*time)
    u = growing + decaying
    v = slow*growing + fast*decaying
  end subroutine part

  elemental real(qp) function mean_hyperbolic_cosine(x) result(mean)
    !! sinh x/x, 1 at x = 0.
    real(qp), intent(in) :: x
    mean = 1.0_qp
    if (abs(x) > 0.0_qp) mean = sinh(x)/x
  end function mean_hyperbolic_cosine

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
    if (c > 0.0_dp) change = change + decay_less_one(0.5_dp*c*time)*(u + change)
  end function increment

  elemental real(dp) function decay_less_one(x) result(less)
    !! e⁻ˣ − 1 without cancellation, for x ≥ 0 of any size.
    real(dp), intent(in) :: x
    if (x < 1.0_dp) then
      less = -2.0_dp*exp(-0.5_dp*x)*sinh(0.5_dp*x)
    else
      less = exp(-x) - 1.0_dp
    end if
  end function decay_less_one

  elemental real(dp) function reduced(phase) result(angle)
    !! A phase less whole turns.
    type(dd), intent(in) :: phase
    type(dd) :: turns
    angle = phase%hi
    if (abs(phase%hi) < 1.0_dp) return
    turns = phase/(dd_pi*2.0_dp)
    angle = 2.0_dp*dd_pi%hi*((turns%hi - anint(turns%hi)) + turns%lo)
  end function reduced

end module bw_precise_flow
