module bw_blow_moves
  !! Blows are moved to where the lines place them, dropped if they gain less than their penalty, and added where they are missing.
  use bw_blow_gains, only: gains_before, gains_from, is_sudden
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
  integer, parameter, public :: fewest = 16              !! fewest samples between blows
  integer, parameter :: near = 64                !! samples by which a blow may be wrong if found from prediction errors
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
    !! Drop blows that add no significant motion with the poles found; one is kept. What the added motion gains over amplitudes that
    !! do not change is less, as these would be fitted to both stretches.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: dropped
    real(dp), allocatable :: residual(:, :), white(:, :), gain(:)
    integer, allocatable :: chosen(:)
    integer :: b, n
    dropped = 0
    if (all(model%lines%steady) .or. ubound(model%stretches, 2) == 1) return
    chosen = locating_components(samples, model)
    allocate (residual(samples%count, size(chosen)), white(0, 0), gain(0))
    call find_residual(samples, model, chosen, residual)
    b = 1
    do while (b <= ubound(model%stretches, 2) .and. ubound(model%stretches, 2) > 1)
      if (model%stretches(2, b) >= model%stretches(1, b)) then   ! otherwise the next blow was moved to the same sample
        white = white_values(samples, model, chosen, residual, b, model%stretches(1, b))
        white = white + added_motion(model, chosen, b, 0, size(white, 1))
        call detrend([(1.0_dp, n=1, size(white, 1))], white)  ! an offset may have been fitted instead of a slow motion
        n = size(white, 1)                         ! the next blow may come earlier
        if (b < ubound(model%stretches, 2)) white = white(:max((n + 1)/2, n - near), :)
        gain = gains_from(strongest(model, b), white)*share_before(model, b)
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

  subroutine add_missing_blows(samples, false_alarm, from, model, added)
    !! Divide stretches by blows where new motion with the poles gains more than the penalty. The amplitudes before such a blow
    !! change, too, as they were fitted to the whole stretch.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    integer, intent(in) :: from                  !! first stretch to search; 0 is before any blow
    type(model_type), intent(inout) :: model
    integer, intent(out) :: added
    real(dp), allocatable :: residual(:, :), white(:, :), gain(:)
    integer, allocatable :: chosen(:)
    real(dp) :: penalty
    integer :: b
    added = 0
    if (all(model%lines%steady) .or. allocated(samples%place)) return
    chosen = locating_components(samples, model)
    allocate (residual(samples%count, size(chosen)), white(0, 0), gain(0))
    call find_residual(samples, model, chosen, residual)
    penalty = penalty_of_blow(samples, false_alarm, model, size(chosen))
    do b = min(most_blows, ubound(model%stretches, 2)), from, -1
      if (model%stretches(2, b) < model%stretches(1, b)) cycle
      white = white_values(samples, model, chosen, residual, b, model%stretches(1, b))
      gain = gains_from(strongest(model, b), white)
      if (b > 0) then
        gain = gain + gains_before(strongest(model, b), white)
        gain(:min(fewest, size(gain))) = 0
      end if
      if (maxval(gain) < penalty) cycle
      if (b > 0) then
        if (.not. is_sudden(strongest(model, b), white, maxloc(gain, dim=1), penalty)) cycle
      end if
      call add_blow(model, b, model%stretches(1, b) + maxloc(gain, dim=1) - 1)
      added = added + 1
    end do
  end subroutine add_missing_blows

  pure real(dp) function share_before(model, b) result(share)
    !! The part of the energy of the lines from blow b − 1 on that comes before blow b, if they lived to the end of stretch b; 1 for
    !! the first blow.
    type(model_type), intent(in) :: model
    integer, intent(in) :: b
    real(dp) :: energy(2), steps(2)              !! up to blow b, and in all
    integer :: k
    share = 1
    if (b < 2) return
    energy = 0
    steps = model%stretches([1, 2], b) - model%stretches(1, b - 1) + [0, 1]
    do k = 1, size(model%lines)
      associate (line => model%lines(k), white => white_amplitude(model%noise, model%lines(k)))
        if (line%steady) cycle
        if (abs(line%pole%re)*steps(2) > 1.0e-6_dp) then
          energy = energy + sum(abs(white(:, b))**2)*(1 - exp(2*line%pole%re*steps))/(1 - exp(2*line%pole%re))
        else
          energy = energy + sum(abs(white(:, b))**2)*steps
        end if
      end associate
    end do
    if (energy(2) > 0) share = energy(1)/energy(2)
  end function share_before

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
    real(dp) :: weight(first:model%stretches(2, b))
    integer :: s, last
    last = model%stretches(2, b)
    white = residual(first:last, :)
    weight = 1
    if (allocated(samples%valid)) weight = merge(1.0_dp, 0.0_dp, samples%valid(first:last))
    call detrend(weight, white)
    do s = 1, size(white, 2)
      associate (filter => model%noise%filter(:model%noise%order(chosen(s)), chosen(s)))
        call whiten(filter, white(:, s))
        call project_out_missing(missing_among(model%missing, first, last - first + 2 - size(filter), filter), white(:, s))
      end associate
    end do
    white(pack(model%missing, model%missing >= first .and. model%missing <= last) - first + 1, :) = 0
  end function white_values

  pure subroutine detrend(weight, values)
    !! Subtract an offset and a slope.
    real(dp), intent(in) :: weight(:)
    real(dp), intent(inout) :: values(:, :)
    real(dp) :: place(size(weight))
    integer :: s, n
    place = [(n, n=1, size(weight))]
    place = place - sum(weight*place)/max(1.0_dp, sum(weight))
    do s = 1, size(values, 2)
      values(:, s) = weight*(values(:, s) - sum(weight*values(:, s))/max(1.0_dp, sum(weight)) &
                             - sum(weight*place*values(:, s))/max(1.0_dp, sum(weight*place**2))*place)
    end do
  end subroutine detrend

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
