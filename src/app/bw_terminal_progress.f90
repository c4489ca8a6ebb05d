module bw_terminal_progress
  !! Progress on standard error: a bar on a terminal if a run takes longer than a second, lines in a log, or JSON lines
  !! for a program; and requests to stop after a signal or when the time limit is reached.
  use bw_descriptors, only: is_terminal, standard_error, write_text
  use bw_json, only: json_member, json_number, json_text
  use bw_kinds, only: dp, i8
  use bw_monitor, only: progress_type
  use bw_process, only: stop_asked
  use bw_stopwatch, only: wall_seconds
  use bw_text, only: printable, shortest, text_of
  implicit none (type, external)
  private
  public :: duration_text, terminal_progress_to

  real(dp), parameter :: quiet_seconds = 1.0_dp       !! shorter runs show nothing
  real(dp), parameter :: terminal_interval = 0.1_dp   !! s between two updates of the bar
  real(dp), parameter :: log_interval = 5.0_dp        !! s between two lines of a log
  real(dp), parameter :: program_interval = 1.0_dp    !! s between two lines for a program
  real(dp), parameter :: least_part = 0.01_dp         !! of a single case, done before the remaining time is estimated
  integer, parameter :: bar_width = 30

  type, extends(progress_type), public :: terminal_progress
    private
    character(:), allocatable :: name                 !! of the scene; nothing is shown without a name
    integer(i8) :: cases = 1, done = 0, taken_over = 0
    real(dp) :: reached = 0.0_dp                      !! largest fraction of the present case so far
    real(dp) :: started = 0.0_dp, shown = 0.0_dp
    real(dp) :: deadline = huge(1.0_dp)               !! on the clock of `wall_seconds`
    character(:), allocatable :: stage                !! of the present case
    logical :: json = .false.                         !! as JSON lines
    logical :: quiet = .false.
    logical :: on_terminal = .false.
    logical :: bar_stands = .false.                   !! a bar is displayed
  contains
    procedure :: begin
    procedure :: cases_done
    procedure :: end => end_scene
    procedure :: advance
    procedure :: enter
    procedure :: stop_requested
  end type terminal_progress

