module bw_damped_search
  !! All lines of a record: peaks that stand out of the noise are taken up, fitted, and what is left is searched again.
  use bw_band_fit, only: damped_line, fit_type, reduce, reduced_type
  use bw_close_pair, only: join_lines, split_lines
  use bw_drift, only: drift_gain, drift_taken
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band, own_rows, prepare_bands, refine
  use bw_monitor, only: monitor_type, stops
  use bw_noise_level, only: level_at, window_width
  use bw_ordinates, only: find_ordinates, least_ordinate, ordinates_type
  use bw_order, only: local_maxima, vertex
  use bw_pure_record, only: find_lines_if_pure, safety
  use bw_samples, only: samples_type, span_of
  use bw_short_lines, only: short_lines
  use bw_tapered_line, only: taper_costs
  use bw_tapered_residual, only: residual_type
  use bw_line_or_colour, only: are_lines
  use bw_whitening, only: find_whitening, gain_of, longest, no_whitening, whiten, whitening_type
  implicit none (type, external)
  private
  public :: find_damped_lines

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: most_rounds = 24
  integer, parameter :: most_at_once = 64
  integer, parameter :: most_lines = 200
  real(dp), parameter :: guard = 4               !! times the leakage of stronger peaks
  real(dp), parameter :: narrowest = 0.4_dp      !! bins; an undamped line leaks 1/(πd)² of its power
  real(dp), parameter :: kept = 1               !! times the threshold, that a line must still pay among the others
  real(dp), parameter :: shortest_life = 0.25_dp !! decay per step: gone after four samples
  real(dp), parameter :: beside = 0.7_dp         !! bins within which a place is the same

  real(dp), parameter :: far_above = 4           !! times the threshold, what no colour of the noise does: lines found with a taper
  real(dp), parameter :: same_peak = 1.5_dp      !! bins from a line, where it is tried as two before a further one is

  real(dp), parameter :: most_fitted = 0.7_dp    !! unknowns for each sample
  real(dp), parameter :: drift_reach = 3         !! bins; the ordinates of a drift are below half of what it gains
  real(dp), parameter :: most_reach = 4        !! half widths of a short line, in which a line that drifts leaves something, and rejected ones are the same
  real(dp), parameter :: undescribed = 0.01_dp   !! of what a drift takes, that may be left beside it
  real(dp), parameter :: no_better = 0.9_dp      !! of what was left before: another fit will not find more

  integer, parameter, public :: not_needed = 1, too_broad = 2, beside_drift = 3

  type, public :: rejected_line
    !! A candidate that is no line.
    real(dp) :: frequency = 0                    !! periods per step
    real(dp) :: ordinate = 0                     !! over the noise's level
    integer :: reason = 0
  end type rejected_line

  type, public :: found_lines
    !! The lines of a record by ascending frequency.
    type(damped_line), allocatable :: lines(:)
    real(dp), allocatable :: still(:, :)         !! offset and slope over half the record, about its middle, (2, S)
    type(line_band), allocatable :: bands(:)
    type(ordinates_type) :: ordinates            !! what the lines leave
    type(rejected_line), allocatable :: rejected(:)
    type(whitening_type), allocatable :: whitening(:)  !! what the samples, and with them the amplitudes, went through, (S)
    type(residual_type) :: left                  !! what the lines of a record that is known to be pure leave of it
    real(dp), allocatable :: deviation(:)        !! of what the lines leave of the record as it was, (S)
  end type found_lines

