module bw_renewal
  !! The renewal of a model's residual: its offset and slope, the noise of its sensors or of their principal components, and its
  !! prediction errors.
  use bw_autoregression, only: autoregression, robust_levels, samples_per_order
  use bw_component_noise, only: estimate_noise, try_mixing, valid_runs
  use bw_kinds, only: dp
  use bw_line, only: has_trend, line_type
  use bw_model, only: clear_missing, find_residual, has_gaps, model_type, subtract_missing
  use bw_noise, only: ends_of, whiten
  use bw_samples, only: place_of, samples_type, validity
  use bw_uneven_noise, only: find_levels
  implicit none (type, external)
  private
  public :: renew

  integer, parameter, public :: highest_order = 64       !! tuned: of a noise's autoregression

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
    if (allocated(samples%missing)) order = min(order, order_beside_gaps(samples))
    if (allocated(samples%place) .and. .not. present(highest)) order = 0   ! for noise alone, times may be taken as even
    if (allocated(model%last)) then
      if (is_last(model, robust, order, penalty)) return  ! nothing has changed since
      deallocate (model%last)
    end if
    if (.not. allocated(model%white)) allocate (model%white(samples%count, size(samples%value, 2)))
    call find_residual(samples, model, [(s, s=1, size(noise))], model%white)
    call subtract_trend(samples, model)
    if (allocated(samples%missing)) then
      model%missing = samples%missing
    else if (.not. allocated(model%missing)) then
      allocate (model%missing(size(noise)))
      do s = 1, size(noise)
        allocate (model%missing(s)%place(0))
      end do
    end if
    call clear_missing(model%missing, model%white)
    allocate (model%last)
    model%last%robust = robust
    model%last%order = order
    model%last%penalty = penalty
    allocate (model%last%lines, source=model%lines)
    allocate (model%last%stretches, source=model%stretches)
    if (allocated(samples%place) .and. .not. allocated(model%place)) model%place = samples%place
    if (allocated(samples%place)) call find_levels(samples, model%white, model%fourier, model%level)
    do s = 1, size(noise)
      noise(s) = noise_of(s)
    end do
    if (.not. robust .and. has_gaps(model)) model%start = noise
    model%noise%cost = sum(noise%cost)
    if (allocated(model%noise%mixing)) deallocate (model%noise%mixing, model%noise%unmixing)
    if (.not. robust .and. size(noise) > 1) call try_mixing(samples%count, penalty, order, noise, model)
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
    if (has_gaps(model)) call subtract_missing(model)

  contains

    function noise_of(s) result(own)
      integer, intent(in) :: s
      type(autoregression) :: own
      if (robust .and. allocated(model%place)) then
        allocate (own%predictor(0:0), source=1.0_dp)   ! lines have not raised the level's medians
        own%variance = max(sum(model%level(:, s))/size(model%level, 1), tiny(1.0_dp))
        model%level(:, s) = model%level(:, s)/own%variance
      else if (robust) then
        call robust_levels(model%white(:, s), samples%count - size(model%missing(s)%place), penalty, model%fourier, own)
      else
        if (allocated(model%start)) own = model%start(s)
        call estimate_noise(model, s, valid_runs(model, samples%count, [s]), order, penalty, own)
        if (allocated(model%place)) model%level(:, s) = model%level(:, s)/own%variance
      end if
    end function noise_of

  end subroutine renew

  pure integer function order_beside_gaps(samples) result(order)
    !! The highest order of noise with missing samples that takes a fraction of a second.
    type(samples_type), intent(in) :: samples
    real(dp), parameter :: products = 5.0e6_dp   ! of each missing sample with two others
    integer :: s
    order = int(sqrt(products/max(1, sum([(size(samples%missing(s)%place), s=1, size(samples%missing))]))))
  end function order_beside_gaps

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

  pure subroutine subtract_trend(samples, model)
    !! Subtract offset and slope of each stretch from the residual, by least squares over its valid samples.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(inout) :: model
    real(dp) :: weight(samples%count), place(samples%count), n, middle, slope, mean
    integer :: s, b, i, other, length(0:ubound(model%stretches, 2))
    length = model%stretches(2, :) - model%stretches(1, :) + 1
    place = [(place_of(samples, i), i=1, samples%count)]
    do s = 1, size(model%white, 2)
      if (s == 1 .or. allocated(samples%missing)) weight = merge(1.0_dp, 0.0_dp, validity(samples, s))
      do b = 0, ubound(model%stretches, 2)
        associate (first => model%stretches(1, b), last => model%stretches(2, b))
          if (last < first .or. b /= sharing(b)) cycle
          associate (w => weight(first:last), u => place(first:last), x => model%white(first:last, s))
            n = max(1.0_dp, sum(w))
            middle = sum(w*u)/n
            slope = sum(w*(u - middle)*x)/max(1.0_dp, sum(w*(u - middle)**2))
            mean = sum(w*x)/n
            model%trend(:, s, b) = [mean - slope*(middle - place(first)), slope]
            x = x - mean - slope*(u - middle)
          end associate
        end associate
      end do
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

end module bw_renewal
