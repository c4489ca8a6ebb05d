module bw_release_error
  !! How far the motion after a release is from that of infinitely many modes.
  !!
  !! The release hands the motion of short waves on to modes of nearly the same number, which then move as far as those of
  !! beam and mass did. And the force between beam and mass ends of a sudden: what it held bent moves on in all modes of the
  !! beam alone, with displacements that fall as k⁻⁴ only. A motion that has grown leaves more in this way than the blow did.
  !!
  !! With counts of modes the mass leaves with the velocity that these give the tip; what they lack of it the beam keeps in
  !! all its modes, low ones too. That is why this error falls only as n^(−3/2). The state of four times the modes just after
  !! the release is found in the same way, and the amplitudes of its difference add up as those of bw_tail do. Where there are
  !! no more modes, what the tip's velocity lacks is judged without them (bw_tip_remainder).
  use bw_amplitudes, only: add_amplitudes, moving_modes
  use bw_coherence, only: combined, deviation_type, largest, observation_type, path_to, path_type
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_mode_set, only: first_numbers, mode_set, mode_source, mode_sources
  use bw_monitor, only: monitor_type, stops
  use bw_reach, only: amplitude_of, turns
  use bw_release, only: tip_remainder
  use bw_segment, only: move, segment_type
  use bw_tail, only: add_tail, may_agree, negligible, sample_window
  use bw_tip_remainder, only: find_tip_remainder
  implicit none (type, external)
  private
  public :: blow_reach, release_error, release_tail

  integer, parameter :: fewest = 256              !! modes of the better state
  integer, parameter :: most_more = 6000          !! at most so many more: the projection takes the square of their number
  real(dp), parameter :: margin = 1.25_dp         !! empirical: for what the better state lacks itself
  real(dp), parameter :: tip_share = 0.05_dp      !! of the tip's velocity that a sum lacks; so well is the better state's known
  integer, parameter :: tip_times = 64            !! by at most so many times its modes; light masses would ask for far more

