module bw_contact_rates
  !! A beam through contacts that last, as under any other load: when the contacts have been followed their force is known, a polynomial in
  !! each step. So accelerations and shear forces are found, and where other loads act, all histories.
  use bw_case_modes, only: whole_beam
  use bw_case_result, only: case_motion
  use bw_double_double, only: to_dd
  use bw_first_motion, only: find_first_motion
  use bw_force_response, only: force_degree
  use bw_force_step, only: polynomial_of
  use bw_kinds, only: dp
  use bw_load_columns, only: factor_of_quantity, list_columns, make_view, placed_loads, quantities
  use bw_load_course, only: load_course, scaled_course
  use bw_load_sum, only: load_tail, load_view, rounding_of, sum_loaded_modes
  use bw_missing, only: missing
  use bw_mode_set, only: first_numbers
  use bw_monitor, only: monitor_type
  use bw_neglected_modes, only: neglected_type
  use bw_response, only: response_type
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: alone, segment_type
  use bw_segment_samples, only: samples_of_segment
  use bw_time_grid, only: time_grid, time_grid_of
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: add_rates, find_driven, neglected_in, rounding_in, show_in_segments, unit_force

  integer, parameter :: displacement = 1, velocity = 2, acceleration = 3, bending_moment = 4, shear_force = 5, turn_of_hub = 6
    !! the quantities of bw_load_columns

  type, public :: driven_type
    !! Histories, in units of bw_segment.
    integer, allocatable :: quantity(:), point(:)  !! (columns)
    integer :: samples = 0                         !! that are known
    real(dp), allocatable :: history(:, :)         !! (samples, columns)
    real(dp), allocatable :: rounding(:)           !! what it leaves, (columns)
    real(dp), allocatable :: neglected(:)          !! what the next octave of modes would add, (columns); unallocated: there is none
    real(dp) :: struck = 0.0_dp                    !! the same of the velocity where the mass strikes
  end type driven_type

