module bw_mpi_crew
  !! A crew of MPI processes. The leader does cases too, and hands out ranges of them to whoever asks; who works on short
  !! ranges asks for the next one while it is at work. Nobody waits in a busy loop.
  use bw_case_queue, only: case_queue, range_length
  use bw_crew, only: crew_type
  use bw_error, only: error_type, fail, status_done
  use bw_kinds, only: dp, i8
  use bw_posix, only: pause
  use bw_stopwatch, only: wall_seconds
  use mpi_f08, only: mpi_allreduce, mpi_any_source, mpi_character, mpi_comm, mpi_comm_free, mpi_comm_rank, mpi_comm_size, &
    mpi_comm_split_type, mpi_comm_type_shared, mpi_comm_world, mpi_double_precision, mpi_finalize, mpi_ibarrier, mpi_ibcast, &
    mpi_info_null, mpi_init, mpi_integer, mpi_integer8, mpi_iprobe, mpi_min, mpi_recv, mpi_request, mpi_send, mpi_status, &
    mpi_status_ignore, mpi_test
  implicit none (type, external)
  private

  integer, parameter :: tag_request = 1, tag_range = 2, tag_farewell = 3, tag_message = 4
  integer, parameter :: pause_microseconds = 50
  real(dp), parameter :: short_seconds = 1.0_dp    !! work of a range that is too short to wait for the next one after it
  integer(i8), parameter :: no_range(2) = [1_i8, 0_i8], stop_notice(2) = [0_i8, 0_i8]
  integer, parameter :: farewell_head = 3          !! cases done, exit status, length of the error's message

  type, extends(crew_type), public :: mpi_crew
    private
    type(case_queue) :: queue                      !! of the leader
    real(dp) :: case_seconds = 0.0_dp              !! what a case takes, as far as is known
    logical, allocatable :: away(:)                !! (0 … processes−1) has been told that nothing is left
    logical :: has_stopped = .false.
    logical :: asked = .false.                     !! a request is under way
    logical :: got = .false.                       !! an answer is there
    integer(i8) :: answer(2) = no_range            !! first and last case
    integer(i8) :: done = 0                        !! cases done and not told yet
    integer(i8) :: told = 0                        !! leader: cases that others have told of
    real(dp) :: began = 0.0_dp                     !! when the cases that are not told yet were begun
  contains
    procedure :: join
    procedure :: part
    procedure :: agree
    procedure :: begin
    procedure :: next
    procedure :: case_done
    procedure :: attend
    procedure :: stop => stop_all
    procedure :: stopped
    procedure :: end => end_all
  end type mpi_crew

