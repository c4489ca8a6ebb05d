module bw_extended_sine
  !! Sines of binary64 angles as double-double numbers, many at a time in vector registers.
  !!
  !! Power series of an eighth of the angle, then sin 2y = 2 sin y (1 − v), 1 − cos 2y = 2 sin² y thrice, where v = 1 − cos y
  !! stands in the cosine's place: near 0 it has the digits that 1 − v would lose.
  !!
  !! **Errors**: 1e-31, absolute.
  use bw_double_double, only: dd, operator(*), operator(+), operator(-)
  use bw_kinds, only: dp, qp
  implicit none (type, external)
  private
  public :: sine_and_versine

  integer, parameter :: doublings = 3
  integer, parameter :: long = 4      !! terms beyond the first whose 16 digits of binary64 are too few
  integer, parameter :: all = 8       !! terms beyond the first: at y = 1/8 the next is below 1e-33 of the whole

  real(qp), parameter :: sine_terms(all) = 1.0_qp/[-6.0_qp, 120.0_qp, -5040.0_qp, 362880.0_qp, -39916800.0_qp, &
    6227020800.0_qp, -1307674368000.0_qp, 355687428096000.0_qp]              !! ±1/(2m+1)!
  real(qp), parameter :: versine_terms(all) = 2.0_qp/[-24.0_qp, 720.0_qp, -40320.0_qp, 3628800.0_qp, -479001600.0_qp, &
    87178291200.0_qp, -20922789888000.0_qp, 6402373705728000.0_qp]           !! ±2/(2m+2)!

contains

  pure subroutine sine_and_versine(angle, sine, versine)
    !! sin x and 1 − cos x.
    real(dp), intent(in) :: angle(:)             !! x, |x| ≤ 1
    type(dd), intent(out) :: sine(:), versine(:) !! (size(angle))
    type(dd), dimension(size(angle)) :: part, square
    integer :: i
    part%hi = angle/2.0_dp**doublings
    part%lo = 0.0_dp
    square = part*part
    sine = part*series(square, sine_terms)
    versine = (square*series(square, versine_terms))*0.5_dp
    do i = 1, doublings
      part = sine*versine
      versine = (sine*sine)*2.0_dp
      sine = (sine - part)*2.0_dp
    end do
  end subroutine sine_and_versine

  pure function series(square, terms) result(sum)
    !! 1 + Σ_m terms_m·square^m, the last terms in binary64.
    type(dd), intent(in) :: square(:)
    real(qp), intent(in) :: terms(all)
    type(dd) :: sum(size(square))
    real(dp) :: tail(size(square)), short(all)
    integer :: m
    short = real(terms, dp)
    tail = short(all)
    do m = all - 1, long + 1, -1
      tail = short(m) + square%hi*tail
    end do
    sum = dd(short(long), real(terms(long) - short(long), dp)) + square%hi*tail
    do m = long - 1, 1, -1
      sum = sum*square + dd(short(m), real(terms(m) - short(m), dp))
    end do
    sum = sum*square + dd(1.0_dp, 0.0_dp)
  end function series

end module bw_extended_sine
