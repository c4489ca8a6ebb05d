module bw_piece_ends
  !! States (v, ψ, M, N) at the outer end of a piece for four motions that span all possible ones at a frequency: two
  !! with even deflection about its middle and two with odd. At the inner end the states are the same up to signs. N =
  !! κGA(v' − ψ) is the shear force, M = Bψ' the moment.
  use bw_kinds, only: dp
  use bw_piece_waves, only: find_waves, piece_frequency, piece_numbers, piece_waves
  use bw_short_piece, only: find_series, piece_series, short_ends
  implicit none (type, external)
  private
  public :: find_ends, inner_states, inner_stiffness, parity_shares

  integer, parameter :: begins(4) = [1, 3, 2, 4]     !! component of v, ψ, M, N with which a motion of a short piece starts

  type, public :: piece_ends
    type(piece_waves) :: waves
    real(dp) :: outer(4, 4) = 0.0_dp     !! states at the outer end of two even and two odd motions, (state, motion)
    real(dp) :: begun(4, 4) = 0.0_dp
      !! short piece: amplitudes of these in motions that start at the inner end, (motion, begun)
    real(dp) :: unit(4) = 1.0_dp         !! initial v, M, ψ and N of these, one in each motion
    integer :: hinged = 0                !! modes of the piece with hinged ends below the frequency
  end type piece_ends

contains

  pure subroutine find_ends(piece, frequency, ends)
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency     !! λ > 0, unless the piece is short
    type(piece_ends), intent(out) :: ends
    type(piece_series) :: series
    real(dp) :: load, g
    integer :: i
    call find_waves(piece, frequency, ends%waves)
    if (ends%waves%short) then
      call find_series(piece, frequency, series)
      call short_ends(series, ends%outer(:, 1:2), ends%outer(:, 3:4))
      ends%unit = [series%even(1, 1, 1), series%even(1, 3, 2), series%odd(1, 2, 1), series%odd(1, 4, 2)]
      do i = 1, 4
        ends%begun(:, i) = ends%outer(begins, i)/ends%unit
      end do
      if (piece%cut%hi*frequency%rho%hi > 1.0_dp) ends%hinged = 1
      return
    end if
    ends%hinged = ends%waves%quarters
    load = piece%mass%hi*frequency%lambda%hi
    do i = 1, 2
      associate (y => ends%waves%y(i), z => ends%waves%z(i), c => ends%waves%c(i), s => ends%waves%s(i))
        g = 1.0_dp/sqrt(abs(y))
        ends%outer(:, i) = [c, -y*s, -piece%stiffness%hi*y*c, -load*s]
        ends%outer(:, i + 2) = g*[z*s, y*c, -piece%stiffness%hi*y*z*s, load*c]
      end associate
    end do
  end subroutine find_ends

  pure function inner_states(ends) result(inner)
    !! Return states at the inner end, for a short piece those of the motions that start there. For others v and M of
    !! even motions and ψ and N of odd ones are even.
    type(piece_ends), intent(in) :: ends
    real(dp) :: inner(4, 4)                  !! (motion, state)
    integer :: q
    inner = 0.0_dp
    if (ends%waves%short) then
      do q = 1, 4
        inner(q, begins(q)) = ends%unit(q)
      end do
      return
    end if
    do q = 1, 4
      inner(1:2, q) = ends%outer(q, 1:2)
      inner(3:4, q) = -ends%outer(q, 3:4)
      if (mod(q, 2) == 0) inner(:, q) = -inner(:, q)
    end do
  end function inner_states

  pure function parity_shares(ends, begun) result(amplitude)
    !! Return amplitudes of even and odd motions for a motion given at the inner end.
    type(piece_ends), intent(in) :: ends
    real(dp), intent(in) :: begun(4)         !! amplitudes of the motions of `inner_states`
    real(dp) :: amplitude(4)
    amplitude = begun
    if (ends%waves%short) amplitude = matmul(ends%begun, begun)
  end function parity_shares

  pure subroutine parity_stiffness(f, k, regular)
    !! Find the forces (N, M) of two motions of one parity for deflection and rotation at the outer end.
    real(dp), intent(in) :: f(4, 2)
    real(dp), intent(out) :: k(2, 2)
    real(dp), intent(out) :: regular         !! distance from a clamped mode of this parity: 0 at it, up to 1
    real(dp) :: det, one, other
    one = f(1, 1)*f(2, 2)
    other = f(1, 2)*f(2, 1)
    det = one - other
    regular = abs(det)/(abs(one) + abs(other))
    if (det == 0.0_dp) det = tiny(det)
    k(1, 1) = (f(4, 1)*f(2, 2) - f(4, 2)*f(2, 1))/det
    k(1, 2) = (f(4, 2)*f(1, 1) - f(4, 1)*f(1, 2))/det
    k(2, 1) = (f(3, 1)*f(2, 2) - f(3, 2)*f(2, 1))/det
    k(2, 2) = (f(3, 2)*f(1, 1) - f(3, 1)*f(1, 2))/det
  end subroutine parity_stiffness

  pure subroutine inner_stiffness(ends, k, clamped, regular)
    !! Find the forces at the inner end of a piece for its deflection and rotation with the outer end held, for the
    !! count of Wittrick and Williams.
    type(piece_ends), intent(in) :: ends
    real(dp), intent(out) :: k(2, 2)
    integer, intent(out) :: clamped          !! modes with both ends clamped below the frequency
    real(dp), intent(out) :: regular         !! see `parity_stiffness`: near 0 `k` has lost its digits
    real(dp) :: even(2, 2), odd(2, 2), other
    call parity_stiffness(ends%outer(:, 1:2), even, regular)
    call parity_stiffness(ends%outer(:, 3:4), odd, other)
    regular = min(regular, other)
    clamped = clamped_count(ends%hinged, even(2, 2), odd(2, 2))
    k = 0.5_dp*(even + odd)
    k(1, 2) = -0.5_dp*(k(1, 2) + k(2, 1))
    k(2, 1) = k(1, 2)
  end subroutine inner_stiffness

  elemental integer function clamped_count(hinged, even, odd) result(clamped)
    !! Count clamped modes: one less for each parity with negative rotational stiffness of the hinged ends.
    integer, intent(in) :: hinged
    real(dp), intent(in) :: even, odd        !! that stiffness
    clamped = hinged - merge(1, 0, even < 0.0_dp) - merge(1, 0, odd < 0.0_dp)
  end function clamped_count

end module bw_piece_ends
