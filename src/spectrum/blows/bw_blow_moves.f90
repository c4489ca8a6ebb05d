module bw_blow_moves
  !! Blows are moved to where the lines place them, dropped if they gain less than their penalty, and added where they are missing.
  use bw_blow_gains, only: gain_of_jump, gains_before, gains_from, is_sudden
  use bw_blow_shift, only: best_shift, fewest
  use bw_cost, only: penalty_of_place
  use bw_kinds, only: dp
  use bw_line, only: course_type, find_wave, life_of, line_type
  use bw_missing_samples, only: missing_among, project_out_missing
  use bw_model, only: add_lines, at_sensors, clear_missing, model_type
  use bw_noise, only: mix, mixed_amplitude, noise_type, white_amplitude, whiten
  use bw_penalty, only: chi_squared
  use bw_samples, only: first_valid, samples_type
  use bw_stretches, only: add_blow, continued, drop_blow, shift_blow
  implicit none (type, external)
  private
  public :: add_missing_blows, drop_blows, drop_gradual_blows, move_blows

  integer, parameter :: most_lines = 8           !! the strongest, which locate a blow
  integer, parameter :: enough = 2**21           !! tuned: numbers that are enough to locate a blow of known poles
  integer, parameter :: most_blows = 32
  real(dp), parameter :: comparable = 0.5_dp     !! of the strongest missing blow's gain: such blows are added together

