module bw_console
  !! Output of the program: reports to standard output, warnings and errors to standard error, unbuffered, since a
  !! buffer is lost when a process is killed. Texts of others, such as names of files, columns and units, pass through
  !! `printable`.
  use bw_descriptors, only: look_at_open, standard_error, standard_output, write_text
  use bw_error, only: error_type
  use bw_files, only: path_state, same_file
  use bw_json, only: json_member, json_text
  use bw_note, only: is_remark
  use bw_scene, only: scene_type
  use bw_system_calls, only: bw_kind_of_error, error_nobody_reads
  use bw_text, only: lines_of, printable, string
  implicit none (type, external)
  private
  public :: print_report, print_warning, print_warnings, print_error, seen_together, speak_json

  logical, protected, public :: report_lost = .false.   !! standard output could not be written
  logical :: in_json = .false.                          !! standard error gets JSON lines

contains

  subroutine print_report(text)
    !! Print lines to standard output. A failure sets `report_lost`, except when the reader closes a pipe, as `head`
    !! does.
    character(*), intent(in) :: text
    integer :: problem
    if (text == '') return
    problem = write_text(standard_output, whole_lines(text))
    if (problem /= 0 .and. bw_kind_of_error(problem) /= error_nobody_reads) report_lost = .true.
  end subroutine print_report

  subroutine speak_json(asked)
    !! Switch standard error to JSON lines, if requested.
    logical, intent(in) :: asked
    in_json = asked
  end subroutine speak_json

  subroutine print_warning(text)
    !! Print lines to standard error. A failure cannot be reported.
    character(*), intent(in) :: text
    integer :: ignored
    if (in_json) then
      ignored = write_text(standard_error, '{"event": "message"'//json_member('message', json_text(text))//'}'//new_line('a'))
    else
      ignored = write_text(standard_error, whole_lines(text))
    end if
  end subroutine print_warning

  subroutine print_warnings(scene, notes)
    !! Print each warning among notes, preceded by its scene. Remarks are printed in the report only.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: notes              !! lines
    type(string), allocatable :: lines(:)
    integer :: i
    lines = lines_of(notes)
    do i = 1, size(lines)
      if (.not. is_remark(lines(i)%text)) call print_warning(scene%file//': warning: '//lines(i)%text)
    end do
  end subroutine print_warnings

  logical function seen_together()
    !! Return whether report and warnings go to the same terminal, file or pipe: the report ends with the same warnings.
    type(path_state) :: output, warnings
    seen_together = look_at_open(standard_output, output) == 0
    if (seen_together) seen_together = look_at_open(standard_error, warnings) == 0
    if (seen_together) seen_together = same_file(output, warnings)
  end function seen_together

  subroutine print_error(error)
    !! Print the message of an error to standard error.
    type(error_type), intent(in) :: error
    call print_warning(error%message)
  end subroutine print_error

  pure function whole_lines(text) result(lines)
    !! Return a text that is safe for a terminal and ends with a line end.
    character(*), intent(in) :: text
    character(:), allocatable :: lines
    lines = printable(text)
    if (len(text) > 0) then
      if (text(len(text):) == new_line('a')) return
    end if
    lines = lines//new_line('a')
  end function whole_lines

end module bw_console
