module bw_initial_state
  !! The state of the modes after all events at t = 0: the impact, and the capture if the mass stays. Without
  !! dimensions: masses in m_i, velocities in the approach velocity V.
  !!
  !! It depends only on shapes, mass ratio and restitution. Cases of a sweep that share these share a cached state; a
  !! sweep of the rotation alone is three times as fast.
  use bw_event, only: event_type
  use bw_impact, only: capture_mass, capture_type, continuum_capture, continuum_impact, continuum_velocity, impact_type, strike
  use bw_impact_par, only: impact_par
  use bw_kinds, only: dp
  use bw_mode_set, only: mean_rate, mode_set
  use bw_monitor, only: monitor_type, part_monitor
  implicit none (type, external)
  private
  public :: continuum_initial_state, find_initial_state, find_jump

  type, public :: initial_state
    !! The state after impact and capture.
    type(impact_type) :: impact
    real(dp), allocatable :: modal_velocity(:)    !! after the last event, (modes)
    real(dp), allocatable :: modal_displacement(:)   !! initial, over the unit of time, (modes); unallocated: 0
    real(dp), allocatable :: velocity_jump(:)     !! at the impact along the beam, Fig. 3, (profile)
    type(event_type), allocatable :: events(:)
  end type initial_state

  integer, parameter :: most_states = 128         !! most states in the cache
  integer, parameter :: most_numbers = 4096       !! most numbers of a cached state: together less than 5 MB

  type :: cached_state
    type(initial_state) :: state
    integer :: counts(2) = 0                      !! of modes of the beam alone, and of beam and mass
  end type cached_state

  type, public :: initial_state_cache
    !! States in the order of their entry. The newest replaces the oldest.
    private
    type(cached_state), allocatable :: states(:)
    integer :: found = 0                          !! entries made so far
  end type initial_state_cache

