module bw_converged
  !! A run fine enough to measure the errors of others against it. test_bw_converged compares it with residues summed in
  !! 45 digits.
  use bw_case_result, only: case_not_converged, case_result
  use bw_case_tolerance, only: plan_case
  use bw_error, only: error_type, fail, status_not_trusted
  use bw_forecast, only: takes_at_most
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_modes_par, only: by_tolerance, coarsest_tolerance, modes_par
  use bw_monitor, only: monitor_type
  use bw_one_case, only: case_cache, run_case
  use bw_response, only: response_type
  use bw_result_layout, only: layout_of
  use bw_scene, only: converges_in_run, is_loaded, scene_type
  use bw_scene_variant, only: with_tolerance
  use bw_stopwatch, only: stopwatch
  use bw_timed_runs, only: run_once, timed_run
  implicit none (type, external)
  private
  public :: converge, find_parts, find_reach

  real(dp), parameter, public :: converged_tolerance = 1.0e-13_dp   !! a hundredth of the finest rung
  integer, parameter, public :: coarsest_decade = 2   !! of the coarsest rung
  real(dp), parameter :: coarsest = 1.0e-6_dp        !! coarsest tolerance of the converged run, however long it takes
  real(dp), parameter, public :: patience = 3.0_dp   !! s, by the cost model; a longer run is not made
  integer, parameter :: most_extended = 600000    !! modes; extended precision for more would take longer than all rungs

  type, public :: converged_run
    type(case_result), allocatable :: result
    real(dp) :: reach = missing                 !! the finest attainable tolerance
    real(dp) :: tolerance = missing             !! that the run meets: `reach`, or the finest that does not take too long
    real(dp) :: peak = 0.0_dp                   !! m, over all points
    real(dp) :: error = missing                 !! its own error estimate over the peak
    logical :: bounds_all = .false.             !! a tolerance bounds the errors of all histories, each relative to its own peak
  end type converged_run

