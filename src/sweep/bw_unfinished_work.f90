module bw_unfinished_work
  !! The unfinished work of a scene: the scene, the layout of its result, and the drafts with its finished cases. The
  !! draft of the first host becomes the result; each further host has its own, since clients of a file server write
  !! back whole pages. A draft is removed only after it was read under the lock, and recognised as of this work, or of
  !! another scene or version that a run replaces; a run of a part replaces none.
  use bw_case_result, only: case_done, case_misfit
  use bw_error, only: error_type, fail, status_bad_file
  use bw_file_lock, only: own_host
  use bw_files, only: cannot_be_written, directory_is_there, look_at, path_state, remove_file
  use bw_kinds, only: i1
  use bw_result_draft, only: not_done, result_draft
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_text, only: string
  use bw_work_directory, only: work_directory
  implicit none (type, external)
  private

  type, extends(work_directory), public :: unfinished_work
    type(scene_type) :: scene
    type(result_layout) :: layout             !! of the scene's result
    type(result_draft) :: draft               !! laid out; open if this process puts its cases into it
    character(:), allocatable :: owner        !! the host of the first draft; empty: none
    logical :: took_away = .false.            !! removed drafts of another scene or version, or damaged ones
  contains
    procedure :: remove
    procedure :: survey
    procedure :: provide
    procedure :: open_draft
    procedure :: merge => merge_drafts
    procedure :: clear
  end type unfinished_work

contains

  subroutine remove(self, own, others, error)
    !! Remove drafts of this work, or of other work.
    !! **Errors**: one cannot be read or removed, or is other work, which a part may not remove.
    class(unfinished_work), intent(inout) :: self
    logical, intent(in) :: own, others
    type(error_type), allocatable, intent(inout) :: error
    type(string), allocatable :: paths(:)
    logical :: is_ours
    integer :: i, problem
    call self%drafts(paths, error)
    do i = 1, size(paths)
      call self%draft%open(paths(i)%text, .false., is_ours, error)
      call self%draft%file%close()
      if (allocated(error)) return
      if (.not. merge(own, others, is_ours)) cycle
      if (self%parts > 1 .and. .not. is_ours) call fail(error, status_bad_file, self%path//': contains unfinished work of '// &
        'another scene, table or version, perhaps of another part, which a part does not remove: remove it, or run the scene '// &
        'once without --part')
      if (allocated(error)) return
      self%took_away = self%took_away .or. .not. is_ours
      problem = remove_file(paths(i)%text)
      if (problem /= 0) call cannot_be_written(error, paths(i)%text, problem)
    end do
  end subroutine remove

  subroutine survey(self, statuses, error)
    !! Read the statuses of cases from all drafts of this work, none of which is open here.
    !! **Errors**: one cannot be read.
    class(unfinished_work), intent(inout) :: self
    integer(i1), allocatable, intent(out) :: statuses(:)   !! (cases), `not_done` unless a draft has the case
    type(error_type), allocatable, intent(inout) :: error
    type(string), allocatable :: paths(:)
    integer(i1), allocatable :: found(:)
    logical :: is_ours
    integer :: i
    allocate (statuses(max(1, self%layout%cases)), source=int(not_done, i1))
    self%owner = ''
    call self%drafts(paths, error)
    do i = 1, size(paths)
      call self%draft%open(paths(i)%text, .false., is_ours, error)
      if (is_ours) then
        call self%draft%get_statuses(found)
        where (found == case_misfit) found = case_done       ! the misfit is found anew
        where (statuses == not_done) statuses = found
        if (paths(i)%text == self%draft_of('')) self%owner = self%draft%host()
      end if
      call self%draft%file%close()
      if (allocated(error)) return
    end do
  end subroutine survey

  subroutine provide(self, hosts, error)
    !! Create missing drafts: the first one, and one for each further host. For a part, the first may be on another
    !! host. **Errors**: one cannot be made.
    class(unfinished_work), intent(inout) :: self
    type(string), intent(in) :: hosts(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    if (self%owner == '') call make(self%draft_of(''))
    if (self%owner == '' .or. self%parts == 1) self%owner = own_host()
    do i = 1, size(hosts)
      if (hosts(i)%text /= self%owner) call make(self%draft_of(hosts(i)%text))
    end do
  contains
    subroutine make(path)
      character(*), intent(in) :: path
      type(path_state) :: state
      if (allocated(error)) return
      if (look_at(path, state) == 0 .and. state%kind > 0) return
      call self%draft%create(path, error)
      call self%draft%file%close()
    end subroutine make
  end subroutine provide

  subroutine open_draft(self, error)
    !! Open the draft of this host.
    !! **Errors**: the system refuses it, or its layout differs.
    class(unfinished_work), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: host
    logical :: is_ours
    host = own_host()
    if (host == self%owner) host = ''
    call self%draft%open(self%draft_of(host), self%parts > 1, is_ours, error)
    if (.not. is_ours .and. .not. allocated(error)) call fail(error, status_bad_file, self%draft_of(host)// &
      ': is not the draft of this run: do all processes run the same program, and see the same directory?')
  end subroutine open_draft

  subroutine merge_drafts(self, error)
    !! Open the first draft, and copy into it the cases of further hosts.
    !! **Errors**: one cannot be read, or the first cannot be written.
    class(unfinished_work), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    type(string), allocatable :: paths(:)
    type(result_draft) :: other
    integer(i1), allocatable :: mine(:), theirs(:)
    integer, allocatable :: cases(:)
    logical :: is_ours
    integer :: i, c
    other = self%draft
    call self%draft%open(self%draft_of(''), .true., is_ours, error)
    if (allocated(error)) return
    call self%draft%get_statuses(mine)
    call self%drafts(paths, error)
    do i = 1, size(paths)
      if (paths(i)%text == self%draft_of('')) cycle
      call other%open(paths(i)%text, .false., is_ours, error)
      if (allocated(error)) return
      if (.not. is_ours) cycle
      call other%get_statuses(theirs)
      cases = pack([(c, c=1, size(mine))], mine == not_done .and. theirs /= not_done)
      call self%draft%take_cases(other, cases)
      call other%file%close()
      call self%draft%file%flush(error)
      if (allocated(error)) return
      call self%draft%put_statuses(cases, int(theirs(cases)))
      mine(cases) = theirs(cases)
    end do
  end subroutine merge_drafts

  subroutine clear(self)
    !! Remove what a run left that was killed after it had named its result, unless another run is at work. Work of
    !! another scene or version is kept: a run of it may continue it.
    class(unfinished_work), intent(inout) :: self
    type(error_type), allocatable :: error
    if (.not. directory_is_there(self%path)) return
    call self%begin(error)
    if (allocated(error)) return
    call self%refuse_other_parts(error)
    if (.not. allocated(error)) call self%remove(own=.true., others=.false., error=error)
    call self%leave()
  end subroutine clear

end module bw_unfinished_work
