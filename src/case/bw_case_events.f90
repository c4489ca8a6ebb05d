module bw_case_events
  !! What happens in a case: flow and jump. Between events the state of the modes moves on exactly; at an event it jumps, or
  !! goes over to other modes. All of it is known before any history is summed.
  use bw_beam_par, only: beam_mass
  use bw_beam_units, only: beam_units, units_of
  use bw_case_notes, only: note_added_energy, note_contacts, note_no_release, note_release, note_rounding
  use bw_case_plan, only: force_of
  use bw_case_result, only: case_diverged, case_events, case_ill_conditioned, case_modes, case_motion, &
                            case_not_converged
  use bw_double_double, only: dd, operator(*)
  use bw_initial_state, only: continuum_initial_state, continuum_state, find_initial_state, initial_state, initial_state_cache
  use bw_kinds, only: dp, qp
  use bw_mode_set, only: first_numbers, mode_set
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type
  use bw_recontact, only: contacts_type, follow_contacts
  use bw_release, only: release_mass, release_type
  use bw_rotation, only: full_speed_in_plane, speed_in_plane
  use bw_scene, only: scene_type
  use bw_scene_pieces, only: mass_struck
  use bw_segment, only: energy_type, free_beam, loaded_beam, move_with_energy, segment_type, state_energy
  use bw_time_grid, only: time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: follow_events, start_motion

