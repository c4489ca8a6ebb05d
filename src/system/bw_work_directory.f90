module bw_work_directory
  !! The directory DIR/<result>.partial, in which a result is made: one run at a time has its lock, and with it the right to give
  !! the result its name. Whatever is written there has a name of its own, which no other process and no later run can have.
  use bw_descriptors, only: flush_path
  use bw_error, only: error_type, fail, status_bad_file
  use bw_file_lock, only: draft_of_lock => draft_suffix, file_lock, is_unique_name, unique_name
  use bw_files, only: cannot_be_written, directory_is_there, directory_of, files_in, flush_directory, link_file, look_at, &
    make_directory, may_write, path_state, remove_directory, remove_file, rename_file, same_file
  use bw_system_calls, only: bw_kind_of_error, error_is_there, error_not_offered, is_directory
  use bw_text, only: string
  implicit none (type, external)
  private
  public :: give_name

  character(*), parameter :: lock_name = '/lock', draft_suffix = '.nc'

  type, public :: work_directory
    character(:), allocatable :: path        !! DIR/<result>.partial
    character(:), allocatable :: result      !! DIR/<result>.nc
    logical :: overwrite = .false.           !! replace a result that is there
    type(file_lock), private :: lock
  contains
    procedure :: plan
    procedure :: begin
    procedure :: new_draft
    procedure :: publish
    procedure :: leave
    procedure :: clear
  end type work_directory

contains

  pure subroutine plan(self, result, overwrite)
    !! Which result is to be made.
    class(work_directory), intent(inout) :: self
    character(*), intent(in) :: result       !! DIR/<result>.nc
    logical, intent(in) :: overwrite
    self%result = result
    self%path = result(:len(result) - len('.nc'))//'.partial'
    self%overwrite = overwrite
  end subroutine plan

  subroutine begin(self, error)
    !! Make the directory, take its lock, and take away what a killed run left half written.
    !! **Errors**: another run is at work, or the system refuses it.
    class(work_directory), intent(inout) :: self
    type(error_type), allocatable, intent(out) :: error
    type(path_state) :: state
    integer :: problem
    problem = make_directory(self%path)
    if (problem /= 0 .and. bw_kind_of_error(problem) /= error_is_there) call cannot_be_written(error, self%path, problem)
    problem = may_write(directory_of(self%path))         ! where the result will get its name
    if (problem /= 0) call cannot_be_written(error, directory_of(self%path), problem)
    problem = look_at(self%path, state, itself=.true.)
    if (problem == 0 .and. state%kind > 0 .and. state%kind /= is_directory .and. .not. allocated(error)) then
      call fail(error, status_bad_file, self%path//': is no directory but a link or a file, which is left as it is; remove it')
    end if
    if (allocated(error)) return
    call self%lock%take(self%path//lock_name, error)
    if (.not. allocated(error)) call remove_all(self%path, draft_suffix)
  end subroutine begin

  function new_draft(self) result(path)
    !! Where a result is written until it is whole.
    class(work_directory), intent(in) :: self
    character(:), allocatable :: path
    path = self%path//'/'//unique_name()//draft_suffix
  end function new_draft

  subroutine publish(self, draft, error)
    !! Give a whole result its name, so that it outlives the machine.
    !! **Errors**: it cannot be written, another run has taken the work over, or a result was put there meanwhile.
    class(work_directory), intent(in) :: self
    character(*), intent(in) :: draft
    type(error_type), allocatable, intent(inout) :: error
    logical :: taken
    integer :: problem
    problem = flush_path(draft)
    if (problem /= 0) then
      call cannot_be_written(error, draft, problem)
    else if (.not. self%lock%is_held()) then
      call fail(error, status_bad_file, self%lock%path//': is gone or another run''s; the result was not put in its place')
    end if
    if (allocated(error)) return
    call give_name(draft, self%result, self%overwrite, taken, problem)
    if (taken) call fail(error, status_bad_file, self%result//': a result was put there meanwhile; --overwrite replaces it')
    if (problem == 0) problem = flush_directory(directory_of(self%result))
    if (problem /= 0) call cannot_be_written(error, self%result, problem)
  end subroutine publish

  subroutine give_name(draft, path, overwrite, taken, problem)
    !! Give a file that is whole its name, at once and within one file system, unless something has the name.
    character(*), intent(in) :: draft, path
    logical, intent(in) :: overwrite         !! what has the name is replaced; a link itself, and not what it leads to
    logical, intent(out) :: taken            !! something has
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
    taken = there%kind > 0 .and. .not. same_file(mine, there)      ! a server may say that of its own answer to a first try
    if (.not. taken) problem = rename_file(draft, path)
  end subroutine give_name

  subroutine leave(self)
    !! Take away what is half written, and give the lock back; the directory stays where work is left in it.
    class(work_directory), intent(inout) :: self
    integer :: ignored
    if (self%lock%is_held()) then
      call remove_all(self%path, draft_suffix)
      call remove_all(self%path, draft_of_lock)
    end if
    call self%lock%give_back()
    ignored = remove_directory(self%path)
  end subroutine leave

  subroutine clear(self)
    !! Take away what a run left that was killed when its result had its final name already, unless another run is at work.
    class(work_directory), intent(inout) :: self
    type(error_type), allocatable :: error
    if (.not. directory_is_there(self%path)) return
    call self%begin(error)
    if (.not. allocated(error)) call self%leave()
  end subroutine clear

  subroutine remove_all(path, suffix)
    !! Remove what has such a name as runs give, as far as that is possible; whatever else is there is not theirs.
    character(*), intent(in) :: path, suffix
    type(string), allocatable :: names(:)
    integer :: ignored, i
    ignored = files_in(path, suffix, names)
    do i = 1, size(names)
      associate (name => names(i)%text)
        if (is_unique_name(name(:len(name) - len(suffix)))) ignored = remove_file(path//'/'//name)
      end associate
    end do
  end subroutine remove_all

end module bw_work_directory
