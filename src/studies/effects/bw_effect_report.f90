module bw_effect_report
  !! The influence of effects as a printed table and as the variables of DIR/<scene>.effects.nc.
  use bw_kinds, only: dp
  use bw_columns, only: table_of, text_table
  use bw_effect_list, only: effect_list, effect_not_combined, effect_on, effect_row, largest_change, state_words
  use bw_effect_table, only: in_words
  use bw_hint, only: compared_modes
  use bw_missing, only: is_missing, missing
  use bw_screen, only: details
  use bw_stopwatch, only: processor_name
  use bw_study_file, only: study_file, study_values
  use bw_text, only: percent, shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: effect_report

  integer, parameter :: middle = 3         !! a mode between the first and the last shown
  character(*), parameter :: by_mode = 'effect mode'   !! dimensions in the file

  type, extends(study_values), public :: effect_values
    type(effect_list) :: list
  contains
    procedure :: put => put_effects
  end type effect_values

contains

  function effect_report(list) result(text)
    !! Return the printed table.
    type(effect_list), intent(in) :: list
    character(:), allocatable :: text
    type(text_builder) :: lines
    type(text_table) :: table
    integer :: i
    call lines%append_line('')
    call lines%append_line('  Changes by each effect, with everything else unchanged. Wave velocities: the largest change')
    call lines%append_line('  in '//text_of(list%mode_count)// &
                           ' modes. Response: the largest difference of the displacement over its peak;')
    call lines%append_line('  +/-: the sum of the estimated errors of both displacements over the same peak.')
    call lines%append_line('')
    call lines%append_line('                                     frequency of mode              wave velocity')
    table = table_of('  effect|state|1|'//text_of(min(middle, list%mode_count))//'|'//text_of(list%mode_count)// &
                     '|phase|group|response|+/-|time|verdict', '', [-25, -6, 9, 9, 9, 9, 9, 10, 9, 8, 0], is_list=.false.)
    call table%put_head(lines)
    do i = 1, size(list%rows)
      call put_effect(list%rows(i), list%tolerance, list%mode_count, table, lines)
    end do
    call lines%append_line('')
    call lines%append_line('  An effect matters from the first mode whose frequency it changes by more than '// &
                           shortest(100.0_dp*list%tolerance, 2)//' %,')
    call lines%append_line('  '//list%tolerance_source//'. It matters for')
    call lines%append_line('  the response if the change exceeds that and the error.')
    do i = 1, size(list%rows)
      if (list%rows(i)%state /= effect_not_combined .and. list%rows(i)%remark /= '') then
        call lines%append(details('  '//in_words(list%rows(i)%effect)//': '//list%rows(i)%remark))
      end if
    end do
    text = lines%text()
  end function effect_report

  subroutine put_effect(row, tolerance, last, table, lines)
    !! Print the line of an effect: its influence and cost, or why it is not combined with the scene.
    type(effect_row), intent(in) :: row
    real(dp), intent(in) :: tolerance
    integer, intent(in) :: last                    !! the last compared mode
    type(text_table), intent(in) :: table
    type(text_builder), intent(inout) :: lines
    character(:), allocatable :: cost
    if (row%state == effect_not_combined) then
      call table%put_row(lines, '  '//in_words(row%effect)//'|-', '   '//row%remark)
      return
    end if
    cost = '-'                                     ! a run ended early
    if (row%is_whole) cost = times(row%seconds_with, row%seconds_without)
    call table%put_row(lines, '  '//in_words(row%effect)//'|'//trim(merge('on ', 'off', row%state == effect_on))//'|'// &
                       signed(row%frequency_change(1))//'|'//signed(row%frequency_change(min(middle, last)))//'|'// &
                       signed(row%frequency_change(last))//'|'//signed(largest_change(row%phase_velocity_change))//'|'// &
                       signed(largest_change(row%group_velocity_change))//'|'//part(row%response_change)//'|'// &
                       part(row%response_error)//'|'//cost//'|'//verdict(row, tolerance))
  end subroutine put_effect

  pure function verdict(row, tolerance) result(text)
    !! Say whether an effect matters; a dash if the numbers needed are omitted.
    type(effect_row), intent(in) :: row
    real(dp), intent(in) :: tolerance
    character(:), allocatable :: text
    real(dp) :: least
    least = tolerance
    if (.not. is_missing(row%response_error)) least = max(tolerance, row%response_error)
    if (row%matters_from > 0) then
      text = 'matters from mode '//text_of(row%matters_from)//' on'
    else if (.not. is_missing(row%response_change) .and. row%response_change > least) then
      text = 'changes only the response'
    else if (.not. row%is_whole) then
      text = '-'
    else
      text = 'does not matter'
    end if
  end function verdict

  pure function signed(change) result(text)
    !! Format a relative change in per cent, with two digits and a sign; 0 if it is rounding between two methods; a dash
    !! if it does not exist.
    real(dp), intent(in) :: change
    character(:), allocatable :: text
    real(dp), parameter :: rounding = 1.0e-12_dp
    text = '-'
    if (is_missing(change)) return
    text = '0'
    if (abs(change) > rounding) text = percent(change)//'%'
  end function signed

  pure function part(change) result(text)
    !! Format a change relative to the peak, unsigned.
    real(dp), intent(in) :: change
    character(:), allocatable :: text
    text = signed(change)
    if (text(1:1) == '+') text = text(2:)
  end function part

  pure function times(above, below) result(text)
    !! Format the ratio of run times with and without the effect; a dash if unknown.
    real(dp), intent(in) :: above, below
    character(:), allocatable :: text
    text = '-'
    if (.not. is_missing(ratio(above, below))) text = 'x '//shortest(ratio(above, below), 2)
  end function times

  subroutine put_effects(self, file)
    !! Put all rows into the file.
    class(effect_values), intent(in) :: self
    type(study_file), intent(inout) :: file
    call file%put_text('machine', processor_name())
    call file%put_text('remarks', remarks_of(self%list%rows))
    call file%put_axis('effect', size(self%list%rows), 'effect', self%list%rows%effect)
    call file%put_axis('mode', compared_modes, 'mode number k')
    call file%put_counts('effect_state', 'effect', 'whether the scene has the effect', self%list%rows%state, state_words)
    call file%put_counts('matters_from_mode', 'effect', &
                         'first mode whose frequency the effect changes by more than the tolerance; 0 where none', &
                         self%list%rows%matters_from)
    call file%put_numbers('frequency_tolerance', '', '1', 'relative change above which an effect matters', &
                          [self%list%tolerance])
    call put_modes(file, self%list%rows)
    call put_costs(file, self%list%rows)
  end subroutine put_effects

  subroutine put_modes(file, rows)
    !! Put the frequencies with and without each effect, and their changes.
    type(study_file), intent(inout) :: file
    type(effect_row), intent(in) :: rows(:)
    integer :: i
    call file%put_numbers('angular_frequency_with', by_mode, 'rad s-1', 'angular frequency with the effect', &
                          [(rows(i)%with%angular_frequency, i=1, size(rows))])
    call file%put_numbers('angular_frequency_without', by_mode, 'rad s-1', 'angular frequency without the effect', &
                          [(rows(i)%without%angular_frequency, i=1, size(rows))])
    call file%put_numbers('frequency_change', by_mode, '1', 'relative change of the angular frequency by the effect', &
                          [(rows(i)%frequency_change, i=1, size(rows))])
    call file%put_numbers('phase_velocity_change', by_mode, '1', 'relative change of the phase velocity by the effect', &
                          [(rows(i)%phase_velocity_change, i=1, size(rows))])
    call file%put_numbers('group_velocity_change', by_mode, '1', 'relative change of the group velocity by the effect', &
                          [(rows(i)%group_velocity_change, i=1, size(rows))])
  end subroutine put_modes

  subroutine put_costs(file, rows)
    !! Put the change of the response by each effect, and its cost.
    type(study_file), intent(inout) :: file
    type(effect_row), intent(in) :: rows(:)
    call file%put_numbers('response_change', 'effect', '1', &
                          'largest change of the displacement by the effect over the peak of the scene''s own', &
                          rows%response_change)
    call file%put_numbers('response_error', 'effect', '1', &
                          'estimated error of the displacement with and without the effect over the same peak', &
                          rows%response_error)
    call file%put_numbers('seconds_with', 'effect', 's', 'wall time of a case with the effect, median of the repeats', &
                          rows%seconds_with)
    call file%put_numbers('seconds_without', 'effect', 's', 'wall time of a case without the effect, median of the repeats', &
                          rows%seconds_without)
    call file%put_numbers('cost', 'effect', '1', 'wall time with the effect over that without it', &
                          ratio(rows%seconds_with, rows%seconds_without))
  end subroutine put_costs

  elemental real(dp) function ratio(above, below)
    !! Return the ratio of two times; missing if either is missing or the second is not positive.
    real(dp), intent(in) :: above, below
    ratio = missing
    if (is_missing(above) .or. is_missing(below)) return
    if (below > 0.0_dp) ratio = above/below
  end function ratio

  pure function remarks_of(rows) result(text)
    !! Return the remarks, one line for each effect that has one.
    type(effect_row), intent(in) :: rows(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(rows)
      if (rows(i)%remark == '') cycle
      if (text /= '') text = text//new_line('a')
      text = text//trim(rows(i)%effect)//': '//rows(i)%remark
    end do
  end function remarks_of

end module bw_effect_report
