module bw_band
  !! A band of frequencies around a few lines: white samples, demodulated to the band's centre and summed over blocks.
  !!
  !! A few hundred sums keep the information of a stretch on lines near the centre to a few thousandths, and the image of a line in
  !! them is known in closed form. The rows are real numbers with white noise of variance 1. A sum of n samples times e^(−iθ) has
  !! noise x + iy with E|x + iy|² = n and E(x + iy)² = p = Σ e^(−2iθ): rotated by −½ arg p its parts are independent, with variances
  !! (n ± |p|)/2. Near 0 and half the sampling rate the rows are the samples themselves, or real sums of them.
  use bw_band_columns, only: band_part, band_type, line_columns, line_fills, rows_of, traces_of
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_lapack, only: ddot
  use bw_line, only: life_of, line_type, pole_at
  use bw_missing_samples, only: find_reach, missing_among, project_out_missing
  use bw_noise, only: noise_type
  use bw_samples, only: gaps_type
  use bw_tapered_line, only: parts
  implicit none (type, external)
  private
  public :: add_to_band, band_around, enough_for, fill_rows, holds, tapered_band

  integer, parameter :: sums_per_bin = 32    !! tuned: loses (π/32)²/3 of the information at the edge of the band
  integer, parameter :: ample = 1024         !! tuned: sums that are enough for a broad line
  integer, parameter :: fewest_per_bin = 8   !! tuned: loses 5 % at the edge of so broad a band
  real(dp), parameter :: resolved = 0.5_dp   !! of the frequencies that sums over blocks distinguish
  real(dp), parameter :: folds = 9           !! e-folds after which a line is negligible
  real(dp), parameter :: noiseless = 1.0e-6_dp  !! of the noise of the other row of a block; with less a row is noiseless