contains

  subroutine start_motion(scene, modes, monitor, cache, initial)
    !! The impact, and the capture if the mass stays. Nothing strikes modes that are not resolved.
    type(scene_type), intent(in) :: scene
    type(case_modes), intent(in) :: modes
    class(monitor_type), intent(inout) :: monitor  !! what is left means nothing where it asks to stop
    type(initial_state_cache), intent(inout) :: cache
    type(initial_state), intent(out) :: initial
    allocate (initial%events(0))
    if (.not. allocated(scene%impact) .or. .not. modes%resolved) return
    if (allocated(modes%free)) then
      call find_initial_state(modes%free, modes%loaded, scene%impact, monitor, cache, initial)
    else
      call continuum_initial_state(modes%loaded, scene%impact, mass_struck(scene, units_of(scene%beam)), initial)
    end if
  end subroutine start_motion

  subroutine follow_events(scene, motion, monitor, later)
    !! All events of the record, and the segments of the motion between them where there is more than one.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion        !! its modes, plan and initial state
    class(monitor_type), intent(inout) :: monitor  !! what is found means nothing where it asks to stop
    type(case_events), intent(out) :: later
    later%events = motion%initial%events
    if (size(later%events) == 0) return            ! nothing strikes the beam
    if (size(later%events) > 1) call note_added_energy(scene, later)
    if (allocated(scene%release)) then
      if (allocated(motion%plan%release)) then
        call release_in_record(scene, motion, monitor, later)
      else
        call note_no_release(scene, later)
      end if
    end if
    if (allocated(scene%recontact)) call meet_again(scene, motion, monitor, later)
  end subroutine follow_events

  subroutine release_in_record(scene, motion, monitor, later)
    !! The captured motion and that of the beam alone. A tolerance that is out of reach leaves their states unknown.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(monitor_type), intent(inout) :: monitor
    type(case_events), intent(inout) :: later
    type(release_type) :: release
    associate (time => motion%plan%release%time)
      later%segments = [segment_type(loaded_beam, dd()), segment_type(free_beam, time)]
    end associate
    if (.not. by_tolerance(scene%modes)) then
      call release_set(scene, motion, monitor, later%segments(1), release)
    else if (motion%plan%reached <= scene%modes%tolerance) then
      call release_continuum(scene, motion, monitor, later%released, release)
    else
      return
    end if
    if (monitor%stop_requested()) return
    later%segments(2)%q = release%q
    later%segments(2)%rate = release%rate
    release%event%time = scene%release%time
    release%event%end_time = scene%release%time
    later%events = [later%events, release%event]
    call note_release(scene, motion%units, release, later)
    call note_rounding(later)
  end subroutine release_in_record

  subroutine release_set(scene, motion, monitor, captured, release)
    !! The release of as many modes as the scene counts.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(monitor_type), intent(inout) :: monitor
    type(segment_type), intent(inout) :: captured
    type(release_type), intent(out) :: release
    type(energy_type) :: energy
    real(dp), dimension(motion%modes%loaded%count) :: q, rate
    q = 0.0_dp
    rate = motion%initial%modal_velocity
    captured%q = q
    captured%rate = rate
    energy = state_energy(motion%modes%loaded, q, rate)
    call move_with_energy(motion%modes%loaded, motion%plan%release%time, q, rate, energy)
    release = release_mass(motion%modes%loaded, q, rate, motion%modes%free, speed_in_plane(scene%rotation, motion%units), &
                           energy=energy, monitor=monitor)
  end subroutine release_set

  subroutine release_continuum(scene, motion, monitor, released, release)
    !! The release as infinitely many modes have it, but for those of the beam alone that are not summed.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(monitor_type), intent(inout) :: monitor
    class(mode_set), allocatable, intent(out) :: released    !! modes that move after it
    type(release_type), intent(out) :: release
    class(mode_set), allocatable :: loaded
    type(time_grid) :: grid
    real(dp) :: longest                          ! the record, l²/h
    real(dp), dimension(motion%plan%release%count) :: q, rate
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    longest = grid%samples*grid%step%hi
    associate (tip => motion%plan%release%tip)
      call continuum_state(motion%sources%loaded, force_of(scene), motion%plan%release%time, longest, monitor, loaded, q, rate)
      call motion%sources%free%find(first_numbers(size(q)), released, longest, monitor)
      if (monitor%stop_requested()) return
      release = release_mass(loaded, q, rate, released, speed_in_plane(scene%rotation, motion%units), tip, &
                             energy_type(tip%energy, epsilon(1.0_dp)*tip%energy), monitor)
    end associate
  end subroutine release_continuum

  subroutine meet_again(scene, motion, monitor, later)
    !! Contacts of a mass that rebounded.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(monitor_type), intent(inout) :: monitor
    type(case_events), intent(inout) :: later
    type(contacts_type) :: contacts
    if (scene%impact%mass_ratio == 0.0_dp .or. scene%impact%approach_velocity == 0.0_dp) return
    call follow_contacts(motion%modes%free, mass_ratio_in_full(scene), scene%impact%restitution, &
                         full_speed_in_plane(scene%rotation, motion%units), &
                         scene%response%duration/motion%units%time%hi, scene%recontact%max_contacts, contacts, monitor)
    if (monitor%stop_requested()) return
    call in_seconds(motion%units, scene%response%duration, contacts)
    later%events = [later%events, contacts%events]
    later%known_until = contacts%known_until
    if (contacts%out_of_range) then
      later%ending = case_diverged
    else if (contacts%cut) then
      later%ending = case_not_converged
    else if (contacts%known_until < huge(1.0_dp)) then
      later%ending = case_ill_conditioned
    end if
    call note_contacts(scene, motion%units, contacts, later)
    call move_alloc(contacts%segments, later%segments)
    if (allocated(contacts%modes)) call move_alloc(contacts%modes, later%in_contact)
  end subroutine meet_again

  pure real(qp) function mass_ratio_in_full(scene) result(gamma)
    !! m_j/m_i of the numbers as they were given.
    type(scene_type), intent(in) :: scene
    gamma = scene%impact%mass_ratio
    if (scene%impact%mass_given) gamma = scene%impact%mass/beam_mass(scene%beam)
  end function mass_ratio_in_full

  pure subroutine in_seconds(units, duration, contacts)
    !! The times of contacts and their errors; one that lasts to the end of the record ends there exactly.
    type(beam_units), intent(in) :: units
    real(dp), intent(in) :: duration             !! s
    type(contacts_type), intent(inout) :: contacts
    associate (events => contacts%events, unit => units%time%hi)
      events%time = min(events%time*unit, duration)
      events%end_time = min(events%end_time*unit, duration)
      events%time_error = events%time_error*unit + 2*epsilon(duration)*events%time
      events%end_error = events%end_error*unit + 2*epsilon(duration)*events%end_time
      if (.not. contacts%lasting) return
      events(size(events))%end_time = duration
      events(size(events))%end_error = 0.0_dp
    end associate
  end subroutine in_seconds

end module bw_case_events
