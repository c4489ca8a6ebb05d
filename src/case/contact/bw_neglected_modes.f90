module bw_neglected_modes
  !! What the modes beyond those that are summed would add to the motion of a beam that is struck: as many modes more, driven by the forces
  !! of its contacts as they were found, less what follows these forces at once, which is added. Of a motion whose contacts hardly feel
  !! those modes that is what is missing, but for the modes that come after them.
  !!
  !! Where the beam changes, what they have done goes over to the modes after it, and so does what the motion hands on to the octave that
  !! is missing there. What of it comes to modes that are summed is missing, too.
  use bw_beam_units, only: beam_units
  use bw_case_bodies, only: bodies_of, presence
  use bw_case_histories, only: find_loaded_segments, sum_histories
  use bw_case_moments, only: scale_of_moments
  use bw_case_result, only: case_histories, case_motion
  use bw_change_of_bodies, only: beam_state, body_type, hand_over
  use bw_double_double, only: operator(-)
  use bw_event, only: event_type
  use bw_first_motion, only: find_first_motion
  use bw_force_step, only: drive, find_step_end, force_in_step, polynomial_of
  use bw_kinds, only: dp
  use bw_loads_beside, only: taking_part
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: is_missing
  use bw_mode_set, only: configuration_type, curvatures, deflections, first_numbers, mode_set, turns, values_at
  use bw_monitor, only: monitor_type
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_oscillators, only: oscillators, oscillators_of
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: alone, load_type, move, segment_type
  use bw_timeline, only: carried_type, configurations_of
  implicit none (type, external)
  private
  public :: find_neglected, hand_on

  type, public :: neglected_type
    !! The largest magnitudes of what the next octave of modes would add, SI; unallocated where there are no more modes.
    real(dp), allocatable :: displacement(:), velocity(:), bending_moment(:), acceleration(:), shear_force(:)   !! (points)
    real(dp) :: struck = 0.0_dp                      !! of the velocity of the place that the mass strikes, in contacts
  end type neglected_type

