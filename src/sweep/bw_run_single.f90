module bw_run_single
  !! A scene without sweeps: one case, straight into its file.
  use bw_case_result, only: case_done, case_result
  use bw_child_process, only: child_process
  use bw_error, only: error_type
  use bw_kinds, only: i1, i8
  use bw_notes, only: notes_type
  use bw_one_case, only: case_cache, run_case
  use bw_outcome, only: outcome_type, work_taken_away
  use bw_progress, only: progress_type
  use bw_report, only: case_report
  use bw_result_file, only: create_result, result_file
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_stage_table, only: stage_table
  use bw_stopwatch, only: stage_write, stopwatch
  use bw_text, only: string
  use bw_unfinished_work, only: unfinished_work
  implicit none (type, external)
  private
  public :: run_single

contains

  subroutine run_single(scene, layout, unfinished, progress, outcome, error)
    !! After an error, or when it is stopped, nothing is left of a single case.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(inout) :: unfinished    !! held
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(case_result) :: result
    type(case_cache) :: cache
    type(stopwatch) :: watch
    integer(i1) :: none(0)
    logical :: whole
    call unfinished%survey(0_i8, none, error)
    if (.not. allocated(error) .and. unfinished%has_others()) call outcome%remark(work_taken_away)
    call unfinished%remove_others(error)
    whole = .true.
    if (.not. allocated(error)) then
      call progress%begin(scene%name, 1_i8, 0_i8)
      call run_case(scene, layout, watch, progress, cache, result, whole)
      if (whole) call write_result(scene, layout, result, unfinished, progress, watch, outcome, whole, error)
      call progress%end()
    end if
    if (.not. whole) call outcome%set_stopped(0_i8, 1_i8)
    call unfinished%discard()
  end subroutine run_single

  subroutine write_result(scene, layout, result, unfinished, progress, watch, outcome, whole, error)
    !! The file under its final name, and what there is to say of it.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(case_result), intent(in) :: result
    type(unfinished_work), intent(in) :: unfinished
    class(progress_type), intent(inout) :: progress
    type(stopwatch), intent(inout) :: watch
    type(outcome_type), intent(inout) :: outcome
    logical, intent(out) :: whole                         !! false where the monitor asked to stop
    type(error_type), allocatable, intent(inout) :: error
    type(child_process) :: child
    type(result_file) :: file
    type(notes_type) :: notes
    type(string), allocatable :: texts(:)
    character(:), allocatable :: draft
    call notes%add(1_i8, result%notes)
    call outcome%set_notes(notes%lines(layout%cases), layout, merge(0_i8, 1_i8, result%status == case_done))
    draft = unfinished%new_draft()
    call child%begin()
    if (child%is_here()) then
      allocate (texts(0))
      call create_result(draft, scene, layout, file, error)
      if (.not. allocated(error)) call file%put_case(result, error)
      call watch%lap(stage_write)
      call file%finish(outcome%notes_text(), watch%seconds, error)
      call child%tell(texts, error)
    end if
    call child%hear(texts, whole, error, progress)
    if (.not. whole .or. allocated(error)) return
    call unfinished%publish(draft, error)
    call watch%lap(stage_write)
    call watch%add_cpu(stage_write, child%seconds)
    if (.not. allocated(error)) call outcome%set_report(scene, layout, case_report(result), 0_i8, &
      stage_table(watch, sum(watch%seconds), 1, 1_i8))
  end subroutine write_result

end module bw_run_single
