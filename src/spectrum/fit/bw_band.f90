module bw_band
  !! A band of a record around a few lines: the samples, turned by the frequency in its middle and summed over blocks.
  !!
  !! A few hundred complex sums hold what the record says of a line near the middle, to a few thousandths of its
  !! information, and the image of any exponential is known exactly. The rows are real numbers whose noise is white and has
  !! the variance of the samples' noise near the middle. A sum of n samples, turned by e^(−iθ), has a noise x + iy of E|x + iy|² = n
  !! and E(x + iy)² = p = Σ e^(−2iθ): turned by −½ arg p its parts are independent, with variances (n ± |p|)/2. |p| is n where a
  !! block is one sample, and hardly 0 where uneven times let a line meet its mirror image anywhere. Near 0 and half the sampling
  !! rate the rows are the real samples themselves or their sums.
  !!
  !! Where a record holds no noise but other lines, a few bins of the tapered transform serve instead: they tell less of a line,
  !! and nothing of lines in other bins.
  use bw_block_sums, only: block_sums, blocks_type, even_blocks, find_moments, part_of
  use bw_damped_line, only: damped_line
  use bw_kinds, only: dp
  use bw_lapack, only: ddot
  use bw_samples, only: centre_of, find_wave, phase_factor, samples_type, span_of
  use bw_tapered_line, only: parts, tapered_columns
  implicit none (type, external)
  private
  public :: band_around, cut_band, fill_bands, line_columns, still_columns, tapered_band, uneven_rows

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: sums_per_bin = 32    !! loses (π/32)²/3 of the information at the edge of the band
  integer, parameter :: ample = 2048         !! sums that tell enough of a broad line, whose information is near its middle
  integer, parameter :: fewest_per_bin = 8   !! loses 5 % at the edge of so broad a band
  real(dp), parameter :: noiseless = 1.0e-6_dp  !! of the noise of the other row of a block
  integer, parameter :: samples_at_once = 16384  !! of one sensor, which fit a processor's cache
  real(dp), parameter :: clear = 1           !! widths of a block's transform between a band and its mirror image

  type, public :: band_type
    real(dp) :: centre = 0                   !! periods per step
    real(dp) :: half_width = 0               !! bins, of 1/span each
    logical :: is_real = .false.             !! the sums of the mirror image are the same numbers
    type(blocks_type) :: blocks
    complex(dp), allocatable :: turn(:)      !! that makes the two rows of a block independent, (B)
    real(dp), allocatable :: root(:, :)      !! what they are divided by, (B, 2), or (B, 1)
    real(dp), allocatable :: rows(:, :)      !! the record, (rows, S)
    logical :: tapered = .false.             !! the rows are bins of the tapered transform, and there are no blocks
    integer :: bins(2) = 0                   !! the first and the last of these
  end type band_type

