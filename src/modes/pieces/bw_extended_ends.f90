module bw_extended_ends
  !! `bw_piece_ends` in double-double: states at the outer end of the four motions of a piece, divided by the same
  !! binary64 numbers, so that amplitudes keep their meaning.
  use bw_double_double, only: dd, dd_pi, to_dd, operator(+), operator(-), operator(*), operator(/)
  use bw_kinds, only: dp, qp
  use bw_piece_waves, only: is_short, piece_frequency, piece_numbers, wave_numbers, wave_numbers_of
  use bw_short_piece, only: starts
  implicit none (type, external)
  private
  public :: extended_ends

  integer, parameter :: terms = 34           !! of the power series of motions, |z|h² ≤ ½, to the 32nd digit
  integer, parameter :: square_terms = 12    !! of those of C and S, series in zh²
  integer :: m                               !! index in lists of constants
  type(dd), parameter :: reciprocal(terms) = [(dd(1.0_dp/m, real(1.0_qp/m - 1.0_dp/m, dp)), m=1, terms)]
  integer, parameter :: parts = 32, wholes = 26      !! of 1, and of π/4
  type(dd), parameter :: whole_sines(0:wholes) = [(dd(real(sin(m/real(parts, qp)), dp), &
    real(sin(m/real(parts, qp)) - real(sin(m/real(parts, qp)), dp), dp)), m=0, wholes)]
  type(dd), parameter :: whole_cosines(0:wholes) = [(dd(real(cos(m/real(parts, qp)), dp), &
    real(cos(m/real(parts, qp)) - real(cos(m/real(parts, qp)), dp), dp)), m=0, wholes)]
  type(dd), parameter :: whole_exponentials(-wholes:wholes) = [(dd(real(exp(m/real(parts, qp)), dp), &
    real(exp(m/real(parts, qp)) - real(exp(m/real(parts, qp)), dp), dp)), m=-wholes, wholes)]
  type(dd), parameter :: log_2 = dd(log(2.0_dp), real(log(2.0_qp) - log(2.0_dp), dp))
  type(dd), parameter :: inverse(2:6) = [(dd(1.0_dp/gamma(m + 1.0_dp), &
    real(1.0_qp/gamma(m + 1.0_qp) - 1.0_dp/gamma(m + 1.0_dp), dp)), m=2, 6)]      !! 1/m!
  real(dp), parameter :: nothing = 40.0_dp   !! qh above which tanh qh is 1 to 34 digits
  real(dp), parameter :: hardly = 20.0_dp    !! qh above which it follows to 32 digits from e^(−2qh) in binary64
  real(dp), parameter :: small = 0.5_dp      !! |z|h² below which C and S are summed as series

