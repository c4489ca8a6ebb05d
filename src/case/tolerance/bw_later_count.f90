module bw_later_count
  !! How many modes a tolerance needs at a change: modes after it that are summed, and modes before it that are projected.
  use bw_case_drift, only: drift_of_state
  use bw_case_modes, only: case_mode_cache, extend_source, first_modes
  use bw_case_notes, only: most_modes, most_released
  use bw_case_result, only: case_motion
  use bw_double_double, only: operator(*), operator(-)
  use bw_first_count, only: next_count, steepest
  use bw_kinds, only: dp
  use bw_lack_error, only: find_lack, lack_error
  use bw_mode_set, only: deflections, first_numbers
  use bw_monitor, only: monitor_type
  use bw_plan, only: bound_times
  use bw_projection, only: project, projection_type
  use bw_release, only: energy_after
  use bw_rotation, only: speed_in_plane
  use bw_scene, only: scene_type
  use bw_segment, only: segment_type
  use bw_segment_samples, only: stretch_of
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  use bw_truncation_error, only: displacement_error, find_tail, tail_type
  implicit none (type, external)
  private
  public :: choose_later

  real(dp), parameter :: doubt_share = 0.3_dp    !! of the allowed error, left to errors of the projected state
  real(dp), parameter :: bound_share = 0.5_dp    !! of the bound, left to either part

