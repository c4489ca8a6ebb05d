module bw_timeline
  !! The motion of a case as one list: segments, in which the modes of a configuration move on exactly, and changes between them, at
  !! which the state jumps or goes over to other modes. What a scene makes happen, and when, is asked here alone.
  use bw_beam_units, only: beam_units
  use bw_double_double, only: dd, to_dd, operator(/)
  use bw_event, only: event_type, release_event
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_scene, only: scene_type
  use bw_segment, only: alone, leaves_range, segment_type
  implicit none (type, external)
  private
  public :: changes_of, comes_back, happens, most_events

  type, public :: change_type
    !! A change at a time that the scene gives.
    integer :: kind = release_event                 !! of the event
    integer :: configuration = alone                !! that moves from then on
    real(dp) :: seconds = 0.0_dp
    type(dd) :: time                                !! l²/h
  end type change_type

  type, public :: timeline_type
    type(event_type), allocatable :: events(:)      !! in the order of time
    type(segment_type), allocatable :: segments(:)  !! in the order of time; none where nothing strikes the beam
    real(dp) :: known_until = huge(1.0_dp)          !! l²/h; nothing is known of the motion from then on
  end type timeline_type

contains

  pure function changes_of(scene, units) result(changes)
    !! After t = 0, in the order of time.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(change_type), allocatable :: changes(:)
    allocate (changes(0))
    if (allocated(scene%release)) &
      changes = [change_type(release_event, alone, scene%release%time, to_dd(scene%release%time)/units%time)]
  end function changes_of

  pure logical function happens(change, scene, since, modes)
    !! A change counts where it comes before the record ends, and before a growing mode leaves the range of numbers.
    type(change_type), intent(in) :: change
    type(scene_type), intent(in) :: scene
    type(dd), intent(in) :: since                   !! from the start of the segment before it, l²/h
    class(mode_set), intent(in) :: modes            !! that move until then
    happens = .not. leaves_range(modes, since)
    if (allocated(scene%response)) happens = happens .and. change%seconds < scene%response%duration
  end function happens

  pure logical function comes_back(scene)
    !! Whether the beam moves without the mass again, after it has captured it.
    type(scene_type), intent(in) :: scene
    comes_back = allocated(scene%release)
  end function comes_back

  pure integer function most_events(scene, contacts) result(events)
    !! That a scene may have.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: contacts                 !! that are followed, at most
    events = count([allocated(scene%impact), allocated(scene%capture), allocated(scene%release)])
    if (allocated(scene%recontact)) events = events + contacts
  end function most_events

end module bw_timeline
