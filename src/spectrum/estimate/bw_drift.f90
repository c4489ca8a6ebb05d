module bw_drift
  !! Lines whose frequency and decay change over the record: e^(pu + gu²) instead of e^(pu), u = −1 … 1 over the record.
  !!
  !! At a fitted line the slope by g is the line's image times u², so that g, its covariance and what it gains are one linear
  !! step. At the time u decay and frequency differ from the fitted ones by the step of p and by 2gu.
  use bw_band_fit, only: damped_line, reduce, reduced_type, slopes
  use bw_kinds, only: dp
  use bw_lapack, only: dgeqrf, dormqr
  use bw_line_bands, only: line_band
  use bw_samples, only: samples_type
  implicit none (type, external)
  private
  public :: drift_gain, drift_of

  real(dp), parameter :: dependent = 1.0e-12_dp

  type, public :: drift_type
    !! −decay and 2π·frequency over half the record, and their drifts g: the step that brings them in, and its covariance.
    real(dp) :: step(4) = 0
    real(dp) :: covariance(4, 4) = 0
    real(dp) :: gain = 0                       !! of the drifts alone: without any, the sum of two squares of normal numbers
  end type drift_type

contains

  real(dp) function drift_gain(samples, band, rows, weight, lines, j) result(gain)
    !! What a drift of line j's frequency alone takes off the weighted squares. (One of its decay is what a close pair looks like.)
    type(samples_type), intent(in) :: samples
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: rows(:, :), weight(:)
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: j
    type(drift_type) :: drift
    drift = drift_of(samples, band, rows, weight, lines, j)
    gain = max(0.0_dp, drift%gain - drift%step(3)**2/drift%covariance(3, 3))
  end function drift_gain

  function drift_of(samples, band, rows, weight, lines, j) result(drift)
    !! The drift of line j, all lines of the band being free.
    type(samples_type), intent(in) :: samples
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: rows(:, :)         !! without the lines that are not the band's
    real(dp), intent(in) :: weight(:)
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: j
    type(drift_type) :: drift
    type(reduced_type) :: reduced
    real(dp), allocatable :: matrix(:, :), right(:, :), tau(:), work(:), length(:), part(:, :)
    real(dp) :: inverse(4, 4)
    integer :: info, s, n, k, last
    reduced = reduce(samples, band%band, rows, lines, band%with_still, 2, j)
    n = size(reduced%length) - reduced%linear
    last = 2*size(lines) + 2
    allocate (matrix(n*size(weight), last), right(n*size(weight), 1), tau(last), work(64*last))
    part = slopes(reduced, weight)
    matrix(:, :2*j - 2) = part(:, :2*j - 2)
    matrix(:, 2*j - 1:last - 4) = part(:, 2*j + 1:)
    matrix(:, last - 3:last - 2) = part(:, 2*j - 1:2*j)
    matrix(:, last - 1:) = slopes(reduced, weight, j)
    do s = 1, size(weight)
      right((s - 1)*n + 1:s*n, 1) = reduced%rotated(reduced%linear + 1:, s)*sqrt(weight(s))
    end do
    length = max(norm2(matrix, dim=1), tiny(1.0_dp))
    do k = 1, last
      matrix(:, k) = matrix(:, k)/length(k)
    end do
    call dgeqrf(size(matrix, 1), last, matrix, size(matrix, 1), tau, work, size(work), info)
    call dormqr('L', 'T', size(matrix, 1), 1, last, matrix, size(matrix, 1), tau, right, size(matrix, 1), work, size(work), info)
    inverse = inverted(matrix(last - 3:last, last - 3:last))
    do k = 1, 4
      inverse(k, :) = inverse(k, :)/length(last - 4 + k)
    end do
    drift%step = matmul(inverse, right(last - 3:last, 1))
    drift%covariance = matmul(inverse, transpose(inverse))
    drift%gain = sum(right(last - 1:last, 1)**2)
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