contains

  subroutine choose_later(scene, motion, last, next, projection, monitor, cache)
    !! Choose both counts for the segment after a change.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(segment_type), intent(in) :: last       !! copy of the segment before
    type(segment_type), intent(inout) :: next    !! with start and configuration
    type(projection_type), intent(inout) :: projection   !! new
    class(monitor_type), intent(inout), target :: monitor
    type(case_mode_cache), intent(inout), optional :: cache
    type(time_grid) :: grid
    real(dp) :: allowed, doubt, drift, error, last_doubt, surely
    integer :: first, handed, i, last_handed, most, most_handed, n, samples
    logical :: exhausted, extended, grows, seen
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    first = first_sample(next%start, grid)
    samples = grid%samples - first + 1
    seen = first <= grid%samples .and. motion%plan%peak > 0.0_dp
    i = size(motion%timeline%segments) + 1
    next%count = first_modes
    associate (plan => motion%plan, before => motion%modes%configuration(last%configuration), &
               after => motion%modes%configuration(next%configuration))
      most_handed = min(most_modes, before%source%highest, max(before%source%quickly, last%count))
      most = min(most_released, after%source%highest)
      handed = 0
      last_doubt = 0.0_dp
      last_handed = 0
      n = min(most, max(first_modes, 2*last%count))    ! a beam without its mass takes nearly twice as many
      if (.not. seen) n = min(most, first_modes)
      do
        call after%source%find(first_numbers(n), after%set, grid%samples*grid%step%hi, monitor)
        call project(last, before, next%start - last%start, grid%samples*grid%step%hi, handed, after%set, projection, monitor)
        if (monitor%stop_requested()) return
        call survey_next()
        grows = .false.
        exhausted = .false.
        if (doubt > 1.0_dp) then
          if (projection%place%count == before%source%highest) then
            call extend_source(scene, motion%units, last%configuration, monitor, before%source, extended, cache)
            if (extended) most_handed = min(most_modes, before%source%highest)
          end if
          grows = projection%place%count < most_handed
          exhausted = .not. grows
          if (grows) handed = more_handed()
        end if
        if (error > 1.0_dp) then
          if (n == most) then
            call extend_source(scene, motion%units, next%configuration, monitor, after%source, extended, cache)
            if (extended) most = min(most_released, after%source%highest)
          end if
          exhausted = exhausted .or. n == most
          grows = grows .or. n < most
          n = min(most, next_count(n, 1.05_dp*error**0.4_dp, 2*n))
        end if
        if (.not. grows) exit
      end do
      if (seen) call cut_to_least()
    end associate
  contains
    integer function more_handed() result(count)
      !! Return how many modes to project next, if the projection error keeps falling at its last rate.
      real(dp) :: power
      power = 1.5_dp
      associate (known => projection%place%count)
        if (last_handed > 0 .and. known > last_handed) &
          power = max(0.5_dp, min(power, log(last_doubt/doubt)/log(real(known, dp)/last_handed)))
        count = int(min(real(most_handed, dp), known*max(1.25_dp, min(64.0_dp, 1.05_dp*doubt**(1.0_dp/power)))))
        last_handed = known
        last_doubt = doubt
      end associate
    end function more_handed
    subroutine survey_next()
      !! Estimate the errors of the summed modes and of their projected state, over what is allowed of either.
      type(lack_error) :: lacking
      real(dp), dimension(size(scene%response%points)) :: part, times
      associate (survey => motion%plan%survey(i), after => motion%modes%configuration(next%configuration), &
                 stretch => stretch_of(grid, first, grid%samples, next%start))
        next%energy = energy_after(projection, after%set, speed_in_plane(scene%rotation, motion%units))
        call survey%start(deflections, scene%response%points, stretch, [n])
        call survey%add_set(after%set, 1, n, projection%q_after, projection%rate_after)
        error = 0.0_dp
        doubt = projection%place%part*sqrt(2.0_dp*projection%place%missing_energy*projection%place%mobility)/scene%modes%tolerance
        if (.not. seen) return
        drift = maxval(drift_of_state(after%set, deflections, survey%points, projection%q_after, projection%rate_after, stretch, &
                                      grid, .false.))
        allowed = motion%plan%allowed(drift)
        part = motion%plan%part_of_block(i, n, samples, after%source%pieces%beam)
        times = 0.0_dp
        call find_lack(projection%lack, after%set, n, survey, samples, part, times, lacking)
        doubt = max(maxval(lacking%displacement)/(doubt_share*allowed), maxval(lacking%bound)/(bound_share*bound_times*allowed))
        surely = 0.0_dp
        error = error_with(n)
        associate (fall => steepest(after%source, survey%bin(survey%bins)%square))
          surely = surely*min(1.0_dp, real(n, dp)/min(most_released, after%source%at_most))**fall(2) + maxval(lacking%bound) &
            *min(1.0_dp, real(projection%place%count, dp)/max(most_handed, 1))
        end associate
      end associate
    end subroutine survey_next
    real(dp) function error_with(count)
      !! Return the truncation error of the first `count` modes, over its share of the tolerance.
      integer, intent(in) :: count
      type(tail_type) :: tail
      associate (plan => motion%plan, source => motion%modes%configuration(next%configuration)%source)
        call find_tail(plan%survey(i), source%pieces%beam, source%damping, next%energy, count, tail)
        error_with = maxval(displacement_error(tail, plan%part_of_block(i, count, samples, source%pieces%beam))) &
          /(1.0_dp - doubt_share)
        surely = max(surely, maxval(tail%bound))
        error_with = max(error_with, maxval(tail%bound)/(bound_share*bound_times))/allowed
      end associate
    end function error_with
    subroutine cut_to_least()
      !! Drop modes that the tolerance does not need.
      integer :: few, enough, try
      real(dp) :: surest
      surest = surely
      few = min(first_modes, n)
      enough = n
      if (error_with(few) <= 1.0_dp) enough = few
      do while (enough - few > max(1, few/32))
        try = (few + enough)/2
        if (motion%plan%survey(i)%bin_of(try) == 0) exit
        if (error_with(try) <= 1.0_dp) then
          enough = try
        else
          few = try
        end if
      end do
      next%count = enough
      call motion%plan%take_segment(i, allowed*max(error_with(enough), doubt), surest, drift, exhausted)
    end subroutine cut_to_least
  end subroutine choose_later

end module bw_later_count
