module bw_run_command
  !! The commands that write results: run scenes, or study one scene by running it in several ways.
  use bw_accuracy, only: measure_accuracy
  use bw_command_table, only: command_type
  use bw_console, only: print_error, print_report, print_warning, print_warnings, seen_together, speak_json
  use bw_effects, only: compare_effects
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input, status_done, status_not_trusted, status_stopped
  use bw_kinds, only: dp, i4
  use bw_outcome, only: outcome_type
  use bw_process, only: pause, stop_after
  use bw_process_group, only: process_group
  use bw_run_record, only: run_record
  use bw_run_scene, only: run_scene
  use bw_scene, only: scene_type
  use bw_scene_files, only: read_and_list
  use bw_scene_tally, only: scene_tally, warning_kinds
  use bw_screen, only: printed
  use bw_terminal_progress, only: terminal_progress, terminal_progress_to
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: run_command, accuracy_command, effects_command

  integer, parameter :: between_streams = 20000        !! µs; mpirun forwards both streams in pieces of 4 KB, and a warning must not
                                                       !! split a report

contains

  integer function run_command(command) result(status)
    !! Run every valid scene; the status is the highest of all. Called by all processes; only the leader prints.
    type(command_type), intent(in) :: command
    type(scene_type), allocatable :: scenes(:)
    type(terminal_progress) :: progress
    type(scene_tally) :: tally
    type(error_type), allocatable :: error
    integer(i4), allocatable :: stop(:)            ! of size 1: 1 if the leader has to stop
    integer :: i, count
    if (command%max_seconds < huge(1.0_dp)) call stop_after(command%max_seconds)
    call speak_json(command%json)
    progress = terminal_progress_to(huge(1.0_dp), command%quiet .and. .not. command%json .or. .not. command%group%leads(), &
                                    command%json)
    call read_and_list(command%words, command%group%leads(), scenes, count, status, tally)
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
        exit
      end if
      status = max(status, run_one(command, scenes(i), progress, tally))
    end do
    if (command%group%leads() .and. .not. command%quiet) call print_report(tally%text('done'))
  end function run_command

  subroutine agree_on_scenes(group, count, error)
    !! Check that all processes have read the same scenes.
    !! **Errors**: a process could not read what the leader has read. All get the error.
    class(process_group), intent(inout) :: group
    integer, intent(in) :: count                   !! of valid scenes
    type(error_type), allocatable, intent(out) :: error
    integer(i4), allocatable :: counts(:)
    real(dp) :: nothing(0)
    counts = [count]
    call group%share(counts)
    if (count /= counts(1)) call fail(error, status_bad_file, 'beamwave: process '//text_of(group%number)//' of '// &
      text_of(group%processes)//' reads '//text_of(count)//' good scenes, the first one '//text_of(counts(1))// &
      ': a file could not be read, or memory ran out')
    call group%collect(nothing, error)
  end subroutine agree_on_scenes

  integer function run_one(command, scene, progress, tally) result(status)
    !! Run a scene, and print its outcome.
    type(command_type), intent(in) :: command
    type(scene_type), intent(in) :: scene
    type(terminal_progress), intent(inout) :: progress
    type(scene_tally), intent(inout) :: tally
    type(outcome_type) :: outcome
    type(error_type), allocatable :: error
    outcome%notes = ''
    if (allocated(scene%record)) then
      call run_record(scene, command%output, command%overwrite, command%part, command%group, progress, outcome, error)
    else
      call run_scene(scene, command%output, command%overwrite, command%part, command%group, progress, outcome, error)
    end if
    status = outcome%status
    if (.not. command%group%leads()) return
    status = print_outcome(command, scene, outcome, tally%is_brief(), error)
    call tally%count_end(status, outcome%notes)
    if (outcome%was_there) tally%there = tally%there + 1
  end function run_one

  integer function accuracy_command(command) result(status)
    !! Measure the cost of accuracy for a scene.
    type(command_type), intent(in) :: command
    status = study_scene(command, measure_accuracy)
  end function accuracy_command

  integer function effects_command(command) result(status)
    !! Compare a scene with and without each effect.
    type(command_type), intent(in) :: command
    status = study_scene(command, compare_effects)
  end function effects_command

  integer function study_scene(command, study) result(status)
    !! Study the scene that is named, and print the outcome.
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
    if (allocated(scenes(1)%record)) then
      call fail(error, status_bad_input, scenes(1)%file//': &record: beamwave '// &
                trim(command%row%name)//' needs simulated histories; accepted: a scene without &record')
    else
      call study(scenes(1), command%output, command%overwrite, progress, outcome, error)
    end if
    status = max(status, print_outcome(command, scenes(1), outcome, .false., error))
  end function study_scene

  integer function print_outcome(command, scene, outcome, brief, error) result(status)
    !! Print the outcome of a scene.
    type(command_type), intent(in) :: command
    type(scene_type), intent(in) :: scene
    type(outcome_type), intent(in) :: outcome
    logical, intent(in) :: brief                   !! in one line
    type(error_type), intent(in), optional :: error
    logical :: made                                !! a result exists, even if a file beside it could not be written
    made = .not. present(error)
    if (allocated(outcome%report)) made = made .or. outcome%report /= ''
    status = merge(outcome%status, status_done, made)
    if (made) then
      call print_result(command, scene, outcome, brief)
    else if (allocated(outcome%warnings)) then
      call print_warnings(scene, outcome%warnings)
    end if
    if (.not. present(error)) return
    call print_error(error)
    status = max(status, error%status)
  end function print_outcome

  subroutine print_result(command, scene, outcome, brief)
    !! Print the report of a result, and its warnings.
    type(command_type), intent(in) :: command
    type(scene_type), intent(in) :: scene
    type(outcome_type), intent(in) :: outcome
    logical, intent(in) :: brief                   !! in one line
    logical :: seen                                !! the report has shown the warnings to the same reader
    if (.not. command%quiet .and. brief) call print_report(brief_text(outcome))
    if (.not. command%quiet .and. .not. brief) call print_report(printed(outcome%report, command%verbose))
    if (outcome%was_there) return
    seen = .false.
    if (.not. command%quiet .and. outcome%status /= status_stopped) seen = seen_together()
    if (seen) return
    if (command%group%processes > 1 .and. .not. command%quiet) call pause(between_streams)
    if (allocated(outcome%warnings)) call print_warnings(scene, outcome%warnings)
    call print_warnings(scene, outcome%notes)
  end subroutine print_result

  pure function brief_text(outcome) result(text)
    !! Return one line for one of many scenes; empty for a stopped one, which has a warning.
    type(outcome_type), intent(in) :: outcome
    character(:), allocatable :: text
    text = ''
    if (outcome%status == status_stopped) return
    text = outcome%file//': done'
    if (outcome%was_there) text = outcome%file//': nothing to do'
    if (outcome%status == status_not_trusted) text = text//', but some numbers cannot be trusted'
    if (warning_kinds(outcome%notes) /= '') text = text//'; warnings: '//warning_kinds(outcome%notes)
  end function brief_text

end module bw_run_command
