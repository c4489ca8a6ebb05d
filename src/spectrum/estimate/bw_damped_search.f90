module bw_damped_search
  !! All lines of a record: peaks that stand out of the noise are taken up, fitted, and what is left is searched again.
  use bw_band_fit, only: damped_line, fit_type, reduce, reduced_type
  use bw_close_pair, only: join_lines, split_lines
  use bw_damped_line, only: bend_reach
  use bw_drift, only: drift_gain, drift_taken
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band, own_rows, prepare_bands, refine
  use bw_line_errors, only: amplitude_deviation, frequency_deviation, line_errors, line_errors_of
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
  public :: drop_astray, drop_broad, drop_colour, drop_needless, drop_uncertain, find_damped_lines

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: most_rounds = 24
  integer, parameter :: most_idle = 3            !! rounds of drifts and pairs, after each of which as much is left as before
  real(dp), parameter :: no_gain = 0.999_dp      !! of what was left
  integer, parameter :: most_at_once = 64, most_around = 3  !! new lines of a round, and of a place
  real(dp), parameter :: around = 8              !! bins that a place reaches to either side
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
  real(dp), parameter :: sigmas = 2              !! standard deviations of an interval, that tells whether there is a line at all
  real(dp), parameter :: widest_error = 3        !! bins, of a frequency
  real(dp), parameter :: strayed = 2             !! bins, and half widths, that a fit may take a line from its peak
  real(dp), parameter :: most_reach = 4          !! half widths of a short line, in which one that drifts leaves something, and
                                                 !! rejected ones are the same
  real(dp), parameter :: undescribed = 0.01_dp   !! of what a drift takes, that may be left beside it
  real(dp), parameter :: no_better = 0.9_dp      !! of what was left before: another fit will not find more

  integer, parameter, public :: not_needed = 1, too_broad = 2, beside_drift = 3, uncertain = 4, &
                                 noise_colour = 5

  type, public :: rejected_line
    !! A candidate that is no line.
    real(dp) :: frequency = 0                    !! periods per step
    real(dp) :: ordinate = 0                     !! what it takes off half the squares over the noise's level; of one that a
                                                 !! fit has taken elsewhere, the ordinate at the peak, which is that of a steady line
    integer :: reason = 0
    real(dp) :: sought = -1                      !! frequency of the peak that was taken for it; negative: none
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
      if (dropped) then
        call settle(samples, found)
        call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
        found%deviation = found%ordinates%deviation
      end if
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
      if (.not. stays(k)) found%rejected = [found%rejected, rejected_line(lines(k)%frequency, pays(k), noise_colour)]
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
    integer :: round, known, idle
    logical :: changed, better, astray
    before = huge(1.0_dp)
    idle = 0
    do round = 1, most_rounds
      call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
      threshold = least_ordinate(found%ordinates%shape, span_of(samples)/2, false_alarm)
      known = size(found%lines)
      if (norm2(found%ordinates%deviation) < no_gain*before) idle = 0
      call change(samples, false_alarm, threshold, tapered, found, changed, idle, monitor)
      better = norm2(found%ordinates%deviation) < no_better*before
      before = norm2(found%ordinates%deviation)
      if (present(monitor)) call monitor%advance(1 - 1.0_dp/(1 + round))
      if (.not. (changed .or. better)) exit
      if (stops(monitor)) exit
      call settle(samples, found, monitor)
      call drop_astray(samples, known, found, astray)
      if (astray) call settle(samples, found, monitor)
    end do
  end subroutine search

  subroutine change(samples, false_alarm, threshold, tapered, found, changed, idle, monitor)
    !! Change the lines in the first way that pays: add some that stand out with a taper, leave out needless ones, add some that
    !! stand out without a taper, let lines drift or split them, add some beside others, join some.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm, threshold
    type(ordinates_type), intent(in) :: tapered
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    integer, intent(inout) :: idle               !! rounds of new shapes since anything was gained
    class(monitor_type), intent(inout), optional :: monitor
    type(damped_line), allocatable :: needless(:)
    real(dp), allocatable :: missed(:)
    integer :: k
    call drop_broad(samples, threshold, found, changed)
    if (changed) return
    call add(candidates(samples, found, tapered, &
      & far_above*least_ordinate(tapered%shape, span_of(samples)/2, false_alarm), same_peak))
    if (changed) return
    call drop_needless(samples, threshold, found, changed)
    if (changed) return
    call add(candidates(samples, found, found%ordinates, threshold, same_peak))
    if (changed) return
    associate (noise => found%ordinates%noise)
      if (idle < most_idle) call split_lines(samples, false_alarm, found%ordinates, found%bands, found%lines, found%still, &
        & changed, monitor)
      if (changed) idle = idle + 1
      if (changed) return
      call drop_uncertain(samples, found, changed)
      if (changed) return
      call add(candidates(samples, found, found%ordinates, threshold, 0.0_dp))
      if (changed) return
      call add(short_candidates(samples, found, false_alarm))
      if (changed) return
      call join_lines(samples, false_alarm, noise, found%bands, found%lines, found%still, changed, needless, missed)
      do k = 1, size(needless)
        found%rejected = [found%rejected, rejected_line(needless(k)%frequency, missed(k), not_needed, needless(k)%sought)]
      end do
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
    fresh%sought = fresh%frequency
    reach = abs(fresh(1)%decay)/(2*pi)
    if (any(abs(found%rejected%frequency - fresh(1)%frequency) < most_reach*reach)) fresh = fresh(2:)
    do k = 1, size(found%lines)
      if (size(fresh) == 0) exit
      if (abs(found%lines(k)%frequency - fresh(1)%frequency) < drift_reach/span_of(samples) &
        & + merge(most_reach*reach, 0.0_dp, found%lines(k)%powers > 1)) fresh = fresh(2:)
    end do
  end function short_candidates

  subroutine settle(samples, found, monitor)
    !! Fit all lines.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(inout) :: found
    class(monitor_type), intent(inout), optional :: monitor
    call prepare_bands(samples, found%lines, found%bands)
    call refine(samples, found%ordinates%noise, found%bands, found%lines, found%still, monitor)
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
            if (count(abs(fresh%frequency - place/length)*span_of(samples) < around) < most_around) then
              if (is_new(place/length, total(m))) fresh = [fresh, line_at(samples, place/length, width(total, m, bins))]
            end if
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
        & .and. all(abs(found%rejected%sought - frequency)*span_of(samples) > beside) &
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
      complex(dp) :: reach
      reach = bend_reach(line)
      broadened = reach%im/pi
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
    line%sought = frequency
    line%decay = max(1.0_dp, 2*pi*(half_width - narrowest))/span_of(samples)
    allocate (line%amplitude(size(samples%value, 2)))
    line%amplitude = 0
  end function line_at

  subroutine drop_broad(samples, threshold, found, changed)
    !! Leave out lines too broad to be told from the noise's colour, unless they pay far more than that; they are not tried again.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: threshold
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    logical, dimension(size(found%lines)) :: broad, gone
    real(dp) :: pays(size(found%lines))
    changed = .false.
    broad = abs(found%lines%decay) > pi*window_width(span_of(samples)/2)/(2*span_of(samples))
    gone = abs(found%lines%decay) > shortest_life
    if (.not. any(broad .or. gone)) return
    pays = pays_of(samples, found)
    gone = gone .or. (broad .and. pays < far_above*threshold)
    call reject(merge(too_broad, 0, gone), pays, found, changed)
  end subroutine drop_broad

  subroutine drop_astray(samples, known, found, changed)
    !! Leave out lines that a fit has taken to where no peak was: they describe what others leave beside them, or the noise's colour.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: known                 !! lines that were there before, and come first
    type(found_lines), intent(inout) :: found    !! its ordinates are those before the others were taken up
    logical, intent(out) :: changed
    real(dp) :: ordinate(size(found%lines))
    integer :: reason(size(found%lines)), k
    reason = 0
    ordinate = 0
    do k = known + 1, size(found%lines)
      associate (line => found%lines(k), others => found%lines(:known))
        if (abs(line%frequency - line%sought)*span_of(samples) < strayed + abs(line%decay)*span_of(samples)/pi) cycle
        reason(k) = not_needed
        ordinate(k) = ordinate_at(found%ordinates, merge(line%sought, line%frequency, line%sought >= 0))
        if (any(others%powers > 1 .and. abs(others%frequency - line%frequency)*span_of(samples) < drift_reach)) &
          & reason(k) = beside_drift
      end associate
    end do
    call reject(reason, ordinate, found, changed)
  end subroutine drop_astray

  pure real(dp) function ordinate_at(ordinates, frequency)
    !! The ordinate nearest to a frequency in periods per step.
    type(ordinates_type), intent(in) :: ordinates
    real(dp), intent(in) :: frequency
    ordinate_at = ordinates%total(max(0, min(ubound(ordinates%total, 1), nint(frequency*ordinates%length))))
  end function ordinate_at

  subroutine drop_uncertain(samples, found, changed)
    !! Leave out lines by themselves that the record does not determine: at no sensor is the amplitude, where it is largest, above
    !! its own interval, or the frequency's interval is as wide as the frequency, or wider than the line. They are not tried again.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    type(line_errors) :: errors
    real(dp) :: span, error, pays(size(found%lines))
    integer :: reason(size(found%lines)), i, j
    reason = 0
    span = span_of(samples)
    do i = 1, size(found%bands)
      if (size(found%bands(i)%member) == 0) cycle
      associate (band => found%bands(i), own => found%lines(found%bands(i)%member))
        errors = line_errors_of(reduce(samples, band%band, own_rows(samples, found%lines, found%still, band), own, &
          & band%with_still), 1/level_at(found%ordinates%noise, band%band%centre, size(samples%value, 2)))
        do j = 1, size(own)
          if (own(j)%frequency*span > same_peak .and. &
            & count(abs(own%frequency - own(j)%frequency)*span < same_peak) > 1) cycle
          if (.not. stands_out(errors, own(j), j)) reason(band%member(j)) = uncertain
          if (own(j)%frequency*span < 1) cycle
          error = sigmas*frequency_deviation(errors, j)/pi
          if (error > min(own(j)%frequency*span, widest_error + abs(own(j)%decay)*span/pi)) reason(band%member(j)) = uncertain
        end do
      end associate
    end do
    pays = 0
    if (any(reason > 0)) pays = pays_of(samples, found)
    call reject(reason, pays, found, changed)
  end subroutine drop_uncertain

  logical function stands_out(errors, line, j)
    !! Whether an amplitude, where it is largest over the record, is above its own interval at any sensor.
    type(line_errors), intent(in) :: errors
    type(damped_line), intent(in) :: line
    integer, intent(in) :: j                     !! its place in the fit
    real(dp) :: along(2, size(line%amplitude))
    integer :: s
    stands_out = .true.
    do s = 1, size(line%amplitude)
      associate (a => line%amplitude(s))
        along = 0
        along(:, s) = [a%re, a%im]/max(abs(a), tiny(1.0_dp))
        if (abs(a) > sigmas*amplitude_deviation(errors, j, along, last=line%decay < 0)) return
      end associate
    end do
    stands_out = .false.
  end function stands_out

  subroutine reject(reason, ordinate, found, changed)
    !! Move lines to the rejected ones.
    integer, intent(in) :: reason(:)             !! 0 for lines that stay
    real(dp), intent(in) :: ordinate(:)          !! of those that do not
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    integer :: k
    do k = 1, size(reason)
      if (reason(k) == 0) cycle
      found%rejected = [found%rejected, &
        & rejected_line(found%lines(k)%frequency, ordinate(k), reason(k), found%lines(k)%sought)]
    end do
    changed = any(reason > 0)
    if (changed) found%lines = pack(found%lines, reason == 0)
  end subroutine reject

  subroutine drop_needless(samples, threshold, found, changed)
    !! Leave out lines without which the others explain as much but for noise; they are not tried again.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: threshold
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    real(dp) :: pays(size(found%lines))
    pays = pays_of(samples, found)
    call reject(merge(not_needed, 0, pays <= kept*threshold), pays, found, changed)
  end subroutine drop_needless

end module bw_damped_search
