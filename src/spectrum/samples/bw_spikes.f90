module bw_spikes
  !! Spikes: samples that do not follow from those around them, although these follow from each other.
  !!
  !! In prediction errors e_n = Σ h_i x_(n+i) a spike a at sample m is a h_i in row m − i. Without it the squares fall by c²/E, where
  !! c = Σ h_i e_(m−i) and E = Σ h_i². It is a spike if this exceeds what noise reaches anywhere, if it stands out of the errors of the
  !! rows on either side, and if without it the errors are like those. At a blow no single sample explains the errors: the motion
  !! after it does not follow from rest.
  use bw_autoregression, only: autoregression, burg, samples_per_order
  use bw_kinds, only: dp
  use bw_missing_samples, only: missing_among, project_out_missing
  use bw_order, only: quantile_of
  use bw_penalty, only: chi_median, chi_squared
  use bw_samples, only: gaps_of, gaps_type, runs_of, samples_type, validity
  use bw_triangle, only: solved, triangulate
  implicit none (type, external)
  private
  public :: leave_out_spikes

  integer, parameter :: order = 32               !! tuned: of the prediction; more makes close spikes hide each other
  integer, parameter :: least_order = 8          !! of a prediction that follows a motion of a few modes
  real(dp), parameter :: products = 2.0e8_dp     !! of a sample with others, which take a fraction of a second
  integer, parameter :: most_together = 3        !! spikes within reach of the prediction
  integer, parameter :: rows_per_spike = 4       !! fewer could explain the beginning of a motion
  integer, parameter :: most_tried = 10000       !! samples that may be spikes, which take a fraction of a second
  integer, parameter :: rounds = 8               !! of predictions without the spikes found
  real(dp), parameter :: clearly = 4             !! times the largest squared error beside it
  real(dp), parameter :: alike = 2               !! times the mean squared error beside it
  real(dp), parameter :: most = 0.01_dp          !! of the samples; with more, they are the motion or its noise

