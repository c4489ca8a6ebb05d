module bw_case_loop
  !! The cases of a sweep, done by one of the processes that share them and kept in its journal.
  use bw_case_keeper, only: case_keeper
  use bw_case_result, only: case_result
  use bw_crew, only: crew_type
  use bw_error, only: error_type
  use bw_gathering, only: gathering_type
  use bw_kept_work, only: kept_work
  use bw_kinds, only: dp, i8
  use bw_monitor, only: monitor_type
  use bw_one_case, only: run_case
  use bw_progress, only: progress_type
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_scene
  use bw_stopwatch, only: stage_write, stopwatch
  implicit none (type, external)
  private
  public :: run_cases

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

contains

  subroutine run_cases(scene, layout, keeper, crew, progress, watch, done, error, gathering)
    !! Do cases as long as there are any. The caller has called `crew%begin` and calls `crew%end`.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(case_keeper), intent(inout) :: keeper
    class(crew_type), intent(inout), target :: crew
    class(progress_type), intent(inout), target :: progress
    type(stopwatch), intent(inout) :: watch
    integer(i8), intent(out) :: done             !! cases done, by this process and by those that told it so far
    type(error_type), allocatable, intent(out) :: error
    type(gathering_type), intent(inout), optional :: gathering   !! of the leader: the result under way
    type(crew_monitor) :: monitor
    type(kept_work) :: kept
    type(scene_type) :: one
    integer(i8) :: first, last, i
    monitor%progress => progress
    monitor%crew => crew
    do
      call crew%next(first, last)
      if (first > last) exit
      do i = first, last
        call run_one(scene, layout, i, one, monitor, keeper, kept, watch, error, gathering)
        if (allocated(error)) call crew%stop()
        if (monitor%stop_requested()) exit
      end do
      call monitor%listen()
      if (present(gathering)) call follow_others(gathering, monitor, watch, error)
      if (allocated(error)) call crew%stop()
    end do
    call keeper%end()
    done = monitor%done
  end subroutine run_cases

  subroutine follow_others(gathering, monitor, watch, error)
    !! What the others have done goes into the result while they do more.
    type(gathering_type), intent(inout) :: gathering
    type(crew_monitor), intent(inout) :: monitor
    type(stopwatch), intent(inout) :: watch
    type(error_type), allocatable, intent(inout) :: error
    call watch%start()
    call gathering%follow(error, monitor)
    call watch%lap(stage_write)
  end subroutine follow_others

  subroutine run_one(scene, layout, i, one, monitor, keeper, kept, watch, error, gathering)
    !! One case onto the disk, unless it is stopped on the way.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    integer(i8), intent(in) :: i
    type(scene_type), intent(inout) :: one       !! the case before this one
    type(crew_monitor), intent(inout) :: monitor
    type(case_keeper), intent(inout) :: keeper
    type(kept_work), intent(inout) :: kept
    type(stopwatch), intent(inout) :: watch
    type(error_type), allocatable, intent(out) :: error
    type(gathering_type), intent(inout), optional :: gathering
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
    if (present(gathering)) call gathering%assembly%take(i, keeper%numbers, result%notes, error)
    call watch%lap(stage_write)
    call monitor%progress%cases_done(1_i8)
  end subroutine run_one

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
