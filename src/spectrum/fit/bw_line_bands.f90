module bw_line_bands
  !! Lines that share a band, and all bands of a record: each is fitted while the images of all other lines are taken out, in
  !! turn, until nothing moves. Lines further apart than a few bins hardly see each other, so that this ends soon.
  use bw_band, only: band_around, band_type, fill_bands, uneven_rows
  use bw_band_fit, only: excess, fit_band, fit_type, image_of, still_image
  use bw_damped_line, only: add_uneven, bend_reach, damped_line
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type, stops
  use bw_noise_level, only: level_at, level_knots
  use bw_order, only: ascending
  use bw_samples, only: centre_of, samples_type, span_of
  implicit none (type, external)
  private
  public :: own_rows, prepare_bands, refine, weight_of

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: together = 4          !! bins between lines of one band
  real(dp), parameter :: near_still = 8        !! bins from 0 within which offset and slope are fitted with the lines
  real(dp), parameter :: margin = 0.7_dp       !! bins that lines may move before their band is made anew
  integer, parameter :: most_sweeps = 6
  real(dp), parameter :: most_work = 1.0e8_dp  !! numbers of lines' images, after which no further sweep begins
  real(dp), parameter :: nudged = 0.1_dp       !! bins, by which a line may move and be the same line
  real(dp), parameter :: settled = 1.0e-3_dp   !! variances of the noise that a sweep may still gain
  real(dp), parameter :: unseen = 1.0e-5_dp    !! of these, that the rows of a band may change before it is fitted again
  real(dp), parameter :: same_noise = 0.05_dp  !! of its variance, that it may change

  type, public :: line_band
    !! A band, and which lines are in it.
    type(band_type) :: band
    real(dp) :: lowest = 0, highest = 0, widest = 0  !! that it was made for, with a margin
    integer, allocatable :: member(:)          !! indices of its lines; none in the band of offset and slope
    logical :: with_still = .false.            !! offset and slope are fitted here
    real(dp) :: left = huge(1.0_dp)            !! squares of what its lines leave, over the noise's variance
    type(damped_line), allocatable :: fitted(:)  !! the lines as its last fit left them
    real(dp), allocatable :: seen(:, :)        !! the rows that they were fitted to
    real(dp), allocatable :: weight(:)         !! one over the noise's variance in that fit, (S)
    real(dp) :: refused = huge(1.0_dp)         !! squares, not weighted, that no other shape of its lines takes off
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
    call fill(samples, fresh)
    if (size(fresh) > 1) fresh(1)%with_still = .not. any(fresh(2:)%with_still)
    do i = 1, size(fresh)
      call remember(lines, bands, fresh(i))
    end do
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

  subroutine fill(samples, bands)
    !! Give rows to the bands that have none.
    type(samples_type), intent(in) :: samples
    type(line_band), intent(inout) :: bands(:)
    type(band_type), allocatable :: made(:)
    integer, allocatable :: empty(:)
    integer :: i
    empty = pack([(i, i=1, size(bands))], [(.not. allocated(bands(i)%band%rows), i=1, size(bands))])
    allocate (made(size(empty)))
    do i = 1, size(empty)
      made(i) = bands(empty(i))%band
    end do
    call fill_bands(samples, made)
    do i = 1, size(empty)
      bands(empty(i))%band = made(i)
    end do
  end subroutine fill

  subroutine remember(lines, bands, new)
    !! Let a band know what is known of one with the same rows and lines.
    type(damped_line), intent(in) :: lines(:)
    type(line_band), allocatable, intent(in) :: bands(:)
    type(line_band), intent(inout) :: new
    integer :: i
    if (.not. allocated(bands)) return
    do i = 1, size(bands)
      if (.not. allocated(bands(i)%fitted)) cycle
      if (size(bands(i)%fitted) /= size(new%member) .or. (bands(i)%with_still .neqv. new%with_still)) cycle
      if (abs(bands(i)%lowest - new%lowest) > 0 .or. abs(bands(i)%highest - new%highest) > 0) cycle
      if (abs(bands(i)%widest - new%widest) > 0) cycle
      if (.not. all(same(bands(i)%fitted, lines(new%member)))) cycle
      new%left = bands(i)%left
      new%fitted = bands(i)%fitted
      new%seen = bands(i)%seen
      new%weight = bands(i)%weight
      new%refused = bands(i)%refused
      return
    end do
  end subroutine remember

  elemental logical function same(line, other)
    !! Whether two lines are the same but for their amplitudes.
    type(damped_line), intent(in) :: line, other
    same = .not. (abs(line%frequency - other%frequency) > 0 .or. abs(line%decay - other%decay) > 0 .or. &
      & line%powers /= other%powers .or. any(abs(line%bend - other%bend) > 0))
  end function same

  logical function alike(band, lines, span)
    !! Whether a fit has left a band's lines within a tenth of a bin of where they were.
    type(line_band), intent(in) :: band
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: span
    alike = .false.
    if (.not. allocated(band%fitted)) return
    if (size(band%fitted) /= size(lines)) return
    alike = all(band%fitted%powers == lines%powers .and. abs(band%fitted%frequency - lines%frequency)*span < nudged &
      & .and. abs(band%fitted%decay - lines%decay)*span < 2*pi*nudged)
  end function alike

  logical function is_at_rest(band, rows, weight, lines)
    !! Whether neither a band's lines, nor what it sees of others, nor the noise have changed since its last fit.
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: rows(:, :), weight(:)
    type(damped_line), intent(in) :: lines(:)
    is_at_rest = .false.
    if (.not. allocated(band%seen)) return
    if (size(band%fitted) /= size(lines)) return
    if (.not. all(same(band%fitted, lines))) return
    if (any(abs(band%weight - weight) > same_noise*weight)) return
    is_at_rest = sum(weight*sum((rows - band%seen)**2, dim=1)) < unseen*excess(band%left, rows)
  end function is_at_rest

  elemental real(dp) function width_of(samples, line)
    !! The largest decay, and change of 2π·frequency, of a line anywhere in the record.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: line
    width_of = abs(line%decay) + abs(bend_reach(line, centre_of(samples)))/centre_of(samples)
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

  pure function weight_of(noise, band, sensors) result(weight)
    !! One over the noise's variance of each sensor where the band's lines are, which is not the middle of a band that reaches to 0
    !! or to half the sampling rate, (S).
    type(level_knots), intent(in) :: noise
    type(line_band), intent(in) :: band
    integer, intent(in) :: sensors
    real(dp) :: weight(sensors)
    weight = 1/level_at(noise, (band%lowest + band%highest)/2, sensors)
  end function weight_of

  function own_rows(samples, lines, still, band) result(rows)
    !! The rows of a band without the lines that are not its own, and without offset and slope where they are not.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    type(line_band), intent(in) :: band
    real(dp), allocatable :: rows(:, :), left(:, :)
    integer :: k
    if (allocated(samples%place)) then         ! a line far from a band takes two sums of all samples there
      left = samples%value(:samples%count, :)
      call add_motion(samples, pack(lines, [(all(band%member /= k), k=1, size(lines))]), &
        & merge(0.0_dp, still, band%with_still), -1.0_dp, left)
      rows = uneven_rows(samples, band%band, left)
      return
    end if
    rows = band%band%rows
    if (.not. band%with_still) rows = rows - still_image(samples, band%band, still)
    do k = 1, size(lines)
      if (any(band%member == k)) cycle
      rows = rows - image_of(samples, band%band, lines(k))
    end do
  end function own_rows

  function rows_with_own(samples, left, own, still, band) result(rows)
    !! The same of uneven samples, from what all lines, offset and slope leave of them: lines far from a band are taken out of
    !! samples sooner than out of its rows.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: left(:, :)
    type(damped_line), intent(in) :: own(:)    !! the band's lines
    real(dp), intent(in) :: still(:, :)
    type(line_band), intent(in) :: band
    real(dp), allocatable :: rows(:, :)
    integer :: k
    rows = uneven_rows(samples, band%band, left)
    if (band%with_still) rows = rows + still_image(samples, band%band, still)
    do k = 1, size(own)
      rows = rows + image_of(samples, band%band, own(k))
    end do
  end function rows_with_own

  pure subroutine add_motion(samples, lines, still, factor, value)
    !! Add lines, offset and slope to values at uneven times, times a factor.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    real(dp), intent(in) :: factor
    real(dp), intent(inout) :: value(:, :)     !! (N, S)
    integer :: s
    do s = 1, size(value, 2)
      if (.not. any(abs(still(:, s)) > 0)) cycle
      value(:, s) = value(:, s) + factor*(still(1, s) + still(2, s)*(samples%place(:samples%count)/centre_of(samples) - 1))
    end do
    call add_uneven(samples, lines, 1, factor, value)
  end subroutine add_motion

  subroutine refine(samples, noise, bands, lines, still, monitor, work)
    !! Fit band after band until nothing is gained; those that have come to rest are left as they are.
    type(samples_type), intent(in) :: samples
    type(level_knots), intent(in) :: noise
    type(line_band), intent(inout) :: bands(:)
    type(damped_line), intent(inout) :: lines(:)
    real(dp), intent(inout) :: still(:, :)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp), intent(inout), optional :: work    !! numbers of lines' images that are computed, added up
    type(fit_type) :: fit
    real(dp), allocatable :: rows(:, :), weight(:)
    real(dp) :: left(samples%count, merge(size(still, 2), 0, allocated(samples%place)))
    real(dp) :: before, moved
    integer :: sweep, i
    if (allocated(samples%place)) then
      left = samples%value(:samples%count, :)
      call add_motion(samples, lines, still, -1.0_dp, left)
    end if
    do sweep = 1, most_sweeps
      moved = 0
      do i = 1, size(bands)
        if (size(bands(i)%member) == 0 .and. .not. bands(i)%with_still) cycle
        if (stops(monitor)) return
        before = bands(i)%left
        weight = weight_of(noise, bands(i), size(still, 2))
        fit%lines = lines(bands(i)%member)
        if (allocated(samples%place)) then
          rows = rows_with_own(samples, left, fit%lines, still, bands(i))
        else
          rows = own_rows(samples, lines, still, bands(i))
        end if
        fit%work = fit%work + size(rows, 1)*2.0_dp*(size(lines) - size(fit%lines))
        if (is_at_rest(bands(i), rows, weight, fit%lines)) cycle
        call fit_band(samples, bands(i)%band, rows, weight, bands(i)%with_still, fit)
        if (.not. alike(bands(i), fit%lines, span_of(samples))) bands(i)%refused = huge(1.0_dp)
        bands(i)%fitted = fit%lines
        bands(i)%seen = rows
        bands(i)%weight = weight
        if (.not. bands(i)%with_still) fit%still = still
        if (allocated(samples%place)) then
          call add_motion(samples, lines(bands(i)%member), still - fit%still, 1.0_dp, left)
          call add_motion(samples, fit%lines, 0*still, -1.0_dp, left)
        end if
        lines(bands(i)%member) = fit%lines
        still = fit%still
        bands(i)%left = fit%left
        moved = max(moved, abs(before - fit%left)/excess(fit%left, rows))
      end do
      if (moved < settled .or. size(bands) == 1 .or. fit%work > most_work) exit
    end do
    if (present(work)) work = work + fit%work
  end subroutine refine

end module bw_line_bands
