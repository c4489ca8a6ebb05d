module bw_changing_motion
  !! The motion of a beam that changes in time, from its initial motion through all events. Mode counts are given, and a
  !! fraction of the modes may take part, so that several runs show their convergence.
  use bw_beam_motion, only: beam_motion
  use bw_case_bodies, only: bodies_of, presence, set_pull
  use bw_change_of_bodies, only: beam_state, body_type, change_bodies, change_type, energy_at, energy_of, strike_beam
  use bw_double_double, only: dd, to_dd, operator(/), operator(-)
  use bw_event, only: arrival_event, capture_event, departure_event, event_type, exchange_event, impact_event, release_event
  use bw_first_motion, only: find_first_motion
  use bw_initial_state, only: find_jump, initial_state
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_rotation, only: speed_in_plane
  use bw_scene, only: scene_type
  use bw_segment, only: energy_type, known_energy, move, segment_type, operator(+)
  use bw_text, only: append, shortest
  use bw_timeline, only: carried_type, configurations_of, number_of, occurs_in_record, step_type, steps_of, time_of, timeline_type
  use bw_unprojected, only: unprojected_errors
  implicit none (type, external)
  private
  public :: follow_changes, happens, kind_of_change, note_late_change

  type :: now_type
    !! The current state of the motion.
    type(beam_state) :: state
    type(body_type), allocatable :: bodies(:)
    type(beam_state) :: total                      !! including the motion under loads after t = 0
    type(body_type), allocatable :: stretched(:)   !! the bodies in that motion
    integer :: configuration = 1
    logical, allocatable :: there(:)               !! bodies that the beam carries, (bodies)
    real(dp), allocatable :: error(:, :)           !! of the state at the start of a segment, (modes, 2)
  end type now_type

