module bw_monitor
  !! Monitors, through which long work reports its progress and learns that it should stop, whoever listens.
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: stops

  integer, parameter, public :: between_questions = 64   !! steps of up to some µs between questions whether to stop

  type, abstract, public :: monitor_type
  contains
    procedure(advance_interface), deferred :: advance
    procedure(stop_interface), deferred :: stop_requested
    procedure :: enter => enter_nothing
  end type monitor_type

  abstract interface
    subroutine advance_interface(self, fraction)
      !! Called regularly with the finished fraction, 0 … 1, of the present case.
      import :: monitor_type, dp
      class(monitor_type), intent(inout) :: self
      real(dp), intent(in) :: fraction
    end subroutine advance_interface

    logical function stop_interface(self)
      !! Returns true if the work should be abandoned: a signal came, or time is up.
      import :: monitor_type
      class(monitor_type), intent(inout) :: self
    end function stop_interface
  end interface

  type, abstract, extends(monitor_type), public :: progress_type
    !! A monitor that also follows the cases of a scene.
  contains
    procedure(begin_interface), deferred :: begin
    procedure(cases_interface), deferred :: cases_done
    procedure(end_interface), deferred :: end
  end type progress_type

  abstract interface
    subroutine begin_interface(self, name, cases, finished)
      !! Called before the first case of a scene.
      import :: progress_type, i8
      class(progress_type), intent(inout) :: self
      character(*), intent(in) :: name          !! of the scene
      integer(i8), intent(in) :: cases          !! their number
      integer(i8), intent(in) :: finished       !! by earlier runs
    end subroutine begin_interface

    subroutine cases_interface(self, count)
      import :: progress_type, i8
      class(progress_type), intent(inout) :: self
      integer(i8), intent(in) :: count          !! cases finished since the last call
    end subroutine cases_interface

    subroutine end_interface(self)
      !! Called at the end of a scene.
      import :: progress_type
      class(progress_type), intent(inout) :: self
    end subroutine end_interface
  end interface

  type, extends(monitor_type), public :: silent_monitor
    !! A monitor that shows nothing and never stops.
  contains
    procedure :: advance => ignore
    procedure :: stop_requested => never
  end type silent_monitor

  type, extends(monitor_type), public :: part_monitor
    !! A monitor of a part of a case: converts its progress to that of the whole.
    class(monitor_type), pointer :: whole => null()
    real(dp) :: start = 0.0_dp       !! fraction of the whole done before this part, 0 … 1
    real(dp) :: share = 1.0_dp       !! this part as a fraction of the whole, 0 … 1
  contains
    procedure :: advance => advance_whole
    procedure :: stop_requested => ask_whole
    procedure :: enter => enter_of_whole
  end type part_monitor

contains

  logical function stops(monitor)
    !! Return whether the monitor asks to stop; an absent one never does.
    class(monitor_type), intent(inout), optional :: monitor
    stops = .false.
    if (present(monitor)) stops = monitor%stop_requested()
  end function stops

  subroutine enter_nothing(self, stage)
    !! Begin a stage of a case; most monitors ignore it.
    class(monitor_type), intent(inout) :: self
    character(*), intent(in) :: stage
    associate (unused => self, unused_too => stage)
    end associate
  end subroutine enter_nothing

  recursive subroutine enter_of_whole(self, stage)      ! as `advance_whole`
    !! Pass the stage to the monitor of the whole.
    class(part_monitor), intent(inout) :: self
    character(*), intent(in) :: stage
    call self%whole%enter(stage)
  end subroutine enter_of_whole

  recursive subroutine advance_whole(self, fraction)    ! the whole may be a part itself
    !! Convert the finished fraction of the part to that of the whole.
    class(part_monitor), intent(inout) :: self
    real(dp), intent(in) :: fraction
    call self%whole%advance(self%start + self%share*fraction)
  end subroutine advance_whole

  recursive logical function ask_whole(self)
    !! Ask the monitor of the whole.
    class(part_monitor), intent(inout) :: self
    ask_whole = self%whole%stop_requested()
  end function ask_whole

  subroutine ignore(self, fraction)
    !! Ignore the progress.
    class(silent_monitor), intent(inout) :: self
    real(dp), intent(in) :: fraction
    associate (unused => self, unused_too => fraction)
    end associate
  end subroutine ignore

  logical function never(self)
    !! Never asks to stop.
    class(silent_monitor), intent(inout) :: self
    associate (unused => self)
    end associate
    never = .false.
  end function never

end module bw_monitor
