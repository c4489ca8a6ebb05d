module bw_band_fit
  !! Lines that share a band, fitted to all sensors at once by least squares: variable projection (Golub and Pereyra, 1973).
  !!
  !! Given decays and frequencies, everything else is linear. One triangle R of [columns of amplitudes, columns of slopes] and
  !! the rotated record hold the whole fit: what is left, the Gauss–Newton step, and the covariance, since all sensors share the
  !! columns. The covariance of decays and frequencies is the inverse of Re(JᴴΣ⁻¹J) with the amplitudes eliminated: the
  !! Cramér–Rao bound for noise of each sensor's level.
  use bw_kinds, only: dp
  use bw_band, only: band_type, line_columns, still_columns
  use bw_lapack, only: dgelsy, dgeqrf, dormqr
  use bw_samples, only: centre_of, samples_type
  implicit none (type, external)
  private
  public :: fit_band, image_of, position_covariance, reduce, slopes, still_image

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: most_steps = 40, most_halvings = 5
  real(dp), parameter :: settled = 1.0e-6_dp    !! variances of the noise that a step promises to gain: it is the last
  real(dp), parameter :: longest = 1.5_dp       !! step of a decay or a frequency over half the record; half a bin is π/2
  real(dp), parameter :: dependent = 1.0e-12_dp !! columns this close to the others are left out of a solution

  integer, parameter, public :: most_powers = 6 !! of time in the exponent of a line

  type, public :: damped_line
    !! The motion Re A_s e^(−dτ + 2πifτ) at sensor s, or of one that drifts Re A_s e^(−dτ + 2πifτ + b₂u² + b₃u³ + …).
    real(dp) :: decay = 0                       !! d, per step; negative grows. In the middle of the record if the line drifts
    real(dp) :: frequency = 0                   !! f, periods per step. As well
    complex(dp), allocatable :: amplitude(:)    !! A_s at the record's first sample, or at its last for a line that grows, (S)
    integer :: powers = 1                       !! of u, time from the middle over half the record, in the exponent; 1: no drift
    complex(dp) :: bend(2:most_powers) = 0      !! b
  end type damped_line

  type, public :: reduced_type
    !! The triangle of a fit. Columns: two for each line, two of offset and slope or none, then two slopes for each power of each
    !! line, real and imaginary part of its coefficient in the exponent: −decay and 2π·frequency over half the record, then bends.
    integer :: lines = 0, linear = 0            !! linear: columns of amplitudes, offset and slope
    integer, allocatable :: first(:)            !! slope of each line, counted among slopes from 1, and one after all, (lines + 1)
    real(dp), allocatable :: triangle(:, :)     !! R of the columns scaled to length 1
    real(dp), allocatable :: length(:)          !! of the columns
    real(dp), allocatable :: rotated(:, :)      !! Qᵀ of the record, (columns, S)
    real(dp), allocatable :: linear_part(:, :)  !! amplitudes, offsets and slopes, (linear, S)
    real(dp), allocatable :: left(:)            !! squares of what the linear part leaves, (S)
  end type reduced_type

  type, public :: fit_type
    !! Lines fitted to a band.
    type(damped_line), allocatable :: lines(:)
    real(dp), allocatable :: still(:, :)        !! offset and slope, (2, S), where they have been fitted
    real(dp) :: left = huge(1.0_dp)             !! squares of what is left over the noise's variance, all sensors
  end type fit_type

