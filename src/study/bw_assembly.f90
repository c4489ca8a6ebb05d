module bw_assembly
  !! The result of a sweep, put together by the leader while the cases are done: its own go into the file as they are
  !! finished, those of the others are read from their journals between two of its ranges, and what is missing when all have
  !! ended (cases of an earlier run, and the last of the others) at the end. So the file is part of the work that is
  !! shared, and little of it is left for one process alone. Until it is whole it counts for nothing: the journals do.
  use bw_case_block, only: block_for, case_block
  use bw_case_fields, only: case_field, case_length, fields_of
  use bw_case_journal, only: journal_reader
  use bw_case_result, only: case_done
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kinds, only: dp, i1, i8
  use bw_monitor, only: monitor_type
  use bw_notes, only: notes_type
  use bw_posix, only: remove_file
  use bw_result_file, only: create_result, result_file
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_sweep_table, only: sweep_table
  use bw_text, only: string, text_of
  use bw_unfinished, only: unfinished_work
  implicit none (type, external)
  private

  integer, parameter :: most_followed = 64     !! journals that are open at a time; those of more processes are read at the end

  type :: follower
    !! The journal of another process.
    character(:), allocatable :: path
    type(journal_reader) :: reader
    logical :: is_open = .false.
    logical :: left = .false.                            !! not to be followed any more: the end will tell
  end type follower

  type, public :: assembly_type
    !! A sweep's result, and what there is to say of it.
    type(result_file) :: file
    type(sweep_table) :: table
    type(notes_type) :: notes
    integer(i8) :: not_trusted = 0                       !! cases
    character(:), allocatable, private :: work           !! whose cases these are
    type(case_field), allocatable, private :: fields(:)
    integer(i1), allocatable, private :: done(:)         !! (cases)
    type(case_block), private :: block                   !! neighbouring cases, not written yet
    integer(i8), private :: first = 1                    !! the first of them
    real(dp), allocatable, private :: numbers(:)         !! of a case that is read
    type(follower), allocatable, private :: followed(:)
  contains
    procedure :: begin
    procedure :: take
    procedure :: follow
    procedure :: complete
    procedure :: abandon
    procedure, private :: write_block
  end type assembly_type

