module bw_short_piece
  !! The motions of a piece that is short compared with its waves, as power series from its middle.
  !!
  !! In t = x/h the state (v, hψ, h²M/B, h³N/B) obeys v' = ψ + cN, ψ' = M, M' = −N − bψ, N' = −av, a = mλh⁴/B, b = Rh²/B, c =
  !! sB/h². Even motions start from v and from M in the middle, odd ones from ψ and from N, in amounts typical of the whole beam
  !! at the frequency, which hardly depend on the piece: elimination pivots by size, and so subtracts deflections from
  !! deflections and forces from forces. If forces were computed from deflections, a mode that hardly bends the piece would need
  !! exact differences of nearly equal motions. As λ → 0 the motions become static ones, without loss of digits.
  use bw_kinds, only: dp
  use bw_piece_waves, only: piece_frequency, piece_numbers
  implicit none (type, external)
  private
  public :: find_series, short_ends, starts, states_of_series, polynomial_states

  integer, parameter, public :: series_terms = 11   !! of powers t^0, t^2, … or t^1, t^3, …: the rest is below 1e-18 for |z|h² ≤ ½

  type, public :: piece_series
    !! Coefficients by state (v, ψ, M, N) and start, (terms, 4, 2): in even motions v and M have even powers of t, ψ and
    !! N odd ones; in odd motions vice versa. In physical units except t.
    real(dp) :: even(series_terms, 4, 2) = 0.0_dp
    real(dp) :: odd(series_terms, 4, 2) = 0.0_dp
  end type piece_series

contains

  pure subroutine find_series(piece, frequency, series)
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    type(piece_series), intent(out) :: series
    real(dp) :: a, b, c, h, unit(4), start(4)
    integer :: j
    h = piece%half%hi
    a = piece%wave%hi*frequency%lambda%hi*h**4
    b = piece%turn%hi*frequency%rho%hi*h**2
    c = piece%flexible%hi/h**2
    start = starts(piece, frequency)
    series%even(1, 1, 1) = start(1)
    series%even(1, 3, 2) = start(3)
    series%odd(1, 2, 1) = start(2)
    series%odd(1, 4, 2) = start(4)
    unit = [1.0_dp, 1.0_dp/h, piece%stiffness%hi/h**2, piece%stiffness%hi/h**3]
    do j = 1, 2
      call continue_even(a, b, c, series%even(:, :, j))
      call continue_odd(a, b, c, series%odd(:, :, j))
    end do
    do j = 1, 4
      series%even(:, j, :) = unit(j)*series%even(:, j, :)
      series%odd(:, j, :) = unit(j)*series%odd(:, j, :)
    end do
  end subroutine find_series

  pure function starts(piece, frequency) result(start)
    !! Return v, hψ, h²M/B and h³N/B in the middle, each of one motion.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    real(dp) :: start(4)
    associate (h => piece%half%hi, b => piece%stiffness%hi)
      start = frequency%unit*[1.0_dp, h, h**2/b, h**3/b]
    end associate
  end function starts

  pure subroutine continue_even(a, b, c, f)
    !! Find higher coefficients from those of v and M in the middle.
    real(dp), intent(in) :: a, b, c
    real(dp), intent(inout) :: f(:, :)             !! (terms, 4)
    integer :: m
    do m = 1, series_terms
      f(m, 4) = -a*f(m, 1)/(2*m - 1)
      f(m, 2) = f(m, 3)/(2*m - 1)
      if (m == series_terms) exit
      f(m + 1, 1) = (f(m, 2) + c*f(m, 4))/(2*m)
      f(m + 1, 3) = -(f(m, 4) + b*f(m, 2))/(2*m)
    end do
  end subroutine continue_even

  pure subroutine continue_odd(a, b, c, f)
    !! Find higher coefficients from those of ψ and N in the middle.
    real(dp), intent(in) :: a, b, c
    real(dp), intent(inout) :: f(:, :)             !! (terms, 4)
    integer :: m
    do m = 1, series_terms
      f(m, 1) = (f(m, 2) + c*f(m, 4))/(2*m - 1)
      f(m, 3) = -(f(m, 4) + b*f(m, 2))/(2*m - 1)
      if (m == series_terms) exit
      f(m + 1, 2) = f(m, 3)/(2*m)
      f(m + 1, 4) = -a*f(m, 1)/(2*m)
    end do
  end subroutine continue_odd

  pure subroutine short_ends(series, even, odd)
    !! Find the states at t = 1.
    type(piece_series), intent(in) :: series
    real(dp), intent(out) :: even(4, 2), odd(4, 2)
    integer :: m
    even = series%even(series_terms, :, :)
    odd = series%odd(series_terms, :, :)
    do m = series_terms - 1, 1, -1                 ! small terms first
      even = even + series%even(m, :, :)
      odd = odd + series%odd(m, :, :)
    end do
  end subroutine short_ends

  pure function states_of_series(series, amplitude) result(f)
    !! Return the coefficients of a motion: even ones of v, ψ, M, N in columns 1 … 4, odd ones in 5 … 8.
    type(piece_series), intent(in) :: series
    real(dp), intent(in) :: amplitude(4)           !! of two even and two odd motions
    real(dp) :: f(series_terms, 8)
    f(:, 1:4) = amplitude(1)*series%even(:, :, 1) + amplitude(2)*series%even(:, :, 2)
    f(:, 5:8) = amplitude(3)*series%odd(:, :, 1) + amplitude(4)*series%odd(:, :, 2)
  end function states_of_series

  pure function polynomial_states(f, t) result(state)
    !! Return (v, ψ, M, N) at −1 ≤ t ≤ 1.
    real(dp), intent(in) :: f(series_terms, 8)     !! from `states_of_series`
    real(dp), intent(in) :: t
    real(dp) :: state(4)
    real(dp) :: sum(8)
    integer :: m
    sum = f(series_terms, :)
    do m = series_terms - 1, 1, -1
      sum = sum*t**2 + f(m, :)
    end do
    state(1) = sum(1) + t*sum(5)
    state(2) = t*sum(2) + sum(6)
    state(3) = sum(3) + t*sum(7)
    state(4) = t*sum(4) + sum(8)
  end function polynomial_states

end module bw_short_piece
