module bw_study_commands
  !! The commands that study one scene by running it in several ways. Each returns an exit status.
  use bw_accuracy, only: measure_accuracy
  use bw_command_line, only: command_type
  use bw_commands, only: print_outcome, read_and_list
  use bw_error, only: error_type, status_bad_input
  use bw_console, only: print_warning
  use bw_effects, only: compare_effects
  use bw_kinds, only: dp
  use bw_outcome, only: outcome_type
  use bw_scene, only: scene_type
  use bw_terminal_progress, only: terminal_progress, terminal_progress_to
  implicit none (type, external)
  private
  public :: study_command

contains

  integer function study_command(command) result(status)
    !! What accuracy costs on a scene, or what effects change.
    type(command_type), intent(in) :: command
    type(scene_type), allocatable :: scenes(:)
    type(terminal_progress) :: progress
    type(outcome_type) :: outcome
    type(error_type), allocatable :: error
    integer :: count
    call read_and_list(command, .true., scenes, count, status)
    if (count > 1) then
      call print_warning('beamwave '//command%name//': a directory holds several scenes; accepted: one scene')
      status = status_bad_input
    end if
    if (count /= 1) return
    progress = terminal_progress_to(huge(1.0_dp), command%quiet)
    if (command%name == 'effects') then
      call compare_effects(scenes(1), command%output, command%overwrite, progress, outcome, error)
    else
      call measure_accuracy(scenes(1), command%output, command%overwrite, progress, outcome, error)
    end if
    status = max(status, print_outcome(command, 1, scenes(1), outcome, error))
  end function study_command

end module bw_study_commands