contains

  subroutine join(self)
    class(mpi_crew), intent(inout) :: self
    call mpi_init()
    call mpi_comm_rank(mpi_comm_world, self%number)
    call mpi_comm_size(mpi_comm_world, self%processes)
    call look_for_leader(self)
  end subroutine join

  subroutine look_for_leader(self)
    !! Whether the leader, who has number 0, is among the processes that share memory with this one.
    class(mpi_crew), intent(inout) :: self
    type(mpi_comm) :: neighbours
    integer :: lowest
    call mpi_comm_split_type(mpi_comm_world, mpi_comm_type_shared, self%number, mpi_info_null, neighbours)
    call mpi_allreduce(self%number, lowest, 1, mpi_integer, mpi_min, neighbours)
    call mpi_comm_free(neighbours)
    self%near_leader = lowest == 0
  end subroutine look_for_leader

  subroutine part(self)
    class(mpi_crew), intent(inout) :: self
    type(mpi_request) :: request
    associate (unused => self)
    end associate
    call mpi_ibarrier(mpi_comm_world, request)
    call wait_for(request)
    call mpi_finalize()
  end subroutine part

  subroutine agree(self, value)
    class(mpi_crew), intent(inout) :: self
    integer, intent(inout) :: value
    integer, asynchronous :: shared(1)
    type(mpi_request) :: request
    associate (unused => self)
    end associate
    shared = value
    call mpi_ibcast(shared, 1, mpi_integer, 0, mpi_comm_world, request)
    call wait_for(request)
    value = shared(1)
  end subroutine agree

  subroutine wait_for(request)
    !! Without taking the processor from others.
    type(mpi_request), intent(inout) :: request
    logical :: done
    do
      call mpi_test(request, done, mpi_status_ignore)
      if (done) return
      call pause(pause_microseconds)
    end do
  end subroutine wait_for

  subroutine begin(self, queue)
    class(mpi_crew), intent(inout) :: self
    type(case_queue), intent(in) :: queue
    if (self%leads()) self%queue = queue
    if (allocated(self%away)) deallocate (self%away)
    allocate (self%away(0:self%processes - 1), source=.false.)
    self%case_seconds = 0.0_dp
    self%has_stopped = .false.
    self%asked = .false.
    self%got = .false.
    self%done = 0
    self%told = 0
    self%began = wall_seconds()
  end subroutine begin

  subroutine next(self, first, last)
    class(mpi_crew), intent(inout) :: self
    integer(i8), intent(out) :: first, last
    if (self%leads()) then
      call learn(self, self%done, wall_seconds() - self%began)
      self%done = 0
      self%began = wall_seconds()
      call answer_others(self)
      call self%queue%take(range_length(self%queue%left, self%processes, self%case_seconds), first, last)
    else
      call ask_leader(self, first, last)
    end if
  end subroutine next

  subroutine ask_leader(self, first, last)
    !! The next range from the leader. What comes after somebody has stopped is not begun.
    class(mpi_crew), intent(inout) :: self
    integer(i8), intent(out) :: first, last
    real(dp) :: seconds
    do
      if (.not. (self%asked .or. self%got)) call request_range(self)
      do while (.not. self%got)
        call hear_leader(self)
        if (.not. self%got) call pause(pause_microseconds)
      end do
      self%got = .false.
      first = self%answer(1)
      last = self%answer(2)
      if (first > last) return
      if (.not. self%has_stopped) exit
    end do
    seconds = self%case_seconds*real(last - first + 1, dp)
    if (seconds > 0.0_dp .and. seconds < short_seconds) call request_range(self)
  end subroutine ask_leader

  subroutine request_range(self)
    !! Tell the leader what was done since the last request, and ask for more.
    class(mpi_crew), intent(inout) :: self
    real(dp) :: now
    now = wall_seconds()
    call learn(self, self%done, now - self%began)
    call mpi_send([real(self%done, dp), now - self%began, merge(1.0_dp, 0.0_dp, self%has_stopped)], 3, &
                  mpi_double_precision, 0, tag_request, mpi_comm_world)
    self%done = 0
    self%began = now
    self%asked = .true.
  end subroutine request_range

  pure subroutine learn(self, done, seconds)
    !! What a case takes, from the latest of them: neighbours are alike.
    class(mpi_crew), intent(inout) :: self
    integer(i8), intent(in) :: done                !! cases
    real(dp), intent(in) :: seconds                !! that they took
    real(dp) :: mean
    if (done == 0) return
    mean = seconds/real(done, dp)
    if (self%case_seconds > 0.0_dp) mean = 0.5_dp*(mean + self%case_seconds)
    self%case_seconds = mean
  end subroutine learn

  subroutine hear_leader(self)
    !! A range, or the notice that all have to stop.
    class(mpi_crew), intent(inout) :: self
    integer(i8) :: range(2)
    logical :: there
    call mpi_iprobe(0, tag_range, mpi_comm_world, there, mpi_status_ignore)
    if (.not. there) return
    call mpi_recv(range, 2, mpi_integer8, 0, tag_range, mpi_comm_world, mpi_status_ignore)
    if (all(range == stop_notice)) then
      self%has_stopped = .true.
    else
      self%answer = range
      self%asked = .false.
      self%got = .true.
    end if
  end subroutine hear_leader

  subroutine answer_others(self)
    !! All requests that have come.
    class(mpi_crew), intent(inout) :: self
    type(mpi_status) :: from
    real(dp) :: request(3)
    integer(i8) :: range(2)
    logical :: there
    do
      call mpi_iprobe(mpi_any_source, tag_request, mpi_comm_world, there, from)
      if (.not. there) return
      call mpi_recv(request, 3, mpi_double_precision, from%mpi_source, tag_request, mpi_comm_world, mpi_status_ignore)
      self%told = self%told + nint(request(1), i8)
      call learn(self, nint(request(1), i8), request(2))
      if (request(3) > 0.0_dp) call self%stop()
      call self%queue%take(range_length(self%queue%left, self%processes, self%case_seconds), range(1), range(2))
      if (range(1) > range(2)) then
        range = no_range
        self%away(from%mpi_source) = .true.
      end if
      call mpi_send(range, 2, mpi_integer8, from%mpi_source, tag_range, mpi_comm_world)
    end do
  end subroutine answer_others

  subroutine case_done(self)
    class(mpi_crew), intent(inout) :: self
    self%done = self%done + 1
  end subroutine case_done

  subroutine attend(self, done)
    class(mpi_crew), intent(inout) :: self
    integer(i8), intent(out) :: done
    if (self%leads()) then
      call answer_others(self)
    else
      call hear_leader(self)
    end if
    done = self%told
    self%told = 0
  end subroutine attend

  subroutine stop_all(self)
    class(mpi_crew), intent(inout) :: self
    integer :: other
    if (self%has_stopped) return
    self%has_stopped = .true.
    if (.not. self%leads()) return                 ! the next request tells the leader
    call self%queue%drop_all()
    do other = 1, self%processes - 1
      if (.not. self%away(other)) call mpi_send(stop_notice, 2, mpi_integer8, other, tag_range, mpi_comm_world)
    end do
  end subroutine stop_all

  logical function stopped(self)
    class(mpi_crew), intent(in) :: self
    stopped = self%has_stopped
  end function stopped

  subroutine end_all(self, totals, error)
    class(mpi_crew), intent(inout) :: self
    real(dp), intent(inout) :: totals(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: farewells
    logical :: there
    type(mpi_status) :: from
    if (.not. self%leads()) then
      call say_farewell(self, totals, error)
      return
    end if
    farewells = 0
    do while (farewells < self%processes - 1)
      call answer_others(self)
      call mpi_iprobe(mpi_any_source, tag_farewell, mpi_comm_world, there, from)
      if (there) then
        call hear_farewell(self, from%mpi_source, totals, error)
        farewells = farewells + 1
      else
        call pause(pause_microseconds)
      end if
    end do
  end subroutine end_all

  subroutine say_farewell(self, totals, error)
    class(mpi_crew), intent(inout) :: self
    real(dp), intent(in) :: totals(:)
    type(error_type), intent(in), optional :: error
    character(:), allocatable :: text
    integer :: status
    status = status_done
    text = ''
    if (present(error)) then
      status = error%status
      text = error%message
    end if
    call mpi_send([real(self%done, dp), real(status, dp), real(len(text), dp), totals], farewell_head + size(totals), &
                  mpi_double_precision, 0, tag_farewell, mpi_comm_world)
    if (len(text) > 0) call mpi_send(text, len(text), mpi_character, 0, tag_message, mpi_comm_world)
    self%done = 0
  end subroutine say_farewell

  subroutine hear_farewell(self, other, totals, error)
    !! The first error is kept.
    class(mpi_crew), intent(inout) :: self
    integer, intent(in) :: other                   !! who says it
    real(dp), intent(inout) :: totals(:)
    type(error_type), allocatable, intent(inout) :: error
    real(dp) :: farewell(farewell_head + size(totals))
    character(:), allocatable :: text
    call mpi_recv(farewell, size(farewell), mpi_double_precision, other, tag_farewell, mpi_comm_world, mpi_status_ignore)
    self%told = self%told + nint(farewell(1), i8)
    totals = totals + farewell(farewell_head + 1:)
    allocate (character(nint(farewell(3))) :: text)
    if (len(text) > 0) call mpi_recv(text, len(text), mpi_character, other, tag_message, mpi_comm_world, mpi_status_ignore)
    if (nint(farewell(2)) /= status_done .and. .not. allocated(error)) call fail(error, nint(farewell(2)), text)
  end subroutine hear_farewell

end module bw_mpi_crew
