module bw_study_frame
  !! What studies of a scene share: the place of their result, and how they begin and end.
  use bw_error, only: error_type, status_stopped
  use bw_existing_result, only: existing_result, look_at_existing
  use bw_kinds, only: i8
  use bw_outcome, only: outcome_type
  use bw_report, only: notes_report
  use bw_result_layout, only: layout_of
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count, case_scene
  use bw_scene_summary, only: scene_heading, scene_summary
  use bw_study_file, only: study_values, write_study
  use bw_text, only: shortest, string, text_of
  use bw_work_directory, only: work_directory
  implicit none (type, external)
  private

  character(*), parameter :: nl = new_line('a')

  type, public :: study_frame
    type(scene_type) :: scene                       !! the studied case: of a sweep the first
    character(:), allocatable :: study              !! the command
    type(work_directory) :: work
  contains
    procedure :: begin
    procedure :: end => end_study
    procedure :: leave
  end type study_frame

contains

  subroutine begin(self, scene, directory, overwrite, outcome, error)
    !! Check for an existing result, and reserve DIR/<scene>.<study>.nc before any work, so that a result that cannot be
    !! written fails at once. **Errors**: `status_bad_file` if a file cannot be read or written or belongs to another
    !! scene.
    class(study_frame), intent(inout) :: self       !! with `study`
    type(scene_type), intent(in) :: scene           !! as read
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    type(outcome_type), intent(inout) :: outcome    !! `was_there` if there is nothing to do
    type(error_type), allocatable, intent(out) :: error
    type(existing_result) :: existing
    call case_scene(scene, 1_i8, self%scene, error)
    if (allocated(error)) return
    outcome%file = directory//'/'//scene%name//'.'//self%study//'.nc'
    call self%work%plan(outcome%file, overwrite)
    call look_at_existing(outcome%file, self%scene, overwrite, existing, error, self%study)
    if (existing%is_there) call self%work%clear()
    if (existing%is_there) call outcome%set_found(self%scene, layout_of(self%scene), existing)
    if (.not. (allocated(error) .or. existing%is_there)) call self%work%begin(error)
  end subroutine begin

  subroutine end_study(self, scene, values, body, notes, outcome, error)
    !! Write the file, give it its final name, and report the findings; after a failure nothing remains.
    class(study_frame), intent(inout) :: self
    type(scene_type), intent(in) :: scene           !! as read
    class(study_values), intent(in) :: values
    character(*), intent(in) :: body                !! of the report
    type(string), intent(in), optional :: notes(:)
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(inout) :: error
    type(string), allocatable :: lines(:)
    character(:), allocatable :: report
    integer :: i
    allocate (lines(0))
    if (present(notes)) lines = notes
    report = which_case(scene)//body
    outcome%notes = ''
    do i = 1, size(lines)
      outcome%notes = outcome%notes//lines(i)%text//nl
    end do
    call write_study(self%work%draft_of(''), self%scene, self%study, values, outcome%notes_text(), report, error)
    call self%work%publish(error)
    call self%work%discard()
    if (allocated(error)) return
    outcome%report = scene_heading(self%scene)//scene_summary(self%scene, layout_of(self%scene))//report//nl// &
      notes_report(outcome%notes_text())//'  result     '//outcome%file//nl
  end subroutine end_study

  pure function which_case(scene) result(text)
    !! Say which case of a sweep is studied, on a line of its own.
    type(scene_type), intent(in) :: scene           !! as read
    character(:), allocatable :: text
    integer :: s
    text = ''
    if (size(scene%sweeps) == 0) return
    do s = 1, size(scene%sweeps)
      text = text//', '//scene%sweeps(s)%parameter//' = '//shortest(scene%sweeps(s)%values(1), 6)
    end do
    text = nl//'  Of '//text_of(case_count(scene))//' cases only the first is measured: '//text(3:)//'.'//nl
  end function which_case

  subroutine leave(self, outcome)
    !! End a study that was stopped; no file remains.
    class(study_frame), intent(inout) :: self
    type(outcome_type), intent(inout) :: outcome
    call self%work%discard()
    outcome%status = status_stopped
    outcome%report = ''
    outcome%notes = outcome%file//': stopped; seconds cannot be taken up again, so the same command starts anew'//nl
  end subroutine leave

end module bw_study_frame
