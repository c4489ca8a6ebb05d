module bw_kept_tolerance
  !! The motion of a case and its histories, of as many modes as keep its tolerance. Where the histories show that the modes which were
  !! chosen do not, more are chosen by what was seen. Of modes that a scene counts it is one sum.
  use bw_case_drift, only: drift_errors
  use bw_case_errors, only: estimate_errors
  use bw_case_histories, only: sum_histories, sums_of_segment
  use bw_case_modes, only: case_mode_cache
  use bw_case_motion, only: follow_motion, start_motion
  use bw_case_result, only: case_histories, case_motion, history_errors
  use bw_initial_state, only: initial_state_cache
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_mode_set, only: deflections
  use bw_monitor, only: monitor_type, part_monitor
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_plan, only: bound_times
  use bw_scene, only: scene_type
  use bw_stopwatch, only: stage_events, stopwatch
  implicit none (type, external)
  private
  public :: find_histories, find_motion

  type, public :: motion_cache
    !! Work that motions share, done once.
    type(case_mode_cache) :: modes
    type(initial_state_cache) :: initial
    type(nonuniform_sum) :: sums(sums_of_segment)   !! kernels, plans and grids of the last transforms
  end type motion_cache

contains

  subroutine find_motion(scene, motion, monitor, cache)
    !! From the impact on, with as many modes as are chosen for it.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion     !! its modes are known
    class(monitor_type), intent(inout), target :: monitor   !! the motion means nothing where it asks to stop
    type(motion_cache), intent(inout) :: cache
    type(part_monitor) :: part
    call start_motion(scene, motion, monitor, cache%initial, cache%modes)
    if (monitor%stop_requested()) return
    part = part_monitor(monitor, 1.0_dp, 0.0_dp)            ! how long later events take is not known
    call follow_motion(scene, motion, part, cache%modes)
  end subroutine find_motion

  subroutine find_histories(scene, motion, monitor, cache, histories, errors, watch)
    !! Sum a motion until its tolerance is kept. Where there are no more modes to be had, the plan says so, and there are no histories.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion     !! found
    class(monitor_type), intent(inout), target :: monitor   !! what is found means nothing where it asks to stop
    type(motion_cache), intent(inout) :: cache
    type(case_histories), intent(out) :: histories
    type(history_errors), intent(out) :: errors
    type(stopwatch), intent(inout), optional :: watch
    type(part_monitor) :: part
    integer, parameter :: tries = 10
    integer :: try
    do try = 1, tries
      part = part_monitor(monitor)
      if (try > 1) part = part_monitor(monitor, 1.0_dp, 0.0_dp)
      call sum_histories(scene, motion, deflections, part, cache%sums, histories)
      if (monitor%stop_requested()) return
      call estimate_errors(scene, motion, histories, part, errors)
      if (monitor%stop_requested() .or. .not. errors%missed) return
      call learn()
      if (.not. motion%plan%within) cycle
      part = part_monitor(monitor, 1.0_dp, 0.0_dp)
      call find_motion(scene, motion, part, cache)
      if (monitor%stop_requested()) return
      if (present(watch)) call watch%lap(stage_events)
    end do
  contains
    subroutine learn()
      !! What the sum has shown.
      associate (unit => abs(scene%impact%approach_velocity)*motion%units%time%hi, plan => motion%plan)
        call plan%learn(errors%part, largest_magnitude(histories%response%displacement)/unit, errors%segment, &
                        max(maxval(errors%displacement), maxval(errors%displacement_bound)/bound_times)/unit, &
                        maxval(drift_errors(scene, motion, deflections, .false.))/unit)
        plan%within = plan%within .and. try < tries - 1
      end associate
    end subroutine learn
  end subroutine find_histories

end module bw_kept_tolerance
