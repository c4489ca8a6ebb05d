module bw_damped_line
  !! One line of a record, common to all sensors: an oscillation that may decay or grow.
  !!
  !! A frequency is kept as two numbers, the second below the rounding of the first, so that the phase at a record's end loses
  !! nothing to the number of periods before it.
  use bw_kinds, only: dp
  use bw_samples, only: bent_factor, bent_series, centre_of, find_wave, grain, phase_factor, samples_type
  implicit none (type, external)
  private
  public :: add_uneven, bend_reach, cancels, line_in_record, move_line, overlap, place_in_bins, position_of, strength_of
  public :: subtract_lines

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter, public :: same_peak = 1.5_dp  !! bins from a line, where it is tried as two before a further one is
  integer, parameter :: table = 256              !! samples between two turns of a line's coefficient
  real(dp), parameter :: most_cancelled = 30     !! amplitude, of the record's highest sample: equal lines 1/200 bin apart
  real(dp), parameter :: gone = 5                !! e-folds below its largest amplitude, where a line that drifts has ended
  real(dp), parameter :: most_decay = 2.5_dp     !! per step, of either sign; the table must not overflow

  integer, parameter :: tables_of_bend = 1024    !! in which a record is cut where a line drifts
  integer, parameter, public :: most_powers = 6

  type, public :: damped_line
    !! The motion Re A_s e^(−dτ + 2πifτ) at sensor s, or Re A_s e^(−dτ + 2πifτ + b₂u² + b₃u³ + …) of one that drifts, u = −1 … 1.
    real(dp) :: decay = 0                        !! d, per step; negative grows. That in the record's middle if the line drifts
    real(dp) :: frequency = 0                    !! f, periods per step, rounded. As well
    complex(dp), allocatable :: amplitude(:)     !! A_s at the record's first sample, or at its last for a line that grows, (S)
    real(dp) :: rest = 0                         !! of f, below the rounding of `frequency`
    logical :: steady = .false.                  !! the decay is held, of a steady line at 0
    logical :: fixed = .false.                   !! the frequency is held
    integer :: powers = 1                        !! of u in the exponent; 1: no drift
    complex(dp) :: bend(2:most_powers) = 0       !! b
    real(dp) :: sought = -1                      !! frequency of the peak that it was first taken for; negative: none
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
    if (line%frequency < 0) line%bend = conjg(line%bend)
    line%frequency = abs(line%frequency)
  end subroutine move_line

  elemental complex(dp) function bend_reach(line, centre) result(reach)
    !! The largest change of −decay, and of 2π·frequency, over half the record, that a drift makes from the record's middle anywhere
    !! in the line's life. Where it is gone its powers of time are free, and say nothing.
    type(damped_line), intent(in) :: line
    real(dp), intent(in) :: centre               !! half of the record, in steps
    integer, parameter :: looks = 16
    complex(dp) :: rate(-looks:looks)
    real(dp) :: height(-looks:looks), u
    integer :: i, m
    reach = 0
    if (line%powers < 2) return
    do i = -looks, looks
      u = real(i, dp)/looks
      rate(i) = sum([(m*line%bend(m)*u**(m - 1), m=2, line%powers)])
      height(i) = real(sum([(line%bend(m)*u**m, m=2, line%powers)]), dp) - line%decay*centre*u
    end do
    reach = cmplx(maxval(abs(rate%re), mask=height > maxval(height) - gone), &
      & maxval(abs(rate%im), mask=height > maxval(height) - gone), dp)
  end function bend_reach

  elemental logical function cancels(line, highest)
    !! Whether a line is so much larger than the record that only its difference from others is in it: a sum that fits anything slow.
    type(damped_line), intent(in) :: line
    real(dp), intent(in) :: highest              !! of the samples, as the length of a vector of all sensors
    cancels = strength_of(line)*abs(bent_factor(line%bend(:line%powers), sign(1.0_dp, -line%decay))) > most_cancelled*highest
  end function cancels

  elemental logical function overlap(line, other, span)
    !! Whether two lines share a peak: they are within a bin and a half, or within half their widths at half their power.
    type(damped_line), intent(in) :: line, other
    real(dp), intent(in) :: span                 !! of the record, in steps
    overlap = abs(line%frequency - other%frequency) < same_peak/span + (abs(line%decay) + abs(other%decay))/(2*pi)
  end function overlap

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
    do k = 1, size(lines)
      longest = min(table, size(left))
      if (lines(k)%powers > 1) longest = max(1, min(table, size(left)/tables_of_bend))
      tone(:longest - 1) = [(exp(-lines(k)%decay*l)*phase_factor(lines(k)%frequency, l, lines(k)%rest), l=0, longest - 1)]
      start = min(lines(k)%decay, 0.0_dp)*max(size(left) - 1, 1)
      do n = 0, size(left) - 1, longest
        length = min(longest, size(left) - n)
        factor = lines(k)%amplitude(s)*exp(start - lines(k)%decay*n)*phase_factor(lines(k)%frequency, n, lines(k)%rest)
        associate (part => left(n + 1:n + length))
          if (lines(k)%powers > 1) then
            part = part - real(factor*tone(:length - 1)*bent_tone(lines(k), n, length, size(left)), dp)
          else
            part = part - (factor%re*tone(:length - 1)%re - factor%im*tone(:length - 1)%im)
          end if
        end associate
      end do
    end do
  end subroutine subtract_lines

  pure subroutine add_uneven(samples, lines, first, factor, value)
    !! Add the motion of lines at uneven times, times a factor, to values of some sensors. Sections of the record are short enough
    !! for a processor to have them at hand.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: first                 !! of the sensors
    real(dp), intent(in) :: factor
    real(dp), intent(inout) :: value(:, :)       !! (N, sensors)
    real(dp), dimension(table) :: along, across
    real(dp) :: centre
    integer :: n, last, length, k, s
    centre = centre_of(samples)
    do n = 1, samples%count, table
      last = min(n + table - 1, samples%count)
      length = last - n + 1
      do k = 1, size(lines)
        call find_wave(samples%place(n:last), centre, lines(k)%decay, lines(k)%frequency, lines(k)%bend(:lines(k)%powers), &
          & along(:length), across(:length))
        do s = 1, size(value, 2)
          associate (a => factor*lines(k)%amplitude(first + s - 1))
            value(n:last, s) = value(n:last, s) + (a%re*along(:length) - a%im*across(:length))
          end associate
        end do
      end do
    end do
  end subroutine add_uneven

  pure function bent_tone(line, start, length, count) result(factor)
    !! The factors of a line's bend at some of the even samples.
    type(damped_line), intent(in) :: line
    integer, intent(in) :: start, length, count  !! samples before these, these, in the record
    complex(dp), allocatable :: a(:, :)
    complex(dp) :: factor(length)
    real(dp) :: centre
    integer :: l, m
    centre = max(count - 1, 1)/2.0_dp
    associate (bend => line%bend(:line%powers), u => (start - centre)/centre)
      a = bent_series(bend, [u])*bent_factor(bend, u)
    end associate
    factor = a(1, size(a))
    do m = size(a) - 1, 1, -1
      factor = factor*[((l - 1)/centre, l=1, length)] + a(1, m)
    end do
  end function bent_tone

end module bw_damped_line
