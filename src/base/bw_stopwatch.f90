module bw_stopwatch
  !! Run times: wall and processor time of the stages of a run, medians of repeated work, and the processor on which
  !! they were measured.
  use bw_kinds, only: dp, i8
  use bw_missing, only: missing
  implicit none (type, external)
  private
  public :: processor_name, wall_seconds

  integer, parameter, public :: stage_modes = 1, stage_events = 2, stage_response = 3, stage_spectrum = 4, stage_write = 5
  integer, parameter, public :: stage_count = 5
  character(*), parameter, public :: stage_words(stage_count) = &
    [character(8) :: 'modes', 'events', 'response', 'spectrum', 'write']

  type, public :: stopwatch
    !! Wall and processor time by stage, summed over cases.
    real(dp) :: seconds(stage_count) = 0.0_dp     !! wall time, s
    real(dp) :: cpu(stage_count) = 0.0_dp         !! processor time, s
    real(dp) :: calls(stage_count) = 0.0_dp
    real(dp), private :: last = 0.0_dp            ! of start and laps, on the clock of `wall_seconds`
    real(dp), private :: unshared(0:stage_count) = 0.0_dp
      ! wall time whose processor time is not recorded yet: of no stage, and of each
    real(dp), private :: shared_cpu = 0.0_dp      ! processor time of that
  contains
    procedure :: start
    procedure :: lap
    procedure :: rebook
    procedure :: totals
    procedure :: set_totals
  end type stopwatch

  real(dp), parameter :: short = 1.0e-3_dp        !! s: shorter stages share their processor time, which is slow to query

  type, public :: repeats_type
    !! Run times of repeated work: median and quartiles. On a busy machine single times may be far too long, but the
    !! median is robust.
    integer :: count = 0
    real(dp), allocatable :: seconds(:)           !! ascending, (count)
  contains
    procedure :: add
    procedure :: total
    procedure :: quantile
    procedure :: median
  end type repeats_type

contains

  real(dp) function wall_seconds()
    !! Return a monotonic clock, s.
    integer(i8) :: count, rate
    call system_clock(count, rate)
    wall_seconds = real(count, dp)/real(rate, dp)
  end function wall_seconds

  subroutine start(self)
    !! Start timing the stage that the next `lap` names.
    class(stopwatch), intent(inout) :: self
    call book(self, 0)
  end subroutine start

  subroutine lap(self, stage)
    !! Add the time since `start` or the last `lap` to a stage.
    class(stopwatch), intent(inout) :: self
    integer, intent(in) :: stage          !! one of this module's stage numbers
    real(dp) :: began
    began = self%last
    call book(self, stage)
    self%seconds(stage) = self%seconds(stage) + (self%last - began)
    self%calls(stage) = self%calls(stage) + 1.0_dp
  end subroutine lap

  subroutine book(self, stage)
    !! Add the time since the last call to a stage, or to none.
    class(stopwatch), intent(inout) :: self
    integer, intent(in) :: stage          !! 0: none
    real(dp) :: cpu, now
    now = wall_seconds()
    if (self%last > 0.0_dp) self%unshared(stage) = self%unshared(stage) + (now - self%last)
    if (self%last > 0.0_dp .and. sum(self%unshared) < short) then
      self%last = now
      return
    end if
    call cpu_time(cpu)
    if (self%last > 0.0_dp) self%cpu = self%cpu + (cpu - self%shared_cpu)*self%unshared(1:)/sum(self%unshared)
    self%unshared = 0.0_dp
    self%shared_cpu = cpu
    self%last = now
  end subroutine book

  pure subroutine rebook(self, from, to, seconds)
    !! Move seconds from one stage to another, within which work was done.
    class(stopwatch), intent(inout) :: self
    integer, intent(in) :: from, to
    real(dp), intent(in) :: seconds
    real(dp) :: cpu
    cpu = min(seconds, self%cpu(from))
    self%seconds([from, to]) = self%seconds([from, to]) + [-seconds, seconds]
    self%cpu([from, to]) = self%cpu([from, to]) + [-cpu, cpu]
  end subroutine rebook

  pure function totals(self) result(values)
    !! Return all times, as numbers that can be summed over processes.
    class(stopwatch), intent(in) :: self
    real(dp) :: values(3*stage_count)
    values = [self%seconds, self%cpu, self%calls]
  end function totals

  pure subroutine set_totals(self, values)
    !! Replace the times by sums of `totals`.
    class(stopwatch), intent(inout) :: self
    real(dp), intent(in) :: values(3*stage_count)
    self%seconds = values(:stage_count)
    self%cpu = values(stage_count + 1:2*stage_count)
    self%calls = values(2*stage_count + 1:)
  end subroutine set_totals

  pure subroutine add(self, seconds)
    !! Insert one more time in ascending order.
    class(repeats_type), intent(inout) :: self
    real(dp), intent(in) :: seconds
    integer :: below
    if (.not. allocated(self%seconds)) allocate (self%seconds(0))
    below = count(self%seconds < seconds)
    self%seconds = [self%seconds(:below), seconds, self%seconds(below + 1:)]
    self%count = self%count + 1
  end subroutine add

  pure real(dp) function total(self)
    !! Return the sum of all times, s.
    class(repeats_type), intent(in) :: self
    total = 0.0_dp
    if (self%count > 0) total = sum(self%seconds)
  end function total

  pure real(dp) function median(self)
    !! Return the median, s.
    class(repeats_type), intent(in) :: self
    median = self%quantile(0.5_dp)
  end function median

  pure real(dp) function quantile(self, fraction)
    !! Return a quantile of the times, s, linearly interpolated; missing if there are none.
    class(repeats_type), intent(in) :: self
    real(dp), intent(in) :: fraction         !! 0 … 1
    real(dp) :: place
    integer :: below
    quantile = missing
    if (self%count == 0) return
    place = 1.0_dp + fraction*(self%count - 1)
    below = min(int(place), self%count)
    quantile = self%seconds(below)
    if (below < self%count) quantile = quantile + (place - below)*(self%seconds(below + 1) - self%seconds(below))
  end function quantile

  function processor_name() result(name)
    !! Return the processor's model as Linux reports it, else 'unknown'.
    character(:), allocatable :: name
    character(200) :: line
    integer :: unit, stat
    name = 'unknown'
    open (newunit=unit, file='/proc/cpuinfo', status='old', action='read', iostat=stat)
    if (stat /= 0) return
    do
      read (unit, '(a)', iostat=stat) line
      if (stat /= 0) exit
      if (index(line, 'model name') /= 1) cycle
      name = trim(adjustl(line(index(line, ':') + 1:)))
      exit
    end do
    close (unit)
  end function processor_name

end module bw_stopwatch
