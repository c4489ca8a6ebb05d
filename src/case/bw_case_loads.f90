module bw_case_loads
  !! The motion of a case under its loads, to its histories and their errors. What moves the beam otherwise is added to it, since all of
  !! that is linear: the loads act on a beam at rest, through the same changes of its topology.
  !!
  !! The number of modes is that of the scene, or doubles until the tolerance is kept. With every number what modes beyond it add at once
  !! is part of the answer; what is missing is how much they lag behind the loads. As many modes more tell that, and for displacements it
  !! is bounded.
  use bw_case_modes, only: case_mode_cache, find_modes, most_to_tolerance
  use bw_case_moments, only: scale_of_moments
  use bw_case_result, only: case_diverged, case_done, case_histories, case_modes, case_motion, case_not_converged, history_errors, &
    load_result
  use bw_beam_units, only: beam_units
  use bw_double_double, only: dd, to_dd, operator(-)
  use bw_error, only: error_type
  use bw_kinds, only: dp
  use bw_load_course, only: impulse_of, interval_at, lag_bound, largest_load, load_course, rates_of
  use bw_load_courses, only: courses_of
  use bw_load_modes, only: carried_mass, find_residuals, find_shears, total_mass
  use bw_load_sum, only: load_tail, load_view, rounding_of, sum_loaded_modes, tail_error
  use bw_missing, only: is_missing, missing
  use bw_mode_set, only: configuration_type, curvatures, deflections, first_numbers, mode_set, values_at
  use bw_modes_par, only: by_tolerance, relaxed_tolerance
  use bw_monitor, only: monitor_type
  use bw_note, only: remark
  use bw_scene, only: by_pieces, changes_shapes, scene_type
  use bw_scene_pieces, only: pieces_of, varying_of
  use bw_segment, only: alone, growth_ends
  use bw_text, only: append, shortest, text_of
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  use bw_timeline, only: change_type, changes_of, happens
  use bw_varying_beam, only: varying_beam
  implicit none (type, external)
  private
  public :: add_loads, without_tolerance

  integer, parameter :: first_count = 32           !! modes that a tolerance begins with
  integer, parameter :: most_count = 1024          !! and the most that it takes, four times as many where it was asked for
  real(dp), parameter :: rounding_in_bound = 1.0e-12_dp    !! of the peak
  real(dp), parameter :: bound_times = 100.0_dp    !! a proved bound may be as many tolerances

  integer, parameter :: quantities = 5             !! displacement, velocity, acceleration, bending moment, shear force
  integer, parameter :: weight_of(quantities) = [1, 1, 1, 2, 3], order_of(quantities) = [0, 1, 2, 0, 0]

  type :: loaded_run
    !! The histories of some modes, SI.
    real(dp), allocatable :: history(:, :)         !! (samples, columns)
    real(dp), allocatable :: error(:)              !! (columns)
    real(dp), allocatable :: bound(:)              !! of the displacements, (points)
    integer, allocatable :: quantity(:), point(:)  !! (columns)
    integer :: samples = 0                         !! that are known
    integer :: count = 0                           !! modes
  end type loaded_run

