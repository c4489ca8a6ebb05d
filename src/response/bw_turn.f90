module bw_turn
  !! Phases of modes at samples, in turns, reduced before they are rounded: whole turns carry no information, however
  !! many there are.
  use bw_kinds, only: dp
  use bw_double_double, only: dd, dd_pi, operator(*)
  implicit none (type, external)
  private
  public :: phase_angles, turn_fractions, turns

contains

  pure function turn_fractions(cycles) result(fraction)
    !! Cycles less the nearest whole number: −½ … ½.
    type(dd), intent(in) :: cycles(:)
    type(dd) :: fraction(size(cycles))
    real(dp) :: part, sum
    integer :: k
    do k = 1, size(cycles)
      part = cycles(k)%hi - aint(cycles(k)%hi)
      sum = part + cycles(k)%lo
      fraction(k)%hi = sum - aint(sum + sign(0.5_dp, sum))
      fraction(k)%lo = cycles(k)%lo - (sum - part)     ! exact: `part` is zero or larger than what it is added to
    end do
  end function turn_fractions

  pure function phase_angles(cycles, sample) result(angle)
    !! 2π·cycles·sample less whole turns, rad.
    type(dd), intent(in) :: cycles(:)        !! turns per sample
    integer, intent(in) :: sample
    real(dp) :: angle(size(cycles))
    type(dd) :: phase(size(cycles))
    phase = turn_fractions(cycles*real(sample, dp))
    angle = 2.0_dp*dd_pi%hi*(phase%hi + phase%lo)
  end function phase_angles

  pure subroutine turns(cycles, first, step, cosine, sine)
    !! cos and sin of 2π·cycles·(first + j·step), j = 0, 1, …: products of a few fine turns and a few coarse ones.
    !! **Errors**: 3 units in the last place of 1.
    type(dd), intent(in) :: cycles                   !! turns per sample
    integer, intent(in) :: first, step               !! samples
    real(dp), intent(out) :: cosine(0:), sine(0:)
    real(dp), dimension(0:nint(sqrt(real(size(cosine), dp)))) :: c, s
    real(dp) :: angle, cosine_far, sine_far
    integer :: i, j, fine, last
    fine = size(c)
    do j = 0, fine - 1
      angle = angle_at(cycles, j*step)
      c(j) = cos(angle)
      s(j) = sin(angle)
    end do
    do i = 0, size(cosine) - 1, fine
      angle = angle_at(cycles, first + i*step)
      cosine_far = cos(angle)
      sine_far = sin(angle)
      last = min(i + fine, size(cosine)) - 1
      cosine(i:last) = cosine_far*c(:last - i) - sine_far*s(:last - i)
      sine(i:last) = sine_far*c(:last - i) + cosine_far*s(:last - i)
    end do
  end subroutine turns

  pure real(dp) function angle_at(cycles, sample) result(angle)
    !! 2π·cycles·sample less whole turns, rad.
    type(dd), intent(in) :: cycles
    integer, intent(in) :: sample
    type(dd) :: phase
    real(dp) :: part, sum
    phase = cycles*real(sample, dp)
    part = phase%hi - aint(phase%hi)
    sum = part + phase%lo
    angle = 2.0_dp*dd_pi%hi*((sum - aint(sum + sign(0.5_dp, sum))) + (phase%lo - (sum - part)))
  end function angle_at

end module bw_turn
