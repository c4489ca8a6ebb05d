module bw_neglected_modes
  !! What the modes beyond those that are summed would add to the motion of a beam that is struck: as many modes more, driven by the forces
  !! of its contacts as they were found, less what follows these forces at once, which is added. Of a motion whose contacts hardly feel
  !! those modes that is what is missing, but for the modes that come after them.
  !!
  !! The beam is the one that was struck, whatever comes to it or leaves it later.
  use bw_case_histories, only: sum_histories
  use bw_case_moments, only: scale_of_moments
  use bw_case_result, only: case_histories, case_motion
  use bw_double_double, only: operator(-)
  use bw_first_motion, only: find_first_motion
  use bw_force_response, only: force_degree
  use bw_force_step, only: drive, find_step_end, force_in_step, polynomial_of
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_mode_set, only: curvatures, deflections, first_numbers, values_at
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
    real(dp) :: largest(size(scene%response%points) + 1, 3)   ! displacement, velocity, curvature
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
    call drive_through(seen, motion%timeline%segments, beyond, monitor, largest)
    if (monitor%stop_requested()) return
    call look(deflections, largest(:, 1), largest(:, 2))
    if (monitor%stop_requested()) return
    neglected%displacement = largest(:points, 1)
    neglected%velocity = largest(:points, 2)
    neglected%struck = largest(points + 1, 2)
    if (.not. scene%response%bending_moment) return
    call look(curvatures, largest(:, 3))
    neglected%bending_moment = largest(:points, 3)*scale_of_moments(scene)
  contains
    subroutine look(quantity, value, rate)
      !! At the samples of free flights.
      integer, intent(in) :: quantity
      real(dp), intent(inout) :: value(:)
      real(dp), intent(inout), optional :: rate(:)
      type(case_histories) :: found
      integer :: n, p
      call sum_histories(seen, beyond, quantity, monitor, workspace, found)
      if (monitor%stop_requested()) return
      n = found%response%finite_samples
      do p = 1, size(value)
        value(p) = max(value(p), largest_magnitude(found%response%displacement(:n, p)))
        if (present(rate)) rate(p) = max(rate(p), largest_magnitude(found%response%velocity(:n, p)))
      end do
    end subroutine look
  end subroutine find_neglected

  subroutine drive_through(scene, segments, beyond, monitor, largest)
    !! The segments of a motion once more, for other modes: each starts where the one before it left them. What they show in contacts is
    !! looked at where steps end, so that nothing of it is left to the histories.
    type(scene_type), intent(in) :: scene
    type(segment_type), intent(in) :: segments(:)
    type(case_motion), intent(inout) :: beyond       !! its modes are known
    class(monitor_type), intent(inout) :: monitor    !! what is found means nothing where it asks to stop
    real(dp), intent(out) :: largest(:, :)           !! in contacts, beyond what follows the force at once, SI but for curvatures,
                                                     !! (points, 3)
    type(oscillators) :: parts
    real(dp), allocatable :: bends(:, :), c(:), q(:), rate(:), shapes(:, :), soft(:)
    integer :: i
    call find_first_motion(scene, alone, beyond, q, rate)
    q = q/unit_velocity(scene)
    rate = rate/unit_velocity(scene)
    largest = 0.0_dp
    allocate (beyond%timeline%segments(size(segments)))
    allocate (beyond%ladder(0:maxval([(levels_in(segments(i)), i=1, size(segments))]), 1))
    associate (set => beyond%modes%configuration(1)%set, unit => beyond%units%time%hi)
      c = 0.0_dp*set%modal_mass
      if (allocated(set%damping)) c = set%damping
      parts = oscillators_of(set%beta_squared, c)
      soft = set%struck/(set%modal_mass*set%beta_squared%hi)
      shapes = values_at(set, deflections, 1, set%count, scene%response%points)
      bends = values_at(set, curvatures, 1, set%count, scene%response%points)
      do i = 1, size(segments)
        if (monitor%stop_requested()) return
        beyond%timeline%segments(i) = segment_type(start=segments(i)%start, count=set%count, q=q, rate=rate)
        if (allocated(segments(i)%load)) then
          beyond%timeline%segments(i)%q = 0.0_dp
          beyond%timeline%segments(i)%rate = 0.0_dp
          call press(segments(i)%load)
        else if (i < size(segments)) then
          call move(set, segments(i + 1)%start - segments(i)%start, q, rate)
        end if
      end do
      largest = largest*abs(unit_velocity(scene))
      largest(:, [1, 3]) = largest(:, [1, 3])*unit
    end associate
  contains
    subroutine press(load)
      !! To the end of a contact, whose last step may be of any length.
      type(load_type), intent(in) :: load
      real(dp) :: coefficients(0:force_degree), force, slope
      integer :: j
      associate (set => beyond%modes%configuration(1)%set)
        do j = 1, size(load%length)
          if (j < size(load%length)) then
            associate (step => beyond%ladder(load%level(j), 1))
              if (step%length <= 0.0_dp) call find_step_end(parts, set%struck, set%modal_mass, load%length(j), step)
              call step%advance(load%force(:, j), q, rate)
            end associate
          else
            call drive(parts, set%struck, set%modal_mass, load%length(j), 1.0_dp, load%force(:, j), q, rate)
          end if
          coefficients = polynomial_of(load%force(:, j))
          call force_in_step(coefficients, 1.0_dp, force, slope)
          slope = slope/load%length(j)
          largest(:, 1) = max(largest(:, 1), abs(matmul(q - soft*force, shapes)))
          largest(:, 2) = max(largest(:, 2), abs(matmul(rate - soft*slope, shapes)))
          largest(:, 3) = max(largest(:, 3), abs(matmul(q - soft*force, bends)))
        end do
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

end module bw_neglected_modes
