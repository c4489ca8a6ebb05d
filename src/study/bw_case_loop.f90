module bw_case_loop
  !! The cases of a sweep, done by one of the processes that share them and kept in its journal.
  use bw_assembly, only: assembly_type
  use bw_case_fields, only: case_field, case_length, fields_of, put_all_fields
  use bw_case_journal, only: journal_writer
  use bw_case_result, only: case_result
  use bw_crew, only: crew_type
  use bw_error, only: error_type, fail, status_bad_file
  use bw_kept_work, only: kept_work
  use bw_kinds, only: dp, i8
  use bw_monitor, only: monitor_type
  use bw_one_case, only: run_case
  use bw_posix, only: file_exists
  use bw_progress, only: progress_type
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_scene
  use bw_stopwatch, only: stage_write, stopwatch, wall_seconds
  implicit none (type, external)
  private
  public :: run_cases

  real(dp), parameter :: look_every = 0.5_dp     !! s between two looks whether the journal is still there

  type, extends(monitor_type) :: crew_monitor
    !! Passes on the progress of a case, and answers the other processes meanwhile.
    class(progress_type), pointer :: progress => null()
    class(crew_type), pointer :: crew => null()
    integer(i8) :: done = 0                      !! cases done, by this process and by those that told it
  contains
    procedure :: advance
    procedure :: stop_requested
    procedure :: listen
  end type crew_monitor

  type :: case_keeper
    !! The journal of this process.
    character(:), allocatable :: path, work
    type(journal_writer) :: journal
    logical :: is_open = .false.
    real(dp) :: looked = 0.0_dp
    type(case_field), allocatable :: fields(:)
    real(dp), allocatable :: numbers(:)          !! of the case at hand
  contains
    procedure :: keep
  end type case_keeper

contains

  subroutine run_cases(scene, layout, path, work, crew, progress, watch, done, error, assembly)
    !! Do cases as long as there are any. The caller has called `crew%begin` and calls `crew%end`.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: path             !! of this process's journal
    character(*), intent(in) :: work             !! whose cases these are
    class(crew_type), intent(inout), target :: crew
    class(progress_type), intent(inout), target :: progress
    type(stopwatch), intent(inout) :: watch
    integer(i8), intent(out) :: done             !! cases done, by this process and by those that told it so far
    type(error_type), allocatable, intent(out) :: error
    type(assembly_type), intent(inout), optional :: assembly   !! of the leader: the result under way
    type(crew_monitor) :: monitor
    type(case_keeper) :: keeper
    type(kept_work) :: kept
    type(scene_type) :: one
    integer(i8) :: first, last, i
    monitor%progress => progress
    monitor%crew => crew
    keeper%path = path
    keeper%work = work
    allocate (keeper%fields, source=fields_of(layout))
    allocate (keeper%numbers(case_length(keeper%fields)))
    do
      call crew%next(first, last)
      if (first > last) exit
      do i = first, last
        call run_one(scene, layout, i, one, monitor, keeper, kept, watch, error, assembly)
        if (allocated(error)) call crew%stop()
        if (monitor%stop_requested()) exit
      end do
      call monitor%listen()
      if (present(assembly)) call follow_others(assembly, monitor, watch, error)
      if (allocated(error)) call crew%stop()
    end do
    call keeper%journal%close()
    done = monitor%done
  end subroutine run_cases

  subroutine follow_others(assembly, monitor, watch, error)
    !! What the others have done goes into the result while they do more.
    type(assembly_type), intent(inout) :: assembly
    type(crew_monitor), intent(inout) :: monitor
    type(stopwatch), intent(inout) :: watch
    type(error_type), allocatable, intent(inout) :: error
    call watch%start()
    call assembly%follow(error, monitor)
    call watch%lap(stage_write)
  end subroutine follow_others

  subroutine run_one(scene, layout, i, one, monitor, keeper, kept, watch, error, assembly)
    !! One case into the journal, unless it is stopped on the way.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer(i8), intent(in) :: i
    type(scene_type), intent(inout) :: one       !! the case before this one
    type(crew_monitor), intent(inout) :: monitor
    type(case_keeper), intent(inout) :: keeper
    type(kept_work), intent(inout) :: kept
    type(stopwatch), intent(inout) :: watch
    type(error_type), allocatable, intent(out) :: error
    type(assembly_type), intent(inout), optional :: assembly
    type(case_result) :: result
    logical :: whole
    if (monitor%stop_requested()) return
    call case_scene(scene, i, one, error)
    if (allocated(error)) return
    call run_case(one, layout, watch, monitor, kept, result, whole)
    if (.not. whole) return
    call keeper%keep(i, result, error)
    if (allocated(error)) return
    call monitor%crew%case_done()
    monitor%done = monitor%done + 1
    if (present(assembly)) call assembly%take(i, keeper%numbers, result%notes, error)
    call watch%lap(stage_write)
    call monitor%progress%cases_done(1_i8)
  end subroutine run_one

  subroutine keep(self, index, result, error)
    !! A finished case into the journal, which begins with the first of them.
    !! **Errors**: the journal cannot be written, or is gone.
    class(case_keeper), intent(inout) :: self
    integer(i8), intent(in) :: index
    type(case_result), intent(in) :: result
    type(error_type), allocatable, intent(out) :: error
    logical :: kept
    real(dp) :: now
    kept = .true.
    if (.not. self%is_open) kept = self%journal%open(self%path, self%work)
    self%is_open = .true.
    call put_all_fields(result, self%fields, self%numbers)
    if (kept) kept = self%journal%put(index, self%numbers, result%notes)
    if (.not. kept) call fail(error, status_bad_file, self%path// &
      ': cannot be written: is the disk full, a quota used up, the directory gone or read-only?')
    now = wall_seconds()
    if (allocated(error) .or. now - self%looked <= look_every) return
    self%looked = now
    if (.not. file_exists(self%path)) call fail(error, status_bad_file, self%path// &
      ': is gone: somebody has removed it while cases were done, or its file system is no longer there')
  end subroutine keep

  subroutine advance(self, fraction)
    class(crew_monitor), intent(inout) :: self
    real(dp), intent(in) :: fraction
    call self%listen()
    call self%progress%advance(fraction)
  end subroutine advance

  logical function stop_requested(self)
    class(crew_monitor), intent(inout) :: self
    call self%listen()
    if (self%progress%stop_requested()) call self%crew%stop()
    stop_requested = self%crew%stopped()
  end function stop_requested

  subroutine listen(self)
    !! Answer the others and count what they have done.
    class(crew_monitor), intent(inout) :: self
    integer(i8) :: done
    call self%crew%attend(done)
    if (done == 0) return
    self%done = self%done + done
    call self%progress%cases_done(done)
  end subroutine listen

end module bw_case_loop
