module bw_search_rounds
  !! Rounds of a search: peaks that stand out of the noise are taken up, fitted, and what is left is searched again.
  use bw_close_pair, only: split_lines
  use bw_damped_line, only: damped_line, same_peak
  use bw_fourier, only: real_fourier
  use bw_found_lines, only: beside_drift, far_above, found_lines, not_needed, rejected_line
  use bw_joined_lines, only: join_lines
  use bw_kinds, only: dp
  use bw_line_bands, only: prepare_bands, refine
  use bw_line_candidates, only: candidates, short_candidates
  use bw_line_refusals, only: drop_astray, drop_beside_drift, drop_broad, drop_cancelling, drop_needless, &
    & drop_uncertain, place_of
  use bw_monitor, only: monitor_type, stops
  use bw_ordinates, only: find_ordinates, least_ordinate, ordinates_type
  use bw_samples, only: highest_of, samples_type, span_of
  use bw_short_lines, only: cap_noise
  implicit none (type, external)
  private
  public :: search, settle

  integer, parameter :: most_rounds = 24
  real(dp), parameter :: most_work = 4.0e3_dp    !! numbers of lines' images for each sample and sensor, that a search computes
  real(dp), parameter :: least_allowed = 4.0e8_dp  !! of these in any record
  integer, parameter :: most_last = 8            !! rounds of refusals after these
  integer, parameter :: most_idle = 3            !! rounds of drifts and pairs, after each of which as much is left as before
  real(dp), parameter :: no_gain = 0.999_dp      !! of what was left
  integer, parameter :: most_stuck = 4           !! rounds in which far more is left than noise, and as much as before
  real(dp), parameter :: some_gain = 0.95_dp     !! of what was left
  real(dp), parameter :: above = 2               !! times the threshold of tapered ordinates, where no others pass it: the skirt of a
                                                 !! line that nobody has found raises the level that others are told by
  real(dp), parameter :: far_from_noise = 100    !! times the threshold
  real(dp), parameter :: no_better = 0.9_dp      !! of what was left before: another fit will not find more
  integer, parameter :: most_lines = 200
  real(dp), parameter :: most_fitted = 0.7_dp    !! unknowns for each sample

