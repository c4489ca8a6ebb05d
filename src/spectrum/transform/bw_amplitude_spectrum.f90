module bw_amplitude_spectrum
  !! This module computes one-sided amplitude spectra with windows that are sums of cosines, in the periodic form that suits a
  !! Fourier transform.
  use bw_constants, only: pi
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  implicit none (type, external)
  private
  public :: amplitude_spectrum, frequency_axis, window_at, window_samples


  type, public :: spectrum_plan
    !! The transform and the window of records of one length, kept from record to record.
    private
    type(real_fourier) :: fourier
    character(:), allocatable :: window
    real(dp), allocatable :: weight(:)            ! of the window, (N)
    real(dp) :: weight_sum = 0.0_dp               ! its sum
  contains
    procedure, private :: prepare
  end type spectrum_plan

contains

  subroutine amplitude_spectrum(samples, window, plan, amplitude)
    !! Compute the one-sided amplitude spectrum, in the unit of the samples. A tone of amplitude A at the centre of a bin has the
    !! value A with any window. Amplitudes below 1e-154 of the largest sample may be 0.
    real(dp), intent(in), contiguous :: samples(:)   !! (N), N ≥ 1, finite
    character(*), intent(in) :: window            !! as the input `spectrum%window`
    type(spectrum_plan), intent(inout) :: plan    !! renewed if the length or the window changes
    real(dp), intent(out), contiguous :: amplitude(0:)   !! (0:N/2)
    real(dp) :: down(2), up(2)
    integer :: last, power
    last = size(samples)/2
    call plan%prepare(size(samples), window)
    power = exponent(largest_magnitude(samples))  ! scale by a power of two, so that samples near overflow pass
    down = power_of_two(-power)
    up = power_of_two(power)
    plan%fourier%samples(:) = plan%weight*((samples*down(1))*down(2))
    call plan%fourier%transform()
    call find_magnitudes(plan%fourier%spectrum, up(1)*(2.0_dp/plan%weight_sum), up(2), amplitude)
    amplitude(0) = amplitude(0)/2                 ! bins 0 and N/2 have no mirror image
    if (2*last == size(samples)) amplitude(last) = amplitude(last)/2
  end subroutine amplitude_spectrum

  pure subroutine find_magnitudes(x, factor, factor_too, magnitude)
    !! Compute |x| times two factors; the square of |x| has to be within range.
    complex(dp), intent(in), contiguous :: x(:)
    real(dp), intent(in) :: factor, factor_too
    real(dp), intent(out), contiguous :: magnitude(:)
    magnitude = (sqrt(real(x)**2 + aimag(x)**2)*factor)*factor_too
  end subroutine find_magnitudes

  pure function power_of_two(power) result(factors)
    !! Two factors whose product is 2^power, which itself may be out of range.
    integer, intent(in) :: power
    real(dp) :: factors(2)
    factors = scale(1.0_dp, [power/2, power - power/2])
  end function power_of_two

  subroutine prepare(self, length, window)
    !! Make the window and the transform's plan, unless they are there for this length and window.
    class(spectrum_plan), intent(inout) :: self
    integer, intent(in) :: length                 !! N
    character(*), intent(in) :: window
    logical :: ready
    ready = allocated(self%weight)
    if (ready) ready = size(self%weight) == length .and. self%window == window
    if (ready) return
    self%window = window
    self%weight = window_samples(window, length)
    self%weight_sum = sum(self%weight)
    call self%fourier%prepare(length)
  end subroutine prepare

  pure function frequency_axis(samples, duration) result(frequency)
    !! The frequencies j/T of the bins of `amplitude_spectrum`, in Hz, (0:samples/2).
    integer, intent(in) :: samples                !! N ≥ 1
    real(dp), intent(in) :: duration              !! T = N times the sampling step, s
    real(dp) :: frequency(0:samples/2)
    integer :: j
    frequency = [(real(j, dp)/duration, j=0, samples/2)]
  end function frequency_axis

  pure function window_samples(word, count) result(weight)
    !! The window w_j = Σ_q (−1)^q a_q cos(2πqj/count), j = 0 … count−1, (count).
    !! A record too short for the window's main lobe, or an unknown word, gets the rectangular window.
    character(*), intent(in) :: word
    integer, intent(in) :: count
    real(dp) :: weight(count)
    integer :: j
    weight = window_at(word, [(real(j, dp), j=0, count - 1)], real(count, dp))
  end function window_samples

  pure function window_at(word, place, length) result(weight)
    !! The same window at given places of a record.
    character(*), intent(in) :: word
    real(dp), intent(in) :: place(:), length      !! from the record's start, and the record's length, in the same unit
    real(dp) :: weight(size(place))
    real(dp), allocatable :: a(:)
    integer :: q
    allocate (a, source=window_coefficients(word))
    if (size(place) < 2*size(a) .or. size(a) == 0) a = [1.0_dp]
    weight = a(1)
    do q = 1, size(a) - 1
      weight = weight + (-1)**q*a(q + 1)*cos(2*pi*q*place/length)
    end do
  end function window_at

  pure function window_coefficients(word) result(a)
    !! The coefficients a_0, a_1, … of the window; none if the word is unknown.
    !! Source: Harris, Proc. IEEE 66 (1978) 51; flat_top: ISO 18431-2.
    character(*), intent(in) :: word
    real(dp), allocatable :: a(:)
    select case (word)
    case ('rectangular')
      a = [1.0_dp]
    case ('hann')
      a = [0.5_dp, 0.5_dp]
    case ('hamming')
      a = [0.54_dp, 0.46_dp]
    case ('blackman')
      a = [0.42_dp, 0.5_dp, 0.08_dp]
    case ('blackman_harris')
      a = [0.35875_dp, 0.48829_dp, 0.14128_dp, 0.01168_dp]
    case ('flat_top')
      a = [1.0_dp, 1.933_dp, 1.286_dp, 0.388_dp, 0.0322_dp]
    case default
      allocate (a(0))
    end select
  end function window_coefficients

end module bw_amplitude_spectrum
