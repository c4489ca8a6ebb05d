module bw_later_events
  !! What happens after t = 0: flow and jump. Between events the state of the modes moves on exactly; at an event it jumps,
  !! or goes over to other modes. Without such events there is nothing to do here.
  use bw_kinds, only: dp
  use bw_case_result, only: add_note, case_result
  use bw_course, only: course_type, free_modes, leaves_range, loaded_modes, move
  use bw_double_double, only: dd, to_dd, operator(/)
  use bw_event, only: event_type
  use bw_mode_set, only: mode_set
  use bw_recontact, only: contacts_type, follow_contacts
  use bw_release, only: release_mass, release_type
  use bw_rotation, only: speed_in_plane
  use bw_scene, only: scene_type
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: follow_events

contains

  subroutine follow_events(scene, free, loaded, result)
    !! The courses of the motion, where there is more than one, and the events between them.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in), optional :: free, loaded    !! modes of the beam alone, and of beam and mass
    type(case_result), intent(inout) :: result
    if (allocated(scene%release)) call release_in_time(scene, free, loaded, result)
    if (allocated(scene%recontact)) call meet_again(scene, free, result)
  end subroutine follow_events

  subroutine release_in_time(scene, free, loaded, result)
    !! A release within the record, and within the range of numbers.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: free, loaded
    type(case_result), intent(inout) :: result
    type(release_type) :: release
    type(course_type) :: first
    type(dd) :: time
    if (allocated(scene%response)) then
      if (scene%release%time >= scene%response%duration) then
        call add_note(result, 'release: comes after the end of the record, which shows nothing of it')
        return
      end if
    end if
    time = to_dd(scene%release%time)/result%units%time
    if (leaves_range(loaded, time)) then
      call add_note(result, 'release: by then the motion has grown out of the range of numbers')
      return
    end if
    first = course_type(loaded_modes, dd(), 0.0_dp*result%modal_velocity, result%modal_velocity)
    release = release_from(first)
    result%courses = [first, course_type(free_modes, time, release%q, release%rate)]
    release%event%time = scene%release%time
    release%event%end_time = scene%release%time
    result%events = [result%events, release%event]
    call note_release(release, result)
  contains
    type(release_type) function release_from(course)
      type(course_type), intent(in) :: course
      real(dp) :: q(loaded%count), rate(loaded%count)
      q = course%q
      rate = course%rate
      call move(loaded, time, q, rate)
      release_from = release_mass(loaded, q, rate, free, speed_in_plane(scene%rotation, result%units))
    end function release_from
  end subroutine release_in_time

  subroutine meet_again(scene, free, result)
    !! Contacts of a mass that rebounded.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: free
    type(case_result), intent(inout) :: result
    type(contacts_type) :: contacts
    if (scene%impact%mass_ratio == 0.0_dp .or. result%approach_velocity == 0.0_dp) return
    call follow_contacts(free, scene%impact%mass_ratio, scene%impact%restitution, &
                         speed_in_plane(scene%rotation, result%units), result%modal_velocity, &
                         result%impact%mass_velocity, scene%response%duration/result%units%time%hi, &
                         scene%recontact%max_contacts, contacts)
    call in_seconds(contacts%events, scene%response%duration, result)
    result%events = [result%events, contacts%events]
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
    real(dp) :: unit
    unit = result%units%mass*result%approach_velocity**2
    call add_note(result, 'energy of the release: the mass leaves with '//shortest(release%kinetic_leaving*unit, 4)// &
                  ' J of motion ('//shortest(release%energy_leaving*unit, 4)//' J with what the centrifugal force '// &
                  'does) of '//shortest(release%event%energy_before*unit, 4)// &
                  ' J in all; the modes of the beam alone miss '//shortest(release%energy_lost*unit, 2)//' J')
  end subroutine note_release

end module bw_later_events
