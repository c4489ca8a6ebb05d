module bw_console
  !! What the program prints: reports to standard output, warnings and errors to standard error.
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use bw_error, only: error_type
  implicit none (type, external)
  private
  public :: print_report, print_warning, print_error

contains

  subroutine print_report(text)
    !! Lines, flushed: redirected output is lost when a process is killed. A failure shows when the process ends.
    character(*), intent(in) :: text
    integer :: stat
    if (text == '') return
    write (output_unit, '(a)', advance=merge('no ', 'yes', ends_line(text)), iostat=stat) text
    flush (output_unit, iostat=stat)
  end subroutine print_report

  pure logical function ends_line(text)
    character(*), intent(in) :: text
    ends_line = text(len(text):) == new_line('a')
  end function ends_line

  subroutine print_warning(text)
    character(*), intent(in) :: text
    integer :: stat
    write (error_unit, '(a)', iostat=stat) text
  end subroutine print_warning

  subroutine print_error(error)
    type(error_type), intent(in) :: error
    call print_warning(without_last_end(error%message))
  end subroutine print_error

  pure function without_last_end(text) result(lines)
    character(*), intent(in) :: text
    character(:), allocatable :: lines
    lines = text
    if (len(text) > 0) then
      if (ends_line(text)) lines = text(:len(text) - 1)
    end if
  end function without_last_end

end module bw_console
