module bw_process_group
  !! The processes that share the cases of a sweep, as seen from one of them. Each takes the next batch from a common
  !! counter; the leader prints and writes the result. This is a group of one; the MPI group in `app/` extends it.
  use bw_error, only: error_type
  use bw_file_lock, only: own_host
  use bw_kinds, only: dp, i4, i8
  use bw_text, only: append, string
  implicit none (type, external)
  private

  integer(i8), parameter, public :: stopped_at = 2_i8**62     !! value of the counter when no more batches may be taken

  type, public :: process_group
    integer :: number = 0                            !! of this process; 0 leads
    integer :: processes = 1
    integer(i8), private :: next = 1                 !! the counter
    integer(i8), private :: done = 0                 !! cases reported as done
  contains
    procedure :: leads
    procedure :: join
    procedure :: part
    procedure :: share
    procedure :: hosts
    procedure :: begin
    procedure :: take
    procedure :: tell
    procedure :: stop => stop_all
    procedure :: collect
  end type process_group

contains

  pure logical function leads(self)
    !! Return whether this process prints and writes the result.
    class(process_group), intent(in) :: self
    leads = self%number == 0
  end function leads

  subroutine join(self)
    !! Join the other processes, and set `number` and `processes`: must be called first.
    class(process_group), intent(inout) :: self
    self%processes = 1
  end subroutine join

  subroutine part(self)
    !! Leave the group: must be called last.
    class(process_group), intent(inout) :: self
    self%done = 0
  end subroutine part

  subroutine share(self, values)
    !! Broadcast the leader's values. Called by all.
    class(process_group), intent(inout) :: self
    integer(i4), allocatable, intent(inout) :: values(:)
    associate (unused => self, shared => values)
    end associate
  end subroutine share

  subroutine hosts(self, names)
    !! Collect the names of the hosts. Called by all; the leader gets each name once, its own first.
    class(process_group), intent(inout) :: self
    type(string), allocatable, intent(out) :: names(:)
    associate (unused => self)
    end associate
    call append(names, own_host())
  end subroutine hosts

  subroutine begin(self)
    !! Set the counter to the first position, and the number of finished cases to 0. Called by all.
    class(process_group), intent(inout) :: self
    self%next = 1
    self%done = 0
  end subroutine begin

  subroutine take(self, length, first)
    !! Take the next positions from the counter, for this process alone.
    class(process_group), intent(inout) :: self
    integer(i8), intent(in) :: length                !! how many
    integer(i8), intent(out) :: first                !! from 1; beyond the last position if none is left or a process has stopped
    first = self%next
    self%next = self%next + length
  end subroutine take

  subroutine tell(self, done, all_done, stopped)
    !! Report finished cases, and get the total of all processes.
    class(process_group), intent(inout) :: self
    integer(i8), intent(in) :: done                  !! by this process, not yet reported
    integer(i8), intent(out) :: all_done             !! reported by all processes
    logical, intent(out) :: stopped                  !! a process has called `stop`
    self%done = self%done + done
    all_done = self%done
    stopped = self%next >= stopped_at
  end subroutine tell

  subroutine stop_all(self)
    !! Let no process take further batches.
    class(process_group), intent(inout) :: self
    self%next = stopped_at
  end subroutine stop_all

  subroutine collect(self, totals, error)
    !! Sum up the results of all processes when their cases are done. Called by all; all get the sums, and an error if
    !! any process has one.
    class(process_group), intent(inout) :: self
    real(dp), intent(inout) :: totals(:)
    type(error_type), allocatable, intent(inout) :: error
    associate (unused => self, mine => totals, too => error)
    end associate
  end subroutine collect

end module bw_process_group
