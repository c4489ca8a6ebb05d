module bw_quantile_table
  !! The printed table of quantiles over the cases of a design.
  use bw_columns, only: note_rest, short, table_of, text_table
  use bw_constants, only: two_pi
  use bw_kinds, only: dp
  use bw_missing, only: scaled
  use bw_over_cases, only: case_quantiles
  use bw_result_draft, only: result_draft
  use bw_result_layout, only: has
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: quantile_table

  integer, parameter :: shown = 5           !! numbers of one variable

contains

  function quantile_table(draft, quantiles) result(text)
    !! Print a line for each number that is not 0 in every case; of modes the first.
    type(result_draft), intent(in) :: draft
    type(case_quantiles), intent(in) :: quantiles(:)
    character(:), allocatable :: text
    type(text_builder) :: lines
    type(text_table) :: table
    integer :: s, n
    call lines%append_line('')
    call lines%append_line('  Quantiles over '//text_of(draft%layout%cases)//' cases, of those that have the number')
    table = table_of('cases|least|5 %|25 %|50 %|75 %|95 %|largest|what', '', [8, 12, 12, 12, 12, 12, 12, 12, 0])
    call table%put_head(lines)
    do s = 1, size(quantiles)
      do n = 1, min(shown, size(quantiles(s)%cases))
        if (all(quantiles(s)%values(n, :) == 0.0_dp)) cycle
        call table%put_row(lines, cells_of(draft, s, quantiles(s), n))
      end do
      call note_rest(lines, size(quantiles(s)%cases), shown)
    end do
    text = lines%text()
  end function quantile_table

  function cells_of(draft, s, quantiles, n) result(cells)
    !! Return the cells of a number.
    type(result_draft), intent(in) :: draft
    integer, intent(in) :: s                !! index of the draft's summary
    type(case_quantiles), intent(in) :: quantiles
    integer, intent(in) :: n
    character(:), allocatable :: cells, words, unit
    real(dp) :: factor
    integer :: q
    factor = 1
    associate (summary => draft%summaries(s))
      words = summary%long_name
      unit = summary%units
      if (unit == 'rad s-1' .and. index(summary%name, 'frequency') > 0) then
        words = 'frequency'
        unit = 'Hz'
        factor = 1/two_pi
      end if
      if (summary%dimensions == 'point' .and. has(draft%layout, 'places')) then
        words = words//' at xi = '//shortest(draft%scene%response%points(n), 15)
      else if (summary%dimensions /= '') then
        words = words//', '//summary%dimensions//' '//text_of(n)
      end if
    end associate
    cells = text_of(quantiles%cases(n))
    do q = 1, size(quantiles%values, 2)
      cells = cells//'|'//short(scaled(quantiles%values(n, q), factor), 6)
    end do
    cells = cells//'|'//words
    if (unit /= '1') cells = cells//' ('//unit//')'
  end function cells_of

end module bw_quantile_table
