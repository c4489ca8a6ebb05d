module bw_close_pair
  !! Lines that turn out to be two: a second line in a peak is taken where the likelihood pays for it, and where a drift of
  !! the single line would not do as well.
  !!
  !! What a second line within a bin could take is nearly what amplitudes that change with powers of time take, which is
  !! linear: only where that pays are pairs of several distances fitted.
  use bw_band_fit, only: damped_line, fit_band, fit_type, reduce, reduced_type
  use bw_drift, only: drift_gain
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band, own_rows
  use bw_noise_level, only: level_at, level_knots
  use bw_samples, only: samples_type, span_of
  implicit none (type, external)
  private
  public :: join_lines, split_lines

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: places = 8             !! independent places of a second line in a peak; from trials on noise
  integer, parameter :: highest_power = 4
  real(dp), parameter :: widest_apart = 1.5_dp  !! bins of a member from the single line
  real(dp), parameter :: broadest = 12          !! over the record, of a member's decay from the single line's
  real(dp), parameter :: below(5) = [0.12_dp, 0.25_dp, 0.5_dp, 0.0_dp, 0.7_dp]
  real(dp), parameter :: above(5) = [0.12_dp, 0.25_dp, 0.5_dp, 0.7_dp, 0.0_dp]
    !! bins from a line to two lines on either side of it, to start from

contains

  subroutine split_lines(samples, false_alarm, noise, bands, lines, still, changed)
    !! Try every line as two; the best of each band is kept.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(level_knots), intent(in) :: noise
    type(line_band), intent(in) :: bands(:)
    type(damped_line), allocatable, intent(inout) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    logical, intent(out) :: changed
    type(damped_line), allocatable :: after(:)
    integer :: i
    changed = .false.
    after = lines
    do i = 1, size(bands)
      if (size(bands(i)%member) > 0) call split_band(bands(i), least_gain(size(samples%value, 2), false_alarm/size(lines)))
    end do
    if (changed) call move_alloc(after, lines)

  contains

    subroutine split_band(band, least)
      !! Keep the best split of one of the band's lines.
      type(line_band), intent(in) :: band
      real(dp), intent(in) :: least
      type(fit_type) :: fit, best
      real(dp), allocatable :: rows(:, :), weight(:)
      real(dp) :: left
      type(damped_line), allocatable :: own(:)
      integer :: j, k, chosen
      rows = own_rows(samples, lines, still, band)
      weight = 1/level_at(noise, band%band%centre, size(samples%value, 2))
      own = lines(band%member)
      fit%lines = own
      call fit_band(samples, band%band, rows, weight, band%with_still, fit)
      left = fit%left
      best = fit
      chosen = 0
      do j = 1, size(own)
        if (bent_gain(samples, band, rows, weight, own, j) < least) cycle
        do k = 1, size(below)
          fit%lines = [own(:j - 1), own(j + 1:), pair_at(own(j), [-below(k), above(k)]/span_of(samples))]
          call fit_band(samples, band%band, rows, weight, band%with_still, fit)
          if (fit%left >= best%left) cycle
          if (left - fit%left < least) cycle
          if (.not. beside_in_bins(own(j), fit%lines(size(own):), span_of(samples))) cycle
          if (left - fit%left < least + drift_gain(samples, band, rows, weight, own, j)) cycle
          best = fit
          chosen = j
        end do
      end do
      if (chosen == 0) return
      changed = .true.
      after(band%member(:chosen - 1)) = best%lines(:chosen - 1)
      after(band%member(chosen + 1:)) = best%lines(chosen:size(own) - 1)
      after(band%member(chosen)) = best%lines(size(own))
      after = [after, best%lines(size(own) + 1)]
    end subroutine split_band

  end subroutine split_lines

  logical function beside_in_bins(line, pair, span) result(near)
    !! Whether both lines are within the peak of the one, neither much broader: what is further away has a peak of its own.
    type(damped_line), intent(in) :: line, pair(:)
    real(dp), intent(in) :: span
    near = all(abs(pair%frequency - line%frequency)*span < widest_apart + abs(line%decay)*span/pi) .and. &
      & all(abs(pair%decay - line%decay)*span < broadest + 2*abs(line%decay)*span)
  end function beside_in_bins

  subroutine join_lines(samples, false_alarm, noise, bands, lines, still, changed)
    !! Leave a line out of each peak that has several, where the others, fitted again, do as well but for noise.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(level_knots), intent(in) :: noise
    type(line_band), intent(in) :: bands(:)
    type(damped_line), allocatable, intent(inout) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    logical, intent(out) :: changed
    logical :: stays(size(lines))
    integer :: i
    stays = .true.
    do i = 1, size(bands)
      if (size(bands(i)%member) > 1) call join_band(bands(i), least_gain(size(samples%value, 2), false_alarm/size(lines)))
    end do
    changed = .not. all(stays)
    if (changed) lines = pack(lines, stays)

  contains

    subroutine join_band(band, least)
      !! Leave out the line that is missed least.
      type(line_band), intent(in) :: band
      real(dp), intent(in) :: least
      type(fit_type) :: fit
      real(dp), allocatable :: rows(:, :), weight(:)
      type(damped_line), allocatable :: own(:), best(:)
      real(dp) :: left, least_left
      integer :: j, chosen
      own = lines(band%member)
      rows = own_rows(samples, lines, still, band)
      weight = 1/level_at(noise, band%band%centre, size(samples%value, 2))
      fit%lines = own
      call fit_band(samples, band%band, rows, weight, band%with_still, fit)
      left = fit%left
      least_left = left + least
      chosen = 0
      do j = 1, size(own)
        if (count(abs(own%frequency - own(j)%frequency)*span_of(samples) < 2*widest_apart) < 2) cycle
        fit%lines = [own(:j - 1), own(j + 1:)]
        call fit_band(samples, band%band, rows, weight, band%with_still, fit)
        if (fit%left >= least_left) cycle
        least_left = fit%left
        chosen = j
        best = fit%lines
      end do
      if (chosen == 0) return
      stays(band%member(chosen)) = .false.
      lines(band%member(:chosen - 1)) = best(:chosen - 1)
      lines(band%member(chosen + 1:)) = best(chosen:)
    end subroutine join_band

  end subroutine join_lines

  pure function pair_at(line, away) result(pair)
    !! Two lines beside one.
    type(damped_line), intent(in) :: line
    real(dp), intent(in) :: away(2)             !! periods per step
    type(damped_line) :: pair(2)
    pair = line
    pair%frequency = abs(line%frequency + away)
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
    integer :: n
    n = size(lines)
    reduced = reduce(samples, band%band, rows, lines, band%with_still, highest_power, j)
    gain = sum(weight*sum(reduced%rotated(reduced%linear + 2*n + 1:, :)**2, dim=1))
  end function bent_gain

  pure real(dp) function least_gain(sensors, false_alarm) result(gain)
    !! What a second line must take off the weighted squares: noise gives more with that probability. Decay, frequency and an
    !! amplitude at each sensor are 2 + 2S normal numbers, at about `places` places.
    integer, intent(in) :: sensors
    real(dp), intent(in) :: false_alarm
    real(dp) :: low, high, term, tail
    integer :: i, j
    low = 0
    high = 2000.0_dp + 20*sensors
    do i = 1, 60
      gain = (low + high)/2
      term = exp(-gain/2)
      tail = term
      do j = 1, sensors
        term = term*gain/(2*j)
        tail = tail + term
      end do
      if (tail*places > false_alarm) then
        low = gain
      else
        high = gain
      end if
    end do
  end function least_gain

end module bw_close_pair