contains

  subroutine fit_band(samples, band, rows, weight, with_still, fit)
    !! Improve decays and frequencies of the lines of a fit until a step gains nothing that noise would notice.
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    real(dp), intent(in) :: rows(:, :)          !! the band's rows without all other lines, (rows, S)
    real(dp), intent(in) :: weight(:)           !! one over the noise's variance, (S)
    logical, intent(in) :: with_still           !! offset and slope belong to the fit
    type(fit_type), intent(inout) :: fit
    type(reduced_type) :: now, trial
    type(damped_line), allocatable :: moved(:)
    real(dp) :: step(2*sum(fit%lines%powers)), gain, factor, left, left_now
    integer :: i, j
    now = reduce(samples, band, rows, fit%lines, with_still)
    left_now = sum(weight*now%left)
    do i = 1, most_steps
      if (size(fit%lines) == 0) exit
      call step_of(now, weight, step, gain)
      if (.not. gain > settled) exit
      factor = min(1.0_dp, longest/maxval(abs(step)))
      do j = 0, most_halvings
        moved = moved_lines(samples, fit%lines, factor*step)
        trial = reduce(samples, band, rows, moved, with_still)
        left = sum(weight*trial%left)
        if (left < left_now) exit
        factor = factor/4
      end do
      if (left >= left_now) exit
      fit%lines = moved
      now = trial
      left_now = left
    end do
    fit%left = left_now
    do i = 1, size(fit%lines)
      fit%lines(i)%amplitude = cmplx(now%linear_part(2*i - 1, :), now%linear_part(2*i, :), dp)
    end do
    if (with_still) fit%still = now%linear_part(now%linear - 1:, :)
  end subroutine fit_band

  function reduce(samples, band, rows, lines, with_still, powers) result(reduced)
    !! The triangle of the lines' columns, and the record turned by it. There must be more rows than columns.
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    real(dp), intent(in) :: rows(:, :)
    type(damped_line), intent(in) :: lines(:)
    logical, intent(in) :: with_still
    integer, intent(in), optional :: powers(:)  !! of time by which each line has slopes: its own if absent, 0 for none
    type(reduced_type) :: reduced
    real(dp), allocatable :: matrix(:, :), turned(:, :), tau(:), work(:), columns(:, :, :)
    integer :: highest(size(lines)), k, m, n, c, info
    highest = lines%powers
    if (present(powers)) highest = powers
    reduced%lines = size(lines)
    reduced%linear = 2*size(lines) + merge(2, 0, with_still)
    reduced%first = [(1 + 2*sum(highest(:k - 1)), k=1, size(lines) + 1)]
    n = reduced%linear + 2*sum(highest)
    allocate (matrix(size(rows, 1), n), tau(n), work(64*max(n, size(rows, 2), 1)))
    do k = 1, size(lines)
      allocate (columns(size(rows, 1), 2, 0:highest(k)))
      columns(:, :, :) = line_columns(samples, band, lines(k)%decay, lines(k)%frequency, highest(k), &
        & lines(k)%bend(:lines(k)%powers))
      matrix(:, 2*k - 1:2*k) = columns(:, :, 0)
      do m = 1, highest(k)
        c = reduced%linear + reduced%first(k) + 2*(m - 1)
        matrix(:, c:c + 1) = columns(:, :, m)
      end do
      deallocate (columns)
    end do
    if (with_still) matrix(:, reduced%linear - 1:reduced%linear) = still_columns(samples, band)
    reduced%length = norm2(matrix, dim=1)
    where (reduced%length <= 0) reduced%length = 1
    do k = 1, n
      matrix(:, k) = matrix(:, k)/reduced%length(k)
    end do
    turned = rows
    if (n > 0) then
      call dgeqrf(size(matrix, 1), n, matrix, size(matrix, 1), tau, work, size(work), info)
      call dormqr('L', 'T', size(rows, 1), size(rows, 2), n, matrix, size(matrix, 1), tau, turned, size(rows, 1), &
        & work, size(work), info)
    end if
    reduced%triangle = matrix(:n, :)
    reduced%rotated = turned(:n, :)
    reduced%left = sum(turned(reduced%linear + 1:, :)**2, dim=1)
    reduced%linear_part = solved(reduced%triangle(:reduced%linear, :reduced%linear), reduced%rotated(:reduced%linear, :))
    do k = 1, reduced%linear
      reduced%linear_part(k, :) = reduced%linear_part(k, :)/reduced%length(k)
    end do
  end function reduce

  pure function solved(triangle, right) result(x)
    !! R⁻¹ of the right sides; what R does not determine is 0.
    real(dp), intent(in) :: triangle(:, :), right(:, :)
    real(dp) :: x(size(right, 1), size(right, 2))
    integer :: i, j
    do j = 1, size(right, 2)
      do i = size(right, 1), 1, -1
        x(i, j) = right(i, j) - dot_product(triangle(i, i + 1:size(right, 1)), x(i + 1:, j))
        if (abs(triangle(i, i)) > dependent) then
          x(i, j) = x(i, j)/triangle(i, i)
        else
          x(i, j) = 0
        end if
      end do
    end do
  end function solved

  function slopes(reduced, weight) result(matrix)
    !! The slopes of all sensors by the coefficients in the exponents, amplitudes, offset and slope eliminated,
    !! (sensors × slopes, slopes).
    type(reduced_type), intent(in) :: reduced
    real(dp), intent(in) :: weight(:)
    real(dp), allocatable :: matrix(:, :)
    real(dp) :: a, b
    integer :: s, k, n, row, i, c
    n = size(reduced%length) - reduced%linear
    allocate (matrix(size(weight)*n, n))
    do s = 1, size(weight)
      row = (s - 1)*n
      do k = 1, reduced%lines
        a = reduced%linear_part(2*k - 1, s)*sqrt(weight(s))
        b = reduced%linear_part(2*k, s)*sqrt(weight(s))
        do i = reduced%first(k), reduced%first(k + 1) - 1, 2
          c = reduced%linear + i
          associate (one => reduced%triangle(reduced%linear + 1:, c)*reduced%length(c), &
              & other => reduced%triangle(reduced%linear + 1:, c + 1)*reduced%length(c + 1))
            matrix(row + 1:row + n, i) = a*upper(one, c) + b*upper(other, c + 1)
            matrix(row + 1:row + n, i + 1) = -b*upper(one, c) + a*upper(other, c + 1)
          end associate
        end do
      end do
    end do

  contains

    pure function upper(column, c)
      !! What lies below the diagonal of R is not its own.
      real(dp), intent(in) :: column(:)
      integer, intent(in) :: c
      real(dp) :: upper(size(column))
      upper = column
      upper(c - reduced%linear + 1:) = 0
    end function upper

  end function slopes

  subroutine step_of(reduced, weight, step, gain)
    !! The Gauss–Newton step of the coefficients in the exponents, and what it promises to take off the weighted squares.
    type(reduced_type), intent(in) :: reduced
    real(dp), intent(in) :: weight(:)
    real(dp), intent(out) :: step(:), gain
    real(dp), allocatable :: matrix(:, :), factors(:, :), right(:, :), work(:)
    integer :: pivot(size(step)), rank, info, s, n
    n = size(reduced%length) - reduced%linear
    matrix = slopes(reduced, weight)
    allocate (right(size(matrix, 1), 1), work(64*(sum(shape(matrix)) + 1)))
    do s = 1, size(weight)
      right((s - 1)*n + 1:s*n, 1) = reduced%rotated(reduced%linear + 1:, s)*sqrt(weight(s))
    end do
    pivot = 0
    factors = matrix
    call dgelsy(size(matrix, 1), size(matrix, 2), 1, factors, size(matrix, 1), right, size(right, 1), pivot, dependent, rank, &
      & work, size(work), info)
    step = right(:size(step), 1)
    gain = norm2(matmul(matrix, step))**2
  end subroutine step_of

  function moved_lines(samples, lines, step) result(moved)
    !! The lines after a step; a frequency that passes 0 or half the sampling rate comes back as its mirror image.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: step(:)
    type(damped_line), allocatable :: moved(:)
    real(dp) :: half
    integer :: k, m, i
    half = centre_of(samples)
    moved = lines
    i = 1
    do k = 1, size(lines)
      moved(k)%decay = lines(k)%decay - step(i)/half
      moved(k)%frequency = lines(k)%frequency + step(i + 1)/(2*pi*half)
      do m = 2, lines(k)%powers
        moved(k)%bend(m) = lines(k)%bend(m) + cmplx(step(i + 2*m - 2), step(i + 2*m - 1), dp)
      end do
      i = i + 2*lines(k)%powers
      if (moved(k)%frequency < 0) call mirror(0.0_dp)
      if (moved(k)%frequency > 0.5_dp .and. .not. allocated(samples%place)) call mirror(1.0_dp)
    end do

  contains

    subroutine mirror(whole)
      !! The conjugate line; the amplitude follows from the fit.
      real(dp), intent(in) :: whole
      moved(k)%frequency = whole - moved(k)%frequency
      moved(k)%bend = conjg(moved(k)%bend)
    end subroutine mirror

  end function moved_lines

  function position_covariance(reduced, weight) result(covariance)
    !! The covariance of the coefficients in the exponents, in noise of the variances 1/weight, (slopes, slopes).
    type(reduced_type), intent(in) :: reduced
    real(dp), intent(in) :: weight(:)
    real(dp), allocatable :: covariance(:, :)
    real(dp), allocatable :: matrix(:, :), tau(:), work(:), length(:), inverse(:, :)
    integer :: info, i, n
    n = size(reduced%length) - reduced%linear
    matrix = slopes(reduced, weight)
    allocate (tau(n), work(64*n), inverse(n, n))
    length = max(norm2(matrix, dim=1), tiny(1.0_dp))
    do i = 1, n
      matrix(:, i) = matrix(:, i)/length(i)
    end do
    call dgeqrf(size(matrix, 1), n, matrix, size(matrix, 1), tau, work, size(work), info)
    inverse = 0
    do i = 1, n
      inverse(i, i) = 1
    end do
    inverse = solved(matrix(:n, :n), inverse)
    do i = 1, n
      inverse(i, :) = inverse(i, :)/length(i)
    end do
    covariance = matmul(inverse, transpose(inverse))
  end function position_covariance

  function image_of(samples, band, line) result(image)
    !! The rows of one line at all sensors, (rows, S).
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    type(damped_line), intent(in) :: line
    real(dp) :: image(size(band%rows, 1), size(band%rows, 2)), columns(size(band%rows, 1), 2, 0:0)
    integer :: s
    columns = line_columns(samples, band, line%decay, line%frequency, 0, line%bend(:line%powers))
    do s = 1, size(image, 2)
      image(:, s) = line%amplitude(s)%re*columns(:, 1, 0) + line%amplitude(s)%im*columns(:, 2, 0)
    end do
  end function image_of

  function still_image(samples, band, still) result(image)
    !! The rows of offset and slope at all sensors, (rows, S).
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    real(dp), intent(in) :: still(:, :)         !! (2, S)
    real(dp) :: image(size(band%rows, 1), size(band%rows, 2))
    image = matmul(still_columns(samples, band), still)
  end function still_image

end module bw_band_fit
