module bw_blow_moves
  !! Blows moved to where the poles found say that they are, dropped where they do not pay, and added where they are missing.
  !!
  !! New motion of known poles that begins at sample n takes T(n) = cᵀG⁻¹c off the squares of what is left, c being its scalar
  !! products with the parts of Σ e^(z_k(m − n)), m ≥ n, and G those of these parts. Both follow from those of n + 1, so that all n cost no
  !! more than a few transforms.
  use bw_kinds, only: dp
  use bw_line, only: bend_of, course_type, find_wave, life_of, line_type
  use bw_missing_samples, only: missing_among, take_off
  use bw_model, only: add_lines, at_sensors, clear_invalid, model_type
  use bw_noise, only: mix, mixed_amplitude, white_amplitude, whiten
  use bw_penalty, only: chi_squared
  use bw_samples, only: samples_type
  implicit none (type, external)
  private
  public :: add_missing_blows, drop_blow, move_blows

  integer, parameter :: most_lines = 8           !! the strongest, which tell where a blow is
  integer, parameter :: enough = 2**21           !! tuned: numbers that tell where a blow of known poles is
  integer, parameter :: most_blows = 32
  integer, parameter :: renewed = 100            !! part of its samples, by which G may have grown
  integer, parameter :: fewest = 16              !! samples between blows
  integer, parameter :: near = 64                !! samples by which a blow may be missed where a prediction errs
  real(dp), parameter :: ridge = 1.0e-6_dp       !! of G's diagonal, which poles beside each other need
  real(dp), parameter :: most_carried = 30       !! logarithm of that factor
  real(dp), parameter :: worth = 1               !! fall of −2 ln L for which a blow is moved

