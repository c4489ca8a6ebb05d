module bw_line_search
  !! The lines of a record: one number is made small by a few moves.
  !!
  !! J = −2 ln L of the prediction errors + the price of each unknown, such that noise alone gets a line with the probability
  !! `false_alarm`. Moves add a line where a bank of decays shows one, or a course to a line; renew the noise; move, add and drop
  !! blows; and drop whatever does not pay, the noise renewed on both sides of the comparison. The search ends when no move lowers J.
  use bw_band, only: band_type
  use bw_blow_moves, only: add_missing_blows, move_blows
  use bw_blows, only: find_blows
  use bw_decay_bank, only: candidate_type, find_candidates
  use bw_kinds, only: dp
  use bw_line, only: course_type, life_of, line_type, pi
  use bw_model, only: colour_at, model_type, renew
  use bw_monitor, only: monitor_type, stops
  use bw_noise, only: white_amplitude
  use bw_order, only: ascending
  use bw_price, only: chi_squared, line_price
  use bw_refit, only: accept, near, overlaps, refit, refit_all, refit_type, span_of_model
  use bw_samples, only: samples_type
  use bw_vector_noise, only: vector_noise_cost
  implicit none (type, external)
  private
  public :: find_lines

  integer, parameter :: most_lines = 60
  integer, parameter :: many_lines = 24           !! tuned: so many may be parts of a driven motion
  integer, parameter :: most_colour = 1024        !! order of noise alone, which a driven beam's motion is
  integer, parameter :: least_colour = 8          !! of that in a record that is large
  integer, parameter :: most_rounds = 4
  integer, parameter :: most_additions = 12       !! rounds in which lines are added, since a blow may come and go
  real(dp), parameter :: at_rest = 1              !! fall of −2 ln L in a sweep over all lines, after which they stay
  real(dp), parameter :: same_shape = 0.8_dp      !! tuned: cosine between the shapes of a line and of what its drift leaves
  integer, parameter :: first_window = 64         !! part of the longest stretch in which a drifting line is looked at first
  real(dp), parameter :: promised = 0.5_dp        !! tuned: part of what a candidate seems to gain, that it gains beside those before
  integer, parameter :: first_steps = 8, trial_steps = 5, all_steps = 10

  type, public :: outcome_type
    !! How a search ended.
    logical :: converged = .true.                !! no move lowers J any more
    logical :: driven = .false.                  !! noise alone explains the motion better than all lines that were found
    complex(dp), allocatable :: poles(:)         !! of lines that were dropped again, or that noise alone explains
    real(dp), allocatable :: gains(:)            !! squares over the noise's variance, that they took off
  end type outcome_type

