module bw_record_table
  !! The printed table of the cases of a record, repeats or parts: all of a few cases, or the first and last of many.
  use bw_columns, only: pair_cells, short, table_of, text_table
  use bw_constants, only: two_pi
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing, missing
  use bw_result_draft, only: result_draft
  use bw_swept_text, only: swept_text
  use bw_text, only: text_builder, text_of
  implicit none (type, external)
  private
  public :: record_table

  integer, parameter :: shown = 10            !! number of first cases, and of last ones

contains

  function record_table(draft) result(text)
    !! Return the table of all cases of a draft.
    type(result_draft), intent(inout) :: draft
    character(:), allocatable :: text
    type(text_builder) :: built
    type(text_table) :: table
    integer(i8) :: i
    call built%append_line('')
    table = table_of('case|lines|strongest line|+/-|decay rate|+/-|noise|of', &
                     '||Hz|Hz|1/s|1/s|1st sensor', [8, 8, 16, 12, 12, 12, 12, 0])
    call table%put_head(built)
    do i = 1, draft%layout%cases
      if (i <= shown .or. i > draft%layout%cases - shown) then
        call table%put_row(built, row_cells(draft, i), '   '//swept_text(draft%scene, i))
      else if (i == shown + 1) then
        call built%append_line('     ...')
      end if
    end do
    text = built%text()
  end function record_table

  function row_cells(draft, case) result(cells)
    !! Return the cells of a case: its strongest line, and the noise of the first sensor.
    type(result_draft), intent(inout) :: draft
    integer(i8), intent(in) :: case
    character(:), allocatable :: cells
    real(dp), allocatable, dimension(:) :: lines, frequency, frequency_error, decay, decay_error, noise
    real(dp) :: pairs(2, 2)
    integer :: k
    lines = draft%get('peak_count', case)
    noise = draft%get('noise_deviation', case)
    pairs = missing
    if (nint(lines(1)) > 0) then
      k = strongest(draft%get('measured_amplitude', case), draft%layout%peaks)
      frequency = draft%get('measured_angular_frequency', case)
      frequency_error = draft%get('measured_angular_frequency_error', case)
      decay = draft%get('measured_decay_rate', case)
      decay_error = draft%get('measured_decay_rate_error', case)
      pairs(:, 1) = [frequency(k), frequency_error(k)]/two_pi
      pairs(:, 2) = [decay(k), decay_error(k)]
    end if
    cells = text_of(case)//'|'//text_of(nint(lines(1)))//'|'//pair_cells(pairs(1, 1), pairs(2, 1))//'|'// &
      pair_cells(pairs(1, 2), pairs(2, 2))//'|'//short(noise(1), 3)
  end function row_cells

  pure integer function strongest(amplitude, peaks) result(k)
    !! Return the line of the largest amplitude at any sensor.
    real(dp), intent(in) :: amplitude(:)      !! the lines of the first sensor, of the second, …
    integer, intent(in) :: peaks              !! reserved number of lines
    k = modulo(maxloc(amplitude, dim=1, mask=.not. is_missing(amplitude)) - 1, peaks) + 1
  end function strongest

end module bw_record_table
