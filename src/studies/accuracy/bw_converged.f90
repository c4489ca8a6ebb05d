module bw_converged
  !! A run so fine that the errors of others can be measured against it. test_bw_converged compares it with residues summed in 45
  !! digits.
  use bw_case_result, only: case_not_converged, case_result
  use bw_case_tolerance, only: plan_case
  use bw_error, only: error_type, fail, status_not_trusted
  use bw_forecast, only: takes_at_most
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_modes_par, only: coarsest_tolerance
  use bw_monitor, only: monitor_type
  use bw_one_case, only: case_cache, run_case
  use bw_result_layout, only: layout_of
  use bw_scene, only: scene_type
  use bw_scene_variant, only: with_tolerance
  use bw_stopwatch, only: stopwatch
  implicit none (type, external)
  private
  public :: converge, find_reach

  real(dp), parameter, public :: converged_tolerance = 1.0e-13_dp   !! a hundredth of the finest rung
  real(dp), parameter :: coarsest = 1.0e-6_dp        !! of the converged run, however long it takes
  real(dp), parameter, public :: patience = 3.0_dp   !! s, by the model of costs; a run that takes longer is not made
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
    !! Run with the finest tolerance in reach, or with the finest power of ten that does not take too long by the model of costs; every
    !! root is in extended precision where there are not too many, so that the run does not share what others leave out.
    !! **Errors**: `status_bad_input` where no tolerance is in reach, `status_not_trusted` where the run does not keep its own.
    type(scene_type), intent(in) :: scene       !! without sweeps
    class(monitor_type), intent(inout) :: monitor
    type(converged_run), intent(out) :: run
    logical, intent(out) :: whole               !! false where the monitor asked to stop
    type(error_type), allocatable, intent(out) :: error
    type(scene_type) :: fine
    type(case_cache) :: cache
    type(stopwatch) :: watch
    integer :: count
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
        run%reach = coarser(run%tolerance)              ! the plan of a run may promise a little more than the run keeps
        if (run%reach > coarsest_tolerance) call fail(error, status_not_trusted, fine%file//': no converged run: '// &
                                                      run%result%notes(size(run%result%notes))%text)
      end if
      run%tolerance = coarser(run%tolerance)
    end do
    call take_peak(run)
  end subroutine converge

  pure real(dp) function coarser(tolerance)
    !! The next power of ten.
    real(dp), intent(in) :: tolerance
    coarser = 10.0_dp**floor(log10(tolerance) + 1.0_dp + sqrt(epsilon(1.0_dp)))
  end function coarser

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
