module bw_load_run
  !! The motion of a beam under its loads with a given number of modes, through all changes of the beam: histories and
  !! their truncation errors.
  use bw_beam_motion, only: case_modes
  use bw_beam_units, only: beam_units
  use bw_case_bodies, only: beam_of, bodies_of, presence
  use bw_change_of_bodies, only: beam_state, body_type, change_bodies, change_type
  use bw_changing_errors, only: error_of_state
  use bw_double_double, only: dd, to_dd, operator(/), operator(-)
  use bw_event, only: event_type
  use bw_kinds, only: dp
  use bw_lack_error, only: lack_error
  use bw_load_columns, only: factor_of_quantity, list_columns, make_view, quantities
  use bw_load_course, only: lag_bound, load_course, loads_before
  use bw_load_sum, only: load_tail, load_view, rounding_of, sum_loaded_modes, tail_errors
  use bw_missing, only: is_missing
  use bw_mode_set, only: configuration_type, curvatures, deflections, first_numbers, mode_set
  use bw_monitor, only: monitor_type
  use bw_placed_loads, only: find_drive, placed_loads, residual_at
  use bw_scene, only: scene_type
  use bw_segment, only: growth_ends
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  use bw_timeline, only: carried_type, configurations_of, later_steps, number_of, occurs_in_record, step_type, time_of
  use bw_unprojected, only: unprojected_errors
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: follow_loads, largest_of

  type, public :: loaded_run
    !! Histories and their errors, SI.
    real(dp), allocatable :: history(:, :)         !! (samples, columns)
    real(dp), allocatable :: error(:)              !! (columns)
    real(dp), allocatable :: bound(:)              !! of displacements; `huge`: none, (points)
    integer, allocatable :: quantity(:), point(:)  !! (columns)
    integer :: samples = 0                         !! known samples
    integer :: count = 0                           !! modes summed
    type(beam_state), allocatable :: before_event(:)   !! motion before each event after t = 0
  end type loaded_run

