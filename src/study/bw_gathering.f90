module bw_gathering
  !! How the leader comes by the cases of others: it reads their journals between two ranges of its own, and what is missing
  !! when all have ended (cases of an earlier run, and the last of the others) at the end. So the result is part of the work
  !! that is shared, and little of it is left for one process alone.
  use bw_assembly, only: assembly_type
  use bw_case_journal, only: journal_reader
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kinds, only: dp, i8
  use bw_monitor, only: monitor_type
  use bw_posix, only: remove_file
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

  type, public :: gathering_type
    type(assembly_type) :: assembly
    character(:), allocatable, private :: work           !! whose cases these are
    real(dp), allocatable, private :: numbers(:)         !! of a case that is read
    type(follower), allocatable, private :: followed(:)
  contains
    procedure :: begin
    procedure :: follow
    procedure :: complete
    procedure :: end => stop_following
    procedure, private :: take_records
    procedure, private :: take_journal
  end type gathering_type

contains

  subroutine begin(self, unfinished, number, processes)
    !! Follow the others. The assembly has begun.
    class(gathering_type), intent(inout) :: self
    type(unfinished_work), intent(in) :: unfinished
    integer, intent(in) :: number                        !! of the leader's journal; those of the others follow
    integer, intent(in) :: processes
    integer :: i
    self%work = unfinished%work
    allocate (self%numbers(self%assembly%body%case_length()))
    allocate (self%followed(min(processes - 1, most_followed)))
    do i = 1, size(self%followed)
      self%followed(i)%path = unfinished%journal(number + i)
    end do
  end subroutine begin

  subroutine follow(self, error, monitor)
    !! What the other processes have finished by now, or as much of it until the monitor asks to stop.
    !! **Errors**: the result cannot be written.
    class(gathering_type), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    class(monitor_type), intent(inout), optional :: monitor   !! is asked between two cases
    logical :: sound
    integer :: i
    do i = 1, size(self%followed)
      if (self%followed(i)%left .or. allocated(error)) cycle
      associate (other => self%followed(i))
        if (.not. other%is_open) other%is_open = other%reader%open(other%path, self%work)
        if (.not. other%is_open) cycle
        call self%take_records(other%reader, self%assembly%body%known(), sound, error, monitor)
        other%left = .not. sound
      end associate
    end do
  end subroutine follow

  subroutine take_records(self, reader, is_fresh, sound, error, monitor)
    !! The records of a journal from where it stands. A record whose long fields are not what they were is passed over: its
    !! case is done again.
    class(gathering_type), intent(inout) :: self
    type(journal_reader), intent(inout) :: reader
    logical, intent(in) :: is_fresh                      !! of this run: what is long was written on this machine just before
    logical, intent(out) :: sound                        !! none of those that were needed is damaged
    type(error_type), allocatable, intent(inout) :: error
    class(monitor_type), intent(inout), optional :: monitor
    type(string), allocatable :: notes(:)
    integer(i8) :: index, held
    sound = .true.
    do
      if (present(monitor)) then
        if (monitor%stop_requested()) return
      end if
      if (.not. reader%next(index)) return
      if (index < 1 .or. index > size(self%assembly%done, kind=i8)) cycle
      if (self%assembly%done(index) /= 0) cycle
      if (.not. is_fresh) then
        if (.not. self%assembly%body%has_all(index, reader%elsewhere(), reader%total_elsewhere(), self%numbers)) cycle
      end if
      held = size(self%numbers, kind=i8) - reader%elsewhere()
      sound = reader%take(self%numbers(:held), notes)
      if (sound) call self%assembly%take(index, self%numbers(:held), notes, error)
      if (.not. sound .or. allocated(error)) return
    end do
  end subroutine take_records

  subroutine complete(self, unfinished, error)
    !! What is missing, from all journals.
    !! **Errors**: the result cannot be written, or a journal is damaged, which is then taken away.
    class(gathering_type), intent(inout) :: self
    type(unfinished_work), intent(in) :: unfinished
    type(error_type), allocatable, intent(inout) :: error
    type(string), allocatable :: paths(:)
    integer :: i
    call self%follow(error)
    call self%end()
    paths = unfinished%journals()
    do i = 1, size(paths)
      if (allocated(error) .or. all(self%assembly%done /= 0)) exit
      call self%take_journal(paths(i)%text, error)
    end do
    call self%assembly%write_block(error)
    if (allocated(error) .or. all(self%assembly%done /= 0)) return
    call fail(error, status_bad_file, unfinished%directory//': '//text_of(count(self%assembly%done == 0))// &
              ' finished cases are gone; the same command does them again')
  end subroutine complete

  subroutine take_journal(self, path, error)
    class(gathering_type), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    type(journal_reader) :: reader
    logical :: sound
    if (.not. reader%open(path, self%work)) return
    call self%take_records(reader, .false., sound, error)
    call reader%close()
    if (sound) return
    call remove_file(path)
    call fail(error, status_bad_file, path//': is damaged and was removed; the same command does its cases again')
  end subroutine take_journal

  subroutine stop_following(self)
    class(gathering_type), intent(inout) :: self
    integer :: i
    if (.not. allocated(self%followed)) return
    do i = 1, size(self%followed)
      if (self%followed(i)%is_open) call self%followed(i)%reader%close()
    end do
    deallocate (self%followed)
  end subroutine stop_following

end module bw_gathering
