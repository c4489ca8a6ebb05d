module bw_timeline
  !! The timeline of a case: segments, in which the modes of one configuration move, and events between them, at which
  !! the state jumps or is projected onto other modes. The events of a scene, and their times, are found only here.
  !!
  !! A configuration is the set of bodies on the beam. A captured mass is the last of them.
  use bw_beam_units, only: beam_units
  use bw_double_double, only: dd, to_dd, operator(/)
  use bw_event, only: event_type
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_mode_set, only: mode_set
  use bw_scene, only: at_start, has_configurations, scene_type
  use bw_segment, only: leaves_range, segment_type
  implicit none (type, external)
  private
  public :: configurations_of, is_released, later_steps, most_configurations, most_events, number_of, occurs_in_record, start_of, &
    steps_of, time_of

  type, public :: carried_type
    !! What the beam carries.
    logical, allocatable :: body(:)                 !! bodies of the scene on the beam, (bodies)
    logical :: captured = .false.                   !! the striking mass is on it, too
  end type carried_type

  type, public :: step_type
    !! An instant at which the mass strikes, or bodies arrive or leave, all at once.
    real(dp) :: seconds = 0.0_dp
    type(carried_type) :: carried                   !! from then on
    logical :: is_impact = .false.                  !! the mass strikes
    logical :: is_capture = .false.                 !! it stays
    logical :: is_release = .false.                 !! it leaves
  end type step_type

  type, public :: timeline_type
    type(event_type), allocatable :: events(:)      !! in order of time
    type(segment_type), allocatable :: segments(:)  !! in order of time; empty: no motion
    real(dp) :: known_until = huge(1.0_dp)          !! l²/h; the motion is unknown from then on
  end type timeline_type

