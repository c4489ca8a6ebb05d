module bw_mpi_processes
  !! A group of MPI processes. The counter and the number of finished cases are two integers in a window of the leader's
  !! memory, which each process changes by one-sided calls. Waiting uses no busy loop.
  use, intrinsic :: iso_c_binding, only: c_ptr
  use bw_error, only: error_type, fail, status_done
  use bw_file_lock, only: own_host
  use bw_kinds, only: dp, i4, i8
  use bw_process, only: pause
  use bw_process_group, only: process_group, stopped_at
  use bw_text, only: append, string
  use mpi_f08, only: mpi_2integer, mpi_address_kind, mpi_character, mpi_comm_rank, mpi_comm_size, mpi_comm_world, &
    mpi_double_precision, mpi_fetch_and_op, mpi_finalize, mpi_iallreduce, mpi_ibarrier, mpi_ibcast, mpi_igather, mpi_info_null, &
    mpi_init, mpi_integer, mpi_integer8, mpi_maxloc, mpi_no_op, mpi_op, mpi_replace, mpi_request, mpi_status_ignore, mpi_sum, &
    mpi_test, mpi_win, mpi_win_allocate, mpi_win_flush, mpi_win_free, mpi_win_lock_all, mpi_win_unlock_all
  implicit none (type, external)
  private

  integer, parameter :: pause_microseconds = 50, longest_name = 256       !! of a host
  integer(mpi_address_kind), parameter :: next_place = 0, done_cases = 1    !! the integers of the window

  type, extends(process_group), public :: mpi_processes
    type(mpi_win), private :: window
  contains
    procedure :: join
    procedure :: part
    procedure :: share
    procedure :: hosts
    procedure :: begin
    procedure :: take
    procedure :: tell
    procedure :: stop => stop_all
    procedure :: collect
  end type mpi_processes