contains

  subroutine move_blows(samples, false_alarm, model, changed)
    !! Move blows; afterwards the model has to be renewed and refitted.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(model_type), intent(inout) :: model
    integer, intent(out) :: changed              !! number of moves
    real(dp), allocatable :: residual(:, :), white(:, :)
    integer, allocatable :: chosen(:)
    integer :: b, best, first, start
    changed = 0
    if (all(model%lines%steady) .or. allocated(samples%place)) return  ! uneven samples do not predict each other
    chosen = locating_components(samples, model)
    allocate (residual(samples%count, size(chosen)), white(0, 0))
    do b = 1, ubound(model%stretches, 2)
      call find_residual(samples, model, chosen, residual)
      first = model%stretches(1, b - 1)
      if (model%stretches(2, b - 1) < first) first = model%stretches(1, b)
      white = white_values(model, chosen, residual, b, first)
      start = 1
      if (b == 1) start = first_valid(samples) - first + 1
      best = best_shift(model, penalty_of_place(samples, false_alarm), start, chosen, first, white, &
        & added_motion(model, chosen, b, first - model%stretches(1, b), size(white, 1)), model%stretches(1, b) - first + 1)
      if (best == 0) cycle
      call shift_blow(model, b, model%stretches(1, b) + best)
      changed = changed + 1
    end do
    do b = ubound(model%stretches, 2) - 1, 1, -1
      if (model%stretches(2, b) < model%stretches(1, b)) call drop_blow(model, b)  ! the next was moved to the same sample
    end do
  end subroutine move_blows

  subroutine drop_blows(samples, false_alarm, early, penalties, model, dropped)
    !! Drop blows that gain less than so many penalties with the poles found; one is kept.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    integer, intent(in) :: early                 !! samples by which the next blow may come earlier
    real(dp), intent(in) :: penalties
    type(model_type), intent(inout) :: model
    integer, intent(out) :: dropped
    real(dp), allocatable :: residual(:, :), white(:, :)
    integer, allocatable :: chosen(:)
    integer :: b, n, last, before
    dropped = 0
    if (all(model%lines%steady) .or. ubound(model%stretches, 2) == 1 .or. allocated(samples%place)) return
    chosen = locating_components(samples, model)
    allocate (residual(samples%count, size(chosen)), white(0, 0))
    call find_residual(samples, model, chosen, residual)
    b = 1
    do while (b <= ubound(model%stretches, 2) .and. ubound(model%stretches, 2) > 1)
      before = 0                                 ! samples within the motion before
      if (b > 1) before = model%stretches(2, b - 1) - model%stretches(1, b - 1) + 1
      white = white_values(model, chosen, residual, b, model%stretches(1, b) - before)
      n = size(white, 1) - before
      call continue_motion(model%noise, chosen, before + 1, added_motion(model, chosen, b, -before, size(white, 1)), white)
      last = before + n
      if (b < ubound(model%stretches, 2)) last = before + max((n + 1)/2, n - early)
      b = b + 1
      if (gain_of_jump(strongest(model, b - 1), white(:last, :), before) >= &
        & penalties*penalty_of_blow(samples, false_alarm, model, size(chosen))) cycle
      b = b - 1
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
    !! Divide stretches by blows where new motion with the poles gains more than the penalty, beginning with the strongest. The
    !! amplitudes before such a blow change, too, as they were fitted to the whole stretch.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    integer, intent(in) :: from                  !! first stretch to search; 0 is before any blow
    type(model_type), intent(inout) :: model
    integer, intent(out) :: added
    real(dp), allocatable :: residual(:, :), white(:, :), gain(:)
    integer, allocatable :: chosen(:)
    real(dp) :: most(0:ubound(model%stretches, 2))   !! that a blow within each stretch gains
    integer :: at(0:ubound(most, 1)), b
    added = 0
    if (all(model%lines%steady) .or. allocated(samples%place)) return
    chosen = locating_components(samples, model)
    allocate (residual(samples%count, size(chosen)), white(0, 0), gain(0))
    call find_residual(samples, model, chosen, residual)
    most = 0
    do b = from, min(most_blows, ubound(most, 1))
      if (model%stretches(2, b) < model%stretches(1, b)) cycle
      white = white_values(model, chosen, residual, b, model%stretches(1, b))
      gain = gains_from(strongest(model, b), white)
      if (b > 0) then
        gain = gain + gains_before(strongest(model, b), white)
        gain(:min(fewest, size(gain))) = 0
      end if
      most(b) = maxval(gain)
      at(b) = model%stretches(1, b) + maxloc(gain, dim=1) - 1
    end do
    do b = ubound(most, 1), from, -1
      if (most(b) < max(penalty_of_blow(samples, false_alarm, model, size(chosen)), comparable*maxval(most))) cycle
      call add_blow(model, b, at(b))
      added = added + 1
    end do
  end subroutine add_missing_blows

  subroutine drop_gradual_blows(samples, false_alarm, before, model)
    !! Move new blows to where the lines fitted with them place them, and drop those at which the amplitudes change gradually.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    integer, intent(in) :: before(:)             !! samples of the blows that were there before
    type(model_type), intent(inout) :: model
    real(dp), allocatable :: residual(:, :), white(:, :), motion(:, :)
    integer, allocatable :: chosen(:)
    integer :: b, first, n, shift
    chosen = locating_components(samples, model)
    allocate (residual(samples%count, size(chosen)), white(0, 0), motion(0, 0))
    do b = ubound(model%stretches, 2), 2, -1
      first = model%stretches(1, b - 1)
      if (any(before == model%stretches(1, b)) .or. model%stretches(2, b - 1) < first) cycle
      call find_residual(samples, model, chosen, residual)
      white = white_values(model, chosen, residual, b, first)
      motion = added_motion(model, chosen, b, first - model%stretches(1, b), size(white, 1))
      n = model%stretches(1, b) - first + 1      ! the blow's sample among these
      shift = best_shift(model, penalty_of_place(samples, false_alarm), 1, chosen, first, white, motion, n)
      call continue_motion(model%noise, chosen, n, motion, white)
      if (is_sudden(strongest(model, b), white, n + shift, penalty_of_blow(samples, false_alarm, model, size(chosen)))) then
        if (shift /= 0) call shift_blow(model, b, model%stretches(1, b) + shift)
      else
        call drop_blow(model, b)
      end if
    end do
  end subroutine drop_gradual_blows

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
    call clear_missing(model%missing(chosen), residual)
  end subroutine find_residual

  function white_values(model, chosen, residual, b, first) result(white)
    !! The prediction errors of the residual from a sample to the end of a stretch, (samples, components); 0 where a sample is
    !! missing.
    type(model_type), intent(in) :: model
    integer, intent(in) :: chosen(:)             !! components
    real(dp), intent(in) :: residual(:, :)
    integer, intent(in) :: b, first
    real(dp), allocatable :: white(:, :)
    real(dp) :: weight(first:model%stretches(2, b))
    integer, allocatable :: gaps(:)
    integer :: s, last
    last = model%stretches(2, b)
    white = residual(first:last, :)
    do s = 1, size(white, 2)
      associate (missing => model%missing(chosen(s))%place)
        gaps = pack(missing, missing >= first .and. missing <= last)
      end associate
      weight = 1
      weight(gaps) = 0
      call detrend(weight, white(:, s))
      associate (filter => model%noise%filter(:model%noise%order(chosen(s)), chosen(s)))
        call whiten(filter, white(:, s))
        call project_out_missing(missing_among(gaps, first, last - first + 2 - size(filter), filter), white(:, s))
      end associate
      white(gaps - first + 1, s) = 0
    end do
  end function white_values

  pure subroutine continue_motion(noise, chosen, at, motion, white)
    !! Change prediction errors as if the motion before a blow continued, except where a sample is missing.
    type(noise_type), intent(in) :: noise
    integer, intent(in) :: chosen(:)             !! components
    integer, intent(in) :: at                    !! the blow's sample
    real(dp), intent(in) :: motion(:, :)         !! that the blow adds
    real(dp), intent(inout) :: white(:, :)
    real(dp) :: added(size(motion, 1))
    integer :: s
    do s = 1, size(white, 2)
      added = motion(:, s)
      added(:at - 1) = 0
      call whiten(noise%filter(:noise%order(chosen(s)), chosen(s)), added)
      where (abs(white(:, s)) > 0) white(:, s) = white(:, s) + added
    end do
  end subroutine continue_motion

  pure subroutine detrend(weight, values)
    !! Subtract an offset and a slope.
    real(dp), intent(in) :: weight(:)
    real(dp), intent(inout) :: values(:)
    real(dp) :: place(size(weight))
    integer :: n
    place = [(n, n=1, size(weight))]
    place = place - sum(weight*place)/max(1.0_dp, sum(weight))
    values = weight*(values - sum(weight*values)/max(1.0_dp, sum(weight)) &
      & - sum(weight*place*values)/max(1.0_dp, sum(weight*place**2))*place)
  end subroutine detrend

  pure function added_motion(model, chosen, b, from, count) result(motion)
    !! The motion that blow b adds, `from`, `from` + 1, … samples after it: new motion minus the continued earlier one.
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
      line%amplitude = mixed_amplitude(model%noise, line%amplitude)
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

end module bw_blow_moves
