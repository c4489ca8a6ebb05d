module bw_band_columns
  !! The rows of a band, and the image of a line in them: the sums over blocks of an exponential, in closed form.
  use bw_kinds, only: dp
  use bw_line, only: bend_of, find_wave, limited, line_type, pole_at, psi, psi_bend, psi_by_rate, psi_slope
  use bw_missing_samples, only: fills_of, find_reach, missing_type
  use bw_tapered_line, only: tapered_columns
  implicit none (type, external)
  private
  public :: line_columns, line_fills, rows_of, traces_of, trend_columns

  integer, parameter :: series = 8           !! powers of time within a block in the expansion of a drift
  real(dp), parameter :: least_part = 1.0e-3_dp  !! of a line's norm that is left beside missing samples; less determines nothing

  type, public :: band_part
    !! The rows of one stretch after a blow: of all sensors, or of one if samples are missing, as they depend on its noise.
    integer :: stretch = 0
    integer :: first = 1                     !! first sample
    integer :: used = 0                      !! number of samples
    integer :: length = 0                    !! number of samples with rows in the stretch, used or not
    integer :: sensors(2) = 1                !! first and last
    type(missing_type) :: missing            !! missing samples that enter the rows
    integer, allocatable :: block(:)         !! the last block that each of them enters
    complex(dp), allocatable :: trace(:, :)  !! sums over blocks of the response to 1 in its place, from the last block backwards
    real(dp), allocatable :: place(:)        !! times of uneven samples since the blow, in steps, (used)
    complex(dp), allocatable :: turn(:)      !! rotates sums so that the two rows of a block are independent, (blocks)
    real(dp), allocatable :: root(:, :)      !! standard deviations of rows, by which they are divided, (blocks, 2), or (blocks, 1)
    real(dp), allocatable :: rows(:, :)      !! the record, (rows, S)
  end type band_part

  type, public :: band_type
    real(dp) :: centre = 0                   !! rad per step
    integer :: length = 1                    !! samples in a block
    real(dp) :: longest = 1                  !! samples of the longest stretch
    logical :: is_real = .true.              !! the rows are real sums
    logical :: tapered = .false.             !! the rows are bins of a tapered transform instead, real parts above imaginary ones
    integer :: bins(2) = 0                   !! first and last of these
    type(band_part), allocatable :: part(:)
  end type band_type

