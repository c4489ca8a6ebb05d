module bw_commands
  !! The commands of the program. Each returns an exit status.
  use bw_command_line, only: command_type
  use bw_console, only: print_error, print_report, print_warning
  use bw_descriptors, only: is_terminal, standard_error, standard_output
  use bw_error, only: error_type, fail, status_bad_file, status_done, status_not_trusted, status_stopped
  use bw_kinds, only: dp, i4
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type
  use bw_one_case, only: plan_case
  use bw_process, only: pause, settle_libraries
  use bw_process_group, only: process_group
  use bw_result_layout, only: result_layout, layout_of
  use bw_outcome, only: outcome_type
  use bw_run_scene, only: run_scene
  use bw_scene, only: scene_type
  use bw_scene_describe, only: describe_text
  use bw_scene_files, only: read_scenes
  use bw_scene_summary, only: cost_summary, scene_heading, scene_summary
  use bw_stopwatch, only: wall_seconds
  use bw_terminal_progress, only: duration_text, terminal_progress, terminal_progress_to
  use bw_text, only: append, lines_of, shortest, string, text_of
  use bw_time_estimate, only: estimated_seconds
  implicit none (type, external)
  private
  public :: run_command, check_command, describe_command, print_outcome, read_and_list

  real(dp), parameter :: check_seconds = 2.0_dp        !! what `check` may take to try cases of all its scenes
  real(dp), parameter :: most_check_seconds = 1.0_dp   !! and of one of them
  integer, parameter :: between_streams = 20000        !! µs; mpirun hands on both streams in pieces of 4 KB, and a warning
                                                       !! must not fall between two pieces of a report

