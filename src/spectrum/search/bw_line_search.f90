module bw_line_search
  !! The lines of a record: one number is made small by a few moves.
  !!
  !! J = −2 ln L of the prediction errors + the penalty of each unknown. Moves add a line where a bank of decays shows one, or a course to a
  !! line; renew the noise; move, add and drop blows; and drop whatever does not pay. The search ends when no move lowers J. What stands
  !! here is the order of the moves; what each is stands in `bw_line_moves`, `bw_line_drops` and `bw_blow_moves`.
  use bw_band, only: enough_for
  use bw_blow_moves, only: add_missing_blows, drop_blow, move_blows
  use bw_blows, only: find_blows
  use bw_cost, only: cost_of_all, order_price, penalty_of_tone
  use bw_decay_bank, only: highest_decay
  use bw_kinds, only: dp
  use bw_limited_range, only: allow_for_limits
  use bw_line, only: line_type
  use bw_line_drops, only: clear_if_cancelling, drop_lines, drop_weakest, keep_or_clear, line_outcome
  use bw_line_moves, only: add_drifts, add_lines, add_round, judge_steady, may_be_tone, merge_lines, &
    & most_additions, most_lines
  use bw_model, only: model_type, renew
  use bw_monitor, only: monitor_type, stops
  use bw_noise_alone, only: cost_of_shared_motion, most_orders
  use bw_refit, only: all_steps, at_rest, refit_all, trial_steps
  use bw_samples, only: samples_type
  implicit none (type, external)
  private
  public :: find_lines, line_outcome

  integer, parameter :: many_lines = 24           !! tuned: so many may be parts of a driven motion
  integer, parameter :: most_colour = 1024        !! order of noise alone, which a driven beam's motion is
  integer, parameter :: most_rounds = 4
  real(dp), parameter :: first_lines = 0.6_dp     !! of the time

  type :: description_type
    !! What a model says of a record, to which the search may go back.
    type(line_type), allocatable :: lines(:)
    integer, allocatable :: stretches(:, :)      !! (2, 0:B)
    real(dp), allocatable :: trend(:, :, :)      !! (2, S, 0:B)
    real(dp) :: cost = 0                         !! J
  end type description_type

