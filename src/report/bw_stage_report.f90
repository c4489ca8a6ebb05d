module bw_stage_report
  !! The run time by stage.
  use bw_columns, only: seconds_text
  use bw_kinds, only: dp, i8
  use bw_stopwatch, only: stage_count, stage_words, stopwatch
  use bw_text, only: shortest, text_of
  implicit none (type, external)
  private
  public :: stage_report

  real(dp), parameter :: told = 0.01_dp           !! least fraction of a run for a stage to be named
  real(dp), parameter :: least = 5.0e-4_dp        !! s, printed as 1 ms

contains

  pure function stage_report(watch, elapsed, processes, cases) result(text)
    !! Name the stages that took most of a run, summed over processes.
    type(stopwatch), intent(in) :: watch
    real(dp), intent(in) :: elapsed               !! wall time from the first case to the result, s
    integer, intent(in) :: processes
    integer(i8), intent(in) :: cases              !! done in this run
    character(:), allocatable :: text
    character(1) :: comma
    integer :: i
    text = '  time       '//seconds_text(elapsed)
    if (processes > 1) text = text//' on '//text_of(processes)//' processes, over which the stages are summed'
    if (cases > 1) text = text//', '//shortest(real(cases, dp)/max(elapsed, 1.0e-9_dp), 3)//' cases/s'
    comma = ':'
    do i = 1, stage_count
      if (watch%seconds(i) < max(told*elapsed, least)) cycle
      text = text//comma//' '//trim(stage_words(i))//' '//seconds_text(watch%seconds(i))
      comma = ','
    end do
    text = text//new_line('a')
  end function stage_report

end module bw_stage_report