contains

  subroutine find_damped_lines(samples, false_alarm, found, monitor)
    !! Find the lines of a record in which noise alone makes any line with the probability `false_alarm`. Where the noise of
    !! even samples is coloured they are whitened in their memory, and searched once more. Of samples that are known to be pure
    !! there are the lines and what they leave, and nothing else.
    type(samples_type), intent(inout) :: samples
    real(dp), intent(in) :: false_alarm
    type(found_lines), intent(out) :: found    !! of no use where the monitor stops
    class(monitor_type), intent(inout), optional :: monitor
    type(real_fourier) :: plan
    type(samples_type) :: raw
    type(ordinates_type) :: tapered
    logical :: pure, dropped
    allocate (found%lines(0), found%rejected(0))
    allocate (found%still(2, size(samples%value, 2)), source=0.0_dp)
    allocate (found%whitening, source=no_whitening(size(samples%value, 2)))
    call take_if_pure(samples, plan, found, pure, monitor)
    if (pure) return
    if (stops(monitor)) return
    call settle(samples, found)
    call search(samples, false_alarm, plan, found, monitor)
    found%deviation = found%ordinates%deviation
    if (allocated(samples%place)) return
    if (stops(monitor)) return
    if (samples%count <= longest) then
      raw = samples
      call drop_colour(raw, samples, false_alarm, found, dropped)
      if (dropped) call settle(samples, found)
    end if
    call find_whitening(samples, found%lines, found%still, found%whitening)
    if (all(found%whitening%order == 0)) return
    call whiten(samples, found%whitening, found%lines)
    deallocate (found%bands, found%rejected)
    allocate (found%rejected(0))
    call settle(samples, found)
    call search(samples, false_alarm, plan, found, monitor)
    if (.not. allocated(raw%value)) return
    call drop_colour(raw, samples, false_alarm, found, dropped)
    if (.not. dropped) return
    call settle(samples, found)
    call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
  end subroutine find_damped_lines

  subroutine drop_colour(raw, samples, false_alarm, found, dropped)
    !! Leave out lines that the colour of the noise explains.
    type(samples_type), intent(in) :: raw      !! as they were before they were whitened
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: dropped
    type(damped_line) :: lines(size(found%lines))
    logical :: stays(size(found%lines))
    real(dp) :: pays(size(found%lines))
    integer :: k
    pays = pays_of(samples, found)
    lines = found%lines
    do k = 1, size(lines)
      lines(k)%amplitude = lines(k)%amplitude/gain_of(found%whitening, lines(k))
    end do
    stays = are_lines(raw, lines, pays, least_ordinate(found%ordinates%shape, span_of(raw)/2, false_alarm))
    dropped = .not. all(stays)
    do k = 1, size(lines)
      if (.not. stays(k)) found%rejected = [found%rejected, rejected_line(lines(k)%frequency, pays(k), not_needed)]
    end do
    found%lines = pack(found%lines, stays)
  end subroutine drop_colour

  function pays_of(samples, found) result(pays)
    !! What each line takes off half the squares over the noise's level, beside the others of its band.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    real(dp) :: pays(size(found%lines))
    type(reduced_type) :: with, without
    real(dp), allocatable :: rows(:, :), weight(:)
    integer, allocatable :: others(:)
    integer :: i, j
    do i = 1, size(found%bands)
      if (size(found%bands(i)%member) == 0) cycle
      associate (band => found%bands(i))
        rows = own_rows(samples, found%lines, found%still, band)
        weight = 1/level_at(found%ordinates%noise, band%band%centre, size(samples%value, 2))
        with = reduce(samples, band%band, rows, found%lines(band%member), band%with_still, 0*band%member)
        do j = 1, size(band%member)
          others = pack(band%member, band%member /= band%member(j))
          without = reduce(samples, band%band, rows, found%lines(others), band%with_still, 0*others)
          pays(band%member(j)) = sum(weight*(without%left - with%left))/2
        end do
      end associate
    end do
  end function pays_of

  subroutine take_if_pure(samples, plan, found, pure, monitor)
    !! Take the lines of a record that holds nothing else but rounding, which is its noise.
    type(samples_type), intent(in) :: samples
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: pure
    class(monitor_type), intent(inout), optional :: monitor
    type(damped_line), allocatable :: lines(:)
    type(ordinates_type) :: tapered
    logical, allocatable :: is_offset(:)
    integer :: k
    call find_lines_if_pure(samples, lines, found%left, pure, monitor)
    if (samples%pure) call move_alloc(lines, found%lines)
    if (samples%pure .or. .not. pure) return
    is_offset = lines%steady .and. .not. lines%frequency > 0
    do k = 1, size(lines)
      if (is_offset(k)) found%still(1, :) = found%still(1, :) + lines(k)%amplitude%re
    end do
    found%lines = pack(lines, .not. is_offset)
    found%lines%steady = .false.
    call prepare_bands(samples, found%lines, found%bands)
    call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
    found%ordinates%noise%level = (safety*taper_costs)**2*found%ordinates%noise%level
    found%deviation = found%ordinates%deviation
  end subroutine take_if_pure

  subroutine search(samples, false_alarm, plan, found, monitor)
    !! Take up peaks, lines that drift and two lines for one, and leave lines out again, until nothing changes.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    class(monitor_type), intent(inout), optional :: monitor
    type(ordinates_type) :: tapered
    real(dp) :: threshold, before
    integer :: round
    logical :: changed, better
    before = huge(1.0_dp)
    do round = 1, most_rounds
      call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
      threshold = least_ordinate(found%ordinates%shape, span_of(samples)/2, false_alarm)
      call change(samples, false_alarm, threshold, tapered, found, changed)
      better = norm2(found%ordinates%deviation) < no_better*before
      before = norm2(found%ordinates%deviation)
      if (present(monitor)) call monitor%advance(1 - 1.0_dp/(1 + round))
      if (.not. (changed .or. better)) exit
      if (stops(monitor)) exit
      call settle(samples, found)
    end do
  end subroutine search

  subroutine change(samples, false_alarm, threshold, tapered, found, changed)
    !! Change the lines in the first way that pays: add some that stand out with a taper, leave out needless ones, add some that
    !! stand out without a taper, let lines drift or split them, add some beside others, join some.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm, threshold
    type(ordinates_type), intent(in) :: tapered
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    call add(candidates(samples, found, tapered, &
      & far_above*least_ordinate(tapered%shape, span_of(samples)/2, false_alarm), same_peak))
    if (changed) return
    call drop_needless(samples, threshold, found, changed)
    if (changed) return
    call add(candidates(samples, found, found%ordinates, threshold, same_peak))
    if (changed) return
    associate (noise => found%ordinates%noise)
      call split_lines(samples, false_alarm, found%ordinates, found%bands, found%lines, found%still, changed)
      if (changed) return
      call add(candidates(samples, found, found%ordinates, threshold, 0.0_dp))
      if (changed) return
      call add(short_candidates(samples, found, false_alarm))
      if (changed) return
      call join_lines(samples, false_alarm, noise, found%bands, found%lines, found%still, changed)
    end associate

  contains

    subroutine add(fresh)
      !! Add candidates to the lines, if there are any and the record has numbers for them.
      type(damped_line), intent(in) :: fresh(:)
      integer :: lines
      lines = size(found%lines) + size(fresh)
      changed = size(fresh) > 0 .and. lines <= most_lines .and. 4*lines <= most_fitted*samples%count
      if (changed) found%lines = [found%lines, fresh]
    end subroutine add

  end subroutine change

  function short_candidates(samples, found, false_alarm) result(fresh)
    !! A new line that is gone long before the record ends, or grows as fast, if one stands out of the noise, has not been
    !! rejected, and is not beside a line that drifts, of which anything may be left.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    real(dp), intent(in) :: false_alarm
    type(damped_line), allocatable :: fresh(:)
    real(dp) :: reach
    integer :: k
    fresh = short_lines(samples, found%lines, found%still, found%ordinates%shape, false_alarm)
    if (size(fresh) == 0) return
    reach = abs(fresh(1)%decay)/(2*pi)
    if (any(abs(found%rejected%frequency - fresh(1)%frequency) < most_reach*reach)) fresh = fresh(2:)
    do k = 1, size(found%lines)
      if (size(fresh) == 0) exit
      if (abs(found%lines(k)%frequency - fresh(1)%frequency) < drift_reach/span_of(samples) &
        & + merge(most_reach*reach, 0.0_dp, found%lines(k)%powers > 1)) fresh = fresh(2:)
    end do
  end function short_candidates

  subroutine settle(samples, found)
    !! Fit all lines.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(inout) :: found
    call prepare_bands(samples, found%lines, found%bands)
    call refine(samples, found%ordinates%noise, found%bands, found%lines, found%still)
  end subroutine settle

  function candidates(samples, found, ordinates, threshold, distance) result(fresh)
    !! New lines at the peaks that noise does not explain, nor the leakage of stronger peaks, nor a drift of a line, and that have
    !! not been rejected.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    type(ordinates_type), intent(in) :: ordinates
    real(dp), intent(in) :: threshold
    real(dp), intent(in) :: distance             !! bins from other lines that new ones keep
    type(damped_line), allocatable :: fresh(:)
    integer, allocatable :: peak(:), taken(:)
    real(dp) :: leakage, place, bins
    integer :: i, j, best
    allocate (fresh(0), taken(0))
    associate (total => ordinates%total, length => ordinates%length)
      bins = span_of(samples)/length
      peak = local_maxima(total, threshold)
      peak = pack(peak, peak > 0 .and. peak < ubound(total, 1))
      do i = 1, min(size(peak), 4*most_at_once)
        best = maxloc(total(peak), dim=1)
        associate (m => peak(best))
          place = m + vertex(total(m - 1:m + 1))
          leakage = 0
          do j = 1, size(taken)
            leakage = leakage + total(taken(j))/(1 + ((m - taken(j))*bins/width(total, taken(j), bins))**2) &
              & + total(taken(j))/(1 + ((m + taken(j))*bins/width(total, taken(j), bins))**2)
          end do
          if (total(m) > guard*leakage) then
            taken = [taken, m]
            if (is_new(place/length, total(m))) fresh = [fresh, line_at(samples, place/length, width(total, m, bins))]
          end if
        end associate
        peak = [peak(:best - 1), peak(best + 1:)]
        if (size(fresh) == most_at_once) exit
      end do
    end associate

  contains

    logical function is_new(frequency, ordinate)
      !! Whether a peak is none of a rejected line, nor beside a line in whose peak a drift would take more.
      real(dp), intent(in) :: frequency, ordinate
      is_new = all(abs(found%rejected%frequency - frequency)*span_of(samples) > beside) &
        & .and. all(abs(found%lines%frequency - frequency)*span_of(samples) >= distance)
      if (is_new) is_new = .not. is_drift(samples, found, frequency, ordinate)
    end function is_new

  end function candidates

  logical function is_drift(samples, found, frequency, ordinate)
    !! Whether a peak is beside a line whose drift would take more off the squares than a line at the peak, or has taken so much
    !! more that this is what no drift of a few powers of time describes.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    real(dp), intent(in) :: frequency, ordinate
    real(dp), allocatable :: rows(:, :), weight(:)
    type(damped_line), allocatable :: own(:)
    integer :: i, j
    is_drift = .false.
    do i = 1, size(found%bands)
      associate (band => found%bands(i))
        own = found%lines(band%member)
        do j = 1, size(own)
          if (abs(own(j)%frequency - frequency)*span_of(samples) > drift_reach + broadened(own(j))) cycle
          rows = own_rows(samples, found%lines, found%still, band)
          weight = 1/level_at(found%ordinates%noise, band%band%centre, size(samples%value, 2))
          is_drift = 2*ordinate < drift_gain(samples, band, rows, weight, own, j)
          if (is_drift) return
          if (own(j)%powers > 1) is_drift = 2*ordinate < undescribed*drift_taken(samples, band, rows, weight, own, j)
          if (is_drift) return
        end do
      end associate
    end do

  contains

    real(dp) function broadened(line)
      !! Bins that a line's drift reaches to either side.
      type(damped_line), intent(in) :: line
      integer :: m
      broadened = sum([(m*abs(line%bend(m)%im), m=2, line%powers)])/pi
    end function broadened

  end function is_drift

  pure real(dp) function width(total, m, bins)
    !! Half the width of a peak at half its height, in bins, not less than that of an undamped line.
    real(dp), intent(in) :: total(0:)
    integer, intent(in) :: m
    real(dp), intent(in) :: bins                 !! between ordinates
    integer :: low, high
    do low = m, 1, -1
      if (2*total(low) < total(m)) exit
    end do
    do high = m, size(total) - 2
      if (2*total(high) < total(m)) exit
    end do
    width = max(narrowest, (high - low)*bins/2 - narrowest)
  end function width

  pure function line_at(samples, frequency, half_width) result(line)
    !! A line at a peak, with the decay that its width tells: the power of a decaying line is half at 2π(f − f₀) = decay.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: frequency
    real(dp), intent(in) :: half_width           !! bins
    type(damped_line) :: line
    line%frequency = frequency
    line%decay = max(1.0_dp, 2*pi*(half_width - narrowest))/span_of(samples)
    allocate (line%amplitude(size(samples%value, 2)))
    line%amplitude = 0
  end function line_at

  subroutine drop_needless(samples, threshold, found, changed)
    !! Leave out lines without which the others explain as much but for noise, and those too broad to be told from the noise's
    !! colour; they are not tried again.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: threshold
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    logical :: stays(size(found%lines)), broad
    real(dp) :: pays(size(found%lines)), widest
    integer :: k
    pays = pays_of(samples, found)
    widest = pi*window_width(span_of(samples)/2)/(2*span_of(samples))
    do k = 1, size(found%lines)
      associate (line => found%lines(k))
        broad = abs(line%decay) > shortest_life .or. (abs(line%decay) > widest .and. pays(k) < far_above*threshold)
        stays(k) = pays(k) > kept*threshold .and. .not. broad
        if (.not. stays(k)) found%rejected = &
          & [found%rejected, rejected_line(line%frequency, pays(k), merge(too_broad, not_needed, broad))]
      end associate
    end do
    changed = .not. all(stays)
    if (changed) found%lines = pack(found%lines, stays)
  end subroutine drop_needless

end module bw_damped_search