contains

  subroutine find_lines(samples, false_alarm, model, outcome, monitor)
    !! Find the lines of a record.
    type(samples_type), intent(inout) :: samples   !! as they were in the end
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(out) :: model
    type(line_outcome), intent(out) :: outcome
    class(monitor_type), intent(inout), optional :: monitor  !! nothing is of use where it asks to stop
    integer, allocatable :: blows(:)
    if (allocated(samples%blow)) then
      blows = samples%blow
    else
      call find_blows(samples, false_alarm, blows)
    end if
    call find_lines_behind(blows, samples, false_alarm, model, outcome, monitor)
    if (outcome%driven .and. allocated(samples%valid) .and. size(blows) > 1 .and. .not. allocated(samples%blow)) &
      & call find_lines_behind(blows(:1), samples, false_alarm, model, outcome, monitor)   ! gaps may look like others
    call allow_for_limits(samples, model)
  end subroutine find_lines

  subroutine find_lines_behind(blows, samples, false_alarm, model, outcome, monitor)
    !! Find the lines of a record that was struck, as far as is known, at some samples.
    integer, intent(in) :: blows(:)
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(out) :: model
    type(line_outcome), intent(out) :: outcome
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: alone                            !! J of noise alone
    real(dp) :: last                             !! J of the round before
    integer :: round, changed, dropped, moved
    allocate (outcome%poles(0), outcome%gains(0))
    alone = cost_of_shared_motion(samples)       ! before there is anything else in memory
    call start_model(samples, blows, model)
    call renew(samples, order_price(samples), .false., model, most_orders(samples, most_colour, 1))
    alone = min(alone, model%noise%cost)
    call add_first_lines(samples, false_alarm, alone, model, outcome, monitor)
    if (outcome%driven) return
    last = huge(1.0_dp)
    do round = 1, most_rounds
      if (stops(monitor)) return
      if (present(monitor)) call monitor%advance(first_lines + (1 - first_lines)*round/(most_rounds + 2))
      call refit_all(all_steps, at_rest, model)
      call renew(samples, order_price(samples), .false., model)
      call try_blows(samples, false_alarm, model, moved)
      call try_tones(samples, false_alarm, model, changed)
      moved = moved + changed
      call add_lines(samples, false_alarm, model, changed, monitor)
      changed = changed + moved
      call try_blows(samples, false_alarm, model, moved, 0.0_dp)
      changed = changed + moved
      if (size(model%lines) == 0) exit
      do
        call merge_lines(samples, false_alarm, model, moved)
        if (moved == 0) exit
        if (stops(monitor)) exit
        changed = changed + moved
      end do
      if (changed > 0) then
        call refit_all(all_steps, at_rest, model)
        call renew(samples, order_price(samples), .false., model)
      end if
      call drop_lines(samples, false_alarm, model, dropped, outcome)
      if (changed + dropped == 0) exit
      if (cost_of_all(samples, false_alarm, model) > max(alone, last)) exit   ! no move makes noise alone the worse description
      last = cost_of_all(samples, false_alarm, model)
    end do
    call add_drifts(false_alarm, model, changed)
    call refit_all(all_steps, 0.0_dp, model)
    call renew(samples, order_price(samples), .false., model)
    call keep_or_clear(samples, false_alarm, alone, model, outcome)
    call clear_if_cancelling(samples, model, outcome)
    outcome%converged = round <= most_rounds .and. size(model%lines) < most_lines
  end subroutine find_lines_behind

  pure subroutine start_model(samples, blows, model)
    !! The stretches between blows, and no lines.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: blows(:)
    type(model_type), intent(out) :: model
    allocate (model%stretches(2, 0:size(blows)))
    model%stretches(1, :) = [1, blows]
    model%stretches(2, :) = [blows - 1, samples%count]
    allocate (model%trend(2, size(samples%value, 2), 0:size(blows)), source=0.0_dp)
    allocate (model%lines(0))
  end subroutine start_model

  subroutine add_first_lines(samples, false_alarm, alone, model, outcome, monitor)
    !! Add lines while the noise is found in a way that they do not disturb. Where noise alone explains the record better than the lines
    !! of a round and noise, as it does where the motion is driven, there are none.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    real(dp), intent(in) :: alone                !! J of noise alone
    type(model_type), intent(inout) :: model
    type(line_outcome), intent(inout) :: outcome
    class(monitor_type), intent(inout), optional :: monitor
    integer :: added, steady, moved, dropped, round
    real(dp) :: cost, last
    do round = 1, most_additions
      if (present(monitor)) call monitor%advance(first_lines*round/(round + 2))
      call renew(samples, order_price(samples), .true., model)
      call add_round(samples, false_alarm, model, added)
      if (stops(monitor)) exit
      if (added > 0) call refit_all(trial_steps, at_rest, model)
      if (added > 0) call renew(samples, order_price(samples), .true., model)
      call judge_steady(samples, false_alarm, model, steady)
      if (steady > 0) call refit_all(trial_steps, at_rest, model)
      moved = 0
      if (.not. allocated(samples%blow)) call move_blows(samples, false_alarm, model, moved)
      if (moved > 0) then
        call renew(samples, order_price(samples), .true., model)
        call refit_all(trial_steps, at_rest, model)
      end if
      if (added + moved == 0) exit
      if (size(model%lines) < many_lines) cycle
      call try_tones(samples, false_alarm, model, moved)
      call renew(samples, order_price(samples), .false., model)
      call drop_weakest(samples, false_alarm, model, dropped)  ! that stood for a blow which was found later
      call keep_or_clear(samples, false_alarm, alone, model, outcome)
      if (size(model%lines) == 0) return
    end do
    call renew(samples, order_price(samples), .false., model)
    last = huge(1.0_dp)
    do round = 1, most_additions                 ! the last lines may decide
      cost = cost_of_all(samples, false_alarm, model)
      if (cost < alone .or. cost > last - abs(alone - cost)/most_additions) exit  ! or lines do not get there
      last = cost
      call add_round(samples, false_alarm, model, added)
      if (added == 0) exit
      if (stops(monitor)) exit
      call refit_all(trial_steps, at_rest, model)
      call renew(samples, order_price(samples), .false., model)
    end do
    call keep_or_clear(samples, false_alarm, alone, model, outcome)
  end subroutine add_first_lines

  subroutine try_blows(samples, false_alarm, model, moved, rival)
    !! Drop and move blows, or add those that are missing, if that lowers J when the lines are fitted again.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: moved                !! blows
    real(dp), intent(in), optional :: rival      !! blows are added where they take more than this off the squares
    type(description_type) :: before
    integer :: fleeting
    moved = 0
    if (allocated(samples%blow)) return
    before = description_of(samples, false_alarm, model)
    if (present(rival)) then
      call add_missing_blows(samples, false_alarm, rival, merge(1, 0, rival > 0), model, moved)
    else
      fleeting = count(-model%lines%pole%re > highest_decay)   ! such a line makes up for a blow that is somewhere else
      if (fleeting > 0) model%lines = pack(model%lines, -model%lines%pole%re <= highest_decay)
      if (fleeting > 0) call renew(samples, order_price(samples), .false., model)
      call move_blows(samples, false_alarm, model, moved)
      moved = moved + fleeting
    end if
    if (moved > 0) call keep_if_cheaper(samples, false_alarm, before, model, moved)
  end subroutine try_blows

  subroutine try_tones(samples, false_alarm, model, changed)
    !! Take lines that hardly decay for tones which were there before the first blow, one after the other, where that lowers J. A record
    !! whose first sample is within such a tone seems to be struck there.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: changed              !! lines
    type(description_type) :: before
    complex(dp), allocatable :: modes(:)         !! poles of lines that are no tones
    logical :: open(size(model%lines)), is_cut
    integer :: k, b, accepted
    changed = 0
    allocate (modes(0))
    do
      open = [(may_be_tone(model, model%lines(k)) .and. all(abs(modes - model%lines(k)%pole) > 0), k=1, size(open))]
      if (.not. any(open) .or. count(.not. model%lines%steady) < 2) return   ! or nothing was struck
      is_cut = model%stretches(2, 0) < model%stretches(1, 0)
      b = merge(1, 0, is_cut .and. ubound(model%stretches, 2) > 1)
      if (model%stretches(2, b) - model%stretches(1, b) + 1 < enough_for(1)) return   ! nothing tells what was before
      k = minloc(abs(model%lines%pole%re), dim=1, mask=open)
      modes = [modes, model%lines(k)%pole]
      before = description_of(samples, false_alarm, model)
      before%cost = before%cost - penalty_of_tone(samples, false_alarm)
      model%lines(k)%pole = cmplx(0, model%lines(k)%pole%im, dp)
      model%lines(k)%steady = .true.
      if (is_cut .and. .not. allocated(samples%blow)) call drop_blow(model, 1)
      accepted = 1
      call keep_if_cheaper(samples, false_alarm, before, model, accepted)
      changed = changed + accepted
    end do
  end subroutine try_tones

  function description_of(samples, false_alarm, model) result(description)
    !! What a model says of a record, and J.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model     !! is renewed
    type(description_type) :: description
    call renew(samples, order_price(samples), .false., model)
    description%cost = cost_of_all(samples, false_alarm, model)
    allocate (description%lines, source=model%lines)
    allocate (description%stretches(2, 0:ubound(model%stretches, 2)), source=model%stretches)
    allocate (description%trend(2, size(model%trend, 2), 0:ubound(model%stretches, 2)), source=model%trend)
  end function description_of

  subroutine keep_if_cheaper(samples, false_alarm, before, model, moved)
    !! Fit the lines of a model again, and go back to the description before if that was the better one.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(description_type), intent(inout) :: before
    type(model_type), intent(inout) :: model
    integer, intent(inout) :: moved              !! blows; 0 if the model goes back
    call renew(samples, order_price(samples), .false., model)
    call refit_all(trial_steps, at_rest, model)
    call renew(samples, order_price(samples), .false., model)
    if (cost_of_all(samples, false_alarm, model) < before%cost) return
    moved = 0
    call move_alloc(before%lines, model%lines)
    call move_alloc(before%stretches, model%stretches)
    call move_alloc(before%trend, model%trend)
    call renew(samples, order_price(samples), .false., model)
  end subroutine keep_if_cheaper

end module bw_line_search
