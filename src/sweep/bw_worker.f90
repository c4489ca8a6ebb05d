module bw_worker
  !! A worker process of a sweep: it takes batches of cases, runs them, and puts each into the draft of its host, until
  !! none is left. A case is done when its numbers are on the disk, where cases are saved at least every two seconds.
  use bw_case_result, only: case_result
  use bw_error, only: error_type
  use bw_files, only: cannot_be_written
  use bw_kinds, only: dp, i4, i8
  use bw_monitor, only: monitor_type, progress_type
  use bw_one_case, only: case_cache, run_case
  use bw_process_group, only: process_group
  use bw_result_draft, only: result_draft
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_scene
  use bw_stopwatch, only: stage_write, stopwatch, wall_seconds
  implicit none (type, external)
  private
  public :: batch_length

  real(dp), parameter :: batch_seconds = 0.05_dp !! duration of a batch: long compared to taking it, short compared to a run; tuned
  integer, parameter :: batches_left = 4             !! least number of remaining batches per process
  real(dp), parameter :: look_every = 0.1_dp         !! s between two reports to the other processes
  real(dp), parameter :: save_seconds(2) = [0.1_dp, 2.0_dp]
    !! s between saves, least and most: within these, saving takes a twentieth of the time
  real(dp), parameter :: saving_share = 0.05_dp

  type :: unsaved_cases
    !! Cases put into a draft and not yet saved to the disk.
    type(result_draft), pointer :: draft => null()
    integer, allocatable :: cases(:), statuses(:)
    integer :: count = 0
    real(dp) :: due = 0.0_dp                         !! time of the next save
    integer(i8) :: saved = 0                         !! cases of this process
    type(error_type), allocatable :: error           !! why they cannot be saved
  contains
    procedure :: add => add_unsaved
    procedure :: save => save_cases
  end type unsaved_cases

  type, extends(monitor_type) :: group_monitor
    !! Forwards progress, detects that any process has stopped, and saves cases in time.
    class(progress_type), pointer :: progress => null()
    class(process_group), pointer :: group => null()
    type(unsaved_cases) :: unsaved
    integer(i8) :: done = 0                          !! cases of this process
    integer(i8) :: reported = 0                          !! of these, reported to the others
    integer(i8) :: shown = 0                         !! of all processes, reported to the progress
    real(dp) :: looked = 0.0_dp
    logical :: stopped = .false.
  contains
    procedure :: advance
    procedure :: enter
    procedure :: stop_requested
    procedure :: count_case
    procedure :: look
  end type group_monitor

  type, public :: worker_type
    !! The state of a process that runs cases.
    type(scene_type) :: scene
    type(stopwatch) :: watch                         !! times of the stages of all its cases
    type(scene_type), private :: one                 !! the present or the previous case
    type(case_cache), private :: cache               !! shared between cases
    type(group_monitor), private :: monitor
  contains
    procedure :: run_cases
    procedure, private :: run_one
  end type worker_type

