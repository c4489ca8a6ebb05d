module bw_main
  !! The table of commands, and the main procedure of both programs. A new command is a row of the table and its
  !! procedure.
  use bw_check_command, only: check_command
  use bw_command_line, only: read_command_line
  use bw_command_table, only: command_row, command_type, help_text, no_words, one_group, one_scene, some_scenes
  use bw_console, only: print_error, print_report, print_warning, report_lost
  use bw_error, only: error_type, status_bad_file, status_done
  use bw_process, only: leave, open_standard_streams, watch_over_process
  use bw_process_group, only: process_group
  use bw_result_header, only: source_text
  use bw_run_command, only: accuracy_command, effects_command, run_command
  use bw_scene_describe, only: describe_text
  use bw_version, only: program_build, program_compiler, program_libraries, program_native
  implicit none (type, external)
  private
  public :: main

contains

  pure function commands() result(rows)
    !! Return all commands, in the order of the help.
    type(command_row) :: rows(7)
    character(*), parameter :: writing = '--output --overwrite --quiet --verbose'
    rows = [ &
      command_row('run', some_scenes, writing//' --max-seconds --part --progress', &
                  'run scenes; a directory stands for its *.nml', run_command, shared=.true.), &
      command_row('check', some_scenes, '--quiet --json', &
                  'read and validate; report what would be simulated, how, and in what time and memory', check_command), &
      command_row('accuracy', one_scene, writing, 'measure how long each further digit takes on this scene', accuracy_command), &
      command_row('effects', one_scene, writing, &
                  'for each effect: on or off, what it changes, what it costs', effects_command), &
      command_row('describe', one_group, '', 'every input name: type, unit, range, default, meaning', describe_command), &
      command_row('help', no_words, '', '', help_command, flags='--help -h'), &
      command_row('version', no_words, '', '', version_command, flags='--version -V')]
  end function commands

  subroutine main(group)
    !! Run a command: all processes run scenes; the leader does everything else alone, and its exit status is that of all.
    class(process_group), intent(inout), target :: group
    type(command_type) :: command
    type(error_type), allocatable :: error
    integer :: status
    call open_standard_streams()
    call group%join()
    call watch_over_process()
    status = status_done
    command%group => group
    call read_command_line(commands(), command, error)
    if (allocated(error)) then
      status = error%status
      if (group%leads()) call print_error(error)
    else if (command%row%shared .or. group%leads()) then
      status = command%row%procedure(command)
    end if
    if (report_lost) then
      call print_warning('beamwave: standard output cannot be written')
      status = max(status, status_bad_file)
    end if
    call group%part()
    if (.not. group%leads()) status = status_done
    call leave(status)
  end subroutine main

  integer function describe_command(command) result(status)
    !! Print every input name, or those of one group.
    !! **Errors**: `status_bad_input` for an unknown group.
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

  integer function help_command(command) result(status)
    !! Print the help.
    type(command_type), intent(in) :: command
    associate (unused => command)
    end associate
    call print_report(help_text(commands()))
    status = status_done
  end function help_command

  integer function version_command(command) result(status)
    !! Print version and commit, the compiler, and the libraries.
    type(command_type), intent(in) :: command
    character(*), parameter :: nl = new_line('a')
    character(:), allocatable :: processor
    associate (unused => command)
    end associate
    processor = 'for any processor of its kind'
    if (program_native) processor = 'tuned for the processor it was built on'
    call print_report(source_text()//nl//'compiler    '//program_compiler//nl// &
                      'build       '//program_build//', '//processor//nl//'libraries   '//program_libraries//nl)
    status = status_done
  end function version_command

end module bw_main
