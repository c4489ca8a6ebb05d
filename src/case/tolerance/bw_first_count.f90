module bw_first_count
  !! How many modes a tolerance sums in the first segment. A survey of the modes estimates the contribution of all
  !! beyond a count; it covers twice the count that is judged, as long as that is cheap.
  use bw_case_drift, only: drift_of_state
  use bw_case_modes, only: case_mode_cache, extend_source, first_modes
  use bw_case_notes, only: most_modes, most_of
  use bw_case_peak, only: peak_after_changes, previewed_peak
  use bw_case_result, only: case_motion
  use bw_kinds, only: dp
  use bw_mode_set, only: configuration_type, deflections, mode_source
  use bw_monitor, only: monitor_type
  use bw_plan, only: bound_times, looked_ahead
  use bw_scene, only: scene_type
  use bw_segment, only: segment_type
  use bw_segment_samples, only: stretch_of
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  use bw_timeline, only: later_steps, occurs_in_record, step_type, time_of
  use bw_truncation_error, only: lowest_cutoff, displacement_error, find_tail, tail_type
  implicit none (type, external)
  private
  public :: choose_first, next_count, steepest

  integer, parameter :: most_previewed = 2**16   !! limit of modes summed to find the peak
  real(dp), parameter :: seen_part_of_most = 0.1_dp   !! of the modes that are found quickly; from there on errors are extrapolated
  real(dp), parameter :: near_enough = 1.02_dp   !! accepted count over the least that meets a tolerance