contains

  subroutine find_neglected(scene, motion, summed, monitor, workspace, neglected)
    !! Beside the forces of all contacts nothing acts on the beam.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion          !! followed with the modes that are summed
    integer, intent(in) :: summed                    !! of the first configuration
    class(monitor_type), intent(inout), target :: monitor   !! what is found means nothing where it asks to stop
    type(nonuniform_sum), intent(inout) :: workspace(:)
    type(neglected_type), intent(out) :: neglected
    type(case_motion) :: beyond
    integer, allocatable :: first(:)                 ! of the modes beyond, (configurations)
    if (size(motion%timeline%segments) == 0) return
    beyond%units = motion%units
    beyond%timeline%known_until = motion%timeline%known_until
    call find_octaves(scene, motion, summed, beyond%modes%configuration, first, monitor)
    if (monitor%stop_requested()) return
    if (any(first == 0)) return
    call drive_through(scene, motion%timeline%segments, first, beyond, neglected%struck, monitor)
    if (monitor%stop_requested()) return
    neglected%struck = abs(unit_velocity(scene))*neglected%struck
    call find_loaded_segments(scene, beyond, monitor)
    if (monitor%stop_requested()) return
    call look(deflections, neglected%displacement, neglected%velocity)
    if (monitor%stop_requested()) return
    if (.not. scene%response%bending_moment) return
    call look(curvatures, neglected%bending_moment)
    neglected%bending_moment = neglected%bending_moment*scale_of_moments(scene)
  contains
    subroutine look(quantity, value, rate)
      integer, intent(in) :: quantity
      real(dp), allocatable, intent(out) :: value(:)
      real(dp), allocatable, intent(out), optional :: rate(:)
      type(case_histories) :: found
      integer :: p
      call sum_histories(scene, beyond, quantity, monitor, workspace, found)
      if (monitor%stop_requested()) return
      associate (response => found%response, n => found%response%finite_samples)
        value = [(largest_magnitude(response%displacement(:n, p)), p=1, size(scene%response%points))]
        if (present(rate) .and. scene%response%velocity) &
          rate = [(largest_magnitude(response%velocity(:n, p)), p=1, size(scene%response%points))]
      end associate
    end subroutine look
  end subroutine find_neglected

  subroutine find_octaves(scene, motion, summed, configuration, first, monitor)
    !! The next octave of modes of each configuration; if there are several, behind its summed modes, which forces do not move again.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: summed
    type(configuration_type), allocatable, intent(out) :: configuration(:)
    integer, allocatable, intent(out) :: first(:)    !! of the octave in each set; 0: it has no more modes, (configurations)
    class(monitor_type), intent(inout) :: monitor    !! what is found means nothing where it asks to stop
    integer :: c, more, n
    allocate (configuration(size(motion%modes%configuration)))
    allocate (first(size(configuration)), source=1)
    do c = 1, size(configuration)
      associate (segments => motion%timeline%segments, source => motion%modes%configuration(c)%source)
        if (c /= alone .and. .not. any(segments%configuration == c)) cycle
        n = taking_part(motion, c, summed)
        more = min(n, source%highest - n)
        if (more <= 0) then
          first(c) = 0
        else if (any(segments%configuration /= alone)) then
          first(c) = n + 1
          call source%find(first_numbers(n + more), configuration(c)%set, scene%response%duration/motion%units%time%hi, monitor)
          if (monitor%stop_requested()) return
          configuration(c)%set%struck(:n) = 0.0_dp
        else
          call source%find(n + first_numbers(more), configuration(c)%set, scene%response%duration/motion%units%time%hi, monitor)
          if (monitor%stop_requested()) return
        end if
      end associate
    end do
  end subroutine find_octaves

  subroutine drive_through(scene, segments, first, beyond, struck, monitor)
    !! The segments of a motion once more, for other modes: each starts where the one before it left them.
    type(scene_type), intent(in) :: scene
    type(segment_type), intent(in) :: segments(:)
    integer, intent(in) :: first(:)                  !! of the modes that forces move, (configurations)
    type(case_motion), intent(inout) :: beyond       !! its modes are known
    real(dp), intent(out) :: struck                  !! largest speed of the struck place at the ends of steps of contacts, less what
                                                     !! follows the force at once
    class(monitor_type), intent(inout) :: monitor    !! what is found means nothing where it asks to stop
    type(oscillators) :: parts
    real(dp), allocatable :: q(:), rate(:), following(:, :), soft(:)
    real(dp) :: force(2)                             ! and its rate, at the end of a step
    integer :: i, now
    call find_first_motion(scene, alone, beyond, q, rate)
    q = q/unit_velocity(scene)
    rate = rate/unit_velocity(scene)
    q(:first(alone) - 1) = 0.0_dp
    rate(:first(alone) - 1) = 0.0_dp
    struck = 0.0_dp
    allocate (beyond%timeline%segments(size(segments)))
    allocate (beyond%ladder(0:maxval([(levels_in(segments(i)), i=1, size(segments))]), size(beyond%modes%configuration)))
    call begin(alone)
    do i = 1, size(segments)
      if (monitor%stop_requested()) return
      associate (given => segments(i), own => beyond%timeline%segments(i))
        if (given%configuration /= now) call change(given)
        if (monitor%stop_requested()) return
        associate (set => beyond%modes%configuration(now)%set)
          own = segment_type(now, given%start, count=set%count, q=q, rate=rate)
          force = 0.0_dp
          if (allocated(given%load)) then
            own%load = load_type(given%load%length, given%load%level, given%load%force, set%count, -following)
            call press(own%load)
          else if (i < size(segments)) then
            call move(set, segments(i + 1)%start - given%start, q, rate)
          end if
        end associate
      end associate
    end do
  contains
    subroutine change(next)
      !! To the modes of a segment.
      type(segment_type), intent(in) :: next
      q = q - force(1)*soft                          ! which the motion itself hands on
      rate = rate - force(2)*soft
      call hand_on(scene, beyond%units, beyond%modes%configuration, [now, next%configuration], [now, next%configuration], q, rate, &
                   monitor)
      if (monitor%stop_requested()) return
      call begin(next%configuration)
      if (.not. allocated(next%beyond)) return
      q(first(now):) = q(first(now):) + next%beyond(:, 1)
      rate(first(now):) = rate(first(now):) + next%beyond(:, 2)
    end subroutine change

    subroutine begin(configuration)
      integer, intent(in) :: configuration
      real(dp), allocatable :: c(:)
      now = configuration
      force = 0.0_dp
      associate (set => beyond%modes%configuration(now)%set, k => first(configuration))
        c = 0.0_dp*set%modal_mass
        if (allocated(set%damping)) c = set%damping
        parts = oscillators_of(set%beta_squared, c)
        soft = 0.0_dp*c
        soft(k:) = set%struck(k:)/(set%modal_mass(k:)*set%beta_squared(k:)%hi)
        following = what_follows(set, soft, scene%response%points)
      end associate
    end subroutine begin

    subroutine press(load)
      !! To the end of a contact, whose last step may be of any length.
      type(load_type), intent(in) :: load
      integer :: j
      associate (set => beyond%modes%configuration(now)%set, last => size(load%length))
        do j = 1, last - 1
          associate (step => beyond%ladder(load%level(j), now))
            if (step%length <= 0.0_dp) call find_step_end(parts, set%struck, set%modal_mass, load%length(j), step)
            call step%advance(load%force(:, j), q, rate)
          end associate
          call see(load%force(:, j), load%length(j))
        end do
        if (last == 0) return
        call drive(parts, set%struck, set%modal_mass, load%length(last), 1.0_dp, load%force(:, last), q, rate)
        call see(load%force(:, last), load%length(last))
      end associate
    end subroutine press

    subroutine see(values, length)
      !! How fast the struck place moves at the end of a step.
      real(dp), intent(in) :: values(0:), length
      call force_in_step(polynomial_of(values), 1.0_dp, force(1), force(2))
      force(2) = force(2)/length
      struck = max(struck, abs(dot_product(beyond%modes%configuration(now)%set%struck, rate - force(2)*soft)))
    end subroutine see
  end subroutine drive_through

  pure integer function levels_in(segment) result(levels)
    !! Of the steps of its load.
    type(segment_type), intent(in) :: segment
    levels = 0
    if (.not. allocated(segment%load)) return
    if (size(segment%load%level) > 0) levels = maxval(segment%load%level)
  end function levels_in

  pure function what_follows(modes, soft, points) result(shown)
    !! What modes add at once under a force of 1 where the mass strikes: displacements, curvatures and the turn of the hub.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: soft(:)                  !! their modal displacements then
    real(dp), intent(in) :: points(:)                !! ξ
    real(dp) :: shown(size(points), 3)
    integer, parameter :: quantities(3) = [deflections, curvatures, turns]
    integer :: i
    do i = 1, size(quantities)
      shown(:, quantities(i)) = matmul(soft, values_at(modes, quantities(i), 1, modes%count, points))
    end do
  end function what_follows

  subroutine hand_on(scene, units, configuration, which, number, q, rate, monitor)
    !! What modes have done beyond those that are summed, and beyond what follows forces at once, goes over to other modes; springs are at
    !! rest then, and what bodies bring moves the modes that are summed.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(configuration_type), intent(in) :: configuration(:)
    integer, intent(in) :: which(2)                  !! of these, before and after,
    integer, intent(in) :: number(2)                 !! and of those of the scene
    real(dp), allocatable, intent(inout) :: q(:), rate(:)   !! (modes before), then (modes after)
    class(monitor_type), intent(inout) :: monitor    !! the state means nothing where it asks to stop
    type(carried_type), allocatable :: carried(:)
    type(body_type), allocatable :: bodies(:)
    type(beam_state) :: beyond, later
    type(event_type) :: ignored
    carried = configurations_of(scene)
    bodies = bodies_of(scene, units)
    bodies%stiffness = 0.0_dp
    bodies%turning_stiffness = 0.0_dp
    bodies%pull = 0.0_dp
    where (.not. is_missing(bodies%velocity)) bodies%velocity = 0.0_dp
    if (carried(number(2))%captured) bodies(size(bodies))%velocity = 0.0_dp
    beyond = beam_state(size(q), q, rate)
    allocate (beyond%shape(0))
    call hand_over(configuration, which(1), beyond, presence(scene, carried(number(1))), which(2), &
                   configuration(which(2))%set%count, presence(scene, carried(number(2))), bodies, 0.0_dp, later, ignored, monitor)
    q = later%q
    rate = later%rate
  end subroutine hand_on

end module bw_neglected_modes
