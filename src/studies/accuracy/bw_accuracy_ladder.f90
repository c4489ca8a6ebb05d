module bw_accuracy_ladder
  !! The rungs of an accuracy study, and the measurement of one of them.
  use bw_case_result, only: case_diverged, case_not_converged, case_result
  use bw_converged, only: coarsest_decade, converged_run, find_parts, patience
  use bw_forecast, only: takes_at_most
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_price_list, only: by_counts, by_products, by_tolerances, by_transform, priced_stages, rung_diverged, &
    rung_measured, rung_out_of_reach, rung_too_long, rung_type
  use bw_scene, only: scene_type
  use bw_scene_variant, only: with_counts, with_tolerance
  use bw_timed_runs, only: timed_run
  implicit none (type, external)
  private
  public :: ladder_of, scene_of_rung, take_errors, take_seconds, leave_out

  integer, parameter :: finest = 11               !! decade of the finest tolerance
  integer, parameter, public :: counts(*) = [5, 10, 20, 50, 100, 200, 500, 1000, 2000]

contains

  pure function ladder_of() result(rungs)
    !! Return all rungs, from coarse to fine: tolerances, then mode counts.
    type(rung_type), allocatable :: rungs(:)
    integer, parameter :: asked = finest - coarsest_decade + 1
    integer :: i
    allocate (rungs(asked + size(counts)))
    do i = 1, asked
      rungs(i)%ladder = by_tolerances
      rungs(i)%tolerance = 10.0_dp**(-(coarsest_decade + i - 1))
    end do
    do i = 1, size(counts)
      rungs(asked + i)%ladder = by_counts
      rungs(asked + i)%mode_count = counts(i)
    end do
  end function ladder_of

  pure type(scene_type) function scene_of_rung(scene, rung) result(variant)
    !! Return the scene with a rung's tolerance or mode counts.
    type(scene_type), intent(in) :: scene
    type(rung_type), intent(in) :: rung
    if (rung%ladder == by_counts) then
      variant = with_counts(scene, rung%mode_count)
    else
      variant = with_tolerance(scene, rung%tolerance)
    end if
  end function scene_of_rung

  subroutine leave_out(converged, runs, rungs)
    !! Mark the rungs that are not run: tolerances that the program refuses, and runs that take too long by the cost model.
    type(converged_run), intent(in) :: converged
    type(timed_run), intent(inout) :: runs(:)
    type(rung_type), intent(inout) :: rungs(:)
    integer :: i
    do i = 1, size(rungs)
      if (is_missing(rungs(i)%tolerance)) then
        if (.not. takes_at_most(runs(i)%scene, rungs(i)%mode_count, patience)) rungs(i)%status = rung_too_long
      else if (rungs(i)%tolerance < converged%reach) then
        rungs(i)%status = rung_out_of_reach
      else if (rungs(i)%tolerance < converged%tolerance) then
        rungs(i)%status = rung_too_long
      end if
      runs(i)%is_timed = rungs(i)%status == rung_measured
    end do
  end subroutine leave_out

  pure subroutine take_errors(result, converged, rung)
    !! Put into a rung its errors relative to the converged run.
    type(case_result), intent(in) :: result
    type(converged_run), intent(in) :: converged
    type(rung_type), intent(inout) :: rung
    rung%mode_count = result%mode_count
    if (result%status == case_not_converged) rung%status = rung_out_of_reach
    if (result%status == case_not_converged) return
    rung%method = merge(by_transform, by_products, result%response%transformed > 0)
    if (result%status == case_diverged) rung%status = rung_diverged
    call find_parts(result%response, converged%result%response, converged%bounds_all, rung%error, rung%estimate)
  end subroutine take_errors

  pure subroutine take_seconds(run, rung)
    !! Put the median and the quartiles of the repeats into a rung.
    type(timed_run), intent(in) :: run
    type(rung_type), intent(inout) :: rung
    integer :: i
    rung%repeats = run%seconds%count
    if (rung%repeats == 0) return
    rung%seconds = run%seconds%median()
    rung%lower = run%seconds%quantile(0.25_dp)
    rung%upper = run%seconds%quantile(0.75_dp)
    rung%stages = [(run%stage(i)%median(), i=1, priced_stages)]
  end subroutine take_seconds

end module bw_accuracy_ladder
