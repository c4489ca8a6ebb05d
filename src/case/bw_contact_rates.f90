module bw_contact_rates
  !! Accelerations and shear forces of a beam through contacts that last. When the contacts have been followed their force is known, a
  !! polynomial in each step, and the beam moves under it as under any other load.
  use bw_case_modes, only: whole_beam
  use bw_case_result, only: case_motion
  use bw_double_double, only: to_dd
  use bw_force_response, only: force_degree
  use bw_force_step, only: polynomial_of
  use bw_kinds, only: dp
  use bw_load_columns, only: factor_of_quantity, list_columns, make_view, placed_loads, quantities
  use bw_load_course, only: load_course
  use bw_load_sum, only: load_tail, load_view, rounding_of, sum_loaded_modes
  use bw_missing, only: missing
  use bw_monitor, only: monitor_type
  use bw_response, only: response_type
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: alone, segment_type
  use bw_time_grid, only: time_grid, time_grid_of
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: add_rates

  integer, parameter :: acceleration = 3, shear_force = 5   ! among the quantities of bw_load_columns

contains

  subroutine add_rates(scene, motion, summed, monitor, response)
    !! Add what is asked for to the histories of a motion, and to their errors what rounding leaves.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion        !! followed, without a capture
    integer, intent(in) :: summed                  !! modes that take part
    class(monitor_type), intent(inout) :: monitor  !! the histories mean nothing where it asks to stop
    type(response_type), intent(inout) :: response !! of displacements
    type(placed_loads) :: loads
    type(varying_beam) :: given
    type(load_view) :: view
    type(load_tail) :: tail
    type(time_grid) :: grid
    integer, allocatable :: quantity(:), point(:)
    real(dp), allocatable :: flexibility(:), history(:, :), rounding(:), q(:), v(:)
    real(dp) :: duration, metre
    logical :: asked(quantities)
    integer :: c, n, struck
    if (.not. (scene%response%acceleration .or. scene%response%shear_force)) return
    call whole_beam(scene, motion%units, given, struck)
    loads = placed_loads([course_of(motion%timeline%segments)], [scene%impact%position], [.false.], kind=[1])
    asked = .false.
    asked([acceleration, shear_force]) = [scene%response%acceleration, scene%response%shear_force]
    call list_columns(scene%response, asked, quantity, point)
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    allocate (history(grid%samples, size(quantity)), source=0.0_dp)
    n = response%finite_samples
    associate (free => motion%modes%configuration(alone)%set)
      call make_view(given, free, summed, loads, scene%response%points, quantity, point, monitor, view, flexibility)
      if (monitor%stop_requested()) return
      q = motion%timeline%segments(1)%q
      v = motion%timeline%segments(1)%rate
      duration = (n*grid%step%hi)
      call sum_loaded_modes(free, view, grid, [1, n], to_dd(0.0_dp), to_dd(duration), monitor, q, v, history, tail)
      if (monitor%stop_requested()) return
      rounding = rounding_of(free, view, tail, duration)
    end associate
    metre = unit_velocity(scene)*motion%units%time%hi
    do c = 1, size(quantity)
      associate (factor => metre*factor_of_quantity(scene, motion%units, quantity(c)))
        history(:n, c) = factor*history(:n, c)
        rounding(c) = abs(factor)*rounding(c)
      end associate
    end do
    history(n + 1:, :) = missing
    call take(acceleration, response%acceleration, response%acceleration_error)
    call take(shear_force, response%shear_force, response%shear_force_error)
  contains
    subroutine take(which, histories, error)
      integer, intent(in) :: which
      real(dp), allocatable, intent(inout) :: histories(:, :), error(:)
      associate (columns => pack([(c, c=1, size(quantity))], quantity == which))
        if (size(columns) == 0) return
        histories = history(:, columns)
        error = rounding(columns)
      end associate
    end subroutine take
  end subroutine add_rates

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
