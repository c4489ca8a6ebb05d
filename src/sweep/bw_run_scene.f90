module bw_run_scene
  !! A scene from what is there already to its finished file.
  use bw_case_fields, only: case_field, fields_of
  use bw_error, only: error_type, fail, status_bad_file
  use bw_existing_result, only: look_at_existing
  use bw_kinds, only: i1, i4
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type
  use bw_one_case, only: plan_case
  use bw_outcome, only: outcome_type
  use bw_process_group, only: process_group
  use bw_progress, only: progress_type
  use bw_result_header, only: source_text
  use bw_result_layout, only: result_layout, layout_of
  use bw_run_single, only: run_single
  use bw_run_sweep, only: run_sweep
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  use bw_scene_summary, only: bytes_text, working_bytes
  use bw_text, only: text_of
  use bw_unfinished_work, only: unfinished_work
  implicit none (type, external)
  private
  public :: run_scene

contains

  subroutine run_scene(scene, directory, overwrite, group, progress, outcome, error)
    !! Run all cases of a scene, write DIRECTORY/<scene>.nc, and say how it went. Called by all processes; the leader gets
    !! the outcome.
    !! **Errors**: `status_bad_file` where a file cannot be read or written or is another scene's.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    class(process_group), intent(inout) :: group
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(result_layout) :: layout
    type(unfinished_work) :: unfinished
    integer(i4), allocatable :: go(:)           ! its size: 1 where there is work to do
    layout = layout_of(scene)
    if (layout%cases == 0 .and. .not. group%leads()) return
    outcome%file = directory//'/'//scene%name//'.nc'
    outcome%warnings = ''
    call unfinished%plan(outcome%file, overwrite)
    unfinished%identity = source_text()//new_line('a')//resolved_text(scene)//new_line('a')//fields_text(fields_of(layout))
    allocate (go(0))
    if (group%leads()) call look_first(scene, layout, unfinished, progress, outcome, go, error)
    if (layout%cases > 0) call group%share(go)
    if (size(go) == 0) return
    if (layout%cases == 0) then
      call run_single(scene, layout, unfinished, progress, outcome, error)
    else
      call run_sweep(scene, layout, unfinished, group, progress, outcome, error)
    end if
  end subroutine run_scene

  pure function fields_text(fields) result(text)
    !! The numbers of a case in their order, as a journal has them: names and lengths.
    type(case_field), intent(in) :: fields(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(fields)
      text = text//trim(fields(i)%name)//' '//text_of(fields(i)%length)//new_line('a')
    end do
  end function fields_text

  subroutine look_first(scene, layout, unfinished, monitor, outcome, go, error)
    !! Whether there is something to do, and room to do it; then the work is held.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(inout) :: unfinished
    class(monitor_type), intent(inout) :: monitor
    type(outcome_type), intent(inout) :: outcome
    integer(i4), allocatable, intent(inout) :: go(:)
    type(error_type), allocatable, intent(out) :: error
    associate (file => outcome%file, was_there => outcome%was_there, overwrite => unfinished%overwrite)
      call look_at_existing(file, scene, overwrite, was_there, outcome%not_trusted, error)
      if (was_there) call unfinished%clear()
      if (was_there .or. allocated(error)) return
      call refuse_out_of_reach(scene, monitor, error)
      if (.not. allocated(error)) call ask_for_memory(scene, layout, error)
      if (.not. allocated(error)) call unfinished%begin(error)
      if (allocated(error)) return
      call look_at_existing(file, scene, overwrite, was_there, outcome%not_trusted, error)     ! of a run that has ended just now
      if (was_there .or. allocated(error)) call unfinished%leave()
      if (.not. (was_there .or. allocated(error))) go = [1_i4]
    end associate
  end subroutine look_first

  subroutine refuse_out_of_reach(scene, monitor, error)
    !! A single case whose tolerance is out of reach is refused before anything is written; in a sweep such a case is
    !! recorded and the others go on.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout) :: monitor
    type(error_type), allocatable, intent(out) :: error
    integer :: ignored
    if (by_tolerance(scene%modes) .and. size(scene%sweeps) == 0) call plan_case(scene, monitor, ignored, error)
  end subroutine refuse_out_of_reach

  subroutine ask_for_memory(scene, layout, error)
    !! Memory that is refused is refused before any work is done.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(error_type), allocatable, intent(out) :: error
    integer(i1), allocatable :: room(:)
    integer :: stat
    allocate (room(working_bytes(layout)), stat=stat)
    if (stat /= 0) call fail(error, status_bad_file, scene%file//': memory was refused: a case takes about '// &
                             bytes_text(working_bytes(layout)))
  end subroutine ask_for_memory

end module bw_run_scene
