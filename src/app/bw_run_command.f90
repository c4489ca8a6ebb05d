module bw_run_command
  !! The commands that write results: scenes are run, or one scene is studied by running it in several ways.
  use bw_accuracy, only: measure_accuracy
  use bw_command_table, only: command_type
  use bw_console, only: print_error, print_report, print_warning
  use bw_descriptors, only: is_terminal, standard_error, standard_output
  use bw_effects, only: compare_effects
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input, status_stopped
  use bw_kinds, only: dp, i4
  use bw_outcome, only: outcome_type
  use bw_process, only: pause
  use bw_process_group, only: process_group
  use bw_run_scene, only: run_scene
  use bw_scene, only: scene_type
  use bw_scene_files, only: read_and_list
  use bw_stopwatch, only: wall_seconds
  use bw_terminal_progress, only: terminal_progress, terminal_progress_to
  use bw_text, only: lines_of, string, text_of
  implicit none (type, external)
  private
  public :: run_command, accuracy_command, effects_command

  integer, parameter :: between_streams = 20000        !! µs; mpirun hands on both streams in pieces of 4 KB, and a warning
                                                       !! must not fall between two pieces of a report

contains

  integer function run_command(command) result(status)
    !! Run every good scene; the status is the highest of any. Called by all processes; only the leader speaks.
    type(command_type), intent(in) :: command
    type(scene_type), allocatable :: scenes(:)
    type(terminal_progress) :: progress
    real(dp) :: deadline
    type(error_type), allocatable :: error
    integer(i4), allocatable :: stop(:)            ! of one number: 1 where the leader has to stop
    integer :: i, count
    deadline = huge(1.0_dp)
    if (command%max_seconds < huge(1.0_dp)) deadline = wall_seconds() + command%max_seconds
    progress = terminal_progress_to(deadline, command%quiet .or. .not. command%group%leads())
    call read_and_list(command%words, command%group%leads(), scenes, count, status)
    call agree_on_scenes(command%group, count, error)
    if (allocated(error)) then
      if (command%group%leads()) call print_error(error)
      status = error%status
      return
    end if
    do i = 1, count
      stop = [merge(1_i4, 0_i4, progress%stop_requested())]
      call command%group%share(stop)
      if (stop(1) == 1) then
        if (command%group%leads()) call print_warning('beamwave: stopped before '//scenes(i)%file// &
                                             '; the same command goes on from there')
        status = max(status, status_stopped)
        return
      end if
      status = max(status, run_one(command, scenes(i), progress))
    end do
  end function run_command

  subroutine agree_on_scenes(group, count, error)
    !! Make sure that all processes have read the same scenes.
    !! **Errors**: one of them could not read what the leader has read. All get it.
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

  integer function run_one(command, scene, progress) result(status)
    !! Run a scene, and say how it ended.
    type(command_type), intent(in) :: command
    type(scene_type), intent(in) :: scene
    type(terminal_progress), intent(inout) :: progress
    type(outcome_type) :: outcome
    type(error_type), allocatable :: error
    call run_scene(scene, command%output, command%overwrite, command%group, progress, outcome, error)
    status = outcome%status
    if (command%group%leads()) status = print_outcome(command, scene, outcome, error)
  end function run_one

  integer function accuracy_command(command) result(status)
    !! Measure what accuracy costs on a scene.
    type(command_type), intent(in) :: command
    status = study_scene(command, measure_accuracy)
  end function accuracy_command

  integer function effects_command(command) result(status)
    !! Compare a scene with and without each effect.
    type(command_type), intent(in) :: command
    status = study_scene(command, compare_effects)
  end function effects_command

  integer function study_scene(command, study) result(status)
    !! Study the one scene that is named, and say how that ended.
    type(command_type), intent(in) :: command
    procedure(measure_accuracy) :: study
    type(scene_type), allocatable :: scenes(:)
    type(terminal_progress) :: progress
    type(outcome_type) :: outcome
    type(error_type), allocatable :: error
    integer :: count
    call read_and_list(command%words, .true., scenes, count, status)
    if (count > 1) then
      call print_warning('beamwave '//trim(command%row%name)//': a directory holds several scenes; accepted: one scene')
      status = status_bad_input
    end if
    if (count /= 1) return
    progress = terminal_progress_to(huge(1.0_dp), command%quiet)
    call study(scenes(1), command%output, command%overwrite, progress, outcome, error)
    status = max(status, print_outcome(command, scenes(1), outcome, error))
  end function study_scene

  integer function print_outcome(command, scene, outcome, error) result(status)
    !! Say how a scene ended.
    type(command_type), intent(in) :: command
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
    if (command%group%processes > 1 .and. .not. command%quiet) call pause(between_streams)
    if (allocated(outcome%remarks)) call print_warnings(scene, outcome%remarks)
    call print_warnings(scene, outcome%warnings)
  end function print_outcome

  pure function trust_text(outcome) result(text)
    !! The words on a result that was there already whose numbers cannot all be trusted; empty where they can.
    type(outcome_type), intent(in) :: outcome
    character(:), allocatable :: text
    text = ''
    if (outcome%not_trusted > 0) text = '; '//text_of(outcome%not_trusted)//' of its cases '// &
      'cannot be trusted, as its notes say'
  end function trust_text

  logical function seen_together()
    !! Whether report and warnings come to the same eyes: the report ends with the same notes.
    seen_together = is_terminal(standard_output)
    if (seen_together) seen_together = is_terminal(standard_error)
  end function seen_together

  subroutine print_warnings(scene, lines)
    !! Print each line with the scene that it is about.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: lines
    type(string), allocatable :: warnings(:)
    integer :: i
    warnings = lines_of(lines)
    do i = 1, size(warnings)
      call print_warning(scene%file//': warning: '//warnings(i)%text)
    end do
  end subroutine print_warnings

end module bw_run_command
