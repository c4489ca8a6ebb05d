module bw_child_process
  !! Work in a process of its own, whose end, whatever it is, is not this one's: HDF5 crashes or never ends after a refused read
  !! or write. Both go through the same lines:
  !!
  !!     call child%begin()
  !!     if (child%is_here()) then            ! only in the child
  !!       call do_the_work(texts, error)
  !!       call child%tell(texts, error)      ! the child ends here
  !!     end if
  !!     call child%hear(texts, whole, error, monitor)
  !!
  !! A child that has to wait for something asks `is_released`, until the parent calls `release`. Where the system refuses
  !! another process (`is_refused`) the work is done in this one, on the same lines; what it would wait for has to come before.
  use, intrinsic :: iso_c_binding, only: c_int, c_loc
  use bw_descriptors, only: close_file, write_text, write_words
  use bw_error, only: error_type, fail, status_bad_file, status_done, status_fault
  use bw_kinds, only: dp, i8
  use bw_monitor, only: monitor_type
  use bw_system_calls, only: bw_fork, bw_kill, bw_leave, bw_listen, bw_wait
  use bw_text, only: append, string, text_of
  implicit none (type, external)
  private

  integer, parameter :: wait_milliseconds = 20       !! between two looks whether to stop
  integer, parameter :: most_at_once = 65536         !! bytes
  character(*), parameter :: nul = achar(0)          !! behind each text of its message
  character(*), parameter :: last_word = 'end'

  type, public :: child_process
    integer(i8), private :: number = -1              !! of the child, 0 in the child itself, −1 where there is none
    integer, private :: writes = -1, reads = -1      !! ends of the pipes to the other process
    real(dp), allocatable, private :: given(:)       !! with the release
    type(string), allocatable, private :: texts(:)   !! where there is no child: what was told
    type(error_type), allocatable, private :: error
    real(dp) :: seconds = 0.0_dp                     !! processor time of the child
  contains
    procedure :: begin
    procedure :: is_here
    procedure :: is_refused
    procedure :: tell
    procedure :: release
    procedure :: is_released
    procedure :: hear
    procedure :: end => end_child
    procedure, private :: listen
  end type child_process

