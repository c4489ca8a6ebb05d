module bw_samples
  !! Samples of one motion at several sensors, taken at even or uneven times, and sums of exponentials over blocks of them.
  !!
  !! Time is counted in steps from the first sample: τ = (t − t₁)/step. An exponential of decay d and frequency f is
  !! e^(−dτ + 2πifτ), d per step and f in periods per step. Its slopes by decay and frequency are powers of the centred time
  !! u = (τ − τ_c)/τ_c, −1 … 1, τ_c being the middle of the record.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: block_sums, centre_of, even_blocks, phase_factor, place_of, span_of

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: grain = 2.0_dp**26  !! a frequency of so many bits times a number of samples is exact

  type, public :: samples_type
    real(dp) :: step = 1                     !! s; of uneven times the median
    real(dp), allocatable :: place(:)        !! times τ of the samples, rising from 0, (N); not allocated: 0, 1, 2, …
    real(dp), allocatable :: value(:, :)     !! (N, S)
  end type samples_type

  type, public :: blocks_type
    integer, allocatable :: first(:)         !! index of the first sample of each block, and N + 1, (B + 1)
  end type blocks_type

contains

  pure real(dp) function span_of(samples)
    !! The length of the record in steps, N where they are even.
    type(samples_type), intent(in) :: samples
    if (allocated(samples%place)) then
      span_of = samples%place(size(samples%place)) + 1
    else
      span_of = size(samples%value, 1)
    end if
  end function span_of

  pure real(dp) function centre_of(samples)
    !! The time τ_c in the middle between the first and the last sample.
    type(samples_type), intent(in) :: samples
    centre_of = max(span_of(samples) - 1, 1.0_dp)/2
  end function centre_of

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

  pure function even_blocks(samples, count) result(blocks)
    !! About so many blocks of the same length in time; of uneven samples those without a sample are left out.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: count
    type(blocks_type) :: blocks
    integer, allocatable :: block(:)
    integer :: length, samples_in_all, n
    samples_in_all = size(samples%value, 1)
    if (.not. allocated(samples%place)) then
      length = max(1, samples_in_all/count)
      blocks%first = [(n, n=1, samples_in_all, length), samples_in_all + 1]
    else if (count >= samples_in_all) then
      blocks%first = [(n, n=1, samples_in_all + 1)]
    else
      block = int(samples%place*(count/span_of(samples)))
      blocks%first = [1, pack([(n, n=2, samples_in_all)], block(2:) > block(:samples_in_all - 1)), samples_in_all + 1]
    end if
  end function even_blocks

  function block_sums(samples, blocks, decay, frequency, order) result(sums)
    !! The sums Σ u^m e^(−dτ + 2πifτ) over the samples of each block, m = 0 … order, (B, 0:order). A line that grows is
    !! divided by its last value, so that nothing overflows.
    type(samples_type), intent(in) :: samples
    type(blocks_type), intent(in) :: blocks
    real(dp), intent(in) :: decay, frequency
    integer, intent(in) :: order               !! 0 … 2
    complex(dp) :: sums(size(blocks%first) - 1, 0:order)
    if (allocated(samples%place)) then
      sums = uneven_sums(samples, blocks, decay, frequency, order)
    else
      sums = even_sums(size(samples%value, 1), blocks, decay, frequency, order)
    end if
  end function block_sums

  pure function even_sums(count, blocks, decay, frequency, order) result(sums)
    !! All blocks but the last have one length, so that their sums differ by a factor and by where u starts.
    integer, intent(in) :: count, order
    type(blocks_type), intent(in) :: blocks
    real(dp), intent(in) :: decay, frequency
    complex(dp) :: sums(size(blocks%first) - 1, 0:order)
    complex(dp) :: moment(0:order), factor
    real(dp) :: centre, start
    integer :: b, length
    centre = max(count - 1, 1)/2.0_dp
    length = 0
    do b = 1, size(sums, 1)
      if (length /= blocks%first(b + 1) - blocks%first(b)) then
        length = blocks%first(b + 1) - blocks%first(b)
        moment = moments(length)
      end if
      factor = phase_factor(frequency, blocks%first(b) - 1)*exp(-decay*(blocks%first(b) - 1) + min(decay, 0.0_dp)*(count - 1))
      start = (blocks%first(b) - 1 - centre)/centre
      sums(b, 0) = factor*moment(0)
      if (order > 0) sums(b, 1) = factor*(start*moment(0) + moment(1))
      if (order > 1) sums(b, 2) = factor*(start*start*moment(0) + 2*start*moment(1) + moment(2))
    end do

  contains

    pure function moments(length) result(moment)
      !! The sums of the first block about its own start.
      integer, intent(in) :: length
      complex(dp) :: moment(0:order), term
      integer :: l, m
      moment = 0
      do l = 0, length - 1
        term = exp(-decay*l)*phase_factor(frequency, l)
        do m = 0, order
          moment(m) = moment(m) + term
          term = term*(l/centre)
        end do
      end do
    end function moments

  end function even_sums

  pure function uneven_sums(samples, blocks, decay, frequency, order) result(sums)
    !! Sample by sample.
    type(samples_type), intent(in) :: samples
    type(blocks_type), intent(in) :: blocks
    real(dp), intent(in) :: decay, frequency
    integer, intent(in) :: order
    complex(dp) :: sums(size(blocks%first) - 1, 0:order), term
    real(dp) :: centre, u, periods
    integer :: b, n, m
    centre = centre_of(samples)
    sums = 0
    do b = 1, size(sums, 1)
      do n = blocks%first(b), blocks%first(b + 1) - 1
        periods = frequency*samples%place(n)
        u = samples%place(n)/centre - 1
        term = exp(-decay*samples%place(n) + 2*min(decay, 0.0_dp)*centre)*exp(cmplx(0, 2*pi*(periods - anint(periods)), dp))
        do m = 0, order
          sums(b, m) = sums(b, m) + term
          term = term*u
        end do
      end do
    end do
  end function uneven_sums

  elemental complex(dp) function phase_factor(frequency, n)
    !! The factor e^(2πi·frequency·n); whole periods are taken off before anything is rounded.
    real(dp), intent(in) :: frequency        !! periods per step, below 1
    integer, intent(in) :: n                 !! below 2²⁶
    real(dp) :: coarse, periods
    coarse = anint(frequency*grain)/grain
    periods = coarse*n
    periods = periods - anint(periods) + (frequency - coarse)*n
    phase_factor = exp(cmplx(0, 2*pi*periods, dp))
  end function phase_factor

end module bw_samples
