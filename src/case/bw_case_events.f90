module bw_case_events
  !! What happens in a case: flow and jump. Between events the state of the modes moves on exactly; at an event it jumps, or
  !! goes over to other modes. All of it is known before any history is summed.
  use bw_kinds, only: dp, qp
  use bw_beam_par, only: beam_mass
  use bw_beam_units, only: beam_units
  use bw_case_plan, only: find_state, force_of
  use bw_case_result, only: case_diverged, case_done, case_events, case_ill_conditioned, case_modes, case_motion
  use bw_double_double, only: dd, operator(*)
  use bw_event, only: event_type
  use bw_initial_state, only: continuum_initial_state, find_initial_state, initial_state, initial_state_cache
  use bw_missing, only: is_missing, scaled
  use bw_mode_set, only: first_numbers, mode_set
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type
  use bw_recontact, only: contacts_type, follow_contacts
  use bw_release, only: release_mass, release_type
  use bw_rotation, only: full_speed_in_plane, speed_in_plane
  use bw_scene, only: scene_type
  use bw_segment, only: energy_type, free_beam, loaded_beam, move_with_energy, segment_type, state_energy
  use bw_text, only: append, shortest, text_of
  use bw_time_grid, only: time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: follow_events, start_motion

  real(dp), parameter :: noteworthy = 1.0e12_dp    !! an amplification that leaves nothing of data with 12 digits

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
      call continuum_initial_state(modes%loaded, scene%impact, initial)
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
    real(dp), dimension(motion%plan%release%count) :: q, rate
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    associate (tip => motion%plan%release%tip)
      call find_state(motion%sources%loaded, force_of(scene), motion%plan%release%time, grid, monitor, loaded, q, rate)
      call motion%sources%free%find(first_numbers(size(q)), released, grid%samples*grid%step%hi, monitor)
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

  subroutine note_added_energy(scene, later)
    !! With e > 0 the interface conditions 22–26 give the mass the tip's velocity.
    type(scene_type), intent(in) :: scene
    type(case_events), intent(inout) :: later    !! impact and capture
    if (scene%impact%restitution == 0.0_dp) return
    associate (impact => later%events(1), capture => later%events(2), approach => later%events(1)%energy_before)
      if (approach == 0.0_dp .or. scene%impact%approach_velocity == 0.0_dp) return
      call append(later%notes, 'added energy: restitution '//shortest(scene%impact%restitution, 6)// &
        ' with capture: the interface conditions give the mass the tip''s velocity, which adds the momentum '// &
        shortest((capture%momentum_after - capture%momentum_before)/impact%momentum_before, 4)// &
        ' and the energy '//shortest((capture%energy_after - capture%energy_before)/approach, 4)// &
        ' of what the mass brought; beam and mass then hold '//shortest(capture%energy_after/approach, 4)// &
        ' of its energy')
    end associate
  end subroutine note_added_energy

  subroutine note_no_release(scene, later)
    !! Why no release comes within the record.
    type(scene_type), intent(in) :: scene
    type(case_events), intent(inout) :: later
    logical :: late
    late = .false.
    if (allocated(scene%response)) late = scene%release%time >= scene%response%duration
    if (late) then
      call append(later%notes, 'release: comes after the end of the record, which shows nothing of it')
    else
      call append(later%notes, 'release: by then the motion has grown out of the range of numbers')
    end if
  end subroutine note_no_release

  subroutine note_release(scene, units, release, later)
    !! Where the energy went.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(release_type), intent(in) :: release
    type(case_events), intent(inout) :: later
    character(:), allocatable :: text
    real(dp) :: joules(4)
    joules = scaled([release%kinetic_leaving, release%energy_leaving, release%event%energy_before, release%energy_lost], &
                    units%mass*scene%impact%approach_velocity**2)
    if (is_missing(joules(1))) then
      call append(later%notes, 'energy of the release: too large for double precision')
      return
    end if
    text = 'energy of the release: the mass leaves with '//shortest(joules(1), 4)//' J of motion'
    if (.not. is_missing(joules(2))) text = text//' ('//shortest(joules(2), 4)//' J with what the centrifugal force does)'
    if (.not. is_missing(joules(3))) text = text//' of '//shortest(joules(3), 4)//' J in all'
    if (.not. (is_missing(joules(4)) .or. by_tolerance(scene%modes))) then
      text = text//'; the modes of the beam alone miss '//shortest(joules(4), 2)//' J'
    end if
    call append(later%notes, text)
  end subroutine note_release

  subroutine note_rounding(later)
    !! Energies that are the difference of far larger ones.
    type(case_events), intent(inout) :: later
    if (.not. any(is_missing([later%events%energy_before, later%events%energy_after]))) return
    call append(later%notes, 'energy lost in rounding: that of a motion which has grown is the difference of far larger '// &
                'numbers; it is fill where fewer than three digits are left')
  end subroutine note_rounding

  subroutine note_contacts(scene, units, contacts, later)
    !! How the search for contacts ended.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(contacts_type), intent(in) :: contacts
    type(case_events), intent(inout) :: later
    character(:), allocatable :: from_then_on
    from_then_on = ' from t = '//shortest(max(0.0_dp, later%known_until)*units%time%hi, 6)// &
      ' s on: the histories hold fill from there, and no later contact is given'
    if (contacts%cut) call append(later%notes, 'recontact: more than the '//text_of(scene%recontact%max_contacts)// &
      ' contacts of max_contacts; what comes after the last is the motion without another')
    if (contacts%lasting) call append(later%notes, &
      'recontact: the last contact has not ended at the end of the record')
    if (contacts%out_of_range) call append(later%notes, &
      'recontact: the motion grows out of the range of numbers'//from_then_on)
    if (later%ending == case_ill_conditioned) call append(later%notes, &
      'ill-conditioned: after '//text_of(size(contacts%events))//' contacts, which amplify every error, nothing is known '// &
      'of the motion'//from_then_on)
    if (contacts%amplification > noteworthy) call append(later%notes, &
      'amplification: the contacts amplify every change of the data, '//shortest(contacts%amplification, 1)//' times in '// &
      'the end: what holds for these data to the last digit need not hold for a beam that can be measured')
    if (any(is_missing(contacts%events%energy_after))) call append(later%notes, &
      'energy: a motion that grows leaves fewer than three digits of the energies of the last events, which are fill')
    if (size(contacts%events) == 0 .and. later%ending == case_done) call append(later%notes, &
      'recontact: the mass does not come back within the record')
  end subroutine note_contacts

end module bw_case_events
