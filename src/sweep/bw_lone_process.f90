module bw_lone_process
  !! A group of one process, whose counter is an integer.
  use bw_error, only: error_type
  use bw_kinds, only: dp, i4, i8
  use bw_process_group, only: process_group
  implicit none (type, external)
  private

  integer(i8), parameter :: stopped_at = 2_i8**62

  type, extends(process_group), public :: lone_process
    integer(i8), private :: next = 1
    integer(i8), private :: done = 0
  contains
    procedure :: join => do_nothing
    procedure :: part => do_nothing
    procedure :: share
    procedure :: begin
    procedure :: take
    procedure :: tell
    procedure :: stop => stop_all
    procedure :: collect
  end type lone_process

contains

  subroutine do_nothing(self)
    class(lone_process), intent(inout) :: self
    associate (unused => self)
    end associate
  end subroutine do_nothing

  subroutine share(self, values)
    class(lone_process), intent(inout) :: self
    integer(i4), allocatable, intent(inout) :: values(:)
    associate (unused => self, shared => values)
    end associate
  end subroutine share

  subroutine begin(self)
    class(lone_process), intent(inout) :: self
    self%next = 1
    self%done = 0
  end subroutine begin

  subroutine take(self, length, first)
    class(lone_process), intent(inout) :: self
    integer(i8), intent(in) :: length
    integer(i8), intent(out) :: first
    first = self%next
    self%next = self%next + length
  end subroutine take

  subroutine tell(self, done, all_done, stopped)
    class(lone_process), intent(inout) :: self
    integer(i8), intent(in) :: done
    integer(i8), intent(out) :: all_done
    logical, intent(out) :: stopped
    self%done = self%done + done
    all_done = self%done
    stopped = self%next >= stopped_at
  end subroutine tell

  subroutine stop_all(self)
    class(lone_process), intent(inout) :: self
    self%next = stopped_at
  end subroutine stop_all

  subroutine collect(self, totals, error)
    class(lone_process), intent(inout) :: self
    real(dp), intent(inout) :: totals(:)
    type(error_type), allocatable, intent(inout) :: error
    associate (unused => self, mine => totals, too => error)
    end associate
  end subroutine collect

end module bw_lone_process
