module bw_work_directory
  !! The directory DIR/<result>.partial, in which a result is made as `draft.nc`. Its lock, held by one run at a time,
  !! gives the right to lay out drafts and to name the result. Separately run parts of a sweep hold that lock only
  !! briefly, and each holds one of its own while it works.
  use bw_error, only: error_type, fail, status_bad_file
  use bw_file_lock, only: file_lock, first_of_lock, lock_suffix, unique_name
  use bw_files, only: cannot_be_read, cannot_be_written, directory_is_there, directory_of, files_in, flush_directory, link_file, &
    look_at, make_directory, may_write, path_state, remove_directory, remove_file, rename_file, same_file
  use bw_system_calls, only: bw_kind_of_error, error_is_there, error_not_offered, error_not_there, is_directory
  use bw_text, only: append, string, text_of
  implicit none (type, external)
  private
  public :: give_name

  character(*), parameter :: draft_suffix = '.nc', first_of_draft = 'draft', first_of_part = 'part.', &
    first_of_scratch = 'scratch.'

  type, public :: work_directory
    character(:), allocatable :: path        !! DIR/<result>.partial
    character(:), allocatable :: result      !! DIR/<result>.nc
    logical :: overwrite = .false.           !! replace a result that is there
    integer :: part = 1, parts = 1           !! the part run by this process, and the number of parts
    type(file_lock), private :: lock, part_lock
  contains
    procedure :: plan
    procedure :: begin
    procedure :: begin_part
    procedure :: begin_end
    procedure :: end_part
    procedure :: refuse_other_parts
    procedure :: draft_of
    procedure :: drafts
    procedure :: scratch
    procedure :: publish
    procedure :: discard
    procedure :: leave
    procedure :: clear
  end type work_directory

