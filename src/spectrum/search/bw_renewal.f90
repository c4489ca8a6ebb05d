module bw_renewal
  !! The renewal of a model's residual: its offset and slope, the noise of its sensors or of their principal components, and its
  !! prediction errors.
  use bw_autoregression, only: autoregression, burg, robust_levels
  use bw_kinds, only: dp
  use bw_lapack, only: dgemm, dsyev
  use bw_line, only: has_trend, line_type
  use bw_missing_samples, only: missing_among, project_out_missing
  use bw_model, only: chunk, clear_invalid, find_residual, model_type, subtract_missing
  use bw_noise, only: ends_of, whiten
  use bw_noise_with_gaps, only: fit_with_gaps
  use bw_samples, only: place_of, samples_type, valid_runs
  use bw_uneven_noise, only: find_levels
  implicit none (type, external)
  private
  public :: renew

  integer, parameter, public :: highest_order = 64       !! tuned: of a noise's autoregression
  integer, parameter :: samples_per_order = 10   !! tuned: fewer do not determine so high an order
  real(dp), parameter :: least_share = 1.0e-3_dp !! of a sensor's noise that is its own; a rounded copy has less

contains

  subroutine renew(samples, penalty, robust, model, highest)
    !! Renew the residual of the samples, its offset and slope, its noise, and its prediction errors. A `robust` estimate of the
    !! noise is not disturbed by lines in the residual, but has no meaningful cost.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: penalty              !! per coefficient
    logical, intent(in) :: robust
    type(model_type), intent(inout) :: model
    integer, intent(in), optional :: highest     !! order of the noise; usual if absent
    type(autoregression) :: noise(size(samples%value, 2))
    integer :: s, c, order
    real(dp) :: scale
    order = highest_order
    if (present(highest)) order = highest
    order = min(order, samples%count/samples_per_order)
    if (allocated(samples%place) .and. .not. present(highest)) order = 0   ! for noise alone, times may be taken as even
    if (allocated(model%last)) then
      if (is_last(model, robust, order, penalty)) return  ! nothing has changed since
      deallocate (model%last)
    end if
    if (.not. allocated(model%white)) allocate (model%white(samples%count, size(samples%value, 2)))
    call find_residual(samples, model, [(s, s=1, size(noise))], model%white)
    call subtract_trend(samples, model)
    call clear_invalid(samples, model%white)
    model%missing = [integer ::]
    if (allocated(samples%valid)) model%missing = pack([(c, c=1, samples%count)], .not. samples%valid)
    allocate (model%last)
    model%last%robust = robust
    model%last%order = order
    model%last%penalty = penalty
    allocate (model%last%lines, source=model%lines)
    allocate (model%last%stretches, source=model%stretches)
    if (allocated(samples%place) .and. .not. allocated(model%place)) model%place = samples%place
    if (allocated(samples%place)) call find_levels(samples%place, model%white, model%fourier, model%level)
    do s = 1, size(noise)
      noise(s) = noise_of(s)
    end do
    if (.not. robust .and. size(model%missing) > 0) model%start = noise
    model%noise%cost = sum(noise%cost)
    if (allocated(model%noise%mixing)) deallocate (model%noise%mixing, model%noise%unmixing)
    if (.not. robust .and. size(noise) > 1) call try_mixing(samples, penalty, order, noise, model)
    model%noise%order = [(ubound(noise(s)%predictor, 1), s=1, size(noise))]
    model%noise%lost = maxval(model%noise%order)
    if (allocated(model%noise%filter)) deallocate (model%noise%filter)
    allocate (model%noise%filter(0:model%noise%lost, size(noise)), source=0.0_dp)
    if (allocated(model%noise%ends)) deallocate (model%noise%ends)
    allocate (model%noise%ends(0:model%noise%lost, 0:model%noise%lost - 1, size(noise)), source=0.0_dp)
    call keep_ends(model)
    do s = 1, size(noise)
      scale = 1/sqrt(noise(s)%variance)
      do c = 0, ubound(model%stretches, 2)
        associate (first => model%stretches(1, c), last => model%stretches(2, c))
          if (last >= first) call whiten(noise(s)%predictor, model%white(first:last, s))
          model%white(max(first, last - model%noise%lost + 1):last, s) = 0
        end associate
      end do
      model%white(:, s) = model%white(:, s)*scale
      model%noise%filter(:model%noise%order(s), s) = noise(s)%predictor*scale
      model%noise%ends(:model%noise%order(s), :model%noise%order(s) - 1, s) = ends_of(noise(s)%predictor*scale)
    end do
    call subtract_missing(model)

  contains

    function noise_of(s) result(own)
      integer, intent(in) :: s
      type(autoregression) :: own
      if (robust .and. allocated(model%place)) then
        allocate (own%predictor(0:0), source=1.0_dp)   ! lines have not raised the level's medians
        own%variance = max(sum(model%level(:, s))/size(model%level, 1), tiny(1.0_dp))
        model%level(:, s) = model%level(:, s)/own%variance
      else if (robust) then
        call robust_levels(model%white(:, s), penalty, model%fourier, own)
      else
        if (allocated(model%start)) own = model%start(s)
        call estimate_noise(samples, model, s, order, penalty, own)
        if (allocated(model%place)) model%level(:, s) = model%level(:, s)/own%variance
      end if
    end function noise_of

  end subroutine renew

  pure subroutine keep_ends(model)
    !! Keep the residual of the last samples of each stretch.
    type(model_type), intent(inout) :: model
    integer :: b, n
    if (allocated(model%last_values)) deallocate (model%last_values)
    allocate (model%last_values(model%noise%lost, size(model%white, 2), 0:ubound(model%stretches, 2)), source=0.0_dp)
    do b = 0, ubound(model%stretches, 2)
      associate (first => model%stretches(1, b), last => model%stretches(2, b), lost => model%noise%lost)
        n = min(lost, last - first + 1)
        if (n > 0) model%last_values(lost - n + 1:, :, b) = model%white(last - n + 1:last, :)
      end associate
    end do
  end subroutine keep_ends

  subroutine estimate_noise(samples, model, s, order, penalty, noise)
    !! Estimate the noise of one component of the residual.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, intent(in) :: s
    integer, intent(in) :: order                 !! the highest
    real(dp), intent(in) :: penalty
    type(autoregression), intent(inout) :: noise   !! with the initial predictor, if samples are missing
    if (size(model%missing) == 0 .or. allocated(model%place)) then
      call burg(model%white(:, s), all_runs(samples, model), order, penalty, noise)
    else
      call fit_with_gaps(model%white(:, s), all_runs(samples, model), model%stretches, order, penalty, noise)
    end if
  end subroutine estimate_noise

  pure logical function is_last(model, robust, order, penalty)
    !! Whether the noise was last estimated in this way, with these lines and stretches.
    type(model_type), intent(in) :: model
    logical, intent(in) :: robust
    integer, intent(in) :: order
    real(dp), intent(in) :: penalty
    integer :: k
    associate (last => model%last)
      is_last = (last%robust .eqv. robust) .and. last%order == order .and. .not. abs(last%penalty - penalty) > 0 &
        & .and. size(last%lines) == size(model%lines) .and. size(last%stretches) == size(model%stretches)
      if (is_last) is_last = all(last%stretches == model%stretches)
      if (is_last) is_last = all([(are_same(last%lines(k), model%lines(k)), k=1, size(model%lines))])
    end associate
  end function is_last

  pure logical function are_same(line, other)
    !! Whether two lines are the same.
    type(line_type), intent(in) :: line, other
    are_same = line%pole == other%pole .and. (line%steady .eqv. other%steady) .and. size(line%courses) == size(other%courses)
    if (are_same) are_same = all(line%courses%rate == other%courses%rate .and. line%courses%bend == other%courses%bend) &
      & .and. all(line%amplitude == other%amplitude)
  end function are_same

  pure function all_runs(samples, model) result(runs)
    !! The runs of valid samples in all stretches.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, allocatable :: runs(:, :)
    integer :: b
    allocate (runs(2, 0))
    do b = 0, ubound(model%stretches, 2)
      if (model%stretches(2, b) < model%stretches(1, b)) cycle
      call append_runs(valid_runs(samples, model%stretches(1, b), model%stretches(2, b)), runs)
    end do
  end function all_runs

  pure subroutine append_runs(own, runs)
    !! Append runs to others.
    integer, intent(in) :: own(:, :)
    integer, allocatable, intent(inout) :: runs(:, :)
    integer :: more(2, size(runs, 2) + size(own, 2))
    more(:, :size(runs, 2)) = runs
    more(:, size(runs, 2) + 1:) = own
    runs = more
  end subroutine append_runs

  pure subroutine subtract_trend(samples, model)
    !! Subtract offset and slope of each stretch from the residual, by least squares over its valid samples.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(inout) :: model
    real(dp) :: weight(samples%count), u(samples%count), middle, slope
    integer :: s, b, i, other, length(0:ubound(model%stretches, 2))
    length = model%stretches(2, :) - model%stretches(1, :) + 1
    weight = 1
    if (allocated(samples%valid)) weight = merge(1.0_dp, 0.0_dp, samples%valid)
    do b = 0, ubound(model%stretches, 2)
      associate (first => model%stretches(1, b), last => model%stretches(2, b))
        if (last < first .or. b /= sharing(b)) cycle
        associate (w => weight(first:last), n => max(1.0_dp, sum(weight(first:last))))
          u(first:last) = [(place_of(samples, i) - place_of(samples, first), i=first, last)]
          middle = sum(w*u(first:last))/n
          u(first:last) = u(first:last) - middle
          do s = 1, size(model%white, 2)
            associate (x => model%white(first:last, s))
              slope = sum(w*u(first:last)*x)/max(1.0_dp, sum(w*u(first:last)**2))
              model%trend(:, s, b) = [sum(w*x)/n - slope*middle, slope]
              x = x - sum(w*x)/n - slope*u(first:last)
            end associate
          end do
        end associate
      end associate
    end do
    do b = 0, ubound(model%stretches, 2)
      other = sharing(b)
      if (other == b) cycle
      do s = 1, size(model%white, 2)
        associate (first => model%stretches(1, b), trend => model%trend(:, s, b))
          trend = model%trend(:, s, other)
          trend(1) = trend(1) + trend(2)*(place_of(samples, first) - place_of(samples, model%stretches(1, other)))
          do i = first, model%stretches(2, b)
            model%white(i, s) = model%white(i, s) - trend(1) - trend(2)*(place_of(samples, i) - place_of(samples, first))
          end do
        end associate
      end do
    end do

  contains

    pure integer function sharing(b)
      !! The stretch whose trend stretch b shares: the next that has one, from b on, or else the last that has one.
      integer, intent(in) :: b
      do sharing = b, ubound(model%stretches, 2)
        if (has_own(sharing)) return
      end do
      do sharing = b - 1, 0, -1
        if (has_own(sharing)) return
      end do
    end function sharing

    pure logical function has_own(b)
      integer, intent(in) :: b
      has_own = has_trend(model%lines, maxval(length), length(b))
    end function has_own

  end subroutine subtract_trend

  subroutine try_mixing(samples, penalty, order, noise, model)
    !! Mix the sensors into the principal components of their prediction errors if these have the lower cost.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: penalty
    integer, intent(in) :: order
    type(autoregression), intent(inout) :: noise(:)
    type(model_type), intent(inout) :: model
    type(autoregression) :: own(size(noise))
    real(dp), dimension(size(noise), size(noise)) :: correlation, vectors
    real(dp) :: values(size(noise)), work(64*size(noise)), cost
    real(dp), allocatable :: error(:, :)
    integer, allocatable :: runs(:, :)
    integer :: s, sensors, info, b, n, valid_count, first, lost
    sensors = size(noise)
    runs = all_runs(samples, model)
    valid_count = sum(runs(2, :) - runs(1, :) + 1) ! number of valid samples
    lost = maxval([(ubound(noise(s)%predictor, 1), s=1, sensors)])
    correlation = 0
    allocate (error(0, 0))
    do b = 0, ubound(model%stretches, 2)
      do first = model%stretches(1, b), model%stretches(2, b), chunk
        n = min(chunk, model%stretches(2, b) - first + 1)
        error = model%white(first:min(first + n + lost - 1, model%stretches(2, b)), :)
        do s = 1, sensors
          call whiten(noise(s)%predictor, error(:, s))
          call project_out_missing(missing_among(model%missing, first, size(error, 1) - ubound(noise(s)%predictor, 1), &
            & noise(s)%predictor), &
            & error(:, s))
        end do
        call dgemm('T', 'N', sensors, sensors, n, 1.0_dp, error, size(error, 1), error, size(error, 1), 1.0_dp, correlation, &
          & sensors)
      end do
    end do
    values = 1/sqrt([(max(correlation(s, s), tiny(1.0_dp)), s=1, sensors)])
    correlation = correlation*spread(values, 1, sensors)*spread(values, 2, sensors)
    vectors = correlation
    call dsyev('V', 'U', sensors, vectors, sensors, values, work, size(work), info)
    cost = 0.5_dp*sensors*(sensors - 1)*penalty
    if (valid_count*sum(log(max(values, 1.0e-12_dp))) + cost > 0) return
    model%noise%mixing = spread(1/sqrt(noise%variance), 2, sensors)*vectors
    model%noise%unmixing = transpose(vectors)*spread(sqrt(noise%variance), 1, sensors)
    call mix(model%noise%mixing, model%white)
    do s = 1, sensors
      own(s)%predictor = noise(s)%predictor
      call estimate_noise(samples, model, s, order, penalty, own(s))
      own(s)%variance = max(own(s)%variance, least_share)
    end do
    cost = cost + sum(own%cost) + valid_count*sum(log(noise%variance))
    if (cost < model%noise%cost) then
      model%noise%cost = cost
      noise = own
    else
      call mix(model%noise%unmixing, model%white)
      deallocate (model%noise%mixing, model%noise%unmixing)
    end if
  end subroutine try_mixing

  subroutine mix(matrix, values)
    !! Replace rows of values by their products with a matrix.
    real(dp), intent(in) :: matrix(:, :)
    real(dp), intent(inout) :: values(:, :)
    real(dp) :: part(chunk, size(matrix, 1))
    integer :: first, n
    do first = 1, size(values, 1), chunk
      n = min(chunk, size(values, 1) - first + 1)
      part(:n, :) = values(first:first + n - 1, :)
      values(first:first + n - 1, :) = matmul(part(:n, :), matrix)
    end do
  end subroutine mix

end module bw_renewal
