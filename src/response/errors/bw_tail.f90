module bw_tail
  !! Sums over the modes of a struck beam that are not summed: how far they move, without their phases (bw_coherence).
  !!
  !! The sums run over windows of mode numbers that double in length, each sampled by runs of neighbouring modes, since the
  !! shapes at a point repeat every few modes. The runs lie as the nodes of a Lobatto rule, the ends of the window among them,
  !! and integrate cubics over it.
  use bw_amplitudes, only: add_amplitudes, moving_modes, run_length
  use bw_coherence, only: deviation_type, observation_type, pinned
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_modal_flow, only: slow_exponent
  use bw_mode_set, only: mode_set, mode_source
  use bw_monitor, only: stops
  use bw_reach, only: damped_reach, turns, undamped_reaches
  implicit none (type, external)
  private
  public :: add_modes, add_tail, may_agree, sample_window

  real(dp), parameter :: pi = acos(-1.0_dp)
  integer, parameter :: runs = 4                  !! of neighbours that are sampled of a window
  integer, parameter :: short_runs(2) = [12, 8]   !! of the first window and of others, where modes take long and sections are even
  real(dp), parameter :: nodes(runs) = [-1.0_dp, -sqrt(0.2_dp), sqrt(0.2_dp), 1.0_dp]
  integer, parameter :: part = 1024               !! modes whose shapes are held at a time
  real(dp), parameter :: tells = 0.25_dp
    !! a window of modes, as far as none is damped, that adds less than this tells what those beyond it add where it is known how
    !! amplitudes fall
  integer, parameter :: usual_ratio = 2, wide_ratio = 4   !! of the last mode of a window to its first, elsewhere and there
  real(dp), parameter, public :: negligible = 1.0e-3_dp   !! a window that adds less than this ends the sum
  real(dp), parameter :: velocities_end = 0.03_dp
    !! the same of ΣA² of velocities, whose Σ|A| has no bound: after some thirty times the modes
  real(dp), parameter :: unseen = 0.01_dp
    !! of a sampled window: the rule is off by less in the steepest, and what ends the sum is less again