contains

  pure subroutine plan(self, result, overwrite)
    !! Set the result to be made.
    class(work_directory), intent(inout) :: self
    character(*), intent(in) :: result       !! DIR/<result>.nc
    logical, intent(in) :: overwrite
    self%result = result
    self%path = result(:len(result) - len('.nc'))//'.partial'
    self%overwrite = overwrite
  end subroutine plan

  subroutine begin(self, error)
    !! Make the directory and take its lock; a part takes it briefly.
    !! **Errors**: another run is at work, or the system refuses it.
    class(work_directory), intent(inout) :: self
    type(error_type), allocatable, intent(out) :: error
    type(path_state) :: state
    integer :: problem
    problem = make_directory(self%path)
    if (problem /= 0 .and. bw_kind_of_error(problem) /= error_is_there) call cannot_be_written(error, self%path, problem)
    problem = may_write(directory_of(self%path))         ! of the result
    if (problem /= 0) call cannot_be_written(error, directory_of(self%path), problem)
    problem = look_at(self%path, state, itself=.true.)
    if (problem == 0 .and. state%kind > 0 .and. state%kind /= is_directory .and. .not. allocated(error)) then
      call fail(error, status_bad_file, self%path//': is no directory but a link or a file, which is left as it is; remove it')
    end if
    if (allocated(error)) return
    self%lock%is_brief = self%parts > 1
    call self%lock%take(self%path//'/lock', error)
    if (.not. allocated(error) .and. self%parts == 1) call self%refuse_other_parts(error)
    if (allocated(error)) call self%leave()
    if (.not. allocated(error)) call remove_rubbish(self%path)
  end subroutine begin

  subroutine begin_part(self, error)
    !! Take the lock of the part, and release that of the directory.
    !! **Errors**: another run is at work on this part, or the system refuses it.
    class(work_directory), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    type(error_type), allocatable :: refused
    call self%part_lock%take(self%path//'/'//first_of_part//text_of(self%part)//'-of-'//text_of(self%parts)//lock_suffix, refused)
    call self%lock%give_back()
    if (.not. allocated(error)) call move_alloc(refused, error)
  end subroutine begin_part

  subroutine begin_end(self, is_busy, error)
    !! Take the lock of the directory again; while the part holds its own, no other process finishes the file.
    !! **Errors**: the system refuses it.
    class(work_directory), intent(inout) :: self
    logical, intent(out) :: is_busy          !! another process holds it for longer
    type(error_type), allocatable, intent(inout) :: error
    type(error_type), allocatable :: refused
    call self%lock%take(self%path//'/lock', refused)
    is_busy = allocated(refused) .and. self%lock%is_refused
    if (.not. (is_busy .or. allocated(error))) call move_alloc(refused, error)
  end subroutine begin_end

  subroutine end_part(self, is_busy, error)
    !! Release the lock of the part. If no other part is left, the holder of the directory's lock may finish the file.
    !! **Errors**: it is unknown whether there are other parts.
    class(work_directory), intent(inout) :: self
    logical, intent(inout) :: is_busy        !! others are at work
    type(error_type), allocatable, intent(inout) :: error
    type(error_type), allocatable :: refused
    call self%part_lock%give_back()
    if (is_busy .or. allocated(error)) return
    call self%refuse_other_parts(refused)
    is_busy = allocated(refused) .and. self%part_lock%is_refused
    if (.not. is_busy) call move_alloc(refused, error)
  end subroutine end_part

  subroutine refuse_other_parts(self, error)
    !! Check whether other processes run parts; locks of ended ones are removed.
    !! **Errors**: one does, or this is unknown.
    class(work_directory), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    type(string), allocatable :: names(:)
    integer :: problem, i
    problem = files_in(self%path, lock_suffix, names)
    if (problem /= 0) call cannot_be_read(error, self%path, problem)
    do i = 1, size(names)
      if (index(names(i)%text, first_of_part) /= 1) cycle
      call self%part_lock%refuse_if_held(self%path//'/'//names(i)%text, error)
      if (allocated(error)) return
      problem = remove_file(self%path//'/'//names(i)%text)
    end do
  end subroutine refuse_other_parts

  pure function draft_of(self, host) result(path)
    !! Return the path of the draft of a further host; for an empty name, of the first one, which becomes the result.
    class(work_directory), intent(in) :: self
    character(*), intent(in) :: host
    character(:), allocatable :: path
    path = self%path//'/'//first_of_draft//draft_suffix
    if (host /= '') path = self%path//'/'//first_of_draft//'.'//host//draft_suffix
  end function draft_of

  subroutine drafts(self, paths, error)
    !! List all drafts.
    !! **Errors**: the directory cannot be read.
    class(work_directory), intent(in) :: self
    type(string), allocatable, intent(out) :: paths(:)
    type(error_type), allocatable, intent(inout) :: error
    type(string), allocatable :: names(:)
    integer :: problem, i
    allocate (paths(0))
    problem = files_in(self%path, draft_suffix, names)
    if (problem /= 0 .and. bw_kind_of_error(problem) /= error_not_there) call cannot_be_read(error, self%path, problem)
    do i = 1, size(names)
      if (index(names(i)%text, first_of_draft//'.') == 1) call append(paths, self%path//'/'//names(i)%text)
    end do
  end subroutine drafts

  function scratch(self) result(path)
    !! Return a unique path, for a file that is renamed before the lock is released.
    class(work_directory), intent(in) :: self
    character(:), allocatable :: path
    path = self%path//'/'//first_of_scratch//unique_name()
  end function scratch

  subroutine publish(self, error)
    !! Give the first draft, which is on the disk, the name of the result, durably.
    !! **Errors**: the system refuses it, another run has taken over, or a result has appeared meanwhile.
    class(work_directory), intent(in) :: self
    type(error_type), allocatable, intent(inout) :: error
    logical :: taken
    integer :: problem
    if (.not. self%lock%is_held()) call fail(error, status_bad_file, self%lock%path// &
                                             ': is gone or another run''s; the result was not put in its place')
    if (allocated(error)) return
    call give_name(self%draft_of(''), self%result, self%overwrite, taken, problem)
    if (taken) call fail(error, status_bad_file, self%result//': a result was put there meanwhile; --overwrite replaces it')
    if (problem == 0) problem = flush_directory(directory_of(self%result))
    if (problem /= 0) call cannot_be_written(error, self%result, problem)
  end subroutine publish

  subroutine give_name(draft, path, overwrite, taken, problem)
    !! Name a complete file atomically, within one file system, unless the name exists.
    character(*), intent(in) :: draft, path
    logical, intent(in) :: overwrite         !! an existing file of this name is replaced; a link itself, not its target
    logical, intent(out) :: taken            !! the name exists
    integer, intent(out) :: problem
    type(path_state) :: mine, there
    integer :: linked, ignored
    taken = .false.
    if (overwrite) problem = rename_file(draft, path)
    if (overwrite) return
    linked = link_file(draft, path)
    if (linked == 0) ignored = remove_file(draft)
    problem = linked
    if (all(bw_kind_of_error(linked) /= [error_is_there, error_not_offered])) return
    problem = look_at(path, there)
    if (problem == 0) problem = look_at(draft, mine)
    if (problem /= 0) return
    taken = there%kind > 0 .and. .not. same_file(mine, there)      ! a server may report this when it repeats a successful request
    if (.not. taken) problem = rename_file(draft, path)
  end subroutine give_name

  subroutine discard(self)
    !! Remove all drafts, and release the lock.
    class(work_directory), intent(inout) :: self
    type(string), allocatable :: paths(:)
    type(error_type), allocatable :: ignored_too
    integer :: ignored, i
    if (self%lock%is_held()) then
      call self%drafts(paths, ignored_too)
      do i = 1, size(paths)
        ignored = remove_file(paths(i)%text)
      end do
    end if
    call self%leave()
  end subroutine discard

  subroutine leave(self)
    !! Release the locks; the directory stays if it is not empty.
    class(work_directory), intent(inout) :: self
    integer :: ignored
    if (self%lock%is_held()) call remove_rubbish(self%path)
    call self%lock%give_back()
    call self%part_lock%give_back()
    ignored = remove_directory(self%path)
  end subroutine leave

  subroutine clear(self)
    !! Remove what a run left that was killed after it had named its result, unless another run is at work.
    class(work_directory), intent(inout) :: self
    type(error_type), allocatable :: error
    if (.not. directory_is_there(self%path)) return
    call self%begin(error)
    if (.not. allocated(error)) call self%leave()
  end subroutine clear

  subroutine remove_rubbish(path)
    !! Remove unfinished temporary files of runs, and nothing else.
    character(*), intent(in) :: path
    integer :: ignored, i
    type(string), allocatable :: names(:)
    ignored = files_in(path, '', names)
    do i = 1, size(names)
      if (index(names(i)%text, first_of_lock) == 1 .or. index(names(i)%text, first_of_scratch) == 1) &
        ignored = remove_file(path//'/'//names(i)%text)
    end do
  end subroutine remove_rubbish

end module bw_work_directory
