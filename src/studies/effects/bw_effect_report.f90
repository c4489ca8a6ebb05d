module bw_effect_report
  !! The printed table of what effects change.
  use bw_kinds, only: dp
  use bw_columns, only: right
  use bw_effect_list, only: effect_list, effect_not_combined, effect_on, effect_row, effect_words, largest_change
  use bw_missing, only: is_missing
  use bw_text, only: percent, shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: effect_report

  integer, parameter :: middle = 3         !! a mode between the first and the last that is shown

contains

  function effect_report(list) result(text)
    !! The table as it is printed.
    type(effect_list), intent(in) :: list
    character(:), allocatable :: text
    type(text_builder) :: lines
    integer :: i
    call lines%append_line('')
    call lines%append_line('  Each effect: the scene run with it beside the scene without it, all else alike. Of the wave')
    call lines%append_line('  velocities the largest change in '//text_of(list%mode_count)// &
                           ' modes, of the response the largest difference over its peak.')
    call lines%append_line('')
    call lines%append_line('                                     frequency of mode              wave velocity')
    call lines%append_line('  effect                 state        1'//right(text_of(min(middle, list%mode_count)), 9)// &
                           right(text_of(list%mode_count), 9)//'    phase    group  response    time  verdict')
    do i = 1, size(list%rows)
      call lines%append_line(row_line(list%rows(i), list%mode_count))
    end do
    call lines%append_line('')
    call lines%append_line('  An effect matters from the first mode on whose frequency it changes by more than '// &
                           shortest(list%tolerance, 2)//',')
    call lines%append_line('  '//list%tolerance_source//'.')
    do i = 1, size(list%rows)
      if (list%rows(i)%state /= effect_not_combined .and. list%rows(i)%remark /= '') then
        call lines%append_line('  '//name_of(list%rows(i))//': '//list%rows(i)%remark)
      end if
    end do
    text = lines%text()
  end function effect_report

  function row_line(row, last) result(text)
    type(effect_row), intent(in) :: row
    integer, intent(in) :: last                    !! the last mode that is compared
    character(:), allocatable :: text
    character(21) :: name
    character(3) :: state
    name = name_of(row)
    text = '  '//name
    if (row%state == effect_not_combined) then
      text = text//'  -        '//row%remark
      return
    end if
    state = merge('on ', 'off', row%state == effect_on)
    text = text//'  '//state//'   '//right(signed(row%frequency_change(1)), 9)// &
      right(signed(row%frequency_change(min(middle, last))), 9)//right(signed(row%frequency_change(last)), 9)// &
      right(signed(largest_change(row%phase_velocity_change)), 9)//right(signed(largest_change(row%group_velocity_change)), 9)// &
      right(part(row%response_change), 10)//right(times(row%seconds_with, row%seconds_without), 8)//'  '//verdict(row)
  end function row_line

  pure function name_of(row) result(name)
    !! In words.
    type(effect_row), intent(in) :: row
    character(:), allocatable :: name
    integer :: i
    name = trim(effect_words(row%effect))
    do i = 1, len(name)
      if (name(i:i) == '_') name(i:i) = ' '
    end do
  end function name_of

  pure function verdict(row) result(text)
    type(effect_row), intent(in) :: row
    character(:), allocatable :: text
    if (row%matters_from > 0) then
      text = 'matters from mode '//text_of(row%matters_from)//' on'
    else if (.not. is_missing(row%response_change) .and. row%response_change > 0.0_dp) then
      text = 'changes the response alone'
    else
      text = 'does not matter'
    end if
  end function verdict

  pure function signed(change) result(text)
    !! A change in per cent; 0 for the rounding of two ways to find the same; a dash for what does not exist.
    real(dp), intent(in) :: change
    character(:), allocatable :: text
    real(dp), parameter :: rounding = 1.0e-12_dp
    text = '-'
    if (is_missing(change)) return
    text = '0'
    if (abs(change) > rounding) text = percent(change)//'%'
  end function signed

  pure function part(change) result(text)
    !! Of the peak; nothing is said of its direction.
    real(dp), intent(in) :: change
    character(:), allocatable :: text
    text = signed(change)
    if (text(1:1) == '+') text = text(2:)
  end function part

  pure function times(above, below) result(text)
    !! How many times as long.
    real(dp), intent(in) :: above, below
    character(:), allocatable :: text
    text = '-'
    if (is_missing(above) .or. is_missing(below)) return
    if (below > 0.0_dp) text = 'x '//shortest(above/below, 2)
  end function times

end module bw_effect_report