contains

  pure function extended_ends(piece, frequency) result(outer)
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency     !! λ > 0, unless the piece is short
    type(dd) :: outer(4, 4)                            !! (state, motion)
    type(wave_numbers) :: waves
    type(dd) :: c, s, load, moment
    real(dp) :: g
    integer :: i
    if (is_short(piece, frequency)) then
      outer = short_ends(piece, frequency)
      return
    end if
    waves = wave_numbers_of(piece, frequency)
    load = piece%mass*frequency%lambda
    do i = 1, 2
      g = 1.0_dp/sqrt(abs(waves%y(i)%hi))
      call find_c_and_s(waves%z(i), waves%p(i), piece%half, c, s)
      moment = piece%stiffness*waves%y(i)
      outer(:, i) = [c, -(waves%y(i)*s), -(moment*c), -(load*s)]
      outer(:, i + 2) = [waves%z(i)*s*g, waves%y(i)*c*g, -(moment*waves%z(i)*s*g), load*c*g]
    end do
  end function extended_ends

  pure subroutine find_c_and_s(z, p, half, c, s)
    !! Find C and S at the end, over cosh √(−z)h for z < 0.
    type(dd), intent(in) :: z, p, half
    type(dd), intent(out) :: c, s
    type(dd) :: angle, x, e
    integer :: m
    angle = p*half
    x = z*half*half
    if (abs(x%hi) < small) then
      c = to_dd(1.0_dp)
      s = to_dd(1.0_dp)
      do m = square_terms, 1, -1
        c = to_dd(1.0_dp) - x*c/to_dd(real(2*m*(2*m - 1), dp))
        s = to_dd(1.0_dp) - x*s/to_dd(real(2*m*(2*m + 1), dp))
      end do
      s = s*half
      if (z%hi >= 0.0_dp) return
      s = s/c
      c = to_dd(1.0_dp)
    else if (z%hi > 0.0_dp) then
      call find_circular(angle, c, s)
      s = s/p
    else
      c = to_dd(1.0_dp)
      s = c/p
      if (angle%hi > nothing) return
      if (angle%hi > hardly) then
        e = to_dd(exp(-2.0_dp*angle%hi))
      else
        e = exponential(angle*(-2.0_dp))
      end if
      s = (c - e)/((c + e)*p)
    end if
  end subroutine find_c_and_s

  pure subroutine find_circular(angle, cosine, sine)
    type(dd), intent(in) :: angle              !! ≥ 0
    type(dd), intent(out) :: cosine, sine
    type(dd) :: rest, c, s
    integer :: quarters
    quarters = nint(angle%hi*(2.0_dp/dd_pi%hi))
    rest = angle - dd_pi*(0.5_dp*quarters)
    call sine_and_cosine(rest, s, c)
    select case (modulo(quarters, 4))
    case (0)
      cosine = c
      sine = s
    case (1)
      cosine = -s
      sine = c
    case (2)
      cosine = -c
      sine = -s
    case default
      cosine = s
      sine = -c
    end select
  end subroutine find_circular

  pure subroutine sine_and_cosine(angle, sine, cosine)
    !! Expand about the nearest 32nd by Taylor series, with the last terms in binary64.
    type(dd), intent(in) :: angle              !! |angle| ≤ π/4, or slightly more
    type(dd), intent(out) :: sine, cosine
    type(dd) :: rest, square, s, versine, whole, whole_cosine
    real(dp) :: x
    integer :: i
    i = nint(angle%hi*parts)
    rest = angle + (-i/real(parts, dp))
    square = rest*rest
    x = square%hi
    s = ((inverse(5) + x*(-1.0_dp/5040 + x*(1.0_dp/362880 - x/39916800)))*square + (-inverse(3)))*square*rest + rest
    versine = (((-inverse(6)) + x*(1.0_dp/40320 - x/3628800))*square + inverse(4))*square
    versine = (inverse(2) - versine)*square
    whole = whole_sines(abs(i))*real(sign(1, i), dp)
    whole_cosine = whole_cosines(abs(i))
    sine = whole + (whole_cosine*s - whole*versine)
    cosine = whole_cosine - (whole_cosine*versine + whole*s)
  end subroutine sine_and_cosine

  pure type(dd) function exponential(x)
    !! Expand about the nearest 32nd, besides a power of two, by Taylor series, with the last terms in binary64.
    type(dd), intent(in) :: x
    type(dd) :: rest, square
    real(dp) :: r
    integer :: i, power
    power = nint(x%hi/log_2%hi)
    rest = x - log_2*real(power, dp)
    i = nint(rest%hi*parts)
    rest = rest + (-i/real(parts, dp))
    square = rest*rest
    r = rest%hi
    r = r*(1.0_dp/5040 + r*(1.0_dp/40320 + r*(1.0_dp/362880 + r*(1.0_dp/3628800 &
      + r*(1.0_dp/39916800 + r*(1.0_dp/479001600 + r*(1.0_dp/6227020800.0_dp)))))))
    exponential = (inverse(6) + r)*square + inverse(5)*rest + inverse(4)
    exponential = (exponential*rest + inverse(3))*rest + inverse(2)
    exponential = (exponential*square + rest) + 1.0_dp
    exponential = exponential*whole_exponentials(i)
    exponential = dd(scale(exponential%hi, power), scale(exponential%lo, power))
  end function exponential

  pure function short_ends(piece, frequency) result(outer)
    !! Return the end states of a short piece by the power series of bw_short_piece.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    type(dd) :: outer(4, 4)
    type(dd) :: square, a, b, c, unit(4)
    real(dp) :: start(4)
    integer :: j
    square = piece%half*piece%half
    a = piece%wave*frequency%lambda*square*square
    b = piece%turn*frequency%rho*square
    c = piece%flexible/square
    start = starts(piece, frequency)
    outer(:, 1) = sum_of_series(a, b, c, [start(1), 0.0_dp, 0.0_dp, 0.0_dp])
    outer(:, 2) = sum_of_series(a, b, c, [0.0_dp, 0.0_dp, start(3), 0.0_dp])
    outer(:, 3) = sum_of_series(a, b, c, [0.0_dp, start(2), 0.0_dp, 0.0_dp])
    outer(:, 4) = sum_of_series(a, b, c, [0.0_dp, 0.0_dp, 0.0_dp, start(4)])
    unit = [to_dd(1.0_dp), to_dd(1.0_dp)/piece%half, piece%stiffness/square, piece%stiffness/(square*piece%half)]
    do j = 1, 4
      outer(:, j) = unit*outer(:, j)
    end do
  end function short_ends

  pure function sum_of_series(a, b, c, start) result(state)
    !! Return (v, ψ, M, N) at t = 1 from v and M, or ψ and N, in the middle; alternate powers of t have the other two.
    type(dd), intent(in) :: a, b, c
    real(dp), intent(in) :: start(4)
    type(dd) :: state(4)
    real(dp), parameter :: nothing_more = 1.0e-34_dp
    type(dd) :: term(4)
    integer :: m, j
    logical :: even                            ! the last power has v and M
    state = [(to_dd(start(j)), j=1, 4)]
    term = state
    even = start(1) /= 0.0_dp .or. start(3) /= 0.0_dp
    do m = 1, terms
      if (even) then
        term(2) = term(3)*reciprocal(m)
        term(4) = -(a*term(1))*reciprocal(m)
        state(2:4:2) = state(2:4:2) + term(2:4:2)
      else
        term(1) = (term(2) + c*term(4))*reciprocal(m)
        term(3) = -(term(4) + b*term(2))*reciprocal(m)
        state(1:3:2) = state(1:3:2) + term(1:3:2)
      end if
      even = .not. even
      if (all(abs(term%hi) <= nothing_more*abs(state%hi))) exit
    end do
  end function sum_of_series

end module bw_extended_ends