contains

  subroutine begin(self, scene, layout, unfinished, number, processes, error)
    !! A result without cases.
    class(assembly_type), intent(inout) :: self
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(unfinished_work), intent(in) :: unfinished
    integer, intent(in) :: number                        !! of the leader's journal; those of the others follow
    integer, intent(in) :: processes
    type(error_type), allocatable, intent(out) :: error
    integer :: i
    call create_result(unfinished%result_path(), scene, layout, self%file, error)
    if (allocated(error)) return
    self%work = unfinished%work
    allocate (self%done(layout%cases), source=0_i1)
    allocate (self%fields, source=fields_of(layout))
    allocate (self%numbers(case_length(self%fields)))
    self%block = block_for(self%fields, layout%cases)
    self%table = sweep_table(scene, layout)
    allocate (self%followed(min(processes - 1, most_followed)))
    do i = 1, size(self%followed)
      self%followed(i)%path = unfinished%journal(number + i)
    end do
  end subroutine begin

  subroutine take(self, index, numbers, notes, error)
    !! A case, unless it is there: whoever did it, it has the same bits.
    class(assembly_type), intent(inout) :: self
    integer(i8), intent(in) :: index
    real(dp), intent(in), contiguous :: numbers(:)       !! (case_length)
    type(string), intent(in) :: notes(:)
    type(error_type), allocatable, intent(inout) :: error
    if (self%done(index) /= 0) return
    if (self%block%held == self%block%room .or. index /= self%first + self%block%held) then
      call self%write_block(error)                       ! it is full, or does not reach up to this case
      if (allocated(error)) return
      self%first = index
    end if
    call self%block%add(self%fields, numbers)
    self%done(index) = 1_i1
    if (nint(numbers(size(numbers))) /= case_done) self%not_trusted = self%not_trusted + 1
    call self%notes%add(index, notes)
    call self%table%add(index, numbers)
  end subroutine take

  subroutine write_block(self, error)
    class(assembly_type), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    if (self%block%held > 0 .and. .not. allocated(error)) call self%file%put_cases(self%first, self%block, error)
    self%block%held = 0
  end subroutine write_block

  subroutine follow(self, error, monitor)
    !! What the other processes have finished by now, or as much of it until the monitor asks to stop.
    !! **Errors**: the result cannot be written.
    class(assembly_type), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    class(monitor_type), intent(inout), optional :: monitor   !! is asked between two cases
    logical :: sound
    integer :: i
    do i = 1, size(self%followed)
      if (self%followed(i)%left .or. allocated(error)) cycle
      associate (other => self%followed(i))
        if (.not. other%is_open) other%is_open = other%reader%open(other%path, self%work)
        if (.not. other%is_open) cycle
        call take_records(self, other%reader, sound, error, monitor)
        other%left = .not. sound
      end associate
    end do
  end subroutine follow

  subroutine take_records(self, reader, sound, error, monitor)
    !! The records of a journal from where it stands.
    class(assembly_type), intent(inout) :: self
    type(journal_reader), intent(inout) :: reader
    logical, intent(out) :: sound                        !! none of those that were needed is damaged
    type(error_type), allocatable, intent(inout) :: error
    class(monitor_type), intent(inout), optional :: monitor
    type(string), allocatable :: notes(:)
    integer(i8) :: index
    sound = .true.
    do
      if (present(monitor)) then
        if (monitor%stop_requested()) return
      end if
      if (.not. reader%next(index)) return
      if (index < 1 .or. index > size(self%done, kind=i8)) cycle
      if (self%done(index) /= 0) cycle
      sound = reader%take(self%numbers, notes)
      if (sound) call self%take(index, self%numbers, notes, error)
      if (.not. sound .or. allocated(error)) return
    end do
  end subroutine take_records

  subroutine complete(self, unfinished, error)
    !! What is missing, from all journals.
    !! **Errors**: the result cannot be written, or a journal is damaged, which is then taken away.
    class(assembly_type), intent(inout) :: self
    type(unfinished_work), intent(in) :: unfinished
    type(error_type), allocatable, intent(inout) :: error
    type(string), allocatable :: paths(:)
    integer :: i
    call self%follow(error)
    call stop_following(self)
    paths = unfinished%journals()
    do i = 1, size(paths)
      if (allocated(error) .or. all(self%done /= 0)) exit
      call take_journal(self, paths(i)%text, error)
    end do
    call self%write_block(error)
    if (allocated(error) .or. all(self%done /= 0)) return
    call fail(error, status_bad_file, unfinished%directory//': '//text_of(count(self%done == 0))// &
              ' finished cases are gone; the same command does them again')
  end subroutine complete

  subroutine take_journal(self, path, error)
    class(assembly_type), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    type(journal_reader) :: reader
    logical :: sound
    if (.not. reader%open(path, self%work)) return
    call take_records(self, reader, sound, error)
    call reader%close()
    if (sound) return
    call remove_file(path)
    call fail(error, status_bad_file, path//': is damaged and was removed; the same command does its cases again')
  end subroutine take_journal

  subroutine abandon(self, unfinished)
    !! Take the unfinished file away.
    class(assembly_type), intent(inout) :: self
    type(unfinished_work), intent(in) :: unfinished
    call stop_following(self)
    if (.not. allocated(self%work)) return               ! it was never begun
    call self%file%close()
    call remove_file(unfinished%result_path())
  end subroutine abandon

  subroutine stop_following(self)
    class(assembly_type), intent(inout) :: self
    integer :: i
    if (.not. allocated(self%followed)) return
    do i = 1, size(self%followed)
      if (self%followed(i)%is_open) call self%followed(i)%reader%close()
    end do
    deallocate (self%followed)
  end subroutine stop_following

end module bw_assembly
