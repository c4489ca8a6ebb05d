module bw_converged
  !! A run so fine that the errors of others can be measured against it. test_bw_converged compares it with residues summed in 45
  !! digits.
  use bw_case_result, only: case_not_converged, case_result
  use bw_case_tolerance, only: plan_case
  use bw_error, only: error_type, fail, status_not_trusted
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_modes_par, only: coarsest_tolerance
  use bw_monitor, only: monitor_type
  use bw_one_case, only: case_cache, run_case
  use bw_result_layout, only: layout_of
  use bw_scene, only: scene_type
  use bw_scene_variant, only: with_tolerance
  use bw_stopwatch, only: stopwatch
  use bw_timed_runs, only: foresight
  implicit none (type, external)
  private
  public :: converge, find_reach

  real(dp), parameter, public :: converged_tolerance = 1.0e-13_dp   !! a hundredth of the finest rung
  integer, parameter :: first_decade = 6, decades = 2   !! of the tolerances of the runs that come ever nearer to it
  real(dp), parameter :: patience = 5.0_dp           !! s of the processor; a run that would take longer is not made
  real(dp), parameter, public :: steepest_tolerance = 1.0_dp   !! of seconds over 1/tolerance, as a power
  integer, parameter :: most_extended = 600000    !! modes; extended precision for more would take longer than all the rungs

  type, public :: converged_run
    type(case_result) :: result
    real(dp) :: reach = missing                 !! the finest tolerance there is
    real(dp) :: tolerance = missing             !! that the run keeps: `reach`, or the finest that does not take too long
    real(dp) :: peak = 0.0_dp                   !! m, over all points
    real(dp) :: error = missing                 !! its own estimate over the peak
  end type converged_run

contains

  subroutine converge(scene, monitor, run, whole, error)
    !! Make runs of ever finer tolerances, up to the finest in reach or until the next would take too long. The last is the
    !! converged run.
    !! **Errors**: `status_bad_input` where no tolerance is in reach.
    type(scene_type), intent(in) :: scene       !! without sweeps
    class(monitor_type), intent(inout) :: monitor
    type(converged_run), intent(out) :: run
    logical, intent(out) :: whole               !! false where the monitor asked to stop
    type(error_type), allocatable, intent(out) :: error
    type(scene_type) :: fine
    type(foresight) :: foreseen
    real(dp) :: seconds
    integer :: decade
    whole = .true.
    call find_reach(scene, monitor, run%reach, error)
    whole = .not. monitor%stop_requested()
    if (allocated(error) .or. .not. whole) return
    do decade = first_decade, huge(decade) - decades, decades
      run%tolerance = tolerance_of(decade, run%reach)
      fine = with_tolerance(scene, run%tolerance)
      call run_fine(fine, monitor, run, seconds, whole, error)
      if (allocated(error) .or. .not. whole) return
      if (run%tolerance == run%reach) exit
      call foreseen%book(1.0_dp/run%tolerance, seconds)
      if (foreseen%next_seconds(1.0_dp/tolerance_of(decade + decades, run%reach), steepest_tolerance) > patience) exit
    end do
    call take_peak(run)
  end subroutine converge

  pure real(dp) function tolerance_of(decade, reach) result(tolerance)
    !! The tolerance of a decade: a power of ten, or the finest in reach where that is near.
    integer, intent(in) :: decade
    real(dp), intent(in) :: reach
    real(dp), parameter :: near = 20.0_dp       ! a decade, and something for rounding
    tolerance = 10.0_dp**(-decade)
    if (tolerance < near*reach) tolerance = reach
  end function tolerance_of

  subroutine run_fine(fine, monitor, run, seconds, whole, error)
    !! Make one run, with every root in extended precision where there are not too many.
    !! **Errors**: `status_not_trusted` where it does not keep its tolerance.
    type(scene_type), intent(inout) :: fine
    class(monitor_type), intent(inout) :: monitor
    type(converged_run), intent(inout) :: run
    real(dp), intent(out) :: seconds            !! of the processor, which other work on the machine changes least
    logical, intent(out) :: whole               !! false where the monitor asked to stop
    type(error_type), allocatable, intent(out) :: error
    type(case_cache) :: cache
    type(stopwatch) :: watch
    integer :: count
    real(dp) :: began, ended
    whole = .true.
    call cpu_time(began)
    call plan_case(fine, monitor, count, error)
    if (allocated(error)) return
    fine%modes%extended = count <= most_extended  ! so that it does not share what the rungs may have left out
    call run_case(fine, layout_of(fine), watch, monitor, cache, run%result, whole)
    call cpu_time(ended)
    seconds = ended - began
    if (.not. whole .or. run%result%status /= case_not_converged) return
    call fail(error, status_not_trusted, fine%file//': no converged run: '//run%result%notes(size(run%result%notes))%text)
  end subroutine run_fine

  pure subroutine take_peak(run)
    !! Find the peak, and the run's own estimate of its error over it.
    type(converged_run), intent(inout) :: run
    associate (response => run%result%response)
      if (response%finite_samples > 0) run%peak = maxval(abs(response%displacement(:response%finite_samples, :)))
      if (.not. allocated(response%displacement_error)) return
      run%error = 0.0_dp
      if (run%peak > 0.0_dp) run%error = maxval(response%displacement_error)/run%peak
    end associate
  end subroutine take_peak

  subroutine find_reach(scene, monitor, tolerance, error)
    !! Find the finest tolerance that can be reached, down to `converged_tolerance`.
    !! **Errors**: `status_bad_input` where there is none.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout) :: monitor
    real(dp), intent(out) :: tolerance
    type(error_type), allocatable, intent(out) :: error
    real(dp), parameter :: margin = 1.02_dp     ! what is reached is rounded elsewhere, and
    integer, parameter :: most_tries = 8        ! depends a little on what is asked for
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
