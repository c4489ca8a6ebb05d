module bw_refined_far_roots
  !! Roots of far modes to 30 digits, many at a time in vector registers: one Newton step from the binary64 root, whose
  !! residual is taken in double-double numbers from the exact mass ratio. sech α and 1 − tanh α are below that precision.
  use bw_double_double, only: dd, to_dd, operator(*), operator(+), operator(-), operator(/)
  use bw_extended_sine, only: sine_and_versine
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: refine_light, refine_heavy

  integer, parameter, public :: first_far = 25    !! mode, from which on sech α is below 2e-33

contains

  pure subroutine refine_light(gamma, rest, alpha)
    !! sin δ (1 + c) + c cos δ = 0, c = γα, at α = (k − ½)π + δ.
    type(dd), intent(in) :: gamma
    real(dp), intent(in) :: rest(:)               !! δ as binary64 has it, (modes)
    type(dd), intent(inout) :: alpha(:)           !! the same with its whole turns; refined
    type(dd), dimension(size(rest)) :: sine, versine, c, residual
    real(dp), dimension(size(rest)) :: cosine, slope
    call sine_and_versine(rest, sine, versine)
    c = alpha*gamma
    residual = sine + c*(sine - versine + to_dd(1.0_dp))
    cosine = 1.0_dp - versine%hi
    slope = cosine + c%hi*(cosine - sine%hi) + gamma%hi*(sine%hi + cosine)
    alpha = alpha + (-(residual%hi/slope))
  end subroutine refine_light

  pure subroutine refine_heavy(gamma, rest, alpha)
    !! sin δ (2 + u) − u cos δ = 0, u = 1/(γα), at α = (k − ¾)π + δ.
    type(dd), intent(in) :: gamma
    real(dp), intent(in) :: rest(:)               !! as that of `refine_light`
    type(dd), intent(inout) :: alpha(:)
    real(dp), parameter :: heaviest = 1.0e40_dp   ! beyond it δ is below 1e-42, and γα soon overflows
    type(dd), dimension(size(rest)) :: sine, versine, u, residual
    real(dp), dimension(size(rest)) :: cosine, slope
    type(dd) :: mass
    mass = gamma
    if (gamma%hi > heaviest) mass = to_dd(heaviest)
    call sine_and_versine(rest, sine, versine)
    u = to_dd(1.0_dp)/(alpha*mass)
    residual = sine*2.0_dp + u*(sine + versine - to_dd(1.0_dp))
    cosine = 1.0_dp - versine%hi
    slope = cosine*(2.0_dp + u%hi) + u%hi*sine%hi - (u%hi/alpha%hi)*(sine%hi - cosine)
    alpha = alpha + (-(residual%hi/slope))
  end subroutine refine_heavy

end module bw_refined_far_roots
