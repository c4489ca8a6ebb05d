module bw_line_search
  !! The search for the lines of a record: a few moves minimise one number.
  !!
  !! J = −2 ln L of the prediction errors + the penalty of each unknown. Moves add a line where the bank of decays shows one, or a
  !! course to a line; renew the noise; move, add and drop blows; and drop what gains less than its penalty. The search ends when no
  !! move lowers J. This module has the order of the moves; `bw_line_moves`, `bw_line_drops` and `bw_blow_trials` have the moves.
  use bw_band, only: enough_for
  use bw_band_fit, only: converged
  use bw_blow_trials, only: try_missing_blows, try_moved_blows
  use bw_cost, only: akaike, cost_beside_noise, cost_of_all, order_price
  use bw_kinds, only: dp
  use bw_line, only: find_wave, line_type
  use bw_line_drops, only: clear_if_growing, drop_lines, drop_weakest, keep_or_clear, line_outcome
  use bw_line_moves, only: add_drifts, add_round, judge_steady, may_be_tone, merge_lines, most_additions, most_lines
  use bw_model, only: model_type
  use bw_monitor, only: monitor_type, stops
  use bw_noise_alone, only: cost_of_shared_motion, dies, most_colour, most_orders
  use bw_refit, only: all_steps, follow_lines, negligible_gain, refit_all, slow_in, trial_steps
  use bw_renewal, only: renew
  use bw_samples, only: samples_type
  use bw_search_state, only: go_back, keep_best, keep_if_cheaper, state_of, state_type
  use bw_stretches, only: drop_blow
  implicit none (type, external)
  private
  public :: find_lines_after, improve_lines

  integer, parameter, public :: many_lines = 24   !! tuned: as many may represent a driven motion, or one that no lines describe
  integer, parameter :: most_rounds = 4
  integer, parameter :: most_in_vain = 1          !! tuned: rounds in which J does not fall
  real(dp), parameter :: first_lines = 0.6_dp     !! fraction of the time
  real(dp), parameter :: least_share = 0.3_dp     !! of the usual gain; chosen: driven beams have 0.25, free decays 0.5 and more

