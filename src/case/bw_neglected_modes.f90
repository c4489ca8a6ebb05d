module bw_neglected_modes
  !! What the modes beyond those that are summed would add to the motion of a beam that is struck: as many modes more, driven by the forces
  !! of its contacts as they were found, less what follows these forces at once, which is added. Of a motion whose contacts hardly feel
  !! those modes that is what is missing, but for the modes that come after them.
  !!
  !! The beam is the one that was struck, whatever comes to it or leaves it later.
  use bw_case_histories, only: find_loaded_segments, sum_histories
  use bw_case_moments, only: scale_of_moments
  use bw_case_result, only: case_histories, case_motion
  use bw_double_double, only: operator(-)
  use bw_first_motion, only: find_first_motion
  use bw_force_step, only: drive, find_step_end
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_mode_set, only: curvatures, deflections, first_numbers, mode_set, turns, values_at
  use bw_monitor, only: monitor_type
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_oscillators, only: oscillators, oscillators_of
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: alone, load_type, move, segment_type
  implicit none (type, external)
  private
  public :: find_neglected

  type, public :: neglected_type
    !! The largest magnitudes of what the next octave of modes would add, SI; unallocated where there are no more modes.
    real(dp), allocatable :: displacement(:), velocity(:), bending_moment(:), acceleration(:), shear_force(:)   !! (points)
    real(dp) :: struck = 0.0_dp                      !! of the velocity of the place that the mass strikes
  end type neglected_type

contains

  subroutine find_neglected(scene, motion, summed, monitor, workspace, neglected)
    !! Beside the forces of all contacts nothing acts on the beam.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion          !! followed with the modes that are summed
    integer, intent(in) :: summed
    class(monitor_type), intent(inout), target :: monitor   !! what is found means nothing where it asks to stop
    type(nonuniform_sum), intent(inout) :: workspace(:)
    type(neglected_type), intent(out) :: neglected
    type(scene_type) :: seen                         ! also where the mass strikes, and with velocities there
    type(case_motion) :: beyond
    integer :: more, points
    more = min(summed, motion%modes%configuration(alone)%source%highest - summed)
    if (more <= 0 .or. size(motion%timeline%segments) == 0) return
    points = size(scene%response%points)
    seen = scene
    seen%response%points = [scene%response%points, scene%impact%position]
    seen%response%velocity = .true.
    beyond%units = motion%units
    beyond%timeline%known_until = motion%timeline%known_until
    allocate (beyond%modes%configuration(1))
    call motion%modes%configuration(alone)%source%find(summed + first_numbers(more), beyond%modes%configuration(1)%set, &
                                                       scene%response%duration/motion%units%time%hi, monitor)
    if (monitor%stop_requested()) return
    call drive_through(seen, motion%timeline%segments, beyond, monitor)
    if (monitor%stop_requested()) return
    call find_loaded_segments(seen, beyond, monitor)
    if (monitor%stop_requested()) return
    call look(deflections, neglected%displacement, neglected%velocity)
    if (monitor%stop_requested()) return
    neglected%struck = neglected%velocity(points + 1)
    neglected%displacement = neglected%displacement(:points)
    neglected%velocity = neglected%velocity(:points)
    if (.not. scene%response%bending_moment) return
    call look(curvatures, neglected%bending_moment)
    neglected%bending_moment = neglected%bending_moment(:points)*scale_of_moments(scene)
  contains
    subroutine look(quantity, value, rate)
      integer, intent(in) :: quantity
      real(dp), allocatable, intent(out) :: value(:)
      real(dp), allocatable, intent(out), optional :: rate(:)
      type(case_histories) :: found
      integer :: p
      call sum_histories(seen, beyond, quantity, monitor, workspace, found)
      if (monitor%stop_requested()) return
      associate (response => found%response, n => found%response%finite_samples)
        value = [(largest_magnitude(response%displacement(:n, p)), p=1, points + 1)]
        if (present(rate)) rate = [(largest_magnitude(response%velocity(:n, p)), p=1, points + 1)]
      end associate
    end subroutine look
  end subroutine find_neglected

  subroutine drive_through(scene, segments, beyond, monitor)
    !! The segments of a motion once more, for other modes: each starts where the one before it left them.
    type(scene_type), intent(in) :: scene
    type(segment_type), intent(in) :: segments(:)
    type(case_motion), intent(inout) :: beyond       !! its modes are known
    class(monitor_type), intent(inout) :: monitor    !! what is found means nothing where it asks to stop
    type(oscillators) :: parts
    real(dp), allocatable :: c(:), q(:), rate(:), following(:, :)
    integer :: i
    call find_first_motion(scene, alone, beyond, q, rate)
    q = q/unit_velocity(scene)
    rate = rate/unit_velocity(scene)
    allocate (beyond%timeline%segments(size(segments)))
    allocate (beyond%ladder(0:maxval([(levels_in(segments(i)), i=1, size(segments))]), 1))
    associate (set => beyond%modes%configuration(1)%set)
      c = 0.0_dp*set%modal_mass
      if (allocated(set%damping)) c = set%damping
      parts = oscillators_of(set%beta_squared, c)
      following = what_follows(set, scene%response%points)
      do i = 1, size(segments)
        if (monitor%stop_requested()) return
        associate (given => segments(i), own => beyond%timeline%segments(i))
          own = segment_type(start=given%start, count=set%count, q=q, rate=rate)
          if (allocated(given%load)) then
            own%load = load_type(given%load%length, given%load%level, given%load%force, set%count, -following)
            call press(own%load)
          else if (i < size(segments)) then
            call move(set, segments(i + 1)%start - given%start, q, rate)
          end if
        end associate
      end do
    end associate
  contains
    subroutine press(load)
      !! To the end of a contact, whose last step may be of any length.
      type(load_type), intent(in) :: load
      integer :: j
      associate (set => beyond%modes%configuration(1)%set, last => size(load%length))
        do j = 1, last - 1
          associate (step => beyond%ladder(load%level(j), 1))
            if (step%length <= 0.0_dp) call find_step_end(parts, set%struck, set%modal_mass, load%length(j), step)
            call step%advance(load%force(:, j), q, rate)
          end associate
        end do
        if (last > 0) call drive(parts, set%struck, set%modal_mass, load%length(last), 1.0_dp, load%force(:, last), q, rate)
      end associate
    end subroutine press
  end subroutine drive_through

  pure integer function levels_in(segment) result(levels)
    !! Of the steps of its load.
    type(segment_type), intent(in) :: segment
    levels = 0
    if (.not. allocated(segment%load)) return
    if (size(segment%load%level) > 0) levels = maxval(segment%load%level)
  end function levels_in

  pure function what_follows(modes, points) result(shown)
    !! What modes add at once under a force of 1 where the mass strikes: displacements, curvatures and the turn of the hub.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: points(:)                !! ξ
    real(dp) :: shown(size(points), 3)
    integer, parameter :: quantities(3) = [deflections, curvatures, turns]
    integer :: i
    associate (soft => modes%struck/(modes%modal_mass*modes%beta_squared%hi))
      do i = 1, size(quantities)
        shown(:, quantities(i)) = matmul(soft, values_at(modes, quantities(i), 1, modes%count, points))
      end do
    end associate
  end function what_follows

end module bw_neglected_modes
