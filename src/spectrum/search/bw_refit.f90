module bw_refit
  !! Refits of some lines of a model, with the others fixed; a refit is accepted if it lowers the cost of the whole record.
  use bw_band, only: add_to_band, band_around, fill_rows
  use bw_band_columns, only: band_type
  use bw_band_fit, only: amplitudes_of, converged, fit_band, reduced_type, squares_left
  use bw_constants, only: pi
  use bw_exchange, only: exchange_lines
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_model, only: has_gaps, model_type, rows_of_stretches, steps_between, white_lines
  use bw_noise, only: amplitude_of
  implicit none (type, external)
  private
  public :: accept, all_steps, cluster_of, follow_lines, is_broken, near, negligible_gain, overlaps, refit, refit_all, &
    & slow_in, span_of_model, trial_steps

  real(dp), parameter :: unlike = 1/37.0_dp      !! tuned: squared scalar product of two lines that are not fitted together
  real(dp), parameter :: broken = 0.05_dp        !! tuned: fraction of two lines' scalar product
  integer, parameter :: most_sweeps = 6
  integer, parameter, public :: most_together = 8        !! tuned: lines of a chain fitted at once; of a longer one each with its neighbours
  integer, parameter :: trial_steps = 5, all_steps = 10   !! of a trial fit, and of a final one
  real(dp), parameter :: negligible_gain = 1      !! fall of −2 ln L that is expected of another fit, below which lines rest
  real(dp), parameter :: low = 24                !! periods in the shortest stretch; slower lines are fitted with a trend

  type, public :: refit_type
    !! Lines that replace others.
    logical, allocatable :: old(:)               !! the lines of the model that they replace
    type(line_type), allocatable :: lines(:)
    type(reduced_type), allocatable :: reduced(:)
    logical :: with_trend = .false.              !! offset and slope of the stretches were fitted with them
    real(dp) :: gain = 0                         !! decrease of the squares in the band
  end type refit_type

