module bw_accuracy
  !! The cost of accuracy for a scene: tolerances and fixed mode counts, each with its true error and run time.
  use bw_kinds, only: dp, i8
  use bw_accuracy_ladder, only: ladder_of, leave_out, scene_of_rung, take_errors, take_seconds
  use bw_case_result, only: case_done, case_result
  use bw_converged, only: converge, converged_run, converged_tolerance
  use bw_error, only: error_type, fail, status_bad_input, status_not_trusted
  use bw_missing, only: is_missing
  use bw_absent_effects, only: model_errors
  use bw_monitor, only: monitor_type, part_monitor, progress_type
  use bw_note, only: kind_of
  use bw_outcome, only: outcome_type
  use bw_price_list, only: is_above_estimate, price_list, rung_out_of_reach, rung_type
  use bw_price_report, only: price_report
  use bw_scene, only: converges_in_run, scene_type
  use bw_study_frame, only: study_frame
  use bw_text, only: append, shortest, string, text_of
  use bw_timed_runs, only: repeat_runs, run_first, timed_run
  implicit none (type, external)
  private
  public :: measure_accuracy

  real(dp), parameter :: budget = 0.5_dp       !! s of repeated runs for each rung
  real(dp), parameter :: converging = 0.2_dp   !! share of the converged run in the progress shown

  type :: accuracy_study
    type(converged_run) :: converged
    type(timed_run), allocatable :: runs(:)    !! of the rungs
    type(price_list) :: list
    type(string), allocatable :: notes(:)
  end type accuracy_study