contains

  subroutine move_blows(samples, false_alarm, model, changed)
    !! Drop and move blows; the model is to be renewed and refitted then.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: changed              !! moves
    real(dp), allocatable :: left(:, :), white(:, :)
    integer, allocatable :: those(:)
    integer :: b, best, first
    changed = 0
    if (allocated(samples%place)) return         ! uneven times have no prediction from sample to sample
    call drop_blows(samples, false_alarm, model, changed)
    if (all(model%lines%steady)) return
    those = telling(samples, model)
    allocate (left(samples%count, size(those)), white(0, 0))
    do b = 1, ubound(model%stretches, 2)
      call find_left(samples, model, those, left)
      first = model%stretches(1, b - 1)
      if (model%stretches(2, b - 1) < first) first = model%stretches(1, b)
      white = white_values(samples, model, those, left, b, first)
      best = best_shift(white, brought(model, those, b, first - model%stretches(1, b), size(white, 1)), &
        & model%stretches(1, b) - first + 1)
      if (best == 0) cycle
      call shift_blow(model, b, model%stretches(1, b) + best)
      changed = changed + 1
    end do
  end subroutine move_blows

  subroutine drop_blows(samples, false_alarm, model, dropped)
    !! Drop blows that bring nothing of the poles found; one stays.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: dropped
    real(dp), allocatable :: left(:, :), white(:, :), gain(:)
    integer, allocatable :: those(:)
    integer :: b
    dropped = 0
    if (all(model%lines%steady) .or. ubound(model%stretches, 2) == 1) return
    those = telling(samples, model)
    allocate (left(samples%count, size(those)), white(0, 0), gain(0))
    call find_left(samples, model, those, left)
    b = 1
    do while (b <= ubound(model%stretches, 2) .and. ubound(model%stretches, 2) > 1)
      if (model%stretches(2, b) >= model%stretches(1, b)) then   ! else the next blow was moved to the same sample
        white = white_values(samples, model, those, left, b, model%stretches(1, b))
        gain = gains_of(strongest(model, b), white + brought(model, those, b, 0, size(white, 1)))
        b = b + 1
        if (.not. gain(1) < penalty_of_blow(samples, false_alarm, model, size(those))) cycle
        b = b - 1
      end if
      call drop_blow(model, b)
      call find_left(samples, model, those, left)
      dropped = dropped + 1
    end do
  end subroutine drop_blows

  pure real(dp) function penalty_of_blow(samples, false_alarm, model, components) result(penalty)
    !! Of a blow's amplitudes of the lines that tell where it is.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(in) :: model
    integer, intent(in) :: components            !! that are looked at
    penalty = chi_squared(false_alarm/samples%count, 2*components*min(most_lines, count(.not. model%lines%steady)))
  end function penalty_of_blow

  subroutine add_missing_blows(samples, false_alarm, rival, from, model, added)
    !! Add blows where new motion of the poles pays, and takes more off the squares than a rival move.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm, rival
    integer, intent(in) :: from                  !! stretch, 0 before any blow
    type(model_type), intent(inout) :: model
    integer, intent(out) :: added
    real(dp), allocatable :: left(:, :), gain(:)
    integer, allocatable :: those(:)
    real(dp) :: need
    integer :: b, best, first
    added = 0
    if (all(model%lines%steady) .or. allocated(samples%place)) return
    those = telling(samples, model)
    allocate (left(samples%count, size(those)), gain(0))
    call find_left(samples, model, those, left)
    need = max(rival, penalty_of_blow(samples, false_alarm, model, size(those)))
    b = from
    do while (b <= min(most_blows, ubound(model%stretches, 2)))
      first = model%stretches(1, b)
      if (model%stretches(2, b) < first) then
        b = b + 1
        cycle
      end if
      gain = gains_of(strongest(model, b), white_values(samples, model, those, left, b, first))
      best = maxloc(gain, dim=1)
      b = b + 1
      if (gain(best) < need .or. (best < fewest .and. b > 1)) cycle
      call add_blow(model, b - 1, first + best - 1)
      call find_left(samples, model, those, left)
      added = added + 1
    end do
  end subroutine add_missing_blows

  pure function telling(samples, model) result(those)
    !! The components of the noise in which the lines are strongest, as many as tell where the blows are.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, allocatable :: those(:)
    real(dp) :: energy(size(samples%value, 2))
    integer :: c, k
    energy = 0
    do k = 1, size(model%lines)
      associate (line => model%lines(k))
        if (.not. line%steady) energy = energy + sum(abs(white_amplitude(model%noise, line))**2, dim=2) &
          & *life_of(line, 1.0_dp, 1.0_dp*samples%count)
      end associate
    end do
    those = pack([(c, c=1, size(energy))], [(count(energy > energy(c)) < max(1, enough/samples%count), c=1, size(energy))])
  end function telling

  subroutine find_left(samples, model, those, left)
    !! What the lines leave of some components, offset and slope not taken off; 0 where a sample is not valid.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, intent(in) :: those(:)
    real(dp), intent(out), contiguous :: left(:, :)
    type(line_type) :: lines(size(model%lines))
    integer :: k
    lines = model%lines
    do k = 1, size(lines)
      lines(k)%amplitude = mixed_amplitude(model%noise, lines(k)%amplitude)
    end do
    call mix(model%noise, samples%value, those, left)
    call add_lines(model%stretches, at_sensors(lines, those), -1.0_dp, left, model%place)
    call clear_invalid(samples, left)
  end subroutine find_left

  function white_values(samples, model, those, left, b, first) result(white)
    !! What the lines leave from a sample to the end of a stretch, as prediction errors, (samples, components).
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, intent(in) :: those(:)              !! components
    real(dp), intent(in) :: left(:, :)
    integer, intent(in) :: b, first
    real(dp), allocatable :: white(:, :)
    real(dp), dimension(first:model%stretches(2, b)) :: place, weight
    integer :: s, last, n
    last = model%stretches(2, b)
    white = left(first:last, :)
    weight = 1
    if (allocated(samples%valid)) weight = merge(1.0_dp, 0.0_dp, samples%valid(first:last))
    place = [(n, n=first, last)]
    place = place - sum(weight*place)/max(1.0_dp, sum(weight))
    do s = 1, size(white, 2)                     ! an offset and a slope
      white(:, s) = weight*(white(:, s) - sum(weight*white(:, s))/max(1.0_dp, sum(weight)) &
                            - sum(weight*place*white(:, s))/max(1.0_dp, sum(weight*place**2))*place)
    end do
    do s = 1, size(white, 2)
      associate (filter => model%noise%filter(:model%noise%order(those(s)), those(s)))
        call whiten(filter, white(:, s))
        call take_off(missing_among(model%missing, first, last - first + 2 - size(filter), filter), white(:, s))
      end associate
    end do
    white(pack(model%missing, model%missing >= first .and. model%missing <= last) - first + 1, :) = 0
  end function white_values

  pure function brought(model, those, b, from, count) result(motion)
    !! What blow b has brought, `from`, `from` + 1, … samples after it: white motion less what that before it would have become.
    type(model_type), intent(in) :: model
    integer, intent(in) :: those(:)              !! components
    integer, intent(in) :: b, from, count
    real(dp) :: motion(count, size(those))
    complex(dp) :: wave(count)
    type(line_type) :: line
    integer :: k, s, later
    motion = 0
    later = max(1, 1 - from)                     ! the sample of the blow
    do k = 1, size(model%lines)
      line = model%lines(k)
      if (line%steady) cycle
      line%amplitude(:, b + 1) = line%amplitude(:, b + 1) - continued(model, line, b)
      line%amplitude = white_amplitude(model%noise, line)
      call find_wave(line, real(max(from, 0), dp), wave=wave(later:))
      line%courses = [course_type ::]
      call find_wave(line, real(from, dp), wave=wave(:later - 1))
      do s = 1, size(motion, 2)
        associate (a => line%amplitude(those(s), b + 1))
          motion(:, s) = motion(:, s) + a%re*wave%re - a%im*wave%im
        end associate
      end do
    end do
  end function brought

  pure integer function best_shift(white, motion, at) result(shift)
    !! By how many samples a blow is best moved, the motion that it brings going on as it is. It is not put off over rows that tell
    !! nothing, which may be crests that were cut off, nor over a motion that was there in another phase, as that of a beat is: if it
    !! was not, just its own squares fall.
    real(dp), intent(in) :: white(:, :)          !! what is left with this motion from sample `at` on
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
    !! What the motion before blow b would have been at its first sample, (S).
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: line
    integer, intent(in) :: b
    complex(dp) :: amplitude(size(line%amplitude, 1))
    real(dp) :: m
    amplitude = 0
    if (b < 2) return
    m = model%stretches(1, b) - model%stretches(1, b - 1)
    amplitude = line%amplitude(:, b)*carried(line%pole*m + bend_of(line, m))
  end function continued

  elemental complex(dp) function carried(exponent)
    !! The factor of an amplitude from one sample to another; one that grows beyond reason is cut off.
    complex(dp), intent(in) :: exponent
    carried = exp(cmplx(max(-most_carried, min(most_carried, exponent%re)), exponent%im, dp))
  end function carried

  pure function strongest(model, b) result(poles)
    !! The poles of the lines of most energy in a stretch.
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
    !! T of white values.
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
    !! R⁻¹ of the scalar products RᵀR of real and negative imaginary parts of exponentials x, of which Σ x_k x_l and Σ x_k x_l* are known.
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
    !! Join a stretch with the one before, whose lines go on unless it is empty.
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
    !! Leave these stretches.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: others(0:)
    integer :: stretches(2, 0:ubound(others, 1))
    stretches = model%stretches(:, others)
    deallocate (model%stretches, model%trend)
    allocate (model%stretches(2, 0:ubound(stretches, 2)), source=stretches)
    allocate (model%trend(2, size(model%white, 2), 0:ubound(stretches, 2)), source=0.0_dp)
  end subroutine choose

  pure subroutine shift_blow(model, b, first)
    !! Move a blow to a sample.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: b, first
    real(dp) :: m
    integer :: k
    m = first - model%stretches(1, b)
    model%stretches(1, b) = first
    model%stretches(2, b - 1) = first - 1
    do k = 1, size(model%lines)
      associate (line => model%lines(k))
        line%amplitude(:, b + 1) = line%amplitude(:, b + 1)*carried(line%pole*m)
      end associate
    end do
  end subroutine shift_blow

  pure subroutine add_blow(model, b, first)
    !! Part a stretch at a sample.
    type(model_type), intent(inout) :: model
    integer, intent(in) :: b, first
    integer :: k, i, last
    real(dp) :: m
    last = model%stretches(2, b)
    m = first - model%stretches(1, b)
    do k = 1, size(model%lines)
      associate (line => model%lines(k))
        line%amplitude = line%amplitude(:, [(i, i=1, b + 1), b + 1, (i, i=b + 2, size(line%amplitude, 2))])
        line%amplitude(:, b + 2) = line%amplitude(:, b + 1)*carried(line%pole*m + bend_of(line, m))
      end associate
    end do
    call choose(model, [(i, i=0, b), b, (i, i=b + 1, ubound(model%stretches, 2))])
    model%stretches(2, b) = first - 1
    model%stretches(:, b + 1) = [first, last]
  end subroutine add_blow

end module bw_blow_moves
