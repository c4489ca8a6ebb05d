module bw_stopwatch
  !! Wall time of the stages of a run.
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: wall_seconds

  integer, parameter, public :: stage_modes = 1, stage_events = 2, stage_response = 3, stage_spectrum = 4, stage_write = 5
  integer, parameter, public :: stage_count = 5
  character(*), parameter, public :: stage_words(stage_count) = &
    [character(8) :: 'modes', 'events', 'response', 'spectrum', 'write']

  type, public :: stopwatch
    !! Seconds by stage, summed over cases.
    real(dp) :: seconds(stage_count) = 0.0_dp
    real(dp), private :: last = 0.0_dp
  contains
    procedure :: start
    procedure :: lap
    procedure :: rebook
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
  end subroutine start

  subroutine lap(self, stage)
    !! Book the time since `start` or the last `lap` on a stage.
    class(stopwatch), intent(inout) :: self
    integer, intent(in) :: stage          !! one of this module's stage numbers
    real(dp) :: now
    now = wall_seconds()
    self%seconds(stage) = self%seconds(stage) + (now - self%last)
    self%last = now
  end subroutine lap

  pure subroutine rebook(self, from, to, seconds)
    !! Book seconds of one stage on another: what was done within it belongs there.
    class(stopwatch), intent(inout) :: self
    integer, intent(in) :: from, to
    real(dp), intent(in) :: seconds
    self%seconds(from) = self%seconds(from) - seconds
    self%seconds(to) = self%seconds(to) + seconds
  end subroutine rebook

end module bw_stopwatch
