module bw_process_group
  !! The processes that share the cases of a sweep, as seen from one of them: each takes the next batch from a counter that all
  !! see; one of them leads: it speaks, and writes the result. This is a group of one; MPI's in `app/` extends it.
  use bw_error, only: error_type
  use bw_file_lock, only: own_host
  use bw_kinds, only: dp, i4, i8
  use bw_text, only: append, string
  implicit none (type, external)
  private

  integer(i8), parameter, public :: stopped_at = 2_i8**62     !! where the counter stands when nothing is to be taken any more

  type, public :: process_group
    integer :: number = 0                            !! of this process; 0 leads
    integer :: processes = 1
    integer(i8), private :: next = 1                 !! the counter
    integer(i8), private :: done = 0                 !! cases that were told of
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
    !! Whether this process is the one that speaks and writes the result.
    class(process_group), intent(in) :: self
    leads = self%number == 0
  end function leads

  subroutine join(self)
    !! Come together with the other processes, and set `number` and `processes`: the first call of all.
    class(process_group), intent(inout) :: self
    self%processes = 1
  end subroutine join

  subroutine part(self)
    !! Go apart again: the last call of all.
    class(process_group), intent(inout) :: self
    self%done = 0
  end subroutine part

  subroutine share(self, values)
    !! Hand the leader's values to all. Called by all.
    class(process_group), intent(inout) :: self
    integer(i4), allocatable, intent(inout) :: values(:)
    associate (unused => self, shared => values)
    end associate
  end subroutine share

  subroutine hosts(self, names)
    !! Find out on which hosts the processes run. Called by all; the leader gets the names, each once, its own first.
    class(process_group), intent(inout) :: self
    type(string), allocatable, intent(out) :: names(:)
    associate (unused => self)
    end associate
    call append(names, own_host())
  end subroutine hosts

  subroutine begin(self)
    !! Set the counter to the first place, and the number of finished cases to 0. Called by all.
    class(process_group), intent(inout) :: self
    self%next = 1
    self%done = 0
  end subroutine begin

  subroutine take(self, length, first)
    !! Take the next places, which nobody else gets.
    class(process_group), intent(inout) :: self
    integer(i8), intent(in) :: length                !! how many
    integer(i8), intent(out) :: first                !! from 1; above all places where nothing is left or somebody has stopped
    first = self%next
    self%next = self%next + length
  end subroutine take

  subroutine tell(self, done, all_done, stopped)
    !! Tell of cases that are done, and learn of the others.
    class(process_group), intent(inout) :: self
    integer(i8), intent(in) :: done                  !! by this process, not told yet
    integer(i8), intent(out) :: all_done             !! by all that have told
    logical, intent(out) :: stopped                  !! somebody has called `stop`
    self%done = self%done + done
    all_done = self%done
    stopped = self%next >= stopped_at
  end subroutine tell

  subroutine stop_all(self)
    !! Let nobody take anything more.
    class(process_group), intent(inout) :: self
    self%next = stopped_at
  end subroutine stop_all

  subroutine collect(self, totals, error)
    !! Add up what all processes have when their cases are done. Called by all; all get the sums, and an error if anybody has
    !! one.
    class(process_group), intent(inout) :: self
    real(dp), intent(inout) :: totals(:)
    type(error_type), allocatable, intent(inout) :: error
    associate (unused => self, mine => totals, too => error)
    end associate
  end subroutine collect

end module bw_process_group
