module bw_band_fit
  !! Lines that share a band, fitted to all sensors at once by least squares: variable projection (Golub and Pereyra, 1973).
  !!
  !! Given decays and frequencies, everything else is linear. One triangle R of [columns of amplitudes, columns of slopes] and
  !! the rotated record hold the whole fit: what is left, the Gauss–Newton step, and the covariance, since all sensors share the
  !! columns. The triangle of its slopes is that of Re(JᴴΣ⁻¹J) with the amplitudes eliminated, from which the Cramér–Rao bounds
  !! follow for noise of each sensor's level.
  use bw_kinds, only: dp
  use bw_band, only: band_type, line_columns, still_columns
  use bw_damped_line, only: bend_reach, damped_line, move_line
  use bw_lapack, only: dgelsy
  use bw_samples, only: centre_of, samples_type, span_of
  use bw_triangle, only: dependent, length_of, scaled, solved, triangulate
  implicit none (type, external)
  private
  public :: excess, fit_band, image_of, reduce, slopes, still_image

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: most_steps = 20, most_halvings = 5
  real(dp), parameter :: settled = 1.0e-6_dp    !! variances of what is left that a step promises to gain: it is the last
  real(dp), parameter :: far_more = 10          !! times the noise, what is left by lines that do not describe a record
  real(dp), parameter :: longest = 1.5_dp       !! step of a decay or a frequency over half the record; half a bin is π/2
  real(dp), parameter :: farthest = 3           !! half widths of a band from its middle; its sums see nothing beyond 32
  real(dp), parameter, public :: widest_drift = 25  !! of −decay and 2π·frequency over half the record; one bin is π

  type, public :: reduced_type
    !! The triangle of a fit. Columns: two for each line, two of offset and slope or none, then two slopes for each power of each
    !! line, real and imaginary part of its coefficient in the exponent: −decay and 2π·frequency over half the record, then bends.
    !! Where they are more than the rows, the triangle has as many rows as there are.
    integer :: lines = 0, linear = 0            !! linear: columns of amplitudes, offset and slope
    integer, allocatable :: first(:)            !! slope of each line, counted among slopes from 1, and one after all, (lines + 1)
    logical, allocatable :: free(:)             !! slopes that are unknowns: not those by what is held, (slopes)
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
    real(dp) :: slowest = 1                     !! part of that: a step that leaves more of what there was is the last
    real(dp) :: work = 0                        !! numbers of lines' images that this and earlier fits have computed
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
    logical :: slow
    now = reduce(samples, band, rows, fit%lines, with_still)
    fit%work = fit%work + size(rows, 1)*real(now%linear + size(now%free), dp)
    left_now = sum(weight*now%left)
    do i = 1, most_steps
      if (size(fit%lines) == 0) exit
      call step_of(now, weight, step, gain)
      if (.not. gain > settled*excess(left_now, rows)) exit
      factor = min(1.0_dp, longest/maxval(abs(step)))
      do j = 0, most_halvings
        moved = moved_lines(samples, fit%lines, factor*step)
        trial = reduce(samples, band, rows, moved, with_still)
        fit%work = fit%work + size(rows, 1)*real(now%linear + size(now%free), dp)
        left = sum(weight*trial%left)
        if (left < left_now .and. all(is_held(samples, band, moved))) exit
        factor = factor/4
      end do
      if (j > most_halvings) exit
      fit%lines = moved
      now = trial
      slow = left > fit%slowest*left_now
      left_now = left
      if (slow) exit
    end do
    fit%left = left_now
    do i = 1, size(fit%lines)
      fit%lines(i)%amplitude = cmplx(now%linear_part(2*i - 1, :), now%linear_part(2*i, :), dp)
    end do
    if (with_still) fit%still = now%linear_part(now%linear - 1:, :)
  end subroutine fit_band

  pure real(dp) function excess(left, rows)
    !! How many times the noise's variance a row's square is where lines leave far more than noise, and 1 elsewhere: what no lines
    !! describe is not to be described to a part of the noise.
    real(dp), intent(in) :: left                !! squares of what is left over the noise's variance, all sensors
    real(dp), intent(in) :: rows(:, :)
    excess = max(1.0_dp, left/(far_more*size(rows)))
  end function excess

  elemental logical function is_held(samples, band, line)
    !! Whether a line is where a band's sums see it, and these are enough for its drift.
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    type(damped_line), intent(in) :: line
    is_held = band%tapered
    if (is_held) return
    is_held = abs(bend_reach(line, centre_of(samples))) <= widest_drift
    if (size(band%turn) < band%blocks%first(size(band%turn) + 1) - band%blocks%first(1)) is_held = is_held .and. &
      & (abs(line%frequency - band%centre) + abs(line%decay)/(2*pi))*span_of(samples) < farthest*band%half_width
  end function is_held

  function reduce(samples, band, rows, lines, with_still, powers) result(reduced)
    !! The triangle of the lines' columns, and the record turned by it. There must be more rows than amplitudes.
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    real(dp), intent(in) :: rows(:, :)
    type(damped_line), intent(in) :: lines(:)
    logical, intent(in) :: with_still
    integer, intent(in), optional :: powers(:)  !! of time by which each line has slopes: its own if absent, 0 for none
    type(reduced_type) :: reduced
    real(dp), allocatable :: matrix(:, :), columns(:, :, :)
    integer :: highest(size(lines)), k, m, n, c
    highest = lines%powers
    if (present(powers)) highest = powers
    reduced%lines = size(lines)
    reduced%linear = 2*size(lines) + merge(2, 0, with_still)
    reduced%first = [(1 + 2*sum(highest(:k - 1)), k=1, size(lines) + 1)]
    n = reduced%linear + 2*sum(highest)
    allocate (reduced%free(2*sum(highest)), source=.true.)
    do k = 1, size(lines)
      if (highest(k) > 0) reduced%free(reduced%first(k):reduced%first(k) + 1) = .not. [lines(k)%steady, lines(k)%fixed]
    end do
    allocate (matrix(size(rows, 1), n))
    do k = 1, size(lines)
      allocate (columns(size(rows, 1), 2, 0:highest(k)))
      columns(:, :, :) = line_columns(samples, band, lines(k), highest(k))
      matrix(:, 2*k - 1:2*k) = columns(:, :, 0)
      do m = 1, highest(k)
        c = reduced%linear + reduced%first(k) + 2*(m - 1)
        matrix(:, c:c + 1) = columns(:, :, m)
      end do
      deallocate (columns)
    end do
    if (with_still) matrix(:, reduced%linear - 1:reduced%linear) = still_columns(samples, band)
    reduced%length = [(length_of(matrix(:, k)), k=1, n)]
    where (reduced%length <= 0) reduced%length = 1
    do k = 1, n
      matrix(:, k) = matrix(:, k)/reduced%length(k)
    end do
    call triangulate(matrix, rows, reduced%triangle, reduced%rotated, reduced%left)
    associate (triangle => reduced%triangle(:reduced%linear, :reduced%linear))
      reduced%linear_part = solved(triangle, reduced%rotated(:reduced%linear, :))
      reduced%left = reduced%left + sum(reduced%rotated(reduced%linear + 1:, :)**2, dim=1)
      do k = 1, reduced%linear                  ! where the triangle does not determine a number, something stays
        if (abs(triangle(k, k)) > dependent) cycle
        reduced%left = reduced%left + (reduced%rotated(k, :) - matmul(triangle(k, k:), reduced%linear_part(k:, :)))**2
      end do
    end associate
    do k = 1, reduced%linear
      reduced%linear_part(k, :) = reduced%linear_part(k, :)/reduced%length(k)
    end do
  end function reduce

  function slopes(reduced, weight) result(matrix)
    !! The slopes of all sensors by the coefficients in the exponents, those by what is held left out, amplitudes, offset and
    !! slope eliminated, (sensors × rows, unknowns).
    type(reduced_type), intent(in) :: reduced
    real(dp), intent(in) :: weight(:)
    real(dp), allocatable :: matrix(:, :)
    real(dp) :: a, b
    integer :: s, k, n, row, i, c
    n = size(reduced%triangle, 1) - reduced%linear
    allocate (matrix(size(weight)*n, size(reduced%free)))
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
    if (.not. all(reduced%free)) matrix = matrix(:, pack([(c, c=1, size(matrix, 2))], reduced%free))

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
    real(dp), allocatable :: matrix(:, :), factors(:, :), right(:, :), length(:), work(:)
    integer, allocatable :: pivot(:)
    integer :: rank, info, s, n
    n = size(reduced%triangle, 1) - reduced%linear
    matrix = slopes(reduced, weight)
    length = scaled(matrix)
    allocate (right(max(size(matrix, 1), size(matrix, 2)), 1), work(64*(sum(shape(matrix)) + 1)))
    right = 0
    do s = 1, size(weight)
      right((s - 1)*n + 1:s*n, 1) = reduced%rotated(reduced%linear + 1:, s)*sqrt(weight(s))
    end do
    allocate (pivot(size(matrix, 2)), source=0)
    factors = matrix
    call dgelsy(size(matrix, 1), size(matrix, 2), 1, factors, size(matrix, 1), right, size(right, 1), pivot, dependent, rank, &
      & work, size(work), info)
    gain = norm2(matmul(matrix, right(:size(matrix, 2), 1)))**2
    step = unpack(right(:size(matrix, 2), 1)/length, reduced%free, 0.0_dp)
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
      do m = 2, lines(k)%powers
        moved(k)%bend(m) = lines(k)%bend(m) + cmplx(step(i + 2*m - 2), step(i + 2*m - 1), dp)
      end do
      call move_line(moved(k), -step(i)/half, step(i + 1)/(2*pi*half))
      i = i + 2*lines(k)%powers
      if (allocated(samples%place) .or. moved(k)%frequency <= 0.5_dp) cycle
      moved(k)%frequency = 1 - moved(k)%frequency
      moved(k)%rest = -moved(k)%rest
      moved(k)%bend = conjg(moved(k)%bend)
    end do
  end function moved_lines

  function image_of(samples, band, line) result(image)
    !! The rows of one line at all sensors, (rows, S).
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    type(damped_line), intent(in) :: line
    real(dp) :: image(size(band%rows, 1), size(band%rows, 2)), columns(size(band%rows, 1), 2, 0:0)
    integer :: s
    columns = line_columns(samples, band, line, 0)
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
