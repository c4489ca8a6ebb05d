module bw_turn
  !! Phases of modes at samples, in cycles, reduced before rounding: whole cycles carry no information. For many evenly spaced
  !! times cosines and sines are products of a few fine and a few coarse angles, for all modes in vector registers.
  use bw_double_double, only: dd, dd_pi, rounder, operator(*)
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: phase_angles, turn_fractions, turn_table

  integer, parameter :: fine = 8          !! fine angles for each coarse one
  real(dp), parameter :: coarse_bits = 1.5_dp*2.0_dp**22   ! its last bit is 2⁻³⁰

contains

  pure function turn_fractions(cycles) result(fraction)
    !! Return cycles less the nearest integer: −½ … ½.
    type(dd), intent(in) :: cycles(:)
    type(dd) :: fraction(size(cycles))
    real(dp), parameter :: most = 2.0_dp**50         ! cycles that `rounder` rounds
    real(dp) :: part, sum
    integer :: k
    do k = 1, size(cycles)
      part = cycles(k)%hi - ((cycles(k)%hi + rounder) - rounder)
      sum = part + cycles(k)%lo
      fraction(k)%hi = sum - ((sum + rounder) - rounder)
      fraction(k)%lo = cycles(k)%lo - (sum - part)     ! exact: `part` is zero or larger
    end do
    do k = 1, size(cycles)
      if (abs(cycles(k)%hi) < most) cycle
      part = cycles(k)%hi - aint(cycles(k)%hi)
      sum = part + cycles(k)%lo
      fraction(k) = dd(sum - anint(sum), cycles(k)%lo - (sum - part))
    end do
  end function turn_fractions

  pure function phase_angles(cycles, sample) result(angle)
    !! Return 2π·cycles·sample modulo 2π, rad.
    type(dd), intent(in) :: cycles(:)        !! per sample
    integer, intent(in) :: sample
    real(dp) :: angle(size(cycles))
    type(dd) :: phase(size(cycles))
    phase = turn_fractions(cycles*real(sample, dp))
    angle = 2.0_dp*dd_pi%hi*(phase%hi + phase%lo)
  end function phase_angles

  pure subroutine turn_table(cycles, first, step, cosine, sine)
    !! Tabulate cos and sin of 2π·cycles·(first + j·step), j = 0, 1, … (at most 2¹⁶).
    !! **Errors**: 5 units in the last place of 1, for two angles rounded near π; relative for sines of small angles.
    type(dd), intent(in) :: cycles(:)                    !! per unit of time, (modes, a few hundred)
    real(dp), intent(in) :: first, step                  !! times: integers in that unit
    real(dp), intent(out), contiguous :: cosine(:, 0:), sine(:, 0:)   !! (modes, times)
    real(dp), dimension(size(cycles), 0:fine - 1) :: c, s
    real(dp), dimension(size(cycles), 0:(size(cosine, 2) - 1)/fine) :: far_c, far_s
    integer :: i, j
    call some_turns(cycles, 0.0_dp, step, c, s)
    call some_turns(cycles, first, fine*step, far_c, far_s)
    do j = 0, size(cosine, 2) - 1
      i = j/fine
      associate (c => c(:, j - i*fine), s => s(:, j - i*fine))
        cosine(:, j) = far_c(:, i)*c - far_s(:, i)*s
        sine(:, j) = far_s(:, i)*c + far_c(:, i)*s
      end associate
    end do
  end subroutine turn_table

  pure subroutine some_turns(cycles, first, step, cosine, sine)
    !! Tabulate the same one by one. The phase step is split so that integer multiples of its larger part are exact.
    type(dd), intent(in) :: cycles(:)
    real(dp), intent(in) :: first, step
    real(dp), intent(out), contiguous :: cosine(:, 0:), sine(:, 0:)
    real(dp), dimension(size(cycles), 0:size(cosine, 2) - 1) :: angle
    real(dp), dimension(size(cycles)) :: start, start_low, turn, turn_low
    integer :: j, k
    call split(turn_fractions(cycles*first), start, start_low)
    call split(turn_fractions(cycles*step), turn, turn_low)
    do j = 0, size(cosine, 2) - 1
      do k = 1, size(cycles)
        angle(k, j) = 2.0_dp*dd_pi%hi*(part_of_turn(start(k) + j*turn(k)) + (start_low(k) + j*turn_low(k)))
      end do
    end do
    call cosines_and_sines(size(angle), angle, cosine, sine)
  end subroutine some_turns

  elemental subroutine split(fraction, large, small)
    !! Split a fraction of a cycle so that integer multiples of its larger part are exact.
    type(dd), intent(in) :: fraction        !! −½ … ½
    real(dp), intent(out) :: large          !! a multiple of 2⁻³⁰
    real(dp), intent(out) :: small          !! remainder
    large = (fraction%hi + coarse_bits) - coarse_bits
    small = (fraction%hi - large) + fraction%lo
  end subroutine split

  elemental real(dp) function part_of_turn(turns) result(part)
    !! Return cycles less the nearest integer.
    real(dp), intent(in) :: turns
    part = turns - aint(turns + sign(0.5_dp, turns))     ! `anint` is a call for every element
  end function part_of_turn

  pure subroutine cosines_and_sines(n, angle, cosine, sine)
    !! Compute cosines and sines in separate loops: a joint call for one angle is not vectorised.
    integer, intent(in) :: n
    real(dp), intent(in) :: angle(n)
    real(dp), intent(out) :: cosine(n), sine(n)
    cosine = cos(angle)
    sine = sin(angle)
  end subroutine cosines_and_sines

end module bw_turn
