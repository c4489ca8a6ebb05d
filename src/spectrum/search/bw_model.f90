module bw_model
  !! The model of a record during the search for lines: its stretches, lines, noise and residual.
  use bw_autoregression, only: autoregression, burg, robust_levels
  use bw_constants, only: pi
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_lapack, only: ddot, dgemm, dsyev
  use bw_line, only: find_wave, life_of, line_type
  use bw_missing_samples, only: missing_among, take_off
  use bw_noise, only: ends_of, mixed_amplitude, noise_type, squares_at_end, white_amplitude, whiten
  use bw_noise_with_gaps, only: fit_with_gaps
  use bw_samples, only: place_of, samples_type, valid_runs
  use bw_uneven_noise, only: find_levels
  implicit none (type, external)
  private
  public :: add_lines, at_sensors, clear_invalid, colour_at, exchange_lines, find_misfit, renew, rows_of_stretches, steps_between, &
    & white_lines

  real(dp), parameter :: negligible = 40         !! e-folds after which a line is negligible
  integer, parameter, public :: highest_order = 64       !! tuned: of a noise's autoregression
  integer, parameter :: samples_per_order = 10   !! tuned: fewer do not determine so high an order
  real(dp), parameter :: least_share = 1.0e-3_dp !! of a sensor's noise that is its own; a rounded copy has less
  integer, parameter :: chunk = 2048             !! rows handled at once

  type :: renewal_type
    !! The input of the last noise estimate.
    type(line_type), allocatable :: lines(:)
    integer, allocatable :: stretches(:, :)      !! (2, 0:B)
    logical :: robust = .false.
    integer :: order = 0                         !! the highest one
  end type renewal_type

  type, public :: model_type
    integer, allocatable :: stretches(:, :)      !! first and last sample: before any blow, and after each, (2, 0:B)
    type(line_type), allocatable :: lines(:)
    real(dp), allocatable :: trend(:, :, :)      !! offset at a stretch's first sample and slope per step, (2, S, 0:B)
    type(noise_type) :: noise
    real(dp), allocatable :: place(:)            !! times of uneven samples, in steps, (N); their noise is white up to `level`
    real(dp), allocatable :: level(:, :)         !! of uneven samples: power of the noise over its mean, (bins, S)
    integer, allocatable :: missing(:)           !! invalid samples, ascending
    real(dp), allocatable :: white(:, :)         !! prediction errors over their standard deviation; 0 where there is none, (N, S)
    real(dp), allocatable :: last_values(:, :, :)  !! the components' residual at the last samples of each stretch, (lost, S, 0:B)
    type(real_fourier) :: fourier
    type(renewal_type), allocatable :: last      !! the last renewal
    type(autoregression), allocatable :: start(:)  !! last noise estimate of each sensor, if samples are missing
  end type model_type