contains

  subroutine measure_accuracy(scene, directory, overwrite, progress, outcome, error)
    !! Measure, write DIRECTORY/<scene>.accuracy.nc, and report what was found.
    !! **Errors**: `status_bad_input` if nothing can be measured on the scene, `status_bad_file` if a file cannot be
    !! read or written or belongs to another scene.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(accuracy_study) :: state
    type(study_frame) :: frame
    logical :: whole
    call refuse(scene, error)
    frame%study = 'accuracy'
    if (.not. allocated(error)) call frame%begin(scene, directory, overwrite, outcome, error)
    if (allocated(error) .or. outcome%was_there) return
    call progress%begin(scene%name, 1_i8, 0_i8)
    call measure(frame%scene, progress, state, whole, error)
    call progress%end()
    if (allocated(error) .or. .not. whole) then
      call frame%leave(outcome)
    else
      if (state%converged%result%status /= case_done) outcome%status = status_not_trusted
      call frame%end(scene, state%list, price_report(state%list), state%notes, outcome, error)
    end if
  end subroutine measure_accuracy

  subroutine refuse(scene, error)
    !! Refuse a scene without a history that converges as modes are added: accuracy is measured against that limit.
    !! **Errors**: `status_bad_input`.
    type(scene_type), intent(in) :: scene
    type(error_type), allocatable, intent(out) :: error
    character(*), parameter :: accepted = '; accepted: a scene with &response whose mass, if any, stays, or strikes by &contact'
    if (.not. allocated(scene%response)) then
      call fail(error, status_bad_input, scene%file//': &response: is absent, so that there is no history whose error '// &
                'could be measured'//accepted)
    else if (.not. (converges_in_run(scene) .or. allocated(scene%capture))) then
      call fail(error, status_bad_input, scene%file//': &capture: is absent: after an instantaneous rebound the motion depends '// &
                'on the number of modes (its impulse tends to 0 as modes are added), so that it does not converge'// &
                accepted//'; instead: &sweep parameter=''modes%before'', which shows what changes with their number')
    end if
  end subroutine refuse

  subroutine measure(scene, progress, state, whole, error)
    !! Make the converged run, find the error of each rung, then time all rungs in turn.
    type(scene_type), intent(in) :: scene
    class(progress_type), intent(inout), target :: progress
    type(accuracy_study), intent(inout) :: state
    logical, intent(out) :: whole                !! false if the monitor asked to stop
    type(error_type), allocatable, intent(out) :: error
    type(part_monitor) :: part
    integer :: i
    allocate (state%notes(0))
    part = part_monitor(progress, 0.0_dp, converging)
    call converge(scene, part, state%converged, whole, error)
    if (allocated(error) .or. .not. whole) return
    state%list%rungs = ladder_of()
    allocate (state%runs(size(state%list%rungs)))
    do i = 1, size(state%runs)
      state%runs(i)%scene = scene_of_rung(scene, state%list%rungs(i))
    end do
    call leave_out(state%converged, state%runs, state%list%rungs)
    part = part_monitor(progress, converging, 1.0_dp - converging)
    call run_rungs(part, state, whole)
    if (.not. whole) return
    call repeat_runs(state%runs, budget, part, whole)
    if (whole) call take_account(scene, state)
  end subroutine measure

  subroutine run_rungs(monitor, state, whole)
    !! Run each rung once for its error. Its time comes from repeats, whose scatter is reported.
    class(monitor_type), intent(inout), target :: monitor
    type(accuracy_study), intent(inout) :: state
    logical, intent(out) :: whole
    type(case_result) :: result
    integer :: i
    whole = .true.
    do i = 1, size(state%runs)
      associate (rung => state%list%rungs(i))
        if (.not. state%runs(i)%is_timed) cycle
        call run_first(state%runs, i, budget, huge(budget), monitor, result, whole)
        if (.not. whole) return
        call take_errors(result, state%converged, rung)
        state%runs(i)%is_timed = rung%status /= rung_out_of_reach
      end associate
    end do
  end subroutine run_rungs

  subroutine take_account(scene, state)
    !! Collect all measured values in the list.
    type(scene_type), intent(in) :: scene
    type(accuracy_study), intent(inout) :: state
    integer :: i
    do i = 1, size(state%runs)
      call take_seconds(state%runs(i), state%list%rungs(i))
    end do
    associate (list => state%list, converged => state%converged)
      list%peak = converged%peak
      list%bounds_all = converged%bounds_all
      list%converged_count = converged%result%mode_count
      list%converged_error = converged%error
      list%converged_tolerance = converged%tolerance
      if (converged%reach > converged_tolerance) list%reachable = converged%reach
      associate (result => converged%result)
        if (.not. converged%bounds_all) list%model_errors = model_errors( &
          scene, result%modes, result%modal_velocity*result%approach_velocity, &
          result%response%displacement(:result%response%finite_samples, :))
      end associate
      do i = 1, size(converged%result%notes)
        if (index(kind_of(converged%result%notes(i)%text), 'error of') == 1) cycle       ! these are what the study measures
        call append(state%notes, converged%result%notes(i)%text)
      end do
      call note_estimates(list, state%notes)
    end associate
  end subroutine take_account

  pure subroutine note_estimates(list, notes)
    !! Note the rungs whose true error is above its estimate.
    type(price_list), intent(in) :: list
    type(string), allocatable, intent(inout) :: notes(:)
    character(:), allocatable :: names
    integer :: i
    names = ''
    do i = 1, size(list%rungs)
      if (is_above_estimate(list%rungs(i), list%converged_error)) names = names//', '//name_of(list%rungs(i))
    end do
    if (names /= '') call append(notes, 'estimate: the true error is above the estimate with '//names(3:)// &
                                 ' (the error of the converged run is '//shortest(list%converged_error, 2)//')')
  end subroutine note_estimates

  pure function name_of(rung) result(name)
    !! Describe a rung: `tolerance 1e-5` or `before = after = 50`.
    type(rung_type), intent(in) :: rung
    character(:), allocatable :: name
    if (is_missing(rung%tolerance)) then
      name = 'before = after = '//text_of(rung%mode_count)
    else
      name = 'tolerance '//shortest(rung%tolerance, 2)
    end if
  end function name_of

end module bw_accuracy