contains

  subroutine find_lines(samples, false_alarm, model, outcome, monitor)
    !! Find the lines of a record.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(out) :: model
    type(outcome_type), intent(out) :: outcome
    class(monitor_type), intent(inout), optional :: monitor  !! nothing is of use where it asks to stop
    real(dp) :: alone                            !! J of noise alone
    real(dp) :: last                             !! J of the round before
    integer, allocatable :: blows(:)
    integer :: round, changed, dropped, moved
    allocate (outcome%poles(0), outcome%gains(0))
    call find_blows(samples, false_alarm, blows)
    call start_model(samples, blows, model)
    call renew(samples, order_price(samples), .false., model, most_orders(samples, most_colour, 1))
    alone = min(model%noise%cost, cost_of_shared_motion(samples))
    call add_first_lines(samples, false_alarm, alone, model, outcome, monitor)
    if (outcome%driven) return
    last = huge(1.0_dp)
    do round = 1, most_rounds
      if (stops(monitor)) return
      call refit_all(all_steps, at_rest, model)
      call renew(samples, order_price(samples), .false., model)
      call judge_steady(samples, false_alarm, model, changed)
      if (changed > 0) call refit_all(all_steps, at_rest, model)
      call try_blows(samples, false_alarm, model, moved)
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
    outcome%converged = round <= most_rounds .and. size(model%lines) < most_lines
  end subroutine find_lines

  subroutine try_blows(samples, false_alarm, model, moved, rival)
    !! Drop and move blows, or add those that are missing, if that lowers J when the lines are fitted again.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: moved                !! blows
    real(dp), intent(in), optional :: rival      !! blows are added where they take more than this off the squares
    type(line_type), allocatable :: lines(:)
    integer, allocatable :: stretches(:, :)
    real(dp), allocatable :: still(:, :, :)
    real(dp) :: before
    call renew(samples, order_price(samples), .false., model)
    before = cost_of_all(samples, false_alarm, model)
    allocate (lines, source=model%lines)
    allocate (stretches(2, 0:ubound(model%stretches, 2)), source=model%stretches)
    allocate (still(2, size(model%still, 2), 0:ubound(model%stretches, 2)), source=model%still)
    if (present(rival)) then
      call add_missing_blows(samples, false_alarm, rival, merge(1, 0, rival > 0), model, moved)
    else
      call move_blows(samples, false_alarm, model, moved)
    end if
    if (moved == 0) return
    call renew(samples, order_price(samples), .false., model)
    call refit_all(trial_steps, at_rest, model)
    call renew(samples, order_price(samples), .false., model)
    if (cost_of_all(samples, false_alarm, model) < before) return
    moved = 0
    call move_alloc(lines, model%lines)
    call move_alloc(stretches, model%stretches)
    call move_alloc(still, model%still)
    call renew(samples, order_price(samples), .false., model)
  end subroutine try_blows

  pure real(dp) function cost_of_all(samples, false_alarm, model) result(cost)
    !! J.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(in) :: model
    cost = model%noise%cost + size(model%lines)*price_of_line(samples, false_alarm, model)
  end function cost_of_all

  real(dp) function cost_of_shared_motion(samples) result(cost)
    !! J of noise alone that is one motion of all sensors; huge where samples are missing.
    type(samples_type), intent(in) :: samples
    real(dp), allocatable :: x(:, :)
    integer :: s, n
    cost = huge(1.0_dp)
    n = samples%count
    if (allocated(samples%valid) .or. size(samples%value, 2) == 1) return
    allocate (x(n, size(samples%value, 2)))
    do s = 1, size(x, 2)
      x(:, s) = samples%value(:n, s) - sum(samples%value(:n, s))/n
    end do
    cost = vector_noise_cost(x, most_orders(samples, n/(10*size(x, 2)), size(x, 2)), order_price(samples))
  end function cost_of_shared_motion

  pure integer function most_orders(samples, highest, sensors) result(order)
    !! As high an order of noise alone as takes about a second, each being predicted from so many sensors.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: highest, sensors
    real(dp), parameter :: products = 5.0e8_dp
    order = min(highest, max(least_colour, int(products/(real(size(samples%value), dp)*sensors))))
  end function most_orders

  subroutine add_first_lines(samples, false_alarm, alone, model, outcome, monitor)
    !! Add lines while the noise is found in a way that they do not disturb. Where noise alone explains the record better than the lines
    !! of a round and noise, as it does where the motion is driven, there are none.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    real(dp), intent(in) :: alone                !! J of noise alone
    type(model_type), intent(inout) :: model
    type(outcome_type), intent(inout) :: outcome
    class(monitor_type), intent(inout), optional :: monitor
    integer :: added, steady, moved, round
    real(dp) :: cost, last
    do round = 1, most_additions
      call renew(samples, order_price(samples), .true., model)
      call add_round(samples, false_alarm, model, added)
      if (added == 0) exit
      if (stops(monitor)) exit
      call refit_all(trial_steps, at_rest, model)
      call renew(samples, order_price(samples), .true., model)
      call judge_steady(samples, false_alarm, model, steady)
      if (steady > 0) call refit_all(trial_steps, at_rest, model)
      call move_blows(samples, false_alarm, model, moved)
      if (moved > 0) then
        call renew(samples, order_price(samples), .true., model)
        call refit_all(trial_steps, at_rest, model)
      end if
      if (size(model%lines) < many_lines) cycle
      call renew(samples, order_price(samples), .false., model)
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

  pure real(dp) function order_price(samples)
    !! Of a coefficient of the noise's autoregression (Schwarz, 1978).
    type(samples_type), intent(in) :: samples
    order_price = log(real(samples%count, dp))
  end function order_price

  pure real(dp) function price_of_line(samples, false_alarm, model)
    !! Of a line with its amplitudes at all sensors after all blows.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(in) :: model
    price_of_line = line_price(false_alarm, samples%count, 2*size(samples%value, 2)*ubound(model%stretches, 2))
  end function price_of_line

  pure real(dp) function price_of_course(false_alarm)
    !! Of a drift's three unknowns, and which of a few rates it starts from.
    real(dp), intent(in) :: false_alarm
    price_of_course = chi_squared(false_alarm, 4)
  end function price_of_course

  pure subroutine start_model(samples, blows, model)
    !! The stretches between blows, and no lines.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: blows(:)
    type(model_type), intent(out) :: model
    allocate (model%stretches(2, 0:size(blows)))
    model%stretches(1, :) = [1, blows]
    model%stretches(2, :) = [blows - 1, samples%count]
    allocate (model%still(2, size(samples%value, 2), 0:size(blows)), source=0.0_dp)
    allocate (model%lines(0))
  end subroutine start_model

  subroutine add_lines(samples, false_alarm, model, added, monitor)
    !! Add lines and courses while they pay at the present noise, which is renewed after each round.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: added
    class(monitor_type), intent(inout), optional :: monitor
    integer :: accepted, round
    added = 0
    do round = 1, most_additions
      call add_round(samples, false_alarm, model, accepted)
      if (accepted == 0) exit
      if (stops(monitor)) exit
      added = added + accepted
      call refit_all(trial_steps, at_rest, model)
      call renew(samples, order_price(samples), .false., model)
    end do
  end subroutine add_lines

  subroutine add_round(samples, false_alarm, model, accepted)
    !! Add lines and courses that do not overlap where the bank of decays shows that some are missing.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: accepted
    type(candidate_type), allocatable :: candidates(:)
    complex(dp), allocatable :: moved(:)
    type(refit_type) :: found
    real(dp) :: need, price, gain
    integer :: i
    accepted = 0
    moved = [complex(dp) ::]
    need = price_of_line(samples, false_alarm, model)
    call find_candidates(model, need, most_lines, candidates)
    do i = 1, size(candidates)
      if (any(overlaps(moved, candidates(i)%pole, span_of_model(model)))) cycle  ! first let these come to rest
      if (size(model%lines) >= most_lines) return
      call propose(need, price_of_course(false_alarm), candidates(i), model, found, price)
      price = price*colour_at(model, candidates(i)%pole%im)
      if (i == 1 .and. any(found%old)) then      ! the same residual may come from a blow
        call add_missing_blows(samples, false_alarm, found%gain, 1, model, accepted)
        if (accepted > 0) return
      end if
      if (accepted > 0 .and. found%gain < promised*candidates(i)%gain) cycle  ! it was the skirt of another
      gain = 0
      if (found%gain > price) call accept(found, price, model, gain)
      if (.not. gain > 0) cycle
      accepted = accepted + 1
      moved = [moved, candidates(i)%pole, model%lines(size(model%lines))%pole]
    end do
  end subroutine add_round

  subroutine propose(need, need_of_course, candidate, model, found, price)
    !! Fit a line at a candidate's place, or a course of the line beside it, whichever J prefers.
    real(dp), intent(in) :: need, need_of_course !! prices of a line and of a course
    type(candidate_type), intent(in) :: candidate
    type(model_type), intent(in) :: model
    type(refit_type), intent(out) :: found
    real(dp), intent(out) :: price               !! of what is proposed
    type(refit_type) :: bent
    type(line_type) :: line
    logical, allocatable :: own(:)
    integer :: host
    line%pole = candidate%pole
    allocate (line%courses(0))
    own = near(model, line%pole)
    call refit(model, own, [pack(model%lines, own), line], first_steps, found)
    price = need
    if (.not. any(own)) return
    host = minloc(abs(model%lines%pole%im - line%pole%im), dim=1, mask=own)
    if (.not. beside(model%lines(host), found%lines(size(found%lines)), span_of_model(model))) return
    call add_course(model, own, pack(model%lines, own), count(own(:host)), bent)
    if (.not. bent%gain - need_of_course > found%gain - need) return
    found = bent
    price = need_of_course
  end subroutine propose

  pure logical function beside(line, other, span)
    !! Whether one line may be what the other's drift leaves: it is in its place, and of its shape.
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
    beside = product > same_shape*lengths .and. &
      & abs(line%pole%im - other%pole%im) < 3*(abs(line%pole%re) + abs(other%pole%re)) + 2*pi*4/span
  end function beside

  subroutine add_course(model, own, start, host, best)
    !! Fit the best further course of a line, over its rates. The line is followed from the blow on, over longer and longer parts of the
    !! record, so that its phase is never far from that of the fit.
    type(model_type), intent(in) :: model
    logical, intent(in) :: own(:)                !! lines that are replaced
    type(line_type), intent(in) :: start(:)      !! by these
    integer, intent(in) :: host                  !! which of these gets the course
    type(refit_type), intent(out) :: best
    real(dp) :: span
    integer :: c
    span = span_of_model(model)
    c = size(start(host)%courses) + 1
    best%gain = -huge(1.0_dp)
    call try(2/span)
    call try(2*abs(start(host)%pole%re) + 1/span)

  contains

    subroutine try(rate)
      !! Follow the line with a course of this rate, which is free in the end.
      real(dp), intent(in) :: rate
      type(line_type), allocatable :: lines(:)
      type(refit_type) :: found
      integer :: window
      lines = start
      window = nint(span)/first_window
      do while (2*window < span)
        call refit(model, own, lines, trial_steps, found, window)
        lines = found%lines
        if (size(lines(host)%courses) < c) lines(host)%courses = [lines(host)%courses, course_type(rate, (0.0_dp, 0.0_dp), .true.)]
        window = 2*window
      end do
      call refit(model, own, lines, trial_steps, found)
      lines = found%lines
      lines(host)%courses(c)%held = .false.
      call refit(model, own, lines, all_steps, found)
      if (found%gain > best%gain) best = found
    end subroutine try

  end subroutine add_course

  subroutine add_drifts(false_alarm, model, added)
    !! Let frequency and decay of lines change evenly where that pays; what a faster change leaves, the bank of decays shows.
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: added
    logical :: done(size(model%lines)), own(size(model%lines))
    type(line_type), allocatable :: start(:)
    type(refit_type) :: found
    real(dp) :: gain
    integer :: k, host
    added = 0
    done = [(model%lines(k)%steady .or. size(model%lines(k)%courses) > 0, k=1, size(done))]
    do while (.not. all(done))
      k = findloc(done, .false., dim=1)
      done(k) = .true.
      own = near(model, model%lines(k)%pole)
      host = count(own(:k))
      start = pack(model%lines, own)
      start(host)%courses = [course_type(0.0_dp, (0.0_dp, 0.0_dp), .true.)]
      call refit(model, own, start, first_steps, found)
      call accept(found, chi_squared(false_alarm, 2), model, gain)
      if (.not. abs(gain) > 0) cycle
      added = added + 1
      done = [pack(done, .not. own), pack(done, own)]  ! places have changed
    end do
  end subroutine add_drifts

  subroutine judge_steady(samples, false_alarm, model, changed)
    !! Take lines for tones that do not decay, and were there before the first blow, or for modes, whichever has the lower J.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: changed              !! lines
    type(refit_type) :: found
    type(line_type), allocatable :: start(:)
    logical :: own(size(model%lines))
    real(dp) :: price, gain
    integer :: k
    changed = 0
    if (model%stretches(2, 0) < model%stretches(1, 0)) return   ! nothing tells what was before
    price = chi_squared(false_alarm, 2*size(samples%value, 2)) - chi_squared(false_alarm, 2)  ! an amplitude more, a decay less
    k = 0
    do while (k < size(model%lines))
      k = k + 1
      associate (line => model%lines(k))
        if (line%steady .or. size(line%courses) > 0 .or. abs(line%pole%re)*span_of_model(model) > 1) cycle
      end associate
      own = near(model, model%lines(k)%pole)
      start = pack(model%lines, own)
      start(count(own(:k)))%steady = .true.
      start(count(own(:k)))%pole%re = 0
      call refit(model, own, start, trial_steps, found)
      call accept(found, price, model, gain)
      if (.not. abs(gain) > 0) cycle
      changed = changed + 1
      k = k - count(own(:k))                     ! places have changed
    end do
  end subroutine judge_steady

  subroutine merge_lines(samples, false_alarm, model, merged)
    !! Replace lines beside a stronger one by a course of that one, where J falls.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: merged
    type(refit_type) :: found
    type(line_type), allocatable :: start(:)
    logical, allocatable :: own(:), kept(:)
    real(dp) :: energy(size(model%lines)), gain, price
    integer :: order(size(model%lines)), i, k, host
    merged = 0
    energy = [(energy_of(model, model%lines(k)), k=1, size(energy))]
    order = ascending(energy)
    price = price_of_line(samples, false_alarm, model)
    do i = 1, size(order)
      k = order(i)                               ! the weakest first
      own = near(model, model%lines(k)%pole)
      own(k) = .false.
      if (.not. any(own .and. energy > energy(k))) cycle
      host = minloc(abs(model%lines%pole%im - model%lines(k)%pole%im), dim=1, mask=own .and. energy > energy(k))
      if (.not. beside(model%lines(host), model%lines(k), span_of_model(model))) cycle
      kept = own
      own(k) = .true.
      start = pack(model%lines, kept)
      call add_course(model, own, start, count(kept(:host)), found)
      call accept(found, price_of_course(false_alarm) - price, model, gain)
      if (abs(gain) > 0) then
        merged = merged + 1
        return                                   ! places have changed
      end if
    end do
  end subroutine merge_lines

  subroutine keep_or_clear(samples, false_alarm, alone, model, outcome)
    !! Drop all lines unless they explain the record better than noise alone, be it of any colour: the motion is driven.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    real(dp), intent(in) :: alone                !! J of noise alone
    type(model_type), intent(inout) :: model
    type(outcome_type), intent(inout) :: outcome
    integer :: k
    if (size(model%lines) == 0) return
    if (cost_of_all(samples, false_alarm, model) < alone) return
    outcome%driven = .true.
    outcome%poles = [outcome%poles, model%lines%pole]
    outcome%gains = [outcome%gains, [(energy_of(model, model%lines(k)), k=1, size(model%lines))]]
    model%lines = model%lines(:0)
    call renew(samples, order_price(samples), .false., model)
  end subroutine keep_or_clear

  subroutine drop_lines(samples, false_alarm, model, dropped, outcome)
    !! Drop lines that do not pay against the best coloured noise, one after the other.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: dropped
    type(outcome_type), intent(inout) :: outcome
    type :: line_list
      type(line_type), allocatable :: lines(:)
    end type line_list
    type(line_list), allocatable :: without(:)
    type(line_type), allocatable :: all_of(:)
    real(dp), allocatable :: cost(:)
    real(dp) :: with_all
    integer :: k, n
    call drop_weakest(samples, false_alarm, model, dropped)
    do while (size(model%lines) > 0)
      all_of = model%lines
      n = size(all_of)
      with_all = model%noise%cost
      allocate (without(2*n), cost(2*n))
      do k = 1, n
        without(k)%lines = lines_without(model, k, .false.)
        if (size(all_of(k)%courses) > 0) without(n + k)%lines = lines_without(model, k, .true.)
      end do
      cost = huge(1.0_dp)
      do k = 1, 2*n
        if (.not. allocated(without(k)%lines)) cycle
        model%lines = without(k)%lines
        call renew(samples, order_price(samples), .false., model)
        cost(k) = model%noise%cost &
          & - merge(price_of_line(samples, false_alarm, model), price_of_course(false_alarm), k <= n)
      end do
      k = minloc(cost, dim=1)
      model%lines = all_of
      if (cost(k) < with_all) model%lines = without(k)%lines
      if (cost(k) < with_all .and. k <= n) then
        outcome%poles = [outcome%poles, all_of(k)%pole]
        outcome%gains = [outcome%gains, energy_of(model, all_of(k))]
      end if
      call renew(samples, order_price(samples), .false., model)
      if (.not. cost(k) < with_all) exit
      dropped = dropped + 1
      deallocate (without, cost)
    end do
  end subroutine drop_lines

  subroutine drop_weakest(samples, false_alarm, model, dropped)
    !! Drop as many of the weakest lines, others as they are, as makes J least.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: dropped
    type(line_type) :: by_energy(size(model%lines))
    real(dp) :: energy(size(model%lines)), least, cost
    integer :: k, n
    n = size(model%lines)
    dropped = 0
    do k = 1, n
      energy(k) = energy_of(model, model%lines(k))
    end do
    by_energy = model%lines(ascending(energy))
    least = model%noise%cost + n*price_of_line(samples, false_alarm, model)
    do k = 1, n
      model%lines = by_energy(k + 1:)
      call renew(samples, order_price(samples), .false., model)
      cost = model%noise%cost + (n - k)*price_of_line(samples, false_alarm, model)
      if (cost >= least) cycle
      least = cost
      dropped = k
    end do
    model%lines = by_energy(dropped + 1:)
    call renew(samples, order_price(samples), .false., model)
    if (dropped > 0) call refit_all(all_steps, at_rest, model)
    if (dropped > 0) call renew(samples, order_price(samples), .false., model)
  end subroutine drop_weakest

  pure real(dp) function energy_of(model, line) result(energy)
    !! About the squares of a line's white samples.
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: line
    complex(dp) :: white(size(line%amplitude, 1), size(line%amplitude, 2))
    integer :: b
    white = white_amplitude(model%noise, line)
    energy = 0
    do b = 0, ubound(model%stretches, 2)
      associate (n => real(model%stretches(2, b) - model%stretches(1, b) + 1, dp))
        energy = energy + sum(abs(white(:, b + 1))**2)*life_of(line, 1.0_dp, max(n, 0.0_dp))
      end associate
    end do
  end function energy_of

  function lines_without(model, k, course_alone) result(lines)
    !! All lines without one, or without its last course, those that overlap with it fitted again.
    type(model_type), intent(in) :: model
    integer, intent(in) :: k
    logical, intent(in) :: course_alone
    type(line_type), allocatable :: lines(:)
    logical :: own(size(model%lines)), others(size(model%lines))
    type(refit_type) :: found
    own = near(model, model%lines(k)%pole)
    own(k) = .true.
    others = .true.
    others(k) = course_alone
    lines = model%lines
    if (course_alone) lines(k)%courses = lines(k)%courses(:size(lines(k)%courses) - 1)
    if (any(own .and. others)) then
      call refit(model, own, pack(lines, own .and. others), trial_steps, found)
      lines = [pack(model%lines, .not. own), found%lines]
    else
      lines = pack(lines, others)
    end if
  end function lines_without

end module bw_line_search
