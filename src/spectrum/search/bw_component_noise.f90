module bw_component_noise
  !! The noise of a model's components: of single sensors, or of the sensors' principal components if they share noise.
  use bw_autoregression, only: autoregression, burg
  use bw_kinds, only: dp
  use bw_lapack, only: dgemm, dsyev
  use bw_missing_samples, only: missing_among, project_out_missing
  use bw_model, only: chunk, clear_missing, has_gaps, model_type
  use bw_noise, only: whiten
  use bw_noise_with_gaps, only: fit_with_gaps
  use bw_samples, only: gaps_of, gaps_type, runs_of
  implicit none (type, external)
  private
  public :: estimate_noise, try_mixing, valid_runs

  real(dp), parameter :: least_share = 1.0e-3_dp !! of a sensor's noise that is its own; a rounded copy has less

contains

  subroutine estimate_noise(model, s, runs, order, penalty, noise)
    !! Estimate the noise of one component of the residual.
    type(model_type), intent(in) :: model
    integer, intent(in) :: s
    integer, intent(in) :: runs(:, :)            !! first and last sample of each run of valid ones, (2, runs)
    integer, intent(in) :: order                 !! the highest
    real(dp), intent(in) :: penalty
    type(autoregression), intent(inout) :: noise   !! with the initial predictor, if samples are missing
    if (has_gaps(model) .and. .not. allocated(model%place)) then
      call fit_with_gaps(model%white(:, s), runs, model%stretches, order, penalty, noise)
    else
      call burg(model%white(:, s), runs, order, penalty, noise)
    end if
  end subroutine estimate_noise

  pure function valid_runs(model, count, sensors) result(runs)
    !! The runs, in all stretches, of samples that are valid at each of some sensors, (2, runs).
    type(model_type), intent(in) :: model
    integer, intent(in) :: count                 !! N
    integer, intent(in) :: sensors(:)
    integer, allocatable :: runs(:, :)
    logical :: valid(count)
    integer :: b, i
    valid = .true.
    do i = 1, size(sensors)
      valid(model%missing(sensors(i))%place) = .false.
    end do
    allocate (runs(2, 0))
    do b = 0, ubound(model%stretches, 2)
      if (model%stretches(2, b) < model%stretches(1, b)) cycle
      call append_runs(runs_of(valid, model%stretches(1, b), model%stretches(2, b)), runs)
    end do
  end function valid_runs

  pure subroutine append_runs(own, runs)
    !! Append runs to others.
    integer, intent(in) :: own(:, :)
    integer, allocatable, intent(inout) :: runs(:, :)
    integer :: more(2, size(runs, 2) + size(own, 2))
    more(:, :size(runs, 2)) = runs
    more(:, size(runs, 2) + 1:) = own
    runs = more
  end subroutine append_runs

  subroutine try_mixing(count, penalty, order, noise, model)
    !! Mix the sensors into the principal components of their prediction errors if these have the lower cost. A component is known
    !! where all sensors are valid: only there are the costs compared, and lines fitted.
    integer, intent(in) :: count                 !! N
    real(dp), intent(in) :: penalty
    integer, intent(in) :: order
    type(autoregression), intent(inout) :: noise(:)
    type(model_type), intent(inout) :: model
    type(autoregression) :: own(size(noise))
    type(gaps_type) :: gaps(size(noise))
    real(dp), dimension(size(noise), size(noise)) :: correlation, vectors
    real(dp) :: values(size(noise)), work(64*size(noise)), cost
    real(dp), allocatable :: error(:, :), before(:, :)
    integer, allocatable :: runs(:, :)
    integer :: s, sensors, info, b, n, valid_count, first, lost
    sensors = size(noise)
    gaps = model%missing
    runs = valid_runs(model, count, [(s, s=1, sensors)])
    valid_count = sum(runs(2, :) - runs(1, :) + 1) ! number of samples valid at all sensors
    lost = maxval([(ubound(noise(s)%predictor, 1), s=1, sensors)])
    correlation = 0
    allocate (error(0, 0))
    do b = 0, ubound(model%stretches, 2)
      do first = model%stretches(1, b), model%stretches(2, b), chunk
        n = min(chunk, model%stretches(2, b) - first + 1)
        error = model%white(first:min(first + n + lost - 1, model%stretches(2, b)), :)
        do s = 1, sensors
          call whiten(noise(s)%predictor, error(:, s))
          call project_out_missing(missing_among(gaps(s)%place, first, size(error, 1) - ubound(noise(s)%predictor, 1), &
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
    if (info /= 0) return
    cost = 0.5_dp*sensors*(sensors - 1)*penalty
    if (valid_count*sum(log(max(values, 1.0e-12_dp))) + cost > 0) return
    cost = cost + valid_count*sum(log(noise%variance))
    if (any([(size(gaps(s)%place) < count - valid_count, s=1, sensors)])) then
      before = model%white
      gaps = complement()
      call clear_missing(gaps, model%white)
      own = noise
      do s = 1, sensors
        call estimate_noise(model, s, runs, order, penalty, own(s))
      end do
      cost = cost + sum(noise%cost) - sum(own%cost)
    end if
    model%noise%mixing = spread(1/sqrt(noise%variance), 2, sensors)*vectors
    model%noise%unmixing = transpose(vectors)*spread(sqrt(noise%variance), 1, sensors)
    call mix(model%noise%mixing, model%white)
    do s = 1, sensors
      own(s)%predictor = noise(s)%predictor
      call estimate_noise(model, s, runs, order, penalty, own(s))
      own(s)%variance = max(own(s)%variance, least_share)
    end do
    cost = cost + sum(own%cost)
    if (cost < model%noise%cost) then
      model%noise%cost = cost
      model%missing = gaps
      noise = own
    else
      call mix(model%noise%unmixing, model%white)
      if (allocated(before)) call move_alloc(before, model%white)
      deallocate (model%noise%mixing, model%noise%unmixing)
    end if

  contains

    pure function complement() result(missing)
      !! For each component, the samples that are not valid at all sensors.
      type(gaps_type) :: missing(sensors)
      logical :: is_valid(count)
      integer :: r
      is_valid = .false.
      do r = 1, size(runs, 2)
        is_valid(runs(1, r):runs(2, r)) = .true.
      end do
      missing = gaps_of(is_valid)
    end function complement

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

end module bw_component_noise