contains

  pure function rows_of_stretches(model) result(rows)
    !! First and last sample of each stretch that have a prediction error, (2, 0:B).
    type(model_type), intent(in) :: model
    integer :: rows(2, 0:ubound(model%stretches, 2))
    rows = model%stretches
    rows(2, :) = rows(2, :) - model%noise%lost
  end function rows_of_stretches

  pure function white_lines(model, lines) result(white)
    !! The lines with their amplitudes in the white components.
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: lines(:)
    type(line_type) :: white(size(lines))
    integer :: k
    white = lines
    do k = 1, size(lines)
      white(k)%amplitude = white_amplitude(model%noise, lines(k))
    end do
  end function white_lines

  pure subroutine exchange_lines(model, old, new, fall)
    !! Add some lines to the residual, and subtract others.
    type(model_type), intent(inout) :: model
    type(line_type), intent(in) :: old(:), new(:)
    real(dp), intent(out) :: fall                !! of −2 ln L at a fixed noise level
    type(line_type) :: lines(size(old) + size(new))
    logical :: drifts(size(lines))
    real(dp) :: before
    integer :: k
    lines = [old, new]
    do k = size(old) + 1, size(lines)
      lines(k)%amplitude = -lines(k)%amplitude
    end do
    drifts = [(size(lines(k)%courses) > 0, k=1, size(lines))]
    before = squares_at_ends(model)
    if (any(drifts) .or. size(model%missing) > 0) before = before + sum(model%white**2)
    call add_to_ends(model, lines)
    if (any(drifts)) call add_drifting_lines(model, pack(lines, drifts))
    call add_lines(rows_of_stretches(model), white_lines(model, pack(lines, .not. drifts)), 1.0_dp, model%white, model%place, fall)
    if (size(model%missing) > 0) call subtract_missing(model)
    if (any(drifts) .or. size(model%missing) > 0) fall = -sum(model%white**2)
    fall = fall + before - squares_at_ends(model)
  end subroutine exchange_lines

  pure subroutine add_drifting_lines(model, lines)
    !! Add the prediction errors of lines whose factor H changes along the record, to white samples.
    type(model_type), intent(inout) :: model
    type(line_type), intent(in) :: lines(:)
    type(line_type) :: mixed(size(lines))
    real(dp) :: motion(size(model%white, 1), 1)
    integer :: k, c, b
    mixed = lines
    do k = 1, size(lines)
      mixed(k)%amplitude = mixed_amplitude(model%noise, lines(k)%amplitude)
    end do
    do c = 1, size(model%white, 2)
      motion = 0
      call add_lines(model%stretches, at_sensors(mixed, [c]), 1.0_dp, motion, model%place)
      do b = 1, ubound(model%stretches, 2)
        associate (first => model%stretches(1, b), last => model%stretches(2, b))
          if (last < first) cycle
          call whiten(model%noise%filter(:model%noise%order(c), c), motion(first:last, 1))
          motion(max(first, last - model%noise%lost + 1):last, 1) = 0
          model%white(first:last, c) = model%white(first:last, c) + motion(first:last, 1)
        end associate
      end do
    end do
  end subroutine add_drifting_lines

  pure real(dp) function squares_at_ends(model) result(squares)
    !! The sum of squared prediction errors of all samples without a row.
    type(model_type), intent(in) :: model
    integer :: b
    squares = 0
    do b = 0, ubound(model%stretches, 2)
      associate (n => model%stretches(2, b) - model%stretches(1, b) + 1, lost => model%noise%lost)
        squares = squares + squares_at_end(model%noise, model%last_values(max(1, lost - n + 1):, :, b))
      end associate
    end do
  end function squares_at_ends

  pure subroutine add_to_ends(model, lines)
    !! Add lines to the residual of the last samples of each stretch.
    type(model_type), intent(inout) :: model
    type(line_type), intent(in) :: lines(:)
    complex(dp) :: wave(model%noise%lost)
    integer :: k, c, b, first
    if (model%noise%lost == 0) return
    do k = 1, size(lines)
      associate (amplitude => mixed_amplitude(model%noise, lines(k)%amplitude))
        do b = merge(0, 1, lines(k)%steady), ubound(model%stretches, 2)
          first = max(1, model%noise%lost - (model%stretches(2, b) - model%stretches(1, b)))
          call find_wave(lines(k), real(model%stretches(2, b) - model%stretches(1, b) + first - model%noise%lost, dp), &
            & wave=wave(first:))
          do c = 1, size(amplitude, 1)
            model%last_values(first:, c, b) = model%last_values(first:, c, b) + real(amplitude(c, b + 1)*wave(first:), dp)
          end do
        end do
      end associate
    end do
    if (size(model%missing) > 0) call clear_ends(model)
  end subroutine add_to_ends

  pure subroutine clear_ends(model)
    !! Set missing samples to 0 there.
    type(model_type), intent(inout) :: model
    integer :: b, i
    do b = 0, ubound(model%stretches, 2)
      do i = 1, size(model%missing)
        associate (n => model%missing(i) - model%stretches(2, b) + model%noise%lost)
          if (n > 0 .and. n <= model%noise%lost) model%last_values(n, :, b) = 0
        end associate
      end do
    end do
  end subroutine clear_ends

  pure real(dp) function steps_between(model, first, last)
    !! The length of a part of the record, in steps.
    type(model_type), intent(in) :: model
    integer, intent(in) :: first, last           !! samples
    steps_between = last - first + 1
    if (allocated(model%place) .and. last > first) steps_between = model%place(last) - model%place(first) + 1
  end function steps_between

  pure real(dp) function colour_at(model, frequency) result(colour)
    !! The noise's power near a frequency over that of its prediction: 1 except for uneven samples.
    type(model_type), intent(in) :: model
    real(dp), intent(in) :: frequency            !! rad per step
    colour = 1
    if (.not. allocated(model%level)) return
    associate (bins => size(model%level, 1))
      colour = maxval(model%level(max(1, min(bins, nint(frequency/pi*bins))), :))
    end associate
  end function colour_at

  pure subroutine add_lines(rows, lines, factor, values, place, fall)
    !! Add lines times a factor to the values of all sensors, in parts that fit a processor's cache.
    integer, intent(in) :: rows(:, 0:)           !! of the stretches
    type(line_type), intent(in) :: lines(:)
    real(dp), intent(in) :: factor
    real(dp), intent(inout), contiguous :: values(:, :)
    real(dp), intent(in), optional :: place(:)   !! times of uneven samples
    real(dp), intent(out), optional :: fall      !! by which the sum of the squares falls
    real(dp) :: waves(chunk, 2*size(lines)), amplitudes(2*size(lines), size(values, 2))
    integer :: b, k, m, n, first
    if (present(fall)) fall = 0
    do b = 0, ubound(rows, 2)
      do first = rows(1, b), rows(2, b), chunk
        n = min(chunk, rows(2, b) - first + 1)
        m = 0
        do k = 1, size(lines)
          if (.not. is_there(lines(k), b, first)) cycle
          call fill(lines(k), first - rows(1, b), first, waves(:n, m + 1:m + 2))
          amplitudes(m + 1, :) = factor*lines(k)%amplitude(:, b + 1)%re
          amplitudes(m + 2, :) = -factor*lines(k)%amplitude(:, b + 1)%im
          m = m + 2
        end do
        if (m == 0) cycle
        call add_part(size(values, 1), size(values, 2), first, n, waves, amplitudes, m, values, fall)
      end do
    end do

  contains

    pure logical function is_there(line, b, first)
      !! Whether a line is not yet negligible in a part of a stretch.
      type(line_type), intent(in) :: line
      integer, intent(in) :: b, first
      is_there = b > 0 .or. line%steady
      if (is_there .and. .not. present(place)) &
        & is_there = first - rows(1, b) < life_of(line, negligible, real(rows(2, b) - rows(1, b) + 1, dp))
    end function is_there

    pure subroutine fill(line, from, first, wave)
      !! Real and imaginary part of a line of amplitude 1.
      type(line_type), intent(in) :: line
      integer, intent(in) :: from, first
      real(dp), intent(out) :: wave(:, :)
      complex(dp) :: own(size(wave, 1))
      if (present(place)) then
        call find_wave(line, place(first - from), place(first:first + size(own) - 1), own)
      else
        call find_wave(line, real(from, dp), wave=own)
      end if
      wave(:, 1) = own%re
      wave(:, 2) = own%im
    end subroutine fill

  end subroutine add_lines

  pure subroutine add_part(count, sensors, first, rows, waves, amplitudes, used, values, fall)
    !! Add the first `used` waves, times their amplitudes, to `rows` rows of values.
    integer, intent(in) :: count, sensors, first, rows, used
    real(dp), intent(in) :: waves(:, :), amplitudes(:, :)
    real(dp), intent(inout) :: values(count, sensors)
    real(dp), intent(inout), optional :: fall    !! of the squares
    if (present(fall)) fall = fall + squares()
    call dgemm('N', 'N', rows, sensors, used, 1.0_dp, waves, size(waves, 1), amplitudes, size(amplitudes, 1), 1.0_dp, &
      & values(first, 1), count)
    if (present(fall)) fall = fall - squares()

  contains

    pure real(dp) function squares()
      integer :: s
      squares = sum([(ddot(rows, values(first, s), 1, values(first, s), 1), s=1, sensors)])
    end function squares

  end subroutine add_part

  pure function at_sensors(lines, sensors) result(chosen)
    !! The lines with their amplitudes at some sensors only.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: sensors(:)
    type(line_type) :: chosen(size(lines))
    integer :: k
    chosen = lines
    do k = 1, size(lines)
      chosen(k)%amplitude = lines(k)%amplitude(sensors, :)
    end do
  end function at_sensors

  pure subroutine find_residual(samples, model, sensors, residual)
    !! Find the residual of some sensors, offset and slope included; 0 at invalid samples.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, intent(in) :: sensors(:)
    real(dp), intent(out), contiguous :: residual(:, :)
    integer :: s
    do s = 1, size(residual, 2)
      residual(:, s) = samples%value(:samples%count, sensors(s))
    end do
    call add_lines(model%stretches, at_sensors(model%lines, sensors), -1.0_dp, residual, model%place)
    call clear_invalid(samples, residual)
  end subroutine find_residual

  pure subroutine find_misfit(samples, model, sensors, residual)
    !! Find the residual of the samples after lines, offset and slope of each stretch; undefined at invalid samples.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, intent(in) :: sensors(:)
    real(dp), intent(out), contiguous :: residual(:, :)
    integer :: s, b, n
    call find_residual(samples, model, sensors, residual)
    do s = 1, size(residual, 2)
      do b = 0, ubound(model%stretches, 2)
        associate (first => model%stretches(1, b), trend => model%trend(:, sensors(s), b))
          do n = first, model%stretches(2, b)
            residual(n, s) = residual(n, s) - trend(1) - trend(2)*(place_of(samples, n) - place_of(samples, first))
          end do
        end associate
      end do
    end do
  end subroutine find_misfit

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
    if (allocated(model%last)) then
      if (is_last(model, robust, order)) return  ! nothing has changed since
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
    allocate (model%last%lines, source=model%lines)
    allocate (model%last%stretches, source=model%stretches)
    if (allocated(samples%place) .and. .not. present(highest)) order = 0   ! for noise alone, times may be taken as even
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

  pure logical function is_last(model, robust, order)
    !! Whether the noise was last estimated in this way, with these lines and stretches.
    type(model_type), intent(in) :: model
    logical, intent(in) :: robust
    integer, intent(in) :: order
    integer :: k
    associate (last => model%last)
      is_last = (last%robust .eqv. robust) .and. last%order == order .and. size(last%lines) == size(model%lines) &
        & .and. size(last%stretches) == size(model%stretches)
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

  pure subroutine clear_invalid(samples, values)
    !! Set invalid samples to 0.
    type(samples_type), intent(in) :: samples
    real(dp), intent(inout) :: values(:, :)
    integer :: s
    if (.not. allocated(samples%valid)) return
    do s = 1, size(values, 2)
      where (.not. samples%valid) values(:, s) = 0
    end do
  end subroutine clear_invalid

  pure subroutine subtract_missing(model)
    !! Subtract from the white rows the part that missing samples explain.
    type(model_type), intent(inout) :: model
    integer :: rows(2, 0:ubound(model%stretches, 2)), b, s
    if (size(model%missing) == 0) return
    rows = rows_of_stretches(model)
    do b = 0, ubound(rows, 2)
      do s = 1, size(model%white, 2)
        call take_off(missing_among(model%missing, rows(1, b), rows(2, b) - rows(1, b) + 1, &
          & model%noise%filter(:model%noise%order(s), s)), model%white(rows(1, b):rows(2, b), s))
      end do
    end do
  end subroutine subtract_missing

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
    integer :: s, b, i
    weight = 1
    if (allocated(samples%valid)) weight = merge(1.0_dp, 0.0_dp, samples%valid)
    do b = 0, ubound(model%stretches, 2)
      associate (first => model%stretches(1, b), last => model%stretches(2, b))
        if (last < first) cycle
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
          call take_off(missing_among(model%missing, first, size(error, 1) - ubound(noise(s)%predictor, 1), noise(s)%predictor), &
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

end module bw_model