contains

  pure real(dp) function span_of_model(model)
    !! The length of the longest stretch, in steps.
    type(model_type), intent(in) :: model
    integer :: b
    span_of_model = maxval([(steps_between(model, model%stretches(1, b), model%stretches(2, b)), b=0, ubound(model%stretches, 2))])
  end function span_of_model

  pure real(dp) function shortest_span(model) result(span)
    !! The length of the shortest stretch that has lines, in steps: there they overlap most.
    type(model_type), intent(in) :: model
    integer :: b
    span = span_of_model(model)
    do b = merge(0, 1, any(model%lines%steady)), ubound(model%stretches, 2)
      associate (own_span => steps_between(model, model%stretches(1, b), model%stretches(2, b)))
        if (own_span > 1) span = min(span, own_span)
      end associate
    end do
  end function shortest_span

  pure real(dp) function slow_in(model)
    !! The frequency below which lines are fitted with a trend, rad per step.
    type(model_type), intent(in) :: model
    slow_in = 2*pi*low/shortest_span(model)
  end function slow_in

  elemental logical function overlaps(pole, other, span)
    !! Whether two lines are fitted together: if they are equally damped, within 6 times the sum of their decay rates, and within
    !! 12/T if they are undamped.
    complex(dp), intent(in) :: pole, other
    real(dp), intent(in) :: span                 !! samples
    overlaps = likeness(pole, other, span) > unlike
  end function overlaps

  elemental real(dp) function likeness(pole, other, span)
    !! The squared scalar product of two lines of norm 1. A finite record widens lines: it counts as a decay rate of 2π/T.
    complex(dp), intent(in) :: pole, other
    real(dp), intent(in) :: span                 !! samples
    real(dp) :: rate(2)
    rate = abs([real(pole, dp), real(other, dp)]) + 2*pi/span
    likeness = 4*product(rate)/(sum(rate)**2 + (pole%im - other%im)**2)
  end function likeness

  pure function near(model, pole, span) result(are)
    !! The lines that overlap with one at a pole; tones also with tones before the first blow.
    type(model_type), intent(in) :: model
    complex(dp), intent(in) :: pole
    real(dp), intent(in), optional :: span       !! of the stretch, in steps; the longest one if absent
    logical :: are(size(model%lines))
    integer :: k
    if (present(span)) then
      are = overlaps(model%lines%pole, pole, span)
    else
      are = overlaps(model%lines%pole, pole, span_of_model(model))
    end if
    associate (before => steps_between(model, model%stretches(1, 0), model%stretches(2, 0)))
      if (before > 1 .and. any(model%lines%steady .and. abs(model%lines%pole - pole) <= 0)) &
        & are = are .or. (model%lines%steady .and. overlaps(model%lines%pole, pole, max(1.0_dp, before)))
    end associate
    are = are .or. [(is_broken(model, model%lines(k)%pole%re, real(pole, dp)), k=1, size(are))]
  end function near

  pure function nearest_lines(model, pole, span) result(are)
    !! The lines that overlap most with one at a pole.
    type(model_type), intent(in) :: model
    complex(dp), intent(in) :: pole
    real(dp), intent(in) :: span
    logical :: are(size(model%lines))
    real(dp) :: alike(size(model%lines))
    integer :: k
    alike = likeness(model%lines%pole, pole, span)
    are = near(model, pole, span) .and. [(count(alike > alike(k)) < most_together, k=1, size(are))]
  end function nearest_lines

  pure logical function is_broken(model, rate, other)
    !! Whether so much of two lines' lives is missing that one appears at the frequency of the other, as with clipped crests. Since
    !! their scalar product over all samples is about 0, that over the valid ones is minus that over the gaps.
    type(model_type), intent(in) :: model
    real(dp), intent(in) :: rate, other          !! real parts of their poles
    real(dp) :: life(2), both(2)
    integer :: b, s, lost
    is_broken = .false.
    if (.not. has_gaps(model)) return
    lost = 0
    both = 0
    do b = 1, ubound(model%stretches, 2)
      life = 1/max(-[rate, other], 1.0_dp/max(1, model%stretches(2, b) - model%stretches(1, b) + 1))
      both = both + life
      do s = 1, size(model%missing)
        associate (since => model%missing(s)%place - model%stretches(1, b))
          lost = lost + count(since >= 0 .and. since < minval(life))
        end associate
      end do
    end do
    is_broken = lost > broken*size(model%missing)*sqrt(product(both))
  end function is_broken

  subroutine refit(model, old, start, most_steps, found, window, least)
    !! Fit lines that replace some of the model's, from initial values. The model does not change.
    type(model_type), intent(in) :: model
    logical, intent(in) :: old(:)                !! lines that are replaced
    type(line_type), intent(in) :: start(:)
    integer, intent(in) :: most_steps
    type(refit_type), intent(out) :: found
    integer, intent(in), optional :: window      !! samples after each blow in use; all if absent
    real(dp), intent(in), optional :: least      !! the fit ends at once if its first step predicts a smaller gain
    type(line_type), allocatable :: white(:)
    type(band_type) :: band
    real(dp) :: before
    integer :: p, k, rows(2, 0:ubound(model%stretches, 2)), stretches
    rows = rows_of_stretches(model)
    if (present(window)) rows(2, :) = min(rows(2, :), rows(1, :) + window - 1)
    stretches = ubound(rows, 2) + 1
    found%old = old
    found%lines = start
    white = white_lines(model, pack(model%lines, old))
    band = band_around([white, start], rows, model%noise, model%missing, model%place)
    call fill_rows(model%white, band)
    before = sum([(sum(band%part(p)%rows**2), p=1, size(band%part))])
    call add_to_band(white, band)
    found%with_trend = minval(start%pole%im) < slow_in(model)
    call fit_band(band, found%with_trend, most_steps, found%lines, found%reduced, least=least)
    found%gain = before - squares_left(found%reduced)
    do k = 1, size(start)
      found%lines(k)%amplitude = amplitude_of(model%noise, found%lines(k)%pole, &
        & amplitudes_of(found%reduced, k, stretches, size(model%white, 2)))
      associate (line => found%lines(k), step => steps_between(model, model%stretches(1, 0), model%stretches(1, 1)) - 1)
        if (line%steady .and. all(band%part%stretch > 0)) line%amplitude(:, 1) = line%amplitude(:, 2)*exp(-line%pole*step)
      end associate
    end do
  end subroutine refit

  subroutine accept(found, need, model, gain)
    !! Replace lines by fitted ones if the squares of the whole record fall by more than `need`; otherwise gain is 0.
    type(refit_type), intent(in) :: found
    real(dp), intent(in) :: need
    type(model_type), intent(inout) :: model
    real(dp), intent(out) :: gain
    type(line_type), allocatable :: old(:)
    real(dp) :: back
    old = pack(model%lines, found%old)
    call exchange_lines(model, old, found%lines, found%with_trend, gain)
    if (gain > need) then
      model%lines = [pack(model%lines, .not. found%old), found%lines]
      if (.not. abs(gain) > 0) gain = tiny(gain)   ! accepted nevertheless
    else
      call exchange_lines(model, found%lines, old, found%with_trend, back)
      gain = 0
    end if
  end subroutine accept

  subroutine refit_all(most_steps, rest, model)
    !! Refit all lines, overlapping ones together, until no refit is expected to lower the squares by more than `rest`. Gauss–Newton
    !! steps gain less and less, and what one fit gains can fall again in others by the square of their scalar product.
    integer, intent(in) :: most_steps
    real(dp), intent(in) :: rest
    type(model_type), intent(inout) :: model
    real(dp) :: due(size(model%lines))           !! expected fall of the squares if a line is fitted again
    logical :: done(size(model%lines)), own(size(model%lines))
    type(refit_type) :: found
    real(dp) :: gain, span
    integer :: sweep, first, k
    span = shortest_span(model)
    due = huge(1.0_dp)
    do sweep = 1, most_sweeps
      done = .not. due > rest
      do while (.not. all(done))
        first = findloc(done, .false., dim=1)
        own = cluster_of(model, first, span)
        if (count(own) > most_together) own = nearest_lines(model, model%lines(first)%pole, span)
        call refit(model, own, pack(model%lines, own), most_steps, found)
        gain = 0
        if (found%gain > converged) call accept(found, 0.0_dp, model, gain)
        if (gain > 0) then
          done = [pack(done, .not. own), pack(done, own)]
          due = [pack(due, .not. own), pack(due, own)]
          own = [pack(own, .not. own), pack(own, own)]
          do k = 1, size(own)
            due(k) = due(k) + gain*maxval(likeness(model%lines(k)%pole, model%lines%pole, span), mask=own)
          end do
        end if
        done = done .or. own
        where (own) due = gain
      end do
      if (.not. any(due > rest)) exit
    end do
  end subroutine refit_all

  subroutine follow_lines(window, model)
    !! Refit all lines in twice as many samples after each blow, and so on to the end of the record: where they are known from a
    !! window of samples, their phase is known in the next. The model has to be renewed.
    integer, intent(in) :: window
    type(model_type), intent(inout) :: model
    type(line_type) :: lines(size(model%lines))
    logical :: done(size(lines)), own(size(lines))
    type(refit_type) :: found
    integer :: first, longer, k
    lines = model%lines
    done = .false.
    do while (.not. all(done))
      first = findloc(done, .false., dim=1)
      own = cluster_of(model, first)
      if (count(own) > most_together) own = nearest_lines(model, model%lines(first)%pole, span_of_model(model))
      found%lines = pack(lines, own)
      longer = window
      do while (longer < span_of_model(model))
        longer = 2*longer
        call refit(model, own, [found%lines], trial_steps, found, longer)
      end do
      do k = 1, size(own)
        if (own(k)) lines(k) = found%lines(count(own(:k)))
      end do
      done = done .or. own
    end do
    model%lines = lines
  end subroutine follow_lines

  pure function cluster_of(model, first, span) result(own)
    !! All lines that overlap with one, directly or through others.
    type(model_type), intent(in) :: model
    integer, intent(in) :: first
    real(dp), intent(in), optional :: span       !! as in `near`
    logical :: own(size(model%lines))
    integer :: k, before
    own = .false.
    own(first) = .true.
    do
      before = count(own)
      do k = 1, size(own)
        if (own(k)) own = own .or. near(model, model%lines(k)%pole, span)
      end do
      if (count(own) == before) exit
    end do
  end function cluster_of

end module bw_refit