contains

  subroutine run_cases(self, draft, left, group, progress, done, error)
    !! Run cases until none is left or a process stops.
    !! **Errors**: a case cannot be put into the draft; then all processes are stopped.
    class(worker_type), intent(inout) :: self
    type(result_draft), intent(inout), target :: draft
    integer(i4), intent(in) :: left(:)               !! remaining cases
    class(process_group), intent(inout), target :: group
    class(progress_type), intent(inout), target :: progress
    integer(i8), intent(out) :: done                 !! cases that this process has finished
    type(error_type), allocatable, intent(out) :: error
    integer(i8) :: first, length, i
    real(dp) :: began
    self%monitor%progress => progress
    self%monitor%group => group
    self%monitor%unsaved%draft => draft
    self%monitor%unsaved%due = wall_seconds() + save_seconds(1)
    allocate (self%monitor%unsaved%cases(64), self%monitor%unsaved%statuses(64))
    length = 1
    do
      call group%take(length, first)
      if (first > size(left)) exit
      began = wall_seconds()
      do i = first, min(first + length - 1, size(left, kind=i8))
        if (self%monitor%stop_requested()) exit
        call self%run_one(int(left(i), i8), error)
        if (allocated(error)) exit
      end do
      if (allocated(error)) call group%stop()
      if (allocated(error)) exit
      length = batch_length(size(left) - (first + length - 1), group%processes, (wall_seconds() - began)/length)
    end do
    call self%monitor%look()
    call self%watch%start()
    call self%monitor%unsaved%save(.not. group%leads())          ! the leader flushes the draft later
    call self%watch%lap(stage_write)
    if (.not. allocated(error)) call move_alloc(self%monitor%unsaved%error, error)
    done = self%monitor%unsaved%saved
  end subroutine run_cases

  pure integer(i8) function batch_length(left, processes, case_seconds) result(length)
    !! Return the number of cases in a batch: large enough for short cases, and small enough that all processes end together.
    integer(i8), intent(in) :: left                  !! cases
    integer, intent(in) :: processes
    real(dp), intent(in) :: case_seconds             !! mean duration of a case so far
    length = max(1_i8, int(min(batch_seconds/max(case_seconds, tiny(1.0_dp)), real(left, dp)/(batches_left*processes)), i8))
  end function batch_length

  subroutine run_one(self, index, error)
    !! Run a case and put it into the draft, unless it is stopped.
    !! **Errors**: the case cannot be built or put.
    class(worker_type), intent(inout) :: self
    integer(i8), intent(in) :: index                 !! of the case, from 1
    type(error_type), allocatable, intent(out) :: error
    type(case_result) :: result
    logical :: whole
    whole = .false.
    call case_scene(self%scene, index, self%one, error)
    associate (unsaved => self%monitor%unsaved)
      if (.not. allocated(error)) call run_case(self%one, unsaved%draft%layout, self%watch, self%monitor, self%cache, result, whole)
      if (allocated(result%error)) call move_alloc(result%error, error)
      if (.not. whole .or. allocated(error)) return
      call unsaved%draft%put_case(index, result)
      call unsaved%add(int(index), result%status)
      if (unsaved%draft%file%problem /= 0) call cannot_be_written(error, unsaved%draft%file%path, unsaved%draft%file%problem)
    end associate
    if (allocated(error)) return
    call self%watch%lap(stage_write)
    call self%monitor%count_case()
  end subroutine run_one

  subroutine add_unsaved(self, case, status)
    !! Add a case to the unsaved ones.
    class(unsaved_cases), intent(inout) :: self
    integer, intent(in) :: case, status
    if (self%count == size(self%cases)) then
      self%cases = [self%cases, self%cases]
      self%statuses = [self%statuses, self%statuses]
    end if
    self%count = self%count + 1
    self%cases(self%count) = case
    self%statuses(self%count) = status
  end subroutine add_unsaved

  subroutine save_cases(self, and_statuses)
    !! Save the numbers of all cases to the disk, then put their statuses.
    class(unsaved_cases), intent(inout) :: self
    logical, intent(in) :: and_statuses              !! save the statuses too
    real(dp) :: began
    began = wall_seconds()
    self%due = began + save_seconds(1)
    if (self%count == 0 .or. allocated(self%error)) return
    call self%draft%write_cases()
    call self%draft%file%flush(self%error)
    if (.not. allocated(self%error)) call self%draft%put_statuses(self%cases(:self%count), self%statuses(:self%count))
    if (and_statuses) call self%draft%file%flush(self%error)
    if (.not. allocated(self%error)) self%saved = self%saved + self%count
    self%count = 0
    self%due = wall_seconds() + min(save_seconds(2), max(save_seconds(1), (wall_seconds() - began)/saving_share))
  end subroutine save_cases

  subroutine advance(self, fraction)
    !! Forward the progress of the present case.
    class(group_monitor), intent(inout) :: self
    real(dp), intent(in) :: fraction
    call self%progress%advance(fraction)
  end subroutine advance

  subroutine enter(self, stage)
    !! Forward the present stage of the case.
    class(group_monitor), intent(inout) :: self
    character(*), intent(in) :: stage
    call self%progress%enter(stage)
  end subroutine enter

  logical function stop_requested(self)
    !! Return whether any process has stopped; asks the own progress and, at intervals, the others. Also saves cases when due.
    class(group_monitor), intent(inout) :: self
    real(dp) :: now
    now = wall_seconds()
    if (now > self%unsaved%due) call self%unsaved%save(.true.)
    if (now - self%looked > look_every) call self%look()
    if (.not. self%stopped) then
      self%stopped = self%progress%stop_requested() .or. allocated(self%unsaved%error)
      if (self%stopped) call self%group%stop()
    end if
    stop_requested = self%stopped
  end function stop_requested

  subroutine count_case(self)
    !! Count a case that this process has finished.
    class(group_monitor), intent(inout) :: self
    self%done = self%done + 1
    self%shown = self%shown + 1
    call self%progress%cases_done(1_i8)
  end subroutine count_case

  subroutine look(self)
    !! Report finished cases to the others, and get theirs.
    class(group_monitor), intent(inout) :: self
    integer(i8) :: all_done
    logical :: stopped
    self%looked = wall_seconds()
    call self%group%tell(self%done - self%reported, all_done, stopped)
    self%reported = self%done
    self%stopped = self%stopped .or. stopped
    if (all_done > self%shown) call self%progress%cases_done(all_done - self%shown)
    self%shown = max(self%shown, all_done)
  end subroutine look

end module bw_worker