contains

  subroutine converge(scene, monitor, run, whole, error, longest)
    !! Run with the finest tolerance that is attainable and does not take too long.
    !! **Errors**: `status_bad_input` if no tolerance is attainable, `status_not_trusted` if the run misses its own.
    type(scene_type), intent(in) :: scene       !! without sweeps
    class(monitor_type), intent(inout) :: monitor
    type(converged_run), intent(out) :: run
    logical, intent(out) :: whole               !! false if the monitor asked to stop
    type(error_type), allocatable, intent(out) :: error
    real(dp), intent(in), optional :: longest   !! longest run allowed beside that of the scene itself, s; absent: `patience`
    run%bounds_all = converges_in_run(scene) .or. is_loaded(scene)
    if (run%bounds_all) then
      call converge_by_runs(scene, monitor, run, whole, error, longest)
    else
      call converge_by_plan(scene, monitor, run, whole, error)
    end if
    if (whole .and. .not. allocated(error)) call take_peak(run)
  end subroutine converge

  subroutine converge_by_runs(scene, monitor, run, whole, error, longest)
    !! Refine the tolerance by decades where only a run shows whether it is met: up to one that is missed, or to the
    !! last within the time limit if the run time keeps growing by the same factor. A run of the scene's own tolerance
    !! is always allowed. **Errors**: as above.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout) :: monitor
    type(converged_run), intent(inout) :: run
    logical, intent(out) :: whole
    type(error_type), allocatable, intent(out) :: error
    real(dp), intent(in), optional :: longest
    type(case_result), allocatable :: found, kept
    type(timed_run) :: attempt
    real(dp) :: seconds, before, limit
    integer :: decade
    limit = patience
    if (present(longest)) limit = longest
    seconds = huge(seconds)
    do decade = coarsest_decade, -nint(log10(converged_tolerance))
      attempt = timed_run(with_tolerance(scene, 10.0_dp**(-decade)))
      allocate (found)
      call run_once(attempt, monitor, found, whole)
      if (.not. whole) return
      if (allocated(found%error)) then
        call move_alloc(found%error, error)
        return
      end if
      if (found%status == case_not_converged) exit
      call move_alloc(found, kept)
      run%tolerance = 10.0_dp**(-decade)
      before = min(seconds, attempt%seconds%total())
      seconds = attempt%seconds%total()
      if (seconds*(seconds/before) > limit .and. .not. is_coarser(run%tolerance, scene%modes)) exit
    end do
    run%reach = 0.0_dp                          ! unknown
    if (allocated(found)) run%reach = run%tolerance
    if (allocated(kept)) then
      call move_alloc(kept, run%result)
    else
      call fail(error, status_not_trusted, scene%file//': no converged run: '//found%notes(size(found%notes))%text)
    end if
  end subroutine converge_by_runs

  pure logical function is_coarser(tolerance, modes)
    !! Return whether a tolerance is coarser than that of a scene, which may be relaxed.
    real(dp), intent(in) :: tolerance
    type(modes_par), intent(in) :: modes
    is_coarser = .false.
    if (by_tolerance(modes)) is_coarser = tolerance > modes%tolerance*(1.0_dp + sqrt(epsilon(1.0_dp)))
  end function is_coarser

  subroutine converge_by_plan(scene, monitor, run, whole, error)
    !! Choose the tolerance by plans and the cost model. Every root is found in extended precision unless there are too
    !! many, so that the run does not share rounding errors of the others. **Errors**: as above.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout) :: monitor
    type(converged_run), intent(inout) :: run
    logical, intent(out) :: whole
    type(error_type), allocatable, intent(out) :: error
    type(scene_type) :: fine
    type(case_cache) :: cache
    type(stopwatch) :: watch
    integer :: count
    allocate (run%result)
    call find_reach(scene, monitor, run%reach, error)
    run%tolerance = run%reach
    do
      whole = .not. monitor%stop_requested()
      if (allocated(error) .or. .not. whole) return
      fine = with_tolerance(scene, run%tolerance)
      call plan_case(fine, monitor, count, error)
      if (allocated(error)) return
      if (takes_at_most(fine, count, patience) .or. run%tolerance >= coarsest) then
        fine%modes%extended = count <= most_extended
        call run_case(fine, layout_of(fine), watch, monitor, cache, run%result, whole)
        if (.not. whole) return
        if (run%result%status /= case_not_converged) exit
        run%reach = coarser(run%tolerance)              ! the plan of a run may promise slightly more than the run achieves
        if (run%reach > coarsest_tolerance) call fail(error, status_not_trusted, fine%file//': no converged run: '// &
                                                      run%result%notes(size(run%result%notes))%text)
      end if
      run%tolerance = coarser(run%tolerance)
    end do
  end subroutine converge_by_plan

  pure real(dp) function coarser(tolerance)
    !! Return the next power of ten.
    real(dp), intent(in) :: tolerance
    coarser = 10.0_dp**floor(log10(tolerance) + 1.0_dp + sqrt(epsilon(1.0_dp)))
  end function coarser

  pure subroutine take_peak(run)
    !! Find the peak, and the run's own error estimate over it.
    type(converged_run), intent(inout) :: run
    real(dp) :: nothing
    associate (response => run%result%response)
      if (response%finite_samples > 0) run%peak = maxval(abs(response%displacement(:response%finite_samples, :)))
      call find_parts(response, response, run%bounds_all, nothing, run%error)
    end associate
  end subroutine take_peak

  pure subroutine find_parts(response, fine, bounds_all, error, estimate)
    !! Find the largest difference of a run's histories from finer ones, and its own estimate of it, relative to the
    !! peak of each; over samples that are finite in both, and 0 if nothing moves.
    type(response_type), intent(in) :: response, fine
    logical, intent(in) :: bounds_all           !! errors of all quantities; else of the displacement
    real(dp), intent(out) :: error, estimate    !! the latter is missing if the run has none
    integer :: n
    n = min(response%finite_samples, fine%finite_samples)
    error = 0.0_dp
    estimate = merge(0.0_dp, missing, allocated(response%displacement_error))
    if (n == 0) return
    call look(response%displacement, fine%displacement, response%displacement_error, error, estimate)
    if (.not. bounds_all) return
    call look(response%velocity, fine%velocity, response%velocity_error, error, estimate)
    call look(response%acceleration, fine%acceleration, response%acceleration_error, error, estimate)
    call look(response%bending_moment, fine%bending_moment, response%bending_moment_error, error, estimate)
    call look(response%shear_force, fine%shear_force, response%shear_force_error, error, estimate)
  contains
    pure subroutine look(history, finer, estimated, error, estimate)
      real(dp), allocatable, intent(in) :: history(:, :), finer(:, :), estimated(:)
      real(dp), intent(inout) :: error, estimate
      real(dp) :: peak
      if (.not. allocated(finer)) return
      peak = maxval(abs(finer(:fine%finite_samples, :)))
      if (peak == 0.0_dp) return
      error = max(error, maxval(abs(history(:n, :)/peak - finer(:n, :)/peak)))
      if (allocated(estimated)) estimate = max(estimate, maxval(estimated)/peak)
    end subroutine look
  end subroutine find_parts

  subroutine find_reach(scene, monitor, tolerance, error)
    !! Find the finest attainable tolerance, down to `converged_tolerance`.
    !! **Errors**: `status_bad_input` if there is none.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout) :: monitor
    real(dp), intent(out) :: tolerance
    type(error_type), allocatable, intent(out) :: error
    real(dp), parameter :: margin = 1.02_dp     ! the attainable tolerance is rounded elsewhere, and depends
    integer, parameter :: most_tries = 8        ! slightly on the one requested
    real(dp) :: reached
    integer :: count, i
    tolerance = converged_tolerance
    do i = 1, most_tries
      if (allocated(error)) deallocate (error)
      call plan_case(with_tolerance(scene, tolerance), monitor, count, error, reached)
      if (monitor%stop_requested()) return
      if (.not. allocated(error) .or. reached > coarsest_tolerance) return
      tolerance = margin*max(tolerance, reached)
    end do
  end subroutine find_reach

end module bw_converged
