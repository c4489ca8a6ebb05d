module bw_line
  !! One spectral line in two histories: a tone that may grow or decay, and its images in time and in frequency.
  !!
  !! The history at point p is Re c_p exp(2πi (bin + offset) j/N + growth (j/N − r)), j = 0 … N−1, with r = 1 for a
  !! line that grows and 0 for others, so that |c_p| is its peak. Whole bins and the offset are kept apart: phases
  !! lose nothing to the size of the frequency.
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: line_position, line_row, subtract_line, sidelobe
  public :: add_lines, amplitude_columns, jacobian, parts, unknowns

  integer, parameter, public :: points = 2   !! tip and midpoint, in this order
  real(dp), parameter, public :: main_lobe = 10/32.0_dp  !! mean of the window sin⁶(πj/N)
  real(dp), parameter, public :: resolution = 1  !! periods in the record; closer lines are one
  real(dp), parameter :: difference = 1.0e-4_dp  !! bins; slopes need a few digits only, residuals are exact
  integer, parameter :: block = 256          !! samples between two rotations of the coefficient
  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: window(-3:3) = [-1, 6, -15, 20, -15, 6, -1]/64.0_dp  !! sin⁶(πj/N) as a row of bins

  type, public :: line_type
    integer :: bin = 0                       !! nearest whole number of periods in the record, 0 … N/2
    real(dp) :: offset = 0                   !! periods beyond `bin`
    real(dp) :: growth = 0                   !! logarithm of the growth over the record, 0 for a steady tone
    complex(dp) :: amplitude(points) = 0     !! c_p, in the unit of the record
    logical :: steady = .true.               !! growth is held at 0
    real(dp) :: position_error = 0           !! bound on the error of bin + offset
    real(dp) :: strength_error = 0           !! bound on the error of both amplitudes' length
    real(dp) :: ratio = 0                    !! signed ratio midpoint to tip
    real(dp) :: ratio_error = 0              !! bound on its error, huge if it does not exist
    real(dp) :: hidden = 0                   !! part of it that a line hidden beside it may be
    logical :: doubtful = .true.             !! there may well be such a line
  end type line_type

