module bw_case_tolerance
  !! The plan of a scene with a tolerance before its run: how many modes are summed, and whether the tolerance can be
  !! met. A run continues from the planned motion.
  use bw_beam_units, only: units_of
  use bw_case_modes, only: find_modes
  use bw_case_notes, only: out_of_reach
  use bw_case_result, only: case_histories, case_motion, history_errors
  use bw_error, only: error_type, fail, status_bad_input
  use bw_input_values, only: position_of
  use bw_kept_tolerance, only: find_histories, find_motion, motion_cache
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing
  use bw_mode_set, only: observe_searches, search_failure
  use bw_modes_par, only: relaxed_tolerance
  use bw_monitor, only: monitor_type
  use bw_plan, only: plan_type
  use bw_scene, only: is_planned, scene_type
  use bw_scene_cases, only: case_scene, case_words, few_corners
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: plan_case, fix_tolerance

contains

  subroutine plan_case(scene, monitor, count, error, reached)
    !! Return how many modes a scene with a tolerance will sum; 0 if it counts modes or its run finds the number.
    !! **Errors**: `status_bad_input` if the tolerance is out of reach.
    type(scene_type), intent(in) :: scene          !! without sweeps
    class(monitor_type), intent(inout), target :: monitor  !! nothing is planned if it requests a stop
    integer, intent(out) :: count                  !! 0 if modes are not resolved, as the run notes
    type(error_type), allocatable, intent(out) :: error
    real(dp), intent(out), optional :: reached     !! estimated error over the peak
    type(case_motion), allocatable :: motion
    count = 0
    if (.not. is_planned(scene)) return
    call plan_motion(scene, monitor, motion, count, error)
    if (present(reached)) reached = motion%plan%reached
  end subroutine plan_case

  subroutine plan_motion(scene, monitor, motion, count, error)
    !! Do the same as `plan_case`, and keep the motion up to its histories.
    !! **Errors**: see `plan_case`.
    type(scene_type), intent(in) :: scene          !! without sweeps
    class(monitor_type), intent(inout), target :: monitor
    type(case_motion), allocatable, intent(inout) :: motion   !! unallocated, or planned for another tolerance
    integer, intent(out) :: count
    type(error_type), allocatable, intent(out) :: error
    type(search_failure), target :: failure
    type(motion_cache) :: cache
    character(:), allocatable :: place
    integer :: line
    count = 0
    if (.not. allocated(motion)) then
      allocate (motion)
      motion%units = units_of(scene%beam)
      call find_modes(scene, motion%units, monitor, motion%modes)
      if (monitor%stop_requested()) return
    end if
    call observe_searches(motion%modes%configuration, failure, monitor)
    call try_tolerance(scene, motion, monitor, cache)
    if (monitor%stop_requested()) return
    if (failure%first == 0 .and. size(motion%timeline%segments) > 0) count = motion%timeline%segments(1)%count
    if (failure%first > 0 .or. motion%plan%within) return
    if (scene%modes%asked) call find_named(scene, monitor, motion%plan)
    line = scene%groups(position_of(scene%groups, 'modes'))%line_of('tolerance')
    place = scene%file
    if (line > 0) place = place//':'//text_of(line)         ! 0: default of an absent group
    call fail(error, status_bad_input, place//': modes%tolerance: '//out_of_reach(scene, motion))
  end subroutine plan_motion

  subroutine try_tolerance(scene, motion, monitor, cache)
    !! Choose the number of modes. Unless it is certain to meet the tolerance, sum histories to check.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion     !! its modes are known
    class(monitor_type), intent(inout), target :: monitor
    type(motion_cache), intent(inout) :: cache
    type(case_histories) :: histories
    type(history_errors) :: errors
    call find_motion(scene, motion, monitor, cache)
    if (monitor%stop_requested() .or. motion%plan%is_certain() .or. .not. motion%plan%within) return
    call find_histories(scene, motion, monitor, cache, histories, errors)
  end subroutine try_tolerance

  subroutine find_named(scene, monitor, plan)
    !! Find a tolerance that can be met, to be named instead of a refused one. Near the limit it is planned as in a run
    !! before it is named.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout), target :: monitor
    type(plan_type), intent(inout) :: plan         !! refused
    integer, parameter :: tries = 4
    type(case_motion), allocatable :: motion
    type(motion_cache) :: cache
    type(scene_type) :: other
    integer :: try
    other = scene
    do try = 1, tries
      if (.not. any(plan%exhausted) .or. is_missing(relaxed_tolerance(plan%surely))) return
      other%modes%tolerance = plan%named()
      if (allocated(motion)) deallocate (motion)
      allocate (motion)
      motion%units = units_of(scene%beam)
      call find_modes(other, motion%units, monitor, motion%modes)
      if (.not. monitor%stop_requested()) call try_tolerance(other, motion, monitor, cache)
      if (monitor%stop_requested() .or. motion%plan%within) return
      plan%surely = max(motion%plan%surely, other%modes%tolerance)
    end do
  end subroutine find_named

  subroutine fix_tolerance(scene, monitor, count, error, motion)
    !! Plan a scene before its run. An unreachable default tolerance is relaxed. In a sweep each case relaxes its own,
    !! and a requested one is tried at a few corners: other cases may still not converge.
    !! **Errors**: `status_bad_input` if a requested tolerance is out of reach, or there is none that can be met.
    type(scene_type), intent(inout) :: scene
    class(monitor_type), intent(inout), target :: monitor  !! nothing is planned if it requests a stop
    integer, intent(out) :: count                  !! modes summed by a single case; 0: unknown
    type(error_type), allocatable, intent(out) :: error
    type(case_motion), allocatable, intent(out), optional :: motion
      !! of a single case, up to its histories; unallocated if not planned
    type(case_motion), allocatable :: planned
    type(scene_type) :: one
    integer(i8), allocatable :: corners(:)
    integer :: i, ignored
    count = 0
    if (.not. is_planned(scene)) return
    if (size(scene%sweeps) == 0) then
      call plan_relaxed(scene, monitor, planned, count, error)
      if (present(motion) .and. count > 0 .and. .not. allocated(error)) call move_alloc(planned, motion)
    else if (scene%modes%asked) then
      corners = few_corners(scene)
      do i = 1, size(corners)
        if (monitor%stop_requested()) return
        call case_scene(scene, corners(i), one, error)
        if (.not. allocated(error)) call plan_case(one, monitor, ignored, error)
        if (.not. allocated(error)) cycle
        error%message = error%message//case_words(scene, corners(i))
        return
      end do
    end if
  end subroutine fix_tolerance

  subroutine plan_relaxed(scene, monitor, motion, count, error)
    !! Do the same as `plan_motion`, and relax a default tolerance that is out of reach.
    !! **Errors**: those of `plan_case`, for a requested tolerance or if none can be met.
    type(scene_type), intent(inout) :: scene       !! without sweeps
    class(monitor_type), intent(inout), target :: monitor
    type(case_motion), allocatable, intent(out) :: motion
    integer, intent(out) :: count
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: relaxed
    do
      call plan_motion(scene, monitor, motion, count, error)
      if (.not. allocated(error) .or. scene%modes%asked) return
      relaxed = relaxed_tolerance(max(scene%modes%tolerance, motion%plan%reached))
      if (is_missing(relaxed)) return
      deallocate (error)
      scene%modes%tolerance = relaxed
      call scene%groups(position_of(scene%groups, 'modes'))%derive('tolerance', relaxed, 0)
    end do
  end subroutine plan_relaxed

end module bw_case_tolerance
