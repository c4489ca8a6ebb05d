module bw_stage_report
  !! The run time by stage: a line, and for a long run a table as a detail.
  use bw_columns, only: seconds_text, table_of, text_table
  use bw_kinds, only: dp, i8
  use bw_screen, only: details
  use bw_stopwatch, only: stage_count, stage_words, stopwatch
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: stage_report

  real(dp), parameter :: short = 1.0_dp           !! s, of a run without a table
  real(dp), parameter :: least_share = 0.01_dp           !! least fraction of a run for a stage to be named in the line
  real(dp), parameter :: least = 5.0e-4_dp        !! s, printed as 1 ms

contains

  function stage_report(watch, elapsed, processes, cases) result(text)
    !! Report stages, summed over processes; the last line of the table is the whole run.
    type(stopwatch), intent(in) :: watch
    real(dp), intent(in) :: elapsed               !! wall time from the first case to the result, s
    integer, intent(in) :: processes
    integer(i8), intent(in) :: cases              !! done in this run
    character(:), allocatable :: text
    text = stage_line(watch, elapsed, processes, cases)
    if (elapsed >= short .or. processes > 1) text = text//details(stage_table(watch, elapsed, processes, cases))
  end function stage_report

  pure function stage_line(watch, elapsed, processes, cases) result(text)
    !! Name the stages that took most of a run.
    type(stopwatch), intent(in) :: watch
    real(dp), intent(in) :: elapsed
    integer, intent(in) :: processes
    integer(i8), intent(in) :: cases
    character(:), allocatable :: text
    character(1) :: comma
    integer :: i
    text = '  time       '//seconds_text(elapsed)
    if (processes > 1) text = text//' on '//text_of(processes)//' processes, over which the stages are summed'
    if (cases > 1) text = text//', '//shortest(real(cases, dp)/max(elapsed, 1.0e-9_dp), 3)//' cases/s'
    comma = ':'
    do i = 1, stage_count
      if (watch%seconds(i) < max(least_share*elapsed, least)) cycle
      text = text//comma//' '//trim(stage_words(i))//' '//seconds_text(watch%seconds(i))
      comma = ','
    end do
    text = text//new_line('a')
  end function stage_line

  function stage_table(watch, elapsed, processes, cases) result(text)
    !! Print all stages, and the remainder. Only several cases have a rate.
    type(stopwatch), intent(in) :: watch
    real(dp), intent(in) :: elapsed
    integer, intent(in) :: processes
    integer(i8), intent(in) :: cases
    character(:), allocatable :: text
    type(text_builder) :: lines
    type(text_table) :: table
    real(dp) :: wall, remainder
    integer :: i
    wall = max(elapsed*processes, sum(watch%seconds), tiny(1.0_dp))
    table = table_of('  stage|wall|CPU|share|calls|cases/s', '', [-10, 12, 10, 8, 10, 10], [(.true., i=1, 5), cases > 1])
    call table%put_head(lines)
    do i = 1, stage_count
      if (watch%calls(i) < 1.0_dp) cycle          ! the scene has no such stage
      call table%put_row(lines, stage_row(stage_words(i), watch%seconds(i), watch%cpu(i), wall, nint(watch%calls(i), i8)))
    end do
    remainder = wall - sum(watch%seconds)         ! outside all stages: making and distributing cases, waiting
    if (nint(100.0_dp*remainder/wall) > 0) call table%put_row(lines, '  other|'//seconds_text(remainder)//'||'// &
                                                              text_of(nint(100.0_dp*remainder/wall))//' %')
    call table%put_row(lines, stage_row('elapsed', elapsed, sum(watch%cpu), elapsed, cases))
    if (processes > 1) call lines%append_line('  '//text_of(processes)//' processes; stages are their sums, and shares '// &
                                              'those of '//seconds_text(wall))
    text = lines%text()
  end function stage_table

  pure function stage_row(name, seconds, cpu, whole, calls) result(cells)
    !! Return the cells of a stage.
    character(*), intent(in) :: name
    real(dp), intent(in) :: seconds, cpu
    real(dp), intent(in) :: whole                 !! total of which `seconds` is a share, s
    integer(i8), intent(in) :: calls
    character(:), allocatable :: cells
    cells = '  '//trim(name)//'|'//seconds_text(seconds)//'|'//seconds_text(cpu)//'|'// &
      text_of(nint(100.0_dp*seconds/max(whole, tiny(1.0_dp))))//' %|'//text_of(calls)//'|'// &
      shortest(real(calls, dp)/max(seconds, 1.0e-9_dp), 3)
  end function stage_row

end module bw_stage_report
