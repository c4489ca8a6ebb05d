module bw_check_command
  !! The command that says what scenes would simulate, by which method, and what that would take.
  use bw_command_table, only: command_type
  use bw_console, only: print_error, print_report, print_warning
  use bw_error, only: error_type, fail, status_not_trusted, status_stopped
  use bw_kinds, only: dp
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type
  use bw_one_case, only: plan_case
  use bw_result_layout, only: result_layout, layout_of
  use bw_scene, only: scene_type
  use bw_scene_files, only: read_and_list
  use bw_scene_summary, only: cost_summary, scene_heading, scene_summary
  use bw_terminal_progress, only: duration_text, terminal_progress, terminal_progress_to
  use bw_text, only: shortest, text_of
  use bw_time_estimate, only: estimated_seconds
  implicit none (type, external)
  private
  public :: check_command

  real(dp), parameter :: check_seconds = 2.0_dp        !! what `check` may take to try cases of all its scenes
  real(dp), parameter :: most_check_seconds = 1.0_dp   !! and of one of them

contains

  integer function check_command(command) result(status)
    !! Say what each good scene would simulate; list what is wrong with the others.
    type(command_type), intent(in) :: command
    type(scene_type), allocatable :: scenes(:)
    type(terminal_progress) :: progress            ! shows nothing: it asks to stop after a signal
    type(result_layout) :: layout
    type(error_type), allocatable :: error
    character(:), allocatable :: text
    integer :: i, count
    progress = terminal_progress_to(huge(1.0_dp), quiet=.true.)
    call read_and_list(command%words, .true., scenes, count, status)
    do i = 1, count
      layout = layout_of(scenes(i))
      call plan_tolerance(scenes(i), progress, text, error)
      if (.not. allocated(error) .and. .not. command%quiet) text = scene_heading(scenes(i))// &
        scene_summary(scenes(i), layout)//text//cost_summary(scenes(i), layout)// &
        time_summary(scenes(i), layout, check_seconds/count, progress)
      if (progress%stop_requested()) then
        call print_warning('beamwave: stopped before '//scenes(i)%file//' was checked')
        status = max(status, status_stopped)
        return
      else if (allocated(error)) then
        call print_error(error)
        status = max(status, error%status)
      else if (.not. command%quiet) then
        call print_report(text)
      end if
    end do
  end function check_command

  function time_summary(scene, layout, budget, monitor) result(text)
    !! The line of `check` that says how long the scene would take.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    real(dp), intent(in) :: budget                 !! of the estimate itself, s
    class(monitor_type), intent(inout) :: monitor
    character(:), allocatable :: text
    text = '  time       about '// &
      expected_text(estimated_seconds(scene, layout, min(budget, most_check_seconds), monitor))//' on one core'
    if (layout%cases > 1) text = text//', shared by the processes of beamwave-mpi'
    text = text//new_line('a')
  end function time_summary

  pure function expected_text(seconds) result(text)
    !! Seconds as `duration_text` writes them, with a digit more where whole seconds would be too coarse.
    real(dp), intent(in) :: seconds
    character(:), allocatable :: text
    if (seconds >= 1.0_dp .and. seconds < 10.0_dp) then
      text = shortest(seconds, 2)//' s'
    else
      text = duration_text(seconds)
    end if
  end function expected_text

  subroutine plan_tolerance(scene, monitor, text, error)
    !! Say how many modes a tolerance takes; of a sweep, whose cases take different ones, nothing is said.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout) :: monitor  !! nothing is planned where it asks to stop
    character(:), allocatable, intent(out) :: text
    type(error_type), allocatable, intent(out) :: error
    integer :: count
    text = ''
    if (.not. by_tolerance(scene%modes) .or. size(scene%sweeps) > 0) return
    call plan_case(scene, monitor, count, error)
    if (monitor%stop_requested()) return
    if (.not. allocated(error) .and. count == 0) call fail(error, status_not_trusted, scene%file//': not converged: '// &
      'the polynomials of the Galerkin basis do not resolve the modes; every number of the case would be fill')
    text = '  modes      about '//text_of(count)//' to be summed'//new_line('a')
  end subroutine plan_tolerance

end module bw_check_command
