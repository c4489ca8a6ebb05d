module bw_line_fit
  !! Lines that share a few bins, fitted to both histories at once (Gauss–Newton on positions, amplitudes eliminated).
  use bw_kinds, only: dp
  use bw_least_squares, only: factorise, gradient_length, least_squares
  use bw_line, only: line_position, line_row, line_type, mirror_row, points
  implicit none (type, external)
  private
  public :: add_lines, fit_lines, fit_amplitudes, line_errors, unknowns

  integer, parameter :: max_steps = 12
  integer, parameter :: max_halvings = 3
  real(dp), parameter :: slowest = 0.8_dp         !! a step that gains less is the last
  real(dp), parameter :: negligible = 1.0e-3_dp   !! part of the target at which a fit is complete
  real(dp), parameter :: difference = 1.0e-4_dp   !! bins; slopes need a few digits only, the residual is exact
  real(dp), parameter :: longest_step = 0.5_dp    !! bins; about what a linearised main lobe bears
  real(dp), parameter :: most_growth = 600        !! e^600 is near overflow
  real(dp), parameter :: pi = acos(-1.0_dp)

contains

  elemental integer function unknowns(line)
    !! Real numbers that describe a line.
    type(line_type), intent(in) :: line
    unknowns = 2*points + merge(1, 2, line%steady)
  end function unknowns

  subroutine fit_lines(lines, count, first, image, target_residual, residual)
    !! Improve positions, growths and amplitudes until the residual stops falling.
    type(line_type), intent(inout) :: lines(:)
    integer, intent(in) :: count                  !! samples in the record
    integer, intent(in) :: first                  !! first bin of `image`
    complex(dp), intent(in) :: image(first:, :)   !! windowed transform of these lines alone, (bins, points)
    real(dp), intent(in) :: target_residual       !! small enough
    real(dp), intent(out) :: residual             !! Euclidean length of what is left
    type(line_type) :: trial(size(lines))
    real(dp) :: step(2, size(lines)), trial_residual, factor
    integer :: i, j
    logical :: slow
    call fit_amplitudes(lines, count, first, image, residual)
    do i = 1, max_steps
      step = newton_step(lines, count, first, image)
      factor = min(1.0_dp, longest_step/max(maxval(abs(step(1, :))), tiny(1.0_dp)))
      do j = 0, max_halvings
        trial = lines
        call move(trial, factor*step, count)
        call fit_amplitudes(trial, count, first, image, trial_residual)
        if (trial_residual < residual) exit
        factor = factor/4
      end do
      if (trial_residual >= residual) exit
      lines = trial
      slow = trial_residual > slowest*residual
      residual = trial_residual
      if (slow .or. residual < negligible*target_residual) exit
    end do
  end subroutine fit_lines

  subroutine fit_amplitudes(lines, count, first, image, residual)
    !! Linear least squares for the amplitudes at given positions.
    type(line_type), intent(inout) :: lines(:)
    integer, intent(in) :: count, first
    complex(dp), intent(in) :: image(first:, :)
    real(dp), intent(out) :: residual
    real(dp) :: matrix(2*size(image, 1), 2*size(lines)), right(2*size(image, 1), points)
    real(dp) :: solution(2*size(lines), points)
    integer :: i, p
    do i = 1, size(lines)
      matrix(:, 2*i - 1:2*i) = amplitude_columns(lines(i), count, first, size(image, 1), 0.0_dp)
    end do
    do p = 1, points
      right(:, p) = parts(image(:, p))
    end do
    solution = least_squares(matrix, right)
    residual = norm2(right - matmul(matrix, solution))
    do p = 1, points
      lines%amplitude(p) = cmplx(solution(1::2, p), solution(2::2, p), dp)
    end do
  end subroutine fit_amplitudes

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
    complex(dp), intent(in) :: values(:)
    real(dp) :: stacked(2*size(values))
    stacked = [values%re, values%im]
  end function parts

  function newton_step(lines, count, first, image) result(step)
    !! Change of offset (1, :) and of growth (2, :).
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: count, first
    complex(dp), intent(in) :: image(first:, :)
    real(dp) :: step(2, size(lines))
    real(dp) :: matrix(2*points*size(image, 1), sum(unknowns(lines)))
    complex(dp) :: left(first:first + size(image, 1) - 1, points)
    real(dp) :: solution(size(matrix, 2), 1)
    integer :: i, last
    left = image
    call add_lines(lines, count, first, left, -1.0_dp)
    matrix = jacobian(lines, count, first, size(image, 1))
    solution = least_squares(matrix, reshape([parts(left(:, 1)), parts(left(:, 2))], [size(matrix, 1), 1]))
    step = 0
    last = 0
    do i = 1, size(lines)
      step(1, i) = solution(last + 2*points + 1, 1)
      if (.not. lines(i)%steady) step(2, i) = solution(last + 2*points + 2, 1)
      last = last + unknowns(lines(i))
    end do
  end function newton_step

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
    !! Slopes of both images with respect to offset and growth. An image is analytic in growth + 2πi offset, so that the
    !! slope with respect to growth is that with respect to the offset over 2πi (over −2πi for the mirror image).
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

  elemental subroutine move_line(line, offset, growth, count)
    type(line_type), intent(inout) :: line
    real(dp), intent(in) :: offset, growth
    integer, intent(in) :: count
    integer :: whole
    line%growth = max(-most_growth, min(most_growth, line%growth + growth))
    line%offset = line%offset + offset
    whole = nint(line%offset)
    line%bin = line%bin + whole
    line%offset = line%offset - whole
    if (line%bin + line%offset < 0) then        ! past 0: the mirror image is the line
      line%bin = -line%bin
      line%offset = -line%offset
    else if (line%bin > count - line%bin) then  ! past the Nyquist frequency likewise
      line%bin = count - line%bin
      line%offset = -line%offset
    end if
  end subroutine move_line

  pure subroutine move(lines, step, count)
    type(line_type), intent(inout) :: lines(:)
    real(dp), intent(in) :: step(:, :)
    integer, intent(in) :: count
    call move_line(lines, step(1, :), step(2, :), count)
  end subroutine move

  pure subroutine add_lines(lines, count, first, image, factor)
    !! Add factor times the windowed images of the lines.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: count, first
    complex(dp), intent(inout) :: image(first:, :)
    real(dp), intent(in) :: factor
    complex(dp) :: row(size(image, 1)), mirror(size(image, 1))
    integer :: i, p, last
    last = first + size(image, 1) - 1
    do i = 1, size(lines)
      row = line_row(lines(i), count, first, last, 0.0_dp, .true.)*(factor/2)
      mirror = mirror_row(lines(i), count, first, last, 0.0_dp, .true.)*(factor/2)
      do p = 1, points
        image(:, p) = image(:, p) + lines(i)%amplitude(p)*row + conjg(lines(i)%amplitude(p))*mirror
      end do
    end do
  end subroutine add_lines

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

end module bw_line_fit
