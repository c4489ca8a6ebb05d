module bw_damped_line
  !! One line of a record, common to all sensors: an oscillation that may decay or grow.
  !!
  !! A frequency is kept as two numbers, the second below the rounding of the first, so that the phase at a record's end loses
  !! nothing to the number of periods before it.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: line_in_record, move_line, place_in_bins, position_of, strength_of, subtract_lines

  real(dp), parameter :: grain = 2.0_dp**26      !! a frequency of so many bits times a number of samples is exact
  integer, parameter :: table = 256              !! samples between two turns of a line's coefficient
  real(dp), parameter :: most_decay = 2.5_dp     !! per step, of either sign; the table must not overflow

  type, public :: damped_line
    !! The motion Re A_s e^(−dτ + 2πifτ) at sensor s, τ counting steps from the first sample.
    real(dp) :: decay = 0                        !! d, per step; negative grows
    real(dp) :: frequency = 0                    !! f, periods per step, rounded
    complex(dp), allocatable :: amplitude(:)     !! A_s at the record's first sample, or at its last for a line that grows, (S)
    real(dp) :: rest = 0                         !! of f, below the rounding of `frequency`
    logical :: steady = .false.                  !! the decay is held, of a steady line at 0
    logical :: fixed = .false.                   !! the frequency is held
  end type damped_line

contains

  elemental subroutine place_in_bins(line, count, bin, offset)
    !! The frequency as whole periods in a record of so many samples and what is beyond them, each to rounding.
    type(damped_line), intent(in) :: line
    integer, intent(in) :: count
    integer, intent(out) :: bin
    real(dp), intent(out) :: offset              !! −½ … ½
    real(dp) :: coarse, fine
    coarse = anint(line%frequency*grain)/grain
    fine = (line%frequency - coarse)*count + line%rest*count
    bin = nint(coarse*count + fine)
    offset = (coarse*count - bin) + fine
  end subroutine place_in_bins

  elemental real(dp) function position_of(line, count) result(position)
    !! How many periods of a line are in a record of so many samples.
    type(damped_line), intent(in) :: line
    integer, intent(in) :: count
    integer :: bin
    call place_in_bins(line, count, bin, position)
    position = bin + position
  end function position_of

  pure type(damped_line) function line_in_record(bin, offset, growth, count) result(line)
    !! A line without amplitude of so many periods in a record, and that logarithm of its growth over it.
    integer, intent(in) :: bin, count
    real(dp), intent(in) :: offset, growth
    real(dp) :: away
    integer :: nearest
    line%frequency = real(bin, dp)/count
    call place_in_bins(line, count, nearest, away)
    call move_line(line, -growth/count, (offset - away)/count)
  end function line_in_record

  elemental subroutine move_line(line, decay, frequency)
    !! Change decay and frequency by so much per step. A frequency that passes 0 is its mirror image's.
    type(damped_line), intent(inout) :: line
    real(dp), intent(in) :: decay, frequency
    real(dp) :: before, added
    line%decay = max(-most_decay, min(most_decay, line%decay + decay))
    before = line%frequency
    line%frequency = before + frequency
    added = line%frequency - before
    line%rest = line%rest + ((before - (line%frequency - added)) + (frequency - added))
    if (line%frequency < 0) line%rest = -line%rest
    line%frequency = abs(line%frequency)
  end subroutine move_line

  elemental real(dp) function strength_of(line) result(strength)
    !! The amplitudes of all sensors together; it is never 0.
    type(damped_line), intent(in) :: line
    strength = sqrt(tiny(1.0_dp))
    if (allocated(line%amplitude)) strength = max(strength, norm2(abs(line%amplitude)))
  end function strength_of

  pure subroutine subtract_lines(lines, s, left)
    !! Take lines out of the even samples of sensor s, (N). A line is tabulated over one block, and its coefficient turned from
    !! block to block: no error builds up along the record.
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: s
    real(dp), intent(inout) :: left(:)
    complex(dp) :: tone(0:table - 1), factor
    real(dp) :: start
    integer :: k, n, l, length, longest
    tone = 0
    longest = min(table, size(left))
    do k = 1, size(lines)
      tone(:longest - 1) = [(exp(-lines(k)%decay*l)*phase_factor(lines(k)%frequency, l, lines(k)%rest), l=0, longest - 1)]
      start = min(lines(k)%decay, 0.0_dp)*max(size(left) - 1, 1)
      do n = 0, size(left) - 1, longest
        length = min(longest, size(left) - n)
        factor = lines(k)%amplitude(s)*exp(start - lines(k)%decay*n)*phase_factor(lines(k)%frequency, n, lines(k)%rest)
        associate (part => left(n + 1:n + length))
          part = part - (factor%re*tone(:length - 1)%re - factor%im*tone(:length - 1)%im)
        end associate
      end do
    end do
  end subroutine subtract_lines

  elemental complex(dp) function phase_factor(frequency, n, rest)
    !! The factor e^(2πi·frequency·n); whole periods are taken off before anything is rounded.
    real(dp), intent(in) :: frequency        !! periods per step, below 1
    integer, intent(in) :: n                 !! below 2²⁶
    real(dp), intent(in) :: rest             !! of the frequency, below its rounding
    real(dp) :: coarse, periods
    coarse = anint(frequency*grain)/grain
    periods = coarse*n
    periods = periods - anint(periods) + (frequency - coarse)*n
    periods = periods + rest*n
    phase_factor = exp(cmplx(0, 2*pi*periods, dp))
  end function phase_factor

end module bw_damped_line