contains

  subroutine find_lines_after(blows, samples, false_alarm, model, outcome, monitor, part)
    !! Find the lines of a record with given first estimates of its blows.
    integer, intent(in) :: blows(:)
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(out) :: model
    type(line_outcome), intent(out) :: outcome
    class(monitor_type), intent(inout), optional :: monitor
    type(model_type), intent(in), optional :: part   !! of the record's first part
    logical :: complete                          !! all lines of the part could be followed through the record
    real(dp) :: alone                            !! J of noise alone; huge if the motion dies, as stationary noise does not
    type(state_type) :: best
    call start_model(samples, blows, model)
    alone = huge(1.0_dp)
    if (.not. dies(samples, blows)) then
      alone = cost_of_shared_motion(samples)     ! before the model holds its white samples
      call renew(samples, akaike, .false., model, most_orders(samples, most_colour, 1))
      alone = min(alone, model%noise%cost)
    end if
    complete = .false.
    if (present(part)) call take_lines(samples, part, model, complete)
    if (complete) best = state_of(samples, false_alarm, model)
    if (.not. complete) call add_first_lines(samples, false_alarm, alone, model, best, outcome, monitor)
    outcome%converged = size(model%lines) < most_lines   ! so many are not improved, as they describe no motion of few modes
    if (outcome%converged .and. .not. outcome%driven) &
      & call improve_lines(samples, false_alarm, alone, best, model, outcome, monitor)
  end subroutine find_lines_after

  subroutine improve_lines(samples, false_alarm, alone, best, model, outcome, monitor)
    !! Add, merge and drop lines and blows in rounds until J does not fall.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    real(dp), intent(in) :: alone                !! J of noise alone
    type(state_type), intent(inout) :: best
    type(model_type), intent(inout) :: model
    type(line_outcome), intent(inout) :: outcome
    class(monitor_type), intent(inout), optional :: monitor
    integer :: round, changed, dropped, moved
    logical :: is_worse                          !! J has risen
    do round = 1, most_rounds
      if (stops(monitor)) return
      if (present(monitor)) call monitor%advance(first_lines + (1 - first_lines)*round/(most_rounds + 2))
      call refit_all(all_steps, negligible_gain, model)
      call renew(samples, order_price(samples), .false., model)
      call try_moved_blows(samples, false_alarm, .false., model, moved)
      call try_tones(samples, false_alarm, model, changed)
      moved = moved + changed
      call judge_moves()
      call add_lines(changed)
      changed = changed + moved
      call try_missing_blows(samples, false_alarm, 0, .false., model, moved)
      changed = changed + moved
      call judge_moves()
      if (size(model%lines) == 0) exit
      do while (round == 1 .or. changed > 0)     ! otherwise they were tried with these lines
        call merge_lines(samples, false_alarm, model, moved, monitor)
        if (moved == 0) exit
        if (stops(monitor)) exit
        changed = changed + moved
        call judge_moves()
        if (is_worse) exit
      end do
      if (changed > 0) then
        call refit_all(all_steps, negligible_gain, model)
        call renew(samples, order_price(samples), .false., model)
      end if
      call drop_lines(samples, false_alarm, model, dropped, monitor)
      call judge_moves()
      if (changed + dropped == 0) exit
    end do
    call add_drifts(false_alarm, model, changed, monitor)
    call refit_all(all_steps, converged, model)
    call renew(samples, order_price(samples), .false., model)
    call keep_or_clear(samples, false_alarm, alone, least_share, model, outcome)
    if (alone < huge(alone)) call clear_if_growing(samples, model, outcome)
    outcome%converged = round <= most_rounds .and. size(model%lines) < most_lines

  contains

    subroutine add_lines(added)
      !! Add lines and courses that gain more than their penalty in the present noise, which is renewed after each round, while J
      !! falls.
      integer, intent(out) :: added
      integer :: accepted, k
      added = 0
      do k = 1, most_additions
        call add_round(samples, false_alarm, model, outcome, accepted)
        if (accepted == 0) exit
        if (stops(monitor)) exit
        added = added + accepted
        call refit_all(trial_steps, negligible_gain, model)
        call renew(samples, order_price(samples), .false., model)
        call judge_moves()
        if (is_worse) exit
      end do
    end subroutine add_lines

    subroutine judge_moves()
      !! Keep the state of least J, and return to it if moves have raised J.
      call keep_best(samples, false_alarm, model, best)
      is_worse = cost_of_all(samples, false_alarm, model) > best%cost + negligible_gain
      if (is_worse) call go_back(samples, best, model)
    end subroutine judge_moves

  end subroutine improve_lines

  pure subroutine start_model(samples, blows, model)
    !! Start a model with the stretches between blows, and no lines.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: blows(:)
    type(model_type), intent(out) :: model
    allocate (model%stretches(2, 0:size(blows)))
    model%stretches(1, :) = [1, blows]
    model%stretches(2, :) = [blows - 1, samples%count]
    allocate (model%trend(2, size(samples%value, 2), 0:size(blows)), source=0.0_dp)
    allocate (model%lines(0))
  end subroutine start_model

  subroutine take_lines(samples, part, model, complete)
    !! Follow the lines of a part through the record, but for those that drift or are slow: a part does not tell how they go on.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: part
    type(model_type), intent(inout) :: model     !! its first blows are those of the part
    logical, intent(out) :: complete             !! there was no such line
    integer :: k
    model%lines = pack(part%lines, [(size(part%lines(k)%courses) == 0 .and. part%lines(k)%pole%im > slow_in(part), &
      & k=1, size(part%lines))])
    complete = size(model%lines) == size(part%lines)
    do k = 1, size(model%lines)
      model%lines(k)%amplitude = reshape(model%lines(k)%amplitude, [size(samples%value, 2), size(model%stretches, 2)], &
        & pad=[(0.0_dp, 0.0_dp)])
    end do
    call renew(samples, order_price(samples), .false., model, 0)
    call follow_lines(maxval(part%stretches), model)
  end subroutine take_lines

  subroutine add_first_lines(samples, false_alarm, alone, model, best, outcome, monitor)
    !! Add lines, with a noise estimate that is robust to lines still missing. If noise alone explains the record better than the
    !! lines of a round, as it does if the motion is driven, all are dropped.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    real(dp), intent(in) :: alone                !! J of noise alone
    type(model_type), intent(inout) :: model
    type(state_type), intent(inout) :: best
    type(line_outcome), intent(inout) :: outcome
    class(monitor_type), intent(inout), optional :: monitor
    type(line_type), allocatable :: found(:)
    integer :: added, steady, moved, dropped, round, in_vain
    real(dp) :: cost, last
    in_vain = 0
    do round = 1, most_additions
      if (present(monitor)) call monitor%advance(first_lines*round/(round + 2))
      call add_lines_or_blows(added)
      if (stops(monitor)) exit
      if (added > 0) call refit_all(trial_steps, negligible_gain, model)
      if (added > 0) call renew(samples, order_price(samples), .true., model)
      call judge_steady(samples, false_alarm, model, steady)
      if (steady > 0) call refit_all(trial_steps, negligible_gain, model)
      call try_moved_blows(samples, false_alarm, .true., model, moved)
      last = best%cost
      call keep_best(samples, false_alarm, model, best)
      in_vain = merge(0, in_vain + 1, best%cost < last)
      if (added + moved == 0 .or. (in_vain > most_in_vain .and. best%beside_noise < alone)) exit
      if (size(model%lines) < many_lines) cycle
      call try_tones(samples, false_alarm, model, moved)
      call renew(samples, order_price(samples), .false., model)
      found = model%lines
      call drop_weakest(samples, false_alarm, model, dropped)  ! lines that represent a blow found later
      if (size(model%lines) == 0 .and. alone < huge(alone)) model%lines = found  ! noise alone explains these, which is said
      call keep_best(samples, false_alarm, model, best)
      call keep_or_clear(samples, false_alarm, alone, least_share, model, outcome)
      if (size(model%lines) == 0) return
    end do
    call renew(samples, order_price(samples), .false., model)
    if (best%beside_noise < alone .and. best%cost < cost_of_all(samples, false_alarm, model)) call go_back(samples, best, model)
    last = huge(1.0_dp)
    do round = 1, most_additions                 ! the last lines may be decisive, but not more blows
      cost = cost_beside_noise(samples, false_alarm, model)
      if (cost < alone .or. cost > last - abs(alone - cost)/most_additions) exit  ! or J falls too slowly
      last = cost
      call add_round(samples, false_alarm, model, outcome, added)
      if (added == 0) exit
      if (stops(monitor)) exit
      call refit_all(trial_steps, negligible_gain, model)
      call renew(samples, order_price(samples), .false., model)
    end do
    call keep_or_clear(samples, false_alarm, alone, 0.0_dp, model, outcome)

  contains

    subroutine add_lines_or_blows(added)
      !! Add lines, or blows instead if these lower J more: a blow, too, causes a residual beside the lines.
      integer, intent(out) :: added
      type(state_type) :: with_lines
      type(line_type), allocatable :: before(:)
      logical :: beside
      integer :: blows, more
      before = model%lines
      call renew(samples, order_price(samples), .true., model)
      call add_round(samples, false_alarm, model, outcome, added, beside)
      if (added == 0 .or. .not. beside .or. allocated(samples%blow)) return
      call refit_all(trial_steps, negligible_gain, model)
      with_lines = state_of(samples, false_alarm, model)
      model%lines = before
      more = 0
      do
        call try_missing_blows(samples, false_alarm, 1, .true., model, blows)
        if (blows < 1) exit
        more = more + blows
        if (stops(monitor)) return
      end do
      if (more > 0 .and. cost_of_all(samples, false_alarm, model) < with_lines%cost) then
        added = more
      else
        call go_back(samples, with_lines, model)
      end if
    end subroutine add_lines_or_blows

  end subroutine add_first_lines

  subroutine try_tones(samples, false_alarm, model, changed)
    !! Turn lines that hardly decay into tones that were there before the first blow, if that lowers J. A record that begins within
    !! such tones seems to begin with a blow, which is dropped with the strongest of them.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: changed              !! number of lines
    type(state_type) :: before
    logical :: open(size(model%lines)), is_cut
    real(dp) :: power(size(model%lines))
    integer :: k, tones
    changed = 0
    if (count(.not. model%lines%steady) < 2) return  ! at least one line must be struck
    open = [(may_be_tone(model, model%lines(k)), k=1, size(open))]
    is_cut = model%stretches(2, 0) < model%stretches(1, 0) .and. ubound(model%stretches, 2) > 1 .and. .not. allocated(samples%blow)
    if (is_cut .and. model%stretches(2, 1) - model%stretches(1, 1) + 1 >= enough_for(1)) then
      before = state_of(samples, false_alarm, model)
      power = merge([(tone_power(samples, model, model%lines(k)%pole%im), k=1, size(open))], 0.0_dp, open)
      do tones = 1, min(count(open), count(.not. model%lines%steady) - 1)
        do k = 1, size(open)
          if (.not. open(k) .or. count(power > power(k)) >= tones) cycle
          model%lines(k)%pole%re = 0
          model%lines(k)%steady = .true.
        end do
        call drop_blow(model, 1)
        changed = tones
        call keep_if_cheaper(samples, false_alarm, before, model, changed)
        if (changed > 0) exit
      end do
    end if
    call judge_steady(samples, false_alarm, model, k)
    changed = changed + k
  end subroutine try_tones

  pure real(dp) function tone_power(samples, model, frequency) result(power)
    !! The part of the first stretch's motion that is a tone of this frequency, summed over sensors.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    real(dp), intent(in) :: frequency            !! rad per step
    type(line_type) :: tone
    complex(dp) :: wave(model%stretches(2, 1) - model%stretches(1, 1) + 1)
    real(dp) :: x(size(wave))
    integer :: s
    tone%pole = cmplx(0, frequency, dp)
    allocate (tone%courses(0))
    call find_wave(tone, 0.0_dp, wave=wave)
    power = 0
    do s = 1, size(samples%value, 2)
      x = samples%value(model%stretches(1, 1):model%stretches(2, 1), s)
      x = x - sum(x)/size(x)
      power = power + abs(sum(wave*x))**2/max(sum(x**2), tiny(1.0_dp))
    end do
  end function tone_power

end module bw_line_search