contains

  pure function band_around(lines, stretches, noise, missing, place) result(band)
    !! The band that contains these lines, without rows of the record. A stretch in which none of them lives has no part.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: stretches(:, 0:)  !! first and last sample of each, (2, 0:B); the first is before any blow
    type(noise_type), intent(in) :: noise
    type(gaps_type), intent(in) :: missing(:)  !! of each component
    real(dp), intent(in), optional :: place(:)  !! times of uneven samples, in steps
    type(band_type) :: band
    real(dp) :: lowest, highest, widest, longest, width, life, lives
    complex(dp) :: ends
    integer, dimension(0:ubound(stretches, 2)) :: used, shares   !! numbers of samples and of parts of a stretch
    integer :: blocks, b, k, n
    used = max(0, stretches(2, :) - stretches(1, :) + 1)
    if (.not. any(lines%steady) .or. used(0) < enough_for(size(lines))) used(0) = 0
    longest = maxval(used)
    if (present(place)) longest = maxval([(place(stretches(2, b)) - place(stretches(1, b)) + 1, b=1, ubound(used, 1))])
    band%longest = longest
    lowest = pi
    highest = 0
    widest = 0
    lives = 1
    do k = 1, size(lines)
      associate (line => lines(k))
        life = life_of(line, folds, longest)
        ends = pole_at(line, life)
        lowest = min(lowest, line%pole%im, ends%im)
        highest = max(highest, line%pole%im, ends%im)
        widest = max(widest, abs(line%pole%re))
        lives = max(lives, life)
      end associate
    end do
    if (.not. present(place)) then
      where (used > 0) used = max(min(used, enough_for(size(lines))), min(used, ceiling(lives)))
    end if
    n = maxval(used)
    width = (highest - lowest)*n/(4*pi) + min(widest, 1.0_dp)*n/pi + 1
    blocks = sums_for(width)
    band%centre = (lowest + highest)/2
    band%is_real = min(lowest, pi - highest)*n <= 2*pi*blocks
    if (band%is_real) then
      band%centre = merge(0.0_dp, pi, lowest + highest < pi)
      width = width + abs(band%centre - (lowest + highest)/2)*n/(2*pi)
      blocks = sums_for(width)
    end if
    band%length = n/blocks
    if (band%length < 2 .or. present(place)) then
      band%length = 1
      band%centre = 0
      band%is_real = .true.
    end if
    do b = 0, ubound(used, 1)
      shares(b) = min(1, used(b))
      if (have_gaps(stretches(1, b), used(b) + noise%lost)) shares(b) = shares(b)*size(noise%order)
    end do
    allocate (band%part(sum(shares)))
    n = 0
    do b = 0, ubound(used, 1)
      do k = 1, shares(b)
        n = n + 1
        associate (part => band%part(n))
          part%stretch = b
          part%first = stretches(1, b)
          part%used = used(b)
          part%length = stretches(2, b) - stretches(1, b) + 1
          part%sensors = k + [0, size(noise%order) - shares(b)]
          part%missing = missing_among(missing(k)%place, part%first, part%used, noise%filter(:noise%order(k), k))
          if (present(place)) part%place = place(part%first:part%first + part%used - 1) - place(part%first)
        end associate
        call find_traces(band, band%part(n))
        call find_weights(band, band%part(n))
      end do
    end do

  contains

    pure logical function have_gaps(first, count)
      !! Whether samples of any component are missing among these.
      integer, intent(in) :: first, count
      integer :: k
      have_gaps = any([(any(missing(k)%place >= first .and. missing(k)%place < first + count), k=1, size(missing))])
    end function have_gaps

  end function band_around

  pure function tapered_band(count, image, first, noise) result(band)
    !! The band of given bins of a record's tapered transform.
    integer, intent(in) :: count             !! samples of the record
    integer, intent(in) :: first
    complex(dp), intent(in) :: image(first:, :) !! (bins, S)
    real(dp), intent(in) :: noise            !! standard deviation of a real number of the image
    type(band_type) :: band
    integer :: s
    band%tapered = .true.
    band%bins = [first, ubound(image, 1)]
    band%longest = count
    allocate (band%part(1))
    associate (part => band%part(1))
      part%stretch = 1
      part%used = count
      part%sensors = [1, size(image, 2)]
      allocate (part%turn(0))
      allocate (part%root(2*size(image, 1), 1), source=noise)
      allocate (part%rows(2*size(image, 1), size(image, 2)))
      do s = 1, size(image, 2)
        part%rows(:, s) = parts(image(:, s))/noise
      end do
    end associate
  end function tapered_band

  pure logical function holds(band, line, m)
    !! Whether the sums of a band resolve a line, m steps after a blow.
    type(band_type), intent(in) :: band
    type(line_type), intent(in) :: line
    real(dp), intent(in) :: m
    complex(dp) :: pole
    pole = pole_at(line, m)
    holds = band%length == 1 .or. abs(pole%im - band%centre) + abs(pole%re) < resolved*pi/band%length
  end function holds

  pure integer function enough_for(lines)
    !! Number of samples from which amplitudes of so many lines can be estimated.
    integer, intent(in) :: lines
    enough_for = 4*lines + 16
  end function enough_for

  pure integer function sums_for(width)
    !! Number of sums for a band of `width` bins on either side of its centre.
    real(dp), intent(in) :: width
    sums_for = ceiling(min(sums_per_bin*width, max(real(ample, dp), fewest_per_bin*width)))
  end function sums_for

  pure subroutine find_traces(band, part)
    !! Find the blocks that missing samples enter, and their contributions.
    type(band_type), intent(in) :: band
    type(band_part), intent(inout) :: part
    complex(dp) :: turned(0:ubound(part%missing%filter, 1)), turn
    integer :: i, j, q, low, high
    associate (g => part%missing%place, h => part%missing%filter)
      allocate (part%block(size(g)))
      allocate (part%trace(0:(ubound(h, 1) + band%length - 1)/band%length, size(g)), source=(0.0_dp, 0.0_dp))
      turned = [(h(i)*exp(cmplx(0, band%centre*i, dp)), i=0, ubound(h, 1))]
      do j = 1, size(g)
        call find_reach(part%missing, j, low, high)
        part%block(j) = (g(j) - low - 1)/band%length + 1
        turn = exp(cmplx(0, -band%centre*(g(j) - 1), dp))
        do i = low, high
          q = part%block(j) - (g(j) - i - 1)/band%length - 1
          part%trace(q, j) = part%trace(q, j) + turn*turned(i)
        end do
      end do
    end associate
  end subroutine find_traces

  pure subroutine find_weights(band, part)
    !! Find the factors that make the noise of a part's rows white; if samples are missing, for a line at the centre of the band. A
    !! row without noise has no information: it is divided by a huge number.
    type(band_type), intent(in) :: band
    type(band_part), intent(inout) :: part
    complex(dp) :: p
    real(dp) :: n
    integer :: blocks, j
    complex(dp), allocatable :: fills(:, :)  !! of a wave at the centre of the band
    complex(dp), allocatable :: n_taken(:), p_taken(:)
    blocks = (part%used + band%length - 1)/band%length
    allocate (part%turn(blocks), source=(1.0_dp, 0.0_dp))
    allocate (part%root(blocks, merge(1, 2, band%is_real)))
    if (band%length == 1) then
      part%root(:, :) = 1
      return
    end if
    fills = line_fills(part, wave_of(cmplx(0, band%centre, dp)), 0)
    n_taken = traces_of(part, fills(:, 1))
    p_taken = traces_of(part, conjg(fills(:, 1)))
    do j = 1, blocks
      n = min(band%length, part%used - (j - 1)*band%length)
      p = sum_of(cmplx(0, -2*band%centre, dp), nint(n))*exp(cmplx(0, -2*band%centre*(j - 1)*band%length, dp))
      n = max(n - n_taken(j)%re, n/2)
      p = p - p_taken(j)
      part%root(j, 1) = sqrt(n)
      if (band%is_real) cycle
      part%turn(j) = exp(cmplx(0, -atan2(p%im, p%re)/2, dp))
      part%root(j, :) = [sqrt((n + abs(p))/2), sqrt(max(n - abs(p), 0.0_dp)/2)]
      if (part%root(j, 2) < noiseless*part%root(j, 1)) part%root(j, 2) = huge(1.0_dp)
    end do
  end subroutine find_weights

  pure type(line_type) function wave_of(pole) result(line)
    !! A line with this pole.
    complex(dp), intent(in) :: pole
    line%pole = pole
    allocate (line%courses(0))
  end function wave_of

  pure complex(dp) function sum_of(rate, count)
    !! Σ e^(rate·l), l = 0 … count − 1.
    complex(dp), intent(in) :: rate
    integer, intent(in) :: count
    complex(dp) :: ratio
    ratio = exp(rate)
    sum_of = count
    if (abs(ratio - 1) > 1.0e-6_dp) sum_of = (1 - exp(rate*count))/(1 - ratio)
  end function sum_of

  pure subroutine fill_rows(white, band)
    !! Fill a band with the rows of white samples, (N, S).
    real(dp), intent(in) :: white(:, :)
    type(band_type), intent(inout) :: band
    complex(dp) :: turn(0:band%length - 1)
    complex(dp), allocatable :: sums(:), start(:)
    real(dp) :: re(band%length), im(band%length)
    real(dp), allocatable :: own(:)
    integer :: b, s, j, n, low
    turn = [(exp(cmplx(0, -band%centre*n, dp)), n=0, band%length - 1)]
    re = turn%re
    im = turn%im
    do b = 1, size(band%part)
      associate (part => band%part(b))
        allocate (part%rows(size(part%root), part%sensors(1):part%sensors(2)))
        allocate (sums(size(part%turn)), start(size(part%turn)))
        start(:) = [(exp(cmplx(0, -band%centre*real(band%length, dp)*j, dp)), j=0, size(part%turn) - 1)]
        do s = part%sensors(1), part%sensors(2)
          own = white(part%first:part%first + part%used - 1, s)
          call project_out_missing(part%missing, own)
          if (band%length == 1) then
            part%rows(:, s) = own
            cycle
          end if
          do j = 1, size(sums)
            low = (j - 1)*band%length + 1
            n = min(band%length, part%used - (j - 1)*band%length)
            sums(j) = cmplx(ddot(n, own(low:low + n - 1), 1, re, 1), ddot(n, own(low:low + n - 1), 1, im, 1), dp)
          end do
          part%rows(:, s) = rows_of(part, start*sums)
        end do
        deallocate (sums, start)
      end associate
    end do
  end subroutine fill_rows

  pure subroutine add_to_band(lines, band)
    !! Add lines, with their amplitudes, to the rows of a band.
    type(line_type), intent(in) :: lines(:)
    type(band_type), intent(inout) :: band
    real(dp), allocatable :: columns(:, :, :)
    integer :: p, k, s
    do p = 1, size(band%part)
      associate (part => band%part(p))
        do k = 1, size(lines)
          columns = line_columns(band, part, lines(k), 0)
          do s = part%sensors(1), part%sensors(2)
            associate (a => lines(k)%amplitude(s, part%stretch + 1))
              part%rows(:, s) = part%rows(:, s) + a%re*columns(:, 1, 1) + a%im*columns(:, 2, 1)
            end associate
          end do
        end do
      end associate
    end do
  end subroutine add_to_band

end module bw_band
