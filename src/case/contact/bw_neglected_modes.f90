module bw_neglected_modes
  !! The contribution of the next octave of modes to the motion of a struck beam. These modes are driven by the known
  !! contact forces; their quasi-static part is subtracted, as the histories include it as residual flexibility. If
  !! contacts hardly feel these modes, this is the truncation error but for higher octaves.
  !!
  !! At a change of the beam this motion is projected onto the modes after it, and so is the summed motion onto their
  !! next octave. Its projection onto summed modes is part of the error.
  use bw_beam_units, only: beam_units
  use bw_case_bodies, only: bodies_of, presence
  use bw_case_histories, only: find_loaded_segments, sum_histories
  use bw_case_moments, only: scale_of_moments
  use bw_case_result, only: case_histories, case_motion
  use bw_change_of_bodies, only: beam_state, body_type, change_bodies, change_type
  use bw_double_double, only: operator(-)
  use bw_event, only: event_type
  use bw_first_motion, only: find_first_motion
  use bw_force_step, only: advance_state, find_step_end, force_in_step, polynomial_of
  use bw_kinds, only: dp
  use bw_loads_beside, only: modes_taking_part
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: is_missing
  use bw_mode_set, only: configuration_type, curvatures, damping_rates, deflections, first_numbers, mode_set, turns, values_at
  use bw_monitor, only: monitor_type
  use bw_oscillators, only: oscillators, oscillators_of
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: alone, load_type, move, segment_type
  use bw_timeline, only: carried_type, configurations_of
  implicit none (type, external)
  private
  public :: find_neglected, project_neglected

  type, public :: neglected_type
    !! Largest contribution of the next octave of modes, SI; unallocated if there are no more modes.
    real(dp), allocatable :: displacement(:), velocity(:), bending_moment(:), acceleration(:), shear_force(:)   !! (points)
    real(dp) :: struck = 0.0_dp                      !! to the velocity of the struck place, in contacts
  end type neglected_type

