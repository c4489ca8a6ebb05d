module bw_tapered_fit
  !! Lines that share bins of a tapered transform, fitted to all sensors at once by least squares.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_damped_line, only: damped_line, move_line
  use bw_line_projection, only: find_step, project, projected_type
  use bw_tapered_line, only: parts, tapered_columns
  implicit none (type, external)
  private
  public :: fit_band, half_of, reduce, slopes, tapered_band

  integer, parameter :: most_steps = 20, most_halvings = 5
  real(dp), parameter :: settled = 1.0e-6_dp    !! variances of what is left that a step promises to gain: it is the last
  real(dp), parameter :: far_more = 10          !! times the noise, what is left by lines that do not describe a record
  real(dp), parameter :: longest = 1.5_dp       !! step of a decay or a frequency over half the record; half a bin is π/2

  type, public :: band_type
    !! Bins of a tapered transform.
    integer :: count = 0                        !! samples of the record
    integer :: bins(2) = 0                      !! the first and the last
    real(dp), allocatable :: rows(:, :)         !! the image, real parts above imaginary ones, (rows, S)
  end type band_type

  type, extends(projected_type), public :: reduced_type
    !! The triangle of a fit. Columns: two for each line, then two slopes of each line, by real and imaginary part of its exponent:
    !! −decay and 2π·frequency over half the record.
    integer :: lines = 0
    logical, allocatable :: free(:)             !! slopes that are unknowns: not those by what is held, (slopes)
  end type reduced_type

  type, public :: fit_type
    !! Lines fitted to a band.
    type(damped_line), allocatable :: lines(:)
    real(dp) :: left = huge(1.0_dp)             !! squares of the residual over the noise's variance, all sensors
    real(dp) :: slowest = 1                     !! part of that: a step that leaves more of what there was is the last
  end type fit_type

contains

  pure function tapered_band(count, image, first) result(band)
    !! The band of these bins.
    integer, intent(in) :: count                !! samples of the record
    integer, intent(in) :: first
    complex(dp), intent(in) :: image(first:, :) !! (bins, S)
    type(band_type) :: band
    integer :: s
    band%count = count
    band%bins = [first, ubound(image, 1)]
    allocate (band%rows(2*size(image, 1), size(image, 2)))
    do s = 1, size(image, 2)
      band%rows(:, s) = parts(image(:, s))
    end do
  end function tapered_band

  pure real(dp) function half_of(count)
    !! Half the length of a record of so many samples, in steps.
    integer, intent(in) :: count
    half_of = max(count - 1, 1)/2.0_dp
  end function half_of

  subroutine fit_band(band, weight, fit)
    !! Improve decays and frequencies of the lines of a fit until a step gains nothing that noise would notice.
    type(band_type), intent(in) :: band
    real(dp), intent(in) :: weight(:)           !! one over the noise's variance, (S)
    type(fit_type), intent(inout) :: fit
    type(reduced_type) :: now, trial
    type(damped_line), allocatable :: moved(:)
    real(dp) :: step(2*size(fit%lines)), gain, factor, left, left_now
    integer :: i, j
    logical :: slow
    now = reduce(band, fit%lines)
    left_now = sum(weight*now%left)
    do i = 1, most_steps
      if (size(fit%lines) == 0) exit
      call step_of(now, weight, step, gain)
      if (.not. gain > settled*excess(left_now, band%rows)) exit
      factor = min(1.0_dp, longest/maxval(abs(step)))
      do j = 0, most_halvings
        moved = moved_lines(band%count, fit%lines, factor*step)
        trial = reduce(band, moved)
        left = sum(weight*trial%left)
        if (left < left_now) exit
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
  end subroutine fit_band

  pure real(dp) function excess(left, rows)
    !! How many times the noise's variance a row's square is where lines leave far more than noise, and 1 elsewhere: what no lines
    !! describe is not to be described to a part of the noise.
    real(dp), intent(in) :: left                !! squares of what is left over the noise's variance, all sensors
    real(dp), intent(in) :: rows(:, :)
    excess = max(1.0_dp, left/(far_more*size(rows)))
  end function excess

  function reduce(band, lines) result(reduced)
    !! The triangle of the lines' columns, and the image turned by it. There must be more rows than amplitudes.
    type(band_type), intent(in) :: band
    type(damped_line), intent(in) :: lines(:)
    type(reduced_type) :: reduced
    real(dp), allocatable :: matrix(:, :)
    real(dp) :: columns(size(band%rows, 1), 2, 0:1)
    integer :: k, c
    reduced%lines = size(lines)
    allocate (reduced%free(2*size(lines)), matrix(size(band%rows, 1), 4*size(lines)))
    do k = 1, size(lines)
      reduced%free(2*k - 1:2*k) = .not. [lines(k)%steady, lines(k)%fixed]
      columns = tapered_columns(lines(k), band%count, band%bins(1), band%bins(2), 1)
      c = 2*size(lines) + 2*k - 1
      matrix(:, 2*k - 1:2*k) = columns(:, :, 0)
      matrix(:, c:c + 1) = columns(:, :, 1)
    end do
    call project(matrix, band%rows, 2*size(lines), reduced)
  end function reduce

  function slopes(reduced, weight) result(matrix)
    !! The slopes of all sensors by the exponents, those by what is held left out, amplitudes eliminated, (sensors × rows, unknowns).
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
        i = 2*k - 1
        c = reduced%linear + i
        associate (one => reduced%triangle(reduced%linear + 1:, c)*reduced%length(c), &
            & other => reduced%triangle(reduced%linear + 1:, c + 1)*reduced%length(c + 1))
          matrix(row + 1:row + n, i) = a*upper(one, c) + b*upper(other, c + 1)
          matrix(row + 1:row + n, i + 1) = -b*upper(one, c) + a*upper(other, c + 1)
        end associate
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
    real(dp), allocatable :: right(:)
    integer :: s, unknowns
    unknowns = count(reduced%free)
    right = [(reduced%rotated(reduced%linear + 1:, s)*sqrt(weight(s)), s=1, size(weight))]
    call find_step(slopes(reduced, weight), right, step(:unknowns), gain)
    step = unpack(step(:unknowns), reduced%free, 0.0_dp)
  end subroutine step_of

  function moved_lines(count, lines, step) result(moved)
    !! The lines after a step; a frequency that passes 0 or half the sampling rate comes back as its mirror image.
    integer, intent(in) :: count
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: step(:)
    type(damped_line), allocatable :: moved(:)
    integer :: k
    moved = lines
    do k = 1, size(lines)
      call move_line(moved(k), -step(2*k - 1)/half_of(count), step(2*k)/(2*pi*half_of(count)))
      if (moved(k)%frequency <= 0.5_dp) cycle
      moved(k)%frequency = 1 - moved(k)%frequency
      moved(k)%rest = -moved(k)%rest
    end do
  end function moved_lines

end module bw_tapered_fit
