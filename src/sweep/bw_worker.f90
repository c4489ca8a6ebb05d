module bw_worker
  !! One of the processes that share the cases of a sweep: it takes a batch of them, runs it, and appends each case to its
  !! journal, until nothing is left.
  use bw_case_fields, only: case_field, case_length, fields_of, put_fields
  use bw_case_result, only: case_result
  use bw_error, only: error_type
  use bw_journal_writer, only: journal_writer
  use bw_kinds, only: dp, i4, i8
  use bw_monitor, only: monitor_type
  use bw_one_case, only: case_cache, run_case
  use bw_process_group, only: process_group
  use bw_progress, only: progress_type
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_scene
  use bw_stopwatch, only: stage_write, stopwatch, wall_seconds
  implicit none (type, external)
  private
  public :: batch_length, run_cases

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
    procedure :: look
  end type group_monitor

contains

  subroutine run_cases(scene, layout, left, journal, group, progress, watch, done, error)
    !! Do cases as long as there are any, or until somebody stops.
    !! **Errors**: a case cannot be kept; then all are stopped.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer(i4), intent(in) :: left(:)               !! cases that are to be done
    type(journal_writer), intent(inout) :: journal
    class(process_group), intent(inout), target :: group
    class(progress_type), intent(inout), target :: progress
    type(stopwatch), intent(inout) :: watch
    integer(i8), intent(out) :: done                 !! by this process
    type(error_type), allocatable, intent(out) :: error
    type(group_monitor) :: monitor
    type(case_field), allocatable :: fields(:)
    type(case_cache) :: cache
    type(scene_type) :: one
    integer(i8) :: first, length, i
    real(dp) :: began
    monitor%progress => progress
    monitor%group => group
    fields = fields_of(layout)
    length = 1
    do
      call group%take(length, first)
      if (first > size(left)) exit
      began = wall_seconds()
      do i = first, min(first + length - 1, size(left, kind=i8))
        if (monitor%stop_requested()) exit
        call run_one(scene, layout, int(left(i), i8), one, fields, monitor, journal, cache, watch, error)
        if (allocated(error)) call group%stop()
        if (allocated(error)) exit
      end do
      if (allocated(error)) exit
      length = batch_length(size(left) - (first + length - 1), group%processes, (wall_seconds() - began)/length)
    end do
    call monitor%look()
    call journal%close(error)
    done = monitor%done
  end subroutine run_cases

  pure integer(i8) function batch_length(left, processes, case_seconds) result(length)
    !! How many cases to take at once: rarely many small ones, and no process is left with the last long one.
    integer(i8), intent(in) :: left                  !! cases
    integer, intent(in) :: processes
    real(dp), intent(in) :: case_seconds             !! what a case took so far
    length = max(1_i8, int(min(batch_seconds/max(case_seconds, tiny(1.0_dp)), real(left, dp)/(batches_left*processes)), i8))
  end function batch_length

  subroutine run_one(scene, layout, index, one, fields, monitor, journal, cache, watch, error)
    !! One case into the journal, unless it is stopped on the way.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer(i8), intent(in) :: index
    type(scene_type), intent(inout) :: one           !! the case before this one
    type(case_field), intent(in) :: fields(:)
    type(group_monitor), intent(inout) :: monitor
    type(journal_writer), intent(inout) :: journal
    type(case_cache), intent(inout) :: cache
    type(stopwatch), intent(inout) :: watch
    type(error_type), allocatable, intent(out) :: error
    type(case_result) :: result
    real(dp), pointer, contiguous :: numbers(:)
    logical :: whole
    whole = .false.
    call case_scene(scene, index, one, error)
    if (.not. allocated(error)) call run_case(one, layout, watch, monitor, cache, result, whole)
    if (.not. whole) return
    call journal%prepare(case_length(fields), numbers, error)
    if (allocated(error)) return
    call put_fields(result, fields, numbers)
    call journal%append(index, case_length(fields), result%notes, error)
    if (allocated(error)) return
    call watch%lap(stage_write)
    monitor%done = monitor%done + 1
    monitor%shown = monitor%shown + 1
    call monitor%progress%cases_done(1_i8)
  end subroutine run_one

  subroutine advance(self, fraction)
    class(group_monitor), intent(inout) :: self
    real(dp), intent(in) :: fraction
    call self%progress%advance(fraction)
  end subroutine advance

  logical function stop_requested(self)
    class(group_monitor), intent(inout) :: self
    if (wall_seconds() - self%looked > look_every) call self%look()
    if (.not. self%stopped) then
      self%stopped = self%progress%stop_requested()
      if (self%stopped) call self%group%stop()
    end if
    stop_requested = self%stopped
  end function stop_requested

  subroutine look(self)
    !! Tell the others, and see what they have done.
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
