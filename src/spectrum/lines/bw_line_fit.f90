module bw_line_fit
  !! Lines that share a few bins, fitted to both histories at once (Gauss–Newton on positions, amplitudes eliminated).
  use bw_kinds, only: dp
  use bw_lapack, only: dgelsy, dgeqrf
  use bw_line, only: add_lines, amplitude_columns, jacobian, line_type, parts, points, unknowns
  implicit none (type, external)
  private
  public :: fit_lines, least_squares, factorise, gradient_length

  integer, parameter :: max_steps = 12
  integer, parameter :: max_halvings = 3
  real(dp), parameter :: slowest = 0.8_dp         !! a step that gains less is the last
  real(dp), parameter :: negligible = 1.0e-3_dp   !! part of the target at which a fit is complete
  real(dp), parameter :: longest_step = 0.5_dp    !! bins; about what a linearised main lobe bears
  real(dp), parameter :: most_growth = 600        !! e^600 is near overflow

  real(dp), parameter :: dependent = 1.0e-13_dp   !! columns this close to the others are left out of a solution

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


  function least_squares(matrix, right) result(solution)
    !! The shortest x that makes |matrix x − right| least, with columns scaled to length 1 first; (n, right sides).
    real(dp), intent(in) :: matrix(:, :)     !! (m, n)
    real(dp), intent(in) :: right(:, :)      !! (m, right sides)
    real(dp) :: solution(size(matrix, 2), size(right, 2))
    real(dp) :: a(size(matrix, 1), size(matrix, 2)), b(max(size(matrix, 1), size(matrix, 2)), size(right, 2))
    real(dp) :: length(size(matrix, 2)), work(64*(sum(shape(matrix)) + size(right, 2)))
    integer :: pivot(size(matrix, 2)), rank, info, i
    length = column_lengths(matrix)
    do i = 1, size(a, 2)
      a(:, i) = matrix(:, i)/length(i)
    end do
    b = 0
    b(:size(matrix, 1), :) = right
    pivot = 0
    work = 0
    call dgelsy(size(a, 1), size(a, 2), size(b, 2), a, size(a, 1), b, size(b, 1), pivot, dependent, rank, &
      & work, size(work), info)
    do i = 1, size(b, 2)
      solution(:, i) = b(:size(a, 2), i)/length
    end do
  end function least_squares

  pure function column_lengths(matrix) result(length)
    !! The Euclidean length of each column, 1 for a column of zeros.
    real(dp), intent(in) :: matrix(:, :)
    real(dp) :: length(size(matrix, 2))
    length = norm2(matrix, dim=1)
    where (length == 0) length = 1
  end function column_lengths

  subroutine factorise(matrix, triangle, length)
    !! Find the triangle R of matrix·diag(1/length) = QR, which gives the covariance of a fit.
    real(dp), intent(in) :: matrix(:, :)     !! (m, n), m ≥ n
    real(dp), intent(out) :: triangle(:, :)  !! (n, n), its upper part
    real(dp), intent(out) :: length(:)       !! lengths of the columns, (n)
    real(dp) :: a(size(matrix, 1), size(matrix, 2)), tau(size(matrix, 2)), work(64*size(matrix, 2))
    integer :: info, i
    length = column_lengths(matrix)
    do i = 1, size(a, 2)
      a(:, i) = matrix(:, i)/length(i)
    end do
    work = 0
    tau = 0
    call dgeqrf(size(a, 1), size(a, 2), a, size(a, 1), tau, work, size(work), info)
    triangle = a(:size(a, 2), :)
  end subroutine factorise

  pure real(dp) function gradient_length(triangle, length, gradient)
    !! The standard deviation of gradient·x where the right side has noise of standard deviation 1, |R⁻ᵀ (gradient/length)|.
    !! It is huge if the fit does not determine that number.
    real(dp), intent(in) :: triangle(:, :), length(:)  !! from `factorise`
    real(dp), intent(in) :: gradient(:)
    real(dp) :: y(size(gradient))
    integer :: i
    gradient_length = huge(1.0_dp)
    do i = 1, size(y)
      y(i) = gradient(i)/length(i) - dot_product(triangle(:i - 1, i), y(:i - 1))
      if (abs(triangle(i, i)) > dependent) then
        y(i) = y(i)/triangle(i, i)
      else if (abs(y(i)) > dependent) then
        return
      else
        y(i) = 0
      end if
    end do
    gradient_length = norm2(y)
  end function gradient_length

end module bw_line_fit