contains

  subroutine work_out(free, loaded, given, monitor, state)
    !! Compute the state with finitely many modes.
    class(mode_set), intent(in) :: free                !! modes of the beam alone
    class(mode_set), intent(in), optional :: loaded    !! modes of beam and mass; absent: the mass is not captured
    type(impact_par), intent(in) :: given
    class(monitor_type), intent(inout), target :: monitor    !! the state is invalid if it requests a stop
    type(initial_state), intent(out) :: state
    real(dp), parameter :: handed_on = 10.0_dp               ! an overlap costs as much as a shape at so many points
    type(capture_type) :: capture
    type(part_monitor) :: part
    real(dp) :: share
    state%impact = strike(free, given%mass_ratio, given%restitution)
    state%impact%event%hub_rate_change = mean_rate(free, state%impact%modal_velocity)
    share = 0.0_dp
    if (present(loaded)) then
      share = handed_on*(1.0_dp + loaded%count/real(free%count, dp))
      share = share/(share + given%profile_points)
      part = part_monitor(monitor, 0.0_dp, share)
      capture = capture_mass(free, state%impact, loaded, part)
      capture%event%hub_rate_change = mean_rate(loaded, capture%modal_velocity) - state%impact%event%hub_rate_change
      call move_alloc(capture%modal_velocity, state%modal_velocity)
      state%events = [state%impact%event, capture%event]
    else
      state%modal_velocity = state%impact%modal_velocity
      state%events = [state%impact%event]
    end if
    part = part_monitor(monitor, share, 1.0_dp - share)
    call find_jump(free, state%impact%modal_velocity, given%profile_points, part, state%velocity_jump)
  end subroutine work_out

  pure subroutine continuum_initial_state(loaded, given, held, state)
    !! Return the state in the limit of infinitely many modes before the capture: only the struck point changes its velocity.
    class(mode_set), intent(in) :: loaded              !! modes of beam and mass
    type(impact_par), intent(in) :: given
    real(dp), intent(in) :: held                       !! mass of bodies at the struck point
    type(initial_state), intent(out) :: state
    real(dp) :: place
    state%impact = continuum_impact(given%mass_ratio, given%restitution, held)
    state%modal_velocity = continuum_velocity(loaded, given%mass_ratio, given%restitution)
    state%events = [state%impact%event, continuum_capture(state%impact, held)]
    state%events(2)%hub_rate_change = mean_rate(loaded, state%modal_velocity)
    allocate (state%velocity_jump(given%profile_points), source=0.0_dp)
    place = given%position*(given%profile_points - 1)
    if (abs(place - nint(place)) <= place*epsilon(place)) state%velocity_jump(nint(place) + 1) = state%impact%tip_velocity
  end subroutine continuum_initial_state

  subroutine find_jump(free, modal_velocity, profile_points, monitor, jump)
    !! Find Σφ_i(ξ)Δq̇_i along the beam, in blocks of bounded memory.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: modal_velocity(:)
    integer, intent(in) :: profile_points
    class(monitor_type), intent(inout) :: monitor
    real(dp), allocatable, intent(out) :: jump(:)      !! (profile)
    real(dp) :: profile(profile_points)
    integer, parameter :: most_shapes = 500000         ! values of shapes in memory at a time
    integer :: block, first, i, j, k, last
    profile = [(real(j, dp)/(profile_points - 1), j=0, profile_points - 1)]
    allocate (jump(profile_points), source=0.0_dp)
    block = max(1, most_shapes/free%count)
    do first = 1, profile_points, block
      last = min(first + block - 1, profile_points)
      do i = 1, free%count, most_shapes
        if (monitor%stop_requested()) return
        k = min(i + most_shapes - 1, free%count)
        jump(first:last) = jump(first:last) + matmul(modal_velocity(i:k), free%some_shapes(i, k, profile(first:last)))
      end do
      call monitor%advance(real(last, dp)/profile_points)
    end do
  end subroutine find_jump

  subroutine find_initial_state(free, loaded, given, monitor, cache, state)
    !! Take the state for finitely many modes from the cache, or compute it, and cache it if its modes can be recognised.
    class(mode_set), intent(in) :: free                !! modes of the beam alone
    class(mode_set), intent(in), optional :: loaded    !! modes of beam and mass; absent: the mass is not captured
    type(impact_par), intent(in) :: given
    class(monitor_type), intent(inout) :: monitor      !! nothing is found or cached if it requests a stop
    type(initial_state_cache), intent(inout) :: cache
    type(initial_state), intent(out) :: state
    integer :: counts(2), place
    logical :: cached
    counts = [free%count, 0]
    cached = free%known_by_mass
    if (present(loaded)) then
      counts(2) = loaded%count
      cached = cached .and. loaded%known_by_mass
    end if
    place = 0
    if (cached) place = place_of(cache, counts, given)
    if (place > 0) then
      state = cache%states(place)%state
      return
    end if
    call work_out(free, loaded, given, monitor, state)
    if (monitor%stop_requested()) return
    if (.not. cached .or. free%count + size(state%modal_velocity) + given%profile_points > most_numbers) return
    if (.not. allocated(cache%states)) allocate (cache%states(most_states))
    place = 1 + mod(cache%found, most_states)
    cache%states(place)%state = state
    cache%states(place)%counts = counts
    cache%found = cache%found + 1
  end subroutine find_initial_state

  pure integer function place_of(cache, counts, given) result(place)
    !! Return the index of a state in the cache; 0: none.
    type(initial_state_cache), intent(in) :: cache
    integer, intent(in) :: counts(2)
    type(impact_par), intent(in) :: given
    do place = min(cache%found, most_states), 1, -1
      if (any(cache%states(place)%counts /= counts)) cycle
      associate (known => cache%states(place)%state)
        if (known%impact%gamma == given%mass_ratio .and. known%impact%restitution == given%restitution .and. &
            size(known%velocity_jump) == given%profile_points) return
      end associate
    end do
  end function place_of

end module bw_initial_state