contains

  pure function steps_of(scene) result(steps)
    !! Return all events of a scene in order of time. The first entry is the configuration before t = 0.
    type(scene_type), intent(in) :: scene
    type(step_type), allocatable :: steps(:)
    real(dp), allocatable :: times(:)
    type(step_type) :: step
    integer :: i
    allocate (step%carried%body(size(at_start(scene))))
    if (allocated(scene%bodies)) step%carried%body = is_missing(scene%bodies%from)
    steps = [step]
    if (allocated(scene%impact)) then
      step%is_impact = .true.
      steps = [steps, step]
      step%is_impact = .false.
      step%is_capture = allocated(scene%capture)
      step%carried%captured = step%is_capture
      if (step%is_capture) steps = [steps, step]
      step%is_capture = .false.
    end if
    times = times_of(scene)
    do i = 1, size(times)
      step%seconds = times(i)
      step%is_release = .false.
      if (allocated(scene%release)) step%is_release = scene%release%time == times(i)
      if (step%is_release) step%carried%captured = .false.
      if (allocated(scene%bodies)) then
        where (scene%bodies%from == times(i)) step%carried%body = .true.
        where (scene%bodies%until == times(i)) step%carried%body = .false.
      end if
      steps = [steps, step]
    end do
  end function steps_of

  pure function later_steps(scene) result(steps)
    !! Return the events after t = 0 in order of time.
    type(scene_type), intent(in) :: scene
    type(step_type), allocatable :: steps(:)
    steps = steps_of(scene)
    steps = steps(1 + count(steps%seconds <= 0.0_dp):)
  end function later_steps

  pure type(dd) function time_of(step, units) result(time)
    !! Return the time of an event, l²/h.
    type(step_type), intent(in) :: step
    type(beam_units), intent(in) :: units
    time = to_dd(step%seconds)/units%time
  end function time_of

  pure function times_of(scene) result(times)
    !! Return the times at which bodies arrive or leave, ascending and distinct.
    type(scene_type), intent(in) :: scene
    real(dp), allocatable :: times(:)
    real(dp), allocatable :: all(:)
    allocate (all(0), times(0))
    if (allocated(scene%bodies)) all = pack([scene%bodies%from, scene%bodies%until], &
                                            .not. is_missing([scene%bodies%from, scene%bodies%until]))
    if (allocated(scene%release)) all = [all, scene%release%time]
    do while (size(all) > 0)
      times = [times, minval(all)]
      all = pack(all, all > times(size(times)))
    end do
  end function times_of

  pure function configurations_of(scene) result(configurations)
    !! Return the configurations of a case. If the beam changes in time, each occurs once, in order of occurrence; else
    !! the beam alone, and with the mass if that is captured.
    type(scene_type), intent(in) :: scene
    type(carried_type), allocatable :: configurations(:)
    type(step_type), allocatable :: steps(:)
    if (.not. has_configurations(scene)) then
      configurations = [carried_type(at_start(scene), .false.)]
      if (allocated(scene%capture)) configurations = [configurations, carried_type(at_start(scene), .true.)]
      return
    end if
    steps = steps_of(scene)
    allocate (configurations(0))
    if (allocated(scene%contact)) then             ! the time of capture is not known yet
      steps%carried%captured = .false.
      call add_new(steps, configurations)
      steps%carried%captured = allocated(scene%capture)
    end if
    call add_new(steps, configurations)
  contains
    pure subroutine add_new(steps, configurations)
      type(step_type), intent(in) :: steps(:)
      type(carried_type), allocatable, intent(inout) :: configurations(:)
      integer :: i
      do i = 1, size(steps)
        if (number_of(configurations, steps(i)%carried) == 0) configurations = [configurations, steps(i)%carried]
      end do
    end subroutine add_new
  end function configurations_of

  pure type(carried_type) function start_of(scene) result(carried)
    !! Return what the beam carries after all events at t = 0.
    type(scene_type), intent(in) :: scene
    carried = carried_type(at_start(scene), allocated(scene%capture))
  end function start_of

  pure integer function number_of(configurations, carried) result(number)
    !! Return the index of a configuration; 0: none.
    type(carried_type), intent(in) :: configurations(:)
    type(carried_type), intent(in) :: carried
    do number = size(configurations), 1, -1
      if (all(configurations(number)%body .eqv. carried%body) .and. &
          (configurations(number)%captured .eqv. carried%captured)) return
    end do
  end function number_of

  pure logical function occurs_in_record(step, scene, since, modes)
    !! Return whether an event comes before the end of the record and before a growing mode overflows.
    type(step_type), intent(in) :: step
    type(scene_type), intent(in) :: scene
    type(dd), intent(in) :: since                   !! since the start of the segment before, l²/h
    class(mode_set), intent(in) :: modes            !! of that segment
    occurs_in_record = .not. leaves_range(modes, since)
    if (allocated(scene%response)) occurs_in_record = occurs_in_record .and. step%seconds < scene%response%duration
  end function occurs_in_record

  pure logical function is_released(scene)
    !! Return whether a captured mass is released later.
    type(scene_type), intent(in) :: scene
    is_released = allocated(scene%release)
  end function is_released

  pure integer function most_configurations(scene) result(configurations)
    !! Return the most configurations of any case of a scene that changes in time.
    type(scene_type), intent(in) :: scene
    configurations = size(configurations_of(scene))
    if (size(scene%sweeps) == 0) return
    configurations = 1 + most_events(scene, 0)     ! cases may have fewer
    if (allocated(scene%contact) .and. allocated(scene%capture)) configurations = 2*configurations
  end function most_configurations

  pure integer function most_events(scene, contacts) result(events)
    !! Return the most events of any case of a scene.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: contacts                 !! upper limit
    events = count([allocated(scene%impact), allocated(scene%capture), allocated(scene%release)])
    if (has_configurations(scene)) then
      events = size(steps_of(scene)) - 1
      if (size(scene%sweeps) > 0 .and. allocated(scene%bodies)) events = count([allocated(scene%impact), &
        allocated(scene%capture), allocated(scene%release), .not. is_missing(scene%bodies%from), &
        .not. is_missing(scene%bodies%until)])     ! cases may have fewer, as two at once are one
    end if
    if (allocated(scene%recontact)) events = events + contacts
  end function most_events

end module bw_timeline
