module bw_stage_report
  !! Where the time of a run went: a line for a short run, a table for a long one.
  use bw_columns, only: right, seconds_text
  use bw_kinds, only: dp, i8
  use bw_stopwatch, only: stage_count, stage_words, stopwatch
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: stage_report

  real(dp), parameter :: short = 1.0_dp           !! s, of a run whose stages are told in one line
  real(dp), parameter :: told = 0.01_dp           !! of such a run, that a stage must take to be told
  real(dp), parameter :: least = 5.0e-4_dp        !! s, which are told as 1 ms

contains

  pure function stage_report(watch, elapsed, processes, cases) result(text)
    !! Stages are summed over processes; the last line is the run as a whole.
    type(stopwatch), intent(in) :: watch
    real(dp), intent(in) :: elapsed               !! wall time from the first case to the result, s
    integer, intent(in) :: processes
    integer(i8), intent(in) :: cases              !! done in this run
    character(:), allocatable :: text
    if (elapsed < short .and. processes == 1) then
      text = stage_line(watch, elapsed)
    else
      text = stage_table(watch, elapsed, processes, cases)
    end if
  end function stage_report

  pure function stage_line(watch, elapsed) result(text)
    !! The stages that took most of a short run.
    type(stopwatch), intent(in) :: watch
    real(dp), intent(in) :: elapsed
    character(:), allocatable :: text
    character(1) :: comma
    integer :: i
    text = '  time       '//seconds_text(elapsed)
    comma = ':'
    do i = 1, stage_count
      if (watch%seconds(i) < max(told*elapsed, least)) cycle
      text = text//comma//' '//trim(stage_words(i))//' '//seconds_text(watch%seconds(i))
      comma = ','
    end do
    text = text//new_line('a')
  end function stage_line

  pure function stage_table(watch, elapsed, processes, cases) result(text)
    !! All stages, with what is in none of them. Only several cases have a rate.
    type(stopwatch), intent(in) :: watch
    real(dp), intent(in) :: elapsed
    integer, intent(in) :: processes
    integer(i8), intent(in) :: cases
    character(:), allocatable :: text
    type(text_builder) :: lines
    real(dp) :: wall, remainder
    integer :: i
    wall = max(elapsed*processes, sum(watch%seconds), tiny(1.0_dp))
    call lines%append_line('  stage           wall       CPU   share     calls'//repeat('   cases/s', merge(1, 0, cases > 1)))
    do i = 1, stage_count
      if (watch%calls(i) < 1.0_dp) cycle          ! nothing of the kind is in this scene
      call lines%append_line(stage_row(stage_words(i), watch%seconds(i), watch%cpu(i), wall, nint(watch%calls(i), i8), cases > 1))
    end do
    remainder = wall - sum(watch%seconds)
    if (nint(100.0_dp*remainder/wall) > 0) call lines%append_line(other_row(remainder, wall))
    call lines%append_line(stage_row('elapsed', elapsed, sum(watch%cpu), elapsed, cases, cases > 1))
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

  pure function stage_row(name, seconds, cpu, whole, calls, rated) result(text)
    !! The line of a stage.
    character(*), intent(in) :: name
    real(dp), intent(in) :: seconds, cpu
    real(dp), intent(in) :: whole                 !! of which `seconds` is the share, s
    integer(i8), intent(in) :: calls
    logical, intent(in) :: rated                  !! with calls in a second
    character(:), allocatable :: text
    text = '  '//name//repeat(' ', 8 - len(name))//right(seconds_text(seconds), 12)//right(seconds_text(cpu), 10)// &
      right(text_of(nint(100.0_dp*seconds/max(whole, tiny(1.0_dp))))//' %', 8)//right(text_of(calls), 10)
    if (rated) text = text//right(shortest(real(calls, dp)/max(seconds, 1.0e-9_dp), 3), 10)
  end function stage_row

end module bw_stage_report
