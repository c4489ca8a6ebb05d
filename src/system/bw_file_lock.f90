module bw_file_lock
  !! A lock: a file held by one process at a time. Its text names the holder: host, process and start time. If the file
  !! system has `flock`, the lock ends with its holder in any case. Else, as in Lustre by default, the file's existence
  !! is the lock: a dead holder on this host is detected, and the message says how to remove the lock of another host. A
  !! lock held briefly says so and is waited for, as is one without a text yet.
  use, intrinsic :: iso_c_binding, only: c_int, c_null_char
  use bw_descriptors, only: close_file, look_at_open, new_file, open_file, read_bytes, to_change, write_text
  use bw_error, only: error_type, fail, status_bad_file
  use bw_files, only: cannot_be_written, directory_of, link_file, look_at, make_directory, path_state, remove_file, &
    rename_file, same_file
  use bw_kinds, only: i1, i8
  use bw_system_calls, only: bw_beginning_of, bw_host, bw_kind_of_error, bw_lock, bw_pause, bw_process, &
    error_is_held, error_is_there, error_not_offered, error_not_there
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: first_of_lock, lock_suffix, is_locked_to_write, own_host, unique_name

  character(*), parameter :: lock_suffix = '.lock', first_of_lock = 'lock.'     !! the latter of a lock being removed
  integer, parameter :: attempts = 3000      !! at a lock that is being removed, with or without its directory, or is held briefly
  integer, parameter :: wait_microseconds = 20000      !! for the latter
  integer, parameter :: longest = 600        !! letters of a lock's text, which is as long as that: it is written over others
  character(*), parameter :: for_moments = 'moments', for_a_run = 'run'
  character(*), parameter :: no_locks = '; this file system has no locks: if it is no longer there, remove this file'
  integer(c_int), parameter :: to_write = 0, to_read = 1

  type, public :: file_lock
    character(:), allocatable :: path
    logical :: is_brief = .false.            !! it is held briefly
    logical :: is_refused = .false.          !! another process holds it, or did at the last attempt
    logical, private :: other_is_brief = .false.      !! the other holder holds it briefly
    integer, private :: descriptor = -1      !! of this process's lock
  contains
    procedure :: take
    procedure :: refuse_if_held
    procedure :: is_held
    procedure :: give_back
    procedure, private :: try
    procedure, private :: refuse
  end type file_lock

