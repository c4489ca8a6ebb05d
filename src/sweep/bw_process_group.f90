module bw_process_group
  !! The processes that share the cases of a sweep, as seen from one of them. Each takes the next batch from a counter that all
  !! see; one of them leads: it speaks, and writes the result.
  use bw_error, only: error_type
  use bw_kinds, only: dp, i4, i8
  implicit none (type, external)
  private

  type, abstract, public :: process_group
    integer :: number = 0                   !! of this process; 0 leads
    integer :: processes = 1
  contains
    procedure :: leads
    procedure(join_interface), deferred :: join
    procedure(join_interface), deferred :: part
    procedure(share_interface), deferred :: share
    procedure(join_interface), deferred :: begin
    procedure(take_interface), deferred :: take
    procedure(tell_interface), deferred :: tell
    procedure(join_interface), deferred :: stop
    procedure(collect_interface), deferred :: collect
  end type process_group

  abstract interface
    subroutine join_interface(self)
      !! `join`: the first call of all, which sets what stands above. `part`: the last. `begin`: the counter stands before the
      !! first place, and nothing is done; called by all. `stop`: nothing more is to be taken, by anybody.
      import :: process_group
      implicit none (type, external)
      class(process_group), intent(inout) :: self
    end subroutine join_interface

    subroutine share_interface(self, values)
      !! All get the leader's values. Called by all.
      import :: process_group, i4
      implicit none (type, external)
      class(process_group), intent(inout) :: self
      integer(i4), allocatable, intent(inout) :: values(:)
    end subroutine share_interface

    subroutine take_interface(self, length, first)
      !! The next places, `first` and those behind it, which nobody else gets.
      import :: process_group, i8
      implicit none (type, external)
      class(process_group), intent(inout) :: self
      integer(i8), intent(in) :: length              !! how many
      integer(i8), intent(out) :: first              !! from 1; above all places where nothing is left or somebody has stopped
    end subroutine take_interface

    subroutine tell_interface(self, done, all_done, stopped)
      !! Tell of cases that are done, and learn of the others.
      import :: process_group, i8
      implicit none (type, external)
      class(process_group), intent(inout) :: self
      integer(i8), intent(in) :: done                !! by this process, not told yet
      integer(i8), intent(out) :: all_done           !! by all that have told
      logical, intent(out) :: stopped                !! somebody has called `stop`
    end subroutine tell_interface

    subroutine collect_interface(self, totals, error)
      !! All have done their cases. Called by all; all get the sums, and an error if anybody has one.
      import :: process_group, dp, error_type
      implicit none (type, external)
      class(process_group), intent(inout) :: self
      real(dp), intent(inout) :: totals(:)
      type(error_type), allocatable, intent(inout) :: error
    end subroutine collect_interface
  end interface

contains

  pure logical function leads(self)
    class(process_group), intent(in) :: self
    leads = self%number == 0
  end function leads

end module bw_process_group
