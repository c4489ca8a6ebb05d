module bw_line_errors
  !! What noise makes of fitted lines.
  use bw_kinds, only: dp
  use bw_least_squares, only: factorise, gradient_length
  use bw_line, only: line_type, points
  use bw_line_image, only: jacobian, unknowns
  implicit none (type, external)
  private
  public :: line_errors

contains

  subroutine line_errors(lines, count, first, bins, noise)
    !! Errors of position and ratio that noise of this standard deviation (per real number of an image) makes; the
    !! ratio itself; what breaks the rule that both histories of a mode are in phase counts as an error of the ratio.
    type(line_type), intent(inout) :: lines(:)
    integer, intent(in) :: count, first, bins
    real(dp), intent(in) :: noise
    real(dp), allocatable :: matrix(:, :), triangle(:, :), length(:), gradient(:)
    integer :: i, last
    allocate (matrix, source=jacobian(lines, count, first, bins))
    lines%position_error = huge(1.0_dp)
    lines%strength_error = huge(1.0_dp)
    lines%ratio_error = huge(1.0_dp)
    if (size(matrix, 1) < size(matrix, 2)) return
    allocate (triangle(size(matrix, 2), size(matrix, 2)), length(size(matrix, 2)), gradient(size(matrix, 2)))
    call factorise(matrix, triangle, length)
    last = 0
    do i = 1, size(lines)
      gradient = 0
      gradient(last + 2*points + 1) = 1
      lines(i)%position_error = noise_times(gradient_length(triangle, length, gradient), noise)
      gradient(last + 2*points + 1) = 0
      gradient(last + 1:last + 2*points) = direction(lines(i)%amplitude)
      lines(i)%strength_error = noise_times(gradient_length(triangle, length, gradient), noise)
      if (abs(lines(i)%amplitude(1)) > 0) then
        call ratio_of(lines(i)%amplitude, lines(i)%ratio, gradient(last + 1:last + 2*points))
        lines(i)%ratio_error = noise_times(gradient_length(triangle, length, gradient), noise)
      end if
      last = last + unknowns(lines(i))
    end do
  end subroutine line_errors

  pure function direction(amplitude) result(gradient)
    !! Slopes of both amplitudes' length with respect to their real and imaginary parts.
    complex(dp), intent(in) :: amplitude(:)
    real(dp) :: gradient(2*points)
    gradient = [amplitude(1)%re, amplitude(1)%im, amplitude(2)%re, amplitude(2)%im]
    gradient = gradient/max(norm2(gradient), tiny(1.0_dp))
  end function direction

  elemental real(dp) function noise_times(factor, noise)
    !! factor·noise, huge if the factor is.
    real(dp), intent(in) :: factor, noise
    noise_times = huge(1.0_dp)
    if (factor < sqrt(huge(1.0_dp))) noise_times = factor*noise
  end function noise_times

  pure subroutine ratio_of(amplitude, ratio, gradient)
    !! R = Re(c₂/c₁), and its slopes with respect to Re c₁, Im c₁, Re c₂, Im c₂.
    complex(dp), intent(in) :: amplitude(:)
    real(dp), intent(out) :: ratio, gradient(:)
    complex(dp) :: inverse, slope
    inverse = 1/amplitude(1)
    ratio = real(amplitude(2)*inverse, dp)
    slope = -amplitude(2)*inverse*inverse
    gradient = [slope%re, -slope%im, inverse%re, -inverse%im]
  end subroutine ratio_of

end module bw_line_errors
