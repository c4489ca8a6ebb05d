module bw_planned_case
  !! The motion of a case whose number of modes is given, or planned beforehand from its tolerance: modes ► impact and
  !! later events ► histories ► errors, and the motion under loads.
  use bw_beam_units, only: units_of
  use bw_case_cost, only: case_shares, events_share, histories_share, modes_share, stage_part
  use bw_case_errors, only: drop_errors
  use bw_case_histories, only: add_hub_angle
  use bw_case_loads, only: add_loads
  use bw_case_modes, only: find_modes
  use bw_case_moments, only: find_moments
  use bw_case_result, only: simulation
  use bw_error, only: error_type
  use bw_kept_tolerance, only: find_histories, find_motion, motion_cache
  use bw_kinds, only: dp
  use bw_mode_set, only: observe_searches
  use bw_modes_par, only: shown_modes
  use bw_monitor, only: monitor_type, part_monitor
  use bw_note, only: remark
  use bw_reached_tolerance, only: with_counts
  use bw_scene, only: is_loaded, scene_type
  use bw_stopwatch, only: stage_events, stage_modes, stopwatch
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: run_planned

contains

  subroutine run_planned(scene, watch, monitor, cache, run, error)
    !! Run a case. Where only loads move the beam, they choose the number of modes (bw_case_loads).
    !! **Errors**: those of reading the loads.
    type(scene_type), intent(in) :: scene            !! without sweeps
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(motion_cache), intent(inout), target :: cache
    type(simulation), intent(inout), target :: run   !! new, or with the motion that was planned
    type(error_type), allocatable, intent(out) :: error
    type(part_monitor) :: part
    real(dp), allocatable :: share(:)
    logical :: is_new
    share = case_shares(scene)
    run%counted = scene
    if (is_loaded(scene) .and. .not. allocated(scene%impact)) run%counted = with_counts(scene, shown_modes)
    is_new = .not. allocated(run%motion)
    if (is_new) then
      allocate (run%motion)
      run%motion%units = units_of(scene%beam)
      part = stage_part(monitor, share, modes_share)
      call find_modes(run%counted, run%motion%units, part, run%motion%modes, cache%modes)
      if (monitor%stop_requested()) return
    end if
    call observe_searches(run%motion%modes%configuration, run%failure, monitor)
    call watch%lap(stage_modes)
    if (is_new) then
      part = stage_part(monitor, share, events_share)
      call find_motion(run%counted, run%motion, part, cache)
      if (monitor%stop_requested()) return
      if (allocated(scene%impact)) call watch%lap(stage_events)
    end if
    part = stage_part(monitor, share, histories_share)
    call find_histories(run%counted, run%motion, part, cache, run%histories, run%errors, watch)
    if (monitor%stop_requested() .or. .not. allocated(scene%response)) return
    if (scene%response%bending_moment) call find_moments(run%counted, run%motion, part, run%histories, run%errors)
    if (monitor%stop_requested()) return
    call add_hub_angle(run%counted, run%motion, part, run%histories%response)
    if (monitor%stop_requested()) return
    call drop_errors(run%motion, run%errors)
    if (is_loaded(scene)) call add_loads(scene, run%motion, part, cache%modes, run%histories, run%errors, run%loads, error)
    if (allocated(scene%hub) .and. size(run%motion%timeline%events) > 0) call remark(run%motion%notes, &
      'hub: after the last event its mean angular velocity is '//shortest(sum(run%motion%timeline%events%hub_rate_change) &
      *(scene%impact%approach_velocity/run%motion%units%length), 6)//' rad/s, in addition to the steady rotation')
  end subroutine run_planned

end module bw_planned_case
