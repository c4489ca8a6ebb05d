module bw_line_bands
  !! Lines that share a band, and all bands of a record: each is fitted while the images of all other lines are taken out, in
  !! turn, until nothing moves. Lines further apart than a few bins hardly see each other, so that this ends soon.
  use bw_band, only: band_around, band_type
  use bw_band_fit, only: damped_line, fit_band, fit_type, image_of, still_image
  use bw_kinds, only: dp
  use bw_noise_level, only: level_at, level_knots
  use bw_order, only: ascending
  use bw_samples, only: centre_of, samples_type, span_of
  implicit none (type, external)
  private
  public :: own_rows, prepare_bands, refine

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: together = 4          !! bins between lines of one band
  real(dp), parameter :: near_still = 8        !! bins from 0 within which offset and slope are fitted with the lines
  real(dp), parameter :: margin = 0.7_dp       !! bins that lines may move before their band is made anew
  integer, parameter :: most_sweeps = 12
  real(dp), parameter :: settled = 1.0e-3_dp   !! variances of the noise that a sweep may still gain

  type, public :: line_band
    !! A band, and which lines are in it.
    type(band_type) :: band
    real(dp) :: lowest = 0, highest = 0, widest = 0  !! that it was made for, with a margin
    integer, allocatable :: member(:)          !! indices of its lines; none in the band of offset and slope
    logical :: with_still = .false.            !! offset and slope are fitted here
    real(dp) :: left = huge(1.0_dp)            !! squares of what its lines leave, over the noise's variance
  end type line_band

contains

  subroutine prepare_bands(samples, lines, bands)
    !! Part the lines into bands; a band that is there already and holds its lines is used again. The first band is that of
    !! offset and slope, without members where these are fitted with lines.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    type(line_band), allocatable, intent(inout) :: bands(:)
    type(line_band), allocatable :: fresh(:)
    integer :: order(size(lines)), i, first
    order = ascending(lines%frequency)
    allocate (fresh(1))
    call make(samples, 0.0_dp, 0.0_dp, 0.0_dp, bands, fresh(1))
    allocate (fresh(1)%member(0))
    fresh(1)%with_still = .true.
    first = 1
    do i = 1, size(lines)
      if (i < size(lines)) then
        if (close_by(lines(order(first:i)), lines(order(i + 1)))) cycle
      end if
      fresh = [fresh, band_of(order(first:i))]
      first = i + 1
    end do
    if (size(fresh) > 1) fresh(1)%with_still = .not. any(fresh(2:)%with_still)
    call move_alloc(fresh, bands)

  contains

    pure logical function close_by(group, line)
      !! Whether the line is within a few bins, and widths, of any of the others.
      type(damped_line), intent(in) :: group(:), line
      close_by = any(abs(group%frequency - line%frequency)*span_of(samples) < &
        & together + (width_of(samples, group) + width_of(samples, line))*span_of(samples)/pi)
    end function close_by

    function band_of(member) result(new)
      integer, intent(in) :: member(:)
      type(line_band) :: new
      associate (own => lines(member))
        call make(samples, minval(own%frequency), maxval(own%frequency), maxval(width_of(samples, own)), bands, new)
        new%with_still = minval(own%frequency)*span_of(samples) - maxval(width_of(samples, own))*span_of(samples)/pi < near_still
      end associate
      new%member = member
    end function band_of

  end subroutine prepare_bands

  elemental real(dp) function width_of(samples, line)
    !! The largest decay, and change of 2π·frequency, of a line anywhere in the record.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: line
    integer :: m
    width_of = abs(line%decay) + sum([(m*abs(line%bend(m)), m=2, line%powers)])/centre_of(samples)
  end function width_of

  subroutine make(samples, lowest, highest, widest, bands, new)
    !! Find the band among those that are there, or make it.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: lowest, highest, widest
    type(line_band), allocatable, intent(in) :: bands(:)
    type(line_band), intent(inout) :: new
    integer :: i
    real(dp) :: span
    span = span_of(samples)
    if (allocated(bands)) then
      do i = 1, size(bands)
        if (bands(i)%lowest > lowest .or. bands(i)%highest < highest .or. bands(i)%widest < widest) cycle
        if (highest > 0 .and. .not. bands(i)%highest > 0) cycle
        if (bands(i)%widest > 4*widest + 8/span) cycle
        if (bands(i)%highest - bands(i)%lowest > 4*(highest - lowest) + 8/span) cycle
        new%band = bands(i)%band
        new%lowest = bands(i)%lowest
        new%highest = bands(i)%highest
        new%widest = bands(i)%widest
        return
      end do
    end if
    new%lowest = max(lowest - margin/span, 0.0_dp)
    new%highest = highest
    if (highest > 0) new%highest = highest + margin/span
    if (.not. allocated(samples%place)) new%highest = min(new%highest, 0.5_dp)
    new%widest = 1.5_dp*widest + merge(1/span, 0.0_dp, highest > 0)
    new%band = band_around(samples, new%lowest, new%highest, new%widest)
  end subroutine make

  function own_rows(samples, lines, still, band) result(rows)
    !! The rows of a band without the lines that are not its own, and without offset and slope where they are not.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    type(line_band), intent(in) :: band
    real(dp), allocatable :: rows(:, :)
    integer :: k
    rows = band%band%rows
    if (.not. band%with_still) rows = rows - still_image(samples, band%band, still)
    do k = 1, size(lines)
      if (any(band%member == k)) cycle
      rows = rows - image_of(samples, band%band, lines(k))
    end do
  end function own_rows

  subroutine refine(samples, noise, bands, lines, still)
    !! Fit band after band until nothing is gained.
    type(samples_type), intent(in) :: samples
    type(level_knots), intent(in) :: noise
    type(line_band), intent(inout) :: bands(:)
    type(damped_line), intent(inout) :: lines(:)
    real(dp), intent(inout) :: still(:, :)
    type(fit_type) :: fit
    real(dp), allocatable :: rows(:, :), weight(:)
    real(dp) :: before, moved
    integer :: sweep, i
    do sweep = 1, most_sweeps
      moved = 0
      do i = 1, size(bands)
        if (size(bands(i)%member) == 0 .and. .not. bands(i)%with_still) cycle
        before = bands(i)%left
        rows = own_rows(samples, lines, still, bands(i))
        weight = 1/level_at(noise, bands(i)%band%centre, size(still, 2))
        fit%lines = lines(bands(i)%member)
        call fit_band(samples, bands(i)%band, rows, weight, bands(i)%with_still, fit)
        lines(bands(i)%member) = fit%lines
        if (bands(i)%with_still) still = fit%still
        bands(i)%left = fit%left
        moved = max(moved, abs(before - fit%left))
      end do
      if (moved < settled .or. size(bands) == 1) exit
    end do
  end subroutine refine

end module bw_line_bands
