module bw_unfinished
  !! The unfinished work of a sweep, in a directory of its own: the journals of its finished cases, and a lock.
  use bw_case_journal, only: journal_reader
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kinds, only: i1, i8
  use bw_posix, only: close_descriptor, file_exists, files_in, is_directory, lock_file, make_directory, &
    remove_directory, remove_file
  use bw_text, only: string
  implicit none (type, external)
  private

  character(*), parameter :: suffix = '.cases', lock_name = '/lock', result_name = '/result.nc', notes_name = '/notes'
  integer, parameter :: attempts = 100       !! at a lock whose file its last holder takes away

  type, public :: unfinished_work
    character(:), allocatable :: directory
    character(:), allocatable :: work        !! what the journals have to belong to: program, version and resolved scene
    integer, private :: lock = -1
  contains
    procedure :: begin
    procedure :: survey
    procedure :: saved
    procedure :: journals
    procedure :: journal
    procedure :: next_number
    procedure :: result_path
    procedure :: release
    procedure :: discard
    procedure :: clear
  end type unfinished_work

contains

  subroutine begin(self, error)
    !! Make the directory and take its lock.
    !! **Errors**: the directory cannot be made, or another run is at work.
    class(unfinished_work), intent(inout) :: self
    type(error_type), allocatable, intent(out) :: error
    logical :: held
    integer :: i
    do i = 1, attempts
      if (.not. make_directory(self%directory)) then
        call fail(error, status_bad_file, self%directory//': the directory cannot be made')
        return
      end if
      call lock_file(self%directory//lock_name, self%lock, held)
      if (held) then
        call fail(error, status_bad_file, self%directory//': another run is at work on this scene')
        return
      end if
      if (self%lock < 0) return                              ! a directory that nobody may write, as will be seen
      if (file_exists(self%directory//lock_name)) return
      call close_descriptor(self%lock)
    end do
  end subroutine begin

  subroutine survey(self, done, foreign)
    !! Which cases are finished. What belongs to another scene or version is taken away.
    class(unfinished_work), intent(in) :: self
    integer(i1), intent(inout) :: done(:)    !! (cases), set to 1
    logical, intent(out), optional :: foreign   !! something was taken away
    type(string), allocatable :: paths(:)
    type(journal_reader) :: reader
    integer(i8) :: index
    logical :: other
    integer :: i
    other = file_exists(self%directory//notes_name)          ! of a version that kept its cases in another form
    call remove_file(self%directory//notes_name)
    call remove_file(self%directory//result_name)
    paths = self%journals()
    do i = 1, size(paths)
      if (.not. reader%open(paths(i)%text, self%work)) then
        other = .true.
        call remove_file(paths(i)%text)
        cycle
      end if
      do while (reader%next(index))
        if (index >= 1 .and. index <= size(done, kind=i8)) done(index) = 1_i1
      end do
      call reader%close()
    end do
    if (present(foreign)) foreign = other
  end subroutine survey

  integer(i8) function saved(self, cases)
    !! How many cases are finished and can still be read: what lies on the disk counts, not what was done.
    class(unfinished_work), intent(in) :: self
    integer(i8), intent(in) :: cases         !! of the sweep
    type(string), allocatable :: paths(:)
    type(journal_reader) :: reader
    integer(i1) :: done(cases)
    integer(i8) :: index
    integer :: i
    done = 0_i1
    paths = self%journals()
    do i = 1, size(paths)
      if (.not. reader%open(paths(i)%text, self%work)) cycle
      do while (reader%next(index))
        if (index >= 1 .and. index <= cases) done(index) = 1_i1
      end do
      call reader%close()
    end do
    saved = count(done /= 0_i1, kind=i8)
  end function saved

  function journals(self) result(paths)
    !! Those that are there.
    class(unfinished_work), intent(in) :: self
    type(string), allocatable :: paths(:)
    paths = files_in(self%directory, suffix)
  end function journals

  pure function journal(self, number) result(path)
    class(unfinished_work), intent(in) :: self
    integer, intent(in) :: number            !! from 1
    character(:), allocatable :: path
    character(12) :: digits
    write (digits, '(i6.6)') number
    path = self%directory//'/'//trim(digits)//suffix
  end function journal

  integer function next_number(self) result(number)
    !! The first number above those of all journals: a process that is cut off from its run may still write to its own.
    class(unfinished_work), intent(in) :: self
    type(string), allocatable :: paths(:)
    integer :: i, stat, there
    number = 1
    paths = self%journals()
    do i = 1, size(paths)
      associate (path => paths(i)%text)
        read (path(index(path, '/', back=.true.) + 1:len(path) - len(suffix)), *, iostat=stat) there
      end associate
      if (stat == 0) number = max(number, there + 1)
    end do
  end function next_number

  pure function result_path(self) result(path)
    !! Where the result is made.
    class(unfinished_work), intent(in) :: self
    character(:), allocatable :: path
    path = self%directory//result_name
  end function result_path

  subroutine release(self)
    !! Leave the work for later.
    class(unfinished_work), intent(inout) :: self
    call close_descriptor(self%lock)
    self%lock = -1
  end subroutine release

  subroutine discard(self)
    !! Take the unfinished work away.
    class(unfinished_work), intent(inout) :: self
    type(string), allocatable :: paths(:)
    integer :: i
    paths = self%journals()
    do i = 1, size(paths)
      call remove_file(paths(i)%text)
    end do
    call remove_file(self%result_path())
    call remove_file(self%directory//lock_name)
    call remove_directory(self%directory)
    call self%release()
  end subroutine discard

  subroutine clear(self)
    !! Take away what a run left that was killed when its result had its final name already, unless another run is at work.
    class(unfinished_work), intent(inout) :: self
    type(error_type), allocatable :: ignored
    if (.not. is_directory(self%directory)) return
    call self%begin(ignored)
    if (.not. allocated(ignored)) call self%discard()
  end subroutine clear

end module bw_unfinished