contains

  subroutine find_neglected(scene, motion, summed, monitor, neglected)
    !! Find the contribution of the next octave of modes under the contact forces alone.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion          !! of the summed modes
    integer, intent(in) :: summed                    !! modes of the first configuration
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(neglected_type), intent(out) :: neglected
    type(case_motion) :: beyond
    integer, allocatable :: first(:)                 ! mode of the next octave, (configurations)
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
    call find_largest(deflections, neglected%displacement, neglected%velocity)
    if (monitor%stop_requested()) return
    if (.not. scene%response%bending_moment) return
    call find_largest(curvatures, neglected%bending_moment)
    neglected%bending_moment = neglected%bending_moment*scale_of_moments(scene)
  contains
    subroutine find_largest(quantity, value, rate)
      integer, intent(in) :: quantity
      real(dp), allocatable, intent(out) :: value(:)
      real(dp), allocatable, intent(out), optional :: rate(:)
      type(case_histories) :: found
      integer :: p
      call sum_histories(scene, beyond, quantity, monitor, found)
      if (monitor%stop_requested()) return
      associate (response => found%response, n => found%response%finite_samples)
        value = [(largest_magnitude(response%displacement(:n, p)), p=1, size(scene%response%points))]
        if (present(rate) .and. scene%response%velocity) &
          rate = [(largest_magnitude(response%velocity(:n, p)), p=1, size(scene%response%points))]
      end associate
    end subroutine find_largest
  end subroutine find_neglected

  subroutine find_octaves(scene, motion, summed, configuration, first, monitor)
    !! Find the next octave of modes of each configuration. If the beam changes, the summed modes come before them, without forces.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: summed
    type(configuration_type), allocatable, intent(out) :: configuration(:)
    integer, allocatable, intent(out) :: first(:)    !! mode of the octave in each set; 0: there are no more modes, (configurations)
    class(monitor_type), intent(inout) :: monitor    !! results are invalid if it requests a stop
    integer :: c, more, n
    allocate (configuration(size(motion%modes%configuration)))
    allocate (first(size(configuration)), source=1)
    do c = 1, size(configuration)
      associate (segments => motion%timeline%segments, source => motion%modes%configuration(c)%source)
        if (c /= alone .and. .not. any(segments%configuration == c)) cycle
        n = modes_taking_part(motion, c, summed)
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
    !! Follow other modes through all segments of a motion, each from the state at the end of the one before.
    type(scene_type), intent(in) :: scene
    type(segment_type), intent(in) :: segments(:)
    integer, intent(in) :: first(:)                  !! mode that forces drive, (configurations)
    type(case_motion), intent(inout) :: beyond       !! its modes are known
    real(dp), intent(out) :: struck                  !! largest speed of the struck place at the ends of contact steps, less its
                                                     !! quasi-static part
    class(monitor_type), intent(inout) :: monitor    !! results are invalid if it requests a stop
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
            call move_in_contact(own%load)
          else if (i < size(segments)) then
            call move(set, segments(i + 1)%start - given%start, q, rate)
          end if
        end associate
      end associate
    end do
  contains
    subroutine change(next)
      !! Project the motion onto the modes of the next segment.
      type(segment_type), intent(in) :: next
      q = q - force(1)*soft                          ! less the quasi-static part, which the summed motion projects
      rate = rate - force(2)*soft
      call project_neglected(scene, beyond%units, beyond%modes%configuration, [now, next%configuration], [now, &
        next%configuration], q, rate, &
                   monitor)
      if (monitor%stop_requested()) return
      call begin(next%configuration)
      if (.not. allocated(next%beyond)) return
      q(first(now):) = q(first(now):) + next%beyond(:, 1)
      rate(first(now):) = rate(first(now):) + next%beyond(:, 2)
    end subroutine change

    subroutine begin(configuration)
      integer, intent(in) :: configuration
      now = configuration
      force = 0.0_dp
      associate (set => beyond%modes%configuration(now)%set, k => first(configuration))
        parts = oscillators_of(set%beta_squared, damping_rates(set))
        soft = 0.0_dp*set%modal_mass
        soft(k:) = set%struck(k:)/(set%modal_mass(k:)*set%beta_squared(k:)%hi)
        following = what_follows(set, soft, scene%response%points)
      end associate
    end subroutine begin

    subroutine move_in_contact(load)
      !! Move through a contact, whose last step may have any length.
      type(load_type), intent(in) :: load
      integer :: j
      associate (set => beyond%modes%configuration(now)%set, last => size(load%length))
        do j = 1, last - 1
          associate (step => beyond%ladder(load%level(j), now))
            if (step%length <= 0.0_dp) call find_step_end(parts, set%struck, set%modal_mass, load%length(j), step)
            call step%advance(load%force(:, j), q, rate)
          end associate
          call update_speed(load%force(:, j), load%length(j))
        end do
        if (last == 0) return
        call advance_state(parts, set%struck, set%modal_mass, load%length(last), 1.0_dp, load%force(:, last), q, rate)
        call update_speed(load%force(:, last), load%length(last))
      end associate
    end subroutine move_in_contact

    subroutine update_speed(values, length)
      !! Update the largest speed of the struck place with that at the end of a step.
      real(dp), intent(in) :: values(0:), length
      call force_in_step(polynomial_of(values), 1.0_dp, force(1), force(2))
      force(2) = force(2)/length
      struck = max(struck, abs(dot_product(beyond%modes%configuration(now)%set%struck, rate - force(2)*soft)))
    end subroutine update_speed
  end subroutine drive_through

  pure integer function levels_in(segment) result(levels)
    !! Return the largest level of the steps of a contact.
    type(segment_type), intent(in) :: segment
    levels = 0
    if (.not. allocated(segment%load)) return
    if (size(segment%load%level) > 0) levels = maxval(segment%load%level)
  end function levels_in

  pure function what_follows(modes, soft, points) result(shown)
    !! Return the quasi-static contribution of modes under a force of 1 at the struck place: displacement, curvature and
    !! hub rotation.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: soft(:)                  !! modal displacements under that force
    real(dp), intent(in) :: points(:)                !! ξ
    real(dp) :: shown(size(points), 3)
    integer, parameter :: quantities(3) = [deflections, curvatures, turns]
    integer :: i
    do i = 1, size(quantities)
      shown(:, quantities(i)) = matmul(soft, values_at(modes, quantities(i), 1, modes%count, points))
    end do
  end function what_follows

  subroutine project_neglected(scene, units, configuration, which, number, q, rate, monitor)
    !! Project the motion of omitted modes, less its quasi-static part, onto other modes. Springs and the motion that
    !! bodies bring are left out, as the summed motion includes them.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(configuration_type), intent(in) :: configuration(:)
    integer, intent(in) :: which(2)                  !! indices in `configuration` before and after,
    integer, intent(in) :: number(2)                 !! and indices in the scene
    real(dp), allocatable, intent(inout) :: q(:), rate(:)   !! (modes before), then (modes after)
    class(monitor_type), intent(inout) :: monitor    !! the state is invalid if it requests a stop
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
    call change_bodies(configuration, change_type(which(1), which(2), presence(scene, carried(number(1))), &
      presence(scene, carried(number(2))), configuration(which(2))%set%count), beyond, bodies, 0.0_dp, later, ignored, monitor)
    q = later%q
    rate = later%rate
  end subroutine project_neglected

end module bw_neglected_modes