contains

  elemental real(dp) function line_position(line)
    !! The position of a line is the number of its periods in the record.
    type(line_type), intent(in) :: line
    line_position = line%bin + line%offset
  end function line_position

  pure function line_row(line, count, first, last, shift, windowed) result(row)
    !! The Fourier transform of a line of amplitude 1, without its mirror image, at the bins first … last.
    type(line_type), intent(in) :: line
    integer, intent(in) :: count             !! N
    integer, intent(in) :: first, last       !! bins
    real(dp), intent(in) :: shift            !! added to the line's offset
    logical, intent(in) :: windowed          !! by sin⁶(πj/N)
    complex(dp) :: row(first:last)
    row = transform(line%bin, line%offset + shift, line%growth, count, first, last, windowed)
  end function line_row

  pure function mirror_row(line, count, first, last, shift, windowed) result(row)
    !! The same transform of the line's mirror image at negative frequency.
    type(line_type), intent(in) :: line
    integer, intent(in) :: count, first, last
    real(dp), intent(in) :: shift
    logical, intent(in) :: windowed
    complex(dp) :: row(first:last)
    row = transform(-line%bin, -line%offset - shift, line%growth, count, first, last, windowed)
  end function mirror_row

  pure function transform(bin, offset, growth, count, first, last, windowed) result(row)
    !! The geometric sum Σ_j w_j exp((growth + 2πi (bin − m + offset)) j/N − max(growth, 0)) at the bins m = first … last.
    integer, intent(in) :: bin, count, first, last
    real(dp), intent(in) :: offset, growth
    logical, intent(in) :: windowed
    complex(dp) :: row(first:last)
    complex(dp) :: plain(first - 3:last + 3), numerator, denominator
    integer :: m, away
    if (growth > 0) then
      numerator = -exp(cmplx(0, 2*pi*offset, dp))*exp_less_one(cmplx(-growth, -2*pi*offset, dp))
    else
      numerator = exp_less_one(cmplx(growth, 2*pi*offset, dp))
    end if
    do m = first - 3, last + 3
      away = modulo(bin - m + count/2, count) - count/2
      denominator = exp_less_one(cmplx(growth, 2*pi*(away + offset), dp)/count)
      if (abs(denominator) > 0) then
        plain(m) = numerator/denominator
      else
        plain(m) = count
      end if
    end do
    if (.not. windowed) then
      row = plain(first:last)
    else
      do m = first, last
        row(m) = sum(window*plain(m - 3:m + 3))
      end do
    end if
  end function transform

  pure complex(dp) function exp_less_one(z)
    !! The number e^z − 1, without cancellation near 0.
    complex(dp), intent(in) :: z
    real(dp) :: half, growth
    half = sin(z%im/2)
    if (abs(z%re) < 1) then
      growth = 2*exp(z%re/2)*sinh(z%re/2)
    else
      growth = exp(z%re) - 1
    end if
    exp_less_one = cmplx(growth*cos(z%im) - 2*half*half, exp(z%re)*sin(z%im), dp)
  end function exp_less_one

  pure subroutine subtract_line(line, record)
    !! Take the line out of both histories, (N, points). The tone is tabulated over one block, and its coefficient
    !! turned from block to block: no error builds up along the record.
    type(line_type), intent(in) :: line
    real(dp), intent(inout) :: record(0:, :)
    real(dp) :: tone(0:block - 1, 2)
    complex(dp) :: start
    integer :: j, p, count, length
    count = size(record, 1)
    do j = 0, min(block, count) - 1
      start = turn(line, j, count)
      tone(j, :) = [start%re, start%im]
    end do
    do j = 0, count - 1, block
      length = min(block, count - j)
      do p = 1, points
        start = line%amplitude(p)*turn(line, j, count)*exp(-max(line%growth, 0.0_dp))
        record(j:j + length - 1, p) = record(j:j + length - 1, p) &
          & - (start%re*tone(:length - 1, 1) - start%im*tone(:length - 1, 2))
      end do
    end do
  end subroutine subtract_line

  pure complex(dp) function turn(line, j, count)
    !! The factor exp(2πi (bin + offset) j/N + growth j/N) of sample j; whole periods are subtracted before anything is rounded.
    type(line_type), intent(in) :: line
    integer, intent(in) :: j, count
    integer(i8) :: part
    part = modulo(int(line%bin, i8)*j, int(count, i8))
    if (2*part > count) part = part - count
    turn = exp(line%growth*j/count)*exp(cmplx(0, 2*pi*(part + line%offset*j)/count, dp))
  end function turn

  elemental real(dp) function sidelobe(distance)
    !! The largest leakage of a steady line through the window at that distance, relative to the line's peak.
    real(dp), intent(in) :: distance         !! bins, of either sign
    real(dp) :: d
    d = abs(distance)
    sidelobe = 1
    if (d >= 4) sidelobe = 36/(pi*d*(d*d - 1)*(d*d - 4)*(d*d - 9))
  end function sidelobe

  elemental integer function unknowns(line)
    !! How many real numbers describe a line: two amplitudes, its position, and its growth unless it is steady.
    type(line_type), intent(in) :: line
    unknowns = 2*points + merge(1, 2, line%steady)
  end function unknowns

  pure function amplitude_columns(line, count, first, bins, shift) result(columns)
    !! The windowed images of a line of amplitude 1 and of amplitude i, with imaginary parts below real ones, (2 bins, 2).
    type(line_type), intent(in) :: line
    integer, intent(in) :: count, first, bins
    real(dp), intent(in) :: shift
    real(dp) :: columns(2*bins, 2)
    complex(dp) :: row(bins), mirror(bins)
    row = line_row(line, count, first, first + bins - 1, shift, .true.)/2
    mirror = mirror_row(line, count, first, first + bins - 1, shift, .true.)/2
    columns(:, 1) = parts(row + mirror)
    columns(:, 2) = parts((0, 1)*(row - mirror))
  end function amplitude_columns

  pure function parts(values) result(stacked)
    !! The real parts of an image, followed by its imaginary parts.
    complex(dp), intent(in) :: values(:)
    real(dp) :: stacked(2*size(values))
    stacked = [values%re, values%im]
  end function parts

  pure function jacobian(lines, count, first, bins) result(matrix)
    !! The slopes of both histories' images with respect to each line's amplitudes (re, im, re, im), offset and growth.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: count, first, bins
    real(dp) :: matrix(2*points*bins, sum(unknowns(lines)))
    integer :: i, p, last
    matrix = 0
    last = 0
    do i = 1, size(lines)
      do p = 1, points
        matrix(2*bins*(p - 1) + 1:2*bins*p, last + 2*p - 1:last + 2*p) = &
          & amplitude_columns(lines(i), count, first, bins, 0.0_dp)
      end do
      call position_columns(lines(i), count, first, bins, matrix(:, last + 2*points + 1:last + unknowns(lines(i))))
      last = last + unknowns(lines(i))
    end do
  end function jacobian

  pure subroutine position_columns(line, count, first, bins, columns)
    !! Find the slopes of both images with respect to offset and growth. An image is analytic in growth + 2πi offset, so
    !! that the slope by growth is the slope by offset over 2πi, and over −2πi for the mirror image.
    type(line_type), intent(in) :: line
    integer, intent(in) :: count, first, bins
    real(dp), intent(inout) :: columns(:, :)
    complex(dp) :: row(bins), mirror(bins)
    integer :: p, last
    last = first + bins - 1
    row = (line_row(line, count, first, last, difference, .true.) &
      & - line_row(line, count, first, last, -difference, .true.))/(4*difference)
    mirror = (mirror_row(line, count, first, last, difference, .true.) &
      & - mirror_row(line, count, first, last, -difference, .true.))/(4*difference)
    do p = 1, points
      associate (c => line%amplitude(p), rows => columns(2*bins*(p - 1) + 1:2*bins*p, :))
        rows(:, 1) = parts(c*row + conjg(c)*mirror)
        if (.not. line%steady) rows(:, 2) = parts((c*row - conjg(c)*mirror)/cmplx(0, 2*pi, dp))
      end associate
    end do
  end subroutine position_columns

  pure subroutine add_lines(lines, count, first, image, factor, windowed)
    !! Add the images of the lines, multiplied by the factor, to an image of both histories.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: count, first
    complex(dp), intent(inout) :: image(first:, :)
    real(dp), intent(in) :: factor
    logical, intent(in) :: windowed
    complex(dp) :: row(size(image, 1)), mirror(size(image, 1))
    integer :: i, p, last
    last = first + size(image, 1) - 1
    do i = 1, size(lines)
      row = line_row(lines(i), count, first, last, 0.0_dp, windowed)*(factor/2)
      mirror = mirror_row(lines(i), count, first, last, 0.0_dp, windowed)*(factor/2)
      do p = 1, points
        image(:, p) = image(:, p) + lines(i)%amplitude(p)*row + conjg(lines(i)%amplitude(p))*mirror
      end do
    end do
  end subroutine add_lines

end module bw_line
