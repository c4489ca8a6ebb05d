module bw_amplitude_spectrum
  !! One-sided amplitude spectra.
  use bw_fourier, only: real_transform
  use bw_kinds, only: dp
  use bw_window, only: window_samples
  implicit none (type, external)
  private
  public :: amplitude_spectrum, frequency_axis

contains

  function amplitude_spectrum(samples, window) result(amplitude)
    !! One-sided amplitude spectrum, in the unit of the samples, (0:N/2); a tone of amplitude A in the middle of a
    !! bin reads A, whatever the window.
    real(dp), intent(in) :: samples(:)            !! (N), N ≥ 1, finite
    character(*), intent(in) :: window            !! a word of `known_windows`
    real(dp) :: amplitude(0:size(samples)/2)
    real(dp) :: weight(size(samples))
    integer :: last, power
    last = size(samples)/2
    weight = window_samples(window, size(samples))
    power = exponent(maxval(abs(samples)))        ! of two: samples near overflow pass
    amplitude = 2*abs(real_transform(weight*scale(samples, -power)))/sum(weight)
    amplitude(0) = amplitude(0)/2                 ! these two have no mirror image beside them
    if (2*last == size(samples)) amplitude(last) = amplitude(last)/2
    amplitude = scale(amplitude, power)
  end function amplitude_spectrum

  pure function frequency_axis(samples, duration) result(frequency)
    !! The frequencies of `amplitude_spectrum`, j/T, Hz, (0:samples/2).
    integer, intent(in) :: samples                !! N ≥ 1
    real(dp), intent(in) :: duration              !! T = N times the sampling step, s
    real(dp) :: frequency(0:samples/2)
    integer :: j
    frequency = [(real(j, dp)/duration, j=0, samples/2)]
  end function frequency_axis

end module bw_amplitude_spectrum