contains

  pure type(scene_type) function without_tolerance(scene) result(counted)
    !! A scene whose modes are found by counts where nothing but loads moves the beam: how many these take is found here.
    type(scene_type), intent(in) :: scene
    counted = scene
    if (allocated(scene%impact) .or. .not. by_tolerance(scene%modes)) return
    counted%modes%tolerance = missing
    counted%modes%before = scene%modes%after
  end function without_tolerance

  subroutine add_loads(scene, motion, monitor, cache, histories, errors, found, error)
    !! Add the motion under loads to the histories of a case, and its errors to theirs.
    type(scene_type), intent(in) :: scene            !! with loads
    type(case_motion), intent(inout) :: motion       !! without the loads, whose notes and plan are added to
    class(monitor_type), intent(inout), target :: monitor   !! the histories mean nothing where it asks to stop
    type(case_mode_cache), intent(inout), target :: cache
    type(case_histories), intent(inout) :: histories
    type(history_errors), intent(inout) :: errors
    type(load_result), allocatable, intent(out) :: found
    type(error_type), allocatable, intent(out) :: error
    type(load_course), allocatable :: courses(:)
    type(loaded_run) :: run
    type(case_modes) :: modes
    type(scene_type) :: counted
    real(dp) :: reached, tolerance
    integer :: most, summed(2)
    call courses_of(scene, motion%units, courses, error)
    if (allocated(error)) return
    found = loads_of(courses, motion%units, count_forces(scene))
    counted = scene
    most = most_count
    if (scene%modes%asked) most = 4*most_count
    if (changes_shapes(scene) .and. .not. by_pieces(scene)) most = most_to_tolerance(merge(2, 1, allocated(scene%shear)))
    if (by_tolerance(scene%modes)) then
      counted%modes%tolerance = missing
    end if
    summed = [scene%modes%before, scene%modes%after]
    if (by_tolerance(scene%modes)) summed = first_count
    do
      counted%modes%before = twice(summed(1))
      counted%modes%after = twice(summed(2))
      call find_modes(counted, motion%units, monitor, modes, cache)
      if (monitor%stop_requested()) return
      if (.not. modes%resolved) then
        errors%status = case_not_converged
        return
      end if
      call follow_loads(counted, motion%units, modes, summed, courses, monitor, run)
      if (monitor%stop_requested()) return
      if (.not. by_tolerance(scene%modes)) exit
      tolerance = scene%modes%tolerance
      reached = part_of_peak(run)
      if (reached <= tolerance .or. summed(1) >= most) exit
      summed = min(most, 2*summed)
    end do
    call take_run(scene, run, histories, errors)
    if (run%samples < scene%response%samples .and. errors%status == case_done) then
      errors%status = case_diverged
      call append(errors%notes, 'overflow: a mode grows out of the range of numbers at t = '// &
        shortest(run%samples*(scene%response%duration/scene%response%samples), 6)//' s; the histories hold fill from there on')
    end if
    if (by_tolerance(scene%modes)) call judge(scene, reached, run%count, errors)
    found%count = run%count
    motion%plan%reached = max(motion%plan%reached, part_of_peak(run))
  contains
    pure integer function twice(count)
      !! As many modes more as there are to be had.
      integer, intent(in) :: count
      twice = max(count, min(2*count, 4*most_count))
      if (changes_shapes(scene) .and. .not. by_pieces(scene)) twice = max(count, min(2*count, most))
    end function twice
  end subroutine add_loads

  pure integer function count_forces(scene) result(forces)
    type(scene_type), intent(in) :: scene
    forces = 0
    if (allocated(scene%forces)) forces = size(scene%forces)
  end function count_forces

  pure type(load_result) function loads_of(courses, units, forces) result(loads)
    !! What was applied.
    type(load_course), intent(in) :: courses(:)
    type(beam_units), intent(in) :: units
    integer, intent(in) :: forces                  !! how many of them are; the others are what accelerations do to the beam
    integer :: l
    associate (largest => largest_load(courses), impulse => impulse_of(courses)*units%time%hi)
      loads%force_largest = largest(:forces)
      loads%force_impulse = impulse(:forces)
      loads%base_largest = largest(forces + 1:)/units%mass
      loads%base_velocity = -impulse(forces + 1:)/units%mass
    end associate
    loads%until = maxval([(courses(l)%knot(size(courses(l)%knot)), l=1, size(courses))])*units%time%hi
  end function loads_of

  subroutine judge(scene, reached, count, errors)
    !! A tolerance that was not asked for relaxes to what was reached.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: reached
    integer, intent(in) :: count                   !! modes that were summed
    type(history_errors), intent(inout) :: errors
    if (reached <= scene%modes%tolerance .or. errors%status /= case_done) return
    if (scene%modes%asked) then
      errors%status = case_not_converged
      call append(errors%notes, 'tolerance: '//shortest(scene%modes%tolerance, 6)//' is missed with '//text_of(count)// &
                  ' modes; accepted: '//shortest(1.05_dp*reached, 2)//' or more, or before, which counts modes')
    else if (is_missing(relaxed_tolerance(reached))) then
      errors%status = case_not_converged
      call append(errors%notes, 'tolerance: none is reached with '//text_of(count)//' modes; accepted: fewer quantities, '// &
                  'loads without jumps, or before, which counts modes')
    else
      call remark(errors%notes, 'tolerance: the default '//shortest(scene%modes%tolerance, 6)//' is out of reach; '// &
        'under the loads the histories are found to '//shortest(relaxed_tolerance(reached), 6)//' of their peaks instead')
    end if
  end subroutine judge

  subroutine follow_loads(scene, units, modes, summed, courses, monitor, run)
    !! The histories of the modes that are counted.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(case_modes), intent(in) :: modes            !! with more than are summed, if there are
    integer, intent(in) :: summed(2)                 !! modes of each configuration that are
    type(load_course), intent(in) :: courses(:)
    class(monitor_type), intent(inout) :: monitor
    type(loaded_run), intent(out) :: run
    type(load_view) :: view
    type(load_tail) :: tail
    type(time_grid) :: grid
    type(change_type), allocatable :: changes(:)
    real(dp), allocatable :: q(:), v(:), flexibility(:)
    real(dp) :: ends, factor
    type(dd) :: start, until
    integer :: c, configuration, i, samples(2)
    call list_columns(scene, run)
    grid = time_grid_of(scene%response%duration, scene%response%samples, units%time)
    allocate (run%history(grid%samples, size(run%quantity)), source=0.0_dp)
    allocate (run%error(size(run%quantity)), run%bound(size(scene%response%points)), source=0.0_dp)
    changes = changes_of(scene, units)
    configuration = modes%moving
    run%count = summed(configuration)
    run%samples = grid%samples
    start = to_dd(0.0_dp)
    do i = 0, size(changes)
      associate (set => modes%configuration(configuration)%set)
        ends = start%hi + growth_ends(set)
        until = to_dd(scene%response%duration/units%time%hi)
        if (i < size(changes)) then
          if (happens(changes(i + 1), scene, changes(i + 1)%time - start, set)) until = changes(i + 1)%time
        end if
        samples = [first_sample(start, grid), first_sample(until, grid) - 1]
        if (ends < until%hi) then
          samples(2) = min(samples(2), first_sample(to_dd(ends), grid) - 1)
          run%samples = samples(2)
          until = to_dd(ends)
        end if
        call make_view(scene, beam_of(scene, units, configuration), set, summed(configuration), courses, run, view, &
                       flexibility)
        if (.not. allocated(q)) q = spread(0.0_dp, 1, set%count)
        if (.not. allocated(v)) v = q
        if (allocated(tail%amplitude)) deallocate (tail%amplitude, tail%largest, tail%squares)
        call sum_loaded_modes(set, view, grid, samples, start, until, monitor, q, v, run%history, tail)
        if (monitor%stop_requested()) return
        call add_errors()
        if (run%samples < grid%samples .or. until%hi >= scene%response%duration/units%time%hi) exit
        call hand_over(scene, beam_of(scene, units, configuration), modes%configuration(configuration), &
                       modes%configuration(changes(i + 1)%configuration)%set, courses, until, monitor, q, v)
        if (monitor%stop_requested()) return
        configuration = changes(i + 1)%configuration
        start = until
      end associate
    end do
    do c = 1, size(run%quantity)
      factor = factor_of_quantity(scene, units, run%quantity(c))
      run%history(:, c) = factor*run%history(:, c)
      run%error(c) = factor*run%error(c)
    end do
    run%bound = factor_of_quantity(scene, units, 1)*run%bound
  contains
    subroutine add_errors()
      !! What is missing of infinitely many modes, the most of all segments, and rounding.
      real(dp) :: bound(size(run%bound)), missed(size(run%error)), largest(size(run%error))
      integer, allocatable :: columns(:)
      integer :: o
      if (samples(2) < samples(1)) return
      largest = 0.0_dp
      do o = 1, quantities
        columns = pack([(c, c=1, size(run%quantity))], run%quantity == o)
        if (size(columns) == 0) cycle
        missed(columns) = tail_error(view, tail, columns)
        where (any(abs(run%history(:run%samples, columns)) > 0.0_dp, dim=1)) largest(columns) = largest_of(run, o)
      end do
      associate (set => modes%configuration(configuration)%set)
        bound = bound_of(set, view, flexibility, courses, until%hi)
        missed(:size(bound)) = min(missed(:size(bound)), bound)
        run%bound = max(run%bound, bound)
        run%error = max(run%error, missed) + rounding_of(set, view, tail, until%hi, largest)
      end associate
    end subroutine add_errors
  end subroutine follow_loads

  pure function bound_of(modes, view, flexibility, courses, until) result(bound)
    !! A bound of what the displacements of infinitely many modes differ by: how much the missing ones lag behind each load, times their
    !! flexibility between its place and the point, by Cauchy and Schwarz. (points)
    class(mode_set), intent(in) :: modes
    type(load_view), intent(in) :: view
    real(dp), intent(in) :: flexibility(:)         !! as that of `make_view`
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

  pure type(varying_beam) function beam_of(scene, units, configuration) result(given)
    !! What the modes of a configuration are of.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    integer, intent(in) :: configuration
    given = varying_of(scene, units, pieces_of(scene, units, configuration /= alone))
  end function beam_of

  pure subroutine list_columns(scene, run)
    !! All quantities that are asked for, at all points.
    type(scene_type), intent(in) :: scene
    type(loaded_run), intent(inout) :: run
    integer :: p, q
    logical :: asked(quantities)
    associate (response => scene%response)
      asked = [.true., response%velocity, response%acceleration, response%bending_moment, response%shear_force]
      allocate (run%quantity(0), run%point(0))
      do q = 1, quantities
        if (.not. asked(q)) cycle
        run%quantity = [run%quantity, spread(q, 1, size(response%points))]
        run%point = [run%point, [(p, p=1, size(response%points))]]
      end do
    end associate
  end subroutine list_columns

  pure real(dp) function factor_of_quantity(scene, units, quantity) result(factor)
    !! SI over what the modes show under loads in N: T²/m_i makes displacements, m.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    integer, intent(in) :: quantity
    factor = units%time%hi**2/units%mass/units%time%hi**order_of(quantity)
    if (weight_of(quantity) > 1) factor = factor*scale_of_moments(scene)
    if (weight_of(quantity) > 2) factor = factor/units%length
  end function factor_of_quantity

  subroutine find_drive(scene, given, modes, places, drive, shear)
    !! How each kind of load drives the modes: forces at their places, and the acceleration of the frame by −1 behind them.
    type(scene_type), intent(in) :: scene
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    real(dp), allocatable, intent(out) :: places(:)
    real(dp), allocatable, intent(out) :: drive(:, :)    !! (modes, kinds)
    real(dp), intent(out), optional :: shear(:, :)       !! forces of the modes at the points, where they are asked for, (modes, points)
    real(dp), allocatable :: forces(:, :)
    real(dp) :: participation(modes%count)
    allocate (places(0))
    if (allocated(scene%forces)) places = scene%forces%position
    drive = modes%shapes(places)
    if (present(shear)) then
      shear = 0.0_dp
      if (.not. (allocated(scene%bases) .or. scene%response%shear_force)) return
      call find_shears(given, modes, scene%response%points, shear, participation)
    else
      if (.not. allocated(scene%bases)) return
      allocate (forces(modes%count, 0))
      call find_shears(given, modes, places(:0), forces, participation)
    end if
    if (allocated(scene%bases)) drive = reshape([drive, participation], [modes%count, size(places) + 1])
  end subroutine find_drive

  pure function kinds_of(loads, places, kinds) result(kind)
    !! Which column of the drives each load has: motions of the base share the last one.
    integer, intent(in) :: loads, places, kinds
    integer :: kind(loads)
    integer :: l
    kind = [(min(l, kinds), l=1, loads)]
    if (loads < places) kind = 0                   ! there are none of these
  end function kinds_of

  subroutine make_view(scene, given, modes, summed, courses, run, view, flexibility)
    !! What the loads drive and what is looked at.
    type(scene_type), intent(in) :: scene
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: summed
    type(load_course), intent(in) :: courses(:)
    type(loaded_run), intent(in) :: run
    type(load_view), intent(out) :: view
    real(dp), allocatable, intent(out) :: flexibility(:) !! of what is missing: at the points, and as each load sees it, (points + loads)
    real(dp), allocatable :: places(:), drive(:, :), residual(:, :, :), soft(:)
    real(dp) :: weights(modes%count, size(scene%response%points), 3)
    integer, allocatable :: kind(:)
    integer :: c, l
    associate (points => scene%response%points)
      call find_drive(scene, given, modes, places, drive, weights(:, :, 3))
      weights(:, :, 1) = values_at(modes, deflections, 1, modes%count, points)
      weights(:, :, 2) = values_at(modes, curvatures, 1, modes%count, points)
      allocate (residual(size(drive, 2), size(points), 3), soft(size(points) + size(places)))
      view%summed = min(summed, modes%count)
      call find_residuals(given, modes, view%summed, places, allocated(scene%bases), drive, weights, points, residual, soft)
      kind = kinds_of(size(courses), size(places), size(drive, 2))
      flexibility = [soft(:size(points)), spread(0.0_dp, 1, size(courses))]
      allocate (view%drive(modes%count, size(courses)), view%weight(modes%count, size(run%quantity)), &
                view%residual(size(courses), size(run%quantity)))
      view%course = courses
      view%order = order_of(run%quantity)
      do l = 1, size(courses)
        view%drive(:, l) = drive(:, kind(l))/modes%modal_mass
        if (kind(l) <= size(places)) then
          flexibility(size(points) + l) = soft(size(points) + kind(l))
        else
          flexibility(size(points) + l) = max(0.0_dp, total_mass(given) - carried_mass(modes, drive(:view%summed, kind(l)))) &
            /max(modes%beta_squared(view%summed)%hi, 1.0_dp)
        end if
      end do
      do c = 1, size(run%quantity)
        view%weight(:, c) = weights(:, run%point(c), weight_of(run%quantity(c)))
        view%residual(:, c) = residual(kind, run%point(c), weight_of(run%quantity(c)))
      end do
    end associate
  end subroutine make_view

  subroutine hand_over(scene, given, configuration, after, courses, time, monitor, q, v)
    !! The motion goes over to other modes, with that of modes that were not summed, which follow the loads at once.
    type(scene_type), intent(in) :: scene
    type(varying_beam), intent(in) :: given          !! before the change
    type(configuration_type), intent(in) :: configuration
    class(mode_set), intent(in) :: after
    type(load_course), intent(in) :: courses(:)
    type(dd), intent(in) :: time
    class(monitor_type), intent(inout) :: monitor
    real(dp), allocatable, intent(inout) :: q(:), v(:)
    integer, parameter :: times_as_many = 4          ! modes are handed on as are summed
    class(mode_set), allocatable :: before
    real(dp), allocatable :: places(:), drive(:, :), moved(:), moving(:)
    real(dp) :: level, slope
    complex(dp) :: tone
    integer, allocatable :: kind(:)
    integer :: l, n
    n = configuration%set%count
    call configuration%source%find(first_numbers(min(configuration%source%highest, times_as_many*n)), before, monitor=monitor)
    if (monitor%stop_requested()) return
    call find_drive(scene, given, before, places, drive)
    kind = kinds_of(size(courses), size(places), size(drive, 2))
    moved = spread(0.0_dp, 1, before%count)
    moving = moved
    do l = 1, size(courses)
      call rates_of(courses(l), interval_at(courses(l), time%hi), time%hi, level, slope, tone)
      associate (soft => drive(:, kind(l))/(before%modal_mass*before%beta_squared%hi))
        moved = moved + soft*(level + real(tone))
        moving = moving + soft*(slope - courses(l)%frequency*aimag(tone))
      end associate
    end do
    moved(:n) = q
    moving(:n) = v
    q = after%overlap_of_beam(before, moved, monitor)/after%modal_mass
    v = after%overlap_of_beam(before, moving, monitor)/after%modal_mass
  end subroutine hand_over

  pure real(dp) function part_of_peak(run) result(part)
    !! The largest error of a quantity over its peak, and the bound of that of displacements over what it may be.
    type(loaded_run), intent(in) :: run
    real(dp) :: peak, error
    integer :: q
    part = 0.0_dp
    do q = 1, quantities
      peak = largest_of(run, q)
      error = maxval(run%error, mask=run%quantity == q)
      if (q == 1) error = max(error, maxval(run%bound)/bound_times)
      if (peak > 0.0_dp .and. error > 0.0_dp) part = max(part, error/peak)
    end do
  end function part_of_peak

  pure real(dp) function largest_of(run, quantity) result(peak)
    type(loaded_run), intent(in) :: run
    integer, intent(in) :: quantity
    integer :: c
    peak = 0.0_dp
    do c = 1, size(run%quantity)
      if (run%quantity(c) == quantity) peak = max(peak, maxval(abs(run%history(:run%samples, c))))
    end do
  end function largest_of

  subroutine take_run(scene, run, histories, errors)
    !! Into the histories of the case. Where something strikes the beam, what is not known of that is not known of the whole.
    type(scene_type), intent(in) :: scene
    type(loaded_run), intent(in) :: run
    type(case_histories), intent(inout) :: histories
    type(history_errors), intent(inout) :: errors
    logical :: alone_there
    integer :: n
    alone_there = .not. allocated(scene%impact)
    associate (response => histories%response)
      n = min(response%finite_samples, run%samples)
      response%finite_samples = n
      if (scene%response%acceleration) allocate (response%acceleration, mold=response%displacement)
      if (scene%response%shear_force) allocate (response%shear_force, mold=response%displacement)
      if (allocated(response%acceleration)) response%acceleration = 0.0_dp
      if (allocated(response%shear_force)) response%shear_force = 0.0_dp
      call add(1, response%displacement, errors%displacement)
      if (allocated(response%velocity)) call add(2, response%velocity, errors%velocity)
      if (allocated(response%acceleration)) call add(3, response%acceleration, errors%acceleration)
      if (allocated(response%bending_moment)) call add(4, response%bending_moment, errors%bending_moment)
      if (allocated(response%shear_force)) call add(5, response%shear_force, errors%shear_force)
      if (alone_there) errors%displacement_bound = 0.0_dp*run%bound
      if (allocated(errors%displacement_bound)) then
        where (.not. is_missing(errors%displacement_bound)) errors%displacement_bound = errors%displacement_bound + run%bound &
          + rounding_in_bound*largest_of(run, 1)
        where (run%bound >= huge(1.0_dp)) errors%displacement_bound = missing
      end if
    end associate
  contains
    subroutine add(quantity, history, error)
      integer, intent(in) :: quantity
      real(dp), intent(inout) :: history(:, :)
      real(dp), allocatable, intent(inout) :: error(:)
      integer :: c
      if (alone_there) error = spread(0.0_dp, 1, size(history, 2))
      do c = 1, size(run%quantity)
        if (run%quantity(c) /= quantity) cycle
        history(:n, run%point(c)) = history(:n, run%point(c)) + run%history(:n, c)
        history(n + 1:, run%point(c)) = missing
        if (allocated(error)) error(run%point(c)) = error(run%point(c)) + run%error(c)
      end do
    end subroutine add
  end subroutine take_run

end module bw_case_loads
