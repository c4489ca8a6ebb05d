program beamwave
  !! Bending waves in a rotating beam struck at its tip.
  use bw_command_line, only: command_type, help_text, read_command_line
  use bw_commands, only: check_command, describe_command, run_command
  use bw_console, only: print_error, print_report, print_warning, report_lost
  use bw_error, only: error_type, status_bad_file, status_done
  use bw_process, only: leave, use_one_thread, watch_over_process
  use bw_version_text, only: version_text
  implicit none (type, external)
  type(command_type) :: command
  type(error_type), allocatable :: error
  integer :: status

  call watch_over_process()
  call use_one_thread()
  call read_command_line(command, error)
  if (allocated(error)) then
    call print_error(error)
    call leave(error%status)
  end if
  status = status_done
  select case (command%name)
  case ('run'); status = run_command(command)
  case ('check'); status = check_command(command)
  case ('describe'); status = describe_command(command)
  case ('version'); call print_report(version_text())
  case default; call print_report(help_text())
  end select
  if (report_lost) then
    call print_warning('beamwave: standard output cannot be written')
    status = max(status, status_bad_file)
  end if
  call leave(status)
end program beamwave