contains

  integer function run_command(command, group) result(status)
    !! Run every good scene; the status is the highest of any. Called by all processes; only the leader speaks.
    type(command_type), intent(in) :: command
    class(process_group), intent(inout) :: group
    type(scene_type), allocatable :: scenes(:)
    type(terminal_progress) :: progress
    real(dp) :: deadline
    type(error_type), allocatable :: error
    integer(i4), allocatable :: stop(:)            ! of one number: 1 where the leader has to stop
    integer :: i, count
    deadline = huge(1.0_dp)
    if (command%max_seconds < huge(1.0_dp)) deadline = wall_seconds() + command%max_seconds
    progress = terminal_progress_to(deadline, command%quiet .or. .not. group%leads())
    call read_and_list(command, group%leads(), scenes, count, status)
    call agree_on_scenes(group, count, error)
    if (allocated(error)) then
      if (group%leads()) call print_error(error)
      status = error%status
      return
    end if
    do i = 1, count
      stop = [merge(1_i4, 0_i4, progress%stop_requested())]
      call group%share(stop)
      if (stop(1) == 1) then
        if (group%leads()) call print_warning('beamwave: stopped before '//scenes(i)%file// &
                                             '; the same command goes on from there')
        status = max(status, status_stopped)
        return
      end if
      status = max(status, run_one(command, scenes(i), group, progress))
    end do
  end function run_command

  subroutine agree_on_scenes(group, count, error)
    !! **Errors**: one of the processes could not read what the leader has read. All get it.
    class(process_group), intent(inout) :: group
    integer, intent(in) :: count                   !! of good scenes
    type(error_type), allocatable, intent(out) :: error
    integer(i4), allocatable :: counts(:)
    real(dp) :: nothing(0)
    counts = [count]
    call group%share(counts)
    if (count /= counts(1)) call fail(error, status_bad_file, 'beamwave: process '//text_of(group%number)//' of '// &
      text_of(group%processes)//' reads '//text_of(count)//' good scenes, the first one '//text_of(counts(1))// &
      ': a file could not be read, or memory was refused')
    call group%collect(nothing, error)
  end subroutine agree_on_scenes

  integer function run_one(command, scene, group, progress) result(status)
    type(command_type), intent(in) :: command
    type(scene_type), intent(in) :: scene
    class(process_group), intent(inout) :: group
    type(terminal_progress), intent(inout) :: progress
    type(outcome_type) :: outcome
    type(error_type), allocatable :: error
    call run_scene(scene, command%output, command%overwrite, group, progress, outcome, error)
    status = outcome%status
    if (group%leads()) status = print_outcome(command, group%processes, scene, outcome, error)
  end function run_one

  integer function print_outcome(command, processes, scene, outcome, error) result(status)
    !! Say how a scene ended.
    type(command_type), intent(in) :: command
    integer, intent(in) :: processes
    type(scene_type), intent(in) :: scene
    type(outcome_type), intent(in) :: outcome
    type(error_type), intent(in), optional :: error
    logical :: seen                                !! the report has shown the warnings to the same eyes
    status = outcome%status
    if (present(error)) then
      if (allocated(outcome%remarks)) call print_warnings(scene, outcome%remarks)
      call print_error(error)
      status = error%status
      return
    end if
    if (outcome%was_there) then
      if (.not. command%quiet) call print_report(outcome%file//': nothing to do, the result of this scene is there'// &
                                                 trust_text(outcome))
      return
    end if
    if (.not. command%quiet) call print_report(outcome%report)
    seen = .false.
    if (.not. command%quiet .and. status /= status_stopped) seen = seen_together()
    if (seen) return
    if (processes > 1 .and. .not. command%quiet) call pause(between_streams)
    if (allocated(outcome%remarks)) call print_warnings(scene, outcome%remarks)
    call print_warnings(scene, outcome%warnings)
  end function print_outcome

  pure function trust_text(outcome) result(text)
    !! Of a result that was there already, what it cannot be trusted for.
    type(outcome_type), intent(in) :: outcome
    character(:), allocatable :: text
    text = ''
    if (outcome%not_trusted > 0) text = '; '//text_of(outcome%not_trusted)//' of its cases '// &
      'cannot be trusted, as its notes say'
  end function trust_text

  logical function seen_together()
    !! Report and warnings come to the same eyes, and the report ends with the same notes.
    seen_together = is_terminal(standard_output)
    if (seen_together) seen_together = is_terminal(standard_error)
  end function seen_together

  subroutine print_warnings(scene, lines)
    !! Each line with the scene it is about.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: lines
    type(string), allocatable :: warnings(:)
    integer :: i
    warnings = lines_of(lines)
    do i = 1, size(warnings)
      call print_warning(scene%file//': warning: '//warnings(i)%text)
    end do
  end subroutine print_warnings

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
    call read_and_list(command, .true., scenes, count, status)
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
    !! What `check` says of the time.
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
    !! As `duration_text`, with a digit more where whole seconds would be too coarse.
    real(dp), intent(in) :: seconds
    character(:), allocatable :: text
    if (seconds >= 1.0_dp .and. seconds < 10.0_dp) then
      text = shortest(seconds, 2)//' s'
    else
      text = duration_text(seconds)
    end if
  end function expected_text

  subroutine plan_tolerance(scene, monitor, text, error)
    !! How many modes a tolerance takes, where there is one case to ask for.
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

  subroutine read_and_list(command, aloud, scenes, count, status)
    !! Read all scenes and print what is wrong with the bad ones; none is good where the system lets nothing be run.
    type(command_type), intent(in) :: command
    logical, intent(in) :: aloud                   !! print it
    type(scene_type), allocatable, intent(out) :: scenes(:)
    integer, intent(out) :: count                  !! how many of `scenes` are good
    integer, intent(out) :: status                 !! the highest of the errors'
    type(string), allocatable :: messages(:)
    type(error_type), allocatable :: error
    integer :: i
    call read_scenes(command%words, scenes, count, messages, status)
    if (count > 0) call settle_libraries(scenes(1)%file, error)
    if (allocated(error)) then
      call append(messages, error%message)
      status = max(status, error%status)
      count = 0
    end if
    do i = 1, size(messages)
      if (aloud) call print_warning(messages(i)%text)
    end do
  end subroutine read_and_list

  integer function describe_command(command) result(status)
    !! Every input name, or those of one group. **Errors**: `status_bad_input` for a group that is none.
    type(command_type), intent(in) :: command
    character(:), allocatable :: group, text
    type(error_type), allocatable :: error
    group = ''
    if (size(command%words) == 1) then
      group = command%words(1)%text
      if (index(group, '%') > 1) group = group(:index(group, '%') - 1)      ! group%name as in messages
    end if
    text = describe_text(group, error)
    status = status_done
    if (allocated(error)) then
      call print_error(error)
      status = error%status
    else
      call print_report(text)
    end if
  end function describe_command

end module bw_commands
