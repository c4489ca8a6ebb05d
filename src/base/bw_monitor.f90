module bw_monitor
  !! How long work tells of its progress and learns that it should stop, without knowing who listens.
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private
  public :: stops

  type, abstract, public :: monitor_type
  contains
    procedure(advance_interface), deferred :: advance
    procedure(stop_interface), deferred :: stop_requested
    procedure :: enter => enter_nothing
  end type monitor_type

  abstract interface
    subroutine advance_interface(self, fraction)
      !! Called now and then with the finished part, 0 … 1, of the case at hand.
      import :: monitor_type, dp
      class(monitor_type), intent(inout) :: self
      real(dp), intent(in) :: fraction
    end subroutine advance_interface

    logical function stop_interface(self)
      !! True when the work at hand should be left as it is: a signal came, or time is up.
      import :: monitor_type
      class(monitor_type), intent(inout) :: self
    end function stop_interface
  end interface

  type, abstract, extends(monitor_type), public :: progress_type
    !! A monitor that also follows a scene from case to case.
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
      integer(i8), intent(in) :: cases          !! how many it has
      integer(i8), intent(in) :: finished       !! how many an earlier run had finished
    end subroutine begin_interface

    subroutine cases_interface(self, count)
      import :: progress_type, i8
      class(progress_type), intent(inout) :: self
      integer(i8), intent(in) :: count          !! cases that have been finished since the last call
    end subroutine cases_interface

    subroutine end_interface(self)
      !! Called when no more is to come of the scene.
      import :: progress_type
      class(progress_type), intent(inout) :: self
    end subroutine end_interface
  end interface

  type, extends(monitor_type), public :: silent_monitor
    !! Listens to nothing and never stops.
  contains
    procedure :: advance => ignore
    procedure :: stop_requested => never
  end type silent_monitor

  type, extends(monitor_type), public :: part_monitor
    !! For a part of a case: passes on how much of the whole is done.
    class(monitor_type), pointer :: whole => null()
    real(dp) :: start = 0.0_dp       !! what was done before this part, 0 … 1
    real(dp) :: share = 1.0_dp       !! how much of the whole this part is, 0 … 1
  contains
    procedure :: advance => advance_whole
    procedure :: stop_requested => ask_whole
    procedure :: enter => enter_of_whole
  end type part_monitor

contains

  logical function stops(monitor)
    !! The monitor asks to stop; an absent one never does.
    class(monitor_type), intent(inout), optional :: monitor
    stops = .false.
    if (present(monitor)) stops = monitor%stop_requested()
  end function stops

  subroutine enter_nothing(self, stage)
    !! A stage of the work on a case begins; most monitors do not care which.
    class(monitor_type), intent(inout) :: self
    character(*), intent(in) :: stage
    associate (unused => self, unused_too => stage)
    end associate
  end subroutine enter_nothing

  recursive subroutine enter_of_whole(self, stage)      ! as `advance_whole`
    !! The whole's monitor hears of it.
    class(part_monitor), intent(inout) :: self
    character(*), intent(in) :: stage
    call self%whole%enter(stage)
  end subroutine enter_of_whole

  recursive subroutine advance_whole(self, fraction)    ! the whole may be a part itself
    !! The finished fraction of the part, as a fraction of the whole.
    class(part_monitor), intent(inout) :: self
    real(dp), intent(in) :: fraction
    call self%whole%advance(self%start + self%share*fraction)
  end subroutine advance_whole

  recursive logical function ask_whole(self)
    !! What the whole's monitor says.
    class(part_monitor), intent(inout) :: self
    ask_whole = self%whole%stop_requested()
  end function ask_whole

  subroutine ignore(self, fraction)
    !! Nobody listens.
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
