module bw_drift
  !! Lines whose frequency and decay change over the record: e^(pu + b₂u² + …) instead of e^(pu), u = −1 … 1 over the record.
  !!
  !! At a fitted line the slope by b₂ is the line's image times u², so that b₂, its covariance and what it gains are one linear
  !! step. At the time u decay and frequency differ from those in the middle by 2b₂u + 3b₃u² + ….
  use bw_band_fit, only: fit_band, fit_type, reduce, reduced_type, slopes
  use bw_damped_line, only: damped_line, most_powers
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band
  use bw_samples, only: samples_type
  use bw_triangle, only: dependent, triangulate
  implicit none (type, external)
  private
  public :: drift_gain, drift_of, drift_taken

  type, public :: drift_type
    !! The exponent of a line by powers of u, without the constant, two real numbers each: −decay and 2π·frequency over half the
    !! record, less those fitted, then the bend. (2 powers)
    real(dp), allocatable :: value(:)
    real(dp), allocatable :: covariance(:, :)
    real(dp) :: gain = 0                       !! of powers that are not fitted yet: of noise, the sum of two squares of normal
                                               !! numbers for each
  end type drift_type

contains

  real(dp) function drift_gain(samples, band, rows, weight, lines, j) result(gain)
    !! What one more power in the exponent of line j takes off the weighted squares, to first order.
    type(samples_type), intent(in) :: samples
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: rows(:, :), weight(:)
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: j
    type(drift_type) :: drift
    gain = 0
    if (lines(j)%powers == most_powers) return
    drift = drift_of(samples, band, rows, weight, lines, j, lines(j)%powers + 1)
    gain = drift%gain
  end function drift_gain

  real(dp) function drift_taken(samples, band, rows, weight, lines, j) result(taken)
    !! What the drift of line j has taken off the weighted squares.
    type(samples_type), intent(in) :: samples
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: rows(:, :), weight(:)
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: j
    type(fit_type) :: fit, steady
    fit%lines = lines
    steady%lines = lines
    steady%lines(j)%powers = 1
    call fit_band(samples, band%band, rows, weight, band%with_still, fit)
    call fit_band(samples, band%band, rows, weight, band%with_still, steady)
    taken = steady%left - fit%left
  end function drift_taken

  function drift_of(samples, band, rows, weight, lines, j, powers) result(drift)
    !! The drift of line j up to a power of time, all lines of the band being free.
    type(samples_type), intent(in) :: samples
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: rows(:, :)         !! without the lines that are not the band's
    real(dp), intent(in) :: weight(:)
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: j, powers
    type(drift_type) :: drift
    type(reduced_type) :: reduced
    real(dp), allocatable, dimension(:, :) :: matrix, right, triangle, turned, inverse
    real(dp), allocatable :: length(:), beyond(:)
    integer :: s, n, k, first
    reduced = reduce(samples, band%band, rows, [lines(:j - 1), lines(j + 1:), lines(j)], band%with_still, &
      & [lines(:j - 1)%powers, lines(j + 1:)%powers, powers])
    n = size(reduced%length) - reduced%linear
    first = reduced%first(size(lines))
    matrix = slopes(reduced, weight)
    allocate (right(size(matrix, 1), 1))
    do s = 1, size(weight)
      right((s - 1)*n + 1:s*n, 1) = reduced%rotated(reduced%linear + 1:, s)*sqrt(weight(s))
    end do
    length = max(norm2(matrix, dim=1), tiny(1.0_dp))
    do k = 1, n
      matrix(:, k) = matrix(:, k)/length(k)
    end do
    call triangulate(matrix, right, triangle, turned, beyond)
    inverse = inverted(triangle(first:n, first:n))
    do k = first, n
      inverse(k - first + 1, :) = inverse(k - first + 1, :)/length(k)
    end do
    drift%value = matmul(inverse, turned(first:n, 1))
    do k = 2, lines(j)%powers
      drift%value(2*k - 1:2*k) = drift%value(2*k - 1:2*k) + [lines(j)%bend(k)%re, lines(j)%bend(k)%im]
    end do
    drift%covariance = matmul(inverse, transpose(inverse))
    drift%gain = sum(turned(first + 2*lines(j)%powers:n, 1)**2)
  end function drift_of

  pure function inverted(triangle) result(inverse)
    !! The inverse of an upper triangle; a column that depends on others has none, and gets a huge number.
    real(dp), intent(in) :: triangle(:, :)
    real(dp) :: inverse(size(triangle, 1), size(triangle, 1)), pivot
    integer :: i, j
    inverse = 0
    do j = 1, size(triangle, 1)
      do i = j, 1, -1
        pivot = sign(max(abs(triangle(i, i)), dependent), triangle(i, i))
        inverse(i, j) = (merge(1.0_dp, 0.0_dp, i == j) - dot_product(triangle(i, i + 1:j), inverse(i + 1:j, j)))/pivot
      end do
    end do
  end function inverted

end module bw_drift
