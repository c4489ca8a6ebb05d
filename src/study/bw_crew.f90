module bw_crew
  !! The processes that share the cases of a scene, as seen from one of them. One of them leads: it speaks, hands out, and
  !! writes the result.
  use bw_case_queue, only: case_queue
  use bw_error, only: error_type
  use bw_kinds, only: dp, i8
  implicit none (type, external)
  private

  type, abstract, public :: crew_type
    integer :: number = 0                   !! of this process; 0 leads
    integer :: processes = 1
    logical :: near_leader = .true.         !! this process runs on the leader's machine: both see a file alike at any moment
  contains
    procedure :: leads
    procedure(join_interface), deferred :: join
    procedure(join_interface), deferred :: part
    procedure(agree_interface), deferred :: agree
    procedure(begin_interface), deferred :: begin
    procedure(next_interface), deferred :: next
    procedure(done_interface), deferred :: case_done
    procedure(attend_interface), deferred :: attend
    procedure(stop_interface), deferred :: stop
    procedure(stopped_interface), deferred :: stopped
    procedure(end_interface), deferred :: end
  end type crew_type

  abstract interface
    subroutine join_interface(self)
      !! `join`: the first call of all, sets what stands above. `part`: the last.
      import :: crew_type
      implicit none (type, external)
      class(crew_type), intent(inout) :: self
    end subroutine join_interface

    subroutine agree_interface(self, value)
      !! All get the leader's value. Called by all.
      import :: crew_type
      implicit none (type, external)
      class(crew_type), intent(inout) :: self
      integer, intent(inout) :: value
    end subroutine agree_interface

    subroutine begin_interface(self, queue)
      !! Work begins on the leader's queue. Called by all.
      import :: crew_type, case_queue
      implicit none (type, external)
      class(crew_type), intent(inout) :: self
      type(case_queue), intent(in) :: queue          !! of the leader; others pass an empty one
    end subroutine begin_interface

    subroutine next_interface(self, first, last)
      !! The cases to do next; `first > last` where there are none.
      import :: crew_type, i8
      implicit none (type, external)
      class(crew_type), intent(inout) :: self
      integer(i8), intent(out) :: first, last
    end subroutine next_interface

    subroutine done_interface(self)
      !! A case is done.
      import :: crew_type
      implicit none (type, external)
      class(crew_type), intent(inout) :: self
    end subroutine done_interface

    subroutine attend_interface(self, done)
      !! Answer the others. Called often, from within long cases too.
      import :: crew_type, i8
      implicit none (type, external)
      class(crew_type), intent(inout) :: self
      integer(i8), intent(out) :: done               !! cases that others have done since this was asked last
    end subroutine attend_interface

    subroutine stop_interface(self)
      !! Nothing more is to be handed out, to anybody.
      import :: crew_type
      implicit none (type, external)
      class(crew_type), intent(inout) :: self
    end subroutine stop_interface

    logical function stopped_interface(self)
      !! Whether somebody has called `stop`.
      import :: crew_type
      implicit none (type, external)
      class(crew_type), intent(in) :: self
    end function stopped_interface

    subroutine end_interface(self, totals, error)
      !! All have stopped working. Called by all; the leader gets the sums, and an error if anybody has one.
      import :: crew_type, dp, error_type
      implicit none (type, external)
      class(crew_type), intent(inout) :: self
      real(dp), intent(inout) :: totals(:)
      type(error_type), allocatable, intent(inout) :: error
    end subroutine end_interface
  end interface

contains

  pure logical function leads(self)
    class(crew_type), intent(in) :: self
    leads = self%number == 0
  end function leads

end module bw_crew