contains

  subroutine join(self)
    !! Start MPI, and create the window.
    class(mpi_processes), intent(inout) :: self
    integer(mpi_address_kind), parameter :: bytes = 8
    type(c_ptr) :: memory
    call mpi_init()
    call mpi_comm_rank(mpi_comm_world, self%number)
    call mpi_comm_size(mpi_comm_world, self%processes)
    call mpi_win_allocate(merge(2*bytes, 0*bytes, self%leads()), int(bytes), mpi_info_null, mpi_comm_world, memory, self%window)
    call mpi_win_lock_all(0, self%window)
  end subroutine join

  subroutine part(self)
    !! Wait for all processes, and end MPI.
    class(mpi_processes), intent(inout) :: self
    type(mpi_request) :: request
    call mpi_ibarrier(mpi_comm_world, request)
    call wait_for(request)
    call mpi_win_unlock_all(self%window)
    call mpi_win_free(self%window)
    call mpi_finalize()
  end subroutine part

  subroutine wait_for(request)
    !! Wait for a request without occupying the processor.
    type(mpi_request), intent(inout) :: request
    logical :: done
    do
      call mpi_test(request, done, mpi_status_ignore)
      if (done) return
      call pause(pause_microseconds)
    end do
  end subroutine wait_for

  subroutine share(self, values)
    !! Broadcast the leader's values, whose length is arbitrary.
    class(mpi_processes), intent(inout) :: self
    integer(i4), allocatable, intent(inout) :: values(:)
    integer(i4), allocatable, asynchronous :: shared(:)
    integer, asynchronous :: length(1)
    type(mpi_request) :: request
    length = 0
    if (allocated(values)) length = size(values)
    call mpi_ibcast(length, 1, mpi_integer, 0, mpi_comm_world, request)
    call wait_for(request)
    allocate (shared(length(1)))
    if (self%leads() .and. length(1) > 0) shared = values
    call mpi_ibcast(shared, length(1), mpi_integer, 0, mpi_comm_world, request)
    call wait_for(request)
    call move_alloc(shared, values)
  end subroutine share

  subroutine hosts(self, names)
    !! Gather the names of all hosts on the leader.
    class(mpi_processes), intent(inout) :: self
    type(string), allocatable, intent(out) :: names(:)
    character(longest_name), asynchronous :: mine, every(self%processes)
    type(mpi_request) :: request
    integer :: i
    mine = own_host()
    call mpi_igather(mine, longest_name, mpi_character, every, longest_name, mpi_character, 0, mpi_comm_world, request)
    call wait_for(request)
    allocate (names(0))
    do i = 1, merge(self%processes, 0, self%leads())
      if (.not. any(every(:i - 1) == every(i))) call append(names, trim(every(i)))
    end do
  end subroutine hosts

  subroutine begin(self)
    !! Reset the leader's integers while the others wait.
    class(mpi_processes), intent(inout) :: self
    type(mpi_request) :: request
    integer(i8) :: former
    if (self%leads()) then
      call change(self, next_place, 1_i8, mpi_replace, former)
      call change(self, done_cases, 0_i8, mpi_replace, former)
    end if
    call mpi_ibarrier(mpi_comm_world, request)
    call wait_for(request)
  end subroutine begin

  subroutine change(self, which, value, operation, former)
    !! Change one of the leader's integers, and get its former value.
    class(mpi_processes), intent(inout) :: self
    integer(mpi_address_kind), intent(in) :: which
    integer(i8), intent(in) :: value
    type(mpi_op), intent(in) :: operation
    integer(i8), intent(out) :: former
    integer(i8), asynchronous :: given, got
    given = value
    call mpi_fetch_and_op(given, got, mpi_integer8, 0, which, operation, self%window)
    call mpi_win_flush(0, self%window)
    former = got
  end subroutine change

  subroutine take(self, length, first)
    !! Take the next positions from the leader's counter.
    class(mpi_processes), intent(inout) :: self
    integer(i8), intent(in) :: length
    integer(i8), intent(out) :: first
    call change(self, next_place, length, mpi_sum, first)
  end subroutine take

  subroutine tell(self, done, all_done, stopped)
    !! Add to the leader's number of finished cases, and read it and the counter.
    class(mpi_processes), intent(inout) :: self
    integer(i8), intent(in) :: done
    integer(i8), intent(out) :: all_done
    logical, intent(out) :: stopped
    integer(i8) :: next
    call change(self, done_cases, done, mpi_sum, all_done)
    all_done = all_done + done
    call change(self, next_place, 0_i8, mpi_no_op, next)
    stopped = next >= stopped_at
  end subroutine tell

  subroutine stop_all(self)
    !! Set the leader's counter beyond all positions.
    class(mpi_processes), intent(inout) :: self
    integer(i8) :: former
    call change(self, next_place, stopped_at, mpi_replace, former)
  end subroutine stop_all

  subroutine collect(self, totals, error)
    !! Sum up the values of all processes, and find the process with the worst error.
    class(mpi_processes), intent(inout) :: self
    real(dp), intent(inout) :: totals(:)
    type(error_type), allocatable, intent(inout) :: error
    real(dp), asynchronous :: sums(size(totals)), mine(size(totals))
    integer, asynchronous :: worst(2), own(2)               ! status, and rank of the process
    type(mpi_request) :: request
    mine = totals
    call mpi_iallreduce(mine, sums, size(mine), mpi_double_precision, mpi_sum, mpi_comm_world, request)
    call wait_for(request)
    totals = sums
    own = [status_done, self%number]
    if (allocated(error)) own(1) = error%status
    call mpi_iallreduce(own, worst, 1, mpi_2integer, mpi_maxloc, mpi_comm_world, request)
    call wait_for(request)
    if (worst(1) /= status_done) call share_error(self, worst, error)
  end subroutine collect

  subroutine share_error(self, worst, error)
    !! Broadcast the error of one process.
    class(mpi_processes), intent(in) :: self
    integer, intent(in) :: worst(2)
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable, asynchronous :: text
    integer, asynchronous :: length(1)
    type(mpi_request) :: request
    length = 0
    if (self%number == worst(2)) length = len(error%message)
    call mpi_ibcast(length, 1, mpi_integer, worst(2), mpi_comm_world, request)
    call wait_for(request)
    allocate (character(length(1)) :: text)
    if (self%number == worst(2)) text = error%message
    call mpi_ibcast(text, length(1), mpi_character, worst(2), mpi_comm_world, request)
    call wait_for(request)
    if (allocated(error)) deallocate (error)
    call fail(error, worst(1), text)
  end subroutine share_error

end module bw_mpi_processes
