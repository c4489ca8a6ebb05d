module bw_child_process
  !! Work in a process of its own, whose end, whatever it is, is not this one's. A file that somebody else wrote may be damaged, and
  !! the library that reads it may crash or never return. The child that reads it has limits: of memory, and of processor time
  !! between two things that it tells, so that slow disks and large files do not count. It sends numbers before it tells the rest:
  !!
  !!     call child%begin(seconds, error)
  !!     if (child%is_here()) then            ! only in the child
  !!       call child%send(numbers)           ! again and again; none where there is an error
  !!       call child%tell(texts, error)      ! the child ends here
  !!     end if
  !!     call child%receive(numbers, good)    ! as often as all is good
  !!     call child%hear(texts, error)
  use, intrinsic :: iso_c_binding, only: c_loc
  use bw_descriptors, only: close_file, write_text
  use bw_error, only: error_type, fail, status_bad_file, status_done, status_fault
  use bw_kinds, only: dp, i8
  use bw_system_calls, only: bw_confine, bw_confine_memory, bw_fork, bw_leave, bw_receive, bw_wait, bw_write
  use bw_text, only: lines_of, string, text_builder, text_of
  implicit none (type, external)
  private

  integer, parameter :: most_at_once = 65536         !! bytes
  integer(i8), parameter :: usual_bytes = 2_i8**29   !! that a child may take: a hundred times what most files need
  character(*), parameter :: nul = achar(0)          !! behind each text of its message
  character(*), parameter :: last_word = 'end'

  type, public :: child_process
    integer(i8), private :: number = 0               !! of the child, 0 in the child itself
    integer, private :: channel = -1
    integer, private :: limit = 0                    !! processor time between two things that it tells [s]
  contains
    procedure :: begin
    procedure :: is_here
    procedure :: send
    procedure :: receive
    procedure :: tell
    procedure :: hear
  end type child_process

contains

  subroutine begin(self, seconds, error, bytes)
    !! Start the child: from here on there are two processes.
    !! **Errors**: `status_bad_file` where the system refuses it.
    class(child_process), intent(inout) :: self
    integer, intent(in) :: seconds                   !! limit of processor time
    type(error_type), allocatable, intent(inout) :: error
    integer(i8), intent(in), optional :: bytes       !! what it may take of memory beside the usual
    integer(i8) :: room
    self%number = bw_fork(self%channel)
    self%limit = seconds
    room = usual_bytes
    if (present(bytes)) room = room + bytes
    if (self%number == 0) call bw_confine(seconds)
    if (self%number == 0) call bw_confine_memory(room)
    if (self%number < 0) call fail(error, status_bad_file, 'cannot be read: the system refuses another process for it')
  end subroutine begin

  pure logical function is_here(self)
    !! Whether this process is the one that does the work.
    class(child_process), intent(in) :: self
    is_here = self%number == 0
  end function is_here

  subroutine send(self, numbers)
    !! Hand over some numbers, from the child.
    class(child_process), intent(in) :: self
    real(dp), intent(in), contiguous, target :: numbers(:)   !! of size 0: what follows is told
    integer(i8), target :: count
    integer :: problem
    count = size(numbers, kind=i8)
    problem = bw_write(self%channel, c_loc(count), 8_i8)
    if (problem == 0 .and. count > 0) problem = bw_write(self%channel, c_loc(numbers), 8*count)
    if (problem /= 0) call bw_leave(status_bad_file)
    call bw_confine(self%limit)
  end subroutine send

  subroutine receive(self, numbers, good)
    !! Take as many numbers from the child; where it sends others, or ends, `hear` says why.
    class(child_process), intent(in) :: self
    real(dp), intent(inout), contiguous, target :: numbers(:)
    logical, intent(out) :: good
    integer(i8), target :: count
    good = bw_receive(self%channel, c_loc(count), 8_i8) == 8
    if (good) good = count == size(numbers, kind=i8)
    if (good .and. count > 0) good = bw_receive(self%channel, c_loc(numbers), 8*count) == 8*count
  end subroutine receive

  subroutine tell(self, texts, error)
    !! Hand over what was found, and end.
    class(child_process), intent(inout) :: self
    type(string), allocatable, intent(inout) :: texts(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: problem, i
    if (allocated(error)) then
      problem = write_text(self%channel, text_of(error%status)//nul//error%message//nul//last_word)
    else
      problem = write_text(self%channel, text_of(status_done)//nul)
      do i = 1, size(texts)
        if (problem == 0) problem = write_text(self%channel, texts(i)%text//nul)
      end do
      if (problem == 0) problem = write_text(self%channel, last_word)
    end if
    call bw_leave(merge(status_done, status_bad_file, problem == 0))
  end subroutine tell

  subroutine hear(self, texts, error)
    !! Wait for the end of the child, and take what it has found.
    !! **Errors**: those of the work, or that its process did not come to its end.
    class(child_process), intent(inout) :: self
    type(string), allocatable, intent(out) :: texts(:)
    type(error_type), allocatable, intent(inout) :: error
    character(len=most_at_once), target :: piece
    type(text_builder) :: told
    type(string), allocatable :: pieces(:)
    integer :: ended, status, ignored
    logical :: whole
    integer(i8) :: have
    do
      have = bw_receive(self%channel, c_loc(piece), int(most_at_once, i8))
      call told%append(piece(:have))
      if (have < most_at_once) exit
    end do
    pieces = lines_of(told%text(), nul)
    whole = size(pieces) > 1
    if (whole) whole = pieces(size(pieces))%text == last_word
    ignored = close_file(self%channel)
    ended = int(bw_wait(self%number))
    allocate (texts(0))
    if (ended < 0) then
      call fail(error, status_bad_file, 'cannot be read: the library that reads it crashed or found no end (signal '// &
                text_of(-ended)//'); the file is damaged')
    else if (ended == status_fault) then
      call fail(error, status_fault, 'the process that reads it ended in a fault: please report it')
    else if (ended /= status_done .or. .not. whole) then
      call fail(error, status_bad_file, 'the process that reads it was refused memory, or was not heard to its end')
    end if
    if (allocated(error)) return
    read (pieces(1)%text, *) status
    texts = pieces(2:size(pieces) - 1)
    if (status /= status_done) call fail(error, status, texts(1)%text)
  end subroutine hear

end module bw_child_process
