module bw_console
  !! What the program prints: reports to standard output, warnings and errors to standard error. Every text goes out at
  !! once: what waits in a buffer is lost when a process is killed.
  use bw_descriptors, only: standard_error, standard_output, write_text
  use bw_error, only: error_type
  use bw_system_calls, only: bw_kind_of_error, error_nobody_reads
  implicit none (type, external)
  private
  public :: print_report, print_warning, print_error

  logical, protected, public :: report_lost = .false.   !! standard output could not be written

contains

  subroutine print_report(text)
    !! Print lines to standard output. A failure sets `report_lost`; that the reader has closed a pipe, as `head` does, is
    !! none.
    character(*), intent(in) :: text
    integer :: problem
    if (text == '') return
    problem = write_text(standard_output, whole_lines(text))
    if (problem /= 0 .and. bw_kind_of_error(problem) /= error_nobody_reads) report_lost = .true.
  end subroutine print_report

  subroutine print_warning(text)
    !! Print lines to standard error. Nowhere is left to tell of a failure.
    character(*), intent(in) :: text
    integer :: ignored
    ignored = write_text(standard_error, whole_lines(text))
  end subroutine print_warning

  subroutine print_error(error)
    !! Print the message of an error to standard error.
    type(error_type), intent(in) :: error
    call print_warning(error%message)
  end subroutine print_error

  pure function whole_lines(text) result(lines)
    !! The text with an end to its last line.
    character(*), intent(in) :: text
    character(:), allocatable :: lines
    lines = text
    if (len(text) > 0) then
      if (text(len(text):) == new_line('a')) return
    end if
    lines = text//new_line('a')
  end function whole_lines

end module bw_console