contains

  subroutine begin(self)
    !! From here on there are two.
    class(child_process), intent(inout) :: self
    integer(c_int) :: writes, reads
    self%number = bw_fork(writes, reads)
    self%writes = int(writes)
    self%reads = int(reads)
  end subroutine begin

  pure logical function is_here(self)
    !! This process does the work.
    class(child_process), intent(in) :: self
    is_here = self%number <= 0
  end function is_here

  pure logical function is_refused(self)
    !! There is no other process.
    class(child_process), intent(in) :: self
    is_refused = self%number < 0
  end function is_refused

  subroutine tell(self, texts, error)
    !! Hand over what was found, and end.
    class(child_process), intent(inout) :: self
    type(string), allocatable, intent(inout) :: texts(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: problem, i
    if (self%number < 0) then
      call move_alloc(texts, self%texts)
      call move_alloc(error, self%error)
      return
    end if
    if (allocated(error)) then
      problem = write_text(self%writes, text_of(error%status)//nul//error%message//nul//last_word)
    else
      problem = write_text(self%writes, text_of(status_done)//nul)
      do i = 1, size(texts)
        if (problem == 0) problem = write_text(self%writes, texts(i)%text//nul)
      end do
      if (problem == 0) problem = write_text(self%writes, last_word)
    end if
    call bw_leave(int(merge(status_done, status_bad_file, problem == 0), c_int))
  end subroutine tell

  subroutine release(self, numbers)
    !! What the child waits for has come, with some numbers.
    class(child_process), intent(inout) :: self
    real(dp), intent(in) :: numbers(:)
    integer :: ignored
    self%given = numbers
    if (self%number > 0) ignored = write_words(self%writes, transfer(numbers, [0_i8]))
  end subroutine release

  logical function is_released(self, numbers)
    !! Whether it has come by now.
    class(child_process), intent(in) :: self
    real(dp), intent(inout), contiguous, target :: numbers(:)     !! those of the release, from then on
    integer(i8), parameter :: bytes = storage_size(1.0_dp)/8
    is_released = self%is_refused()
    if (is_released) then
      numbers = self%given
    else
      is_released = bw_listen(int(self%reads, c_int), c_loc(numbers), bytes*size(numbers), 0_c_int) == bytes*size(numbers)
    end if
  end function is_released

  subroutine hear(self, texts, whole, error, monitor)
    !! What the child has found, when it has ended; it is ended where the monitor asks to stop.
    !! **Errors**: those of the work, or that its process did not come to its end.
    class(child_process), intent(inout) :: self
    type(string), allocatable, intent(out) :: texts(:)
    logical, intent(out) :: whole                    !! false where the monitor asked to stop
    type(error_type), allocatable, intent(inout) :: error
    class(monitor_type), intent(inout), optional :: monitor
    character(:), allocatable :: message
    integer :: status, ignored
    whole = .true.
    if (self%number < 0) then
      call move_alloc(self%texts, texts)
      call move_alloc(self%error, error)
      return
    end if
    call self%listen(message, whole, monitor)
    allocate (texts(0))
    if (whole) then
      ignored = close_file(self%writes) + close_file(self%reads)
      status = int(bw_wait(self%number, self%seconds))
      call take_message(message, status, texts, error)
    else
      call self%end()
    end if
  end subroutine hear

  subroutine end_child(self)
    !! End the child, if there is one: its work is not wanted any more.
    class(child_process), intent(inout) :: self
    integer :: ignored
    if (self%number <= 0) return
    call bw_kill(self%number)
    ignored = close_file(self%writes) + close_file(self%reads)
    ignored = int(bw_wait(self%number, self%seconds))
  end subroutine end_child

  subroutine listen(self, message, whole, monitor)
    !! All that the child writes until it ends, unless the monitor asks to stop.
    class(child_process), intent(in) :: self
    character(:), allocatable, intent(out) :: message
    logical, intent(out) :: whole
    class(monitor_type), intent(inout), optional :: monitor
    character(len=most_at_once), target :: piece
    integer(i8) :: have
    message = ''
    whole = .true.
    do
      have = bw_listen(int(self%reads, c_int), c_loc(piece), int(most_at_once, i8), wait_milliseconds)
      if (have == 0) return
      if (have > 0) message = message//piece(:have)
      if (present(monitor)) whole = .not. monitor%stop_requested()
      if (.not. whole) return
    end do
  end subroutine listen

  subroutine take_message(message, ended, texts, error)
    !! What the child has told, or how it ended without its last word.
    character(*), intent(in) :: message
    integer, intent(in) :: ended                     !! its exit status, or below 0 the signal that ended it
    type(string), allocatable, intent(inout) :: texts(:)
    type(error_type), allocatable, intent(inout) :: error
    character(*), parameter :: it = 'the process that reads and writes files '
    integer :: first, letters, status
    if (ended < 0) then
      call fail(error, status_bad_file, it//'was ended by signal '//text_of(-ended)// &
                ', as happens to HDF5 after a refused read or write; where nothing was refused, please report it')
    else if (ended == status_fault) then
      call fail(error, status_fault, it//'ended in a fault: please report it')
    else if (ended /= status_done .or. index(message, nul//last_word) == 0) then
      call fail(error, status_bad_file, it//'was refused memory, or was not heard to its end')
    end if
    if (allocated(error)) return
    letters = index(message, nul)
    read (message(:letters - 1), *) status
    first = letters + 1
    do while (message(first:) /= last_word)
      letters = index(message(first:), nul)
      call append(texts, message(first:first + letters - 2))
      first = first + letters
    end do
    if (status /= status_done) call fail(error, status, texts(1)%text)
  end subroutine take_message

end module bw_child_process
