module bw_case_motion
  !! The motion of a case before histories are summed: the impact, later events, and the modes to be summed. These are
  !! counted by the scene or chosen by its tolerance.
  use bw_case_modes, only: case_mode_cache
  use bw_case_notes, only: note_added_energy, note_contacts, note_release, note_rounding
  use bw_case_result, only: case_diverged, case_ill_conditioned, case_motion, case_not_converged
  use bw_changing_motion, only: happens
  use bw_double_double, only: dd, operator(-)
  use bw_first_count, only: choose_first
  use bw_impact, only: continuum_velocity
  use bw_initial_state, only: continuum_initial_state, find_initial_state, initial_state, initial_state_cache
  use bw_kinds, only: dp
  use bw_later_count, only: choose_later
  use bw_mode_set, only: configuration_type
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type
  use bw_projection, only: project, projection_type
  use bw_recontact, only: contacts_type, follow_contacts
  use bw_release, only: energy_after, release_mass, release_type
  use bw_rotation, only: full_speed_in_plane, speed_in_plane
  use bw_scene, only: scene_type
  use bw_scene_pieces, only: mass_struck
  use bw_segment, only: alone, energy_type, lack_type, move_with_energy, segment_type, state_energy, together
  use bw_timeline, only: configurations_of, later_steps, number_of, step_type, time_of, timeline_type
  implicit none (type, external)
  private
  public :: follow_motion, start_motion

