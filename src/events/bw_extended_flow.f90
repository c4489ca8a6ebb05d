module bw_extended_flow
  !! The exact motion of oscillators in binary128: bw_modal_flow with 34 digits. It runs in software, a microsecond or two for
  !! each oscillator: for motions whose errors grow, of which every digit at the start is one more later.
  use bw_kinds, only: qp
  implicit none (type, external)
  private
  public :: extended_flow

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

end module bw_extended_flow
