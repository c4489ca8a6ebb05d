module bw_timed_runs
  !! How long cases take, one beside the other: they are run in turn, round after round, so that what else the machine
  !! does falls on all of them alike.
  use bw_case_result, only: case_result
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type, part_monitor
  use bw_one_case, only: case_cache, run_case
  use bw_result_layout, only: layout_of
  use bw_scene, only: scene_type
  use bw_stopwatch, only: repeats_type, stage_count, stopwatch
  implicit none (type, external)
  private
  public :: repeat_runs, run_once

  integer, parameter :: fewest = 3, most = 15     !! runs of each case

  type, public :: timed_run
    type(scene_type) :: scene                     !! without sweeps
    logical :: is_timed = .true.                  !! false: `repeat_runs` leaves it out
    type(repeats_type) :: seconds                 !! of the whole case, from its modes to its last stage
    type(repeats_type) :: stage(stage_count)      !! of its stages
  end type timed_run

contains

  subroutine run_once(run, monitor, result, whole)
    !! Run a case once more, and book its time.
    type(timed_run), intent(inout) :: run
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(out) :: result
    logical, intent(out) :: whole                 !! false where the monitor asked to stop; nothing is booked then
    type(case_cache) :: cache
    type(stopwatch) :: watch
    integer :: i
    call run_case(run%scene, layout_of(run%scene), watch, monitor, cache, result, whole)
    if (.not. whole) return
    call run%seconds%add(sum(watch%seconds))
    do i = 1, stage_count
      call run%stage(i)%add(watch%seconds(i))
    end do
  end subroutine run_once

  subroutine repeat_runs(runs, budget, monitor, whole)
    !! Run all of them in turn until each has been run often enough: `fewest` times, and then up to `most` times as long
    !! as it has taken less than its budget.
    type(timed_run), intent(inout) :: runs(:)
    real(dp), intent(in) :: budget                !! s, for each
    class(monitor_type), intent(inout), target :: monitor
    logical, intent(out) :: whole                 !! false where the monitor asked to stop
    type(case_result) :: result
    type(part_monitor) :: part
    integer :: round, i
    whole = .true.
    do round = 1, most
      do i = 1, size(runs)
        if (.not. needs_more(runs(i), budget)) cycle
        part = part_monitor(monitor, progress_of(runs, budget), 0.0_dp)
        call run_once(runs(i), part, result, whole)
        if (whole) whole = .not. monitor%stop_requested()
        if (.not. whole) return
      end do
    end do
  end subroutine repeat_runs

  pure logical function needs_more(run, budget)
    !! Whether a case is to be run again.
    type(timed_run), intent(in) :: run
    real(dp), intent(in) :: budget
    needs_more = run%is_timed .and. run%seconds%count < most .and. &
      (run%seconds%count < fewest .or. run%seconds%total() < budget)
  end function needs_more

  pure real(dp) function progress_of(runs, budget) result(part)
    !! How much of the work is done, 0 … 1, by the share of the runs that need no more.
    type(timed_run), intent(in) :: runs(:)
    real(dp), intent(in) :: budget
    integer :: i
    part = 0.0_dp
    do i = 1, size(runs)
      part = part + min(1.0_dp, max(runs(i)%seconds%total()/budget, real(runs(i)%seconds%count, dp)/most))/size(runs)
      if (.not. runs(i)%is_timed) part = part + 1.0_dp/size(runs)
    end do
    part = min(part, 1.0_dp)
  end function progress_of

end module bw_timed_runs
