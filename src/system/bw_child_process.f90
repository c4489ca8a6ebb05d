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
  !! Where the system refuses another process the work is done in this one, on the same lines.
  !!
  !! A file that somebody else wrote may be damaged, and the library that reads it may crash or never return. The child that reads
  !! it begins with limits: of memory, and of processor time between two things that it tells, so that slow disks and large files
  !! do not count. It sends numbers before it tells the rest. Where the system refuses it, nothing is read:
  !!
  !!     call child%begin(seconds, error)
  !!     if (child%is_here()) then
  !!       call child%send(numbers)           ! again and again; none where there is an error
  !!       call child%tell(texts, error)
  !!     end if
  !!     call child%receive(numbers, good)    ! as often as all is good
  !!     call child%hear(texts, whole, error)
  use, intrinsic :: iso_c_binding, only: c_int, c_loc
  use bw_descriptors, only: close_file, write_text
  use bw_error, only: error_type, fail, status_bad_file, status_done, status_fault
  use bw_kinds, only: dp, i8
  use bw_monitor, only: monitor_type
  use bw_system_calls, only: bw_confine, bw_confine_memory, bw_fork, bw_kill, bw_leave, bw_listen, bw_receive, bw_wait, bw_write
  use bw_text, only: string, text_builder, text_of
  implicit none (type, external)
  private

  integer, parameter :: wait_milliseconds = 20       !! between two looks whether to stop
  integer, parameter :: most_at_once = 65536         !! bytes
  integer(i8), parameter :: usual_bytes = 2_i8**29   !! that a child with limits may take: a hundred times what most files need
  character(*), parameter :: nul = achar(0)          !! behind each text of its message
  character(*), parameter :: last_word = 'end'

  type, public :: child_process
    integer(i8), private :: number = 0               !! of the child, 0 in the child itself, −1 where there is none
    integer, private :: channel = -1
    integer, private :: limit = 0                    !! processor time between two things that it tells [s]; 0: none
    type(string), allocatable, private :: texts(:)   !! where there is no child: what was told
    type(error_type), allocatable, private :: error
    real(dp) :: seconds = 0.0_dp                     !! processor time of the child
  contains
    procedure :: begin
    procedure :: is_here
    procedure :: send
    procedure :: receive
    procedure :: tell
    procedure :: hear
    procedure, private :: listen
    procedure, private :: take_message
  end type child_process

