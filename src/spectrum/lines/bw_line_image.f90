module bw_line_image
  !! Images of lines in a row of bins, and their slopes.
  use bw_kinds, only: dp
  use bw_line, only: line_row, line_type, mirror_row, points
  implicit none (type, external)
  private
  public :: add_lines, amplitude_columns, jacobian, parts, unknowns

  real(dp), parameter :: difference = 1.0e-4_dp   !! bins; slopes need a few digits only, residuals are exact
  real(dp), parameter :: pi = acos(-1.0_dp)

contains

  elemental integer function unknowns(line)
    !! Real numbers that describe a line.
    type(line_type), intent(in) :: line
    unknowns = 2*points + merge(1, 2, line%steady)
  end function unknowns

  pure function amplitude_columns(line, count, first, bins, shift) result(columns)
    !! Image of a line of amplitude 1 and of amplitude i, real and imaginary parts below each other, (2 bins, 2).
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
    !! Real parts, then imaginary parts.
    complex(dp), intent(in) :: values(:)
    real(dp) :: stacked(2*size(values))
    stacked = [values%re, values%im]
  end function parts

  pure function jacobian(lines, count, first, bins) result(matrix)
    !! Slopes of both images with respect to each line's amplitudes (re, im, re, im), offset and growth.
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
    !! Slopes of both images with respect to offset and growth. An image is analytic in growth + 2πi offset, so
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
    !! Add factor times the images of the lines.
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

end module bw_line_image