contains

  subroutine add_tail(count, source, force, seen, sums, shown)
    !! The continuum's modes from `count` + 1 on.
    integer, intent(in) :: count
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    type(observation_type), intent(in) :: seen
    type(deviation_type), intent(inout) :: sums(:)
    class(mode_source), intent(in), optional :: shown   !! modes that they have turned into, number by number
    type(deviation_type) :: before(size(seen%points)), octave(size(seen%points))
    logical :: at_struck(size(seen%points))
    real(dp) :: rising
    integer :: first, last
    if (source%gamma == 0.0_dp .or. force == 0.0_dp) return
    rising = falls_beyond(source%gamma, abs(source%struck_at - seen%points))
    at_struck = seen%points == source%struck_at .and. .not. source%uniform .and. .not. present(shown) &
      .and. pi*source%highest*source%gamma > pinned
    first = count + 1
    do while (first <= source%highest)
      last = window_end(first, source, seen%stretch%start)
      before = sums
      call add_window(source, force, first, last, first > count + 1, seen, sums, shown)
      if (stops(source%monitor)) return
      if (first > rising .and. adds_nothing(before, sums, seen%velocity, negligible)) exit
      if (first > rising .and. source%decay > 0.0_dp .and. .not. allocated(source%damping) &
          .and. .not. (seen%velocity .and. source%quadratic)) then
        if (adds_nothing(before, sums, seen%velocity, tells)) then
          call extrapolate(source%decay, real(wide_ratio, dp), less(sums, before), seen%velocity, at_struck, sums)
          return
        end if
      end if
      first = last + 1
    end do
    if (source%decay > 0.0_dp .and. first > source%highest) then
      octave = deviation_type()
      call add_window(source, force, source%highest/2 + 1, source%highest, .true., seen, octave, shown)
      call extrapolate(source%decay, real(usual_ratio, dp), octave, seen%velocity, at_struck, sums)
    end if
  end subroutine add_tail

  pure real(dp) function falls_beyond(gamma, distance) result(number)
    !! The mode beyond which amplitudes are sure to fall: those of a light mass are level before, and near the struck place shapes
    !! rise from Φ(ξ₀).
    real(dp), intent(in) :: gamma
    real(dp), intent(in) :: distance(:)           !! of the points from there
    real(dp), parameter :: risen = 3.0_dp         ! αd
    real(dp) :: nearest
    nearest = minval(distance, mask=distance > 0.0_dp)           ! huge where there is none
    number = max(1.0_dp/gamma, (risen/pi)/nearest)
  end function falls_beyond

  elemental type(deviation_type) function less(sums, before) result(octave)
    !! What the last window has added.
    type(deviation_type), intent(in) :: sums, before
    octave = sums
    octave%magnitude = sums%magnitude - before%magnitude
    octave%square = sums%square - before%square
    octave%agreeing = sums%agreeing - before%agreeing
    octave%paired = sums%paired - before%paired
  end function less

  pure logical function adds_nothing(before, sums, velocity, nothing)
    !! A window that adds so little that those beyond it need not be looked at.
    type(deviation_type), intent(in) :: before(:) !! the sums without this window, (points)
    type(deviation_type), intent(in) :: sums(:)
    logical, intent(in) :: velocity
    real(dp), intent(in) :: nothing               !! of the sum
    adds_nothing = all(sums%growing - before%growing <= negligible*sums%growing)
    if (velocity) then
      adds_nothing = adds_nothing .and. all(sums%square - before%square <= max(velocities_end, nothing)*sums%square)
    else
      adds_nothing = adds_nothing .and. all(sums%magnitude - before%magnitude <= nothing*sums%magnitude)
    end if
  end function adds_nothing

  integer function window_end(first, source, elapsed) result(last)
    !! Twice the first mode, four times where it is known how amplitudes fall; where damping has left much less of the last than
    !! of the first, no further than all modes are looked at: a few runs of them would not see where the others end.
    integer, intent(in) :: first
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: elapsed               !! since all modes began
    real(dp), parameter :: steepest = 0.5_dp      ! nepers
    real(dp), parameter :: nothing = 60.0_dp      ! nepers, of which nothing is left: windows may be as wide as they like
    class(mode_set), allocatable :: ends
    type(dd) :: exponent(2)
    last = min(merge(wide_ratio, usual_ratio, source%decay > 0.0_dp .and. .not. allocated(source%damping)) &
               *max(first, run_length), source%highest)
    if (.not. allocated(source%damping)) return
    do while (last - first >= 2*runs*run_length)
      call source%find([first, last], ends)
      exponent = slow_exponent(ends%beta_squared, ends%damping)
      if (abs(exponent(1)%hi - exponent(2)%hi)*elapsed <= steepest .or. -exponent(1)%hi*elapsed > nothing) exit
      last = first + (last - first)/2
    end do
  end function window_end

  subroutine add_window(source, force, first, last, later, seen, sums, shown)
    !! Modes `first` … `last`: of undamped ones no more is found than is needed.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    integer, intent(in) :: first, last
    logical, intent(in) :: later                  !! another window was before this one
    type(observation_type), intent(in) :: seen
    type(deviation_type), intent(inout) :: sums(:)
    class(mode_source), intent(in), optional :: shown
    class(mode_set), allocatable :: modes, others
    integer, allocatable :: number(:)
    real(dp), allocatable :: weight(:)
    logical :: sparse
    integer :: run
    sparse = source%quickly < huge(1)
    run = run_length
    if (source%quadratic .and. .not. (seen%velocity .or. present(shown) .or. allocated(source%damping))) &
      run = merge(short_runs(merge(2, 1, later)), run, sparse)
    call sample_window(first, last, number, weight, sparse, run)
    if (present(shown)) then
      call source%find(number, modes)
      call shown%find(number, others)
      call add_modes(others, force*modes%struck/modes%modal_mass, seen, weight, sums, may_pair(source, weight))
    else if (allocated(source%damping)) then
      call source%find(number, modes)
      call add_modes(modes, force*modes%struck/modes%modal_mass, seen, weight, sums, may_pair(source, weight))
    else
      call add_terms(source, force, number, run, seen, weight, sums)
    end if
  end subroutine add_window

  subroutine add_terms(source, force, number, run, seen, weight, sums)
    !! Undamped modes.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    integer, intent(in) :: number(:)
    integer, intent(in) :: run                    !! neighbours among them
    type(observation_type), intent(in) :: seen
    real(dp), intent(in) :: weight(:)
    type(deviation_type), intent(inout) :: sums(:)
    type(moving_modes) :: moving
    type(dd) :: beta(size(number))
    real(dp) :: drive(size(number))
    real(dp) :: shapes(size(number), size(seen%points))
    if (may_pair(source, weight)) then
      allocate (moving%mass(size(number)))
      call source%terms(number, seen%points, beta=beta, drive=drive, shapes=shapes, mass=moving%mass)
    else
      call source%terms(number, seen%points, beta=beta, drive=drive, shapes=shapes)
    end if
    moving%reach = undamped_reaches(beta%hi, seen%stretch%end, seen%velocity)*abs(force*drive)
    moving%alpha = pi*number
    moving%tip = abs(drive)
    moving%swings = beta%hi > 0.0_dp
    moving%agrees = may_agree(moving%alpha, source%agree_from, seen%velocity)
    moving%struck_at = source%struck_at
    moving%uniform = source%uniform
    moving%root_power = source%root_power
    moving%run = run
    call add_amplitudes(moving, shapes, seen, weight, sums)
  end subroutine add_terms

  pure logical function may_pair(source, weight)
    !! Whether modes that are not looked at may be pairs of parts of the beam (`add_pairs`).
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: weight(:)             !! of those that are looked at
    may_pair = .not. source%uniform .and. any(weight > 1.0_dp)
  end function may_pair

  elemental subroutine extrapolate(decay_of_displacement, ratio, window, velocity, at_struck, sums)
    !! The modes beyond the highest that were looked at, as the last window of those tells. Velocities fall as 1/k, whose
    !! sum has no bound: their magnitudes then say nothing. But a mass that stays where it struck holds the beam there, so that
    !! Φ(ξ₀) falls as 1/k, and there everything falls by one power more.
    real(dp), intent(in) :: decay_of_displacement
    real(dp), intent(in) :: ratio                 !! of its last mode to its first
    type(deviation_type), intent(in) :: window
    logical, intent(in) :: velocity
    logical, intent(in) :: at_struck              !! the point is that place, of any beam but the paper's
    type(deviation_type), intent(inout) :: sums
    real(dp), parameter :: no_bound = 1.0e3_dp
    real(dp) :: decay, times
    decay = merge(1.0_dp, decay_of_displacement, velocity)
    if (at_struck) decay = decay + 1.0_dp
    times = no_bound
    if (decay > 1.0_dp) times = 1.0_dp/(ratio**(decay - 1.0_dp) - 1.0_dp)
    sums%square = sums%square + window%square/(ratio**(2.0_dp*decay - 1.0_dp) - 1.0_dp)
    sums%magnitude = sums%magnitude + times*window%magnitude
    sums%agreeing = sums%agreeing + times*window%agreeing
    sums%paired = sums%paired + window%paired/(ratio**decay - 1.0_dp)
    sums%largest = max(sums%largest, window%largest)
    sums%passing = max(sums%passing, window%passing)
    sums%alpha = min(sums%alpha, window%alpha)
  end subroutine extrapolate

  pure subroutine sample_window(first, last, number, weight, sparse, run)
    !! All mode numbers of a short window, runs of neighbours of a long one.
    integer, intent(in) :: first, last
    integer, allocatable, intent(out) :: number(:)
    real(dp), allocatable, intent(out) :: weight(:)        !! for how many modes each stands
    logical, intent(in), optional :: sparse                !! modes take so long to find that no more are asked for than a few runs
    integer, intent(in), optional :: run                   !! modes of a run; absent: `run_length`
    real(dp) :: width, outermost, outer, each(runs)
    integer :: i, k, start, length, most
    length = run_length
    if (present(run)) length = run
    most = 2*runs*length
    if (present(sparse)) most = merge(3*runs*length/2, most, sparse)         ! from here on runs do not overlap
    if (last - first + 1 <= most) then
      number = [(k, k=first, last)]
      weight = spread(1.0_dp, 1, size(number))
      return
    end if
    allocate (number(runs*length), weight(runs*length))
    width = last - first + 1
    outermost = 1.0_dp - length/width            ! middle of the last run, of a window from −1 to 1
    outer = (1.0_dp/3.0_dp - 0.2_dp*outermost**2)/(0.8_dp*outermost**2)
    each = 0.5_dp*[outer, 1.0_dp - outer, 1.0_dp - outer, outer]*(1.0_dp + unseen)*width/length
    do i = 1, runs
      start = first + nint(0.5_dp*(1.0_dp + nodes(i))*(width - length))
      number((i - 1)*length + 1:i*length) = [(k, k=start, start + length - 1)]
      weight((i - 1)*length + 1:i*length) = each(i)
    end do
  end subroutine sample_window

  pure subroutine add_modes(modes, rate, seen, weight, sums, pairs)
    !! Amplitudes of modes that start with velocity `rate`.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: rate(:)               !! (modes)
    type(observation_type), intent(in) :: seen
    real(dp), intent(in) :: weight(:)             !! for how many modes each stands, (modes)
    type(deviation_type), intent(inout) :: sums(:)
    logical, intent(in), optional :: pairs        !! modes between them may be pairs of parts of the beam; absent: there are none
    type(moving_modes) :: moving
    integer :: first, last
    moving%struck_at = modes%struck_at
    moving%uniform = modes%uniform
    moving%root_power = modes%root_power
    do first = 1, modes%count, part
      last = min(first + part - 1, modes%count)
      associate (square => modes%beta_squared(first:last))
        moving%alpha = modes%alpha(first:last)
        moving%tip = abs(modes%struck(first:last))
        moving%agrees = may_agree(moving%alpha, modes%agree_from, seen%velocity)
        if (allocated(modes%damping)) then
          moving%swings = turns(square, modes%damping(first:last))
          moving%reach = abs(rate(first:last))*damped_reach(square, modes%damping(first:last), seen%stretch, seen%velocity)
        else
          moving%swings = square%hi > 0.0_dp
          moving%reach = abs(rate(first:last)) &
            *undamped_reaches(sign(sqrt(abs(square%hi)), square%hi), seen%stretch%end, seen%velocity)
        end if
      end associate
      if (present(pairs)) then
        if (pairs) moving%mass = modes%modal_mass(first:last)
      end if
      call add_amplitudes(moving, modes%some_shapes(first, last, seen%points), seen, weight(first:last), sums)
    end do
  end subroutine add_modes

  elemental logical function may_agree(alpha, from, velocity)
    !! Bending waves do so too rarely to say it of every velocity.
    real(dp), intent(in) :: alpha
    real(dp), intent(in) :: from                  !! `agree_from`
    logical, intent(in) :: velocity
    may_agree = alpha >= from .and. .not. (velocity .and. from == 0.0_dp)
  end function may_agree

end module bw_tail
