module bw_worker
  !! One of the processes that share the cases of a sweep: it takes a batch of them, runs it, and appends each case to its
  !! journal, until nothing is left.
  use bw_case_fields, only: case_field, case_length, fields_of, forbid_lost, put_fields
  use bw_case_result, only: case_result
  use bw_error, only: error_type
  use bw_journal_writer, only: journal_writer
  use bw_kinds, only: dp, i4, i8
  use bw_monitor, only: monitor_type, progress_type
  use bw_one_case, only: case_cache, run_case
  use bw_process_group, only: process_group
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_scene
  use bw_stopwatch, only: stage_write, stopwatch, wall_seconds
  implicit none (type, external)
  private
  public :: batch_length

  real(dp), parameter :: batch_seconds = 0.05_dp     !! work of a batch: long beside taking it, short beside a run; tuned
  integer, parameter :: batches_left = 4             !! how many each process gets at least of what is left
  real(dp), parameter :: look_every = 0.1_dp         !! s between two looks at what the others do

  type, extends(monitor_type) :: group_monitor
    !! Passes on the progress of a case and of the group, and learns that anybody has stopped.
    class(progress_type), pointer :: progress => null()
    class(process_group), pointer :: group => null()
    integer(i8) :: done = 0                          !! cases of this process
    integer(i8) :: told = 0                          !! of these, how many the others know of
    integer(i8) :: shown = 0                         !! of all processes, how many the progress knows of
    real(dp) :: looked = 0.0_dp
    logical :: stopped = .false.
  contains
    procedure :: advance
    procedure :: stop_requested
    procedure :: count_case
    procedure :: look
  end type group_monitor

  type, public :: worker_type
    !! What a process has at hand while it runs cases.
    type(scene_type) :: scene
    type(result_layout) :: layout                    !! of the scene's result
    type(journal_writer) :: journal                  !! with its path and work
    type(stopwatch) :: watch                         !! times of the stages of all its cases
    type(case_field), allocatable, private :: fields(:)  !! the numbers of a case
    type(scene_type), private :: one                 !! the case at hand, or the one before it
    type(case_cache), private :: cache                !! what cases share
    type(group_monitor), private :: monitor
  contains
    procedure :: run_cases
    procedure, private :: run_one
  end type worker_type

contains

  subroutine run_cases(self, left, group, progress, done, error)
    !! Do cases as long as there are any, or until somebody stops.
    !! **Errors**: a case cannot be written to the journal; then all are stopped.
    class(worker_type), intent(inout) :: self
    integer(i4), intent(in) :: left(:)               !! cases that are to be done
    class(process_group), intent(inout), target :: group
    class(progress_type), intent(inout), target :: progress
    integer(i8), intent(out) :: done                 !! cases that this process has finished
    type(error_type), allocatable, intent(out) :: error
    integer(i8) :: first, length, i
    real(dp) :: began
    self%monitor%progress => progress
    self%monitor%group => group
    self%fields = fields_of(self%layout)
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
    call self%journal%close(error)
    done = self%monitor%done
  end subroutine run_cases

  pure integer(i8) function batch_length(left, processes, case_seconds) result(length)
    !! How many cases a process takes at once: rarely many small ones, and so that no process is left with the last long one.
    integer(i8), intent(in) :: left                  !! cases
    integer, intent(in) :: processes
    real(dp), intent(in) :: case_seconds             !! what a case took so far
    length = max(1_i8, int(min(batch_seconds/max(case_seconds, tiny(1.0_dp)), real(left, dp)/(batches_left*processes)), i8))
  end function batch_length

  subroutine run_one(self, index, error)
    !! Run a case and write it to the journal, unless it is stopped on the way.
    !! **Errors**: the case cannot be built, or not be written.
    class(worker_type), intent(inout) :: self
    integer(i8), intent(in) :: index                 !! of the case, from 1
    type(error_type), allocatable, intent(out) :: error
    type(case_result) :: result
    real(dp), pointer, contiguous :: numbers(:)
    logical :: whole, lost
    whole = .false.
    call case_scene(self%scene, index, self%one, error)
    if (.not. allocated(error)) call run_case(self%one, self%layout, self%watch, self%monitor, self%cache, result, whole)
    if (allocated(result%error)) call move_alloc(result%error, error)
    if (.not. whole .or. allocated(error)) return
    call self%journal%prepare(case_length(self%fields), numbers, error)
    if (allocated(error)) return
    call put_fields(result, self%fields, numbers, lost)
    if (lost) then
      call forbid_lost(result, self%fields)
      call put_fields(result, self%fields, numbers)
    end if
    call self%journal%append(index, case_length(self%fields), result%notes, error)
    if (allocated(error)) return
    call self%watch%lap(stage_write)
    call self%monitor%count_case()
  end subroutine run_one

  subroutine advance(self, fraction)
    !! Pass on how much of the case at hand is done.
    class(group_monitor), intent(inout) :: self
    real(dp), intent(in) :: fraction
    call self%progress%advance(fraction)
  end subroutine advance

  logical function stop_requested(self)
    !! Somebody has stopped: this process asks its progress, and now and then the others.
    class(group_monitor), intent(inout) :: self
    if (wall_seconds() - self%looked > look_every) call self%look()
    if (.not. self%stopped) then
      self%stopped = self%progress%stop_requested()
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
    !! Tell the others of the cases that are finished, and see what they have done.
    class(group_monitor), intent(inout) :: self
    integer(i8) :: all_done
    logical :: stopped
    self%looked = wall_seconds()
    call self%group%tell(self%done - self%told, all_done, stopped)
    self%told = self%done
    self%stopped = self%stopped .or. stopped
    if (all_done > self%shown) call self%progress%cases_done(all_done - self%shown)
    self%shown = max(self%shown, all_done)
  end subroutine look

end module bw_worker
