module bw_close_pair
  !! Lines that are no single steady mode: where a line leaves more than noise of its peak, a drift of the line and a second line
  !! beside it are both fitted, and the likelier is taken if it pays for its unknowns.
  !!
  !! What either could take is nearly what amplitudes that change with powers of time take, which is linear: only where that
  !! pays are drifts of rising powers, and pairs of several distances, fitted.
  use bw_band_fit, only: excess, fit_band, fit_type, reduce, reduced_type
  use bw_damped_line, only: bend_reach, cancels, damped_line, most_powers
  use bw_drift, only: drift_of, drift_type
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band, own_rows, weight_of
  use bw_monitor, only: monitor_type, stops
  use bw_ordinates, only: ordinates_type
  use bw_samples, only: centre_of, samples_type, span_of
  use bw_shape_price, only: least_gain, price_of_drift
  implicit none (type, external)
  private
  public :: split_lines

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: highest_power = 4
  real(dp), parameter :: widest_apart = 1.5_dp  !! bins of a member from the single line
  real(dp), parameter :: broadest = 12          !! over the record, of a member's decay from the single line's
  real(dp), parameter :: below(5) = [0.12_dp, 0.25_dp, 0.5_dp, 0.0_dp, 0.7_dp]
  real(dp), parameter :: above(5) = [0.12_dp, 0.25_dp, 0.5_dp, 0.7_dp, 0.0_dp]
    !! bins, or widths of a line that is wider, to two lines on either side of it, to start from
  real(dp), parameter :: leaking = 0.1_dp       !! of the strongest that is left anywhere
  integer, parameter :: most_idle = 2           !! powers of time, one after the other, that a drift gains nothing by
  real(dp), parameter :: slowest = 0.9999_dp    !! of what is left: a step of a trial that leaves more is its last
  real(dp), parameter :: hasty = 0.99_dp        !! the same where lines leave far more than noise
  real(dp), parameter :: again = 0.5_dp         !! of what had to be gained when a shape was refused; then it is tried again
  real(dp), parameter :: promise = 0.3_dp       !! of what a fit gains, that it shows to first order
  real(dp), parameter :: from_still = 2         !! bins; a drift nearer to 0 is not told from an offset and a slope
  integer, parameter :: most_together = 4       !! lines of a band among which drifts and pairs are looked for
  real(dp), parameter :: credit = 12            !! of the weighted squares, for what a line looks like at first sight; from trials
  real(dp), parameter :: most_drift = 15        !! of −decay and 2π·frequency over half the record; one bin is π
  real(dp), parameter :: near_single = 3        !! bins from a place that is one line
  real(dp), parameter :: turns(3) = [0.0_dp, 2.0_dp, -2.0_dp]  !! radians at both ends, of drifts to start from

