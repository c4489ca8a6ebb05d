module bw_unfinished
  !! The unfinished work of a sweep, in a directory of its own: the journals of its finished cases, the result under way with
  !! its head, and a lock.
  use bw_case_journal, only: journal_reader
  use bw_descriptor, only: close_descriptor
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kinds, only: dp, i1, i8
  use bw_posix, only: file_exists, files_in, is_directory, lock_file, make_directory, remove_directory, remove_file
  use bw_result_body, only: result_body
  use bw_text, only: string
  implicit none (type, external)
  private

  character(*), parameter :: suffix = '.cases', lock_name = '/lock', result_name = '/result.nc', head_name = '/head.nc', &
    new_head_name = '/head.nc.new', notes_name = '/notes'
  integer, parameter :: attempts = 100       !! at a lock whose file its last holder takes away

  type, public :: unfinished_work
    character(:), allocatable :: directory
    character(:), allocatable :: work        !! what the journals have to belong to: program, version and resolved scene
    logical :: straight = .true.             !! long fields may be written straight into the result under way
    integer, private :: lock = -1
  contains
    procedure :: begin
    procedure :: survey
    procedure :: saved
    procedure :: journals
    procedure :: journal
    procedure :: next_number
    procedure :: result_path
    procedure :: head_path
    procedure :: new_head_path
    procedure :: remove_result
    procedure :: release
    procedure :: discard
    procedure :: clear
    procedure, private :: holds_others
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

  subroutine survey(self, done, body, foreign, damaged, error)
    !! Which cases are finished. What belongs to another scene or version is taken away.
    !! **Errors**: a journal cannot be read. It may hold finished cases, and stays.
    class(unfinished_work), intent(in) :: self
    integer(i1), intent(inout) :: done(:)    !! (cases), set to 1
    type(result_body), intent(in) :: body    !! where their long fields lie
    logical, intent(out) :: foreign          !! something was taken away
    integer(i8), intent(out) :: damaged      !! how many cases were finished, and their long fields are not what they were
    type(error_type), allocatable, intent(out) :: error
    type(string), allocatable :: paths(:)
    type(journal_reader) :: reader
    real(dp), allocatable :: room(:)
    integer(i1) :: lost(size(done))
    integer(i8) :: index
    logical :: readable
    integer :: i
    damaged = 0
    foreign = file_exists(self%directory//notes_name)        ! of a version that kept its cases in another form
    call remove_file(self%directory//notes_name)
    lost = 0_i1
    allocate (room(body%case_length()))
    paths = self%journals()
    do i = 1, size(paths)
      if (.not. reader%open(paths(i)%text, self%work, readable)) then
        if (.not. readable) then
          call fail(error, status_bad_file, paths(i)%text//': cannot be read; it may hold finished cases')
          return
        end if
        foreign = .true.
        call remove_file(paths(i)%text)
        cycle
      end if
      do while (reader%next(index))
        if (index < 1 .or. index > size(done, kind=i8)) cycle
        if (done(index) /= 0_i1) cycle
        if (body%has_all(index, reader%elsewhere(), reader%total_elsewhere(), room)) then
          done(index) = 1_i1
        else
          lost(index) = 1_i1
        end if
      end do
      call reader%close()
    end do
    damaged = count(lost /= 0_i1 .and. done == 0_i1, kind=i8)
  end subroutine survey

  integer(i8) function saved(self, cases)
    !! How many cases are finished and can still be read: what lies on the disk counts, not what was done.
    class(unfinished_work), intent(in) :: self
    integer(i8), intent(in) :: cases         !! of the sweep
    type(string), allocatable :: paths(:)
    type(journal_reader) :: reader
    integer(i1) :: done(cases)
    integer(i8) :: index
    logical :: has_result
    integer :: i
    done = 0_i1
    has_result = file_exists(self%result_path())
    paths = self%journals()
    do i = 1, size(paths)
      if (.not. reader%open(paths(i)%text, self%work)) cycle
      do while (reader%next(index))
        if (index < 1 .or. index > cases) cycle
        if (has_result .or. reader%elsewhere() == 0) done(index) = 1_i1
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

  pure function head_path(self) result(path)
    !! What a result that is written straight has beside its cases.
    class(unfinished_work), intent(in) :: self
    character(:), allocatable :: path
    path = self%directory//head_name
  end function head_path

  pure function new_head_path(self) result(path)
    !! Where it lies until it is whole.
    class(unfinished_work), intent(in) :: self
    character(:), allocatable :: path
    path = self%directory//new_head_name
  end function new_head_path

  subroutine remove_result(self)
    !! Take the result under way, and its head.
    class(unfinished_work), intent(in) :: self
    call remove_file(self%head_path())
    call remove_file(self%new_head_path())
    call remove_file(self%result_path())
  end subroutine remove_result

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
    call self%remove_result()
    call remove_file(self%directory//lock_name)
    call remove_directory(self%directory)
    call self%release()
  end subroutine discard

  subroutine clear(self)
    !! Take away what a run left that was killed when its result had its final name already, unless another run is at work.
    !! Cases of another scene or version are not touched: a run of that may still want them.
    class(unfinished_work), intent(inout) :: self
    type(error_type), allocatable :: ignored
    if (.not. is_directory(self%directory)) return
    call self%begin(ignored)
    if (allocated(ignored)) return
    if (self%holds_others()) then
      call self%release()
    else
      call self%discard()
    end if
  end subroutine clear

  logical function holds_others(self)
    !! A journal is there that is not of this work, or cannot be read.
    class(unfinished_work), intent(in) :: self
    type(string), allocatable :: paths(:)
    type(journal_reader) :: reader
    integer :: i
    holds_others = .false.
    paths = self%journals()
    do i = 1, size(paths)
      holds_others = .not. reader%open(paths(i)%text, self%work)
      if (holds_others) return
      call reader%close()
    end do
  end function holds_others

end module bw_unfinished