contains

  subroutine find_driven(scene, motion, summed, asked, samples, monitor, driven, loads)
    !! The motion of the modes under the force of all contacts, and under other loads.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion        !! followed, without a capture
    integer, intent(in) :: summed                  !! modes that take part
    logical, intent(in) :: asked(quantities)       !! which quantities are
    integer, intent(in) :: samples                 !! that are known
    class(monitor_type), intent(inout) :: monitor  !! the histories mean nothing where it asks to stop
    type(driven_type), intent(out) :: driven
    type(placed_loads), intent(in), optional :: loads   !! beside the contacts, N
    type(case_motion) :: wide                      ! twice as many modes as are summed, if there are so many
    type(placed_loads) :: acting
    type(varying_beam) :: given
    type(load_view) :: view
    type(load_tail) :: tail
    type(time_grid) :: grid
    real(dp), allocatable :: flexibility(:), q(:), v(:)
    real(dp) :: duration
    integer :: more, struck
    call whole_beam(scene, motion%units, given, struck)
    acting = placed_loads([course_of(motion%timeline%segments)], [scene%impact%position], [.false.], kind=[1])
    if (present(loads)) then
      acting = placed_loads([acting%course, scaled_course(loads%course, 1.0_dp/unit_force(scene, motion))], &
                            [acting%place, loads%place], [acting%turns, loads%turns], loads%accelerated, [1, loads%kind + 1])
    end if
    call list_columns(scene%response, asked, driven%quantity, driven%point)
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    allocate (driven%history(grid%samples, size(driven%quantity)), source=0.0_dp)
    driven%samples = samples
    allocate (wide%modes%configuration(1))
    wide%units = motion%units
    more = min(2*summed, motion%modes%configuration(alone)%source%highest)
    call motion%modes%configuration(alone)%source%find(first_numbers(max(summed, more)), wide%modes%configuration(1)%set, &
                                                       grid%samples*grid%step%hi, monitor)
    if (monitor%stop_requested()) return
    associate (set => wide%modes%configuration(1)%set)
      call make_view(given, set, summed, acting, scene%response%points, driven%quantity, driven%point, monitor, view, flexibility)
      if (monitor%stop_requested()) return
      call find_first_motion(scene, alone, wide, q, v)
      q = q/unit_velocity(scene)
      v = v/unit_velocity(scene)
      duration = samples*grid%step%hi
      call sum_loaded_modes(set, view, grid, [1, samples], to_dd(0.0_dp), to_dd(duration), monitor, q, v, driven%history, tail)
      if (monitor%stop_requested()) return
      driven%rounding = rounding_of(set, view, tail, duration)
      if (more < 2*summed .or. samples == 0) return
      driven%neglected = tail%largest(:, 2)
      driven%struck = norm2(set%struck(summed + 1:)*tail%lag(summed + 1:, 1))
    end associate
  end subroutine find_driven

  pure real(dp) function unit_force(scene, motion) result(newton)
    !! That of bw_segment, N.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    newton = motion%units%mass*unit_velocity(scene)/motion%units%time%hi
  end function unit_force

  subroutine show_in_segments(scene, driven, motion)
    !! Of displacements, velocities and curvatures, what each segment shows at its samples.
    type(scene_type), intent(in) :: scene
    type(driven_type), intent(in) :: driven
    type(case_motion), intent(inout) :: motion
    type(time_grid) :: grid
    real(dp), allocatable :: turned(:, :)
    integer :: i, samples(2)
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    do i = 1, size(motion%timeline%segments)
      samples = samples_of_segment(motion, i, grid)
      samples(2) = max(samples(1) - 1, min(samples(2), driven%samples))
      associate (segment => motion%timeline%segments(i))
        if (.not. allocated(segment%load)) allocate (segment%load)
        segment%load%displacement = of_quantity(displacement)
        segment%load%velocity = of_quantity(velocity)
        segment%load%curvature = of_quantity(bending_moment)
        turned = of_quantity(turn_of_hub)
        if (size(turned, 2) > 0) segment%load%hub_turn = turned(:, 1)
      end associate
    end do
  contains
    pure function of_quantity(which) result(rows)
      integer, intent(in) :: which
      real(dp), allocatable :: rows(:, :)
      integer :: c
      rows = driven%history(samples(1):samples(2), pack([(c, c=1, size(driven%quantity))], driven%quantity == which))
    end function of_quantity
  end subroutine show_in_segments

  subroutine add_rates(scene, motion, driven, response)
    !! Add accelerations and shear forces, if they are asked for, to the histories of a motion, and to their errors what rounding leaves.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(driven_type), intent(in) :: driven
    type(response_type), intent(inout) :: response !! of displacements
    call take(acceleration, response%acceleration, response%acceleration_error)
    call take(shear_force, response%shear_force, response%shear_force_error)
  contains
    subroutine take(which, histories, error)
      integer, intent(in) :: which
      real(dp), allocatable, intent(inout) :: histories(:, :), error(:)
      integer :: c
      associate (columns => pack([(c, c=1, size(driven%quantity))], driven%quantity == which), &
                 factor => factor_of(scene, motion, which))
        if (size(columns) == 0) return
        histories = factor*driven%history(:, columns)
        histories(driven%samples + 1:, :) = missing
        error = abs(factor)*driven%rounding(columns)
      end associate
    end subroutine take
  end subroutine add_rates

  subroutine neglected_in(scene, motion, driven, neglected)
    !! What modes beyond would add to the quantities that are there.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(driven_type), intent(in) :: driven
    type(neglected_type), intent(inout) :: neglected
    if (.not. allocated(driven%neglected)) return
    neglected%struck = max(neglected%struck, abs(unit_velocity(scene))*driven%struck)
    call take(displacement, neglected%displacement)
    call take(velocity, neglected%velocity)
    call take(acceleration, neglected%acceleration)
    call take(bending_moment, neglected%bending_moment)
    call take(shear_force, neglected%shear_force)
  contains
    subroutine take(which, largest)
      integer, intent(in) :: which
      real(dp), allocatable, intent(inout) :: largest(:)
      integer :: c
      associate (columns => pack([(c, c=1, size(driven%quantity))], driven%quantity == which))
        if (size(columns) > 0) largest = abs(factor_of(scene, motion, which))*driven%neglected(columns)
      end associate
    end subroutine take
  end subroutine neglected_in

  pure real(dp) function factor_of(scene, motion, quantity) result(factor)
    !! SI over what the modes show.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: quantity
    factor = unit_velocity(scene)*motion%units%time%hi*factor_of_quantity(scene, motion%units, quantity)
  end function factor_of

  pure function rounding_in(scene, motion, driven) result(rounding)
    !! What rounding leaves of histories, SI, (points, quantities).
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(driven_type), intent(in) :: driven
    real(dp) :: rounding(size(scene%response%points), quantities)
    integer :: c
    rounding = 0.0_dp
    do c = 1, size(driven%quantity)
      rounding(driven%point(c), driven%quantity(c)) = abs(factor_of(scene, motion, driven%quantity(c)))*driven%rounding(c)
    end do
  end function rounding_in

  pure type(load_course) function course_of(segments) result(course)
    !! The force of all contacts, and none between them.
    type(segment_type), intent(in) :: segments(:)
    integer :: i, j, k, steps
    steps = 1
    do i = 1, size(segments)
      if (allocated(segments(i)%load)) steps = steps + size(segments(i)%load%length) + 1
    end do
    allocate (course%knot(steps + 1), course%power(0:force_degree, steps))
    course%power = 0.0_dp
    course%tone = spread((0.0_dp, 0.0_dp), 1, steps)
    course%knot = 0.0_dp
    k = 1                                          ! the interval that begins next
    do i = 1, size(segments)
      if (.not. allocated(segments(i)%load)) cycle
      k = k + 1                                    ! after the flight before it
      course%knot(k) = max(course%knot(k - 1), segments(i)%start%hi)
      associate (load => segments(i)%load)
        do j = 1, size(load%length)
          course%power(:, k) = polynomial_of(load%force(:, j))
          course%knot(k + 1) = course%knot(k) + load%length(j)
          k = k + 1
        end do
      end associate
    end do
    if (k == 1) course%knot(2) = 1.0_dp            ! nothing strikes the beam
  end function course_of

end module bw_contact_rates
