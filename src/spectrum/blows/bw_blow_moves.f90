module bw_blow_moves
  !! Blows are moved to where the lines place them, dropped if they gain less than their penalty, and added where they are missing.
  !!
  !! New motion with known poles that begins at sample n lowers the squares of the residual by T(n) = cᵀG⁻¹c. Here c is the
  !! residual's scalar products with the parts of Σ e^(z_k(m − n)), m ≥ n, and G those of these parts. Both follow from those for
  !! n + 1, so that all n together cost no more than a few transforms.
  use bw_kinds, only: dp
  use bw_line, only: bend_of, course_type, find_wave, life_of, line_type
  use bw_missing_samples, only: missing_among, project_out_missing
  use bw_model, only: add_lines, at_sensors, clear_invalid, model_type
  use bw_noise, only: mix, mixed_amplitude, white_amplitude, whiten
  use bw_penalty, only: chi_squared
  use bw_samples, only: samples_type
  implicit none (type, external)
  private
  public :: add_missing_blows, drop_blow, move_blows

  integer, parameter :: most_lines = 8           !! the strongest, which locate a blow
  integer, parameter :: enough = 2**21           !! tuned: numbers that are enough to locate a blow of known poles
  integer, parameter :: most_blows = 32
  integer, parameter :: renewed = 100            !! G is renewed when its samples have grown by 1/renewed
  integer, parameter :: fewest = 16              !! fewest samples between blows
  integer, parameter :: near = 64                !! samples by which a blow may be wrong if found from prediction errors
  real(dp), parameter :: ridge = 1.0e-6_dp       !! of G's diagonal, needed if poles are close to each other
  real(dp), parameter :: most_carried = 30       !! largest logarithm of an amplitude's change between samples
  real(dp), parameter :: worth = 1               !! fall of −2 ln L for which a blow is moved

