module bw_stopwatch
  !! Wall and processor time of the stages of a run.
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: wall_seconds

  integer, parameter, public :: stage_modes = 1, stage_events = 2, stage_response = 3, stage_spectrum = 4, stage_write = 5
  integer, parameter, public :: stage_count = 5
  character(*), parameter, public :: stage_words(stage_count) = &
    [character(8) :: 'modes', 'events', 'response', 'spectrum', 'write']

  type, public :: stopwatch
    !! By stage, summed over cases.
    real(dp) :: seconds(stage_count) = 0.0_dp     !! wall time, s
    real(dp) :: cpu(stage_count) = 0.0_dp         !! processor time, s
    real(dp) :: calls(stage_count) = 0.0_dp
    real(dp), private :: last = 0.0_dp, last_cpu = 0.0_dp
  contains
    procedure :: start
    procedure :: lap
    procedure :: rebook
    procedure :: totals
    procedure :: set_totals
  end type stopwatch

contains

  real(dp) function wall_seconds()
    !! A clock that only runs forward, s.
    integer(i8) :: count, rate
    call system_clock(count, rate)
    wall_seconds = real(count, dp)/real(rate, dp)
  end function wall_seconds

  subroutine start(self)
    class(stopwatch), intent(inout) :: self
    self%last = wall_seconds()
    call cpu_time(self%last_cpu)
  end subroutine start

  subroutine lap(self, stage)
    !! Book the time since `start` or the last `lap` on a stage.
    class(stopwatch), intent(inout) :: self
    integer, intent(in) :: stage          !! one of this module's stage numbers
    real(dp) :: now, cpu
    now = wall_seconds()
    call cpu_time(cpu)
    self%seconds(stage) = self%seconds(stage) + (now - self%last)
    self%cpu(stage) = self%cpu(stage) + (cpu - self%last_cpu)
    self%calls(stage) = self%calls(stage) + 1.0_dp
    self%last = now
    self%last_cpu = cpu
  end subroutine lap

  pure subroutine rebook(self, from, to, seconds)
    !! Book seconds of one stage on another: what was done within it belongs there.
    class(stopwatch), intent(inout) :: self
    integer, intent(in) :: from, to
    real(dp), intent(in) :: seconds
    real(dp) :: cpu
    self%seconds(from) = self%seconds(from) - seconds
    self%seconds(to) = self%seconds(to) + seconds
    cpu = min(seconds, self%cpu(from))
    self%cpu(from) = self%cpu(from) - cpu
    self%cpu(to) = self%cpu(to) + cpu
  end subroutine rebook

  pure function totals(self) result(values)
    !! All that was booked, as numbers that can be summed over processes.
    class(stopwatch), intent(in) :: self
    real(dp) :: values(3*stage_count)
    values = [self%seconds, self%cpu, self%calls]
  end function totals

  pure subroutine set_totals(self, values)
    !! Take sums of `totals` for what was booked.
    class(stopwatch), intent(inout) :: self
    real(dp), intent(in) :: values(3*stage_count)
    self%seconds = values(:stage_count)
    self%cpu = values(stage_count + 1:2*stage_count)
    self%calls = values(2*stage_count + 1:)
  end subroutine set_totals

end module bw_stopwatch