contains

  function release_tail(count, sources, force, released, seen) result(error)
    !! Estimates of what the modes of the beam alone beyond the first `count` add after the release, (points), where
    !! those start with all that the tip's velocity gives them (bw_tip_remainder).
    integer, intent(in) :: count
    type(mode_sources), intent(in) :: sources
    real(dp), intent(in) :: force                 !! the continuum's modal velocities are force·Φ_k(1)/M_k
    type(dd), intent(in) :: released              !! time of the release, l²/h
    type(observation_type), intent(in) :: seen    !! after it, times from the release
    real(dp) :: error(size(seen%points))
    class(mode_set), allocatable :: low
    real(dp) :: q(count), rate(count)
    call sources%loaded%find(first_numbers(count), low)
    q = 0.0_dp
    rate = force*low%struck/low%modal_mass
    call move(low, released, q, rate)
    error = blow_left(count, sources, force, released, seen) + force_left(low, q, rate, sources%free, seen)
  end function release_tail

  function blow_left(count, sources, force, released, seen) result(error)
    !! What the blow gave the modes beyond the first `count`, handed on number by number, (points).
    integer, intent(in) :: count
    type(mode_sources), intent(in) :: sources
    real(dp), intent(in) :: force
    type(dd), intent(in) :: released
    type(observation_type), intent(in) :: seen
    real(dp) :: error(size(seen%points))
    type(deviation_type) :: sums(size(seen%points))
    type(observation_type) :: since_blow
    since_blow = seen
    since_blow%stretch%start = released%hi + seen%stretch%start
    since_blow%stretch%end = released%hi + seen%stretch%end
    call add_tail(count, sources%loaded, force, since_blow, sums, shown=sources%free)
    error = largest(sums, paths(sources%free, seen), since_blow%stretch, sources%free%quadratic)
  end function blow_left

  function force_left(low, q, rate, source, seen) result(error)
    !! What the modes of the beam alone beyond the first of beam and mass get from these, (points).
    class(mode_set), intent(in) :: low            !! of beam and mass
    real(dp), intent(in) :: q(:), rate(:)         !! their state when the mass leaves
    class(mode_source), intent(in) :: source      !! of the beam alone
    type(observation_type), intent(in) :: seen
    real(dp) :: error(size(seen%points))
    class(mode_set), allocatable :: free
    type(deviation_type), dimension(size(seen%points)) :: sums, before
    integer, allocatable :: number(:)
    real(dp), allocatable :: weight(:)
    integer :: first, last
    first = low%count + 1
    do while (first <= source%highest)
      last = min(2*first, source%highest)
      before = sums
      call sample_window(first, last, number, weight)
      call source%find(number, free)
      call add_state(free, free%overlap_far_below(low, q, source%monitor)/free%modal_mass, &
                     free%overlap_far_below(low, rate, source%monitor)/free%modal_mass, seen, weight, sums)
      if (stops(source%monitor)) exit
      if (all(sums%magnitude + sums%growing - before%magnitude - before%growing &
              <= negligible*(sums%magnitude + sums%growing))) exit
      first = last + 1
    end do
    error = largest(sums, paths(source, seen), seen%stretch, source%quadratic)
  end function force_left

  function blow_reach(free, seen, quadratic) result(reach)
    !! How far a blow of 1 at its tip drives the beam alone at most, (points).
    class(mode_set), intent(in) :: free           !! the modes that move
    type(observation_type), intent(in) :: seen
    logical, intent(in) :: quadratic              !! see `largest`
    real(dp) :: reach(size(seen%points))
    type(deviation_type) :: sums(size(seen%points))
    call add_state(free, 0.0_dp*free%struck, free%struck/free%modal_mass, seen, every(free), sums)
    reach = largest(sums, path_to(seen%points, free%struck_at, free%uniform, 0.0_dp), seen%stretch, quadratic)
  end function blow_reach

  function release_error(after, sources, count, force, seen, monitor) result(error)
    !! Estimates of the largest error over the samples after the release, (points).
    type(segment_type), intent(in) :: after       !! the motion of the beam alone
    type(mode_sources), intent(in) :: sources
    integer, intent(in) :: count                  !! of the modes with the mass that were summed
    real(dp), intent(in) :: force                 !! the continuum's modal velocities are force·Φ_k(1)/M_k
    type(observation_type), intent(in) :: seen    !! after it, times from the release
    class(monitor_type), intent(inout), optional :: monitor   !! the estimates mean nothing where it asks to stop
    real(dp) :: error(size(seen%points))
    class(mode_set), allocatable :: many, free
    type(deviation_type) :: sums(size(seen%points))
    type(tip_remainder) :: remainder
    real(dp) :: usual
    real(dp), allocatable :: lacking(:), lacking_rate(:), start(:), start_rate(:)
    integer :: m, n
    error = 0.0_dp
    if (force == 0.0_dp) return
    m = size(after%q)
    n = max(count, m)
    n = min(max(fewest, min(4*n, n + most_more)), sources%loaded%highest, sources%free%highest)
    call sources%loaded%find(first_numbers(n), many, monitor=monitor)
    call sources%free%find(first_numbers(n), free, monitor=monitor)
    if (stops(monitor)) return
    allocate (start(n), source=0.0_dp)
    start_rate = force*many%struck/many%modal_mass
    usual = sqrt(0.5_dp*sum((many%struck(count + 1:)*start_rate(count + 1:))**2))    ! were the phases random
    call find_tip_remainder(sources%loaded, force, n, after%start, tip_share*usual, remainder, highest=tip_times*n, monitor=monitor)
    call move(many, after%start, start, start_rate)
    associate (gamma => sources%loaded%gamma)
      lacking = (free%overlap_of_beam(many, start, monitor) - gamma*remainder%displacement*free%struck)/free%modal_mass
      lacking_rate = (free%overlap_of_beam(many, start_rate, monitor) - gamma*remainder%velocity*free%struck)/free%modal_mass
      lacking(:m) = lacking(:m) - after%q
      lacking_rate(:m) = lacking_rate(:m) - after%rate
      call add_state(free, lacking, lacking_rate, seen, every(free), sums)
      error = margin*largest(combined(deviation_type(), sums), paths(sources%free, seen), seen%stretch, sources%free%quadratic) &
        + blow_left(n, sources, force, after%start, seen) + force_left(many, start, start_rate, sources%free, seen) &
        + gamma*remainder%uncertainty*blow_reach(free, seen, sources%free%quadratic)
    end associate
  end function release_error

  pure subroutine add_state(modes, q, rate, seen, weight, sums)
    !! Amplitudes of modes that start from any state.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:)         !! (modes)
    type(observation_type), intent(in) :: seen
    real(dp), intent(in) :: weight(:)             !! for how many modes each stands, (modes)
    type(deviation_type), intent(inout) :: sums(:)
    type(moving_modes) :: moving
    real(dp) :: c(modes%count)
    c = 0.0_dp
    if (allocated(modes%damping)) c = modes%damping
    moving = moving_modes(amplitude_of(modes%beta_squared, c, q, rate, seen%stretch, seen%velocity), modes%alpha, &
                          abs(modes%struck), turns(modes%beta_squared, c), &
                          may_agree(modes%alpha, modes%agree_from, seen%velocity), modes%struck_at, modes%uniform, modes%root_power)
    call add_amplitudes(moving, modes%shapes(seen%points), seen, weight, sums)
  end subroutine add_state

  pure function paths(source, seen)
    !! From the blow to each point.
    class(mode_source), intent(in) :: source
    type(observation_type), intent(in) :: seen
    type(path_type) :: paths(size(seen%points))
    paths = path_to(seen%points, source%struck_at, source%uniform, source%gamma)
  end function paths

  pure function every(modes) result(weight)
    !! Each mode stands for itself.
    class(mode_set), intent(in) :: modes
    real(dp) :: weight(modes%count)
    weight = 1.0_dp
  end function every

end module bw_release_error
