module bw_piece_shape
  !! The motion inside a piece: the state (v, ψ, M, N) at places between its ends, from the amplitudes.
  use bw_double_double, only: dd, rounder, to_dd, operator(+), operator(-), operator(*)
  use bw_kinds, only: dp
  use bw_piece_beam, only: piece_beam
  use bw_piece_waves, only: circular, is_short, piece_frequency, piece_numbers, wave_numbers, wave_numbers_of
  use bw_short_piece, only: find_series, piece_series, polynomial_states, series_terms, states_of_series
  implicit none (type, external)
  private
  public :: place_of, states_inside, wave_values

  real(dp), parameter :: small = 0.5_dp          !! |z|h² below which exponentials would cancel, and a power series is used
  integer, parameter :: terms = 10

  type, public :: beam_place
    integer :: piece = 1
    type(dd) :: offset                           !! from the middle of the piece, outwards
  end type beam_place

contains

  pure type(beam_place) function place_of(beam, xi) result(place)
    !! Return the piece of a point of the beam; a joint belongs to the piece before it.
    type(piece_beam), intent(in) :: beam
    real(dp), intent(in) :: xi                   !! 0 ≤ ξ ≤ 1
    type(dd) :: joint, gap
    integer :: i
    do i = 1, size(beam%piece)
      joint = joint + beam%piece(i)%length
      gap = joint - to_dd(xi)
      if (gap%hi >= 0.0_dp .or. i == size(beam%piece)) exit
    end do
    place%piece = i
    if (gap%hi < 0.0_dp) gap = dd()              ! beyond the tip by rounding
    place%offset = beam%piece(i)%length*0.5_dp - gap
  end function place_of

  pure function states_inside(piece, frequency, amplitude, offset) result(state)
    !! Return (v, ψ, M, N) at places of one piece, (4, places).
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    real(dp), intent(in) :: amplitude(4)
    type(dd), intent(in) :: offset(:)            !! from the middle of the piece
    real(dp) :: state(4, size(offset))
    type(piece_series) :: series
    real(dp) :: f(series_terms, 8)
    integer :: i
    if (is_short(piece, frequency)) then
      call find_series(piece, frequency, series)
      f = states_of_series(series, amplitude)
      do i = 1, size(offset)
        state(:, i) = polynomial_states(f, offset(i)%hi/piece%half%hi)
      end do
    else
      state = wave_states(piece, frequency, amplitude, offset)
    end if
  end function states_inside

  pure function wave_states(piece, frequency, amplitude, offset) result(state)
    type(piece_numbers), intent(in) :: piece
    type(piece_frequency), intent(in) :: frequency
    real(dp), intent(in) :: amplitude(4)
    type(dd), intent(in) :: offset(:)
    real(dp) :: state(4, size(offset)), values(size(offset), 4)
    real(dp), dimension(size(offset)) :: c, s
    type(wave_numbers) :: waves
    real(dp) :: load, odd
    integer :: j
    waves = wave_numbers_of(piece, frequency)
    load = piece%mass%hi*frequency%lambda%hi
    values = 0.0_dp
    do j = 1, 2
      associate (y => waves%y(j)%hi, z => waves%z(j)%hi, even => amplitude(j), b => piece%stiffness%hi)
        odd = amplitude(j + 2)/sqrt(abs(y))
        if (z*piece%half%hi**2 > small) then
          call find_circular(waves%p(j), offset, c, s)
        else if (-z*piece%half%hi**2 >= small) then
          call find_exponential(waves%p(j)%hi, piece%half, offset, c, s)
        else
          call wave_values(waves%z(j), waves%p(j), piece%half, offset, c, s)
        end if
        values(:, 1) = values(:, 1) + (even*c + (odd*z)*s)
        values(:, 2) = values(:, 2) + y*(odd*c - even*s)
        values(:, 3) = values(:, 3) - (b*y)*(even*c + (odd*z)*s)
        values(:, 4) = values(:, 4) + load*(odd*c - even*s)
      end associate
    end do
    state = transpose(values)
  end function wave_states

  pure subroutine find_exponential(q, half, offset, c, s)
    !! Find C and S over cosh qh of a pair of exponentials at many places.
    real(dp), intent(in) :: q
    type(dd), intent(in) :: half, offset(:)
    real(dp), intent(out) :: c(:), s(:)
    real(dp), parameter :: nothing = 40.0_dp     ! qh above which exponentials of one end vanish beyond the middle
    real(dp) :: scale, middle
    type(dd) :: gap(size(offset))                  ! to the nearer end
    real(dp), dimension(size(offset)) :: near, far
    gap = half - offset*sign(1.0_dp, offset%hi)
    near = exp(-q*gap%hi)
    far = 0.0_dp
    middle = exp(-q*half%hi)
    if (q*half%hi < nothing) far = middle*(middle/near)
    scale = 1.0_dp/(1.0_dp + middle**2)
    c = scale*(near + far)
    s = sign((near - far)*(scale/q), offset%hi)
  end subroutine find_exponential

  pure subroutine find_circular(p, offset, c, s)
    !! Find C and S of a propagating wave at many places. Whole quarter cycles are subtracted in three parts, the first
    !! two exactly.
    type(dd), intent(in) :: p, offset(:)
    real(dp), intent(out) :: c(:), s(:)
    real(dp), parameter :: quarter(3) = [1.570796325802803039550781_dp, 9.920935739593517155299196e-10_dp, &
                                        5.721188726109831840121713e-18_dp]
    real(dp), parameter :: most = 5.0e7_dp         ! quarter cycles, times the 27 bits of a part
    real(dp), dimension(size(offset)) :: angle, low, turns
    type(dd) :: exact(size(offset))
    exact = offset*p
    angle = exact%hi
    low = exact%lo
    if (maxval(abs(angle)) > most) then
      call circular(exact, c, s)
    else
      turns = (angle/quarter(1) + rounder) - rounder
      angle = ((angle - turns*quarter(1)) - turns*quarter(2)) + (low - turns*quarter(3))
      c = cos(angle)
      s = sin(angle)
      call turn_quarters(iand(int(turns), 3), c, s)
    end if
    s = s*(1.0_dp/p%hi)
  end subroutine find_circular

  elemental subroutine turn_quarters(turns, c, s)
    !! Rotate cosine and sine by quarter cycles, without branches.
    integer, intent(in) :: turns                   !! 0 … 3
    real(dp), intent(inout) :: c, s
    real(dp) :: cosine, sine
    cosine = merge(s, c, iand(turns, 1) == 1)
    sine = merge(c, s, iand(turns, 1) == 1)
    c = merge(-cosine, cosine, turns == 1 .or. turns == 2)
    s = merge(-sine, sine, turns >= 2)
  end subroutine turn_quarters

  elemental subroutine wave_values(z, p, half, offset, c, s)
    !! Find C and S at a place, over cosh √(−z)h for z < 0.
    type(dd), intent(in) :: z, p, half, offset
    real(dp), intent(out) :: c, s
    type(dd) :: distance
    real(dp) :: q, x, far, near, whole
    x = offset%hi
    if (abs(z%hi)*half%hi**2 < small) then
      call power_values(z%hi*x**2, x, c, s)
      if (z%hi < 0.0_dp) then
        whole = cosh(p%hi*half%hi)
        c = c/whole
        s = s/whole
      end if
    else if (z%hi > 0.0_dp) then
      call circular(p*offset, c, s)
      s = s/p%hi
    else
      q = p%hi
      distance = half - offset*sign(1.0_dp, x)
      near = exp(-q*distance%hi)
      far = exp(-q*(half%hi + abs(x)))
      whole = 1.0_dp + exp(-2.0_dp*q*half%hi)
      c = (near + far)/whole
      s = sign((near - far)/whole, x)/q
    end if
  end subroutine wave_values

  elemental subroutine power_values(square, x, c, s)
    !! Find cos √z x and sin √z x/√z by power series.
    real(dp), intent(in) :: square               !! zx²
    real(dp), intent(in) :: x
    real(dp), intent(out) :: c, s
    integer :: m
    c = 1.0_dp
    s = 1.0_dp
    do m = terms, 1, -1
      c = 1.0_dp - square*c/real(2*m*(2*m - 1), dp)
      s = 1.0_dp - square*s/real(2*m*(2*m + 1), dp)
    end do
    s = x*s
  end subroutine power_values

end module bw_piece_shape
