module scene_runs
  !! Scenes that tests write as texts, read and run as one case.
  use bw_case_result, only: case_result
  use bw_error, only: error_type
  use bw_monitor, only: monitor_type, silent_monitor
  use bw_one_case, only: case_cache, run_case
  use bw_result_layout, only: layout_of
  use bw_scene, only: scene_type
  use bw_scene_reader, only: read_scene_text
  use bw_stopwatch, only: stopwatch
  implicit none (type, external)
  private
  public :: run_scene, run_text

contains

  subroutine run_text(text, result, scene, error, monitor, whole)
    !! Read a scene and run it.
    character(*), intent(in) :: text
    type(case_result), intent(out) :: result                    !! empty where the scene is refused
    type(scene_type), intent(out), optional :: scene
    type(error_type), allocatable, intent(out), optional :: error   !! why; absent: it is printed
    class(monitor_type), intent(inout), optional :: monitor
    logical, intent(out), optional :: whole                     !! the monitor did not stop it
    type(scene_type) :: read
    type(error_type), allocatable :: refusal
    call read_scene_text(text, 'x.nml', read, refusal)
    if (present(scene)) scene = read
    if (present(whole)) whole = .false.
    if (.not. allocated(refusal)) then
      call run_scene(read, result, monitor, whole)
    else if (present(error)) then
      error = refusal
    else
      print '(a)', refusal%message
    end if
  end subroutine run_text

  subroutine run_scene(scene, result, monitor, whole)
    !! Run a scene as one case.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(out) :: result
    class(monitor_type), intent(inout), optional :: monitor
    logical, intent(out), optional :: whole
    type(case_cache), target :: cache
    type(stopwatch) :: watch
    type(silent_monitor) :: silent
    logical :: ended
    if (present(monitor)) then
      call run_case(scene, layout_of(scene), watch, monitor, cache, result, ended)
    else
      call run_case(scene, layout_of(scene), watch, silent, cache, result, ended)
    end if
    if (present(whole)) whole = ended
  end subroutine run_scene

end module scene_runs
