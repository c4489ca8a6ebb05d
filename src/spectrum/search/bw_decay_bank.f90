module bw_decay_bank
  !! Candidates for missing lines: the likelihood gain of one more line, over frequency and decay.
  !!
  !! A line e^(−δm) of any amplitude and phase lowers the squares of white samples w by 2 (|F|²E − Re F²P*)/(E² − |P|²), with
  !! F(ω) = Σ w e^(−δm − iωm), E = Σ e^(−2δm) and P = Σ e^(−2δm − 2iωm): one transform for each δ = 0, 1/T, 2/T, 4/T, … A line that
  !! decays early is as visible as one that lasts.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_model, only: model_type, rows_of_stretches, steps_between
  use bw_order, only: local_maxima
  use bw_samples, only: gaps_type
  use bw_uneven_fourier, only: uneven_transform
  implicit none (type, external)
  private
  public :: find_candidates

  real(dp), parameter :: folds = 7               !! e-folds after which a decay is taken as 0
  real(dp), parameter :: highest_decay = 0.5_dp  !! per step
  real(dp), parameter, public :: edge = 3        !! fewest periods in a stretch, and below half the sampling rate; fewer: trend
  real(dp), parameter :: clear = 16              !! tuned: factor by which a gain exceeds the skirts of a stronger line
  real(dp), parameter :: mirrored = 20           !! widths from 0 and half the sampling rate, within which mirror images interfere
  real(dp), parameter :: least_part = 0.05_dp    !! of a line's energy that must not be missing
  integer, parameter :: most = 24                !! number of candidates at a time
  integer, parameter :: fewest = 8               !! fewest samples for a line

  type, public :: decay_candidate
    real(dp) :: gain = 0                         !! decrease of the squares
    complex(dp) :: pole = 0
  end type decay_candidate