contains

  subroutine choose_first(scene, motion, segment, monitor, cache)
    !! Choose the count for the segment from t = 0 to the first change.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(segment_type), intent(inout) :: segment
    class(monitor_type), intent(inout), target :: monitor    !! the count is invalid if it requests a stop
    type(case_mode_cache), intent(inout), optional :: cache
    type(time_grid) :: grid
    integer :: samples
    segment%count = first_modes
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    if (grid%samples == 1 .or. segment%force == 0.0_dp .or. scene%impact%approach_velocity == 0.0_dp) return
    associate (plan => motion%plan, moving => motion%modes%configuration(segment%configuration))
      samples = samples_of_first(scene, motion, moving, grid)
      if (plan%survey(1)%bins == 0) then
        call plan%survey(1)%start(deflections, scene%response%points, stretch_of(grid, 2, samples, segment%start))
        call plan%survey(1)%add_source(moving%source, segment%force, 2*first_modes, monitor)
        if (monitor%stop_requested()) return
      end if
      if (plan%peak == 0.0_dp) call find_peak(scene, motion, segment, grid, samples, monitor)
      if (monitor%stop_requested() .or. samples == 1 .or. plan%peak == 0.0_dp) return
      call find_count(scene, motion, segment, grid, samples, monitor, cache)
    end associate
  end subroutine choose_first

  pure integer function samples_of_first(scene, motion, moving, grid) result(samples)
    !! Return the samples before the first change, or all.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(configuration_type), intent(in) :: moving
    type(time_grid), intent(in) :: grid
    type(step_type), allocatable :: steps(:)
    integer :: i
    samples = grid%samples
    steps = later_steps(scene)
    do i = 1, size(steps)
      associate (time => time_of(steps(i), motion%units))
        if (occurs_in_record(steps(i), scene, time, moving%set)) samples = min(samples, first_sample(time, grid) - 1)
      end associate
    end do
  end function samples_of_first

  subroutine find_peak(scene, motion, segment, grid, samples, monitor)
    !! Find a lower estimate of the peak of the whole motion.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(segment_type), intent(in) :: segment
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: samples               !! of the segment
    class(monitor_type), intent(inout), target :: monitor
    real(dp) :: errors(2), peak
    integer :: count
    associate (plan => motion%plan, moving => motion%modes%configuration(segment%configuration))
      count = first_modes
      do while (samples > 1)
        peak = previewed_peak(scene, moving, segment, count, time_grid(samples, grid%step), motion%units%time%hi, monitor)
        if (monitor%stop_requested()) return
        errors = first_errors(motion, segment, count, samples)
        plan%peak = max(0.5_dp*peak, peak - errors(1))
        if (errors(1) <= 0.5_dp*peak .or. 8*count > moving%source%highest .or. 4*count > most_previewed) exit
        count = 4*count                          ! truncation error as large as the peak: little has moved yet
        call plan%survey(1)%add_source(moving%source, segment%force, 2*count, monitor)
      end do
      if (samples < grid%samples) plan%peak = max(plan%peak, peak_after_changes(scene, motion, segment, grid, samples, monitor))
    end associate
  end subroutine find_peak

  function first_errors(motion, segment, count, samples) result(errors)
    !! Return the largest expected errors of the first modes: the estimate, and the bound over `bound_times`.
    type(case_motion), intent(inout) :: motion   !! its survey caches results
    type(segment_type), intent(in) :: segment
    integer, intent(in) :: count                 !! modes, to the end of a bin
    integer, intent(in) :: samples               !! of the segment
    real(dp) :: errors(2)
    type(tail_type) :: tail
    associate (plan => motion%plan, source => motion%modes%configuration(segment%configuration)%source)
      call find_tail(plan%survey(1), source%pieces%beam, source%damping, segment%energy, count, tail, segment%force, &
                     source%struck_at)
      errors = [maxval(displacement_error(tail, plan%part_of_block(1, count, samples - 1, source%pieces%beam))), &
                maxval(tail%bound)/bound_times]
    end associate
    errors = max(errors, 1.0e-100_dp)            ! for powers
  end function first_errors

  subroutine find_count(scene, motion, segment, grid, samples, monitor, cache)
    !! Find the least count within the aim, with as many modes as that takes.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(segment_type), intent(inout) :: segment
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: samples
    class(monitor_type), intent(inout) :: monitor
    type(case_mode_cache), intent(inout), optional :: cache
    real(dp), dimension(2) :: before, errors, fall, power   ! of estimate and bound: each falls at its own rate
    real(dp) :: allowed, drift
    integer :: last, last_before, most
    logical :: exhausted, extended
    associate (plan => motion%plan, survey => motion%plan%survey(1), &
               moving => motion%modes%configuration(segment%configuration))
      associate (modes => moving%set)
        drift = maxval(drift_of_state(modes, deflections, survey%points, 0.0_dp*modes%struck, &
                                      segment%force*modes%struck/modes%modal_mass, survey%stretch, grid, .false.))
      end associate
      allowed = plan%allowed(drift)
      most = most_of(scene, moving%source)
      last_before = 0
      do
        last = judged(survey%bin(:survey%bins)%last, min(most, moving%source%highest))
        errors = first_errors(motion, segment, last, samples)
        power = steepest(moving%source, survey%bin(survey%bin_of(last))%square)
        fall = power
        if (last > last_before .and. last_before > 0) then
          power = max(0.1_dp, log(before/errors)/log(real(last, dp)/last_before))
          fall = max(fall, power)
        end if
        exhausted = .false.
        if (all(errors <= allowed)) exit
        if (last >= min(most, moving%source%highest) .or. last == last_before) then   ! or the survey ends with whole bins
          call extend_source(scene, motion%units, segment%configuration, monitor, moving%source, extended, cache)
          exhausted = .not. extended
        else if (last >= seen_part_of_most*min(most_modes, moving%source%quickly)) then   ! do not find millions of modes in vain
          plan%within = all(errors*(real(last, dp)/most)**fall <= allowed/plan%aim)
        end if
        if (exhausted .or. .not. plan%within) exit
        last_before = last
        before = errors
        last = next_count(last, 1.1_dp*maxval((errors/allowed)**(1.0_dp/power)), min(most, moving%source%highest))
        call survey%add_source(moving%source, segment%force, min(most, max(last, min(2*last, 2*looked_ahead))), monitor)
        if (monitor%stop_requested()) return
      end do
      segment%count = last
      if (all(errors <= allowed)) segment%count = least_count(errors)
      if (plan%within) then
        fall = steepest(moving%source, survey%bin(survey%bin_of(last))%square)
        call plan%take_segment(1, maxval(first_errors(motion, segment, segment%count, samples)), &
                               bound_times*errors(2)*min(1.0_dp, real(last, dp)/most)**fall(2), drift, exhausted)
      else
        errors = errors*(real(last, dp)/most)**min(power, fall)
        call plan%take_segment(1, maxval(errors), bound_times*errors(2), drift, exhausted)
      end if
    end associate
  contains
    integer function least_count(errors) result(count)
      !! Find the least count, by power laws between a count that fails and one that suffices.
      real(dp), intent(in) :: errors(2)            !! of `last`, which suffices
      integer :: few, enough, try
      real(dp) :: now, over(2), power              ! errors over what is allowed
      associate (survey => motion%plan%survey(1))
        few = survey%bin_of(first_modes)
        enough = survey%bin_of(last)
        over = [error_ratio(few), maxval(errors)/allowed]
        if (over(1) <= 1.0_dp) enough = few
        do while (enough - few > 1)
          associate (ends => real(survey%bin([few, enough])%last, dp))
            if (ends(2) <= near_enough*ends(1)) exit
            power = log(over(1)/over(2))/log(ends(2)/ends(1))
            try = int(ends(1)*min(over(1)**(1.0_dp/power), ends(2)/ends(1)))
          end associate
          try = max(few + 1, min(enough - 1, findloc(survey%bin(:enough)%last >= try, .true., dim=1)))
          now = error_ratio(try)
          if (now <= 1.0_dp) then
            enough = try
            over(2) = now
          else
            few = try
            over(1) = now
          end if
        end do
        count = survey%bin(enough)%last
      end associate
    end function least_count
    real(dp) function error_ratio(bin) result(over)
      integer, intent(in) :: bin                   !! modes to the end of this bin
      over = maxval(first_errors(motion, segment, motion%plan%survey(1)%bin(bin)%last, samples))/allowed
    end function error_ratio
  end subroutine find_count

  pure integer function judged(last, most)
    !! Return how many surveyed modes are judged: half, so that as many beyond are known; all if there are no more, or many.
    integer, intent(in) :: last(:)                 !! modes of the bins
    integer, intent(in) :: most                    !! upper limit
    judged = last(size(last))
    if (judged < most .and. judged < 2*looked_ahead) judged = last(findloc(last >= judged/2, .true., dim=1))
  end function judged

  pure function steepest(source, square) result(power)
    !! Return the exponents by which estimate and bound finally fall with the number of modes. Amplitudes fall as k⁻³,
    !! with shear as k⁻². In the bound, and in the estimate if phases agree, they add up; else they add at random.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: square                 !! β² of the last mode
    real(dp) :: power(2)
    associate (beam => source%pieces%beam)
      power = merge(1.0_dp, 2.0_dp, any(beam%piece%compliance%hi > 0.0_dp))
      if (.not. lowest_cutoff(beam) < square) power(1) = power(1) + 0.5_dp
    end associate
  end function steepest

  pure integer function next_count(last, times, most) result(count)
    !! Return the count that an error needs which falls as a power of it, in limited steps, so that the power can be updated.
    integer, intent(in) :: last
    real(dp), intent(in) :: times                !! times the surveyed modes
    integer, intent(in) :: most
    real(dp), parameter :: least = 1.1_dp, largest = 16.0_dp
    count = int(min(real(most, dp), last*max(least, min(largest, times)) + 1.0_dp))
  end function next_count

end module bw_first_count