contains

  subroutine split_lines(samples, false_alarm, ordinates, bands, lines, still, highest, single, changed, &
    & monitor, work)
    !! Try every line as one that drifts and as two; the best of each band is kept, but where it gains so much less than is
    !! left elsewhere that it may be fitted to what leaks from there.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(ordinates_type), intent(in) :: ordinates  !! what the lines leave
    type(line_band), intent(inout) :: bands(:)
    type(damped_line), allocatable, intent(inout) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    real(dp), intent(in) :: highest                !! sample, as the length of a vector of all sensors
    real(dp), intent(in) :: single(:)              !! frequencies in whose peaks further lines were refused as a drift
    logical, intent(out) :: changed
    class(monitor_type), intent(inout), optional :: monitor
    real(dp), intent(inout), optional :: work      !! numbers of lines' images that are computed, added up
    type :: shape_type
      type(damped_line), allocatable :: lines(:)  !! of a band; a further one is the last
    end type shape_type
    type(shape_type) :: best(size(bands))
    type(damped_line), allocatable :: after(:)
    real(dp) :: pays(size(bands)), least, quiet(size(bands)), spent
    integer :: i, n
    pays = 0
    changed = .false.
    quiet = huge(1.0_dp)
    least = leaking*2*maxval(ordinates%total)
    do i = 1, size(bands)
      if (size(bands(i)%member) == 0) cycle
      if (stops(monitor)) return
      quiet(i) = max(least, -2*log(false_alarm/size(lines)))/ &
        & maxval(weight_of(ordinates%noise, bands(i), size(samples%value, 2)))
      if (quiet(i) > again*bands(i)%refused) cycle
      best(i)%lines = lines(bands(i)%member)
      call shape_band(samples, bands(i), own_rows(samples, lines, still, bands(i)), &
        & weight_of(ordinates%noise, bands(i), size(samples%value, 2)), false_alarm/size(lines), &
        & highest, single, best(i)%lines, pays(i), least, spent)
      if (present(work)) work = work + spent
    end do
    where (pays <= 0) bands%refused = min(bands%refused, quiet)
    least = max(least, leaking*maxval(pays))
    changed = any(pays > least)
    if (.not. changed) return
    after = lines
    do i = 1, size(bands)
      if (pays(i) <= least) cycle
      n = size(bands(i)%member)
      after(bands(i)%member) = best(i)%lines(:n)
      after = [after, best(i)%lines(n + 1:)]
    end do
    call move_alloc(after, lines)
  end subroutine split_lines

  subroutine shape_band(samples, band, rows, weight, chance, highest, single, own, pays_best, least, &
    & spent)
    !! Keep what pays best for one of the band's lines.
    type(samples_type), intent(in) :: samples
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: rows(:, :), weight(:)
    real(dp), intent(in) :: chance              !! of a drift or a second line where there is none
    real(dp), intent(in) :: highest             !! sample
    real(dp), intent(in) :: single(:)           !! frequencies near which no line is taken for two
    type(damped_line), allocatable, intent(inout) :: own(:)  !! the lines of the band; a further one is the last
    real(dp), intent(out) :: pays_best          !! what it takes off the weighted squares beyond its price; 0: nothing pays
    real(dp), intent(in) :: least               !! what it must take off them to be looked at
    real(dp), intent(out) :: spent              !! numbers of lines' images that are computed
    type(fit_type) :: fit, best
    real(dp) :: left, pays
    real(dp) :: pace                            !! of what is left, as `slowest`
    logical :: bulges                           !! the line drifts as a pair of equal lines does, cos δu ≈ e^(−δ²u²/2)
    integer :: j
    fit%lines = own
    call fit_band(samples, band%band, rows, weight, band%with_still, fit)
    left = fit%left
    spent = fit%work
    pace = merge(hasty, slowest, excess(left, rows) > 1)
    pays_best = 0
    do j = 1, size(own)
      call try_drifts()
      call try_pairs()
    end do
    if (pays_best > 0) own = best%lines

  contains

    subroutine try_drifts()
      !! One power of time after the other in the exponent of line j, where two of them gain their price; of a line by itself
      !! also where two lines instead would pay theirs, lest these be taken for want of anything simpler.
      type(fit_type) :: start
      type(drift_type) :: drift
      real(dp) :: before, price
      integer :: powers, k, idle
      bulges = .false.
      idle = 0
      powers = min(own(j)%powers + 2, most_powers)
      if (powers == own(j)%powers .or. own(j)%frequency*span_of(samples) < from_still .or. size(own) > most_together) return
      drift = drift_of(samples, band, rows, weight, own, j, powers)
      price = price_of_drift(powers, chance) - price_of_drift(own(j)%powers, chance)
      if (size(own) == 1) price = min(price, least_gain(size(weight), chance))
      if (drift%gain < max(least*promise, price)) return
      start%lines = [own(:j - 1), own(j + 1:), own(j)]
      do powers = own(j)%powers + 1, most_powers
        start%lines(size(own))%powers = powers
        before = merge(left, fit%left, powers == own(j)%powers + 1)
        fit%left = huge(1.0_dp)
        do k = 1, size(turns)
          if (k > 1 .and. powers > 2) exit
          call try(start, turns(k))
        end do
        start%lines = fit%lines
        idle = merge(0, idle + 1, before - fit%left > -2*log(chance))
        if (idle == most_idle) return
        if (wild(samples, fit%lines(size(own)))) return
        if (powers == 2) bulges = fit%lines(size(own))%bend(2)%re < -abs(fit%lines(size(own))%bend(2)%im)
        pays = left - fit%left + price_of_drift(own(j)%powers, chance) - price_of_drift(powers, chance)
        if (bulges) then
          call keep(0.0_dp)
        else
          call keep(credit)
        end if
      end do
    end subroutine try_drifts

    subroutine try(start, turn)
      !! A fit that starts from another drift.
      type(fit_type), intent(in) :: start
      real(dp), intent(in) :: turn
      type(fit_type) :: other
      other = start
      other%work = 0
      other%slowest = pace
      associate (line => other%lines(size(own)))
        line%bend(2) = line%bend(2) + cmplx(0, turn, dp)
      end associate
      call fit_band(samples, band%band, rows, weight, band%with_still, other)
      spent = spent + other%work
      if (other%left < fit%left) fit = other
    end subroutine try

    subroutine try_pairs()
      !! Two steady lines for line j.
      integer :: k
      if (size(own) > most_together .or. any(abs(single - own(j)%frequency)*span_of(samples) < near_single)) return
      if (bent_gain(samples, band, rows, weight, own, j) < max(least*promise, least_gain(size(weight), chance))) return
      do k = 1, size(below)
        fit%lines = [own(:j - 1), own(j + 1:), pair_at(own(j), [-below(k), above(k)], span_of(samples))]
        fit%slowest = pace
        fit%work = 0
        call fit_band(samples, band%band, rows, weight, band%with_still, fit)
        spent = spent + fit%work
        if (.not. beside_in_bins(own(j), fit%lines(size(own):), span_of(samples))) cycle
        pays = left - fit%left + price_of_drift(own(j)%powers, chance) - least_gain(size(weight), chance)
        if (bulges) then
          call keep(credit)
        else
          call keep(0.0_dp)
        end if
      end do
    end subroutine try_pairs

    subroutine keep(credit)
      !! Take the fit if it pays, and better than the best for now.
      real(dp), intent(in) :: credit
      if (pays <= 0 .or. pays + credit <= pays_best) return
      if (any(cancels(fit%lines, highest))) return
      pays_best = pays + credit
      best = fit
    end subroutine keep

  end subroutine shape_band

  pure logical function wild(samples, line)
    !! Whether a fit has taken a line for so large a drift that it may describe anything.
    type(samples_type), intent(in) :: samples
    type(damped_line), intent(in) :: line
    wild = abs(bend_reach(line, centre_of(samples))) > most_drift
  end function wild

  logical function beside_in_bins(line, pair, span) result(near)
    !! Whether both lines are within the peak of the one, neither much broader: what is further away has a peak of its own. Two that
    !! are less apart in frequency than in decay are one whose decay changes.
    type(damped_line), intent(in) :: line, pair(:)
    real(dp), intent(in) :: span
    near = all(abs(pair%frequency - line%frequency)*span < widest_apart + abs(line%decay)*span/pi) .and. &
      & all(abs(pair%decay - line%decay)*span < broadest + 2*abs(line%decay)*span) .and. &
      & abs(pair(1)%decay - pair(2)%decay) < 2*pi*abs(pair(1)%frequency - pair(2)%frequency)
  end function beside_in_bins

  pure function pair_at(line, away, span) result(pair)
    !! Two steady lines beside one. Where its peak is wider than a bin so is their distance, and each is narrower than the peak.
    type(damped_line), intent(in) :: line
    real(dp), intent(in) :: away(2)             !! bins, or half widths of the peak at half its power
    real(dp), intent(in) :: span
    type(damped_line) :: pair(2)
    real(dp) :: width
    width = abs(line%decay)/(2*pi)              ! periods per step
    pair = line
    if (width*span > 1) pair%decay = line%decay/2
    pair%frequency = abs(line%frequency + away*max(width, 1/span))
    pair%sought = line%frequency                ! the peak that was taken for the line may be one of noise on a broad peak
    pair%powers = 1
    pair(1)%bend = 0
    pair(2)%bend = 0
  end function pair_at

  real(dp) function bent_gain(samples, band, rows, weight, lines, j) result(gain)
    !! What the weighted squares lose where the amplitudes of line j may change with the second to fourth power of time, which is
    !! nearly all that a second line in its peak could take.
    type(samples_type), intent(in) :: samples
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: rows(:, :), weight(:)
    type(damped_line), intent(in) :: lines(:)
    integer, intent(in) :: j
    type(reduced_type) :: reduced
    reduced = reduce(samples, band%band, rows, [lines(:j - 1), lines(j + 1:), lines(j)], band%with_still, &
      & [lines(:j - 1)%powers, lines(j + 1:)%powers, max(lines(j)%powers, highest_power)])
    associate (first => reduced%linear + reduced%first(size(lines)) + 2)
      gain = sum(weight*sum(reduced%rotated(first:, :)**2, dim=1))
    end associate
  end function bent_gain

end module bw_close_pair
