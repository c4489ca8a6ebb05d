module bw_contact_projection
  !! The state of a beam in lasting contacts, and its projection onto other modes as bodies join or leave. Within a contact, the
  !! quasi-static deflection of omitted modes under its force is projected as well.
  use bw_acting_loads, only: acting_loads
  use bw_beam_motion, only: beam_motion
  use bw_case_bodies, only: beam_of, presence
  use bw_change_of_bodies, only: beam_state, body_type, change_bodies, change_type
  use bw_contact_flexibility, only: flexibility_type
  use bw_contact_steps, only: contact_run
  use bw_double_double, only: dd
  use bw_event, only: event_type
  use bw_force_step, only: force_in_step, polynomial_of
  use bw_kinds, only: dp
  use bw_lasting_contact, only: lasting_contacts
  use bw_load_course, only: loads_before
  use bw_loads_beside, only: modes_taking_part
  use bw_mode_set, only: configuration_type, first_numbers, mode_set
  use bw_monitor, only: monitor_type
  use bw_placed_loads, only: find_drive, placed_loads
  use bw_rotation, only: speed_in_plane
  use bw_scene, only: scene_type
  use bw_timeline, only: carried_type, configurations_of, number_of
  use bw_unprojected, only: unprojected_errors
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: change_configuration

  type, public :: contact_progress
    integer :: summed = 0                            !! modes of the first configuration
    type(placed_loads), allocatable :: placed        !! loads besides the contacts, N; unallocated: none
    integer :: configuration = 1
    type(carried_type) :: carried
    logical, allocatable :: there(:)                 !! bodies that the beam carries, (bodies)
    type(body_type), allocatable :: bodies(:)        !! the last is the mass if it is captured
    type(flexibility_type) :: flexibility
    type(acting_loads), allocatable :: loads         !! in terms of modes and mass; unallocated: none
    type(beam_state) :: state                        !! after the last change or, after the capture, at the end of a segment
    real(dp), allocatable :: error(:, :), beyond(:, :)   !! after the last change, see segment_type
    type(contact_run) :: run
  end type contact_progress

