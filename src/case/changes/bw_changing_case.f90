module bw_changing_case
  !! The motion of a case whose beam changes in time, or starts deflected or rotating: modes ► segments and events ►
  !! histories ► errors.
  !!
  !! The motion is followed with all modes and with some eighths of them, and the differences estimate the truncation
  !! error; that of a beam which is only let go needs two runs (bw_let_go_errors). A tolerance doubles the number of modes
  !! until the error is small enough. The motion under loads is superposed, as all changes are linear (bw_case_loads).
  use bw_beam_units, only: in_joules, units_of
  use bw_case_histories, only: add_hub_angle, sum_histories
  use bw_case_loads, only: add_loads
  use bw_case_modes, only: case_mode_cache, find_modes, most_in_run
  use bw_case_moments, only: find_moments
  use bw_case_result, only: add_notes, case_done, case_histories, case_motion, case_not_converged, history_errors, simulation
  use bw_change_of_bodies, only: beam_state
  use bw_changing_errors, only: add_difference, add_rounding_of_turn, extrapolate, join_state_errors, leave_out_rounding, &
    rounding_of_turn
  use bw_changing_motion, only: follow_changes
  use bw_contact_errors, only: add_rounding
  use bw_error, only: error_type
  use bw_event, only: event_words
  use bw_kinds, only: dp
  use bw_let_go_errors, only: find_let_go_errors
  use bw_missing, only: is_missing
  use bw_mode_set, only: deflections, observe_searches
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type
  use bw_note, only: remark
  use bw_reached_tolerance, only: is_met, judge_tolerance, part_of_peak, with_counts
  use bw_scene, only: is_let_go, is_loaded, scene_type
  use bw_stopwatch, only: stage_events, stage_modes, stage_response, stopwatch
  use bw_text, only: shortest
  implicit none (type, external)
  private
  public :: run_changes

  integer, parameter :: most_count = 2048          !! and the most that it may sum
  real(dp), parameter :: state_share = 0.3_dp      !! tuned: of a tolerance, left to errors of the states after changes

