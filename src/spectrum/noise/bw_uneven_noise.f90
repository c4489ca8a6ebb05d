module bw_uneven_noise
  !! The colour of noise at uneven times, where no prediction from sample to sample is possible: running medians of the periodogram.
  use bw_autoregression, only: running_median
  use bw_constants, only: pi
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_uneven_fourier, only: uneven_transform
  implicit none (type, external)
  private
  public :: find_levels

contains

  subroutine find_levels(place, residual, fourier, level)
    !! Find the variance of white noise that has the same power near each frequency from 0 to half the sampling rate.
    real(dp), intent(in) :: place(:)             !! times, in steps, (N)
    real(dp), intent(in) :: residual(:, :)       !! (N, S)
    type(real_fourier), intent(inout) :: fourier
    real(dp), allocatable, intent(out) :: level(:, :)   !! (bins, S)
    real(dp) :: window(size(place))
    complex(dp), allocatable :: spectrum(:)
    integer :: length, s, half
    length = 2*ceiling((place(size(place)) + 1)/2)
    window = sin(pi*place/length)**2
    allocate (spectrum(0:length/2), level(length/2, size(residual, 2)))
    half = max(12, nint(1.5_dp*sqrt(real(length, dp))))  ! tuned: number of bins, more than lines occupy
    do s = 1, size(residual, 2)
      call uneven_transform(place, window*residual(:, s), length, fourier, spectrum)
      level(:, s) = running_median(abs(spectrum(1:))**2/sum(window**2), half)/log(2.0_dp)
    end do
    level = max(level, tiny(1.0_dp))
  end subroutine find_levels

end module bw_uneven_noise
