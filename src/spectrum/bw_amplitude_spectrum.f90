module bw_amplitude_spectrum
  !! One-sided amplitude spectra.
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_window, only: window_samples
  implicit none (type, external)
  private
  public :: amplitude_spectrum, frequency_axis

  type, public :: spectrum_plan
    !! What spectra of one length and window share: kept from record to record.
    private
    type(real_fourier) :: fourier
    character(:), allocatable :: window
    real(dp), allocatable :: weight(:)            ! of the window, (N)
    real(dp) :: whole = 0.0_dp                    ! its sum
  contains
    procedure, private :: prepare
  end type spectrum_plan

contains

  function amplitude_spectrum(samples, window, plan) result(amplitude)
    !! One-sided amplitude spectrum, in the unit of the samples, (0:N/2); a tone of amplitude A in the middle of a
    !! bin reads A, whatever the window. Amplitudes below 1e-154 of the largest sample may read 0.
    real(dp), intent(in) :: samples(:)            !! (N), N ≥ 1, finite
    character(*), intent(in) :: window            !! a word of `known_windows`
    type(spectrum_plan), intent(inout) :: plan    !! made anew where the length or the window is another
    real(dp) :: amplitude(0:size(samples)/2)
    integer :: last, power
    last = size(samples)/2
    call plan%prepare(size(samples), window)
    power = exponent(maxval(abs(samples)))        ! of two: samples near overflow pass
    plan%fourier%samples = plan%weight*times_power(samples, -power)
    call plan%fourier%transform()
    associate (x => plan%fourier%spectrum)
      amplitude = 2*sqrt(real(x)**2 + aimag(x)**2)/plan%whole
    end associate
    amplitude(0) = amplitude(0)/2                 ! these two have no mirror image beside them
    if (2*last == size(samples)) amplitude(last) = amplitude(last)/2
    amplitude = times_power(amplitude, power)
  end function amplitude_spectrum

  pure function times_power(values, power) result(scaled)
    !! 2^power times the values. In two steps, for 2^power itself may be out of range; `scale` is a call for every element.
    real(dp), intent(in) :: values(:)
    integer, intent(in) :: power
    real(dp) :: scaled(size(values))
    real(dp) :: first, second
    first = scale(1.0_dp, power/2)
    second = scale(1.0_dp, power - power/2)
    scaled = (values*first)*second
  end function times_power

  subroutine prepare(self, length, window)
    class(spectrum_plan), intent(inout) :: self
    integer, intent(in) :: length                 !! N
    character(*), intent(in) :: window
    logical :: ready
    ready = allocated(self%weight)
    if (ready) ready = size(self%weight) == length .and. self%window == window
    if (ready) return
    self%window = window
    self%weight = window_samples(window, length)
    self%whole = sum(self%weight)
    call self%fourier%prepare(length)
  end subroutine prepare

  pure function frequency_axis(samples, duration) result(frequency)
    !! The frequencies of `amplitude_spectrum`, j/T, Hz, (0:samples/2).
    integer, intent(in) :: samples                !! N ≥ 1
    real(dp), intent(in) :: duration              !! T = N times the sampling step, s
    real(dp) :: frequency(0:samples/2)
    integer :: j
    frequency = [(real(j, dp)/duration, j=0, samples/2)]
  end function frequency_axis

end module bw_amplitude_spectrum
