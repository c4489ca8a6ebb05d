module bw_case_tolerance
  !! What a tolerance asks of a scene, before it is run: how many modes are summed, and whether it can be had at all. A run goes on
  !! from the motion that this leaves.
  use bw_beam_units, only: units_of
  use bw_case_modes, only: find_modes
  use bw_case_notes, only: out_of_reach
  use bw_case_result, only: case_histories, case_motion, history_errors
  use bw_error, only: error_type, fail, status_bad_input
  use bw_input_values, only: position_of
  use bw_kept_tolerance, only: find_histories, find_motion, motion_cache
  use bw_kinds, only: dp, i8
  use bw_missing, only: is_missing
  use bw_mode_set, only: attend, search_failure
  use bw_modes_par, only: by_tolerance, relaxed_tolerance
  use bw_monitor, only: monitor_type
  use bw_plan, only: plan_type
  use bw_scene, only: counts_in_its_run, scene_type
  use bw_scene_cases, only: case_scene, case_words, few_corners
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: plan_case, fix_tolerance

contains

  subroutine plan_case(scene, monitor, count, error, reached)
    !! How many modes a scene with a tolerance will sum; 0 of one that counts them, or whose impact lasts.
    !! **Errors**: `status_bad_input` where the tolerance is out of reach.
    type(scene_type), intent(in) :: scene          !! without sweeps
    class(monitor_type), intent(inout), target :: monitor  !! nothing is planned where it asks to stop
    integer, intent(out) :: count                  !! 0 where the modes are not resolved: the run says so
    type(error_type), allocatable, intent(out) :: error
    real(dp), intent(out), optional :: reached     !! the estimated error over the peak
    type(case_motion), allocatable :: motion
    count = 0
    if (.not. by_tolerance(scene%modes) .or. counts_in_its_run(scene)) return
    call plan_motion(scene, monitor, motion, count, error)
    if (present(reached)) reached = motion%plan%reached
  end subroutine plan_case

  subroutine plan_motion(scene, monitor, motion, count, error)
    !! `plan_case`, with the motion up to its histories.
    !! **Errors**: as those of `plan_case`.
    type(scene_type), intent(in) :: scene          !! without sweeps
    class(monitor_type), intent(inout), target :: monitor
    type(case_motion), allocatable, intent(inout) :: motion   !! unallocated, or what another tolerance left
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
    call attend(motion%modes%configuration, failure, monitor)
    call try_tolerance(scene, motion, monitor, cache)
    if (monitor%stop_requested()) return
    if (failure%first == 0 .and. size(motion%timeline%segments) > 0) count = motion%timeline%segments(1)%count
    if (failure%first > 0 .or. motion%plan%within) return
    if (scene%modes%asked) call find_named(scene, monitor, motion%plan)
    line = scene%groups(position_of(scene%groups, 'modes'))%line_of('tolerance')
    place = scene%file
    if (line > 0) place = place//':'//text_of(line)         ! 0: it is the default of an absent group
    call fail(error, status_bad_input, place//': modes%tolerance: '//out_of_reach(scene, motion))
  end subroutine plan_motion

  subroutine try_tolerance(scene, motion, monitor, cache)
    !! Choose how many modes are summed. Where it is not certain that the tolerance is kept, the sum tells.
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
    !! Find a tolerance that can be kept, in the place of one that cannot: near the limit it is planned as a run would, before it is
    !! named.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout), target :: monitor
    type(plan_type), intent(inout) :: plan         !! that was refused
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
    !! Plan a scene before it is run. A default tolerance becomes the one that is used; in a sweep each case relaxes its own,
    !! and one that was asked for is tried at few of the corners: other cases may still not converge.
    !! **Errors**: `status_bad_input` where a tolerance that was asked for is out of reach, or none can be had.
    type(scene_type), intent(inout) :: scene
    class(monitor_type), intent(inout), target :: monitor  !! nothing is planned where it asks to stop
    integer, intent(out) :: count                  !! of modes to be summed by a single case; 0: not known
    type(error_type), allocatable, intent(out) :: error
    type(case_motion), allocatable, intent(out), optional :: motion
      !! of a single case, up to its histories; unallocated where none is planned
    type(case_motion), allocatable :: planned
    type(scene_type) :: one
    integer(i8), allocatable :: corners(:)
    integer :: i, ignored
    count = 0
    if (.not. by_tolerance(scene%modes) .or. counts_in_its_run(scene)) return     ! the run finds the count
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
    !! The same as `plan_motion`, of a scene whose default tolerance becomes the one that is used where it is out of reach.
    !! **Errors**: as those of `plan_case`, of a tolerance that was asked for or where none can be had.
    type(scene_type), intent(inout) :: scene       !! as that of `plan_case`
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