contains

  type(terminal_progress) function terminal_progress_to(deadline, quiet, json) result(progress)
    !! Return a progress that requests a stop at a deadline.
    real(dp), intent(in) :: deadline                  !! on the clock of `wall_seconds`
    logical, intent(in) :: quiet
    logical, intent(in), optional :: json             !! as JSON lines; absent: for people
    if (present(json)) progress%json = json
    progress%deadline = deadline
    progress%quiet = quiet
    progress%on_terminal = is_terminal(standard_error)
  end function terminal_progress_to

  subroutine begin(self, name, cases, finished)
    !! Begin to show the progress of a scene.
    class(terminal_progress), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(in) :: cases, finished
    self%name = name
    self%cases = cases
    self%done = finished
    self%taken_over = finished
    self%reached = 0.0_dp
    self%started = wall_seconds()
    self%shown = self%started
    self%stage = ''
    if (self%json .and. .not. self%quiet) call tell(self, 'begin', 0.0_dp, self%started)
  end subroutine begin

  subroutine cases_done(self, count)
    !! Count finished cases.
    class(terminal_progress), intent(inout) :: self
    integer(i8), intent(in) :: count
    self%done = self%done + count
    self%reached = 0.0_dp
    call self%advance(0.0_dp)
  end subroutine cases_done

  subroutine advance(self, fraction)
    !! Show the progress, unless shown a moment ago. It never goes back when estimates change.
    class(terminal_progress), intent(inout) :: self
    real(dp), intent(in) :: fraction
    real(dp) :: now, interval
    self%reached = max(self%reached, fraction)
    if (self%quiet .or. .not. allocated(self%name)) return
    now = wall_seconds()
    if (self%json) then
      if (now - self%shown >= program_interval) call tell(self, 'progress', self%reached, now)
      return
    end if
    if (now - self%started < quiet_seconds) return
    interval = merge(terminal_interval, log_interval, self%on_terminal)
    if (now - self%shown < interval) return
    self%shown = now
    call show(self, self%reached, now)
  end subroutine advance

  subroutine enter(self, stage)
    !! Store the present stage of a case.
    class(terminal_progress), intent(inout) :: self
    character(*), intent(in) :: stage
    self%stage = stage
  end subroutine enter

  subroutine tell(self, event, fraction, now)
    !! Write a JSON line.
    class(terminal_progress), intent(inout) :: self
    character(*), intent(in) :: event                 !! `begin`, `progress` or `end`
    real(dp), intent(in) :: fraction, now
    character(:), allocatable :: stage
    integer :: ignored
    self%shown = now
    stage = 'null'
    if (self%stage /= '' .and. event == 'progress') stage = json_text(self%stage)
    ignored = write_text(standard_error, '{"event": '//json_text(event)//json_member('scene', json_text(self%name))// &
      json_member('done', text_of(self%done))//json_member('cases', text_of(self%cases))// &
      json_member('part', json_number(min(1.0_dp, (real(self%done, dp) + fraction)/real(self%cases, dp))))// &
      json_member('seconds', json_number(now - self%started))//json_member('stage', stage)//'}'//new_line('a'))
  end subroutine tell

  subroutine show(self, fraction, now)
    !! Draw the bar, or write a log line: the fraction done, cases per second, the time left. The search for lines in a spectrum
    !! counts rounds, which take different times, so that before the first case is done nothing tells how long it takes.
    class(terminal_progress), intent(inout) :: self
    real(dp), intent(in) :: fraction, now
    real(dp) :: part, new_part
    character(:), allocatable :: line
    integer :: filled
    integer :: ignored
    part = (real(self%done, dp) + fraction)/real(self%cases, dp)
    new_part = (real(self%done - self%taken_over, dp) + fraction)/real(self%cases, dp)
    line = printable(self%name)//'  '//text_of(nint(100.0_dp*part))//' %'
    if (self%cases > 1) line = line//'  case '//text_of(self%done)//' of '//text_of(self%cases)
    if (self%cases > 1 .and. self%done > self%taken_over) line = line//'  '// &
      shortest(real(self%done - self%taken_over, dp)/(now - self%started), 3)//' cases/s'
    if (new_part > merge(least_part, 0.0_dp, self%cases == 1) .and. part < 1 .and. &
        (self%done > self%taken_over .or. self%stage /= 'spectrum')) line = line//'  '// &
      duration_text((now - self%started)*(1.0_dp - part)/new_part)//' left'
    if (self%on_terminal) then
      filled = min(bar_width, int(bar_width*part))
      line = achar(13)//'['//repeat('#', filled)//repeat('.', bar_width - filled)//'] '//line//achar(27)//'[K'
      self%bar_stands = .true.
    else
      line = line//new_line('a')
    end if
    ignored = write_text(standard_error, line)
  end subroutine show

  pure function duration_text(seconds) result(text)
    !! Format seconds as coarsely as an estimate deserves.
    real(dp), intent(in) :: seconds
    character(:), allocatable :: text
    if (seconds < 1.0_dp) then
      text = text_of(max(1, nint(1000.0_dp*seconds)))//' ms'
    else if (seconds < 120.0_dp) then
      text = text_of(ceiling(seconds))//' s'
    else if (seconds < 7200.0_dp) then
      text = text_of(ceiling(seconds/60.0_dp))//' min'
    else
      text = text_of(ceiling(min(seconds, 1.0e9_dp)/3600.0_dp))//' h'
    end if
  end function duration_text

  subroutine end_scene(self)
    !! Remove the bar; nothing is shown until the next scene begins.
    class(terminal_progress), intent(inout) :: self
    integer :: ignored
    if (self%json .and. .not. self%quiet .and. allocated(self%name)) call tell(self, 'end', self%reached, wall_seconds())
    if (allocated(self%name)) deallocate (self%name)
    if (.not. self%bar_stands) return
    ignored = write_text(standard_error, achar(13)//achar(27)//'[K')
    self%bar_stands = .false.
  end subroutine end_scene

  logical function stop_requested(self)
    !! Return whether a signal came, or the time or the deadline has passed.
    class(terminal_progress), intent(inout) :: self
    stop_requested = stop_asked()
    if (.not. stop_requested .and. self%deadline < huge(1.0_dp)) stop_requested = wall_seconds() >= self%deadline
  end function stop_requested

end module bw_terminal_progress
