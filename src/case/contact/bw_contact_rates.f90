module bw_contact_rates
  !! Histories of a beam with lasting contacts, as under any other load: once the contacts are followed, their force is
  !! known, a polynomial in each step. This gives accelerations and shear forces, and under other loads all histories.
  use bw_case_bodies, only: beam_of
  use bw_case_result, only: case_motion
  use bw_double_double, only: dd, to_dd
  use bw_first_motion, only: find_first_motion
  use bw_force_response, only: force_degree
  use bw_force_step, only: polynomial_of
  use bw_kinds, only: dp
  use bw_load_columns, only: factor_of_quantity, list_columns, make_view, quantities
  use bw_load_course, only: load_course, loads_before, scaled_course
  use bw_load_sum, only: load_tail, load_view, rounding_of, sum_loaded_modes
  use bw_loads_beside, only: modes_taking_part, unit_force
  use bw_missing, only: missing
  use bw_mode_set, only: configuration_type, first_numbers, mode_set
  use bw_monitor, only: monitor_type
  use bw_neglected_modes, only: project_neglected, neglected_type
  use bw_placed_loads, only: placed_loads
  use bw_response, only: response_type
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: alone, segment_type
  use bw_segment_samples, only: samples_of_segment
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  use bw_timeline, only: carried_type, configurations_of
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: add_rates, find_driven_histories, find_next_octave, rounding_in, store_in_segments

  integer, parameter :: displacement = 1, velocity = 2, acceleration = 3, bending_moment = 4, shear_force = 5, turn_of_hub = 6
    !! quantities of bw_load_columns

  type, public :: driven_histories
    !! Histories of given quantities, in units of bw_segment.
    integer, allocatable :: quantity(:), point(:)  !! (columns)
    integer :: samples = 0                         !! known samples
    real(dp), allocatable :: history(:, :)         !! (samples, columns)
    real(dp), allocatable :: rounding(:)           !! rounding error, (columns)
    real(dp), allocatable :: neglected(:) !! largest contribution of the next octave of modes, (columns); unallocated: no such modes
    real(dp) :: struck = 0.0_dp                    !! the same for the velocity of the struck place
  end type driven_histories

  type :: wide_type
    !! Up to twice the summed modes, and their state.
    type(case_motion) :: motion                    !! with these modes only
    integer :: number = alone                      !! their configuration
    integer :: summed = 0
    real(dp), allocatable :: q(:), v(:)             ! at the end of a stretch: the part that is missing from the known motion
  end type wide_type

