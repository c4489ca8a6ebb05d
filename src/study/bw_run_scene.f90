module bw_run_scene
  !! A scene from what is there already to its finished file.
  use bw_crew, only: crew_type
  use bw_error, only: error_type, fail, status_bad_file
  use bw_existing_result, only: look_at_existing
  use bw_kinds, only: i1
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type
  use bw_one_case, only: plan_case
  use bw_outcome, only: outcome_type
  use bw_progress, only: progress_type
  use bw_result_header, only: cases_not_trusted, source_text
  use bw_result_layout, only: result_layout, layout_of
  use bw_run_single, only: run_single
  use bw_run_sweep, only: run_sweep
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  use bw_scene_summary, only: bytes_text, claimed_bytes
  use bw_unfinished, only: unfinished_work
  implicit none (type, external)
  private
  public :: run_scene

contains

  subroutine run_scene(scene, directory, overwrite, crew, progress, outcome, error)
    !! Run all cases of a scene, write DIRECTORY/<scene>.nc, and say how it went. Called by all processes; the leader gets
    !! the outcome.
    !! **Errors**: `status_bad_file` where a file cannot be read or written or is another scene's.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: directory
    logical, intent(in) :: overwrite
    class(crew_type), intent(inout) :: crew
    class(progress_type), intent(inout) :: progress
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(result_layout) :: layout
    type(unfinished_work) :: unfinished
    integer :: go
    layout = layout_of(scene)
    outcome%file = directory//'/'//scene%name//'.nc'
    outcome%warnings = ''
    unfinished%directory = directory//'/'//scene%name//'.partial'
    unfinished%work = source_text()//new_line('a')//resolved_text(scene)
    if (layout%cases == 0 .and. .not. crew%leads()) return
    go = 0
    if (crew%leads()) call look_first(scene, layout, overwrite, progress, outcome, go, error)
    if (outcome%was_there) then
      outcome%not_trusted = cases_not_trusted(outcome%file)
      call unfinished%clear()
    end if
    if (layout%cases > 0) call crew%agree(go)
    if (go == 0) return
    if (layout%cases == 0) then
      call run_single(scene, layout, unfinished, progress, outcome, error)
    else
      call run_sweep(scene, layout, unfinished, crew, progress, outcome, error)
    end if
  end subroutine run_scene

  subroutine look_first(scene, layout, overwrite, monitor, outcome, go, error)
    !! Whether there is something to do, and room to do it.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    logical, intent(in) :: overwrite
    class(monitor_type), intent(inout) :: monitor
    type(outcome_type), intent(inout) :: outcome
    integer, intent(out) :: go                  !! 1: yes
    type(error_type), allocatable, intent(out) :: error
    go = 0
    call look_at_existing(outcome%file, scene, overwrite, outcome%was_there, error)
    if (allocated(error) .or. outcome%was_there) return
    call refuse_out_of_reach(scene, monitor, error)
    if (.not. allocated(error)) call ask_for_memory(scene, layout, error)
    if (.not. allocated(error)) go = 1
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
    allocate (room(claimed_bytes(layout)), stat=stat)
    if (stat /= 0) call fail(error, status_bad_file, scene%file//': memory was refused: a case takes about '// &
                             bytes_text(claimed_bytes(layout)))
  end subroutine ask_for_memory

end module bw_run_scene
