module bw_uneven_noise
  !! The colour of noise at uneven times, where no prediction from sample to sample is possible: running medians of the periodogram.
  use bw_autoregression, only: running_median
  use bw_constants, only: pi
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_samples, only: samples_type, span_of, validity
  use bw_uneven_fourier, only: uneven_transform
  implicit none (type, external)
  private
  public :: find_levels

contains

  subroutine find_levels(samples, residual, fourier, level)
    !! Find the variance of white noise that has the same power near each frequency from 0 to half the sampling rate.
    type(samples_type), intent(in) :: samples    !! at uneven times
    real(dp), intent(in) :: residual(:, :)       !! (N, S)
    type(real_fourier), intent(inout) :: fourier
    real(dp), allocatable, intent(out) :: level(:, :)   !! (bins, S)
    real(dp), dimension(samples%count) :: window, weight
    complex(dp), allocatable :: spectrum(:)
    integer :: length, s, half
    length = 2*ceiling(span_of(samples)/2)
    window = sin(pi*samples%place/length)**2
    allocate (spectrum(0:length/2), level(length/2, size(residual, 2)))
    half = max(12, nint(1.5_dp*sqrt(real(length, dp))))  ! tuned: number of bins, more than lines occupy
    do s = 1, size(residual, 2)
      weight = merge(window, 0.0_dp, validity(samples, s))
      call uneven_transform(samples%place, weight*residual(:, s), length, fourier, spectrum)
      level(:, s) = running_median(abs(spectrum(1:))**2/sum(weight**2), half)/log(2.0_dp)
    end do
    level = max(level, tiny(1.0_dp))
  end subroutine find_levels

end module bw_uneven_noise
