module bw_later_events
  !! What happens after t = 0: flow and jump. Between events the state of the modes moves on exactly; at an event it jumps,
  !! or goes over to other modes. Without such events there is nothing to do here.
  use bw_kinds, only: dp
  use bw_case_result, only: add_note, case_result
  use bw_course, only: course_type, free_modes, leaves_range, loaded_modes
  use bw_double_double, only: dd, to_dd, operator(/)
  use bw_energy, only: carry, energy_type, state_energy
  use bw_event, only: event_type
  use bw_missing, only: is_missing, scaled
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_recontact, only: contacts_type, follow_contacts
  use bw_release, only: release_mass, release_type
  use bw_rotation, only: speed_in_plane
  use bw_scene, only: scene_type
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: follow_events, end_capture

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
    call follow_contacts(free, scene%impact%mass_ratio, scene%impact%restitution, &
                         speed_in_plane(scene%rotation, result%units), result%modal_velocity, &
                         result%impact%mass_velocity, scene%response%duration/result%units%time%hi, &
                         scene%recontact%max_contacts, contacts, monitor)
    if (monitor%stop_requested()) return
    call in_seconds(contacts%events, scene%response%duration, result)
    result%events = [result%events, contacts%events]
    call note_rounding(result)
    if (size(contacts%events) > 0) call move_alloc(contacts%courses, result%courses)
    if (allocated(contacts%held)) call move_alloc(contacts%held, result%held)
    if (contacts%cut) call add_note(result, 'recontact: more than the '//text_of(scene%recontact%max_contacts)// &
      ' contacts of max_contacts; what comes after the last is the motion without another')
    if (contacts%lasting .and. .not. contacts%out_of_range) call add_note(result, &
      'recontact: the last contact has not ended at the end of the record')
    if (contacts%out_of_range) call add_note(result, &
      'recontact: the motion grows out of the range of numbers within the record; later contacts are not looked for')
    if (size(contacts%events) == 0) call add_note(result, 'recontact: the mass does not come back within the record')
  end subroutine meet_again

  pure subroutine in_seconds(events, duration, result)
    type(event_type), intent(inout) :: events(:)
    real(dp), intent(in) :: duration             !! s
    type(case_result), intent(in) :: result
    events%time = min(events%time*result%units%time%hi, duration)
    events%end_time = min(events%end_time*result%units%time%hi, duration)
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