contains

  pure function line_columns(band, part, line, slopes) result(columns)
    !! The rows of a line of amplitude 1 and of one of amplitude i, and their derivatives by the pole, and by κ and κ·rate of each
    !! course, (rows, 2, 0:slopes).
    type(band_type), intent(in) :: band
    type(band_part), intent(in) :: part
    type(line_type), intent(in) :: line
    integer, intent(in) :: slopes
    real(dp) :: columns(size(part%root), 2, 0:slopes)
    complex(dp), dimension(size(part%turn), 0:slopes) :: own, mirror
    type(line_type) :: turned
    integer :: k
    if (band%tapered) then
      columns = tapered_columns(line, part%used, band%bins, slopes)/part%root(1, 1)
      return
    end if
    if (part%stretch == 0 .and. .not. line%steady) then
      columns = 0
      return
    end if
    own = images(band, part, line, slopes)
    if (band%is_real .and. band%centre <= 0) then
      do k = 0, slopes
        columns(:, 1, k) = own(:, k)%re/part%root(:, 1)
        columns(:, 2, k) = -own(:, k)%im/part%root(:, 1)
      end do
      return
    end if
    turned = line
    turned%pole = conjg(line%pole)
    turned%courses%bend = conjg(line%courses%bend)
    mirror = images(band, part, turned, slopes)
    do k = 0, slopes
      columns(:, 1, k) = rows_of(part, (own(:, k) + mirror(:, k))/2)
      columns(:, 2, k) = rows_of(part, (0, 1)*(own(:, k) - mirror(:, k))/2)
    end do
  end function line_columns

  pure function trend_columns(band, part) result(columns)
    !! The rows of an offset and of a slope over the part, (rows, 2).
    type(band_type), intent(in) :: band
    type(band_part), intent(in) :: part
    real(dp) :: columns(size(part%root), 2)
    type(line_type) :: trend
    complex(dp) :: sums(size(part%turn), 0:1)
    allocate (trend%courses(0))
    sums = images(band, part, trend, 1)
    columns(:, 1) = rows_of(part, sums(:, 0))
    columns(:, 2) = rows_of(part, sums(:, 1)/max(1, part%used))
  end function trend_columns

  pure function images(band, part, line, slopes) result(sums)
    !! Sums over blocks of e^(zm + Σκψ − iω_c m), and of its products with m, and with ψ and ∂ψ/∂rate of each course,
    !! (blocks, 0:slopes).
    type(band_type), intent(in) :: band
    type(band_part), intent(in) :: part
    type(line_type), intent(in) :: line
    integer, intent(in) :: slopes
    complex(dp) :: sums(size(part%turn), 0:slopes)
    complex(dp) :: wave(size(part%turn)), moment(0:series + 2), last_moment(0:series + 2), middle
    real(dp) :: m, by_rate(0:2)
    real(dp), allocatable :: places(:)
    integer :: blocks, j, c
    type(line_type) :: turned
    blocks = size(part%turn)
    turned = line
    turned%pole = line%pole - cmplx(0, band%centre, dp)
    if (band%length == 1) then
      places = [(real(j, dp), j=0, blocks - 1)]
      if (allocated(part%place)) places = part%place
      if (allocated(part%place)) then
        call find_wave(line, 0.0_dp, places, wave)
      else
        call find_wave(line, 0.0_dp, wave=wave)
      end if
      sums(:, 0) = wave
      if (slopes > 0) sums(:, 1) = wave*places
      do c = 1, (slopes - 1)/2
        do j = 1, blocks
          by_rate = psi_by_rate(line%courses(c)%rate, places(j))
          sums(j, 2*c) = wave(j)*psi(line%courses(c)%rate, places(j))
          sums(j, 2*c + 1) = wave(j)*by_rate(0)
        end do
      end do
      call subtract_fills()
      return
    end if
    middle = turned%pole
    if (size(line%courses) > 0) middle = pole_at(turned, part%used/2.0_dp)
    moment = moments(middle, band%length, merge(series + 2, 1, size(line%courses) > 0))
    last_moment = moments(middle, part%used - (blocks - 1)*band%length, merge(series + 2, 1, size(line%courses) > 0), band%length)
    if (size(line%courses) == 0) then
      turned%pole = turned%pole*band%length
      call find_wave(turned, 0.0_dp, wave=wave)
      sums(:, 0) = wave*moment(0)
      if (slopes > 0) sums(:, 1) = wave*band%length*(moment(0)*[(real(j, dp), j=0, blocks - 1)] + moment(1))
      sums(blocks, 0) = wave(blocks)*last_moment(0)
      if (slopes > 0) sums(blocks, 1) = wave(blocks)*band%length*((blocks - 1)*last_moment(0) + last_moment(1))
      turned%pole = line%pole - cmplx(0, band%centre, dp)
    else
      do j = 1, blocks
        m = real(j - 1, dp)*band%length
        if (j == blocks) moment = last_moment
        sums(j, :) = limited(turned%pole*m + bend_of(line, m))*drifting_sums(m)
      end do
    end if
    call subtract_fills()

  contains

    pure subroutine subtract_fills()
      !! Subtract what missing samples contribute. Of a line that lives at missing samples only, rounding would be left.
      complex(dp), allocatable :: fills(:, :)
      real(dp) :: whole
      integer :: c
      if (size(part%missing%place) == 0) return
      fills = line_fills(part, line, slopes)
      whole = norm2(abs(sums(:, 0)))
      do c = 0, slopes
        sums(:, c) = sums(:, c) - traces_of(part, fills(:, c + 1))
      end do
      if (norm2(abs(sums(:, 0))) < least_part*whole) sums = 0
    end subroutine subtract_fills

    pure function drifting_sums(m) result(own)
      !! The same for a block that begins m steps after the blow, over the exponential there.
      real(dp), intent(in) :: m
      complex(dp) :: own(0:slopes), a(0:series), part_of(0:2), y, bent
      real(dp) :: length, by_rate(0:2)
      integer :: k, q
      length = band%length
      y = (pole_at(turned, m) - middle)*length
      bent = sum(line%courses%bend*psi_bend(line%courses%rate, m))*length**2
      a(0) = 1
      a(1) = y
      do k = 2, series
        a(k) = (y*a(k - 1) + bent*a(k - 2))/k
      end do
      part_of = [(sum(a*moment(q:q + series)), q=0, 2)]
      own(0) = part_of(0)
      if (slopes > 0) own(1) = m*part_of(0) + length*part_of(1)
      do q = 1, (slopes - 1)/2
        associate (g => line%courses(q)%rate)
          own(2*q) = psi(g, m)*part_of(0) + psi_slope(g, m)*length*part_of(1) + psi_bend(g, m)/2*length**2*part_of(2)
          by_rate = psi_by_rate(g, m)
          own(2*q + 1) = by_rate(0)*part_of(0) + by_rate(1)*length*part_of(1) + by_rate(2)/2*length**2*part_of(2)
        end associate
      end do
    end function drifting_sums

  end function images

  pure function moments(rate, count, highest, length) result(moment)
    !! The sums Σ (l/length)^q e^(rate·l), l = 0 … count − 1, q = 0 … highest.
    complex(dp), intent(in) :: rate
    integer, intent(in) :: count, highest
    integer, intent(in), optional :: length  !! `count` if absent
    complex(dp) :: moment(0:series + 2), term(0:count - 1)
    real(dp) :: place(0:count - 1)
    type(line_type) :: line
    integer :: q
    line%pole = rate
    allocate (line%courses(0))
    call find_wave(line, 0.0_dp, wave=term)
    if (present(length)) then
      place = [(real(q, dp)/length, q=0, count - 1)]
    else
      place = [(real(q, dp)/count, q=0, count - 1)]
    end if
    moment = 0
    do q = 0, highest
      moment(q) = sum(term)
      term = term*place
    end do
  end function moments

  pure function line_fills(part, line, slopes) result(fills)
    !! The values at missing samples that fit a line's rows best, and those for its products with m, and with ψ and ∂ψ/∂rate of
    !! each course, (missing, 1 + slopes).
    type(band_part), intent(in) :: part
    type(line_type), intent(in) :: line
    integer, intent(in) :: slopes
    complex(dp), allocatable :: fills(:, :)
    complex(dp) :: wave(size(part%missing%place))
    real(dp) :: factors(size(wave), 0:slopes), by_rate(0:2), m
    integer :: j, q, low, high
    do j = 1, size(wave)
      call find_reach(part%missing, j, low, high)
      m = part%missing%place(j) - 1
      if (allocated(part%place)) m = part%place(part%missing%place(j))
      wave(j) = limited(line%pole*(m - high) + bend_of(line, m - high))
      factors(j, 0) = 1
      if (slopes > 0) factors(j, 1) = m
      do q = 1, (slopes - 1)/2
        by_rate = psi_by_rate(line%courses(q)%rate, m)
        factors(j, 2*q:2*q + 1) = [psi(line%courses(q)%rate, m), by_rate(0)]
      end do
    end do
    fills = fills_of(part%missing, line%pole, wave, factors)
  end function line_fills

  pure function traces_of(part, fills) result(sums)
    !! The sums over blocks that values at missing samples contribute, (blocks).
    type(band_part), intent(in) :: part
    complex(dp), intent(in) :: fills(:)
    complex(dp) :: sums(size(part%turn))
    integer :: j, q
    sums = 0
    do j = 1, size(fills)
      do q = 0, min(ubound(part%trace, 1), part%block(j) - 1)
        sums(part%block(j) - q) = sums(part%block(j) - q) + part%trace(q, j)*fills(j)
      end do
    end do
  end function traces_of

  pure function rows_of(part, sums) result(rows)
    !! Convert complex sums over blocks to real rows of unit variance.
    type(band_part), intent(in) :: part
    complex(dp), intent(in) :: sums(:)       !! (blocks)
    real(dp) :: rows(size(part%root))
    complex(dp) :: turned(size(sums))
    if (size(part%root, 2) == 1) then
      rows = sums%re/part%root(:, 1)
    else
      turned = sums*part%turn
      rows = [turned%re/part%root(:, 1), turned%im/part%root(:, 2)]
    end if
  end function rows_of

end module bw_band_columns
