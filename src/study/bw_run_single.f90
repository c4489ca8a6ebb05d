module bw_run_single
  !! A scene without sweeps: one case, straight into its file.
  use bw_case_result, only: case_done, case_result
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kept_work, only: kept_work
  use bw_kinds, only: i8
  use bw_notes, only: notes_type
  use bw_one_case, only: run_case
  use bw_outcome, only: outcome_type, work_taken_away
  use bw_posix, only: rename_file
  use bw_progress, only: progress_type
  use bw_report, only: case_report
  use bw_result_file, only: create_result, result_file
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_stage_table, only: stage_table
  use bw_stopwatch, only: stage_write, stopwatch
  use bw_unfinished, only: unfinished_work
  implicit none (type, external)
  private
  public :: run_single

contains

  subroutine run_single(scene, layout, unfinished, progress, outcome, error)
    !! After an error, or when it is stopped, nothing is left of a single case.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(inout) :: unfinished
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(case_result) :: result
    type(kept_work) :: kept
    type(stopwatch) :: watch
    logical :: whole
    call unfinished%begin(error)
    if (allocated(error)) return
    if (size(unfinished%journals()) > 0) call outcome%remark(work_taken_away)
    call unfinished%remove_result()
    call progress%begin(scene%name, 1_i8, 0_i8)
    call run_case(scene, layout, watch, progress, kept, result, whole)
    call progress%end()
    if (.not. whole) then
      call outcome%set_stopped(0_i8, 1_i8)
    else
      call write_result(scene, layout, result, unfinished, watch, outcome, error)
    end if
    call unfinished%discard()
  end subroutine run_single

  subroutine write_result(scene, layout, result, unfinished, watch, outcome, error)
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(case_result), intent(in) :: result
    type(unfinished_work), intent(in) :: unfinished
    type(stopwatch), intent(inout) :: watch
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(result_file) :: file
    type(notes_type) :: notes
    call create_result(unfinished%result_path(), scene, layout, file, error)
    if (allocated(error)) return
    call file%put_case(result, error)
    if (allocated(error)) then
      call file%close()
      return
    end if
    call notes%add(1_i8, result%notes)
    call outcome%set_notes(notes, layout, merge(0_i8, 1_i8, result%status == case_done))
    call watch%lap(stage_write)
    call file%finish(outcome%notes_text(), watch%seconds, error)
    if (allocated(error)) return
    if (.not. rename_file(unfinished%result_path(), outcome%file)) then
      call fail(error, status_bad_file, outcome%file//': the finished result cannot be moved there')
    end if
    if (.not. allocated(error)) call outcome%set_report(scene, layout, case_report(result), 0_i8, &
      stage_table(watch, sum(watch%seconds), 1, 1_i8))
  end subroutine write_result

end module bw_run_single
