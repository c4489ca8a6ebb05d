module bw_frequency_report
  !! The printed report of a harmonic response: resonances, with damping from their half-power widths, and
  !! antiresonances.
  use bw_case_result, only: answer_type
  use bw_columns, only: fixed, note_rest, table_of, text_table
  use bw_constants, only: two_pi
  use bw_frequency_response_par, only: frequency_response_par
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_response_extremes, only: most_extremes
  use bw_text, only: shortest, text_builder
  implicit none (type, external)
  private
  public :: report_answer

  integer, parameter :: shown = 20                   !! rows that are no details

contains

  subroutine report_answer(asked, answer, lines)
    !! Print the resonances and antiresonances of all points.
    type(frequency_response_par), intent(in) :: asked
    type(answer_type), intent(in) :: answer
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    character(:), allocatable :: at, unit
    integer :: i
    select case (asked%quantity)
    case ('velocity'); unit = 'm/s/N'
    case ('acceleration'); unit = 'm/s2/N'
    case default; unit = 'm/N'
    end select
    call lines%append_line('')
    call lines%append_line('response to a harmonic force of 1 N at xi = '//shortest(asked%position, 6)//': '//asked%quantity)
    table = table_of('xi|resonance|amplitude|damping ratio|antiresonance', '|Hz|'//unit//'||Hz', [10, 13, 13, 15, 15])
    call table%put_head(lines)
    do i = 1, min(most_extremes, size(answer%extremes))
      associate (extreme => answer%extremes(i))
        at = shortest(extreme%omega/two_pi, 7)
        if (extreme%is_resonance) then
          call table%put_row(lines, fixed(asked%points(extreme%point))//'|'//at//'|'//fixed(extreme%amplitude)//'|'// &
                             fixed(extreme%ratio), detail=i > shown)
        else
          call table%put_row(lines, fixed(asked%points(extreme%point))//'||||'//at, detail=i > shown)
        end if
      end associate
    end do
    if (size(answer%extremes) > most_extremes) &
      call lines%append_line('   ...  and more; fewer points or a narrower band show them')
    if (size(answer%extremes) == 0) &
      call lines%append_line('  neither a resonance nor an antiresonance lies between these frequencies')
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
