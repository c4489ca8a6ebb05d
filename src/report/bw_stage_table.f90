module bw_stage_table
  !! The printed table of stages: where the time went, and how many cases came of it.
  use bw_columns, only: right, seconds_text
  use bw_kinds, only: dp, i8
  use bw_stopwatch, only: stage_count, stage_words, stopwatch
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: stage_table

contains

  pure function stage_table(watch, elapsed, processes, cases) result(text)
    !! Stages are summed over processes; the last line is the run as a whole.
    type(stopwatch), intent(in) :: watch
    real(dp), intent(in) :: elapsed               !! wall time from the first case to the result, s
    integer, intent(in) :: processes
    integer(i8), intent(in) :: cases              !! done in this run
    character(:), allocatable :: text
    type(text_builder) :: lines
    real(dp) :: wall, rest
    integer :: i
    wall = max(elapsed*processes, sum(watch%seconds), tiny(1.0_dp))
    call lines%append_line('  stage           wall       CPU   share     calls   cases/s')
    do i = 1, stage_count
      if (watch%calls(i) < 1.0_dp) cycle          ! nothing of the kind is in this scene
      call lines%append_line(row(stage_words(i), watch%seconds(i), watch%cpu(i), wall, nint(watch%calls(i), i8)))
    end do
    rest = wall - sum(watch%seconds)
    if (nint(100.0_dp*rest/wall) > 0) call lines%append_line(others(rest, wall))
    call lines%append_line(row('elapsed', elapsed, sum(watch%cpu), elapsed, cases))
    if (processes > 1) call lines%append_line('  '//text_of(processes)//' processes; stages are their sums, and shares '// &
                                              'those of '//seconds_text(wall))
    text = lines%text()
  end function stage_table

  pure function others(seconds, whole) result(text)
    !! What is none of the stages: making scenes of cases, handing them out, waiting.
    real(dp), intent(in) :: seconds, whole        !! as those of `row`
    character(:), allocatable :: text
    text = '  other   '//right(seconds_text(seconds), 12)//right(text_of(nint(100.0_dp*seconds/whole))//' %', 18)
  end function others

  pure function row(name, seconds, cpu, whole, calls) result(text)
    character(*), intent(in) :: name
    real(dp), intent(in) :: seconds, cpu
    real(dp), intent(in) :: whole                 !! of which `seconds` is the share, s
    integer(i8), intent(in) :: calls
    character(:), allocatable :: text
    text = '  '//name//repeat(' ', 8 - len(name))//right(seconds_text(seconds), 12)//right(seconds_text(cpu), 10)// &
      right(text_of(nint(100.0_dp*seconds/max(whole, tiny(1.0_dp))))//' %', 8)//right(text_of(calls), 10)// &
      right(shortest(real(calls, dp)/max(seconds, 1.0e-9_dp), 3), 10)
  end function row

end module bw_stage_table