contains

  subroutine leave_out_spikes(samples, false_alarm, spikes)
    !! Find the spikes of all sensors at even times, and mark them as missing.
    type(samples_type), intent(inout) :: samples
    real(dp), intent(in) :: false_alarm          !! probability that noise alone has one
    type(gaps_type), intent(out) :: spikes(:)    !! (S)
    logical :: valid(samples%count), found(samples%count)
    integer :: s, i, p
    do s = 1, size(spikes)
      allocate (spikes(s)%place(0))
    end do
    p = min(order, samples%count/samples_per_order, int(products/size(samples%value)))
    if (allocated(samples%place) .or. p < least_order) return
    do s = 1, size(spikes)
      if (allocated(samples%left_out)) then
        if (samples%left_out(s)) cycle
      end if
      valid = validity(samples, s)
      call find_spikes(samples%value(:samples%count, s), valid, p, false_alarm/samples%count, found)
      if (any(found) .and. count(found) <= most*count(valid)) spikes(s) = gaps_of(.not. found)
      associate (x => samples%value(:, s), place => spikes(s)%place)
        do i = 1, size(place)
          if (place(i) > 1) x(place(i)) = x(place(i) - 1)
        end do
      end associate
    end do
    if (all([(size(spikes(s)%place) == 0, s=1, size(spikes))])) return
    if (.not. allocated(samples%missing)) samples%missing = [(gaps_of(spread(.true., 1, samples%count)), s=1, size(spikes))]
    do s = 1, size(spikes)
      valid = validity(samples, s)
      valid(spikes(s)%place) = .false.
      samples%missing(s) = gaps_of(valid)
    end do
  end subroutine leave_out_spikes

  subroutine find_spikes(values, valid, p, chance, found)
    !! Find the spikes of one sensor, the largest first, with a prediction from the samples that were none so far.
    real(dp), intent(in) :: values(:)
    logical, intent(in) :: valid(:)
    integer, intent(in) :: p                     !! order
    real(dp), intent(in) :: chance
    logical, intent(out) :: found(:)
    type(autoregression) :: noise
    real(dp) :: x(size(values)), gain(size(values))
    real(dp), allocatable :: error(:)            ! (rows)
    logical, dimension(size(values)) :: is_known, before
    type(gaps_type) :: missing
    real(dp) :: level, need, bound
    integer :: round, m, tried
    missing = gaps_of(valid)
    found = .false.
    do round = 1, rounds
      before = found
      is_known = valid .and. .not. before
      if (count(is_known) < samples_per_order*p) exit
      x = merge(values - quantile_of(pack(values, is_known), 0.5_dp), 0.0_dp, valid)
      call burg(x, runs_of(is_known, 1, size(x)), p, log(real(size(x), dp)), noise)
      error = errors_of(x, noise%predictor)
      call project_out_missing(missing_among(missing%place, 1, size(error), noise%predictor), error)
      gain = gains_of(error, noise%predictor)
      level = quantile_of(error**2, 0.5_dp)/chi_median
      if (.not. level > 0) exit                  ! a coarse resolution
      need = level*colour_of(noise%predictor)*chi_squared(chance, 2)
      bound = maxval(gain, valid)
      found = .false.
      tried = 0
      do while (bound > need)                    ! the largest first
        do m = 1, size(x)
          if (.not. valid(m) .or. found(m) .or. gain(m) > bound .or. gain(m) <= max(need, bound/clearly)) cycle
          tried = tried + 1
          if (tried > most_tried) exit
          call try_spikes(noise%predictor, m, level, valid, error, found)
        end do
        bound = bound/clearly
      end do
      if (all(found .eqv. before)) exit
    end do
  end subroutine find_spikes

  subroutine try_spikes(h, m, level, valid, error, found)
    !! Take sample m, or it and a few within reach of the prediction, for spikes if the errors without them are like those around.
    real(dp), intent(in) :: h(0:)
    integer, intent(in) :: m
    real(dp), intent(in) :: level
    logical, intent(in) :: valid(:)
    real(dp), intent(inout) :: error(:)          !! (rows)
    logical, intent(inout) :: found(:)
    real(dp), allocatable :: columns(:, :), triangle(:, :), turned(:, :), squares(:), own(:, :), gain(:)
    integer, allocatable :: set(:)
    real(dp) :: largest, mean                    ! squared error of the rows beside
    integer :: p, n, first, last, start, end, i, k
    p = ubound(h, 1)
    n = size(error)
    set = [m]
    do
      first = max(1, minval(set) - p)
      last = min(n, maxval(set))
      if (first == 1 .and. last < rows_per_spike*(size(set) + 1)) return   ! a motion may begin here
      start = max(1, first - p - 1)
      end = min(n, last + p + 1)
      largest = max(level, maxval(error(start:first - 1)**2), maxval(error(last + 1:end)**2))
      mean = max(level, (sum(error(start:first - 1)**2) + sum(error(last + 1:end)**2))/(first - start + end - last))
      allocate (columns(first:last, size(set)), source=0.0_dp)
      do i = 1, size(set)
        do k = max(first, set(i) - p), min(last, set(i))
          columns(k, i) = h(set(i) - k)
        end do
      end do
      own = reshape(error(first:last), [last - first + 1, 1])
      call triangulate(columns, own, triangle, turned, squares)
      own = own - matmul(columns, solved(triangle, turned))
      if (sum(own**2) <= alike*mean*size(own) .and. maxval(error(first:last)**2) > clearly*largest) then
        error(first:last) = own(:, 1)
        found(set) = .true.
        return
      end if
      if (size(set) >= min(most_together, p/rows_per_spike)) return
      gain = gains_of(own(:, 1), h)              ! of samples from number `first` on
      where (.not. valid(first:last + p) .or. found(first:last + p)) gain = 0
      gain(set - first + 1) = 0
      set = [set, first - 1 + maxloc(gain, dim=1)]
      deallocate (columns)
    end do
  end subroutine try_spikes

  pure function errors_of(x, h) result(error)
    !! The error of each sample's prediction from those after it, in rows without the last samples.
    real(dp), intent(in) :: x(:), h(0:)
    real(dp) :: error(size(x) - ubound(h, 1))
    integer :: i
    error = 0
    do i = 0, ubound(h, 1)
      error = error + h(i)*x(1 + i:size(error) + i)
    end do
  end function errors_of

  pure real(dp) function colour_of(h)
    !! The variance of c over that in white errors, if the errors are those of white noise, as beside a motion that is predicted.
    real(dp), intent(in) :: h(0:)
    integer :: k
    colour_of = 1 + 2*sum([(dot_product(h(:ubound(h, 1) - k), h(k:))**2, k=1, ubound(h, 1))])/dot_product(h, h)**2
  end function colour_of

  pure function gains_of(error, h) result(gain)
    !! By how much the squares fall without each sample, (rows + p).
    real(dp), intent(in) :: error(:), h(0:)
    real(dp), dimension(size(error) + ubound(h, 1)) :: gain, energy
    integer :: i
    gain = 0
    energy = 0
    do i = 0, ubound(h, 1)
      gain(1 + i:size(error) + i) = gain(1 + i:size(error) + i) + h(i)*error
      energy(1 + i:size(error) + i) = energy(1 + i:size(error) + i) + h(i)**2
    end do
    gain = gain**2/max(energy, tiny(1.0_dp))
  end function gains_of

end module bw_spikes