contains

  subroutine run_changes(scene, watch, monitor, cache, run, error)
    !! Run a case with the counts of the scene or by its tolerance.
    !! **Errors**: those of reading the loads.
    type(scene_type), intent(in) :: scene            !! without sweeps
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor   !! results are invalid if it requests a stop
    type(case_mode_cache), intent(inout), target :: cache
    type(simulation), intent(inout), target :: run   !! new
    type(error_type), allocatable, intent(out) :: error
    type(beam_state), allocatable :: before_event(:) ! of the motion under loads
    integer :: handing
    allocate (run%motion)
    associate (motion => run%motion, histories => run%histories, errors => run%errors)
      call follow_to_tolerance(scene, watch, monitor, cache, run, handing)
      if (monitor%stop_requested()) return
      if (.not. motion%modes%resolved) then
        errors%status = case_not_converged
        return
      end if
      if (is_loaded(scene) .and. allocated(histories%response)) then
        call add_loads(scene, motion, monitor, cache, histories, errors, run%loads, error, before_event)
        if (monitor%stop_requested() .or. allocated(error)) return
        call follow_changes(times_as_many(run%counted, handing), 8, handing, motion, monitor, before_event)
        if (monitor%stop_requested()) return
      end if
      call note_losses(motion)
      if (errors%status == case_done) motion%plan%within = is_met(scene%modes, motion%plan%reached)
      call judge_tolerance(scene%modes, motion%plan%reached, run%counted%modes%before, 'fewer quantities', histories%response, &
                           errors)
    end associate
  end subroutine run_changes

  subroutine follow_to_tolerance(scene, watch, monitor, cache, run, handing)
    !! Follow the motion with the counts of the scene, or with as many modes as its tolerance needs, and estimate its errors.
    type(scene_type), intent(in) :: scene
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor
    type(case_mode_cache), intent(inout), target :: cache
    type(simulation), intent(inout), target :: run
    integer, intent(out) :: handing                  !! how many times the summed modes are projected at changes
    real(dp), allocatable :: rounding(:, :)
    logical :: enough
    integer :: most
    handing = 1
    most = most_in_run(scene, most_count)
    associate (counted => run%counted, motion => run%motion, histories => run%histories, errors => run%errors)
      counted = with_counts(scene)
      do
        motion = case_motion(units=units_of(scene%beam))
        motion%of_continuum = by_tolerance(scene%modes)
        call find_modes(times_as_many(counted, handing), motion%units, monitor, motion%modes, cache)
        if (monitor%stop_requested()) return
        call watch%lap(stage_modes)
        if (.not. motion%modes%resolved) return
        call observe_searches(motion%modes%configuration, run%failure, monitor)
        call follow_fewer(counted, handing, motion, watch, monitor, cache, histories, errors)
        if (monitor%stop_requested() .or. .not. (allocated(scene%response) .and. motion%modes%resolved)) return
        rounding = rounding_of_turn(counted, motion)
        call leave_out_rounding(rounding, errors)
        enough = part_of_peak(histories%response, errors) <= (1.0_dp - state_share)*scene%modes%tolerance
        call join_state_errors(counted, motion, errors)
        motion%plan%reached = part_of_peak(histories%response, errors)
        if (histories%status /= case_done .or. is_met(scene%modes, motion%plan%reached)) exit
        if (enough) then
          if (2*handing*counted%modes%before > most) exit
          handing = 2*handing
        else
          if (counted%modes%before >= most) exit
          counted%modes%before = min(most, 2*counted%modes%before)
          counted%modes%after = counted%modes%before
          handing = max(1, min(handing, most/counted%modes%before))
        end if
      end do
      call add_rounding(counted, motion, histories%response, errors)
      motion%plan%reached = part_of_peak(histories%response, errors)
      call add_rounding_of_turn(rounding, errors)
    end associate
  end subroutine follow_to_tolerance

  pure type(scene_type) function times_as_many(scene, times) result(more)
    !! Multiply the mode counts of a scene.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: times
    more = scene
    more%modes%before = times*scene%modes%before
    more%modes%after = times*scene%modes%after
  end function times_as_many

  subroutine follow_fewer(scene, handing, motion, watch, monitor, cache, histories, errors)
    !! Follow the motion with all modes and with fewer, and extrapolate the differences to the truncation error (`extrapolate`).
    !! After later arrivals of bodies differences vary irregularly with the count, so the largest of several is taken.
    type(scene_type), intent(in) :: scene            !! with mode counts
    integer, intent(in) :: handing                   !! how many times the summed modes are projected at changes
    type(case_motion), intent(inout) :: motion       !! its modes are known
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor
    type(case_mode_cache), intent(inout), target :: cache
    type(case_histories), intent(out) :: histories
    type(history_errors), intent(out) :: errors
    type(case_histories) :: half, other, quarter
    type(case_motion) :: reduced
    type(history_errors) :: before, early            ! differences of half and a quarter, and of a quarter and an eighth
    integer :: eighths, fewer
    if (allocated(scene%response)) then
      call run_eighths(scene, 4, handing, motion, watch, monitor, half)
      if (monitor%stop_requested() .or. .not. motion%modes%resolved) return
      fewer = motion%timeline%segments(1)%count
    end if
    call run_eighths(scene, 8, handing, motion, watch, monitor, histories)
    if (monitor%stop_requested() .or. .not. (allocated(scene%response) .and. motion%modes%resolved)) return
    errors = history_errors(status=histories%status)
    call add_difference(histories%response, half%response, errors)
    if (is_let_go(scene)) then
      call find_let_go_errors(scene, motion, fewer, monitor, cache, errors)
      return
    end if
    reduced = motion
    do eighths = 7, 3, -1
      if (eighths == 4 .or. size(motion%timeline%events) == 0) cycle
      call run_eighths(scene, eighths, handing, reduced, watch, monitor, other)
      if (monitor%stop_requested()) return
      if (eighths > 4) then
        call add_difference(histories%response, other%response, errors)
      else
        call add_difference(half%response, other%response, before)
      end if
    end do
    call run_eighths(scene, 2, handing, reduced, watch, monitor, quarter)
    if (monitor%stop_requested()) return
    call add_difference(half%response, quarter%response, before)
    call run_eighths(scene, 1, handing, reduced, watch, monitor, other)
    if (monitor%stop_requested()) return
    call add_difference(quarter%response, other%response, early)
    call watch%lap(stage_response)
    call extrapolate(early%displacement, before%displacement, errors%displacement)
    if (allocated(errors%velocity)) call extrapolate(early%velocity, before%velocity, errors%velocity)
    if (allocated(errors%bending_moment)) call extrapolate(early%bending_moment, before%bending_moment, errors%bending_moment)
  end subroutine follow_fewer

  subroutine run_eighths(scene, eighths, handing, motion, watch, monitor, found)
    !! Follow the motion with some eighths of the modes, and sum its histories. `motion` is that of this run afterwards.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: eighths, handing
    type(case_motion), intent(inout) :: motion
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor
    type(case_histories), intent(out) :: found
    type(history_errors) :: none
    call follow_changes(scene, eighths, handing, motion, monitor)
    if (monitor%stop_requested() .or. .not. motion%modes%resolved) return
    call watch%lap(stage_events)
    if (.not. allocated(scene%response)) return
    call sum_histories(scene, motion, deflections, monitor, found)
    if (monitor%stop_requested()) return
    if (scene%response%bending_moment) call find_moments(scene, motion, monitor, found, none)
    if (monitor%stop_requested()) return
    found%status = max(found%status, none%status)
    call add_notes(found%notes, none%notes)
    if (eighths == 8) call add_hub_angle(scene, motion, monitor, found%response)
  end subroutine run_eighths

  subroutine note_losses(motion)
    !! Note the event at which most energy is lost.
    type(case_motion), intent(inout) :: motion
    real(dp), parameter :: nothing = 1.0e-9_dp       ! of the energy before
    real(dp), allocatable :: lost(:)
    integer :: i
    associate (events => motion%timeline%events)
      if (size(events) == 0) return
      lost = events%energy_before - events%energy_after
      where (is_missing(events%energy_before) .or. is_missing(events%energy_after)) lost = 0.0_dp
      i = maxloc(lost, dim=1)
      if (lost(i) <= nothing*abs(events(i)%energy_before)) return
      associate (joules => in_joules([lost(i), events(i)%energy_before], motion%units, 1.0_dp))
        call remark(motion%notes, 'energy of events: at most '//shortest(joules(1), 3)//' J of '//shortest(joules(2), 3)// &
          ' J are lost, at the '//trim(event_words(events(i)%kind))//' at t = '//shortest(events(i)%time, 6)// &
          ' s: in the blow, or to modes that are not summed')
      end associate
    end associate
  end subroutine note_losses

end module bw_changing_case
