module bw_line_moves
  !! Moves that change the lines of a model: a new line where the bank of decays shows one, a course of a line, one line instead of
  !! two, a tone that does not decay.
  use bw_band, only: enough_for
  use bw_band_fit, only: most_growth
  use bw_constants, only: pi
  use bw_cost, only: penalty_of_course, penalty_of_line, penalty_of_tone
  use bw_decay_bank, only: decay_candidate, edge, find_candidates
  use bw_kinds, only: dp
  use bw_line, only: course_type, line_type, pole_at
  use bw_line_drops, only: energy_of, line_outcome
  use bw_model, only: colour_at, model_type
  use bw_monitor, only: monitor_type, stops
  use bw_order, only: ascending
  use bw_penalty, only: chi_squared
  use bw_refit, only: accept, all_steps, is_broken, near, overlaps, refit, refit_type, span_of_model, trial_steps
  use bw_samples, only: samples_type
  implicit none (type, external)
  private
  public :: add_drifts, add_round, judge_steady, may_be_tone, merge_lines, most_additions, most_lines

  integer, parameter :: most_lines = 60
  integer, parameter :: most_additions = 12       !! rounds in which lines are added; blows may change in between
  real(dp), parameter :: even_odds = 0.5_dp
  integer, parameter :: first_steps = 8           !! of a new line's fit
  real(dp), parameter :: same_shape = 0.8_dp      !! tuned: cosine between the shapes of a line and of the residual of its drift
  integer, parameter :: first_window = 64         !! a drifting line is fitted first to 1/first_window of the longest stretch
  real(dp), parameter :: far = 0.1_dp             !! of a line's energy: less is a drift by less than a third of a radian
  real(dp), parameter :: faint = 1.0e-3_dp        !! tuned: of the strongest candidate's gain, which that line's residual may have
  real(dp), parameter :: promised = 0.5_dp        !! tuned: fraction of a gain that is enough to go on