contains

  subroutine find_driven_histories(scene, motion, summed, asked, samples, monitor, driven, loads)
    !! Find histories of the modes under the force of all contacts and under other loads.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion        !! with contacts
    integer, intent(in) :: summed                  !! modes of the first configuration that are summed
    logical, intent(in) :: asked(quantities)       !! requested quantities
    integer, intent(in) :: samples                 !! known samples
    class(monitor_type), intent(inout) :: monitor  !! the histories are invalid if it requests a stop
    type(driven_histories), intent(out) :: driven
    type(placed_loads), intent(in), optional :: loads   !! besides the contacts, N
    type(time_grid) :: grid
    type(wide_type) :: wide
    integer :: i, last
    call list_columns(scene%response, asked, driven%quantity, driven%point)
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    allocate (driven%history(grid%samples, size(driven%quantity)), source=0.0_dp)
    allocate (driven%rounding(size(driven%quantity)), source=0.0_dp)
    driven%samples = samples
    if (samples > 0) driven%neglected = driven%rounding
    i = 1
    do while (i <= size(motion%timeline%segments))
      associate (segments => motion%timeline%segments)
        do last = i, size(segments) - 1
          if (segments(last + 1)%configuration /= segments(i)%configuration) exit
        end do
      end associate
      call drive_stretch(scene, motion, [i, min(last, size(motion%timeline%segments))], summed, grid, monitor, wide, driven, loads)
      if (monitor%stop_requested()) return
      i = last + 1
    end do
  end subroutine find_driven_histories

  subroutine drive_stretch(scene, motion, these, summed, grid, monitor, wide, driven, loads)
    !! Find histories from one change of bodies to the next.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: these(2)                !! its first segment and the last
    integer, intent(in) :: summed                  !! modes of the first configuration that are summed
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor  !! the histories are invalid if it requests a stop
    type(wide_type), intent(inout) :: wide
    type(driven_histories), intent(inout) :: driven
    type(placed_loads), intent(in), optional :: loads
    type(wide_type) :: now
    type(placed_loads) :: acting
    type(carried_type), allocatable :: carried(:)
    type(varying_beam) :: given
    type(load_view) :: view
    type(load_tail) :: tail
    type(dd) :: until
    type(configuration_type) :: pair(2)
    real(dp), allocatable :: flexibility(:)
    real(dp), allocatable :: unknown(:, :)         ! missing motion of the summed modes, (modes, 2),
    real(dp), allocatable :: missed(:)             ! and its largest contribution to histories, (columns)
    integer :: more, samples(2)
    associate (segments => motion%timeline%segments(these(1):these(2)))
      associate (configuration => motion%modes%configuration(segments(1)%configuration))
        carried = configurations_of(scene)
        given = beam_of(scene, motion%units, carried(segments(1)%configuration))
        acting = placed_loads([course_of(segments)], [scene%impact%position], kind=[1])
        if (present(loads)) then
          acting = placed_loads([acting%course, scaled_course(loads%course, 1.0_dp/unit_force(scene, motion))], &
                                [acting%place, loads%place], loads%accelerated, [1, loads%kind + 1])
        end if
        now%summed = modes_taking_part(motion, segments(1)%configuration, summed)
        now%number = segments(1)%configuration
        samples = [first_sample(segments(1)%start, grid), driven%samples]
        until = to_dd(driven%samples*grid%step%hi)
        if (these(2) < size(motion%timeline%segments)) then
          until = motion%timeline%segments(these(2) + 1)%start
          samples(2) = min(samples(2), first_sample(until, grid) - 1)
        end if
        if (samples(1) > driven%samples .and. these(1) > 1) return
        allocate (now%motion%modes%configuration(1))
        now%motion%units = motion%units
        more = min(2*now%summed, configuration%source%highest)
        call configuration%source%find(first_numbers(max(now%summed, more)), now%motion%modes%configuration(1)%set, &
                                       grid%samples*grid%step%hi, monitor)
        if (monitor%stop_requested()) return
      end associate
      associate (set => now%motion%modes%configuration(1)%set, n => now%summed)
        call make_view(given, set, n, acting, scene%response%points, driven%quantity, driven%point, monitor, view, flexibility)
        if (monitor%stop_requested()) return
        if (these(1) == 1) then
          call find_first_motion(scene, alone, now%motion, now%q, now%v)
          now%q = now%q/unit_velocity(scene)
          now%v = now%v/unit_velocity(scene)
          allocate (unknown(n, 2), source=0.0_dp)
          if (segments(1)%configuration /= alone) then   ! a body arrives at t = 0
            now%q(:n) = segments(1)%q(:n)
            now%v(:n) = segments(1)%rate(:n)
          end if
        else
          allocate (pair(1)%set, source=wide%motion%modes%configuration(1)%set)
          allocate (pair(2)%set, source=set)
          now%q = wide%q
          now%v = wide%v
          call project_neglected(scene, motion%units, pair, [1, 2], [wide%number, now%number], now%q, now%v, monitor)
          if (monitor%stop_requested()) return
          if (allocated(segments(1)%beyond)) then
            now%q(n + 1:) = now%q(n + 1:) + segments(1)%beyond(:, 1)
            now%v(n + 1:) = now%v(n + 1:) + segments(1)%beyond(:, 2)
          end if
          unknown = reshape([now%q(:n), now%v(:n)], [n, 2])
          if (allocated(driven%neglected)) &
            call follow_missing(set, view, grid, samples, segments(1)%start, until, unknown, monitor, missed)
          if (monitor%stop_requested()) return
          now%q(:n) = segments(1)%q(:n)
          now%v(:n) = segments(1)%rate(:n)
        end if
        call sum_loaded_modes(set, view, grid, samples, segments(1)%start, until, monitor, now%q, now%v, driven%history, tail)
        if (monitor%stop_requested()) return
        wide = now
        wide%q(:n) = unknown(:, 1)
        wide%v(:n) = unknown(:, 2)
        ! the last knot is a rounded sum
        associate (load => loads_before(view%course, until%hi*(1.0_dp - 8.0_dp*epsilon(1.0_dp))), &
                   soft => spread(1.0_dp/set%beta_squared(n + 1:)%hi, 2, size(acting%kind)))
          wide%q(n + 1:) = wide%q(n + 1:) - matmul(soft*view%drive(n + 1:, :), load(:, 1))
          wide%v(n + 1:) = wide%v(n + 1:) - matmul(soft*view%drive(n + 1:, :), load(:, 2))
        end associate
        driven%rounding = driven%rounding + rounding_of(set, view, tail, until%hi)
        if (more < 2*n .and. allocated(driven%neglected)) deallocate (driven%neglected)
        if (.not. allocated(driven%neglected)) return
        if (these(1) > 1) tail%largest(:, 2) = tail%largest(:, 2) + missed
        driven%neglected = max(driven%neglected, tail%largest(:, 2))
        driven%struck = max(driven%struck, norm2(set%struck(n + 1:)*tail%lag(n + 1:, 1)))
      end associate
    end associate
  end subroutine drive_stretch

  subroutine follow_missing(modes, view, grid, samples, start, until, state, monitor, largest)
    !! Follow the free motion that summed modes lack, and find its largest contribution to histories.
    class(mode_set), intent(in) :: modes
    type(load_view), intent(in) :: view
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: samples(2)              !! see `sum_loaded_modes`
    type(dd), intent(in) :: start, until
    real(dp), intent(inout) :: state(:, :)         !! displacements and velocities at the start, then at the end, (modes, 2)
    class(monitor_type), intent(inout) :: monitor  !! results are invalid if it requests a stop
    real(dp), allocatable, intent(out) :: largest(:)   !! magnitudes, (columns)
    type(load_view) :: free
    type(load_tail) :: ignored
    real(dp), allocatable :: q(:), v(:), history(:, :)
    free = view
    free%drive = 0.0_dp
    free%residual = 0.0_dp
    q = [state(:, 1), spread(0.0_dp, 1, modes%count - size(state, 1))]
    v = [state(:, 2), spread(0.0_dp, 1, modes%count - size(state, 1))]
    allocate (history(samples(2), size(view%order)), source=0.0_dp)
    call sum_loaded_modes(modes, free, grid, samples, start, until, monitor, q, v, history, ignored)
    state = reshape([q(:size(state, 1)), v(:size(state, 1))], shape(state))
    largest = maxval(abs(history), 1)
  end subroutine follow_missing

  subroutine store_in_segments(scene, driven, motion)
    !! Store histories of displacements, velocities, curvatures and hub rotation in the segments.
    type(scene_type), intent(in) :: scene
    type(driven_histories), intent(in) :: driven
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
  end subroutine store_in_segments

  subroutine add_rates(scene, motion, driven, response)
    !! Add requested accelerations and shear forces to the histories of a motion, and rounding to their errors.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(driven_histories), intent(in) :: driven
    type(response_type), intent(inout) :: response !! with displacements
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

  subroutine find_next_octave(scene, motion, driven, neglected)
    !! Set the contribution of the next octave of modes to each quantity in SI.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(driven_histories), intent(in) :: driven
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
  end subroutine find_next_octave

  pure real(dp) function factor_of(scene, motion, quantity) result(factor)
    !! Return the factor to SI units.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: quantity
    factor = unit_velocity(scene)*motion%units%time%hi*factor_of_quantity(scene, motion%units, quantity)
  end function factor_of

  pure function rounding_in(scene, motion, driven) result(rounding)
    !! Return the rounding errors of histories, SI, (points, quantities).
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(driven_histories), intent(in) :: driven
    real(dp) :: rounding(size(scene%response%points), quantities)
    integer :: c
    rounding = 0.0_dp
    do c = 1, size(driven%quantity)
      rounding(driven%point(c), driven%quantity(c)) = abs(factor_of(scene, motion, driven%quantity(c)))*driven%rounding(c)
    end do
  end function rounding_in

  pure type(load_course) function course_of(segments) result(course)
    !! Return the force of all contacts as a function of time, 0 between them.
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
    k = 1                                          ! next interval
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
    if (k == 1) course%knot(2) = 1.0_dp
  end function course_of

end module bw_contact_rates
