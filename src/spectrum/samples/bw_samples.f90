module bw_samples
  !! Samples of one motion at several sensors, taken at even or uneven times, and exponentials at these times.
  !!
  !! Time is counted in steps from the first sample: τ = (t − t₁)/step. An exponential of decay d and frequency f is
  !! e^(−dτ + 2πifτ), d per step and f in periods per step. Its slopes by decay and frequency are powers of the centred time
  !! u = (τ − τ_c)/τ_c, −1 … 1, τ_c being the middle of the record. A line that drifts is multiplied by e^(b₂u² + b₃u³ + …),
  !! the complex numbers b being its bend.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: bent_factor, bent_series, centre_of, find_wave, highest_of, keep_sensors, phase_factor, place_of, span_of

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter, public :: grain = 2.0_dp**26  !! a frequency of so many bits times a number of samples is exact
  integer, parameter, public :: series = 8   !! powers of a block's length over half the record, in which a bend is expanded there;
                                             !! where the bend turns a block by 0.4 this leaves 1e-9

  type, public :: samples_type
    integer :: count = 0                     !! N
    real(dp) :: step = 1                     !! s; of uneven times the median
    real(dp), allocatable :: place(:)        !! times τ of the samples, rising from 0, (N); not allocated: 0, 1, 2, …
    real(dp), allocatable :: value(:, :)     !! (N or more, S)
    logical :: pure = .false.                !! known to hold lines and their rounding and no noise, as a simulation's
  end type samples_type

contains

  pure real(dp) function span_of(samples)
    !! The length of the record in steps, N where they are even.
    type(samples_type), intent(in) :: samples
    if (allocated(samples%place)) then
      span_of = samples%place(samples%count) + 1
    else
      span_of = samples%count
    end if
  end function span_of

  pure real(dp) function centre_of(samples)
    !! The time τ_c in the middle between the first and the last sample.
    type(samples_type), intent(in) :: samples
    centre_of = max(span_of(samples) - 1, 1.0_dp)/2
  end function centre_of

  pure real(dp) function highest_of(samples)
    !! The highest sample of each sensor, as the length of a vector of all sensors.
    type(samples_type), intent(in) :: samples
    integer :: s
    highest_of = norm2([(maxval(abs(samples%value(:samples%count, s))), s=1, size(samples%value, 2))])
  end function highest_of

  pure real(dp) function place_of(samples, n)
    !! The time τ of sample n, counted from 1.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: n
    if (allocated(samples%place)) then
      place_of = samples%place(n)
    else
      place_of = n - 1
    end if
  end function place_of

  pure subroutine keep_sensors(kept, samples)
    !! Leave out the samples of all other sensors.
    integer, intent(in) :: kept(:)           !! sensors, in the order that they shall have
    type(samples_type), intent(inout) :: samples
    real(dp), allocatable :: value(:, :)
    integer :: s
    allocate (value(size(samples%value, 1), size(kept)))
    do s = 1, size(kept)
      value(:, s) = samples%value(:, kept(s))
    end do
    call move_alloc(value, samples%value)
  end subroutine keep_sensors

  pure complex(dp) function bent_factor(bend, u)
    !! The factor e^(b₂u² + b₃u³ + …).
    complex(dp), intent(in) :: bend(2:)
    real(dp), intent(in) :: u
    integer :: m
    bent_factor = 0
    do m = ubound(bend, 1), 2, -1
      bent_factor = (bent_factor + bend(m))*u
    end do
    bent_factor = exp(bent_factor*u)
  end function bent_factor

  pure function bent_series(bend, u, rate) result(a)
    !! The factor of a bend at u + x over that at u, as a₀ + a₁x + a₂x² + …: the exponent is r₁x + r₂x² + …, and its exponential has
    !! n·a_n = Σ j·r_j·a_(n−j). Many places are taken at once, as a processor does several.
    complex(dp), intent(in) :: bend(2:)
    real(dp), intent(in) :: u(:)             !! (places)
    complex(dp), intent(in), optional :: rate  !! the factor of an exponential e^(rate·x) too
    complex(dp) :: a(size(u), 0:series), r(size(u), 0:max(ubound(bend, 1), 1))
    integer :: j, m, n, last
    last = ubound(bend, 1)
    r(:, :1) = 0
    do m = 2, last
      r(:, m) = bend(m)
    end do
    do j = 0, last - 1                         ! the powers of u + x, by Horner's scheme
      do m = last - 1, j, -1
        r(:, m) = r(:, m) + u*r(:, m + 1)
      end do
    end do
    if (present(rate)) r(:, 1) = r(:, 1) + rate
    do j = 2, last
      r(:, j) = j*r(:, j)
    end do
    a(:, 0) = 1
    do n = 1, series
      a(:, n) = 0
      do j = 1, min(n, ubound(r, 2))
        a(:, n) = a(:, n) + r(:, j)*a(:, n - j)
      end do
      a(:, n) = a(:, n)/n
    end do
  end function bent_series

  pure subroutine find_wave(place, centre, decay, frequency, bend, along, across)
    !! Find real and imaginary part of e^(−dτ + 2πifτ) at uneven times, times the factor of a bend; that of a line that grows is
    !! divided by its last value. Sines and cosines are not taken in one loop: a compiler then takes several at once.
    real(dp), contiguous, intent(in) :: place(:)  !! τ
    real(dp), intent(in) :: centre           !! τ_c
    real(dp), intent(in) :: decay, frequency
    complex(dp), intent(in) :: bend(2:)      !! of size 0 where the line does not drift
    real(dp), contiguous, intent(out) :: along(:), across(:)
    real(dp), dimension(size(place)) :: phase, height
    integer :: m
    phase = frequency*place
    phase = 2*pi*(phase - int(phase))        ! below 2³¹ periods
    height = 2*min(decay, 0.0_dp)*centre - decay*place
    do m = 2, ubound(bend, 1)
      height = height + bend(m)%re*(place/centre - 1)**m
      phase = phase + bend(m)%im*(place/centre - 1)**m
    end do
    along = cos(phase)
    across = sin(phase)
    height = exp(height)
    along = along*height
    across = across*height
  end subroutine find_wave

  elemental complex(dp) function phase_factor(frequency, n, rest)
    !! The factor e^(2πi·frequency·n); whole periods are taken off before anything is rounded.
    real(dp), intent(in) :: frequency        !! periods per step, below 1
    integer, intent(in) :: n                 !! below 2²⁶
    real(dp), intent(in), optional :: rest   !! of the frequency, below its rounding
    real(dp) :: coarse, periods
    coarse = anint(frequency*grain)/grain
    periods = coarse*n
    periods = periods - anint(periods) + (frequency - coarse)*n
    if (present(rest)) periods = periods + rest*n
    phase_factor = exp(cmplx(0, 2*pi*periods, dp))
  end function phase_factor

end module bw_samples
