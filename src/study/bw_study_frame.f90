module bw_study_frame
  !! What studies of a scene have in common: where their result lies, and how they begin and end.
  use bw_kinds, only: i8
  use bw_error, only: error_type, fail, status_bad_file, status_stopped
  use bw_existing_result, only: look_at_existing
  use bw_outcome, only: outcome_type
  use bw_posix, only: make_directory
  use bw_report, only: notes_report
  use bw_result_layout, only: layout_of
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count, case_scene
  use bw_scene_summary, only: scene_heading, scene_summary
  use bw_study_file, only: create_study, study_file
  use bw_text, only: append, string, text_of
  implicit none (type, external)
  private
  public :: begin_study, end_study, leave_study

  character(*), parameter :: nl = new_line('a')

contains

  subroutine begin_study(study, scene, directory, overwrite, one, file, outcome, error)
    !! Take the first case of a sweep, look at what is there, and make DIRECTORY/<scene>.<study>.nc before any work is
    !! done: a place that refuses the result refuses it now.
    !! **Errors**: `status_bad_file` where a file cannot be read or written or is another scene's.
    character(*), intent(in) :: study               !! the command
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    type(scene_type), intent(out) :: one            !! the case that is studied
    type(study_file), intent(out) :: file
    type(outcome_type), intent(inout) :: outcome    !! `was_there` where there is nothing to do
    type(error_type), allocatable, intent(out) :: error
    call case_scene(scene, 1_i8, one, error)
    if (allocated(error)) return
    outcome%file = directory//'/'//scene%name//'.'//study//'.nc'
    call look_at_existing(outcome%file, one, overwrite, outcome%was_there, error, study)
    if (allocated(error) .or. outcome%was_there) return
    if (make_directory(directory)) then
      call create_study(outcome%file, one, study, file, error)
    else
      call fail(error, status_bad_file, directory//': the directory cannot be made')
    end if
  end subroutine begin_study

  subroutine end_study(scene, one, body, notes, file, outcome, error)
    !! Give the file its final name, and say what was found.
    type(scene_type), intent(in) :: scene, one      !! as it was read; the case that was studied
    character(*), intent(in) :: body                !! of the report
    type(string), intent(in), optional :: notes(:)
    type(study_file), intent(inout) :: file
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(inout) :: error
    type(string), allocatable :: lines(:)
    integer :: i
    if (present(notes)) lines = notes
    if (size(scene%sweeps) > 0) call append(lines, 'sweep: the first of '//text_of(case_count(scene))//' cases is measured')
    outcome%warnings = ''
    if (allocated(lines)) then
      do i = 1, size(lines)
        outcome%warnings = outcome%warnings//lines(i)%text//nl
      end do
    end if
    call file%finish(outcome%notes_text(), error)
    if (allocated(error)) return
    outcome%report = scene_heading(one)//scene_summary(one, layout_of(one))//body//nl// &
      notes_report(outcome%notes_text())//'  result     '//outcome%file//nl
  end subroutine end_study

  subroutine leave_study(file, outcome)
    !! Stopped in order: nothing is left.
    type(study_file), intent(inout) :: file
    type(outcome_type), intent(inout) :: outcome
    call file%discard()
    outcome%status = status_stopped
    outcome%report = ''
    outcome%warnings = outcome%file//': stopped; seconds cannot be taken up again, so the same command starts anew'//nl
  end subroutine leave_study

end module bw_study_frame