contains

  subroutine follow_changes(scene, eighths, handing, motion, monitor, loaded)
    !! Follow the motion to the last event. Loads are superposed elsewhere; given theirs, energies and momenta are those
    !! of the sum.
    type(scene_type), intent(in) :: scene          !! without sweeps, with mode counts
    integer, intent(in) :: eighths                 !! of the modes of each configuration take part, the first
    integer, intent(in) :: handing                 !! how many times the summed modes are projected at changes
    class(beam_motion), intent(inout) :: motion    !! its modes are known
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(beam_state), intent(in), optional :: loaded(:)     !! motion under loads before each event after t = 0
    type(step_type), allocatable :: steps(:)
    type(now_type) :: now
    type(dd) :: time
    integer :: first, i
    motion%initial = initial_state()
    motion%timeline = timeline_type()
    if (allocated(motion%notes)) deallocate (motion%notes)
    allocate (motion%initial%events(0), motion%timeline%events(0), motion%timeline%segments(0))
    steps = steps_of(scene)
    call begin(scene, motion, eighths, steps(1)%carried, now)
    do first = 2, size(steps)
      if (steps(first)%seconds > 0.0_dp) exit
      call apply_event(scene, steps(first), eighths, motion, now, monitor)
      if (monitor%stop_requested()) return
    end do
    if (present(loaded)) then
      now%total = now%state
      now%stretched = now%bodies
    end if
    motion%initial%modal_displacement = now%state%q
    motion%initial%modal_velocity = now%state%rate
    motion%initial%events = motion%timeline%events
    call add_segment(to_dd(0.0_dp), handing, motion, now)
    do i = first, size(steps)
      time = time_of(steps(i), motion%units)
      if (.not. happens(scene, steps(i), motion)) exit
      call advance(time, motion, now)
      if (present(loaded)) then
        if (i - first + 1 > size(loaded)) exit       ! a mode under loads has overflowed
        call add_loaded(loaded(i - first + 1), now)
      end if
      call apply_event(scene, steps(i), eighths, motion, now, monitor, present(loaded))
      if (monitor%stop_requested()) return
      call add_segment(time, handing, motion, now)
    end do
  end subroutine follow_changes

  pure integer function taking_part(modes, eighths) result(count)
    !! Return how many modes take part.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: eighths
    count = max(1, (modes%count*eighths + 7)/8)
  end function taking_part

  subroutine begin(scene, motion, eighths, carried, now)
    !! Set the state at t = 0: deflected by the force of &initial, and rotating.
    type(scene_type), intent(in) :: scene
    class(beam_motion), intent(inout) :: motion
    integer, intent(in) :: eighths
    type(carried_type), intent(in) :: carried
    type(now_type), intent(out) :: now
    integer :: n
    now%configuration = number_of(configurations_of(scene), carried)
    now%there = presence(scene, carried)
    now%bodies = bodies_of(scene, motion%units)
    associate (modes => motion%modes%configuration(now%configuration)%set, state => now%state)
      n = taking_part(modes, eighths)
      state%count = n
      allocate (state%shape(0))
      allocate (now%error(modes%count, 2), source=0.0_dp)
    end associate
    call find_first_motion(scene, now%configuration, motion, now%state%q, now%state%rate)
    now%state%q(n + 1:) = 0.0_dp
    now%state%rate(n + 1:) = 0.0_dp
  end subroutine begin

  logical function happens(scene, step, motion)
    !! Return whether an event comes before the end of the record and before a growing mode overflows; note why not.
    type(scene_type), intent(in) :: scene
    type(step_type), intent(in) :: step
    class(beam_motion), intent(inout) :: motion
    logical :: late
    associate (last => motion%timeline%segments(size(motion%timeline%segments)))
      happens = occurs_in_record(step, scene, time_of(step, motion%units) - last%start, &
                                 motion%modes%configuration(last%configuration)%set)
    end associate
    if (happens) return
    late = .false.
    if (allocated(scene%response)) late = step%seconds >= scene%response%duration
    if (late) then
      call note_late_change(step%seconds, motion)
    else
      call append(motion%notes, 'late change: by t = '//shortest(step%seconds, 6)//' s the motion has grown beyond '// &
                  'the range of double precision, and later changes are ignored')
    end if
  end function happens

  subroutine note_late_change(seconds, motion)
    real(dp), intent(in) :: seconds
    class(beam_motion), intent(inout) :: motion
    call append(motion%notes, 'late change: changes from t = '//shortest(seconds, 6)//' s on are after the end of the '// &
                'histories and do not affect them')
  end subroutine note_late_change

  subroutine advance(time, motion, now)
    !! Move the state from the start of the last segment to a time.
    type(dd), intent(in) :: time
    class(beam_motion), intent(in) :: motion
    type(now_type), intent(inout) :: now
    associate (last => motion%timeline%segments(size(motion%timeline%segments)), state => now%state)
      state%q = last%q
      state%rate = last%rate
      call move(motion%modes%configuration(last%configuration)%set, time - last%start, state%q, state%rate)
    end associate
  end subroutine advance

  subroutine add_segment(time, handing, motion, now)
    !! Append a segment of free motion about the equilibrium.
    type(dd), intent(in) :: time
    integer, intent(in) :: handing
    class(beam_motion), intent(inout) :: motion
    type(now_type), intent(in) :: now
    type(segment_type) :: segment
    segment%configuration = now%configuration
    segment%start = time
    segment%count = (now%state%count + handing - 1)/handing
    segment%q = now%state%q
    segment%rate = now%state%rate
    if (size(now%state%shape) > 0) segment%shape = now%state%shape
    segment%error = now%error
    motion%timeline%segments = [motion%timeline%segments, segment]
  end subroutine add_segment

  pure subroutine add_loaded(loaded, now)
    !! Add the motion under loads to that without, before an event.
    type(beam_state), intent(in) :: loaded         !! may have another number of modes
    type(now_type), intent(inout) :: now
    integer :: n
    n = min(loaded%count, now%state%count)
    associate (total => now%total)
      total%count = now%state%count
      total%q = now%state%q
      total%rate = now%state%rate
      total%q(:n) = total%q(:n) + loaded%q(:n)
      total%rate(:n) = total%rate(:n) + loaded%rate(:n)
    end associate
  end subroutine add_loaded

  subroutine apply_event(scene, step, eighths, motion, now, monitor, with_loads)
    !! Apply one event: an impact, or bodies that come and leave.
    type(scene_type), intent(in) :: scene
    type(step_type), intent(in) :: step
    integer, intent(in) :: eighths
    class(beam_motion), intent(inout) :: motion
    type(now_type), intent(inout) :: now
    class(monitor_type), intent(inout), target :: monitor
    logical, intent(in), optional :: with_loads    !! the event's energies and momenta include the motion under loads
    type(event_type) :: event
    type(change_type) :: change
    type(beam_state) :: later, whole
    logical, allocatable :: is(:)
    real(dp) :: speed
    integer :: next
    event%time = step%seconds
    event%end_time = step%seconds
    if (step%is_impact) then
      call apply_impact(scene, motion, now, event, monitor)
      motion%timeline%events = [motion%timeline%events, event]
      return
    end if
    is = presence(scene, step%carried)
    next = number_of(configurations_of(scene), step%carried)
    speed = speed_in_plane(scene%rotation, motion%units)
    if (step%is_capture) now%bodies(size(now%bodies))%velocity = motion%initial%impact%tip_velocity
    associate (configuration => motion%modes%configuration)
      change = change_type(now%configuration, next, now%there, is, taking_part(configuration(next)%set, eighths))
      call change_bodies(configuration, change, now%state, now%bodies, speed**2, later, event, monitor)
      if (monitor%stop_requested()) return
      associate (n => now%state%count)
        now%error = unprojected_errors(configuration(now%configuration)%set, now%state%q(:n), now%state%rate(:n), &
                                    configuration(next)%set, now%bodies, now%there, is)
      end associate
      if (present(with_loads)) then
        if (with_loads) call change_bodies(configuration, change, now%total, now%stretched, speed**2, whole, event, monitor)
        if (with_loads) now%total = whole
      end if
    end associate
    event%kind = kind_of_change(step, now%there, is)
    motion%timeline%events = [motion%timeline%events, event]
    now%state = later
    now%configuration = next
    now%there = is
  end subroutine apply_event

  pure integer function kind_of_change(step, was, is) result(kind)
    !! Return the kind of an event at which bodies come or leave.
    type(step_type), intent(in) :: step
    logical, intent(in) :: was(:), is(:)
    kind = exchange_event
    if (.not. any(was .and. .not. is)) kind = arrival_event
    if (.not. any(is .and. .not. was)) kind = departure_event
    if (step%is_release .and. count(was .neqv. is) == 1) kind = release_event
    if (step%is_capture) kind = capture_event
  end function kind_of_change

  subroutine apply_impact(scene, motion, now, event, monitor)
    !! Apply the impact. With a tolerance a captured mass strikes the continuum, not a finite number of modes: only the struck place
    !! changes its velocity, which takes no impulse.
    type(scene_type), intent(in) :: scene
    class(beam_motion), intent(inout) :: motion
    type(now_type), intent(inout) :: now
    type(event_type), intent(inout) :: event
    class(monitor_type), intent(inout), target :: monitor
    type(energy_type) :: energy
    type(body_type) :: mass(1)
    real(dp) :: moving, place, speed
    event%kind = impact_event
    now%error = 0.0_dp
    associate (modes => motion%modes%configuration(now%configuration)%set, given => scene%impact, impact => motion%initial%impact, &
               state => now%state)
      moving = dot_product(modes%struck, state%rate)
      impact%gamma = given%mass_ratio
      impact%restitution = given%restitution
      mass = body_type(position=given%position, mass=given%mass_ratio)
      call set_pull(scene, motion%units, mass)
      speed = speed_in_plane(scene%rotation, motion%units)
      place = sum(energy_at(modes, state%q(:state%count), mass(1), [dot_product(modes%struck, state%q), 0.0_dp], speed**2))
      if (motion%of_continuum) then
        energy = energy_of(modes, state) &
          + energy_type(0.5_dp*given%mass_ratio*given%approach_velocity**2 + place, 0.0_dp)
        event%energy_before = known_energy(energy)
        event%energy_after = event%energy_before
        event%momentum_before = modes%modal_mass(1)*state%rate(1)/modes%struck(1) + given%mass_ratio*given%approach_velocity
        event%momentum_after = event%momentum_before
        impact%modal_velocity = 0.0_dp*state%rate
        impact%mass_velocity = given%approach_velocity
        impact%tip_velocity = moving + (1.0_dp + given%restitution)*(given%approach_velocity - moving)
      else
        call strike_beam(modes, state, given%mass_ratio, given%approach_velocity, given%restitution, &
                         place, impact%mass_velocity, impact%modal_velocity, event)
        impact%impulse = event%impulse
        impact%tip_velocity = dot_product(modes%struck, state%rate)
      end if
      impact%event = event
      call find_jump(modes, impact%modal_velocity, given%profile_points, monitor, motion%initial%velocity_jump)
    end associate
  end subroutine apply_impact

end module bw_changing_motion
