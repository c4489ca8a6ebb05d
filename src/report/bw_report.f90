module bw_report
  !! The printed report of a case: the first modes with their wave velocities, the jump, the balance, what was
  !! measured in the histories, what to beware of, and where the time went.
  use bw_kinds, only: dp, i8
  use bw_case_fields, only: named_value
  use bw_case_result, only: case_result
  use bw_columns, only: fixed, right, seconds_text
  use bw_event, only: event_words
  use bw_missing, only: is_missing
  use bw_stopwatch, only: stage_count, stage_words, stopwatch
  use bw_text, only: lines_of, shortest, string, text_builder, text_of
  implicit none (type, external)
  private
  public :: case_report, notes_report, stage_table

  integer, parameter :: shown_modes = 10, shown_peaks = 10, shown_events = 20, shown_points = 5

contains

  function case_report(result) result(text)
    !! What is printed of one case.
    type(case_result), intent(in) :: result
    character(:), allocatable :: text
    type(text_builder) :: lines
    text = ''
    if (result%mode_count == 0) return             ! a note says why
    call report_modes(result, lines)
    if (allocated(result%impact)) call report_impact(result, lines)
    if (allocated(result%response)) call report_histories(result, lines)
    if (allocated(result%measured)) call report_measured(result, lines)
    text = lines%text()
  end function case_report

  subroutine report_modes(result, lines)
    !! The first modes, and above which angular velocity one is unstable.
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    real(dp) :: critical(1)
    call lines%append_line('')
    call lines%append_line('  mode       alpha  wave number    frequency  phase velocity  group velocity')
    call lines%append_line('                            1/m        rad/s             m/s             m/s')
    call report_columns(lines, shown_modes, &
                        named_value(result, 'alpha'), named_value(result, 'wavenumber'), &
                        named_value(result, 'angular_frequency'), named_value(result, 'phase_velocity'), &
                        named_value(result, 'group_velocity'))
    critical = named_value(result, 'critical_angular_velocity')
    if (is_missing(critical(1))) return
    call lines%append_line('  A mode is unstable above '//shortest(critical(1), 6)//' rad/s.')
  end subroutine report_modes

  subroutine report_columns(lines, most, first, second, third, fourth, fifth)
    !! Numbered rows, at most `most` of them.
    type(text_builder), intent(inout) :: lines
    integer, intent(in) :: most
    real(dp), intent(in) :: first(:), second(:), third(:), fourth(:), fifth(:)
    integer :: k
    do k = 1, min(most, size(first))
      call lines%append_line(right(text_of(k), 6)//right(fixed(first(k)), 12)//right(fixed(second(k)), 13)// &
                             right(fixed(third(k)), 13)//right(fixed(fourth(k)), 16)//right(fixed(fifth(k)), 16))
    end do
    if (size(first) > most) call lines%append_line('   ...  '//text_of(size(first))//' in the file')
  end subroutine report_columns

  subroutine report_impact(result, lines)
    !! The jump, and the balance of every event.
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    real(dp) :: state(3)
    state = [named_value(result, 'impulse'), named_value(result, 'mass_velocity'), named_value(result, 'tip_velocity')]
    call lines%append_line('')
    call lines%append_line('  Just after the impact: impulse '//shortest(state(1), 6)//' N s, mass '// &
                           shortest(state(2), 6)//' m/s, tip '//shortest(state(3), 6)//' m/s')
    call report_events(result, lines)
  end subroutine report_impact

  subroutine report_events(result, lines)
    !! The balance of every event; their times where not all are at t = 0, with their errors where contacts amplify them,
    !! their ends where one lasts.
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    real(dp), allocatable, dimension(:) :: energy_before, energy_after, momentum_before, momentum_after, time, end_time
    integer, parameter :: width = 14, narrow = 10
    integer :: timed, lasting, doubtful           ! columns: 0 or 1
    integer :: i
    time = named_value(result, 'event_time')
    end_time = named_value(result, 'event_end')
    timed = merge(1, 0, any(end_time > 0.0_dp))
    lasting = merge(1, 0, any(end_time > time))
    doubtful = merge(timed, 0, any(result%events%time_error > 0.0_dp))
    call lines%append_line('')
    call lines%append_line('  event   '//repeat(right('time', width), timed)//repeat(right('+/-', narrow), doubtful)// &
                           repeat(right('until', width), lasting)// &
                           '   energy before    energy after  momentum before  momentum after')
    call lines%append_line('          '//repeat(right('s', width), timed)//repeat(right('s', narrow), doubtful)// &
                           repeat(right('s', width), lasting)// &
                           '               J               J           kg m/s          kg m/s')
    energy_before = named_value(result, 'energy_before')
    energy_after = named_value(result, 'energy_after')
    momentum_before = named_value(result, 'momentum_before')
    momentum_after = named_value(result, 'momentum_after')
    do i = 1, min(shown_events, size(result%events))
      call lines%append('  '//event_words(result%events(i)%kind))
      if (timed == 1) call lines%append(right(shortest(time(i), 7), width))
      if (doubtful == 1) call lines%append(right(shortest(result%events(i)%time_error, 2), narrow))
      if (lasting == 1) call lines%append(right(until(time(i), end_time(i)), width))
      call lines%append_line(right(fixed(energy_before(i)), 16)//right(fixed(energy_after(i)), 16)// &
                             right(fixed(momentum_before(i)), 17)//right(fixed(momentum_after(i)), 16))
    end do
    if (size(result%events) > shown_events) then
      call lines%append_line('  ...     '//text_of(size(result%events))//' in the file')
    end if
  end subroutine report_events

  pure function until(time, end_time) result(text)
    !! The end of an event; nothing where it takes no time.
    real(dp), intent(in) :: time, end_time        !! s
    character(:), allocatable :: text
    text = ''
    if (end_time > time) text = shortest(end_time, 7)
  end function until

  subroutine report_histories(result, lines)
    !! The largest displacement at each point, and how far it may be from the answer of infinitely many modes.
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    real(dp) :: peak
    integer :: p
    associate (response => result%response)
      if (response%finite_samples == 0) return     ! a note says why
      call lines%append_line('')
      call lines%append_line('  Displacement from '//text_of(result%mode_count)//' modes')
      do p = 1, min(shown_points, size(response%displacement, 2))
        peak = maxval(abs(response%displacement(:response%finite_samples, p)))
        call lines%append('  point'//right(text_of(p), 4)//': largest '//shortest(peak, 6)//' m')
        if (allocated(response%displacement_error) .and. peak > 0.0_dp) call lines%append(', error about '// &
          shortest(response%displacement_error(p), 2)//' m or '//shortest(response%displacement_error(p)/peak, 2)// &
          ' of it')
        call lines%append_line('')
      end do
      if (size(response%displacement, 2) > shown_points) then
        call lines%append_line('  ...  '//text_of(size(response%displacement, 2))//' points in all')
      end if
    end associate
  end subroutine report_histories

  subroutine report_measured(result, lines)
    !! Waves found in the histories, with the bounds of their errors.
    type(case_result), intent(in) :: result
    type(text_builder), intent(inout) :: lines
    if (result%measured%peak_count == 0) return
    call lines%append_line('')
    call lines%append_line('  Measured in the tip and midpoint histories alone; +/- is a bound of the error')
    call lines%append_line('  peak   frequency          +/-  wave number  phase velocity  group velocity')
    call lines%append_line('             rad/s        rad/s          1/m             m/s             m/s')
    call report_columns(lines, shown_peaks, &
                        named_value(result, 'measured_angular_frequency'), &
                        named_value(result, 'measured_angular_frequency_error'), &
                        named_value(result, 'measured_wavenumber'), &
                        named_value(result, 'measured_phase_velocity'), &
                        named_value(result, 'measured_group_velocity'))
  end subroutine report_measured

  pure function notes_report(notes) result(text)
    !! The notes as they stand in the file, one to a line, indented and marked.
    character(*), intent(in) :: notes             !! lines
    character(:), allocatable :: text
    type(string), allocatable :: lines(:)
    integer :: i
    text = ''
    lines = lines_of(notes)
    do i = 1, size(lines)
      text = text//'  note: '//lines(i)%text//new_line('a')
    end do
  end function notes_report

  pure function stage_table(watch, elapsed, processes, cases) result(text)
    !! Stages are summed over processes; the last line is the run as a whole.
    type(stopwatch), intent(in) :: watch
    real(dp), intent(in) :: elapsed               !! wall time from the first case to the result, s
    integer, intent(in) :: processes
    integer(i8), intent(in) :: cases              !! done in this run
    character(:), allocatable :: text
    type(text_builder) :: lines
    real(dp) :: wall, remainder
    integer :: i
    wall = max(elapsed*processes, sum(watch%seconds), tiny(1.0_dp))
    call lines%append_line('  stage           wall       CPU   share     calls   cases/s')
    do i = 1, stage_count
      if (watch%calls(i) < 1.0_dp) cycle          ! nothing of the kind is in this scene
      call lines%append_line(stage_row(stage_words(i), watch%seconds(i), watch%cpu(i), wall, nint(watch%calls(i), i8)))
    end do
    remainder = wall - sum(watch%seconds)
    if (nint(100.0_dp*remainder/wall) > 0) call lines%append_line(other_row(remainder, wall))
    call lines%append_line(stage_row('elapsed', elapsed, sum(watch%cpu), elapsed, cases))
    if (processes > 1) call lines%append_line('  '//text_of(processes)//' processes; stages are their sums, and shares '// &
                                              'those of '//seconds_text(wall))
    text = lines%text()
  end function stage_table

  pure function other_row(seconds, whole) result(text)
    !! The line of the time that is in none of the stages: making scenes of cases, handing them out, waiting.
    real(dp), intent(in) :: seconds, whole        !! as those of `stage_row`
    character(:), allocatable :: text
    text = '  other   '//right(seconds_text(seconds), 12)//right(text_of(nint(100.0_dp*seconds/whole))//' %', 18)
  end function other_row

  pure function stage_row(name, seconds, cpu, whole, calls) result(text)
    !! The line of a stage.
    character(*), intent(in) :: name
    real(dp), intent(in) :: seconds, cpu
    real(dp), intent(in) :: whole                 !! of which `seconds` is the share, s
    integer(i8), intent(in) :: calls
    character(:), allocatable :: text
    text = '  '//name//repeat(' ', 8 - len(name))//right(seconds_text(seconds), 12)//right(seconds_text(cpu), 10)// &
      right(text_of(nint(100.0_dp*seconds/max(whole, tiny(1.0_dp))))//' %', 8)//right(text_of(calls), 10)// &
      right(shortest(real(calls, dp)/max(seconds, 1.0e-9_dp), 3), 10)
  end function stage_row

end module bw_report
