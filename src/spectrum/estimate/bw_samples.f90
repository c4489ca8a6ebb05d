module bw_samples
  !! Samples of one motion at several sensors, taken at even or uneven times, and sums of exponentials over blocks of them.
  !!
  !! Time is counted in steps from the first sample: τ = (t − t₁)/step. An exponential of decay d and frequency f is
  !! e^(−dτ + 2πifτ), d per step and f in periods per step. Its slopes by decay and frequency are powers of the centred time
  !! u = (τ − τ_c)/τ_c, −1 … 1, τ_c being the middle of the record. A line that drifts is multiplied by e^(b₂u² + b₃u³ + …),
  !! the complex numbers b being its bend.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: bent_factor, bent_series, block_sums, centre_of, even_blocks, find_wave, highest_of, phase_factor, place_of, span_of

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: table = 32           !! factors of the fine one of two tables
  real(dp), parameter, public :: grain = 2.0_dp**26  !! a frequency of so many bits times a number of samples is exact
  integer, parameter :: series = 8           !! powers of a block's length over half the record, in which a bend is expanded there;
                                             !! where the bend turns a block by 0.4 this leaves 1e-9

  type, public :: samples_type
    integer :: count = 0                     !! N
    real(dp) :: step = 1                     !! s; of uneven times the median
    real(dp), allocatable :: place(:)        !! times τ of the samples, rising from 0, (N); not allocated: 0, 1, 2, …
    real(dp), allocatable :: value(:, :)     !! (N or more, S)
    logical :: pure = .false.                !! known to hold lines and their rounding and no noise, as a simulation's
  end type samples_type

  type, public :: blocks_type
    integer, allocatable :: first(:)         !! index of the first sample of each block, and N + 1, (B + 1)
  end type blocks_type

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

  pure function even_blocks(samples, count) result(blocks)
    !! About so many blocks of the same length in time; of uneven samples those without a sample are left out.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: count
    type(blocks_type) :: blocks
    integer, allocatable :: block(:)
    integer :: length, samples_in_all, n
    samples_in_all = samples%count
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

  function block_sums(samples, blocks, decay, frequency, order, bend) result(sums)
    !! The sums Σ u^m e^(−dτ + 2πifτ) over the samples of each block, m = 0 … order, (B, 0:order), times the factor of a bend.
    !! A line that grows is divided by its last value, so that nothing overflows.
    type(samples_type), intent(in) :: samples
    type(blocks_type), intent(in) :: blocks
    real(dp), intent(in) :: decay, frequency
    integer, intent(in) :: order
    complex(dp), intent(in) :: bend(2:)      !! of size 0 where the line does not drift
    complex(dp) :: sums(size(blocks%first) - 1, 0:order)
    if (allocated(samples%place)) then
      sums = uneven_sums(samples, blocks, decay, frequency, order, bend)
    else
      sums = even_sums(samples%count, blocks, decay, frequency, order, bend)
    end if
  end function block_sums

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

  pure function even_sums(count, blocks, decay, frequency, order, bend) result(sums)
    !! All blocks but the last have one length, so that their sums differ by a factor and by where u starts.
    integer, intent(in) :: count, order
    type(blocks_type), intent(in) :: blocks
    real(dp), intent(in) :: decay, frequency
    complex(dp), intent(in) :: bend(2:)
    complex(dp) :: sums(size(blocks%first) - 1, 0:order)
    complex(dp) :: factor(size(blocks%first) - 1), moment(0:order + merge(series, 0, size(bend) > 0))
    real(dp) :: centre, u(size(blocks%first) - 1)
    integer :: b, j, m, length, start
    centre = max(count - 1, 1)/2.0_dp
    start = blocks%first(1) - 1
    length = blocks%first(2) - blocks%first(1)
    if (decay < 0) then                        ! powers alone would overflow
      factor = powers(0.0_dp, frequency, length, size(factor))*phase_factor(frequency, start)* &
        & [(exp(decay*(count - 1 - start - real(b, dp)*length)), b=0, size(factor) - 1)]
    else
      factor = powers(decay, frequency, length, size(factor))*exp(-decay*start)*phase_factor(frequency, start)
    end if
    moment = moments(decay, frequency, length, centre, ubound(moment, 1))
    u = [((blocks%first(b) - 1 - centre)/centre, b=1, size(u))]
    do m = 0, order
      sums(:, m) = moment(m)
    end do
    do b = 1, size(sums, 1)
      if (size(bend) == 0 .and. b < size(sums, 1)) cycle
      if (length /= blocks%first(b + 1) - blocks%first(b)) then
        length = blocks%first(b + 1) - blocks%first(b)
        moment = moments(decay, frequency, length, centre, ubound(moment, 1))
      end if
      sums(b, :) = moment(:order)
      if (size(bend) > 0) sums(b, :) = bent_factor(bend, u(b))*bent(moment, bend, u(b), order)
    end do
    do m = 1, order                            ! about the record's middle, by the binomial theorem
      do j = order, m, -1
        sums(:, j) = sums(:, j) + u*sums(:, j - 1)
      end do
    end do
    do m = 0, order
      sums(:, m) = factor*sums(:, m)
    end do
  end function even_sums

  pure function bent(moment, bend, u, order) result(about)
    !! A block's moments with the factor of a bend, over its value where the block starts.
    complex(dp), intent(in) :: moment(0:), bend(2:)
    real(dp), intent(in) :: u
    integer, intent(in) :: order
    complex(dp) :: about(0:order), a(0:series)
    integer :: m
    a = bent_series(bend, u)
    do m = 0, order
      about(m) = sum(a*moment(m:m + series))
    end do
  end function bent

  pure function bent_series(bend, u) result(a)
    !! The factor of a bend at u + x over that at u, as a₀ + a₁x + a₂x² + …: the exponent is r₁x + r₂x² + …, and its exponential has
    !! n·a_n = Σ j·r_j·a_(n−j).
    complex(dp), intent(in) :: bend(2:)
    real(dp), intent(in) :: u
    complex(dp) :: a(0:series), r(series)
    integer :: j, m, n
    do j = 1, series
      r(j) = 0
      do m = max(2, j), ubound(bend, 1)
        r(j) = r(j) + binomial(m, j)*bend(m)*u**(m - j)
      end do
    end do
    a(0) = 1
    do n = 1, series
      a(n) = sum([(j*r(j)*a(n - j), j=1, n)])/n
    end do
  end function bent_series

  pure real(dp) function binomial(n, k)
    !! n!/(k!(n − k)!).
    integer, intent(in) :: n, k
    integer :: i
    binomial = 1
    do i = 1, k
      binomial = binomial*(n - k + i)/i
    end do
  end function binomial

  pure function moments(decay, frequency, length, centre, order) result(moment)
    !! The sums Σ (l/centre)^m e^(−dl + 2πifl) of a block, l = 0 … length − 1, (0:order).
    real(dp), intent(in) :: decay, frequency, centre
    integer, intent(in) :: length, order
    complex(dp) :: moment(0:order), term(length)
    integer :: l, m
    term = powers(decay, frequency, 1, length)
    do m = 0, order
      moment(m) = sum(term)
      if (m < order) term = term*[(l/centre, l=0, length - 1)]
    end do
  end function moments

  pure function powers(decay, frequency, stride, count) result(factor)
    !! The factors e^(−dn + 2πifn) of n = 0, stride, 2 stride, …: the product of a fine and a coarse table.
    real(dp), intent(in) :: decay, frequency
    integer, intent(in) :: stride, count
    complex(dp) :: factor(0:count - 1), fine(0:table - 1), coarse
    integer :: b, last
    fine = [(exp(-decay*b*stride)*phase_factor(frequency, b*stride), b=0, table - 1)]
    do b = 0, count - 1, table
      last = min(count, b + table) - 1
      coarse = exp(-decay*(real(b, dp)*stride))*phase_factor(frequency, b*stride)
      factor(b:last) = coarse*fine(:last - b)
    end do
  end function powers

  pure function uneven_sums(samples, blocks, decay, frequency, order, bend) result(sums)
    !! Sample by sample.
    type(samples_type), intent(in) :: samples
    type(blocks_type), intent(in) :: blocks
    real(dp), intent(in) :: decay, frequency
    integer, intent(in) :: order
    complex(dp), intent(in) :: bend(2:)
    complex(dp) :: sums(size(blocks%first) - 1, 0:order)
    real(dp), allocatable :: along(:), across(:)
    real(dp) :: centre
    integer :: b, m
    centre = centre_of(samples)
    do b = 1, size(sums, 1)
      associate (place => samples%place(blocks%first(b):blocks%first(b + 1) - 1))
        if (allocated(along)) then
          if (size(along) /= size(place)) deallocate (along, across)
        end if
        if (.not. allocated(along)) allocate (along(size(place)), across(size(place)))
        call find_wave(place, centre, decay, frequency, bend, along, across)
        do m = 0, order
          sums(b, m) = cmplx(sum(along), sum(across), dp)
          if (m == order) exit
          along = along*(place/centre - 1)
          across = across*(place/centre - 1)
        end do
      end associate
    end do
  end function uneven_sums

  pure subroutine find_wave(place, centre, decay, frequency, bend, along, across)
    !! Find real and imaginary part of e^(−dτ + 2πifτ) at uneven times, times the factor of a bend; that of a line that grows is
    !! divided by its last value. Sines and cosines are not taken in one loop: a compiler then takes several at once.
    real(dp), intent(in) :: place(:)         !! τ
    real(dp), intent(in) :: centre           !! τ_c
    real(dp), intent(in) :: decay, frequency
    complex(dp), intent(in) :: bend(2:)      !! of size 0 where the line does not drift
    real(dp), intent(out) :: along(:), across(:)
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