contains

  subroutine add_round(samples, false_alarm, model, outcome, accepted, beside)
    !! Add lines and courses that do not overlap, at candidates from the bank of decays.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    type(line_outcome), intent(inout) :: outcome !! takes all candidates that noise alone exceeds in less than half of all records
    integer, intent(out) :: accepted
    logical, intent(out), optional :: beside     !! the strongest candidate overlaps with a line
    type(decay_candidate), allocatable :: candidates(:)
    complex(dp), allocatable :: moved(:)
    type(refit_type) :: found
    real(dp) :: need, penalty, gain
    integer :: i
    accepted = 0
    moved = [complex(dp) ::]
    need = penalty_of_line(samples, false_alarm, model)
    call find_candidates(model, penalty_of_line(samples, even_odds, model), candidates)
    outcome%poles = candidates%pole
    outcome%gains = candidates%gain
    if (present(beside)) beside = any([(near(model, candidates(i)%pole), i=1, min(1, count(candidates%gain > need)))])
    do i = 1, count(candidates%gain > need)
      if (any(overlaps(moved, candidates(i)%pole, span_of_model(model)))) cycle  ! wait until these have converged
      if (size(model%lines) >= most_lines) return
      call propose(need, penalty_of_course(false_alarm), candidates(i), model, found, penalty)
      penalty = penalty*colour_at(model, candidates(i)%pole%im)
      if (accepted > 0 .and. found%gain < promised*candidates(i)%gain) cycle  ! it was the skirt of another
      if (candidates(i)%gain < faint*candidates(1)%gain .and. has_moved(candidates(i), found, span_of_model(model))) cycle
      gain = 0
      if (found%gain > penalty) call accept(found, penalty, model, gain)
      if (.not. gain > 0) cycle
      accepted = accepted + 1
      if (is_broken(model, real(candidates(i)%pole, dp), real(candidates(i)%pole, dp))) return   ! others may be its images
      moved = [moved, candidates(i)%pole, model%lines(size(model%lines))%pole]
    end do
  end subroutine add_round

  pure logical function has_moved(candidate, found, span)
    !! Whether the fit of a new line has moved from its candidate's pole to the residual of a stronger line.
    type(decay_candidate), intent(in) :: candidate
    type(refit_type), intent(in) :: found
    real(dp), intent(in) :: span                 !! samples
    associate (place => candidate%pole)
      has_moved = abs(found%lines(size(found%lines))%pole - place) > 4*max(-place%re, 2/span)
    end associate
  end function has_moved

  subroutine propose(need, need_of_course, candidate, model, found, penalty)
    !! Fit a line at a candidate's pole, or a course of the line next to it, whichever has the lower J.
    real(dp), intent(in) :: need, need_of_course !! penalties of a line and of a course
    type(decay_candidate), intent(in) :: candidate
    type(model_type), intent(in) :: model
    type(refit_type), intent(out) :: found
    real(dp), intent(out) :: penalty             !! of the proposal
    type(refit_type) :: bent
    type(line_type) :: line
    logical, allocatable :: own(:)
    integer :: host
    line%pole = candidate%pole
    allocate (line%courses(0))
    own = near(model, line%pole)
    call refit(model, own, [pack(model%lines, own), line], first_steps, found)
    penalty = need
    if (.not. any(own)) return
    host = minloc(abs(model%lines%pole%im - line%pole%im), dim=1, mask=own)
    if (.not. may_be_residual(model%lines(host), found%lines(size(found%lines)), span_of_model(model))) return
    call add_course(model, own, own, host, found%gain, bent)
    if (.not. allocated(bent%lines)) return
    if (.not. bent%gain - need_of_course > found%gain - need) return
    found = bent
    penalty = need_of_course
  end subroutine propose

  pure logical function may_be_residual(line, other, span)
    !! Whether one line may be the residual of the other's drift: it has about its frequency, and its shape.
    type(line_type), intent(in) :: line, other
    real(dp), intent(in) :: span                 !! samples
    real(dp) :: product, lengths
    integer :: b
    product = 0
    lengths = 0
    do b = 1, size(line%amplitude, 2)
      product = product + abs(dot_product(line%amplitude(:, b), other%amplitude(:, b)))
      lengths = lengths + norm2(abs(line%amplitude(:, b)))*norm2(abs(other%amplitude(:, b)))
    end do
    may_be_residual = product > same_shape*lengths .and. &
      & abs(line%pole%im - other%pole%im) < 3*(abs(line%pole%re) + abs(other%pole%re)) + 2*pi*4/span
  end function may_be_residual

  subroutine add_course(model, own, kept, host, energy, best)
    !! Fit the best further course of a line, from a few rates. If it has to explain much of the line's energy, the line alone is
    !! followed from the blow over longer and longer parts of the record, so that its phase is never far from that of the fit. With
    !! fewer than `edge` periods it is a trend of undetermined frequency: n periods determine a frequency to about 1/n of it, and a
    !! fit that starts outside this range does not converge.
    type(model_type), intent(in) :: model
    logical, intent(in) :: own(:)                !! lines to be replaced
    logical, intent(in) :: kept(:)               !! those of them that are fitted again; the course replaces the others
    integer, intent(in) :: host                  !! which of these gets the course
    real(dp), intent(in) :: energy               !! which the course has to explain
    type(refit_type), intent(out) :: best
    type(line_type), allocatable :: lines(:), bent(:)
    type(refit_type) :: found
    real(dp) :: span, gain
    integer :: c, place
    span = span_of_model(model)
    c = size(model%lines(host)%courses) + 1
    place = count(kept(:host))
    gain = -huge(1.0_dp)
    call try(2/span)
    call try(2*abs(model%lines(host)%pole%re) + 1/span)
    if (.not. allocated(bent)) return            ! fits that overflow
    bent(place)%courses(c)%held = .false.
    call refit(model, own, bent, all_steps, found)
    if (all(decays(found%lines))) best = found

  contains

    subroutine try(rate)
      !! Fit a course of this rate.
      real(dp), intent(in) :: rate
      lines = pack(model%lines, kept)
      if (energy > far*energy_of(model, model%lines(host))) then
        lines(place) = followed(rate)
      else
        lines(place)%courses = [lines(place)%courses, course_type(rate, (0.0_dp, 0.0_dp), .true.)]
      end if
      call refit(model, own, lines, trial_steps, found)
      if (.not. found%gain > gain) return
      gain = found%gain
      bent = found%lines
    end subroutine try

    type(line_type) function followed(rate) result(line)
      !! The line with a course of this rate, followed to the end of the record.
      real(dp), intent(in) :: rate
      type(line_type) :: alone(1)
      logical :: replaced(size(own))
      integer :: window
      replaced = own .and. .not. kept
      replaced(host) = .true.
      alone = model%lines([host])
      window = max(nint(span)/first_window, min(ceiling(2*pi*edge/alone(1)%pole%im), nint(span)/3))
      do while (2*window < span)
        call refit(model, replaced, alone, trial_steps, found, window)
        alone = found%lines
        if (size(alone(1)%courses) < c) alone(1)%courses = [alone(1)%courses, course_type(rate, (0.0_dp, 0.0_dp), .true.)]
        window = 2*window
      end do
      line = alone(1)
    end function followed

    elemental logical function decays(line)
      !! Whether a line never grows much, as the beat of two lines does.
      type(line_type), intent(in) :: line
      decays = max(line%pole%re, real(pole_at(line, span), dp))*span < most_growth
    end function decays

  end subroutine add_course

  subroutine add_drifts(false_alarm, model, added, monitor)
    !! Let frequency and decay of lines change linearly if that gains more than its penalty; residuals of faster changes are found
    !! by the bank of decays. Two lines that beat less than once do not determine a drift.
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: added
    class(monitor_type), intent(inout), optional :: monitor
    logical :: done(size(model%lines)), own(size(model%lines))
    type(line_type), allocatable :: start(:)
    type(refit_type) :: found
    real(dp) :: gain, penalty, resolution
    integer :: k, host
    added = 0
    penalty = chi_squared(false_alarm/max(1, size(done)), 2)   ! any line may drift
    resolution = 2*pi/span_of_model(model)
    done = [(model%lines(k)%steady .or. size(model%lines(k)%courses) > 0 &
      & .or. count(abs(model%lines%pole%im - model%lines(k)%pole%im) < resolution) > 1, k=1, size(done))]
    do while (.not. all(done))
      if (stops(monitor)) return
      k = findloc(done, .false., dim=1)
      done(k) = .true.
      own = near(model, model%lines(k)%pole)
      host = count(own(:k))
      start = pack(model%lines, own)
      start(host)%courses = [course_type(0.0_dp, (0.0_dp, 0.0_dp), .true.)]
      call refit(model, own, start, first_steps, found, least=promised*penalty)
      gain = 0
      if (found%gain > penalty) call accept(found, penalty, model, gain)
      if (.not. abs(gain) > 0) cycle
      added = added + 1
      done = [pack(done, .not. own), pack(done, own)]  ! indices have changed
    end do
  end subroutine add_drifts

  subroutine judge_steady(samples, false_alarm, model, changed)
    !! Turn lines into tones that do not decay, and were there before the first blow, if J falls.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: changed              !! number of lines
    type(refit_type) :: found
    type(line_type), allocatable :: start(:)
    logical :: own(size(model%lines))
    real(dp) :: gain
    integer :: k
    changed = 0
    if (model%stretches(2, 0) - model%stretches(1, 0) + 1 < enough_for(1)) return   ! too few samples before the blow
    k = 0
    do while (k < size(model%lines))
      k = k + 1
      if (.not. may_be_tone(model, model%lines(k))) cycle
      own = near(model, model%lines(k)%pole)
      start = pack(model%lines, own)
      start(count(own(:k)))%steady = .true.
      start(count(own(:k)))%pole%re = 0
      call refit(model, own, start, trial_steps, found)
      call accept(found, penalty_of_tone(samples, false_alarm), model, gain)
      if (.not. abs(gain) > 0) cycle
      changed = changed + 1
      k = k - count(own(:k))                     ! indices have changed
    end do
  end subroutine judge_steady

  pure logical function may_be_tone(model, line)
    !! Whether a line hardly decays.
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: line
    may_be_tone = .not. line%steady .and. size(line%courses) == 0 .and. abs(line%pole%re)*span_of_model(model) <= 1
  end function may_be_tone

  subroutine merge_lines(samples, false_alarm, model, merged, monitor)
    !! Replace lines beside a stronger one by a course of that one if J falls. Lines refitted on the way wait for the next call.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: merged
    class(monitor_type), intent(inout), optional :: monitor
    type(refit_type) :: found
    logical, allocatable :: own(:), kept(:)
    complex(dp), allocatable :: poles(:)
    real(dp), allocatable :: energy(:)
    real(dp) :: gain, penalty
    integer :: i, j, k, host
    merged = 0
    energy = [(energy_of(model, model%lines(k)), k=1, size(model%lines))]
    poles = model%lines(ascending(energy))%pole  ! the weakest first
    penalty = penalty_of_line(samples, false_alarm, model)
    do i = 1, size(poles)
      if (stops(monitor)) return
      k = findloc(model%lines%pole == poles(i), .true., dim=1)
      if (k == 0) cycle                          ! it was refitted beside a merged one
      energy = [(energy_of(model, model%lines(j)), j=1, size(model%lines))]
      own = near(model, model%lines(k)%pole)
      own(k) = .false.
      if (.not. any(own .and. energy > energy(k))) cycle
      host = minloc(abs(model%lines%pole%im - model%lines(k)%pole%im), dim=1, mask=own .and. energy > energy(k))
      if (.not. may_be_residual(model%lines(host), model%lines(k), span_of_model(model))) cycle
      kept = own
      own(k) = .true.
      call add_course(model, own, kept, host, energy(k), found)
      if (.not. allocated(found%lines)) cycle
      call accept(found, penalty_of_course(false_alarm) - penalty, model, gain)
      if (abs(gain) > 0) merged = merged + 1
    end do
  end subroutine merge_lines

end module bw_line_moves
