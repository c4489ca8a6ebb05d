module bw_line_fit
  !! Lines that share a few bins, fitted to both histories at once (Gauss–Newton on positions, amplitudes eliminated).
  use bw_kinds, only: dp
  use bw_least_squares, only: least_squares
  use bw_line, only: add_lines, amplitude_columns, jacobian, line_type, parts, points, unknowns
  implicit none (type, external)
  private
  public :: fit_lines

  integer, parameter :: max_steps = 12
  integer, parameter :: max_halvings = 3
  real(dp), parameter :: slowest = 0.8_dp         !! a step that gains less is the last
  real(dp), parameter :: negligible = 1.0e-3_dp   !! part of the target at which a fit is complete
  real(dp), parameter :: longest_step = 0.5_dp    !! bins; about what a linearised main lobe bears
  real(dp), parameter :: most_growth = 600        !! e^600 is near overflow

contains

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
    !! Find the amplitudes of least residual at given positions and growths.
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

  function newton_step(lines, count, first, image) result(step)
    !! The Gauss–Newton step of each line's offset (1, :) and growth (2, :).
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: count, first
    complex(dp), intent(in) :: image(first:, :)
    real(dp) :: step(2, size(lines))
    real(dp) :: matrix(2*points*size(image, 1), sum(unknowns(lines)))
    complex(dp) :: left(first:first + size(image, 1) - 1, points)
    real(dp) :: solution(size(matrix, 2), 1)
    integer :: i, last
    left = image
    call add_lines(lines, count, first, left, -1.0_dp, .true.)
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

  elemental subroutine move_line(line, offset, growth, count)
    !! Change a line's offset and growth; what passes 0 or the Nyquist frequency comes back as its mirror image.
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
    !! Move all lines by a step.
    type(line_type), intent(inout) :: lines(:)
    real(dp), intent(in) :: step(:, :)
    integer, intent(in) :: count
    call move_line(lines, step(1, :), step(2, :), count)
  end subroutine move

end module bw_line_fit
