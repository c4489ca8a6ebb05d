module bw_extended_ends
  !! `bw_piece_ends` in binary128: states at the outer end of the four motions of a piece, divided by the same
  !! binary64 numbers, so that amplitudes keep their meaning.
  use bw_double_double, only: to_quad
  use bw_kinds, only: dp, qp
  use bw_piece_waves, only: is_short, piece_frequency, piece_numbers, wave_numbers, wave_numbers_of
  use bw_short_piece, only: starts
  implicit none (type, external)
  private
  public :: extended_ends

  integer, parameter :: terms = 34           !! of the power series of motions, |z|h² ≤ ½, to the 32nd digit
  integer, parameter :: square_terms = 12    !! of those of C and S, series in zh²
  real(qp), parameter :: nothing = 40.0_qp   !! qh above which tanh qh is 1 to 34 digits
  real(qp), parameter :: small = 0.5_qp      !! |z|h² below which C and S are summed as series

contains

  pure function extended_ends(piece, frequency) result(outer)
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency     !! λ > 0, unless the piece is short
    real(qp) :: outer(4, 4)                            !! (state, motion)
    type(wave_numbers) :: waves
    real(qp) :: c, s, load, moment, y, z
    real(dp) :: g
    integer :: i
    if (is_short(piece, frequency)) then
      outer = short_ends(piece, frequency)
      return
    end if
    waves = wave_numbers_of(piece, frequency)
    load = to_quad(piece%mass)*to_quad(frequency%lambda)
    do i = 1, 2
      g = 1.0_dp/sqrt(abs(waves%y(i)%hi))
      y = to_quad(waves%y(i))
      z = to_quad(waves%z(i))
      call find_c_and_s(z, to_quad(waves%p(i)), to_quad(piece%half), c, s)
      moment = to_quad(piece%stiffness)*y
      outer(:, i) = [c, -y*s, -moment*c, -load*s]
      outer(:, i + 2) = g*[z*s, y*c, -moment*z*s, load*c]
    end do
  end function extended_ends

  pure subroutine find_c_and_s(z, p, half, c, s)
    !! Find C and S at the end, over cosh √(−z)h for z < 0.
    real(qp), intent(in) :: z, p, half
    real(qp), intent(out) :: c, s
    real(qp) :: x
    integer :: m
    x = z*half**2
    if (abs(x) < small) then
      c = 1.0_qp
      s = 1.0_qp
      do m = square_terms, 1, -1
        c = 1.0_qp - x*c/(2*m*(2*m - 1))
        s = 1.0_qp - x*s/(2*m*(2*m + 1))
      end do
      s = s*half
      if (z >= 0.0_qp) return
      s = s/c
      c = 1.0_qp
    else if (z > 0.0_qp) then
      c = cos(p*half)
      s = sin(p*half)/p
    else
      c = 1.0_qp
      s = 1.0_qp/p
      if (p*half < nothing) s = tanh(p*half)/p
    end if
  end subroutine find_c_and_s

  pure function short_ends(piece, frequency) result(outer)
    !! Return the end states of a short piece by the power series of bw_short_piece.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    real(qp) :: outer(4, 4)
    real(qp) :: a, b, c, h, unit(4)
    real(dp) :: start(4)
    integer :: j
    h = to_quad(piece%half)
    a = to_quad(piece%wave)*to_quad(frequency%lambda)*h**4
    b = to_quad(piece%turn)*to_quad(frequency%rho)*h**2
    c = to_quad(piece%flexible)/h**2
    start = starts(piece, frequency)
    outer(:, 1) = sum_of_series(a, b, c, [start(1), 0.0_dp, 0.0_dp, 0.0_dp])
    outer(:, 2) = sum_of_series(a, b, c, [0.0_dp, 0.0_dp, start(3), 0.0_dp])
    outer(:, 3) = sum_of_series(a, b, c, [0.0_dp, start(2), 0.0_dp, 0.0_dp])
    outer(:, 4) = sum_of_series(a, b, c, [0.0_dp, 0.0_dp, 0.0_dp, start(4)])
    unit = [1.0_qp, 1.0_qp/h, to_quad(piece%stiffness)/h**2, to_quad(piece%stiffness)/h**3]
    do j = 1, 4
      outer(:, j) = unit*outer(:, j)
    end do
  end function short_ends

  pure function sum_of_series(a, b, c, start) result(state)
    !! Return (v, ψ, M, N) at t = 1 from v and M, or ψ and N, in the middle; alternate powers of t have the other two.
    real(qp), intent(in) :: a, b, c
    real(dp), intent(in) :: start(4)
    real(qp) :: state(4)
    real(qp), parameter :: nothing_more = 1.0e-34_qp
    real(qp) :: term(4)
    integer :: m
    logical :: even                            ! the last power has v and M
    state = start
    term = state
    even = start(1) /= 0.0_dp .or. start(3) /= 0.0_dp
    do m = 1, terms
      if (even) then
        term(2) = term(3)/m
        term(4) = -a*term(1)/m
        state(2:4:2) = state(2:4:2) + term(2:4:2)
      else
        term(1) = (term(2) + c*term(4))/m
        term(3) = -(term(4) + b*term(2))/m
        state(1:3:2) = state(1:3:2) + term(1:3:2)
      end if
      even = .not. even
      if (all(abs(term) <= nothing_more*abs(state))) exit
    end do
  end function sum_of_series

end module bw_extended_ends