contains

  function band_around(samples, lowest, highest, widest) result(band)
    !! The band that holds lines between two frequencies whose decays are up to `widest` (per step, of either sign), without rows.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: lowest, highest, widest
    type(band_type) :: band
    real(dp) :: span, width
    integer :: blocks
    span = span_of(samples)
    width = (highest - lowest)*span/2 + widest*span/pi + 1
    band%centre = (lowest + highest)/2
    blocks = sums_for(width)
    band%is_real = min(lowest, nyquist_of(samples) - highest)*span <= clear*blocks
    if (band%is_real) then
      band%centre = merge(0.0_dp, 0.5_dp, allocated(samples%place) .or. lowest + highest < 0.5_dp)
      width = abs(band%centre - (lowest + highest)/2)*span + width
      blocks = sums_for(width)
    end if
    if (2*blocks > samples%count) then
      blocks = samples%count
      band%centre = 0
      band%is_real = .true.
    end if
    band%half_width = width
    band%blocks = even_blocks(samples, blocks)
    if (allocated(samples%place)) call find_moments(samples, [0.0_dp, -2*band%centre], band%blocks)
    call find_noise(samples, band)
  end function band_around

  pure integer function sums_for(width)
    !! How many sums a band needs of so many bins to either side of its middle.
    real(dp), intent(in) :: width
    sums_for = ceiling(min(sums_per_bin*width, max(real(ample, dp), fewest_per_bin*width)))
  end function sums_for

  pure function tapered_band(image, first) result(band)
    !! The band of these bins of a tapered transform.
    integer, intent(in) :: first
    complex(dp), intent(in) :: image(first:, :)  !! (bins, S)
    type(band_type) :: band
    integer :: s
    band%tapered = .true.
    band%bins = [first, ubound(image, 1)]
    allocate (band%rows(2*size(image, 1), size(image, 2)))
    do s = 1, size(image, 2)
      band%rows(:, s) = parts(image(:, s))
    end do
  end function tapered_band

  pure real(dp) function nyquist_of(samples)
    !! Half the sampling rate, in periods per step; uneven times have none.
    type(samples_type), intent(in) :: samples
    nyquist_of = merge(huge(1.0_dp), 0.5_dp, allocated(samples%place))
  end function nyquist_of

  subroutine find_noise(samples, band)
    !! Find what makes the noise of a band's rows white. A row without noise tells nothing: it is divided by what makes it 0.
    type(samples_type), intent(in) :: samples
    type(band_type), intent(inout) :: band
    complex(dp) :: p(size(band%blocks%first) - 1, 0:0)
    real(dp) :: n(size(p, 1))
    associate (first => band%blocks%first)
      n = first(2:) - first(:size(first) - 1)
    end associate
    allocate (band%turn(size(n)), source=(1.0_dp, 0.0_dp))
    if (band%is_real) then
      band%root = reshape(sqrt(n), [size(n), 1])
      return
    end if
    p = block_sums(samples, band%blocks, 0.0_dp, -2*band%centre, 0, [complex(dp) ::])
    band%turn = exp(cmplx(0, -atan2(p(:, 0)%im, p(:, 0)%re)/2, dp))
    band%root = reshape([sqrt((n + abs(p(:, 0)))/2), sqrt(max(n - abs(p(:, 0)), 0.0_dp)/2)], [size(n), 2])
    where (band%root(:, 2) < noiseless*band%root(:, 1)) band%root(:, 2) = huge(1.0_dp)
  end subroutine find_noise

  pure function rows_of(band, sums) result(rows)
    !! Complex sums over blocks as real rows of unit weight.
    type(band_type), intent(in) :: band
    complex(dp), intent(in) :: sums(:)       !! (B)
    real(dp) :: rows(size(band%root))
    complex(dp) :: turned(size(sums))
    if (band%is_real) then
      rows = sums%re/band%root(:, 1)
    else
      turned = sums*band%turn
      rows = [turned%re/band%root(:, 1), turned%im/band%root(:, 2)]
    end if
  end function rows_of

  pure subroutine fill_bands(samples, bands)
    !! Give bands their rows.
    type(samples_type), intent(in) :: samples
    type(band_type), intent(inout) :: bands(:)
    integer :: i
    if (.not. allocated(samples%place)) then
      call fill_evenly(samples, bands)
    else
      do i = 1, size(bands)
        bands(i)%rows = uneven_rows(samples, bands(i), samples%value)
      end do
    end if
  end subroutine fill_bands

  pure subroutine fill_evenly(samples, bands)
    !! Give bands their rows of even samples. A long record is read once for all of them, stretch by stretch.
    type(samples_type), intent(in) :: samples
    type(band_type), intent(inout) :: bands(:)
    type :: sums_type
      real(dp), allocatable :: re(:), im(:)  !! the wave that turns the even samples of a block
      complex(dp), allocatable :: turn(:)    !! and that of each block
      complex(dp), allocatable :: sums(:)
      integer :: next = 1                    !! block
    end type sums_type
    type(sums_type) :: work(size(bands))
    integer :: i, n, s, first
    do i = 1, size(bands)
      associate (band => bands(i), own => work(i))
        allocate (band%rows(size(band%root), size(samples%value, 2)), own%sums(size(band%turn)))
        own%turn = phase_factor(-band%centre, [(n, n=0, longest_block(band%blocks) - 1)])
        own%re = own%turn%re
        own%im = own%turn%im
        own%turn = phase_factor(-band%centre, band%blocks%first(:size(band%turn)) - 1)
      end associate
    end do
    do s = 1, size(samples%value, 2)
      work%next = 1
      do first = 1, samples%count, samples_at_once
        do i = 1, size(bands)
          associate (own => work(i))
            call add_blocks(samples, s, first + samples_at_once, bands(i), own%re, own%im, own%sums, own%next)
          end associate
        end do
      end do
      do i = 1, size(bands)
        work(i)%sums = work(i)%turn*work(i)%sums
        bands(i)%rows(:, s) = rows_of(bands(i), work(i)%sums)
      end do
    end do
  end subroutine fill_evenly

  pure subroutine add_blocks(samples, s, last, band, re, im, sums, next)
    !! Sum one sensor's samples, turned by the band's centre, over each block that starts before sample `last`.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: s, last
    type(band_type), intent(in) :: band
    real(dp), contiguous, intent(in) :: re(:), im(:)
    complex(dp), intent(inout) :: sums(:)
    integer, intent(inout) :: next
    integer :: low, high
    do while (next <= size(sums))
      low = band%blocks%first(next)
      high = band%blocks%first(next + 1) - 1
      if (low >= last) return
      sums(next) = turned_sum(samples%value(low:high, s), re, im)
      next = next + 1
    end do
  end subroutine add_blocks

  pure function uneven_rows(samples, band, value) result(rows)
    !! The rows of values at the samples' uneven times, (rows, S).
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    real(dp), intent(in) :: value(:, :)      !! (N or more, S)
    real(dp) :: rows(size(band%root), size(value, 2))
    complex(dp) :: sums(size(band%turn), size(value, 2))
    real(dp), allocatable :: along(:), across(:)
    integer :: b, s
    do b = 1, size(sums, 1)
      associate (first => band%blocks%first(b), last => band%blocks%first(b + 1) - 1)
        allocate (along(last - first + 1), across(last - first + 1))
        call find_wave(samples%place(first:last), centre_of(samples), 0.0_dp, -band%centre, [complex(dp) ::], along, across)
        do s = 1, size(value, 2)
          sums(b, s) = turned_sum(value(first:last, s), along, across)
        end do
        deallocate (along, across)
      end associate
    end do
    do s = 1, size(value, 2)
      rows(:, s) = rows_of(band, sums(:, s))
    end do
  end function uneven_rows

  pure integer function longest_block(blocks)
    !! Samples of the longest block.
    type(blocks_type), intent(in) :: blocks
    longest_block = maxval(blocks%first(2:) - blocks%first(:size(blocks%first) - 1))
  end function longest_block

  pure complex(dp) function turned_sum(value, re, im)
    !! The sum of numbers times those of a wave.
    real(dp), contiguous, intent(in) :: value(:)
    real(dp), contiguous, intent(in) :: re(:), im(:)  !! as many or more
    turned_sum = cmplx(ddot(size(value), value, 1, re, 1), ddot(size(value), value, 1, im, 1), dp)
  end function turned_sum

  function line_columns(samples, band, line, order) result(columns)
    !! The rows of u^m e^(−dτ) cos 2πfτ and of −u^m e^(−dτ) sin 2πfτ, which are a line of amplitude 1 and one of amplitude
    !! i, for m = 0 … order, (rows, 2, 0:order); bent as the line is.
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    type(damped_line), intent(in) :: line
    integer, intent(in) :: order             !! at most 1 in a tapered band
    real(dp) :: columns(size(band%rows, 1), 2, 0:order)
    if (band%tapered) then
      columns = tapered_columns(line, samples%count, band%bins(1), band%bins(2), order)
    else
      columns = summed_columns(samples, band, line%decay, line%frequency, order, line%bend(:line%powers))
    end if
  end function line_columns

  function summed_columns(samples, band, decay, frequency, order, bend) result(columns)
    !! The same of a band of sums.
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    real(dp), intent(in) :: decay, frequency
    integer, intent(in) :: order
    complex(dp), intent(in) :: bend(:)
    real(dp) :: columns(size(band%rows, 1), 2, 0:order)
    complex(dp), dimension(size(band%turn), 0:order) :: line, mirror
    integer :: m
    line = block_sums(samples, band%blocks, decay, frequency - band%centre, order, bend)
    if (band%is_real .and. .not. band%centre > 0) then
      mirror = conjg(line)
    else
      mirror = block_sums(samples, band%blocks, decay, -frequency - band%centre, order, conjg(bend))
    end if
    do m = 0, order
      columns(:, 1, m) = rows_of(band, (line(:, m) + mirror(:, m))/2)
      columns(:, 2, m) = rows_of(band, (0, 1)*(line(:, m) - mirror(:, m))/2)
    end do
  end function summed_columns

  function still_columns(samples, band) result(columns)
    !! The rows of an offset and of a slope, 1 and u, (rows, 2).
    type(samples_type), intent(in) :: samples
    type(band_type), intent(in) :: band
    real(dp) :: columns(size(band%rows, 1), 2)
    complex(dp) :: sums(size(band%turn), 0:1)
    sums = block_sums(samples, band%blocks, 0.0_dp, -band%centre, 1, [complex(dp) ::])
    columns(:, 1) = rows_of(band, sums(:, 0))
    columns(:, 2) = rows_of(band, sums(:, 1))
  end function still_columns

  pure subroutine cut_band(band, rows, first, last, part, own)
    !! The part of a band, and of rows like its own, between two fractions of its blocks.
    type(band_type), intent(in) :: band
    real(dp), intent(in) :: rows(:, :)
    real(dp), intent(in) :: first, last      !! 0 … 1
    type(band_type), intent(out) :: part
    real(dp), allocatable, intent(out) :: own(:, :)
    integer :: low, high, blocks
    blocks = size(band%turn)
    low = 1 + nint(first*blocks)
    high = nint(last*blocks)
    part%centre = band%centre
    part%half_width = band%half_width
    part%is_real = band%is_real
    part%blocks = part_of(band%blocks, low, high)
    part%turn = band%turn(low:high)
    part%root = band%root(low:high, :)
    if (band%is_real) then
      own = rows(low:high, :)
    else
      allocate (own(2*size(part%turn), size(rows, 2)))
      own(:size(part%turn), :) = rows(low:high, :)
      own(size(part%turn) + 1:, :) = rows(blocks + low:blocks + high, :)
    end if
    part%rows = own
  end subroutine cut_band

end module bw_band