contains

  subroutine change_configuration(scene, carried, time, motion, now, contacts, event, monitor)
    !! Project the motion onto the modes of the beam with the bodies that it carries from now on.
    type(scene_type), intent(in) :: scene
    type(carried_type), intent(in) :: carried
    type(dd), intent(in) :: time
    class(beam_motion), intent(in) :: motion
    type(contact_progress), intent(inout) :: now
    type(lasting_contacts), intent(in) :: contacts
    type(event_type), intent(inout) :: event
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(beam_state) :: later
    real(dp) :: unsummed_at(size(now%bodies), 2, 2), force(2)
    real(dp) :: follows(now%state%count, 2)          ! quasi-static part of the projected modes, displacements and velocities
    real(dp), allocatable :: load(:, :)              ! loads and their rates, (loads, 2)
    real(dp), allocatable :: unsummed(:)
    type(configuration_type), allocatable :: wide(:)   ! with the next octave of modes after the change
    logical, allocatable :: is(:)
    real(dp) :: spin_squared
    type(change_type) :: change
    integer :: i, l, next
    spin_squared = speed_in_plane(scene%rotation, motion%units)**2
    next = number_of(configurations_of(scene), carried)
    is = presence(scene, carried)
    force = 0.0_dp
    if (now%run%captured .neqv. now%carried%captured .or. .not. now%run%ended) force = last_force(contacts)
    unsummed_at(:, :, 1) = force(1)*now%flexibility%at_bodies
    unsummed_at(:, :, 2) = force(2)*now%flexibility%at_bodies
    associate (set => motion%modes%configuration(now%configuration)%set, n => now%state%count)
      follows = spread(set%struck(:n)/(set%modal_mass(:n)*max(set%beta_squared(:n)%hi, 1.0_dp)), 2, 2)*spread(force, 1, n)
    end associate
    if (allocated(now%loads)) then
      load = loads_before(now%loads%course, time%hi)
      associate (square => motion%modes%configuration(now%configuration)%set%beta_squared(:now%state%count)%hi)
        do l = 1, size(load, 1)
          do i = 1, 2
            unsummed_at(:, :, i) = unsummed_at(:, :, i) + load(l, i)*now%flexibility%of_loads(:, :, l)
            where (square > 1.0_dp) follows(:, i) = follows(:, i) + load(l, i)*now%loads%drive(:now%state%count, l)/square
          end do
        end do
      end associate
    end if
    associate (configuration => motion%modes%configuration)
      change = change_type(now%configuration, next, now%there, is, modes_taking_part(motion, next, now%summed))
      wide = configuration
      call wide(next)%source%find(first_numbers(min(2*change%count, wide(next)%source%highest)), wide(next)%set, monitor=monitor)
      if (monitor%stop_requested()) return
      if (force(1) /= 0.0_dp .or. allocated(now%placed)) then
        call project_omitted(beam_of(scene, motion%units, now%carried), configuration(now%configuration), now, force(1), load, &
                             wide(next)%set, monitor, unsummed)
        if (monitor%stop_requested()) return
      end if
      call project_octave(wide, now, change, spin_squared, unsummed_at, unsummed, monitor)
      if (monitor%stop_requested()) return
      if (allocated(unsummed)) unsummed = unsummed(:configuration(next)%set%count)
      call change_bodies(configuration, change, now%state, now%bodies, spin_squared, later, event, monitor, unsummed_at, unsummed)
      if (monitor%stop_requested()) return
      associate (n => now%state%count)
        now%error = unprojected_errors(configuration(now%configuration)%set, now%state%q(:n) - follows(:, 1), &
                                       now%state%rate(:n) - follows(:, 2), configuration(next)%set, now%bodies, now%there, is)
      end associate
    end associate
    event%end_time = event%time
    now%configuration = next
    now%carried = carried
    now%there = is
    now%state = later
  end subroutine change_configuration

  subroutine project_octave(wide, now, change, spin_squared, unsummed_at, unsummed, monitor)
    !! Project the motion onto the next octave of modes after a change.
    type(configuration_type), intent(in) :: wide(:)  !! with that octave
    type(contact_progress), intent(inout) :: now     !! its `beyond` is set
    type(change_type), intent(in) :: change
    real(dp), intent(in) :: spin_squared
    real(dp), intent(in) :: unsummed_at(:, :, :)     !! see `beyond` of `change_bodies`
    real(dp), allocatable, intent(in) :: unsummed(:) !! see `change_bodies`
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(change_type) :: whole                       ! with all of these modes
    type(body_type), allocatable :: bodies(:)
    type(beam_state) :: later
    type(event_type) :: ignored
    bodies = now%bodies
    whole = change
    whole%count = wide(change%onto)%set%count
    call change_bodies(wide, whole, now%state, bodies, spin_squared, later, ignored, monitor, unsummed_at, unsummed)
    if (monitor%stop_requested()) return
    associate (first => change%count + 1)
      now%beyond = reshape([later%q(first:), later%rate(first:)], [size(later%q) - change%count, 2])
    end associate
  end subroutine project_octave

  subroutine project_omitted(given, configuration, now, force, load, after, monitor, unsummed)
    !! Project the quasi-static deflection of the omitted modes onto the modes after a change.
    type(varying_beam), intent(in) :: given          !! before the change
    type(configuration_type), intent(in) :: configuration
    type(contact_progress), intent(in) :: now
    real(dp), intent(in) :: force                    !! of the contact
    real(dp), allocatable, intent(in) :: load(:, :)  !! other loads and their rates, (loads, 2); unallocated: none
    class(mode_set), intent(in) :: after
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    real(dp), allocatable, intent(out) :: unsummed(:)       !! (modes after)
    integer, parameter :: times_as_many = 4          ! modes, over those summed
    class(mode_set), allocatable :: before
    real(dp), allocatable :: drive(:, :), nothing(:, :), pressed(:)
    real(dp) :: no_points(0)
    associate (summed => now%state%count, source => configuration%source)
      call source%find(first_numbers(min(source%highest, times_as_many*summed)), before, monitor=monitor)
      if (monitor%stop_requested()) return
      pressed = force*before%struck
      if (allocated(now%placed)) then
        allocate (nothing(before%count, 0))
        call find_drive(given, before, now%placed%place, now%placed%accelerated, monitor, drive, no_points, nothing)
        if (monitor%stop_requested()) return
        pressed = pressed + matmul(drive(:, now%placed%kind), load(:, 1))
      end if
      pressed(:summed) = 0.0_dp
      pressed(summed + 1:) = pressed(summed + 1:)/(before%modal_mass(summed + 1:)*before%beta_squared(summed + 1:)%hi)
      unsummed = after%overlap(before, pressed, .false., monitor)
    end associate
  end subroutine project_omitted

  pure function last_force(contacts) result(force)
    !! Return the contact force and its rate at the end of the last segment; 0 in flight.
    type(lasting_contacts), intent(in) :: contacts
    real(dp) :: force(2)
    integer :: n
    force = 0.0_dp
    if (size(contacts%segments) == 0) return
    associate (last => contacts%segments(size(contacts%segments)))
      if (.not. allocated(last%load)) return
      n = size(last%load%length)
      call force_in_step(polynomial_of(last%load%force(:, n)), 1.0_dp, force(1), force(2))
      force(2) = force(2)/last%load%length(n)
    end associate
  end function last_force

end module bw_contact_projection
