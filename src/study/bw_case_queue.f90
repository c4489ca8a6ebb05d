module bw_case_queue
  !! The cases of a scene that are still to be done, handed out as ranges of neighbours.
  use bw_kinds, only: dp, i1, i8
  implicit none (type, external)
  private
  public :: queue_of, range_length

  real(dp), parameter :: range_seconds = 0.05_dp     !! work of a range: long beside a message, short beside a run; tuned
  real(dp), parameter :: answer_seconds = 5.0e-4_dp  !! what one process may take of another's time to hand out; tuned
  integer, parameter :: ranges_left = 4              !! how many each process gets at least of what is left

  type, public :: case_queue
    private
    integer(i1), allocatable :: done(:)              !! (cases) 1: done before or handed out
    integer(i8) :: position = 1                      !! no case is left before it
    integer(i8), public :: left = 0                  !! how many are left
  contains
    procedure :: take
    procedure :: drop_all
  end type case_queue

contains

  pure type(case_queue) function queue_of(done) result(queue)
    !! All cases that are not done.
    integer(i1), intent(in) :: done(:)               !! (cases) 0: to be done
    queue%done = done
    queue%left = count(done == 0, kind=i8)
  end function queue_of

  pure subroutine take(self, most, first, last)
    !! The next range; `first > last` where nothing is left.
    class(case_queue), intent(inout) :: self
    integer(i8), intent(in) :: most                  !! its length at most, ≥ 1
    integer(i8), intent(out) :: first, last
    first = 1
    last = 0
    if (self%left == 0) return
    do while (self%done(self%position) /= 0)
      self%position = self%position + 1
    end do
    first = self%position
    last = first
    do while (last < min(size(self%done, kind=i8), first + most - 1))
      if (self%done(last + 1) /= 0) exit
      last = last + 1
    end do
    self%left = self%left - (last - first + 1)
    self%position = last + 1
  end subroutine take

  pure subroutine drop_all(self)
    !! Hand out nothing more.
    class(case_queue), intent(inout) :: self
    self%left = 0
  end subroutine drop_all

  pure integer(i8) function range_length(left, processes, case_seconds) result(length)
    !! How many cases to hand out at once: few messages for many small cases, and no process left with the last long one.
    integer(i8), intent(in) :: left                  !! cases
    integer, intent(in) :: processes
    real(dp), intent(in) :: case_seconds             !! what a case took so far; 0: not known
    real(dp) :: wanted
    length = 1
    if (case_seconds <= 0.0_dp) return
    wanted = max(range_seconds, answer_seconds*processes)/case_seconds
    length = max(1_i8, int(min(wanted, real(left, dp)/(ranges_left*processes)), i8))
  end function range_length

end module bw_case_queue
