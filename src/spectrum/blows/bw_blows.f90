module bw_blows
  !! Detection of blows: a decay is predictable from its own past, its beginning is not.
  !!
  !! The errors of a long linear prediction of the record, with zeros before the first sample, are noise during a decay, and contain
  !! the motion at a blow. A record that was cut within a decay has its first burst at its first sample.
  use bw_autoregression, only: autoregression, burg, samples_per_order
  use bw_kinds, only: dp
  use bw_order, only: ascending, quantile_of
  use bw_penalty, only: chi_median, chi_squared
  use bw_samples, only: runs_of, samples_type, span_of, validity
  implicit none (type, external)
  private
  public :: find_blows

  integer, parameter :: order = 64               !! tuned: order of the prediction, more than two for each mode
  integer, parameter, public :: enough = 2**22   !! numbers that are enough to locate blows
  real(dp), parameter :: clearly = 4             !! tuned: times the level that noise reaches
  integer, parameter :: fewest = 640             !! fewest sums in which bursts are searched for
  integer, parameter :: first = 4                !! samples that give a sensor's value at rest
  integer, parameter :: interpolations = 8       !! iterations for missing samples

contains

  subroutine find_blows(samples, false_alarm, blows)
    !! Find the sample of each burst of prediction errors, 1 if there is none. The record is searched in sums over 1, 2, 4, …
    !! samples, since a slow motion begins too gradually to be seen from one sample to the next. Uneven samples are interpolated at
    !! even times, which is rough: only the first burst is a blow.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    integer, allocatable, intent(out) :: blows(:)
    real(dp), allocatable :: x(:, :)
    logical, allocatable :: valid(:, :), is_limited(:, :)
    integer :: s, n, scale, sensors, stride, first_valid
    n = ceiling(span_of(samples))
    stride = max(1, ceiling(real(n, dp)*size(samples%value, 2)/enough))
    sensors = (size(samples%value, 2) - 1)/stride + 1
    allocate (x(n, sensors), valid(n, sensors), is_limited(n, sensors))
    do s = 1, sensors
      call find_even_values(samples, 1 + (s - 1)*stride, x(:, s), valid(:, s), is_limited(:, s))
    end do
    first_valid = max(1, findloc(any(valid, dim=2), .true., dim=1))
    allocate (blows(0))
    scale = 1
    do
      call add_bursts(x, valid, is_limited, scale, false_alarm, blows)
      n = size(x, 1)/2
      if (n < fewest) exit
      x = x(1:2*n:2, :) + x(2:2*n:2, :)
      valid = valid(1:2*n:2, :) .and. valid(2:2*n:2, :)
      is_limited = is_limited(1:2*n:2, :) .or. is_limited(2:2*n:2, :)
      scale = 2*scale
    end do
    blows = blows(ascending(real(blows, dp)))
    if (size(blows) == 0) blows = [first_valid]
    blows = [max(first_valid, blows(1)), pack(blows(2:), blows(2:) > first_valid)]
    if (.not. allocated(samples%place)) return
    if (blows(1) <= order) blows(1) = 1          ! so close to the first sample there is no prediction
    blows = [1 + count(samples%place < blows(1) - 1)]
  end subroutine find_blows

  pure subroutine find_even_values(samples, s, x, valid, is_limited)
    !! Find the values of a sensor, one per step, and those beyond its range; uneven ones are interpolated.
    type(samples_type), intent(in) :: samples
    integer, intent(in) :: s
    real(dp), intent(out) :: x(:)
    logical, intent(out) :: valid(:), is_limited(:)
    logical, dimension(samples%count) :: is_valid, beyond
    real(dp), allocatable :: place(:), value(:)
    integer :: n, k
    associate (own => samples%value(:samples%count, s))
      is_valid = validity(samples, s)
      beyond = .not. is_valid .and. (own < minval(own, is_valid) .or. own > maxval(own, is_valid))
      if (.not. allocated(samples%place)) then
        x = own
        valid = is_valid
        is_limited = beyond
        return
      end if
      place = pack(samples%place, is_valid .or. beyond)
      value = pack(own, is_valid .or. beyond)
    end associate
    valid = .true.
    is_limited = .false.
    k = 1
    do n = 1, size(x)
      do while (k < size(place) - 1 .and. place(k + 1) < n - 1)
        k = k + 1
      end do
      associate (t => place(k:k + 1), y => value(k:k + 1))
        x(n) = y(1) + (y(2) - y(1))*max(0.0_dp, min(1.0_dp, (n - 1 - t(1))/(t(2) - t(1))))
      end associate
    end do
  end subroutine find_even_values

  subroutine add_bursts(x, valid, is_limited, scale, false_alarm, blows)
    !! Add new bursts in sums over `scale` samples. One missing sample is interpolated to within the noise. Several adjacent ones,
    !! or clipped crests, are not: errors are invalid until they are past. But the first sample of a crest was no smaller than the
    !! recorded one.
    real(dp), intent(inout) :: x(:, :)           !! invalid ones are interpolated
    logical, intent(inout) :: valid(:, :)        !! single missing samples become valid
    logical, intent(in) :: is_limited(:, :)      !! beyond the range of a sensor
    integer, intent(in) :: scale
    real(dp), intent(in) :: false_alarm
    integer, allocatable, intent(inout) :: blows(:)
    type(autoregression) :: noise
    real(dp), dimension(size(x, 1)) :: burst, error, recording
    real(dp) :: least
    logical, dimension(size(x, 1)) :: is_usable, is_bound, is_single
    integer :: n, s, p, last, i, known
    n = size(x, 1)
    p = min(order, n/samples_per_order)
    burst = 0
    do s = 1, size(x, 2)
      associate (own => valid(:, s))
        is_usable = own
        is_single = .not. (own .or. is_limited(:, s)) .and. eoshift(own, -1, .true.) .and. eoshift(own, 1, .true.)
        do i = 1, n
          if (own(i)) cycle
          if (is_limited(i, s) .or. any(.not. own(max(1, i - 1):i - 1))) is_usable(i:min(n, i + p)) = .false.
        end do
        is_bound = is_limited(:, s) .and. scale == 1   ! sums contain interpolated ones
      end associate
      is_bound(2:) = is_bound(2:) .and. is_usable(:n - 1)
      if (count(is_usable) < 2) cycle
      recording = x(:, s) - sum(x(:first, s))/first
      call predict(valid(:, s), is_single, p, x(:, s), noise)
      call find_errors(x(:, s), noise%predictor, error)
      where (is_bound) error = merge(error + recording - x(:, s), 0.0_dp, (error + recording - x(:, s))*recording > 0)
      where (.not. (is_usable .or. is_bound)) error = 0
      error = error**2
      burst = burst + error/(quantile_of(pack(error, is_usable), 0.5_dp)/chi_median + tiny(1.0_dp))
      valid(:, s) = valid(:, s) .or. is_single
    end do
    least = clearly*chi_squared(false_alarm/n, 2*((size(x, 2) + 1)/2))
    last = -n
    known = size(blows)
    do i = 1, n - 2*p
      if (burst(i) < least) cycle
      if (i - last > p .and. all(abs(blows(:known) - scale*i) > 2*p*scale)) blows = [blows, 1 + scale*(i - 1)]
      last = i
    end do
  end subroutine add_bursts

  subroutine predict(valid, is_single, p, x, noise)
    !! Find a sensor's predictor, and interpolate missing samples by it; with single ones filled, longer runs determine it better.
    logical, intent(in) :: valid(:), is_single(:)
    integer, intent(in) :: p
    real(dp), intent(inout) :: x(:)
    type(autoregression), intent(out) :: noise
    real(dp) :: weight(p + 1)
    integer :: n, i, last, m, q, stage
    n = size(x)
    x = x - sum(x(:first))/first                 ! a record that begins before the blow begins at rest
    last = 0
    do i = 1, n                                  ! start with straight lines
      if (.not. valid(i)) cycle
      if (last > 0) x(last + 1:i - 1) = [(x(last) + (x(i) - x(last))*(m - last)/(i - last), m=last + 1, i - 1)]
      last = i
    end do
    do stage = 1, 2
      call burg(x, runs_of(valid .or. (is_single .and. stage > 1), 1, n), p, 0.0_dp, noise)
      if (all(valid)) return
      q = ubound(noise%predictor, 1)
      weight(:q + 1) = [(dot_product(noise%predictor(:q - m), noise%predictor(m:)), m=0, q)]
      do m = 1, interpolations
        do i = 1 + q, n - q
          if (.not. valid(i)) x(i) = -dot_product(weight(2:q + 1), x(i + 1:i + q) + x(i - 1:i - q:-1))/weight(1)
        end do
      end do
      if (.not. any(is_single)) return
    end do
  end subroutine predict

  pure subroutine find_errors(x, h, error)
    !! Find the prediction error of each sample from those before it.
    real(dp), intent(in) :: x(:), h(0:)
    real(dp), intent(out) :: error(:)
    integer :: i
    error = x
    do i = 1, ubound(h, 1)
      error(i + 1:) = error(i + 1:) + h(i)*x(:size(x) - i)
    end do
  end subroutine find_errors

end module bw_blows
