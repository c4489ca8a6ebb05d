module bw_piece_integrals
  !! Integrals over a piece of the squares of a motion, from its amplitudes, without quadrature: with z₁ ≠ z₂,
  !! (z₁ − z₂)∫C₁C₂ dx = 2(z₁S₁C₂ − z₂C₁S₂) and (z₁ − z₂)∫S₁S₂ dx = 2(S₁C₂ − C₁S₂) at the end; ∫C² = hw + CS and
  !! z∫S² = hw − CS, w = C² + zS².
  use bw_kinds, only: dp
  use bw_piece_ends, only: piece_ends
  use bw_piece_waves, only: piece_frequency, piece_numbers, piece_waves
  use bw_short_piece, only: find_series, piece_series, series_terms, states_of_series
  implicit none (type, external)
  private
  public :: mean_squares, sine_square

  real(dp), parameter :: series_below = 0.5_dp     !! |z|h² below which the closed form of ∫S² cancels

contains

  pure function mean_squares(piece, frequency, ends, amplitude) result(squares)
    !! Return ∫v² dx, and ∫ψ² dx with rotary inertia, else 0.
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    type(piece_ends), intent(in) :: ends
    real(dp), intent(in) :: amplitude(4)
    real(dp) :: squares(2)
    if (ends%waves%short) then
      squares = of_series(piece, frequency, amplitude)
    else
      squares = of_waves(ends%waves, piece%half%hi, piece%rotary%hi > 0.0_dp, amplitude)
    end if
  end function mean_squares

  pure function of_waves(waves, half, turning, amplitude) result(squares)
    type(piece_waves), intent(in) :: waves
    real(dp), intent(in) :: half
    logical, intent(in) :: turning
    real(dp), intent(in) :: amplitude(4)
    real(dp) :: squares(2)
    real(dp), dimension(2) :: cc, ss, odd, v
    real(dp) :: cross_c, cross_s
    associate (y => waves%y, z => waves%z, c => waves%c, s => waves%s)
      cc = half*waves%w + c*s
      ss = [sine_square(half, z(1), c(1), s(1), waves%w(1)), sine_square(half, z(2), c(2), s(2), waves%w(2))]
      cross_c = 2.0_dp*(z(1)*s(1)*c(2) - z(2)*c(1)*s(2))/(y(1) - y(2))
      cross_s = 2.0_dp*(s(1)*c(2) - c(1)*s(2))/(y(1) - y(2))
      odd = amplitude(3:4)/sqrt(abs(y))
      v = z*odd
      squares(1) = sum(amplitude(1:2)**2*cc + v**2*ss) + 2.0_dp*(amplitude(1)*amplitude(2)*cross_c + v(1)*v(2)*cross_s)
      squares(2) = 0.0_dp
      if (.not. turning) return
      v = y*amplitude(1:2)
      odd = y*odd
      squares(2) = sum(v**2*ss + odd**2*cc) + 2.0_dp*(v(1)*v(2)*cross_s + odd(1)*odd(2)*cross_c)
    end associate
  end function of_waves

  pure real(dp) function sine_square(half, z, c, s, w) result(integral)
    !! Return ∫S² dx over a piece, over cosh² for z < 0.
    real(dp), intent(in) :: half, z, c, s, w
    real(dp) :: x, term
    integer :: m
    x = z*half**2
    if (abs(x) > series_below) then
      integral = (half*w - c*s)/z
      return
    end if
    term = 2.0_dp/3.0_dp
    integral = term
    do m = 2, 11
      term = -4.0_dp*x*term/real(2*m*(2*m + 1), dp)
      integral = integral + term
    end do
    integral = w*half**3*integral
  end function sine_square

  pure function of_series(piece, frequency, amplitude) result(squares)
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    real(dp), intent(in) :: amplitude(4)
    real(dp) :: squares(2)
    type(piece_series) :: series
    real(dp) :: f(series_terms, 8)
    call find_series(piece, frequency, series)
    f = states_of_series(series, amplitude)
    squares(1) = square_of(f(:, 1), 0) + square_of(f(:, 5), 1)
    squares(2) = 0.0_dp
    if (piece%rotary%hi > 0.0_dp) squares(2) = square_of(f(:, 2), 1) + square_of(f(:, 6), 0)
    squares = piece%half%hi*squares
  end function of_series

  pure real(dp) function square_of(f, lowest) result(integral)
    !! Return ∫(Σ f_m t^(2m + lowest))² dt from −1 to 1, m from 0.
    real(dp), intent(in) :: f(:)
    integer, intent(in) :: lowest                  !! power, 0 or 1
    integer :: i, j
    integral = 0.0_dp
    do j = size(f), 1, -1
      do i = size(f), 1, -1
        integral = integral + f(i)*f(j)*(2.0_dp/(2*(i + j + lowest) - 3))
      end do
    end do
  end function square_of

end module bw_piece_integrals
