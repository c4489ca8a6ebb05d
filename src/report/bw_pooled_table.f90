module bw_pooled_table
  !! The printed table of the lines that repeats of a record share.
  use bw_columns, only: right
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, scaled
  use bw_random_effects, only: pooled_value
  use bw_record_report, only: pair_text
  use bw_repeats, only: pooled_lines
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: pooled_table

  integer, parameter :: shown = 40
  real(dp), parameter :: two_pi = 2.0_dp*acos(-1.0_dp)

contains

  function pooled_table(pooled, cases, confidence) result(text)
    !! The table; nothing where repeats share no line.
    type(pooled_lines), intent(in) :: pooled
    integer, intent(in) :: cases                  !! repeats
    real(dp), intent(in) :: confidence            !! of the intervals
    character(:), allocatable :: text
    type(text_builder) :: lines
    integer :: k
    text = ''
    if (size(pooled%count) == 0) return
    call lines%append_line('')
    call lines%append_line('  Repeats pooled; +/- is half an interval of '//shortest(100*confidence, 6)// &
                           ' % about what they share, next +/- holds what one more repeat measures')
    call lines%append_line('  line  repeats     frequency         +/-    next +/-     scatter  decay rate         +/-    '// &
                           'next +/-     scatter   what')
    call lines%append_line('                           Hz          Hz          Hz          Hz         1/s         1/s    '// &
                           '     1/s         1/s')
    do k = 1, min(shown, size(pooled%count))
      call lines%append_line(right(text_of(k), 6)//right(text_of(pooled%count(k))//' of '//text_of(cases), 9)// &
        value_text(pooled%frequency(k), 1/two_pi, 14)//value_text(pooled%decay(k), 1.0_dp, 12)// &
        status_text(pooled%status(k)))
    end do
    if (size(pooled%count) > shown) call lines%append_line('   ...  '//text_of(size(pooled%count))//' in the file')
    text = lines%text()
  end function pooled_table

  pure function value_text(pooled, unit, width) result(text)
    !! A number, half its interval, that of the next repeat, and the scatter.
    type(pooled_value), intent(in) :: pooled
    real(dp), intent(in) :: unit
    integer, intent(in) :: width                  !! of the number; the others take 12 each
    character(:), allocatable :: text
    text = pair_text([scaled(pooled%value, unit), scaled(pooled%error, unit)], width)
    if (is_missing(pooled%value)) then
      text = text//right('-', 12)//right('-', 12)
    else
      text = text//right(shortest(unit*pooled%next, 2), 12)//right(shortest(unit*pooled%scatter, 2), 12)
    end if
  end function value_text

  pure function status_text(status) result(text)
    !! Which numbers scatter more than the repeats' own errors allow, and whether they drift: the bits of `pooled_words` behind the
    !! first; behind blanks.
    integer, intent(in) :: status
    character(:), allocatable :: text
    character(*), parameter :: told(*) = [character(20) :: ', frequency scatters', ', decay scatters', ', drifting']
    integer :: i
    text = ''
    do i = 1, size(told)
      if (btest(status, i)) text = text//trim(told(i))
    end do
    if (text /= '') text = '   '//text(3:)
  end function status_text

end module bw_pooled_table
