module bw_case_loads
  !! The motion of a case under its loads, superposed on its other motion: all is linear, so the loads act on a beam at
  !! rest through the same changes of the beam.
  !!
  !! The number of modes is that of the scene, or doubles until the tolerance is met. The quasi-static contribution of
  !! omitted modes is included; the truncation error is how much they lag behind it. It is estimated with twice the
  !! modes, and bounded for displacements.
  use bw_beam_motion, only: case_modes
  use bw_beam_units, only: beam_units
  use bw_case_modes, only: case_mode_cache, find_modes, most_in_run
  use bw_case_result, only: add_notes, case_diverged, case_done, case_histories, case_motion, case_not_converged, &
    history_errors, load_result
  use bw_change_of_bodies, only: beam_state
  use bw_error, only: error_type
  use bw_kinds, only: dp
  use bw_load_columns, only: quantities
  use bw_load_course, only: impulse_of, largest_load, load_course
  use bw_load_courses, only: courses_of
  use bw_load_run, only: follow_loads, largest_of, loaded_run
  use bw_missing, only: is_missing, missing
  use bw_monitor, only: monitor_type
  use bw_placed_loads, only: place_loads, placed_loads
  use bw_plan, only: bound_times
  use bw_reached_tolerance, only: is_met, judge_tolerance, with_counts
  use bw_scene, only: changes_in_time, scene_type
  use bw_text, only: append, shortest, text_of
  implicit none (type, external)
  private
  public :: add_loads, load_summary

  integer, parameter :: most_count = 1024          !! limit of modes for a default tolerance; four times as many for a requested one

contains

  subroutine add_loads(scene, motion, monitor, cache, histories, errors, found, error, before_event)
    !! Add the motion under loads to the histories of a case, and its errors to theirs.
    type(scene_type), intent(in) :: scene            !! with loads
    type(case_motion), intent(inout) :: motion       !! without loads; its notes and plan are updated
    class(monitor_type), intent(inout), target :: monitor   !! the histories are invalid if it requests a stop
    type(case_mode_cache), intent(inout), target :: cache
    type(case_histories), intent(inout) :: histories
    type(history_errors), intent(inout) :: errors
    type(load_result), allocatable, intent(out) :: found
    type(error_type), allocatable, intent(out) :: error
    type(beam_state), allocatable, intent(out), optional :: before_event(:)   !! motion under loads before each event after t = 0
    type(placed_loads) :: loads
    type(loaded_run) :: run
    type(case_modes) :: modes
    type(scene_type) :: counted
    real(dp) :: reached
    integer :: most, summed(2)
    call courses_of(scene, motion%units, loads%course, error)
    if (allocated(error)) return
    found = load_summary(scene, loads%course, motion%units)
    call add_notes(errors%notes, found%notes)
    call place_loads(scene, loads)
    most = most_in_run(scene, merge(4*most_count, most_count, scene%modes%asked))
    counted = with_counts(scene)
    summed = [counted%modes%before, counted%modes%after]
    do
      counted%modes%before = twice(summed(1))
      counted%modes%after = twice(summed(2))
      call find_modes(counted, motion%units, monitor, modes, cache)
      if (monitor%stop_requested()) return
      if (.not. modes%resolved) then
        errors%status = case_not_converged
        return
      end if
      call follow_loads(counted, motion%units, modes, summed, loads, monitor, run)
      if (monitor%stop_requested()) return
      reached = part_of_peak(run)
      if (is_met(scene%modes, reached) .or. summed(1) >= most) exit
      summed = min(most, 2*summed)
    end do
    call take_run(scene, run, histories, errors)
    if (run%samples < scene%response%samples .and. errors%status == case_done) then
      errors%status = case_diverged
      call append(errors%notes, 'overflow: a mode grows beyond the range of double precision at t = '// &
        shortest(run%samples*(scene%response%duration/scene%response%samples), 6)//' s; the histories are missing from there on')
    end if
    call judge_tolerance(scene%modes, reached, run%count, 'fewer quantities, loads without jumps', histories%response, errors)
    found%count = run%count
    if (present(before_event)) call move_alloc(run%before_event, before_event)
    motion%plan%reached = max(motion%plan%reached, reached)
  contains
    pure integer function twice(count)
      !! Return twice a count, as far as there are modes.
      integer, intent(in) :: count
      twice = max(count, min(2*count, most_in_run(scene, 4*most_count)))
    end function twice
  end subroutine add_loads

  pure type(load_result) function load_summary(scene, courses, units) result(loads)
    !! Summarise the applied loads, and note impulses before t = 0.
    type(scene_type), intent(in) :: scene
    type(load_course), intent(in) :: courses(:)    !! forces, then base accelerations as forces on the beam
    type(beam_units), intent(in) :: units
    real(dp), parameter :: worth_saying = 1.0e-3_dp   ! of the impulse
    character(:), allocatable :: name
    integer :: forces, l
    forces = 0
    if (allocated(scene%forces)) forces = size(scene%forces)
    associate (largest => largest_load(courses), impulse => impulse_of(courses)*units%time%hi)
      loads%applied_force = largest(:forces)
      loads%applied_impulse = impulse(:forces)
      loads%applied_acceleration = largest(forces + 1:)/units%mass
      loads%applied_velocity = -impulse(forces + 1:)/units%mass
    end associate
    loads%until = maxval([(courses(l)%knot(size(courses(l)%knot)), l=1, size(courses))])*units%time%hi
    allocate (loads%notes(0))
    do l = 1, size(courses)
      associate (before => abs(courses(l)%left_out), after => abs(impulse_of(courses(l))))
        if (before <= worth_saying*(before + after)) cycle
        name = 'force '//text_of(l)
        if (l > forces) name = 'acceleration '//text_of(l - forces)//' of the base'
        call append(loads%notes, name//': '//shortest(100.0_dp*before/(before + after), 3)//' % of its impulse lies before t = '// &
                    '0, and is ignored; a later start includes all of it')
      end associate
    end do
  end function load_summary

  pure real(dp) function part_of_peak(run) result(part)
    !! Return the largest error of any quantity over its peak; for displacements also the bound over `bound_times`.
    type(loaded_run), intent(in) :: run
    real(dp) :: peak, error
    integer :: q
    part = 0.0_dp
    do q = 1, quantities
      peak = largest_of(run, q)
      error = maxval(run%error, mask=run%quantity == q)
      if (q == 1) error = max(error, maxval(run%bound, mask=run%bound < huge(error))/bound_times)
      if (peak > 0.0_dp .and. error > 0.0_dp) part = max(part, error/peak)
    end do
  end function part_of_peak

  subroutine take_run(scene, run, histories, errors)
    !! Add a run to the histories of the case. Samples unknown in either become `missing`.
    type(scene_type), intent(in) :: scene
    type(loaded_run), intent(in) :: run
    type(case_histories), intent(inout) :: histories
    type(history_errors), intent(inout) :: errors
    logical :: alone_there
    integer :: n
    alone_there = .not. (allocated(scene%impact) .or. changes_in_time(scene))
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
      if (allocated(response%hub_angle)) then
        response%hub_angle(:n) = response%hub_angle(:n) + run%history(:n, findloc(run%quantity, quantities, dim=1))
        response%hub_angle(n + 1:) = missing
      end if
      if (alone_there) errors%displacement_bound = 0.0_dp*run%bound
      if (allocated(errors%displacement_bound)) then
        where (.not. is_missing(errors%displacement_bound)) errors%displacement_bound = errors%displacement_bound + run%bound
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
