module bw_damped_search
  !! All lines of a record: peaks that stand out of the noise are taken up, fitted, and what is left is searched again.
  use bw_band_fit, only: damped_line, fit_type, reduce, reduced_type
  use bw_close_pair, only: join_lines, split_lines
  use bw_drift, only: drift_gain
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band, own_rows, prepare_bands, refine
  use bw_monitor, only: monitor_type, stops
  use bw_noise_level, only: level_at, window_width
  use bw_ordinates, only: find_ordinates, least_ordinate, ordinates_type
  use bw_pure_record, only: find_lines_if_pure
  use bw_samples, only: samples_type, span_of
  use bw_tapered_residual, only: residual_type
  use bw_whitening, only: find_whitening, no_whitening, whiten, whitening_type
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
    logical :: pure
    allocate (found%lines(0), found%rejected(0))
    allocate (found%still(2, size(samples%value, 2)), source=0.0_dp)
    allocate (found%whitening, source=no_whitening(size(samples%value, 2)))
    call take_if_pure(samples, plan, found, pure, monitor)
    if (pure .or. stops(monitor)) return
    call settle(samples, found)
    call search(samples, false_alarm, plan, found)
    found%deviation = found%ordinates%deviation
    if (allocated(samples%place)) return
    call find_whitening(samples, found%lines, found%still, found%whitening)
    if (all(found%whitening%order == 0)) return
    call whiten(samples, found%whitening, found%lines)
    deallocate (found%bands, found%rejected)
    allocate (found%rejected(0))
    call settle(samples, found)
    call search(samples, false_alarm, plan, found)
  end subroutine find_damped_lines

  subroutine take_if_pure(samples, plan, found, pure, monitor)
    !! Take the lines of a record that holds nothing else but rounding, which is its noise.
    type(samples_type), intent(in) :: samples
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: pure
    class(monitor_type), intent(inout), optional :: monitor
    type(damped_line), allocatable :: lines(:)
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
    call find_ordinates(samples, found%lines, found%still, .false., plan, found%ordinates)
    found%deviation = found%ordinates%deviation
  end subroutine take_if_pure

  subroutine search(samples, false_alarm, plan, found)
    !! Take up peaks, two lines for one, and leave lines out again, until nothing changes with a taper and without.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    type(damped_line), allocatable :: fresh(:)
    type(ordinates_type) :: plain
    real(dp) :: threshold, before
    integer :: round, quiet
    logical :: changed, tapered, better
    before = huge(1.0_dp)
    tapered = .false.
    quiet = 0
    do round = 1, most_rounds
      tapered = .not. tapered
      call find_ordinates(samples, found%lines, found%still, tapered, plan, found%ordinates)
      if (.not. tapered) plain = found%ordinates
      threshold = least_ordinate(found%ordinates%shape, span_of(samples)/2, false_alarm)
      if (tapered) threshold = far_above*threshold
      changed = .false.
      if (.not. tapered) call drop_needless(samples, threshold, found, changed)
      if (.not. changed) call extend(threshold, changed)
      better = norm2(found%ordinates%deviation) < no_better*before
      before = norm2(found%ordinates%deviation)
      quiet = merge(0, quiet + 1, changed)
      if (quiet >= 2 .and. .not. better) exit
      if (changed .or. better) call settle(samples, found)
    end do
    if (tapered) found%ordinates = plain

  contains

    subroutine extend(threshold, changed)
      !! Add lines. Peaks are split and joined where the noise is known best, without a taper.
      real(dp), intent(in) :: threshold
      logical, intent(out) :: changed
      changed = .false.
      fresh = candidates(samples, found, threshold, same_peak)
      if (size(fresh) == 0 .and. .not. tapered) then
        associate (noise => found%ordinates%noise)
          call split_lines(samples, false_alarm, noise, found%bands, found%lines, found%still, changed)
          if (.not. changed) fresh = candidates(samples, found, threshold, 0.0_dp)
          if (.not. changed .and. size(fresh) == 0) &
            & call join_lines(samples, false_alarm, noise, found%bands, found%lines, found%still, changed)
        end associate
      end if
      if (.not. tapered) call leave_drifts(samples, found, fresh)
      if (size(fresh) == 0 .or. size(found%lines) + size(fresh) > most_lines) return
      if (4*(size(found%lines) + size(fresh)) > most_fitted*samples%count) return
      found%lines = [found%lines, fresh]
      changed = .true.
    end subroutine extend

  end subroutine search

  subroutine settle(samples, found)
    !! Fit all lines.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(inout) :: found
    call prepare_bands(samples, found%lines, found%bands)
    call refine(samples, found%ordinates%noise, found%bands, found%lines, found%still)
  end subroutine settle

  function candidates(samples, found, threshold, distance) result(fresh)
    !! New lines at the peaks that noise does not explain, nor the leakage of stronger peaks, and that have not been rejected.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(in) :: found
    real(dp), intent(in) :: threshold
    real(dp), intent(in) :: distance             !! bins from other lines that new ones keep
    type(damped_line), allocatable :: fresh(:)
    integer, allocatable :: peak(:), taken(:)
    real(dp) :: leakage, place, bins
    integer :: i, j, best
    allocate (fresh(0), taken(0))
    associate (total => found%ordinates%total, length => found%ordinates%length)
      bins = span_of(samples)/length
      peak = local_maxima(total, threshold)
      do i = 1, min(size(peak), 4*most_at_once)
        best = maxloc(total(peak), dim=1)
        associate (m => peak(best))
          place = m + vertex(total, m)
          leakage = 0
          do j = 1, size(taken)
            leakage = leakage + total(taken(j))/(1 + ((m - taken(j))*bins/width(total, taken(j), bins))**2) &
              & + total(taken(j))/(1 + ((m + taken(j))*bins/width(total, taken(j), bins))**2)
          end do
          if (total(m) > guard*leakage .and. all(abs(found%rejected%frequency - place/length)*span_of(samples) > beside) &
            & .and. all(abs(found%lines%frequency - place/length)*span_of(samples) >= distance)) then
            taken = [taken, m]
            fresh = [fresh, line_at(samples, place/length, width(total, m, bins))]
          end if
        end associate
        peak = [peak(:best - 1), peak(best + 1:)]
        if (size(taken) == most_at_once) exit
      end do
    end associate
  end function candidates

  subroutine leave_drifts(samples, found, fresh)
    !! Leave out candidates beside a line whose drift makes such ordinates.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(inout) :: found
    type(damped_line), allocatable, intent(inout) :: fresh(:)
    logical :: stays(size(fresh))
    real(dp), allocatable :: rows(:, :), weight(:)
    real(dp) :: ordinate
    integer :: i, j, k
    stays = .true.
    do k = 1, size(fresh)
      ordinate = found%ordinates%total(nint(fresh(k)%frequency*found%ordinates%length))
      do i = 1, size(found%bands)
        associate (band => found%bands(i))
          do j = 1, size(band%member)
            if (abs(found%lines(band%member(j))%frequency - fresh(k)%frequency)*span_of(samples) > drift_reach) cycle
            rows = own_rows(samples, found%lines, found%still, band)
            weight = 1/level_at(found%ordinates%noise, band%band%centre, size(samples%value, 2))
            if (2*ordinate < drift_gain(samples, band, rows, weight, found%lines(band%member), j)) stays(k) = .false.
          end do
        end associate
      end do
      if (.not. stays(k)) found%rejected = [found%rejected, rejected_line(fresh(k)%frequency, ordinate, beside_drift)]
    end do
    fresh = pack(fresh, stays)
  end subroutine leave_drifts

  pure function local_maxima(total, threshold) result(peak)
    !! The ordinates above the threshold that are not lower than their neighbours, without both ends.
    real(dp), intent(in) :: total(0:), threshold
    integer, allocatable :: peak(:)
    integer :: m
    peak = pack([(m, m=1, size(total) - 2)], total(1:size(total) - 2) > threshold .and. &
      & total(1:size(total) - 2) >= total(0:size(total) - 3) .and. total(1:size(total) - 2) > total(2:size(total) - 1))
  end function local_maxima

  pure real(dp) function vertex(total, m)
    !! Where the parabola through three logarithms is highest, −½ … ½.
    real(dp), intent(in) :: total(0:)
    integer, intent(in) :: m
    real(dp) :: low, middle, high
    low = log(max(total(m - 1), tiny(1.0_dp)))
    middle = log(total(m))
    high = log(max(total(m + 1), tiny(1.0_dp)))
    vertex = max(-0.5_dp, min(0.5_dp, (high - low)/max(2*(2*middle - low - high), 1.0e-10_dp)))
  end function vertex

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
    type(reduced_type) :: with, without
    real(dp), allocatable :: rows(:, :), weight(:)
    type(damped_line) :: line
    logical :: stays(size(found%lines)), broad
    real(dp) :: pays, widest
    integer :: i, j
    stays = .true.
    widest = pi*window_width(span_of(samples)/2)/(2*span_of(samples))
    do i = 1, size(found%bands)
      if (size(found%bands(i)%member) == 0) cycle
      associate (band => found%bands(i))
        rows = own_rows(samples, found%lines, found%still, band)
        weight = 1/level_at(found%ordinates%noise, band%band%centre, size(samples%value, 2))
        with = reduce(samples, band%band, rows, found%lines(band%member), band%with_still, 0)
        do j = 1, size(band%member)
          line = found%lines(band%member(j))
          without = reduce(samples, band%band, rows, found%lines(pack(band%member, band%member /= band%member(j))), &
            & band%with_still, 0)
          pays = sum(weight*(without%left - with%left))/2
          broad = abs(line%decay) > min(widest, shortest_life)
          if (pays > kept*threshold .and. .not. broad) cycle
          stays(band%member(j)) = .false.
          found%rejected = [found%rejected, rejected_line(line%frequency, pays, merge(too_broad, not_needed, broad))]
        end do
      end associate
    end do
    changed = .not. all(stays)
    if (changed) found%lines = pack(found%lines, stays)
  end subroutine drop_needless

end module bw_damped_search
