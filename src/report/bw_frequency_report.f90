module bw_frequency_report
  !! The printed report of a harmonic response: its largest amplitude at each point, and waves at bodies and steps.
  use bw_case_result, only: answer_type
  use bw_columns, only: fixed, note_rest, table_of, text_table
  use bw_frequency_response_par, only: frequency_response_par
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_text, only: shortest, text_builder
  implicit none (type, external)
  private
  public :: report_answer

  integer, parameter :: shown = 20                   !! rows

contains

  subroutine report_answer(asked, answer, lines)
    !! Print the largest amplitude of each point, and its frequency.
    type(frequency_response_par), intent(in) :: asked
    type(answer_type), intent(in) :: answer
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    real(dp) :: amplitude(size(answer%value, 1))
    character(:), allocatable :: unit
    integer :: p, at
    select case (asked%quantity)
    case ('velocity'); unit = 'm/s/N'
    case ('acceleration'); unit = 'm/s2/N'
    case default; unit = 'm/N'
    end select
    call lines%append_line('')
    call lines%append_line('response to a harmonic force of 1 N at xi = '//shortest(asked%position, 6)//': '//asked%quantity)
    table = table_of('xi|largest amplitude|at', '|'//unit//'|Hz', [10, 19, 13])
    call table%put_head(lines)
    do p = 1, min(shown, size(asked%points))
      if (any(is_missing(answer%value(:, p)%re))) cycle
      amplitude = abs(answer%value(:, p))
      at = maxloc(amplitude, dim=1)
      call table%put_row(lines, fixed(asked%points(p))//'|'//fixed(amplitude(at))//'|'//fixed(asked%frequency(at)))
    end do
    call note_rest(lines, size(asked%points), shown)
    if (allocated(answer%junction)) call report_junctions(asked%frequency, answer, lines)
  end subroutine report_answer

  subroutine report_junctions(frequency, answer, lines)
    !! Print the least and largest transmission of bodies and steps within the beam.
    real(dp), intent(in) :: frequency(:)             !! Hz
    type(answer_type), intent(in) :: answer
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    integer :: i, least, most
    call lines%append_line('')
    call lines%append_line('share of the power of bending waves that bodies and steps transmit')
    table = table_of('xi|least|at|largest|at', '|%|Hz|%|Hz', [10, 13, 13, 13, 13])
    call table%put_head(lines)
    do i = 1, min(shown, size(answer%junction))
      associate (share => answer%transmitted(:, i))
        if (any(is_missing(share))) cycle
        least = minloc(share, dim=1)
        most = maxloc(share, dim=1)
        call table%put_row(lines, fixed(answer%junction(i))//'|'//shortest(100.0_dp*share(least), 4)//'|'// &
                           fixed(frequency(least))//'|'//shortest(100.0_dp*share(most), 4)//'|'//fixed(frequency(most)))
      end associate
    end do
    call note_rest(lines, count(.not. is_missing(answer%junction)), shown)
  end subroutine report_junctions

end module bw_frequency_report