contains

  subroutine start_motion(scene, motion, monitor, cache, modes_cache)
    !! Find the impact, and the capture if the mass stays: initial state and mode count of the first segment. Does
    !! nothing if modes are not resolved.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion     !! its modes are known
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(initial_state_cache), intent(inout) :: cache
    type(case_mode_cache), intent(inout), optional :: modes_cache   !! absent: no modes are shared
    type(segment_type) :: segment
    if (allocated(motion%notes)) deallocate (motion%notes)      ! of a try with fewer modes, whose survey is kept
    motion%initial = initial_state()
    motion%timeline = timeline_type()
    allocate (motion%initial%events(0), motion%timeline%events(0), motion%timeline%segments(0))
    if (.not. allocated(scene%impact) .or. .not. motion%modes%resolved) return
    segment%configuration = motion%modes%moving
    associate (moving => motion%modes%configuration(segment%configuration), before => motion%modes%configuration(alone)%set, &
               given => scene%impact)
      segment%force = (1.0_dp + given%restitution)*given%mass_ratio
      segment%energy = energy_of_blow(moving, segment%force)
      if (by_tolerance(scene%modes)) then
        call motion%plan%begin(scene%modes%tolerance, 1 + size(later_steps(scene)))
        call continuum_initial_state(moving%set, given, mass_struck(scene, motion%units), motion%initial)
        call choose_first(scene, motion, segment, monitor, modes_cache)
      else if (segment%configuration == together) then
        call find_initial_state(before, moving%set, given, monitor, cache, motion%initial)
        segment%count = moving%set%count
        segment%rate = motion%initial%modal_velocity
        segment%lack = lack_type(rate=continuum_velocity(moving%set, given%mass_ratio, given%restitution) - segment%rate)
      else
        call find_initial_state(before, given=given, monitor=monitor, cache=cache, state=motion%initial)
        segment%count = moving%set%count
        segment%rate = motion%initial%modal_velocity
      end if
    end associate
    if (monitor%stop_requested()) return
    motion%timeline%segments = [segment]
    motion%timeline%events = motion%initial%events
    if (segment%configuration == together) call note_added_energy(scene, motion)
  end subroutine start_motion

  pure real(dp) function energy_of_blow(configuration, force) result(energy)
    !! Return the energy of all modes with initial velocities force·Φ_k(ξ₀)/M_k: ½force² over the mass at that place.
    type(configuration_type), intent(in) :: configuration
    real(dp), intent(in) :: force
    real(dp) :: mass
    associate (pieces => configuration%source%pieces)
      mass = pieces%beam%joint(pieces%struck)%mass%hi/pieces%lightness
    end associate
    energy = 0.0_dp
    if (mass > 0.0_dp) energy = 0.5_dp*force*(force/mass)
  end function energy_of_blow

  subroutine follow_motion(scene, motion, monitor, modes_cache)
    !! Follow all events after t = 0. If the tolerance is out of reach, the motion stays unknown.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion     !! started
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(case_mode_cache), intent(inout), optional :: modes_cache
    type(step_type), allocatable :: steps(:)
    integer :: i
    if (size(motion%timeline%segments) == 0) return
    steps = later_steps(scene)
    do i = 1, size(steps)
      if (.not. happens(scene, steps(i), motion)) exit
      call apply_change(scene, steps(i), motion, monitor, modes_cache)
      if (monitor%stop_requested()) return
    end do
    if (allocated(scene%recontact)) call find_recontacts(scene, motion, monitor)
  end subroutine follow_motion

  subroutine apply_change(scene, step, motion, monitor, modes_cache)
    !! Apply a change and append the segment after it.
    type(scene_type), intent(in) :: scene
    type(step_type), intent(in) :: step
    type(case_motion), intent(inout) :: motion
    class(monitor_type), intent(inout), target :: monitor
    type(case_mode_cache), intent(inout), optional :: modes_cache
    type(projection_type) :: projection
    type(segment_type) :: last, next
    type(release_type) :: release
    type(energy_type) :: energy
    real(dp) :: speed
    next%configuration = number_of(configurations_of(scene), step%carried)
    next%start = time_of(step, motion%units)
    speed = speed_in_plane(scene%rotation, motion%units)
    last = motion%timeline%segments(size(motion%timeline%segments))
    associate (before => motion%modes%configuration(last%configuration), after => motion%modes%configuration(next%configuration))
      if (allocated(last%rate)) then
        call project(last, before, next%start - last%start, 0.0_dp, 0, after%set, projection, monitor)
        if (monitor%stop_requested()) return
        next%count = after%set%count
        next%energy = energy_after(projection, after%set, speed)
        energy = energy_at(before, last, next%start - last%start)
      else
        if (.not. motion%plan%within) return
        call choose_later(scene, motion, last, next, projection, monitor, modes_cache)
        if (monitor%stop_requested()) return
        if (.not. motion%plan%within) return
        energy = energy_type(projection%place%energy, epsilon(speed)*projection%place%energy)
      end if
      next%q = projection%q_after
      next%rate = projection%rate_after
      next%lack = projection%lack
      next%handed = projection%place%count
      release = release_mass(projection, after%set, speed, energy, .not. allocated(last%rate))
    end associate
    release%event%time = step%seconds
    release%event%end_time = step%seconds
    motion%timeline%segments = [motion%timeline%segments, next]
    motion%timeline%events = [motion%timeline%events, release%event]
    call note_release(scene, release, motion)
    call note_rounding(motion)
  end subroutine apply_change

  type(energy_type) function energy_at(configuration, segment, elapsed) result(energy)
    !! Return the energy of the summed modes at a time after a segment's start.
    type(configuration_type), intent(in) :: configuration
    type(segment_type), intent(in) :: segment
    type(dd), intent(in) :: elapsed
    real(dp), dimension(segment%count) :: q, rate
    q = 0.0_dp
    if (allocated(segment%q)) q = segment%q
    rate = segment%rate
    energy = state_energy(configuration%set, q, rate)
    call move_with_energy(configuration%set, elapsed, q, rate, energy)
  end function energy_at

  subroutine find_recontacts(scene, motion, monitor)
    !! Find the contacts of a mass that rebounded.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    class(monitor_type), intent(inout) :: monitor
    type(contacts_type) :: contacts
    type(configuration_type) :: pressed
    if (scene%impact%mass_ratio == 0.0_dp .or. scene%impact%approach_velocity == 0.0_dp) return
    call follow_contacts(motion%modes%configuration(alone)%set, scene%impact%mass_ratio, scene%impact%restitution, &
                         full_speed_in_plane(scene%rotation, motion%units), &
                         scene%response%duration/motion%units%time%hi, scene%recontact%max_contacts, contacts, monitor)
    if (monitor%stop_requested()) return
    call in_seconds(scene, motion, contacts)
    motion%timeline%events = [motion%timeline%events, contacts%events]
    motion%timeline%known_until = contacts%known_until
    if (contacts%out_of_range) then
      motion%ending = case_diverged
    else if (contacts%cut) then
      motion%ending = case_not_converged
    else if (contacts%known_until < huge(1.0_dp)) then
      motion%ending = case_ill_conditioned
    end if
    call note_contacts(scene, contacts, motion)
    call move_alloc(contacts%segments, motion%timeline%segments)
    if (.not. allocated(contacts%modes)) return
    call move_alloc(contacts%modes, pressed%set)
    motion%modes%configuration = [motion%modes%configuration, pressed]
  end subroutine find_recontacts

  pure subroutine in_seconds(scene, motion, contacts)
    !! Convert times of contacts and their errors to seconds. A contact that lasts to the end of the record ends exactly there.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(contacts_type), intent(inout) :: contacts
    associate (events => contacts%events, unit => motion%units%time%hi, duration => scene%response%duration)
      events%time = min(events%time*unit, duration)
      events%end_time = min(events%end_time*unit, duration)
      events%time_error = events%time_error*unit + 2*epsilon(duration)*events%time
      events%end_error = events%end_error*unit + 2*epsilon(duration)*events%end_time
      if (.not. contacts%lasting) return
      events(size(events))%end_time = duration
      events(size(events))%end_error = 0.0_dp
    end associate
  end subroutine in_seconds

end module bw_case_motion
