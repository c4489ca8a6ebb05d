module bw_main
  !! What the programs do, whoever hands out the cases.
  use bw_command_line, only: command_type, help_text, read_command_line
  use bw_commands, only: check_command, describe_command, run_command
  use bw_console, only: print_error, print_report, print_warning, report_lost
  use bw_error, only: error_type, status_bad_file, status_done
  use bw_process, only: leave, open_standard_streams, watch_over_process
  use bw_process_group, only: process_group
  use bw_study_commands, only: study_command
  use bw_version_text, only: version_text
  implicit none (type, external)
  private
  public :: main

contains

  subroutine main(group)
    !! All processes run scenes; the leader does everything else alone, and its exit status is that of all.
    class(process_group), intent(inout) :: group
    type(command_type) :: command
    type(error_type), allocatable :: error
    integer :: status
    call open_standard_streams()
    call group%join()
    call watch_over_process()
    status = status_done
    call read_command_line(command, error)
    if (allocated(error)) then
      status = error%status
      if (group%leads()) call print_error(error)
    else if (command%name == 'run') then
      status = run_command(command, group)
    else if (group%leads()) then
      status = lone_command(command)
    end if
    if (report_lost) then
      call print_warning('beamwave: standard output cannot be written')
      status = max(status, status_bad_file)
    end if
    call group%part()
    if (.not. group%leads()) status = status_done
    call leave(status)
  end subroutine main

  integer function lone_command(command) result(status)
    !! All but `run`.
    type(command_type), intent(in) :: command
    status = status_done
    select case (command%name)
    case ('accuracy', 'effects'); status = study_command(command)
    case ('check'); status = check_command(command)
    case ('describe'); status = describe_command(command)
    case ('version'); call print_report(version_text())
    case default; call print_report(help_text())
    end select
  end function lone_command

end module bw_main