contains

  subroutine find_candidates(model, least, candidates)
    !! Find the poles where a line gains more than `least`, by descending gain, without skirts of stronger lines.
    type(model_type), intent(inout) :: model     !! its plans of transforms may change
    real(dp), intent(in) :: least
    type(decay_candidate), allocatable, intent(out) :: candidates(:)
    type(decay_candidate), allocatable :: all_of(:)
    real(dp), allocatable :: gain(:)
    integer, allocatable :: places(:)
    real(dp) :: decay, span
    integer :: i, best
    allocate (all_of(0), candidates(0), places(0))
    span = longest(model)
    if (span < fewest) return
    decay = 0
    do
      if (allocated(model%place)) then
        call find_uneven_gains(model, decay, gain)
      else
        call find_gains(model, decay, gain)
      end if
      places = local_maxima(gain, least)
      all_of = [all_of, [(decay_candidate(gain(places(i) + 1), cmplx(-decay, pi*places(i)/(size(gain) - 1), dp)), &
        & i=1, size(places))]]
      decay = max(2*decay, 1/span)
      if (decay > highest_decay .or. folds/decay < 8) exit
    end do
    do while (size(all_of) > 0 .and. size(candidates) < most)
      best = maxloc(all_of%gain, dim=1)
      candidates = [candidates, all_of(best)]
      associate (top => candidates(size(candidates)))
        all_of = pack(all_of, all_of%gain > clear*skirt(top, all_of%pole))
      end associate
    end do

  contains

    elemental real(dp) function skirt(top, pole)
      !! The apparent gain of a line at other poles.
      type(decay_candidate), intent(in) :: top
      complex(dp), intent(in) :: pole
      real(dp) :: width, away
      width = max(-top%pole%re, -pole%re, 2/span)
      away = abs(pole%im - top%pole%im)
      skirt = top%gain
      if (away > 4*width) skirt = top%gain*(width/away)**2
    end function skirt

  end subroutine find_candidates

  pure real(dp) function longest(model)
    !! The length of the longest stretch after a blow, in steps.
    type(model_type), intent(in) :: model
    integer :: rows(2, 0:ubound(model%stretches, 2)), b
    rows = rows_of_stretches(model)
    longest = maxval([(steps_between(model, rows(1, b), rows(2, b)), b=1, ubound(rows, 2))])
  end function longest

  subroutine find_gains(model, decay, gain)
    !! Find the gains of lines with a given decay at frequencies from 0 to half the sampling rate, (bins).
    type(model_type), intent(inout) :: model
    real(dp), intent(in) :: decay
    real(dp), allocatable, intent(out) :: gain(:)
    real(dp), allocatable :: fall(:)
    integer :: rows(2, 0:ubound(model%stretches, 2)), length, b, s, n, k, low, first, last, most
    real(dp) :: whole, energy, valid_part
    rows = rows_of_stretches(model)
    n = ceiling(longest(model))
    if (decay*n > folds) n = ceiling(folds/decay)
    length = fast_length(2*n)
    low = min(length/4, ceiling(edge*length/n))
    allocate (gain(length/2 + 1), source=0.0_dp)
    allocate (fall(n))
    do k = 1, n
      fall(k) = exp(-decay*(k - 1))
    end do
    call model%fourier%prepare(length)
    most = size(gain) - low
    do b = 1, ubound(rows, 2)
      k = min(n, rows(2, b) - rows(1, b) + 1)
      if (k < 4) cycle
      whole = sum(fall(:k)**2)
      first = min(most + 1, 1 + ceiling(edge*length/k))  ! in so short a stretch it would be offset and slope
      last = min(most, int(mirrored*max(decay, 1.0_dp/k)*length/(2*pi)) + 1)
      do s = 1, size(model%white, 2)
        energy = valid_energy(fall(:k), rows(1, b), model%missing(s))
        valid_part = energy/whole
        if (valid_part < least_part) cycle
        model%fourier%samples(:k) = fall(:k)*model%white(rows(1, b):rows(1, b) + k - 1, s)
        model%fourier%samples(k + 1:) = 0
        call model%fourier%transform()
        associate (f => model%fourier%spectrum)
          gain(first:most) = gain(first:most) + 2*(f(first - 1:most - 1)%re**2 + f(first - 1:most - 1)%im**2)/energy
          call add_mirrored(first, last, k)
          call add_mirrored(max(first, last + 1, size(gain) + 1 - last), most, k)
        end associate
      end do
    end do
    gain(:low) = 0
    gain(most + 1:) = 0

  contains

    subroutine add_mirrored(from, to, count)
      !! Add the effect of the mirror image on the gain in `count` samples: with E and P, both over E² − |P|², instead of 1/E.
      integer, intent(in) :: from, to, count
      complex(dp) :: p, f
      real(dp) :: omega
      integer :: j
      do j = from, to
        omega = 2*pi*(j - 1)/length
        f = model%fourier%spectrum(j - 1)
        p = valid_part*(1 - exp(cmplx(-2*decay*count, -2*omega*count, dp)))/(1 - exp(cmplx(-2*decay, -2*omega, dp)))
        gain(j) = gain(j) + 2*((energy*abs(f)**2 - real(f**2*conjg(p), dp))/(energy**2 - abs(p)**2) - abs(f)**2/energy)
      end do
    end subroutine add_mirrored

  end subroutine find_gains

  pure real(dp) function valid_energy(fall, first, missing) result(energy)
    !! The energy of a decay over the valid samples of a sensor.
    real(dp), intent(in) :: fall(:)              !! e^(−δm) at consecutive samples
    integer, intent(in) :: first                 !! number of the first one
    type(gaps_type), intent(in) :: missing
    integer :: i
    energy = sum(fall**2)
    do i = 1, size(missing%place)
      associate (m => missing%place(i) - first + 1)
        if (m >= 1 .and. m <= size(fall)) energy = energy - fall(m)**2
      end associate
    end do
  end function valid_energy

  subroutine find_uneven_gains(model, decay, gain)
    !! The same at uneven times, after the first blow, relative to the local power of the noise.
    type(model_type), intent(inout) :: model
    real(dp), intent(in) :: decay
    real(dp), allocatable, intent(out) :: gain(:)
    real(dp), allocatable :: fall(:), place(:)
    complex(dp), allocatable :: spectrum(:)
    real(dp) :: energy
    integer :: length, s, k, low, bins
    associate (first => model%stretches(1, 1), last => model%stretches(2, 1))
      place = model%place(first:last) - model%place(first)
      length = fast_length(2*ceiling(longest(model)))
      low = ceiling(edge*length/longest(model))
      fall = exp(-decay*place)
      bins = size(model%level, 1)
      allocate (gain(length/2 + 1), source=0.0_dp)
      allocate (spectrum(0:length/2))
      do s = 1, size(model%white, 2)
        energy = valid_energy(fall, first, model%missing(s))
        if (energy < least_part*sum(fall**2)) cycle
        call uneven_transform(place, fall*model%white(first:last, s), length, model%fourier, spectrum)
        do k = low, length/2
          associate (level => model%level(max(1, min(bins, nint(real(k, dp)*2*bins/length))), s))
            gain(k + 1) = gain(k + 1) + 2*abs(spectrum(k))**2/(energy*level)
          end associate
        end do
      end do
    end associate
  end subroutine find_uneven_gains

  pure integer function fast_length(least) result(length)
    !! The smallest even number of at least `least` whose only prime factors are 2, 3 and 5.
    integer, intent(in) :: least
    integer :: rest
    length = least + modulo(least, 2)
    do
      rest = length
      do while (modulo(rest, 2) == 0)
        rest = rest/2
      end do
      do while (modulo(rest, 3) == 0)
        rest = rest/3
      end do
      do while (modulo(rest, 5) == 0)
        rest = rest/5
      end do
      if (rest == 1) return
      length = length + 2
    end do
  end function fast_length

end module bw_decay_bank
