module bw_changing_errors
  !! Errors of histories of a beam that changes in time: differences between runs with fewer modes, extrapolated, and
  !! the effect of errors in the initial states of segments (bw_unprojected).
  use bw_case_moments, only: scale_of_moments
  use bw_case_result, only: case_motion, history_errors
  use bw_contact_errors, only: largest_distance
  use bw_double_double, only: dd, to_dd
  use bw_kinds, only: dp
  use bw_lack_error, only: find_lack, lack_error
  use bw_missing, only: is_missing
  use bw_mode_set, only: curvatures, deflections, mode_set
  use bw_mode_survey, only: mode_survey
  use bw_reach, only: amplitude_of, stretch_type
  use bw_response, only: response_type
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment, only: lack_type
  use bw_segment_samples, only: stretch_of
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  use bw_truncation_error, only: spread_of_samples
  implicit none (type, external)
  private
  public :: add_difference, add_rounding_of_turn, error_of_state, extrapolate, join_state_errors, leave_out_rounding
  public :: rounding_of_turn

contains

  pure subroutine extrapolate(early, before, error)
    !! Extrapolate differences between runs to the truncation error: from an eighth to a quarter of the modes, from
    !! there to a half, and to all. Twice the remainder of a geometric series, 2ρ/(1 − ρ) times the last difference,
    !! where ρ is the larger of the two ratios, and the last difference counts as at least ρ times the one before.
    real(dp), intent(in) :: early(:), before(:)
    real(dp), intent(inout) :: error(:)
    real(dp), parameter :: least = 0.1_dp, most = 0.7_dp       ! tuned
    real(dp) :: ratio
    if (maxval(before) <= 0.0_dp) return
    ratio = maxval(error)/maxval(before)
    if (maxval(early) > 0.0_dp) ratio = max(ratio, maxval(before)/maxval(early))
    ratio = min(most, max(least, ratio))
    error = max(error, ratio*before)*(2.0_dp*ratio/(1.0_dp - ratio))
  end subroutine extrapolate

  pure subroutine add_difference(response, other, errors)
    !! Raise errors to the largest difference of two histories at each point.
    type(response_type), intent(in) :: response, other
    type(history_errors), intent(inout) :: errors
    call add(response%displacement, other%displacement, errors%displacement)
    if (allocated(response%velocity)) call add(response%velocity, other%velocity, errors%velocity)
    if (allocated(response%bending_moment)) call add(response%bending_moment, other%bending_moment, errors%bending_moment)
  contains
    pure subroutine add(history, beside, error)
      real(dp), intent(in) :: history(:, :), beside(:, :)
      real(dp), allocatable, intent(inout) :: error(:)
      if (.not. allocated(error)) error = 0.0_dp*history(1, :)
      where (is_missing(error) .or. is_missing(history(1, :))) error = 0.0_dp
      error = max(error, largest_distance(history, beside))
    end subroutine add
  end subroutine add_difference

  subroutine join_state_errors(scene, motion, errors)
    !! Raise errors to those that errors of the initial states cause, summed over all segments, as if each lasted to the
    !! end of the record. Runs with fewer modes include them, so the larger of both counts.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(history_errors), intent(inout) :: errors
    real(dp), dimension(size(scene%response%points)) :: deflection, rate, curvature
    type(lack_error) :: found
    type(time_grid) :: grid
    real(dp) :: metres, speed
    integer :: i
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    deflection = 0.0_dp
    rate = 0.0_dp
    curvature = 0.0_dp
    do i = 1, size(motion%timeline%segments)
      associate (segment => motion%timeline%segments(i), points => scene%response%points, &
                 modes => motion%modes%configuration(motion%timeline%segments(i)%configuration)%set)
        if (.not. allocated(segment%error)) cycle    ! a contact starts or ends
        found = error_of_state(modes, segment%count, segment%start, segment%error, deflections, points, grid)
        deflection = deflection + found%displacement
        rate = rate + found%rate
        if (.not. allocated(errors%bending_moment)) cycle
        found = error_of_state(modes, segment%count, segment%start, segment%error, curvatures, points, grid)
        curvature = curvature + found%rate
      end associate
    end do
    speed = abs(unit_velocity(scene))
    metres = speed*motion%units%time%hi
    errors%displacement = max(errors%displacement, metres*deflection)
    if (allocated(errors%velocity)) errors%velocity = max(errors%velocity, speed*rate)
    if (allocated(errors%bending_moment)) &
      errors%bending_moment = max(errors%bending_moment, scale_of_moments(scene)*metres*curvature)
  end subroutine join_state_errors

  subroutine add_rounding_of_turn(rounding, errors)
    !! Add the rounding of the hub's rotation to the errors of displacements and velocities.
    real(dp), intent(in) :: rounding(:, :)       !! from `rounding_of_turn`
    type(history_errors), intent(inout) :: errors
    errors%displacement = errors%displacement + rounding(:, 1)
    if (allocated(errors%velocity)) errors%velocity = errors%velocity + rounding(:, 2)
  end subroutine add_rounding_of_turn

  subroutine leave_out_rounding(rounding, errors)
    !! Drop errors within rounding. A beam that rotates with its hub without bending has no others.
    real(dp), intent(in) :: rounding(:, :)       !! from `rounding_of_turn`
    type(history_errors), intent(inout) :: errors
    where (errors%displacement <= rounding(:, 1)) errors%displacement = 0.0_dp
    if (.not. allocated(errors%velocity)) return
    where (errors%velocity <= rounding(:, 2)) errors%velocity = 0.0_dp
  end subroutine leave_out_rounding

  function rounding_of_turn(scene, motion) result(rounding)
    !! Bound the rounding of displacements, m, and velocities, m/s, that are differences from a line rotating with the
    !! hub: it is that of the rotation, (points, 2).
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    real(dp) :: rounding(size(scene%response%points), 2)
    real(dp), parameter :: unit = 16.0_dp*epsilon(1.0_dp)
    type(stretch_type) :: stretch
    type(time_grid) :: grid
    real(dp) :: swing(2)
    integer :: i
    rounding = 0.0_dp
    if (.not. allocated(scene%hub)) return
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    swing = 0.0_dp
    do i = 1, size(motion%timeline%segments)
      associate (segment => motion%timeline%segments(i), &
                 turning => motion%modes%configuration(motion%timeline%segments(i)%configuration)%set%hub_turns())
        stretch = stretch_of(grid, first_sample(segment%start, grid), grid%samples, segment%start)
        swing = max(swing, abs(turning(1))*[ &
          amplitude_of(to_dd(0.0_dp), 0.0_dp, segment%q(1), segment%rate(1), stretch, .false.)*motion%units%time%hi, &
          amplitude_of(to_dd(0.0_dp), 0.0_dp, segment%q(1), segment%rate(1), stretch, .true.)])
      end associate
    end do
    associate (lever => scene%hub%radius/motion%units%length + scene%response%points)
      rounding(:, 1) = unit*abs(unit_velocity(scene))*swing(1)*lever
      rounding(:, 2) = unit*abs(unit_velocity(scene))*swing(2)*lever
    end associate
  end function rounding_of_turn

  type(lack_error) function error_of_state(modes, count, start, doubt, quantity, points, grid) result(error)
    !! Return the errors of histories, from a time to the end of the record, due to errors of the state then, in the
    !! units of `doubt`.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: count                   !! modes summed
    type(dd), intent(in) :: start                  !! l²/h
    real(dp), intent(in) :: doubt(:, :)            !! errors of modal displacements and velocities then, (modes, 2)
    integer, intent(in) :: quantity                !! deflections or curvatures
    real(dp), intent(in) :: points(:)              !! ξ
    type(time_grid), intent(in) :: grid            !! of the record
    type(lack_type) :: lack
    type(mode_survey) :: survey
    real(dp), dimension(size(points)) :: part, times
    integer :: first, samples
    first = first_sample(start, grid)
    samples = grid%samples - first + 1
    part = 0.0_dp
    times = 0.5_dp*spread_of_samples(samples)      ! `doubt` is twice a root mean square
    lack%bounded = count
    lack%q_doubt = doubt(:, 1)
    lack%rate_doubt = doubt(:, 2)
    call survey%start(quantity, points, stretch_of(grid, first, grid%samples, start))
    call find_lack(lack, modes, count, survey, samples, part, times, error)
  end function error_of_state

end module bw_changing_errors