contains

  subroutine follow_loads(scene, units, modes, summed, loads, monitor, run)
    !! Follow the motion under loads and sum its histories.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(case_modes), intent(in) :: modes            !! with more than the summed modes, if there are any
    integer, intent(in) :: summed(2)                 !! modes summed in the first configuration and in others
    type(placed_loads), intent(in) :: loads
    class(monitor_type), intent(inout) :: monitor
    type(loaded_run), intent(out) :: run
    type(load_view) :: view
    type(load_tail) :: tail
    type(time_grid) :: grid
    type(step_type), allocatable :: steps(:)
    type(carried_type), allocatable :: configurations(:)
    type(configuration_type), allocatable :: wide(:)   ! with more modes, for projections
    type(varying_beam) :: given
    type(body_type), allocatable :: bodies(:)
    type(change_type) :: change
    type(beam_state) :: state
    real(dp), allocatable :: doubt(:, :), flexibility(:)
    real(dp), allocatable :: shown(:), held(:)  ! histories of all modes at the last change, and of the static shape of segments,
    real(dp), allocatable :: held_error(:)           ! which includes the truncation error then
    real(dp), dimension(size(loads%course), 2) :: load, since   ! at a change, and when the static shape was set
    real(dp) :: ends, factor, metre
    real(dp) :: of_states(size(scene%response%points), 3)   ! due to state errors: displacement, velocity and curvature
    type(dd) :: start, until, whole
    integer :: c, configuration, i, next, samples(2)
    associate (response => scene%response)
      call list_columns(response, [.true., response%velocity, response%acceleration, response%bending_moment, &
                                   response%shear_force, allocated(scene%hub)], run%quantity, run%point)
    end associate
    grid = time_grid_of(scene%response%duration, scene%response%samples, units%time)
    allocate (run%history(grid%samples, size(run%quantity)), source=0.0_dp)
    allocate (run%error(size(run%quantity)), run%bound(size(scene%response%points)), source=0.0_dp)
    allocate (run%before_event(0))
    steps = later_steps(scene)
    configurations = configurations_of(scene)
    bodies = bodies_of(scene, units)
    where (.not. is_missing(bodies%velocity)) bodies%velocity = 0.0_dp   ! what bodies bring is part of the motion without loads
    bodies%pull = 0.0_dp                             ! as are energies
    allocate (state%shape(0))
    since = 0.0_dp
    held_error = 0.0_dp*run%error
    of_states = 0.0_dp
    configuration = modes%moving
    run%count = summed(merge(1, 2, configuration == 1))
    run%samples = grid%samples
    start = to_dd(0.0_dp)
    whole = to_dd(scene%response%duration/units%time%hi)
    do i = 1, size(steps) + 1
      associate (set => modes%configuration(configuration)%set)
        ends = start%hi + growth_ends(set)
        until = whole
        next = 0
        if (i <= size(steps)) then
          if (occurs_in_record(steps(i), scene, time_of(steps(i), units) - start, set)) then
            next = number_of(configurations, steps(i)%carried)
            until = time_of(steps(i), units)
          end if
        end if
        samples = [first_sample(start, grid), first_sample(until, grid) - 1]
        if (ends < until%hi) then
          samples(2) = min(samples(2), first_sample(to_dd(ends), grid) - 1)
          run%samples = samples(2)
          until = to_dd(ends)
        end if
        given = beam_of(scene, units, configurations(configuration))
        call make_view(given, set, summed(merge(1, 2, configuration == 1)), loads, scene%response%points, &
                       run%quantity, run%point, monitor, view, flexibility)
        if (monitor%stop_requested()) return
        if (.not. allocated(state%q)) state%q = spread(0.0_dp, 1, set%count)
        if (.not. allocated(state%rate)) state%rate = state%q
        held = 0.0_dp*run%error
        if (size(state%shape) > 0) then
          held = shown - shown_by(set, view, state%q, since(:, 1))
          run%history(samples(1):samples(2), :) = spread(held, 1, samples(2) - samples(1) + 1)
        end if
        if (allocated(tail%amplitude)) deallocate (tail%amplitude, tail%lag, tail%load, tail%largest, tail%squares)
        call sum_loaded_modes(set, view, grid, samples, start, until, monitor, state%q, state%rate, run%history, tail)
        if (monitor%stop_requested()) return
        call add_errors()
        if (run%samples < grid%samples .or. next == 0) exit
        associate (speed => units%time%hi/units%mass)  ! units of bw_change_of_bodies, V l²/h and V, with V = 1 m/s
          run%before_event = [run%before_event, beam_state(set%count, speed*state%q, speed*state%rate)]
        end associate
        load = loads_before(loads%course, until%hi)
        shown = held + shown_by(set, view, state%q, load(:, 1))
        if (.not. allocated(wide)) allocate (wide(size(modes%configuration) + 1))
        change = change_type(configuration, next, presence(scene, configurations(configuration)), &
                             presence(scene, steps(i)%carried), modes%configuration(next)%set%count)
        call take_change(given, modes%configuration, change, loads, load, since, monitor, bodies, wide, state, doubt)
        if (monitor%stop_requested()) return
        since = load
        if (size(state%shape) == 0) then
          since = 0.0_dp
          deallocate (wide)                          ! as no shape refers to their modes
        end if
        configuration = next
        start = until
        call add_doubt(modes%configuration(next)%set)
      end associate
    end do
    metre = units%time%hi**2/units%mass                ! of displacements, loads in N
    do c = 1, size(run%quantity)
      factor = metre*factor_of_quantity(scene, units, run%quantity(c))
      run%history(:, c) = factor*run%history(:, c)
      select case (run%quantity(c))
      case (1, 2); run%error(c) = run%error(c) + of_states(run%point(c), run%quantity(c))
      case (4); run%error(c) = run%error(c) + of_states(run%point(c), 3)
      end select
      run%error(c) = factor*run%error(c)
    end do
    where (run%bound < huge(metre)) run%bound = metre*run%bound
  contains
    subroutine add_doubt(after)
      !! Add the effect of state errors after a change.
      class(mode_set), intent(in) :: after
      type(lack_error) :: found
      found = error_of_state(after, after%count, start, doubt, deflections, scene%response%points, grid)
      of_states(:, 1) = of_states(:, 1) + found%displacement
      of_states(:, 2) = of_states(:, 2) + found%rate
      if (.not. scene%response%bending_moment) return
      found = error_of_state(after, after%count, start, doubt, curvatures, scene%response%points, grid)
      of_states(:, 3) = of_states(:, 3) + found%rate
    end subroutine add_doubt

    subroutine add_errors()
      !! Add the largest truncation error of all segments, and rounding. A bound exists until the first change.
      real(dp) :: bound(size(run%bound))
      real(dp) :: missed(size(run%error), 2), rounding(size(run%error))
      integer, allocatable :: columns(:)
      integer :: o
      if (samples(2) < samples(1)) return
      do o = 1, quantities
        columns = pack([(c, c=1, size(run%quantity))], run%quantity == o)
        if (size(columns) == 0) cycle
        missed(columns, :) = tail_errors(view, tail, columns)
      end do
      associate (set => modes%configuration(configuration)%set)
        bound = huge(bound)
        if (start%hi <= 0.0_dp) bound = bound_of(set, view, flexibility, loads%course, until%hi)
        missed(:size(bound), 1) = min(missed(:size(bound), 1), bound)
        rounding = rounding_of(set, view, tail, until%hi)
        run%bound = max(run%bound, bound)
        where (run%bound < huge(bound)) run%bound = run%bound + rounding(:size(bound))
        held_error = merge(held_error + missed(:, 2), 0.0_dp, size(state%shape) > 0 .and. view%order == 0)
        run%error = max(run%error, missed(:, 1) + held_error) + rounding
      end associate
    end subroutine add_errors
  end subroutine follow_loads

  pure function shown_by(modes, view, q, load) result(shown)
    !! Return histories at an instant: known modes, omitted modes quasi-statically, and no rates, (columns).
    class(mode_set), intent(in) :: modes
    type(load_view), intent(in) :: view
    real(dp), intent(in) :: q(:), load(:)
    real(dp) :: shown(size(view%order)), moved(size(q))
    moved = q
    associate (n => view%summed)
      moved(n + 1:) = q(n + 1:) - matmul(view%drive(n + 1:, :), load)/modes%beta_squared(n + 1:)%hi
    end associate
    shown = merge(matmul(moved, view%weight) + matmul(load, view%residual), 0.0_dp, view%order == 0)
  end function shown_by

  pure function bound_of(modes, view, flexibility, courses, until) result(bound)
    !! Bound the truncation error of displacements: the lag of omitted modes behind each load, times their residual
    !! flexibility between load and point, by the Cauchy–Schwarz inequality. (points)
    class(mode_set), intent(in) :: modes
    type(load_view), intent(in) :: view
    real(dp), intent(in) :: flexibility(:)         !! from `make_view`
    type(load_course), intent(in) :: courses(:)
    real(dp), intent(in) :: until                  !! the end of the segment, l²/h
    real(dp) :: bound(size(flexibility) - size(courses))
    real(dp) :: drift, lag, square
    integer :: l
    square = modes%beta_squared(view%summed)%hi
    bound = huge(lag)
    if (square <= 1.0_dp) return
    drift = 0.0_dp
    if (allocated(modes%damping)) drift = max(modes%damping(view%summed)/square, modes%law%stiffness)
    lag = 1.0_dp/sqrt(square) + drift
    bound = 0.0_dp
    do l = 1, size(courses)
      bound = bound + sqrt(flexibility(:size(bound))*flexibility(size(bound) + l))*lag_bound(courses(l), until, lag, drift)
    end do
  end function bound_of

  subroutine take_change(given, configuration, change, loads, load, since, monitor, bodies, wide, state, doubt)
    !! Project the motion onto the modes after a change of bodies, with the quasi-static motion of omitted modes.
    type(varying_beam), intent(in) :: given          !! before the change
    type(configuration_type), intent(in) :: configuration(:)
    type(change_type), intent(in) :: change
    type(placed_loads), intent(in) :: loads
    real(dp), intent(in) :: load(:, :)               !! loads at the change and their rates, (loads, 2)
    real(dp), intent(in) :: since(:, :)              !! the same when the static shape was set; 0: there is no shape
    class(monitor_type), intent(inout) :: monitor    !! results are invalid if it requests a stop
    type(body_type), intent(inout) :: bodies(:)
    type(configuration_type), intent(inout) :: wide(:)   !! one more than there are configurations
    type(beam_state), intent(inout) :: state
    real(dp), allocatable, intent(out) :: doubt(:, :)   !! errors of displacements and velocities, (modes after, 2)
    integer, parameter :: times_as_many = 4          ! modes are projected
    type(beam_state) :: later
    type(change_type) :: to_aside                    ! onto the set that is kept aside
    type(event_type) :: ignored
    real(dp), allocatable :: drive(:, :), follows(:, :), soft(:), nothing(:, :)
    real(dp) :: beyond(size(bodies), 2, 2), no_points(0)
    integer :: aside, b, n
    aside = size(wide)
    n = configuration(change%from)%set%count
    associate (source => configuration(change%from)%source)
      call source%find(first_numbers(min(source%highest, times_as_many*n)), wide(change%from)%set, monitor=monitor)
    end associate
    if (monitor%stop_requested()) return
    if (allocated(wide(aside)%set)) deallocate (wide(aside)%set)
    allocate (wide(aside)%set, source=configuration(change%onto)%set)   ! fewer than later projections use
    associate (before => wide(change%from)%set, after => configuration(change%onto)%set)
      allocate (nothing(before%count, 0))
      call find_drive(given, before, loads%place, loads%accelerated, monitor, drive, no_points, nothing)
      if (monitor%stop_requested()) return
      beyond = 0.0_dp
      do b = 1, size(bodies)
        if (change%was(b) .or. .not. change%is(b)) cycle
        beyond(b, :, :) = matmul(residual_at(given, before, before%count, loads, drive, bodies(b)%position), load)
      end do
      soft = 0.0_dp*before%modal_mass
      where (before%beta_squared%hi > 1.0_dp) soft = 1.0_dp/(before%modal_mass*before%beta_squared%hi)
      follows = spread(soft, 2, 2)*matmul(drive(:, loads%kind), load)
      doubt = unprojected_errors(configuration(change%from)%set, state%q - follows(:n, 1), state%rate - follows(:n, 2), after, &
                                 bodies, change%was, change%is)
      follows(:, 1) = soft*matmul(drive(:, loads%kind), load(:, 1) - since(:, 1))
      state%count = before%count
      state%q = [state%q, follows(n + 1:, 1)]
      state%rate = [state%rate, follows(n + 1:, 2)]
      to_aside = change
      to_aside%onto = aside
      call change_bodies(wide, to_aside, state, bodies, 0.0_dp, later, ignored, monitor, beyond)
      if (monitor%stop_requested()) return
      later%q = later%q(:after%count)
      later%rate = later%rate(:after%count)
    end associate
    state = later
    where (state%shape%configuration == aside) state%shape%configuration = change%onto
  end subroutine take_change

  pure real(dp) function largest_of(run, quantity) result(peak)
    type(loaded_run), intent(in) :: run
    integer, intent(in) :: quantity
    integer :: c
    peak = 0.0_dp
    do c = 1, size(run%quantity)
      if (run%quantity(c) == quantity) peak = max(peak, maxval(abs(run%history(:run%samples, c))))
    end do
  end function largest_of

end module bw_load_run
