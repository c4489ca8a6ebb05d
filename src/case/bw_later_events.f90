module bw_later_events
  !! What happens after t = 0: flow and jump. Between events the state of the modes moves on exactly; at an event it jumps,
  !! or goes over to other modes. Without such events there is nothing to do here.
  use bw_kinds, only: dp, qp
  use bw_beam_par, only: beam_mass
  use bw_case_result, only: add_note, case_diverged, case_done, case_ill_conditioned, case_result
  use bw_course, only: course_type, free_modes, leaves_range, loaded_modes
  use bw_double_double, only: dd, to_dd, operator(/)
  use bw_energy, only: carry, energy_type, state_energy
  use bw_event, only: event_type
  use bw_missing, only: is_missing, scaled
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_recontact, only: contacts_type, follow_contacts
  use bw_release, only: release_mass, release_type
  use bw_rotation, only: full_speed_in_plane, speed_in_plane
  use bw_scene, only: scene_type
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: follow_events, end_capture

  real(dp), parameter :: noteworthy = 1.0e12_dp    !! an amplification that leaves nothing of data with 12 digits

contains

  subroutine follow_events(scene, free, loaded, monitor, result)
    !! The courses of the motion, where there is more than one, and the events between them.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in), optional :: free, loaded    !! modes of the beam alone, and of beam and mass
    class(monitor_type), intent(inout) :: monitor            !! what is found means nothing where it asks to stop
    type(case_result), intent(inout) :: result
    if (allocated(scene%release)) call release_in_time(scene, monitor, result, free, loaded)
    if (allocated(scene%recontact)) call meet_again(scene, free, monitor, result)
  end subroutine follow_events

  subroutine release_in_time(scene, monitor, result, free, loaded)
    !! A release within the record, and within the range of numbers. Where a tolerance asks for as many modes as it takes,
    !! only its time is known yet.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(inout) :: result
    class(mode_set), intent(in), optional :: free, loaded
    type(dd) :: time
    type(energy_type) :: energy
    real(dp), dimension(result%modes%count) :: q, rate
    time = to_dd(scene%release%time)/result%units%time
    if (.not. is_in_record(scene, time, result)) return
    result%courses = [course_type(loaded_modes, dd()), course_type(free_modes, time)]
    if (.not. present(free)) return
    q = 0.0_dp
    rate = result%modal_velocity
    result%courses(1)%q = q
    result%courses(1)%rate = rate
    energy = state_energy(loaded, q, rate)
    call carry(loaded, time, q, rate, energy)
    call end_capture(scene, release_mass(loaded, q, rate, free, speed_in_plane(scene%rotation, result%units), &
                                         energy=energy, monitor=monitor), result)
  end subroutine release_in_time

  logical function is_in_record(scene, time, result)
    !! Whether a release comes before the record ends, and before a growing mode leaves the range of numbers.
    type(scene_type), intent(in) :: scene
    type(dd), intent(in) :: time                 !! of the release, l²/h
    type(case_result), intent(inout) :: result
    is_in_record = .true.
    if (allocated(scene%response)) is_in_record = scene%release%time < scene%response%duration
    if (.not. is_in_record) then
      call add_note(result, 'release: comes after the end of the record, which shows nothing of it')
    else if (leaves_range(result%modes, time)) then
      is_in_record = .false.
      call add_note(result, 'release: by then the motion has grown out of the range of numbers')
    end if
  end function is_in_record

  subroutine end_capture(scene, release, result)
    !! What a release leaves is the start of the second course.
    type(scene_type), intent(in) :: scene
    type(release_type), intent(in) :: release
    type(case_result), intent(inout) :: result
    type(event_type) :: event
    result%courses(2)%q = release%q
    result%courses(2)%rate = release%rate
    event = release%event
    event%time = scene%release%time
    event%end_time = scene%release%time
    result%events = [result%events, event]
    call note_release(release, result)
    call note_rounding(result)
  end subroutine end_capture

  subroutine meet_again(scene, free, monitor, result)
    !! Contacts of a mass that rebounded.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: free
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(inout) :: result
    type(contacts_type) :: contacts
    if (scene%impact%mass_ratio == 0.0_dp .or. result%approach_velocity == 0.0_dp) return
    call follow_contacts(free, mass_ratio_in_full(scene), scene%impact%restitution, &
                         full_speed_in_plane(scene%rotation, result%units), &
                         scene%response%duration/result%units%time%hi, scene%recontact%max_contacts, contacts, monitor)
    if (monitor%stop_requested()) return
    call in_seconds(contacts, scene%response%duration, result)
    result%events = [result%events, contacts%events]
    call move_alloc(contacts%courses, result%courses)
    if (allocated(contacts%held)) call move_alloc(contacts%held, result%held)
    call note_contacts(scene, contacts, result)
  end subroutine meet_again

  subroutine note_contacts(scene, contacts, result)
    !! How the search for contacts ended.
    type(scene_type), intent(in) :: scene
    type(contacts_type), intent(in) :: contacts
    type(case_result), intent(inout) :: result
    if (contacts%out_of_range) then
      result%ending = case_diverged
    else if (contacts%known_until < huge(1.0_dp)) then
      result%ending = case_ill_conditioned
    end if
    result%known_until = contacts%known_until
    if (contacts%cut) call add_note(result, 'recontact: more than the '//text_of(scene%recontact%max_contacts)// &
      ' contacts of max_contacts; what comes after the last is the motion without another')
    if (contacts%lasting) call add_note(result, &
      'recontact: the last contact has not ended at the end of the record')
    if (contacts%out_of_range) call add_note(result, &
      'recontact: the motion grows out of the range of numbers'//from_then_on(result))
    if (result%ending == case_ill_conditioned) call add_note(result, &
      'ill-conditioned: after '//text_of(size(contacts%events))//' contacts, which amplify every error, nothing is known '// &
      'of the motion'//from_then_on(result))
    if (contacts%amplification > noteworthy) call add_note(result, &
      'amplification: the contacts amplify every change of the data, '//shortest(contacts%amplification, 1)//' times in '// &
      'the end: what holds for these data to the last digit need not hold for a beam that can be measured')
    if (any(is_missing(contacts%events%energy_after))) call add_note(result, &
      'energy: a motion that grows leaves fewer than three digits of the energies of the last events, which are fill')
    if (size(contacts%events) == 0 .and. result%ending == case_done) call add_note(result, &
      'recontact: the mass does not come back within the record')
  end subroutine note_contacts

  pure function from_then_on(result) result(text)
    !! When the motion ends that is known.
    type(case_result), intent(in) :: result
    character(:), allocatable :: text
    text = ' from t = '//shortest(max(0.0_dp, result%known_until)*result%units%time%hi, 6)// &
      ' s on: the histories hold fill from there, and no later contact is given'
  end function from_then_on

  pure real(qp) function mass_ratio_in_full(scene) result(gamma)
    !! m_j/m_i of the numbers as they were given.
    type(scene_type), intent(in) :: scene
    gamma = scene%impact%mass_ratio
    if (scene%impact%mass_given) gamma = scene%impact%mass/beam_mass(scene%beam)
  end function mass_ratio_in_full

  pure subroutine in_seconds(contacts, duration, result)
    type(contacts_type), intent(inout) :: contacts
    real(dp), intent(in) :: duration             !! s
    type(case_result), intent(in) :: result
    associate (events => contacts%events, unit => result%units%time%hi)
      events%time = min(events%time*unit, duration)
      events%end_time = min(events%end_time*unit, duration)
      events%time_error = events%time_error*unit + 2*epsilon(duration)*events%time
      events%end_error = events%end_error*unit + 2*epsilon(duration)*events%end_time
      if (.not. contacts%lasting) return
      events(size(events))%end_time = duration   ! exactly: it has not ended
      events(size(events))%end_error = 0.0_dp
    end associate
  end subroutine in_seconds

  subroutine note_release(release, result)
    !! Where the energy went.
    type(release_type), intent(in) :: release
    type(case_result), intent(inout) :: result
    character(:), allocatable :: text
    real(dp) :: joules(4)
    joules = scaled([release%kinetic_leaving, release%energy_leaving, release%event%energy_before, release%energy_lost], &
                    result%units%mass*result%approach_velocity**2)
    if (is_missing(joules(1))) then
      call add_note(result, 'energy of the release: too large for double precision')
      return
    end if
    text = 'energy of the release: the mass leaves with '//shortest(joules(1), 4)//' J of motion'
    if (.not. is_missing(joules(2))) text = text//' ('//shortest(joules(2), 4)//' J with what the centrifugal force does)'
    if (.not. is_missing(joules(3))) text = text//' of '//shortest(joules(3), 4)//' J in all'
    if (.not. (is_missing(joules(4)) .or. allocated(result%tip_rest))) then
      text = text//'; the modes of the beam alone miss '//shortest(joules(4), 2)//' J'
    end if
    call add_note(result, text)
  end subroutine note_release

  subroutine note_rounding(result)
    !! Energies that are the difference of far larger ones.
    type(case_result), intent(inout) :: result
    if (.not. any(is_missing([result%events%energy_before, result%events%energy_after]))) return
    call add_note(result, 'energy lost in rounding: that of a motion which has grown is the difference of far larger '// &
                  'numbers; it is fill where fewer than three digits are left')
  end subroutine note_rounding

end module bw_later_events
