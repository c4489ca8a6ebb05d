module bw_kept_tolerance
  !! Motion and histories with as many modes as the tolerance needs. If the histories miss it, the number is chosen anew
  !! with what they showed. With given counts there is one sum.
  use bw_case_drift, only: drift_errors
  use bw_case_errors, only: estimate_errors
  use bw_case_histories, only: sum_histories
  use bw_case_modes, only: case_mode_cache
  use bw_case_motion, only: follow_motion, start_motion
  use bw_case_result, only: case_histories, case_motion, history_errors
  use bw_initial_state, only: initial_state_cache
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_mode_set, only: deflections
  use bw_monitor, only: monitor_type, part_monitor
  use bw_plan, only: bound_times
  use bw_scene, only: scene_type
  use bw_stopwatch, only: stage_events, stopwatch
  implicit none (type, external)
  private
  public :: find_histories, find_motion

  type, public :: motion_cache
    !! Work shared by several motions.
    type(case_mode_cache) :: modes
    type(initial_state_cache) :: initial
  end type motion_cache

contains

  subroutine find_motion(scene, motion, monitor, cache)
    !! Find the motion from the impact on, with a chosen number of modes.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion     !! its modes are known
    class(monitor_type), intent(inout), target :: monitor   !! the motion is invalid if it requests a stop
    type(motion_cache), intent(inout) :: cache
    type(part_monitor) :: part
    call start_motion(scene, motion, monitor, cache%initial, cache%modes)
    if (monitor%stop_requested()) return
    part = part_monitor(monitor, 1.0_dp, 0.0_dp)            ! duration of later events is unknown
    call follow_motion(scene, motion, part, cache%modes)
  end subroutine find_motion

  subroutine find_histories(scene, motion, monitor, cache, histories, errors, watch)
    !! Sum a motion until its tolerance is met. If there are no more modes, the plan notes it, and there are no histories.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion     !! found
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
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
      call sum_histories(scene, motion, deflections, part, histories)
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
      !! Update the plan with the results of the sum.
      associate (unit => abs(scene%impact%approach_velocity)*motion%units%time%hi, plan => motion%plan)
        call plan%learn(errors%part, largest_magnitude(histories%response%displacement)/unit, errors%segment, &
                        max(maxval(errors%displacement), maxval(errors%displacement_bound)/bound_times)/unit, &
                        maxval(drift_errors(scene, motion, deflections, .false.))/unit)
        plan%within = plan%within .and. try < tries - 1
      end associate
    end subroutine learn
  end subroutine find_histories

end module bw_kept_tolerance