contains

  subroutine begin(self, seconds, error, bytes)
    !! Start the child: from here on there are two processes.
    !! **Errors**: `status_bad_file` where the system refuses it and a limit is asked for.
    class(child_process), intent(inout) :: self
    integer, intent(in), optional :: seconds         !! limit of processor time; absent: none
    integer(i8), intent(in), optional :: bytes       !! what it may take of memory beside the usual
    type(error_type), allocatable, intent(inout), optional :: error
    integer(c_int) :: channel
    integer(i8) :: room
    self%number = bw_fork(channel)
    self%channel = int(channel)
    if (.not. present(seconds)) return
    self%limit = seconds
    if (self%number == 0) then
      call bw_confine(int(seconds, c_int))
      room = usual_bytes
      if (present(bytes)) room = room + bytes
      call bw_confine_memory(room)
    end if
    if (self%number < 0 .and. present(error)) call fail(error, status_bad_file, &
      'cannot be read: the system refuses another process for it')
  end subroutine begin

  pure logical function is_here(self)
    !! Whether this process is the one that does the work.
    class(child_process), intent(in) :: self
    is_here = self%number <= 0
  end function is_here

  subroutine send(self, numbers)
    !! Hand over some numbers, from the child.
    class(child_process), intent(in) :: self
    real(dp), intent(in), contiguous, target :: numbers(:)   !! of size 0: what follows is told
    integer(i8), target :: count
    integer :: problem
    count = size(numbers, kind=i8)
    problem = bw_write(int(self%channel, c_int), c_loc(count), 8_i8)
    if (problem == 0 .and. count > 0) problem = bw_write(int(self%channel, c_int), c_loc(numbers), 8*count)
    if (problem /= 0) call bw_leave(int(status_bad_file, c_int))
    call bw_confine(int(self%limit, c_int))
  end subroutine send

  subroutine receive(self, numbers, good)
    !! Take as many numbers from the child; where it sends others, or ends, `hear` says why.
    class(child_process), intent(in) :: self
    real(dp), intent(inout), contiguous, target :: numbers(:)
    logical, intent(out) :: good
    integer(i8), target :: count
    good = bw_receive(int(self%channel, c_int), c_loc(count), 8_i8) == 8
    if (good) good = count == size(numbers, kind=i8)
    if (good .and. count > 0) good = bw_receive(int(self%channel, c_int), c_loc(numbers), 8*count) == 8*count
  end subroutine receive

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
      problem = write_text(self%channel, text_of(error%status)//nul//error%message//nul//last_word)
    else
      problem = write_text(self%channel, text_of(status_done)//nul)
      do i = 1, size(texts)
        if (problem == 0) problem = write_text(self%channel, texts(i)%text//nul)
      end do
      if (problem == 0) problem = write_text(self%channel, last_word)
    end if
    call bw_leave(int(merge(status_done, status_bad_file, problem == 0), c_int))
  end subroutine tell

  subroutine hear(self, texts, whole, error, monitor)
    !! Wait for the end of the child, and take what it has found; it is ended where the monitor asks to stop.
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
    if (.not. whole) call bw_kill(self%number)
    ignored = close_file(self%channel)
    status = int(bw_wait(self%number, self%seconds))
    allocate (texts(0))
    if (whole) call self%take_message(message, status, texts, error)
  end subroutine hear

  subroutine listen(self, message, whole, monitor)
    !! Read all that the child writes until it ends, unless the monitor asks to stop.
    class(child_process), intent(in) :: self
    character(:), allocatable, intent(out) :: message
    logical, intent(out) :: whole
    class(monitor_type), intent(inout), optional :: monitor
    character(len=most_at_once), target :: piece
    type(text_builder) :: told
    integer(i8) :: have
    whole = .true.
    do while (whole)
      have = bw_listen(int(self%channel, c_int), c_loc(piece), int(most_at_once, i8), wait_milliseconds)
      if (have == 0) exit
      if (have > 0) call told%append(piece(:have))
      if (present(monitor)) whole = .not. monitor%stop_requested()
    end do
    message = told%text()
  end subroutine listen

  subroutine take_message(self, message, ended, texts, error)
    !! Split the message of the child into its texts, or say how it ended without its last word.
    class(child_process), intent(in) :: self
    character(*), intent(in) :: message
    integer, intent(in) :: ended                     !! its exit status, or below 0 the signal that ended it
    type(string), allocatable, intent(inout) :: texts(:)
    type(error_type), allocatable, intent(inout) :: error
    character(*), parameter :: it = 'the process that reads and writes files '
    integer :: first, letters, status, n, i
    if (ended < 0 .and. self%limit > 0) then
      call fail(error, status_bad_file, 'cannot be read: the library that reads it crashed or found no end (signal '// &
                text_of(-ended)//'); the file is damaged')
    else if (ended < 0) then
      call fail(error, status_bad_file, it//'was ended by signal '//text_of(-ended)// &
                ', as happens to HDF5 after a refused read or write; where nothing was refused, please report it')
    else if (ended == status_fault) then
      call fail(error, status_fault, it//'ended in a fault: please report it')
    else if (ended /= status_done .or. index(message, nul//last_word, back=.true.) == 0) then
      call fail(error, status_bad_file, it//'was refused memory, or was not heard to its end')
    end if
    if (allocated(error)) return
    letters = index(message, nul)
    read (message(:letters - 1), *) status
    n = -1                                           ! behind the status stands one, too
    do i = 1, len(message)
      if (message(i:i) == nul) n = n + 1
    end do
    deallocate (texts)
    allocate (texts(n))
    first = letters + 1
    do i = 1, n
      letters = index(message(first:), nul)
      texts(i)%text = message(first:first + letters - 2)
      first = first + letters
    end do
    if (status /= status_done) call fail(error, status, texts(1)%text)
  end subroutine take_message

end module bw_child_process