contains

  subroutine search(samples, false_alarm, plan, found, monitor)
    !! Take up peaks, lines that drift and two lines for one, and leave lines out again, until nothing changes, or until far more
    !! is left than noise and further lines do not describe it. The search for short lines is the dearest, and is not repeated for
    !! what a further fit of the same lines leaves.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    class(monitor_type), intent(inout), optional :: monitor
    type(ordinates_type) :: tapered
    type(damped_line), allocatable :: kept_lines(:)  !! that left least
    real(dp), allocatable :: kept_still(:, :)
    real(dp), dimension(size(samples%value, 2)) :: before, best, left  !! deviation of what is left of each sensor, whatever its unit
    real(dp) :: threshold, least
    integer :: round, known, idle, stuck
    logical :: changed, better, astray, cancels
    logical :: searched                        !! no short line was found, and no line has been changed but by a fit since
    before = huge(1.0_dp)
    best = before
    least = huge(1.0_dp)
    idle = 0
    stuck = 0
    searched = .false.
    found%highest = highest_of(samples)
    kept_lines = found%lines
    kept_still = found%still
    changed = .true.
    do round = 1, most_rounds
      call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
      threshold = least_ordinate(found%ordinates%shape, span_of(samples)/2, false_alarm)
      known = size(found%lines)
      left = found%ordinates%deviation
      if (any(left < no_gain*before)) idle = 0
      stuck = stuck + 1
      if (any(left < some_gain*best) .or. maxval(tapered%total) < far_from_noise*threshold) then
        stuck = 0
        best = left
      end if
      found%at_rest = stuck <= most_stuck .and. found%work < least_allowed + most_work*samples%count*size(samples%value, 2)
      if (.not. found%at_rest) exit
      if (sum(log(max(left, tiny(1.0_dp)))) < least) then
        least = sum(log(max(left, tiny(1.0_dp))))
        kept_lines = found%lines
        kept_still = found%still
      end if
      call change(samples, false_alarm, threshold, tapered, found, changed, idle, monitor)
      better = any(left < no_better*before)
      before = left
      if (.not. (changed .or. searched)) then
        call add(samples, short_candidates(samples, found, false_alarm), found, changed)
        searched = .true.
      end if
      if (present(monitor)) call monitor%advance(1 - 1.0_dp/(1 + round))
      if (.not. (changed .or. better)) exit
      if (stops(monitor)) exit
      call settle(samples, found, monitor)
      call drop_astray(samples, known, found, astray)
      if (astray) call settle(samples, found, monitor)
      call drop_cancelling(samples, found, cancels)
      if (cancels) call settle(samples, found, monitor)
      searched = searched .and. .not. (changed .or. astray .or. cancels)
    end do
    if (stops(monitor)) return
    if (.not. found%at_rest) then              ! a fit may have led astray since
      found%lines = kept_lines
      found%still = kept_still
      call settle(samples, found, monitor)
    end if
    if (changed) call conclude(samples, false_alarm, plan, found, monitor)
  end subroutine search

  subroutine conclude(samples, false_alarm, plan, found, monitor)
    !! Leave out what is no line of a search that has not come to rest, and see what is left then.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(real_fourier), intent(inout) :: plan
    type(found_lines), intent(inout) :: found
    class(monitor_type), intent(inout), optional :: monitor
    type(ordinates_type) :: tapered
    real(dp) :: threshold
    integer :: i
    logical :: changed
    do i = 1, most_last
      call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
      threshold = least_ordinate(found%ordinates%shape, span_of(samples)/2, false_alarm)
      call drop_broad(samples, threshold, found, changed)
      if (.not. changed) call drop_beside_drift(samples, found, changed)
      if (.not. changed) call drop_needless(samples, threshold, found, changed)
      if (.not. changed) call drop_uncertain(samples, found, changed)
      if (.not. changed) return
      if (stops(monitor)) return
      call settle(samples, found, monitor)
    end do
    call find_ordinates(samples, found%lines, found%still, plan, found%ordinates, tapered)
  end subroutine conclude

  subroutine change(samples, false_alarm, threshold, tapered, found, changed, idle, monitor)
    !! Change the lines in the first way that pays: add some that stand out with a taper, leave out needless ones, add some that
    !! stand out without a taper, let lines drift or split them, add some beside others, join some; where short lines leave more
    !! than the noise has when they are gone, let lines drift or split them.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm, threshold
    type(ordinates_type), intent(in) :: tapered
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    integer, intent(inout) :: idle               !! rounds of new shapes since anything was gained
    class(monitor_type), intent(inout), optional :: monitor
    type(damped_line), allocatable :: needless(:)
    real(dp), allocatable :: missed(:)
    type(ordinates_type) :: calm
    integer :: k
    logical :: capped
    call drop_broad(samples, threshold, found, changed)
    if (changed) return
    call drop_beside_drift(samples, found, changed)
    if (changed) return
    call add(samples, candidates(samples, found, tapered, &
      & far_above*least_ordinate(tapered%shape, span_of(samples)/2, false_alarm), same_peak), found, changed)
    if (changed) return
    call drop_needless(samples, threshold, found, changed)
    if (changed) return
    call add(samples, candidates(samples, found, found%ordinates, threshold, same_peak), found, changed)
    if (changed) return
    call add(samples, candidates(samples, found, tapered, &
      & above*least_ordinate(tapered%shape, span_of(samples)/2, false_alarm), same_peak), found, changed)
    if (changed) return
    associate (noise => found%ordinates%noise)
      if (idle < most_idle) call split_lines(samples, false_alarm, found%ordinates, found%bands, found%lines, found%still, &
        & found%highest, pack(found%rejected%frequency, found%rejected%reason == beside_drift), changed, monitor, found%work)
      if (changed) idle = idle + 1
      if (changed) return
      call drop_uncertain(samples, found, changed)
      if (changed) return
      call add(samples, candidates(samples, found, found%ordinates, threshold, 0.0_dp), found, changed)
      if (changed) return
      call join_lines(samples, false_alarm, noise, found%bands, found%lines, found%still, changed, needless, missed)
      do k = 1, size(needless)
        found%rejected = [found%rejected, &
          & rejected_line(needless(k)%frequency, missed(k), not_needed, place_of(needless(k), found))]
      end do
    end associate
    if (changed .or. idle >= most_idle) return
    calm = found%ordinates
    call cap_noise(samples, found%lines, found%still, calm%noise, capped)
    if (capped) call split_lines(samples, false_alarm, calm, found%bands, found%lines, found%still, found%highest, &
      & pack(found%rejected%frequency, found%rejected%reason == beside_drift), changed, monitor, found%work)
    if (changed) idle = idle + 1

  end subroutine change

  subroutine add(samples, fresh, found, changed)
    !! Add candidates to the lines, if there are any and the record has numbers for them.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: fresh(:)
    type(found_lines), intent(inout) :: found
    logical, intent(out) :: changed
    integer :: lines
    lines = size(found%lines) + size(fresh)
    changed = size(fresh) > 0 .and. lines <= most_lines .and. 4*lines <= most_fitted*samples%count
    if (changed) found%lines = [found%lines, fresh]
  end subroutine add

  subroutine settle(samples, found, monitor)
    !! Fit all lines.
    type(samples_type), intent(in) :: samples
    type(found_lines), intent(inout) :: found
    class(monitor_type), intent(inout), optional :: monitor
    call prepare_bands(samples, found%lines, found%bands)
    call refine(samples, found%ordinates%noise, found%bands, found%lines, found%still, monitor, found%work)
  end subroutine settle

end module bw_search_rounds
