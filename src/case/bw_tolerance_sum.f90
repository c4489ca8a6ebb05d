module bw_tolerance_sum
  !! A history within a tolerance: how many modes of the continuum it takes, and their sum.
  use bw_kinds, only: dp
  use bw_case_modes, only: extend_modes
  use bw_case_result, only: case_result, add_note, case_not_converged
  use bw_coherence, only: stretch_type
  use bw_course_histories, only: add_course, last_sample, take
  use bw_double_double, only: operator(*)
  use bw_error, only: error_type, fail, status_bad_input
  use bw_mode_choice, only: first_modes, modes_for, most_modes, most_released
  use bw_mode_set, only: mode_set, mode_source
  use bw_input_values, only: position_of
  use bw_monitor, only: monitor_type, part_monitor
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_released_motion, only: peak_released, plan_released, release_continuum
  use bw_response, only: finish_histories, response_type, start_histories, sum_tolerance
  use bw_streamed_modes, only: add_modes_in_parts, add_modes_of_source, rest_type
  use bw_modes_par, only: coarsest_tolerance
  use bw_scene, only: scene_type
  use bw_text, only: shortest, text_of
  use bw_time_grid, only: time_grid, time_grid_of
  use bw_tip_rest, only: find_tip_rest
  use bw_truncation, only: tail_error
  implicit none (type, external)
  private
  public :: sum_to_tolerance, plan_count, force_of

  integer, parameter :: previewed = 1000     !! samples that show the peak well enough to plan with it
  integer, parameter :: most_previewed = 2**16 !! modes that are summed to see it
  real(dp), parameter :: sum_share = 0.01_dp !! of a tolerance that the sum of the modes may take