contains

  subroutine move_blows(samples, false_alarm, model, changed)
    !! Drop and move blows; afterwards the model has to be renewed and refitted.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: changed              !! number of moves
    real(dp), allocatable :: residual(:, :), white(:, :)
    integer, allocatable :: chosen(:)
    integer :: b, best, first
    changed = 0
    if (allocated(samples%place)) return         ! at uneven times there is no prediction from sample to sample
    call drop_blows(samples, false_alarm, model, changed)
    if (all(model%lines%steady)) return
    chosen = locating_components(samples, model)
    allocate (residual(samples%count, size(chosen)), white(0, 0))
    do b = 1, ubound(model%stretches, 2)
      call find_residual(samples, model, chosen, residual)
      first = model%stretches(1, b - 1)
      if (model%stretches(2, b - 1) < first) first = model%stretches(1, b)
      white = white_values(samples, model, chosen, residual, b, first)
      best = best_shift(white, added_motion(model, chosen, b, first - model%stretches(1, b), size(white, 1)), &
        & model%stretches(1, b) - first + 1)
      if (best == 0) cycle
      call shift_blow(model, b, model%stretches(1, b) + best)
      changed = changed + 1
    end do
  end subroutine move_blows

  subroutine drop_blows(samples, false_alarm, model, dropped)
    !! Drop blows that add no significant motion with the poles found; one is kept.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: dropped
    real(dp), allocatable :: residual(:, :), white(:, :), gain(:)
    integer, allocatable :: chosen(:)
    integer :: b
    dropped = 0
    if (all(model%lines%steady) .or. ubound(model%stretches, 2) == 1) return
    chosen = locating_components(samples, model)
    allocate (residual(samples%count, size(chosen)), white(0, 0), gain(0))
    call find_residual(samples, model, chosen, residual)
    b = 1
    do while (b <= ubound(model%stretches, 2) .and. ubound(model%stretches, 2) > 1)
      if (model%stretches(2, b) >= model%stretches(1, b)) then   ! otherwise the next blow was moved to the same sample
        white = white_values(samples, model, chosen, residual, b, model%stretches(1, b))
        gain = gains_of(strongest(model, b), white + added_motion(model, chosen, b, 0, size(white, 1)))
        b = b + 1
        if (.not. gain(1) < penalty_of_blow(samples, false_alarm, model, size(chosen))) cycle
        b = b - 1
      end if
      call drop_blow(model, b)
      call find_residual(samples, model, chosen, residual)
      dropped = dropped + 1
    end do
  end subroutine drop_blows

  pure real(dp) function penalty_of_blow(samples, false_alarm, model, components) result(penalty)
    !! The penalty of a blow: that of the amplitudes of the lines that locate it.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(in) :: model
    integer, intent(in) :: components            !! number of components in use
    penalty = chi_squared(false_alarm/samples%count, 2*components*min(most_lines, count(.not. model%lines%steady)))
  end function penalty_of_blow

  subroutine add_missing_blows(samples, false_alarm, rival, from, model, added)
    !! Add blows where new motion with the poles gains more than the penalty and than a rival move.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm, rival
    integer, intent(in) :: from                  !! first stretch to search; 0 is before any blow
    type(model_type), intent(inout) :: model
    integer, intent(out) :: added
    real(dp), allocatable :: residual(:, :), gain(:)
    integer, allocatable :: chosen(:)
    real(dp) :: need
    integer :: b, best, first
    added = 0
    if (all(model%lines%steady) .or. allocated(samples%place)) return
    chosen = locating_components(samples, model)
    allocate (residual(samples%count, size(chosen)), gain(0))
    call find_residual(samples, model, chosen, residual)
    need = max(rival, penalty_of_blow(samples, false_alarm, model, size(chosen)))
    b = from
    do while (b <= min(most_blows, ubound(model%stretches, 2)))
      first = model%stretches(1, b)
      if (model%stretches(2, b) < first) then
        b = b + 1
        cycle
      end if
      gain = gains_of(strongest(model, b), white_values(samples, model, chosen, residual, b, first))
      best = maxloc(gain, dim=1)
      b = b + 1
      if (gain(best) < need .or. (best < fewest .and. b > 1)) cycle
      call add_blow(model, b - 1, first + best - 1)
      call find_residual(samples, model, chosen, residual)
      added = added + 1
    end do
  end subroutine add_missing_blows

  pure function locating_components(samples, model) result(chosen)
    !! The components of the noise in which the lines are strongest, as many as are enough to locate blows.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, allocatable :: chosen(:)
    real(dp) :: energy(size(samples%value, 2))
    integer :: c, k
    energy = 0
    do k = 1, size(model%lines)
      associate (line => model%lines(k))
        if (.not. line%steady) energy = energy + sum(abs(white_amplitude(model%noise, line))**2, dim=2) &
          & *life_of(line, 1.0_dp, 1.0_dp*samples%count)
      end associate
    end do
    chosen = pack([(c, c=1, size(energy))], [(count(energy > energy(c)) < max(1, enough/samples%count), c=1, size(energy))])
  end function locating_components

  subroutine find_residual(samples, model, chosen, residual)
    !! Find the residual of some components, offset and slope included; 0 at invalid samples.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, intent(in) :: chosen(:)
    real(dp), intent(out), contiguous :: residual(:, :)
    type(line_type) :: lines(size(model%lines))
    integer :: k
    lines = model%lines
    do k = 1, size(lines)
      lines(k)%amplitude = mixed_amplitude(model%noise, lines(k)%amplitude)
    end do
    call mix(model%noise, samples%value, chosen, residual)
    call add_lines(model%stretches, at_sensors(lines, chosen), -1.0_dp, residual, model%place)
    call clear_invalid(samples, residual)
  end subroutine find_residual

  function white_values(samples, model, chosen, residual, b, first) result(white)
    !! The prediction errors of the residual from a sample to the end of a stretch, (samples, components).
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, intent(in) :: chosen(:)             !! components
    real(dp), intent(in) :: residual(:, :)
    integer, intent(in) :: b, first
    real(dp), allocatable :: white(:, :)
    real(dp), dimension(first:model%stretches(2, b)) :: place, weight
    integer :: s, last, n
    last = model%stretches(2, b)
    white = residual(first:last, :)
    weight = 1
    if (allocated(samples%valid)) weight = merge(1.0_dp, 0.0_dp, samples%valid(first:last))
    place = [(n, n=first, last)]
    place = place - sum(weight*place)/max(1.0_dp, sum(weight))
    do s = 1, size(white, 2)                     ! subtract an offset and a slope
      white(:, s) = weight*(white(:, s) - sum(weight*white(:, s))/max(1.0_dp, sum(weight)) &
                            - sum(weight*place*white(:, s))/max(1.0_dp, sum(weight*place**2))*place)
    end do
    do s = 1, size(white, 2)
      associate (filter => model%noise%filter(:model%noise%order(chosen(s)), chosen(s)))
        call whiten(filter, white(:, s))
        call project_out_missing(missing_among(model%missing, first, last - first + 2 - size(filter), filter), white(:, s))
      end associate
    end do
    white(pack(model%missing, model%missing >= first .and. model%missing <= last) - first + 1, :) = 0
  end function white_values

  pure function added_motion(model, chosen, b, from, count) result(motion)
    !! The white motion that blow b adds, `from`, `from` + 1, … samples after it: new motion minus the continued earlier one.
    type(model_type), intent(in) :: model
    integer, intent(in) :: chosen(:)             !! components
    integer, intent(in) :: b, from, count
    real(dp) :: motion(count, size(chosen))
    complex(dp) :: wave(count)
    type(line_type) :: line
    integer :: k, s, later
    motion = 0
    later = max(1, 1 - from)                     ! place of the blow's sample
    do k = 1, size(model%lines)
      line = model%lines(k)
      if (line%steady) cycle
      line%amplitude(:, b + 1) = line%amplitude(:, b + 1) - continued(model, line, b)
      line%amplitude = white_amplitude(model%noise, line)
      call find_wave(line, real(max(from, 0), dp), wave=wave(later:))
      line%courses = [course_type ::]
      call find_wave(line, real(from, dp), wave=wave(:later - 1))
      do s = 1, size(motion, 2)
        associate (a => line%amplitude(chosen(s), b + 1))
          motion(:, s) = motion(:, s) + a%re*wave%re - a%im*wave%im
        end associate
      end do
    end do
  end function added_motion

  pure integer function best_shift(white, motion, at) result(shift)
    !! By how many samples a blow is best moved, with the motion that it adds unchanged. It is not delayed past rows without
    !! information, which may be clipped crests, nor past motion that exists in another phase, as that of a beat does: if none
    !! exists, the squares fall by those of the motion alone.
    real(dp), intent(in) :: white(:, :)          !! residual with this motion from sample `at` on
    real(dp), intent(in) :: motion(:, :)
    integer, intent(in) :: at
    real(dp) :: gain, best, taken
    integer :: n
    shift = 0
    best = worth
    gain = 0
    do n = at - 1, 1, -1
      if (all(abs(white(n, :)) <= 0)) cycle
      gain = gain + sum(white(n, :)**2 - (white(n, :) - motion(n, :))**2)
      if (gain <= best) cycle
      best = gain
      shift = n - at
    end do
    gain = 0
    taken = 0
    do n = at, size(white, 1) - fewest
      if (all(abs(white(n, :)) <= 0)) exit
      gain = gain + sum(white(n, :)**2 - (white(n, :) + motion(n, :))**2)
      taken = taken + sum(motion(n, :)**2)
      if (gain <= best .or. (n - at >= near .and. abs(gain - taken) > taken/2)) cycle
      best = gain
      shift = n + 1 - at
    end do
  end function best_shift

  pure function continued(model, line, b) result(amplitude)
    !! The amplitudes that the motion before blow b would have had at its first sample, (S).
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: line
    integer, intent(in) :: b
    complex(dp) :: amplitude(size(line%amplitude, 1))
    real(dp) :: m
    amplitude = 0
    if (b < 2) return
    m = model%stretches(1, b) - model%stretches(1, b - 1)
    amplitude = line%amplitude(:, b)*propagated(line%pole*m + bend_of(line, m))
  end function continued

  elemental complex(dp) function propagated(exponent)
    !! The factor of an amplitude from one sample to another, limited in size.
    complex(dp), intent(in) :: exponent
    propagated = exp(cmplx(max(-most_carried, min(most_carried, exponent%re)), exponent%im, dp))
  end function propagated

  pure function strongest(model, b) result(poles)
    !! The poles of the lines with most energy in a stretch.
    type(model_type), intent(in) :: model
    integer, intent(in) :: b
    complex(dp), allocatable :: poles(:)
    real(dp) :: energy(size(model%lines))
    integer :: k
    do k = 1, size(energy)
      associate (line => model%lines(k))
        energy(k) = sum(abs(line%amplitude(:, b + 1))**2)*life_of(line, 1.0_dp, 1.0_dp*size(model%white, 1))
        if (line%steady) energy(k) = -1
      end associate
    end do
    poles = pack(model%lines%pole, [(energy(k) >= 0 .and. count(energy > energy(k)) < most_lines, k=1, size(energy))])
  end function strongest

  pure function gains_of(poles, values) result(gain)
    !! The gains T of white values.
    complex(dp), intent(in) :: poles(:)
    real(dp), intent(in) :: values(:, :)
    real(dp) :: gain(size(values, 1))
    complex(dp), dimension(size(poles), size(poles)) :: with, against, product, mirrored
    complex(dp) :: c(size(poles), size(values, 2)), step(size(poles))
    real(dp) :: factor(2*size(poles), 2*size(poles)), y(2*size(poles))
    integer :: n, k, s, rows, next
    step = exp(poles)
    do k = 1, size(poles)
      with(:, k) = exp(poles + poles(k))
      against(:, k) = exp(poles + conjg(poles(k)))
    end do
    product = 0
    mirrored = 0
    c = 0
    gain = 0
    next = 0
    do n = size(values, 1), 1, -1
      product = 1 + with*product
      mirrored = 1 + against*mirrored
      do s = 1, size(values, 2)
        c(:, s) = values(n, s) + step*c(:, s)
      end do
      rows = size(values, 1) - n + 1
      if (rows < 2*size(y)) cycle
      if (rows >= next .or. n == 1) then
        factor = inverse_triangle(product, mirrored)
        next = rows + rows/renewed + 1
      end if
      do s = 1, size(values, 2)
        y = matmul([c(:, s)%re, -c(:, s)%im], factor)
        gain(n) = gain(n) + dot_product(y, y)
      end do
    end do
  end function gains_of

  pure function inverse_triangle(product, mirrored) result(inverse)
    !! R⁻¹ for the scalar products RᵀR of real and negative imaginary parts of exponentials x, from Σ x_k x_l and Σ x_k x_l*.
    complex(dp), intent(in) :: product(:, :), mirrored(:, :)
    real(dp), dimension(2*size(product, 1), 2*size(product, 1)) :: gram, inverse
    integer :: i, n
    n = size(product, 1)
    gram(:n, :n) = real(mirrored + product, dp)/2
    gram(:n, n + 1:) = aimag(mirrored - product)/2
    gram(n + 1:, :n) = transpose(gram(:n, n + 1:))
    gram(n + 1:, n + 1:) = real(mirrored - product, dp)/2
    do i = 1, 2*n
      gram(i, i) = gram(i, i)*(1 + ridge) + tiny(1.0_dp)
    end do
    inverse = 0
    do i = 1, 2*n                                ! Gram and Schmidt: columns that are orthonormal in this product
      inverse(i, i) = 1
      inverse(:, i) = inverse(:, i) - matmul(inverse(:, :i - 1), matmul(gram(i, :), inverse(:, :i - 1)))
      inverse(:, i) = inverse(:, i)/sqrt(max(dot_product(inverse(:, i), matmul(gram, inverse(:, i))), ridge*gram(i, i)))
    end do
  end function inverse_triangle

  pure subroutine drop_blow(model, b)
    !! Join a stretch with the one before, whose lines continue unless it is empty.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: b
    integer :: k, i, others(ubound(model%stretches, 2))
    if (model%stretches(2, b - 1) < model%stretches(1, b - 1)) then
      do k = 1, size(model%lines)
        model%lines(k)%amplitude(:, b) = model%lines(k)%amplitude(:, b + 1)
      end do
    end if
    others = [(i, i=0, b - 1), (i, i=b + 1, ubound(model%stretches, 2))]
    model%stretches(2, b - 1) = model%stretches(2, b)
    call choose(model, others)
    do k = 1, size(model%lines)
      model%lines(k)%amplitude = model%lines(k)%amplitude(:, others + 1)
    end do
  end subroutine drop_blow

  pure subroutine choose(model, others)
    !! Keep only these stretches.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: others(0:)
    integer :: stretches(2, 0:ubound(others, 1))
    stretches = model%stretches(:, others)
    deallocate (model%stretches, model%trend)
    allocate (model%stretches(2, 0:ubound(stretches, 2)), source=stretches)
    allocate (model%trend(2, size(model%white, 2), 0:ubound(stretches, 2)), source=0.0_dp)
  end subroutine choose

  pure subroutine shift_blow(model, b, first)
    !! Move a blow to a sample, and its amplitudes with it.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: b, first
    real(dp) :: m
    integer :: k
    m = first - model%stretches(1, b)
    model%stretches(1, b) = first
    model%stretches(2, b - 1) = first - 1
    do k = 1, size(model%lines)
      associate (line => model%lines(k))
        line%amplitude(:, b + 1) = line%amplitude(:, b + 1)*propagated(line%pole*m)
      end associate
    end do
  end subroutine shift_blow

  pure subroutine add_blow(model, b, first)
    !! Divide a stretch at a sample.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: b, first
    integer :: k, i, last
    real(dp) :: m
    last = model%stretches(2, b)
    m = first - model%stretches(1, b)
    do k = 1, size(model%lines)
      associate (line => model%lines(k))
        line%amplitude = line%amplitude(:, [(i, i=1, b + 1), b + 1, (i, i=b + 2, size(line%amplitude, 2))])
        line%amplitude(:, b + 2) = line%amplitude(:, b + 1)*propagated(line%pole*m + bend_of(line, m))
      end associate
    end do
    call choose(model, [(i, i=0, b), b, (i, i=b + 1, ubound(model%stretches, 2))])
    model%stretches(2, b) = first - 1
    model%stretches(:, b + 1) = [first, last]
  end subroutine add_blow

end module bw_blow_moves
