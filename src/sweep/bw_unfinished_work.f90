module bw_unfinished_work
  !! The unfinished work of a scene: the scene, what its result will hold, and the directory with the journals of its finished
  !! cases. Nothing is taken away but what has been read, under the lock, as this work's own, or as work of another scene or
  !! version whose place a run takes.
  use bw_checksum, only: word_sum, words_of_text
  use bw_error, only: error_type, fail, status_stopped
  use bw_file_lock, only: is_unique_name
  use bw_files, only: cannot_be_read, cannot_be_written, directory_is_there, files_in, remove_file
  use bw_journal_reader, only: journal_reader
  use bw_kinds, only: i1, i8
  use bw_monitor, only: monitor_type, stops
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_system_calls, only: bw_kind_of_error, error_not_there
  use bw_text, only: append, string
  use bw_work_directory, only: work_directory
  implicit none (type, external)
  private

  character(*), parameter, public :: journal_suffix = '.journal'

  type, extends(work_directory), public :: unfinished_work
    type(scene_type) :: scene
    type(result_layout) :: layout             !! of the scene's result
    character(:), allocatable :: identity     !! what the journals have to belong to: program, version, layout and resolved scene
    type(string), allocatable :: own(:)       !! journals of this work, as they were found last
    type(string), allocatable, private :: others(:)
    integer(i8) :: damaged = 0                !! records in them that are not what they were
  contains
    procedure :: survey
    procedure :: has_others
    procedure :: remove_others
    procedure :: discard
    procedure :: clear
    procedure :: sum_of_identity
    procedure, private :: read_journal
  end type unfinished_work

contains

  subroutine survey(self, count, done, error, monitor)
    !! Read all journals, and find out which cases are finished. Files that no run has named are not looked at.
    !! **Errors**: one cannot be read; `status_stopped` where the monitor asks to stop.
    class(unfinished_work), intent(inout) :: self
    integer(i8), intent(in) :: count          !! numbers of a case
    integer(i1), intent(inout) :: done(:)     !! (cases), set to 1
    type(error_type), allocatable, intent(inout) :: error
    class(monitor_type), intent(inout), optional :: monitor
    type(string), allocatable :: names(:)
    type(journal_reader) :: reader
    logical :: is_others, is_readable
    integer :: problem, i
    self%damaged = 0
    if (allocated(self%own)) deallocate (self%own, self%others)
    allocate (self%own(0), self%others(0))
    problem = files_in(self%path, journal_suffix, names)
    if (problem /= 0 .and. bw_kind_of_error(problem) /= error_not_there) call cannot_be_read(error, self%path, problem)
    do i = 1, size(names)
      if (.not. is_journal(names(i)%text)) cycle
      call reader%open(self%path//'/'//names(i)%text, error)
      call self%read_journal(reader, count, done, is_others, is_readable, error, monitor)
      call reader%close()
      if (allocated(error)) return
      self%damaged = self%damaged + reader%damaged
      if (is_others) then
        call append(self%others, reader%path)
      else if (is_readable) then
        call append(self%own, reader%path)
      end if
    end do
  end subroutine survey

  pure logical function is_journal(name)
    !! Whether a file has such a name as runs give to journals: one of their own, and the number of a process.
    character(*), intent(in) :: name
    integer :: last
    last = index(name, '-', back=.true.) - 1
    is_journal = last > 0
    if (is_journal) is_journal = is_unique_name(name(:last))
  end function is_journal

  subroutine read_journal(self, reader, count, done, is_others, is_readable, error, monitor)
    !! Read all sound records of a journal.
    class(unfinished_work), intent(in) :: self
    type(journal_reader), intent(inout) :: reader
    integer(i8), intent(in) :: count
    integer(i1), intent(inout) :: done(:)
    logical, intent(out) :: is_others         !! it belongs to other work, and says so
    logical, intent(out) :: is_readable       !! some of it is sound, or nothing was written yet
    type(error_type), allocatable, intent(inout) :: error
    class(monitor_type), intent(inout), optional :: monitor
    logical :: found, any_found
    is_others = .false.
    any_found = .false.
    do
      if (stops(monitor) .and. .not. allocated(error)) call fail(error, status_stopped, self%result// &
        ': stopped while the cases of an earlier run were read; nothing is changed')
      call reader%next(found, error)
      any_found = any_found .or. found
      is_readable = any_found .or. reader%damaged == 0
      if (.not. found) return
      is_others = reader%work /= self%sum_of_identity()
      if (is_others) return
      if (reader%case < 1 .or. reader%case > size(done, kind=i8) .or. size(reader%numbers, kind=i8) /= count) cycle
      done(reader%case) = 1_i1
    end do
  end subroutine read_journal

  pure integer(i8) function sum_of_identity(self)
    !! The checksum of the identity, which each record of this work's journals has.
    class(unfinished_work), intent(in) :: self
    sum_of_identity = word_sum(words_of_text(self%identity))
  end function sum_of_identity

  pure logical function has_others(self)
    !! Whether the survey has found work of another scene or version.
    class(unfinished_work), intent(in) :: self
    has_others = size(self%others) > 0
  end function has_others

  subroutine remove_others(self, error)
    !! Remove the journals of other work that the survey has found.
    !! **Errors**: one cannot be removed.
    class(unfinished_work), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    integer :: problem, i
    do i = 1, size(self%others)
      problem = remove_file(self%others(i)%text)
      if (problem /= 0) call cannot_be_written(error, self%others(i)%text, problem)
    end do
  end subroutine remove_others

  subroutine discard(self)
    !! Take away the journals of this work that the last survey has found, and give the lock back.
    class(unfinished_work), intent(inout) :: self
    integer :: ignored, i
    do i = 1, size(self%own)
      ignored = remove_file(self%own(i)%text)
    end do
    call self%leave()
  end subroutine discard

  subroutine clear(self)
    !! Take away what a run left that was killed when its result had its final name already, unless another run is at work.
    !! Cases of another scene or version are not touched: a run of that may still want them.
    class(unfinished_work), intent(inout) :: self
    type(error_type), allocatable :: error
    integer(i1) :: none(0)
    if (.not. directory_is_there(self%path)) return
    call self%begin(error)
    if (allocated(error)) return
    call self%survey(0_i8, none, error)
    if (allocated(error) .or. self%has_others()) then
      call self%leave()
    else
      call self%discard()
    end if
  end subroutine clear

end module bw_unfinished_work