contains

  subroutine sum_to_tolerance(scene, source, alone, grid, monitor, sum, result)
    !! As many of the continuum's modes as the tolerance takes. Where 10⁷ do not reach it the histories are fill.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(inout) :: source  !! modes of beam and mass
    class(mode_source), intent(inout) :: alone   !! modes of the beam alone
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    type(nonuniform_sum), intent(inout) :: sum   !! kept from motion to motion
    type(case_result), intent(inout) :: result
    real(dp) :: reached
    type(rest_type) :: rest
    call choose_count(scene, source, alone, grid, monitor, result, reached, rest)
    if (monitor%stop_requested()) return
    if (scene%response%velocity) rest = rest_type()   ! velocities after the first modes are no smaller than theirs
    call start_histories(grid, size(scene%response%points), scene%response%velocity, result%response)
    if (reached > scene%modes%tolerance) then
      result%status = case_not_converged
      result%response%finite_samples = 0
      call add_note(result, 'tolerance: '//out_of_reach(scene, source, reached)//'; the histories are fill')
      call finish_histories(result%units%time%hi, result%response)
    else if (allocated(result%courses)) then
      call sum_around_release(scene, source, alone, grid, rest, monitor, sum, result)
    else
      call sum_in_parts(scene, source, grid, rest, monitor, sum, result)
      call finish_histories(result%units%time%hi, result%response)
    end if
  end subroutine sum_to_tolerance

  subroutine sum_around_release(scene, source, alone, grid, rest, monitor, sum, result)
    !! The captured motion up to the last sample before the release, then that of the beam alone.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source, alone
    type(time_grid), intent(in) :: grid
    type(rest_type), intent(in) :: rest          !! as that of `sum_in_parts`
    class(monitor_type), intent(inout), target :: monitor
    type(nonuniform_sum), intent(inout) :: sum
    type(case_result), intent(inout) :: result   !! its histories are started
    class(mode_set), allocatable :: free
    type(response_type) :: whole
    type(part_monitor) :: part
    type(time_grid) :: early
    early = captured_part(grid, result)
    whole = result%response
    part = part_monitor(monitor, 0.0_dp, real(early%samples, dp)/grid%samples)
    call start_histories(early, size(scene%response%points), scene%response%velocity, result%response)
    call sum_in_parts(scene, source, early, rest, part, sum, result)
    call finish_histories(result%units%time%hi, result%response)
    if (monitor%stop_requested()) return
    call take(result%response, 1, early%samples, whole)
    whole%sum_error = max(sum_tolerance, result%response%sum_error)
    whole%mode_seconds = result%response%mode_seconds
    whole%transformed = result%response%transformed
    result%response = whole
    call release_continuum(scene, source, alone, force_of(scene), grid, monitor, result, free)
    if (monitor%stop_requested()) return
    call add_course(result%courses(2), free, grid%samples, scene%response%points, grid, monitor, result)
    call finish_histories(1.0_dp, result%response)
  end subroutine sum_around_release

  pure type(time_grid) function captured_part(grid, result) result(early)
    !! Samples before a release; all where there is none.
    type(time_grid), intent(in) :: grid
    type(case_result), intent(in) :: result
    early = grid
    if (allocated(result%courses)) early%samples = last_sample(result%courses, 1, grid)
  end function captured_part

  subroutine sum_in_parts(scene, source, grid, rest, monitor, sum, result)
    !! As many modes as were chosen.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source
    type(time_grid), intent(in) :: grid
    type(rest_type), intent(in) :: rest         !! what the modes after the first add
    class(monitor_type), intent(inout) :: monitor
    type(nonuniform_sum), intent(inout) :: sum   !! kept from motion to motion
    type(case_result), intent(inout) :: result
    associate (unit_time => result%units%time%hi)
      call add_modes_in_parts(source, force_of(scene)*(result%approach_velocity*unit_time), first_modes, result%mode_count, &
                              rest, scene%response%points, grid, unit_time, [sum_tolerance, sum_share*scene%modes%tolerance], &
                              monitor, result%response, sum)
    end associate
  end subroutine sum_in_parts

  subroutine choose_count(scene, source, alone, grid, monitor, result, reached, rest)
    !! `mode_count` from the tolerance and the peak of the first modes, less what the others may take off it.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(inout) :: source, alone
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout), target :: monitor    !! nothing is chosen where it asks to stop
    type(case_result), intent(inout) :: result
    real(dp), intent(out) :: reached            !! the estimated error over the peak
    type(rest_type), intent(out) :: rest        !! what the modes after the first are estimated to add
    type(time_grid) :: early
    real(dp) :: peak, force, longest, tail, missing
    integer :: few
    logical :: extended
    early = captured_part(grid, result)
    longest = early%samples*early%step%hi
    result%mode_count = first_modes
    result%released_count = first_modes
    reached = 0.0_dp
    if (allocated(result%courses)) allocate (result%tip_rest)    ! of what stands still nothing is missing
    force = force_of(scene)
    if (result%approach_velocity == 0.0_dp .or. force == 0.0_dp) return
    if (grid%samples == 1) then                  ! nothing has moved yet, but a release takes energy along
      if (allocated(result%courses)) call find_tip_rest(source, force, first_modes, result%courses(2)%start, &
                                                        scene%modes%tolerance, result%tip_rest, monitor=monitor)
      return
    end if
    associate (points => scene%response%points)
      tail = largest_tail(first_modes)
      missing = tail
      few = first_modes
      do
        call preview(scene, source, few, early, result, monitor, peak)
        if (monitor%stop_requested()) return
        if (missing <= 0.5_dp*peak .or. 4*few > min(most_previewed, source%highest)) exit
        few = 4*few                             ! what is missing is all that is seen: nothing has moved far yet
        missing = largest_tail(few)
      end do
      peak = max(0.5_dp*peak, peak - missing)
      if (allocated(result%courses)) then
        peak = max(peak, peak_released(peak, source, alone, force, points, grid, previewed, result, monitor))
        if (monitor%stop_requested()) return
      end if
      if (peak == 0.0_dp) return
      rest%share = min(1.0_dp, max(epsilon(1.0_dp), tail/peak))
      if (.not. allocated(source%damping)) rest%tail = tail/force     ! damped modes are summed without the transform
      do
        call plan_all(scene%modes%tolerance*peak, source, alone, force, points, grid, early, monitor, result, reached)
        if (reached <= scene%modes%tolerance*peak) exit
        call extend_modes(scene, result%units, source, alone, monitor, extended)
        if (.not. extended) exit
      end do
    end associate
    reached = reached/peak
  contains
    real(dp) function largest_tail(count)
      integer, intent(in) :: count
      largest_tail = maxval(tail_error(count, source, force, scene%response%points, longest, early%samples, .false.))
    end function largest_tail
  end subroutine choose_count

  subroutine plan_all(bound, source, alone, force, points, grid, early, monitor, result, reached)
    !! Counts for the captured motion, and for that after a release.
    real(dp), intent(in) :: bound               !! of the displacement, V l²/h
    class(mode_source), intent(in) :: source, alone
    real(dp), intent(in) :: force, points(:)
    type(time_grid), intent(in) :: grid, early
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(inout) :: result
    real(dp), intent(out) :: reached            !! estimated error, V l²/h
    real(dp) :: after
    call modes_for(bound, first_modes, source, force, points, &
                   stretch_type(early%step%hi, early%samples*early%step%hi, early%step%hi), result%mode_count, reached)
    if (.not. allocated(result%courses)) return
    call plan_released(bound, first_modes, source, alone, force, points, grid, result, after, monitor)
    reached = max(reached, after)
  end subroutine plan_all

  subroutine preview(scene, source, few, grid, result, monitor, peak)
    !! The largest displacement of the first modes, in l²/h times the approach velocity, at some of the samples; at all
    !! of them where a mode grows, whose peak is at the end.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source
    integer, intent(in) :: few                  !! how many
    type(time_grid), intent(in) :: grid
    type(case_result), intent(in) :: result
    class(monitor_type), intent(inout), target :: monitor    !! nothing is seen where it asks to stop
    real(dp), intent(out) :: peak
    type(response_type) :: response
    type(part_monitor) :: part
    type(time_grid) :: coarse
    integer :: stride
    stride = (grid%samples - 1)/previewed + 1
    if (any(result%modes%beta_squared%hi <= 0.0_dp)) stride = 1
    coarse = time_grid((grid%samples - 1)/stride + 1, grid%step*real(stride, dp))
    part = part_monitor(monitor, share=0.0_dp)
    call start_histories(coarse, size(scene%response%points), .false., response)
    call add_modes_of_source(source, force_of(scene), 1, few, scene%response%points, coarse, &
                             result%units%time%hi, sum_tolerance, part, response)
    peak = maxval(abs(response%displacement(:response%finite_samples, :)))
  end subroutine preview

  pure function out_of_reach(scene, source, reached) result(text)
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: reached             !! relative error of the most modes
    character(:), allocatable :: text
    text = shortest(scene%modes%tolerance, 6)//' cannot be reached with '//text_of(min(most_modes, source%highest))//' modes'
    if (allocated(scene%release)) text = text//' before the release and '//text_of(min(most_released, source%highest))//' after it'
    if (1.05_dp*reached <= coarsest_tolerance) then
      text = text//'; accepted: '//shortest(1.05_dp*reached, 2)//' or more'
    else
      text = text//', nor can any other: the points move too little; accepted: other points or a longer duration'
    end if
  end function out_of_reach

  subroutine plan_count(scene, source, alone, monitor, result, error, estimate)
    !! How many modes a tolerance takes, from a preview of the history: before a run, and for `beamwave check`.
    !! **Errors**: `status_bad_input` where more modes than there may be would be needed.
    type(scene_type), intent(in) :: scene       !! without sweeps, with a tolerance
    class(mode_source), intent(inout) :: source    !! modes of beam and mass
    class(mode_source), intent(inout) :: alone     !! modes of the beam alone
    class(monitor_type), intent(inout) :: monitor  !! nothing is planned where it asks to stop
    type(case_result), intent(inout) :: result
    type(error_type), allocatable, intent(out) :: error
    real(dp), intent(out), optional :: estimate    !! of the error over the peak
    real(dp) :: reached
    type(rest_type) :: rest
    character(:), allocatable :: place
    integer :: line
    call choose_count(scene, source, alone, &
                      time_grid_of(scene%response%duration, scene%response%samples, result%units%time), monitor, result, &
                      reached, rest)
    if (present(estimate)) estimate = reached
    if (monitor%stop_requested()) return
    if (reached <= scene%modes%tolerance) return
    line = scene%groups(position_of(scene%groups, 'modes'))%line_of('tolerance')
    place = scene%file
    if (line > 0) place = place//':'//text_of(line)         ! 0: it is the default of an absent group
    call fail(error, status_bad_input, place//': modes%tolerance: '//out_of_reach(scene, source, reached))
  end subroutine plan_count

  pure real(dp) function force_of(scene)
    !! Modal velocities of the continuum are this times Φ_k(1)/M_k and the approach velocity.
    type(scene_type), intent(in) :: scene
    force_of = (1.0_dp + scene%impact%restitution)*scene%impact%mass_ratio
  end function force_of

end module bw_tolerance_sum
