module bw_timed_runs
  !! Comparison of run times: cases run in turn, round after round, so that other load on the machine affects all alike.
  use bw_case_result, only: case_result
  use bw_kinds, only: dp
  use bw_monitor, only: monitor_type, part_monitor
  use bw_one_case, only: case_cache, run_case
  use bw_result_layout, only: layout_of
  use bw_scene, only: scene_type
  use bw_stopwatch, only: repeats_type, stage_count, stopwatch
  implicit none (type, external)
  private
  public :: repeat_runs, run_first, run_once, progress_of

  integer, parameter :: fewest = 3, most = 15     !! runs of each case

  type, public :: timed_run
    type(scene_type) :: scene                     !! without sweeps
    logical :: is_timed = .true.                  !! false: `repeat_runs` leaves it out
    real(dp) :: first = 0.0_dp                    !! s of the first run, which starts with cold caches; 0: not run yet
    type(repeats_type) :: seconds                 !! of the whole case, from modes to last stage
    type(repeats_type) :: stage(stage_count)      !! of its stages
  end type timed_run

contains

  subroutine run_first(runs, place, budget, enough, monitor, result, whole)
    !! Run a case for its result. This run starts with cold caches: its time counts only if it is so long that they do
    !! not matter, and it is then not repeated.
    type(timed_run), intent(inout) :: runs(:)
    integer, intent(in) :: place
    real(dp), intent(in) :: budget                !! s, for the repeats of a case
    real(dp), intent(in) :: enough                !! s: a run as long as this is not repeated
    class(monitor_type), intent(inout), target :: monitor   !! of all runs
    type(case_result), intent(out) :: result
    logical, intent(out) :: whole                 !! false if the monitor asked to stop
    type(timed_run) :: first
    type(part_monitor) :: part
    part = part_monitor(monitor, progress_of(runs, budget), 0.0_dp)
    first = timed_run(runs(place)%scene)
    call run_once(first, part, result, whole)
    if (whole) whole = .not. monitor%stop_requested()
    if (.not. whole) return
    runs(place)%first = first%seconds%total()
    if (runs(place)%first < enough) return
    runs(place)%seconds = first%seconds
    runs(place)%stage = first%stage
    runs(place)%is_timed = .false.
  end subroutine run_first

  subroutine run_once(run, monitor, result, whole)
    !! Run a case once more, and record its time.
    type(timed_run), intent(inout) :: run
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(out) :: result
    logical, intent(out) :: whole                 !! false if the monitor asked to stop; then nothing is recorded
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
    !! Run all cases in turn until each has run `fewest` times, and then up to `most` times while it is within its
    !! budget.
    type(timed_run), intent(inout) :: runs(:)
    real(dp), intent(in) :: budget                !! s, for each
    class(monitor_type), intent(inout), target :: monitor
    logical, intent(out) :: whole                 !! false if the monitor asked to stop
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
    !! Return whether a case is to be run again.
    type(timed_run), intent(in) :: run
    real(dp), intent(in) :: budget
    needs_more = run%is_timed .and. run%seconds%count < most .and. &
      (run%seconds%count < fewest .or. run%seconds%total() < budget)
  end function needs_more

  pure real(dp) function progress_of(runs, budget) result(part)
    !! Return the fraction of work done, 0 … 1: the seconds taken by first runs and repeats, over those that all will
    !! take. A case not run yet counts as the mean of the others.
    type(timed_run), intent(in) :: runs(:)
    real(dp), intent(in) :: budget                !! s, for the repeats of each
    real(dp) :: done, all
    integer :: i, known, to_come
    done = 0.0_dp
    all = 0.0_dp
    known = 0
    to_come = 0
    do i = 1, size(runs)
      if (runs(i)%first <= 0.0_dp) then
        if (runs(i)%is_timed) to_come = to_come + 1
        cycle
      end if
      known = known + 1
      done = done + runs(i)%first
      all = all + runs(i)%first
      if (.not. runs(i)%is_timed) cycle
      done = done + runs(i)%seconds%total()
      all = all + repeats_of(runs(i), budget)
    end do
    part = 0.0_dp
    if (known > 0) part = done/(all*(1.0_dp + real(to_come, dp)/known))
  end function progress_of

  pure real(dp) function repeats_of(run, budget) result(seconds)
    !! Return the time of all repeats of a case, s, if each takes as long as the previous ones.
    type(timed_run), intent(in) :: run            !! its first run is done
    real(dp), intent(in) :: budget
    real(dp) :: once
    once = run%first
    if (run%seconds%count > 0) once = run%seconds%total()/run%seconds%count
    seconds = max(once*min(real(most, dp), max(real(fewest, dp), budget/once)), run%seconds%total())
  end function repeats_of

end module bw_timed_runs