contains

  function unique_name() result(name)
    !! Return a unique name: host, process and the time to the millisecond.
    character(:), allocatable :: name
    character(8) :: date
    character(10) :: time
    call date_and_time(date, time)
    name = own_host()//'-'//text_of(bw_process())//'-'//date//'T'//time
  end function unique_name

  function own_host() result(name)
    !! Return the name of this host.
    character(:), allocatable :: name
    character(256) :: buffer
    call bw_host(buffer, len(buffer))
    name = buffer(:index(buffer, c_null_char) - 1)
  end function own_host

  subroutine take(self, path, error)
    !! Make the lock's directory, and take the lock. **Errors**: another run holds it, or the system refuses it.
    class(file_lock), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(out) :: error
    logical :: taken
    integer :: problem, ignored, i
    self%path = path
    do i = 1, attempts
      self%is_refused = .false.
      call self%try(taken, problem, error)
      if (taken) return
      ignored = close_file(self%descriptor)
      if (problem /= 0 .and. bw_kind_of_error(problem) /= error_not_there) call cannot_be_written(error, path, problem)
      if (.not. allocated(error)) cycle
      if (problem /= 0 .or. .not. self%other_is_brief .or. i == attempts) return
      deallocate (error)
      call bw_pause(wait_microseconds)
    end do
    call fail(error, status_bad_file, path//': other runs take and leave this lock all the time')
  end subroutine take

  subroutine try(self, taken, problem, error)
    !! Open or create the lock, and take it if it is free. **Errors**: it is held, or this is unknown.
    class(file_lock), intent(inout) :: self
    logical, intent(out) :: taken            !! false without an error: the lock has changed meanwhile, try again
    integer, intent(out) :: problem          !! of the system
    type(error_type), allocatable, intent(inout) :: error
    character(longest) :: text
    type(path_state) :: opened
    integer :: locked, ignored
    logical :: is_new, is_the_file           ! the file's existence is the lock
    taken = .false.
    problem = make_directory(directory_of(self%path))
    if (problem == 0) problem = open_file(self%path, new_file, self%descriptor)
    is_new = problem == 0
    if (bw_kind_of_error(problem) == error_is_there) problem = open_file(self%path, to_change, self%descriptor)
    if (problem /= 0) return
    locked = bw_lock(self%descriptor, to_write)
    is_the_file = bw_kind_of_error(locked) == error_not_offered
    if (bw_kind_of_error(locked) == error_is_held) then
      call self%refuse(self%path, self%descriptor, '', error)
    else if (is_the_file .and. .not. is_new) then
      if (.not. holder_is_gone(self%descriptor)) call self%refuse(self%path, self%descriptor, no_locks, error)
      problem = look_at_open(self%descriptor, opened)
      if (problem == 0 .and. .not. allocated(error)) call bury(self%path, opened)
    else
      if (.not. is_the_file) problem = locked
      if (problem == 0) taken = self%is_held()               ! unless the file has been renamed meanwhile
      text = own_host()//' '//text_of(bw_process())//' '//text_of(bw_beginning_of(bw_process()))//' '// &
        trim(merge(for_moments, for_a_run//'    ', self%is_brief))//new_line('a')// &
        'host, process and beginning (in ticks of /proc) of a run of beamwave; once it is no longer there, this file may be removed'
      text(longest:) = new_line('a')
      if (taken) problem = write_text(self%descriptor, text)
      taken = taken .and. problem == 0
      if (is_new .and. problem /= 0) ignored = remove_file(self%path)
    end if
  end subroutine try

  subroutine refuse(self, path, descriptor, advice, error)
    !! Report that another run holds a lock, and which one, as far as its text says.
    class(file_lock), intent(inout) :: self
    character(*), intent(in) :: path
    integer, intent(in) :: descriptor
    character(*), intent(in) :: advice
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: host
    integer(i8) :: process, beginning
    self%is_refused = .true.
    call read_holder(descriptor, host, process, beginning, self%other_is_brief)
    if (host == '') then
      call fail(error, status_bad_file, path//': is a lock that names no run; once no run is at work on this scene, remove it')
    else
      call fail(error, status_bad_file, path//': another run is at work on this scene: process '//text_of(process)// &
                ' on host '//host//advice)
    end if
  end subroutine refuse

  subroutine refuse_if_held(self, path, error)
    !! Check whether any process holds a lock, without changing it. **Errors**: one does, as far as is known.
    class(file_lock), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    integer :: descriptor, ignored
    self%is_refused = .false.
    if (open_file(path, to_change, descriptor) /= 0) return
    select case (bw_kind_of_error(bw_lock(descriptor, to_write)))
    case (error_is_held)
      call self%refuse(path, descriptor, '', error)
    case (error_not_offered)
      if (.not. holder_is_gone(descriptor)) call self%refuse(path, descriptor, no_locks, error)
    end select
    ignored = close_file(descriptor)
  end subroutine refuse_if_held

  logical function holder_is_gone(descriptor)
    !! Return whether the holder was a process of this host that has ended.
    integer, intent(in) :: descriptor
    character(:), allocatable :: host
    integer(i8) :: process, beginning
    logical :: ignored
    call read_holder(descriptor, host, process, beginning, ignored)
    holder_is_gone = .false.
    if (host /= own_host() .or. process <= 0) return
    associate (now => bw_beginning_of(process))
      holder_is_gone = now < 0 .or. (now > 0 .and. beginning > 0 .and. now /= beginning)
    end associate
  end function holder_is_gone

  logical function is_locked_to_write(descriptor)
    !! Return whether another program has locked this file for writing.
    integer, intent(in) :: descriptor
    is_locked_to_write = bw_kind_of_error(bw_lock(descriptor, to_read)) == error_is_held
  end function is_locked_to_write

  subroutine read_holder(descriptor, host, process, beginning, is_brief)
    !! Parse the text of a lock; host is empty and process 0 if it is invalid.
    integer, intent(in) :: descriptor
    character(:), allocatable, intent(out) :: host
    integer(i8), intent(out) :: process, beginning
    logical, intent(out) :: is_brief
    integer(i1) :: bytes(longest)
    character(longest) :: text
    character(256) :: name, how_long
    integer(i8) :: have
    integer :: stat
    host = ''
    process = 0
    beginning = 0
    is_brief = .false.
    if (read_bytes(descriptor, 0_i8, bytes, have) /= 0) return
    is_brief = have == 0
    text = transfer(bytes(:have), text(:have))
    text(have + 1:) = ' '//for_a_run               ! if the text is truncated
    read (text, *, iostat=stat) name, process, beginning, how_long
    if (stat /= 0) return
    host = trim(name)
    is_brief = how_long == for_moments
  end subroutine read_holder

  subroutine bury(path, dead)
    !! Remove a dead lock. If another run has replaced it meanwhile, its lock gets the name back.
    character(*), intent(in) :: path
    type(path_state), intent(in) :: dead
    character(:), allocatable :: grave
    type(path_state) :: taken
    integer :: ignored
    grave = directory_of(path)//first_of_lock//unique_name()
    if (rename_file(path, grave) /= 0) return
    ignored = look_at(grave, taken)
    if (.not. same_file(taken, dead)) ignored = link_file(grave, path)
    ignored = remove_file(grave)
  end subroutine bury

  logical function is_held(self)
    !! Return whether the lock still has its name: no process has removed or taken it.
    class(file_lock), intent(in) :: self
    type(path_state) :: mine, named
    integer :: problem
    is_held = self%descriptor >= 0
    if (.not. is_held) return
    problem = look_at_open(self%descriptor, mine)
    if (problem == 0) problem = look_at(self%path, named)
    is_held = problem == 0 .and. same_file(mine, named)
  end function is_held

  subroutine give_back(self)
    !! Remove the lock, if this process still holds it.
    class(file_lock), intent(inout) :: self
    integer :: ignored
    if (self%is_held()) ignored = remove_file(self%path)
    ignored = close_file(self%descriptor)
  end subroutine give_back

end module bw_file_lock
