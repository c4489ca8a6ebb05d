module bw_steady_noise
  !! Whether what lines leave is noise that stays as it is along the record, as all that is said of lines takes it to be.
  !!
  !! The record is cut into parts of equal length, and the transform of each into bands of equal width. Of steady noise the powers of
  !! a band are the same in all parts, but for chance. What sweeps through frequencies, comes or goes has more power in some. And what
  !! grows has more power in one half of the record.
  use bw_amplitude_spectrum, only: window_at
  use bw_damped_line, only: damped_line
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_noise_level, only: quantile_of
  use bw_ordinates, only: square
  use bw_quantile, only: normal_quantile
  use bw_remainder, only: find_remainder, motion_type, tabulated
  use bw_samples, only: place_of, samples_type, span_of
  use bw_uneven_fourier, only: uneven_transform
  implicit none (type, external)
  private
  public :: unsteady_share

  integer, parameter :: parts = 8
  integer, parameter :: slices = 2*parts - 1   !! as long as a part, that begin half a part after each other
  integer, parameter :: fewest = 64            !! samples of a part
  integer, parameter :: least_width = 2        !! ordinates of a band
  integer, parameter :: most_bands = 512
  integer, parameter :: beside = 4             !! bands on either side, over which medians are averaged
  real(dp), parameter :: hann_square = 0.375_dp  !! mean of the window's squares
  real(dp), parameter :: by_chance = 1.0e-7_dp !! that steady noise has a power above the limit, anywhere
  real(dp), parameter :: most_numbers = 2.0_dp**22  !! of samples of all sensors that are looked at

contains

  real(dp) function unsteady_share(samples, lines, still) result(share)
    !! The part of the squares of the samples that lines leave and that is not steady, of the sensor that has most of it; 0 where a
    !! record is too short to tell. A filter would take it for the colour of the noise: the samples are those before it.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    type(motion_type) :: motion
    type(real_fourier) :: plan
    real(dp), allocatable :: left(:)
    integer :: s, sensors
    share = 0
    if (span_of(samples) < parts*fewest) return
    sensors = min(size(samples%value, 2), max(1, int(most_numbers/samples%count)))
    motion = tabulated(samples, lines, still)
    do s = 1, sensors
      call find_remainder(samples, motion, s, left)
      associate (value => samples%value(:samples%count, s))
        share = max(share, unsteady_squares(samples, left, plan)/max(sum((value - sum(value)/samples%count)**2), tiny(1.0_dp)))
      end associate
    end do
    share = min(share, 1.0_dp)                 ! a part counts what is in its middle more
  end function unsteady_share

  real(dp) function unsteady_squares(samples, left, plan) result(squares)
    !! Of one sensor, whose samples are `left`: the squares above the median of all slices where that is beyond chance.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: left(:)
    type(real_fourier), intent(inout) :: plan
    complex(dp), allocatable :: spectrum(:)
    real(dp) :: power(slices, most_bands), medians(most_bands), half(2), freedom, limit, middle
    integer :: length, bands, width, p, b, n, start, first, last
    length = 2*int(span_of(samples)/(2*parts))
    bands = max(1, min(most_bands, (length/2 - 1)/least_width))
    width = (length/2 - 1)/bands
    call plan%prepare(length)
    allocate (spectrum(0:length/2))
    do p = 1, slices
      start = (p - 1)*(length/2)
      first = count([(place_of(samples, n) < start, n=1, size(left))]) + 1
      last = count([(place_of(samples, n) < start + length, n=1, size(left))])
      if (last - first < length/2) then        ! a gap
        squares = 0
        return
      end if
      if (allocated(samples%place)) then
        associate (place => samples%place(first:last) - start)
          call uneven_transform(place, left(first:last)*window_at('hann', place, real(length, dp)), length, plan, spectrum)
        end associate
      else
        plan%samples = left(first:last)*window_at('hann', [(real(n, dp), n=0, length - 1)], real(length, dp))
        call plan%transform()
        spectrum = plan%spectrum
      end if
      power(p, :bands) = 2/hann_square*[(sum(square(spectrum((b - 1)*width + 2:b*width + 1))), b=1, bands)]/length
    end do
    freedom = width/2.0_dp                     ! the window makes neighbours alike
    limit = normal_quantile(1 - by_chance/(slices*bands))/sqrt(9*freedom)
    limit = (1 - 1/(9*freedom) + limit)**3     ! Wilson and Hilferty, of a sum of squares of 2·freedom numbers
    squares = 0
    medians(:bands) = [(quantile_of(power(:, b), 0.5_dp), b=1, bands)]
    do b = 1, bands
      first = max(1, min(b - beside, bands - 2*beside))
      last = min(bands, first + 2*beside)
      middle = max(medians(b), sum(medians(first:last))/(last - first + 1))  ! colour raises one, what sweeps neither
      squares = squares + sum(power(:, b) - middle, mask=power(:, b) > limit*middle)/2  ! each sample is in two slices
    end do
    half = [sum(power(:parts - 1, :bands)), sum(power(parts + 1:, :bands))]
    associate (independent => max(sum(medians(:bands))**2/max(sum(medians(:bands)**2), tiny(1.0_dp)), 1.0_dp))
      freedom = freedom*independent*parts/2
    end associate
    if (maxval(half) > minval(half)*exp(normal_quantile(1 - by_chance)*sqrt(2/freedom))) &
      & squares = max(squares, (maxval(half) - minval(half))/2)
  end function unsteady_squares

end module bw_steady_noise
