module bw_case_drift
  !! What rounding of frequencies comes to by the end of a record: phases drift as time goes on. Roots of beams without tension get
  !! as many digits as a record asks for; those of beams with tension have the digits of binary64.
  use bw_case_plan, only: captured_samples, seen_after_release, shows_release
  use bw_case_result, only: case_motion
  use bw_coherence, only: observation_type, stretch_type
  use bw_kinds, only: dp
  use bw_mode_set, only: first_numbers, mode_set
  use bw_reach, only: amplitude_of
  use bw_scene, only: scene_type
  use bw_time_grid, only: time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: drift_errors, phase_drift

contains

  function drift_errors(scene, motion, velocity) result(errors)
    !! What the rounding of β² moves the points by at the end of the record, m or m/s, (points): a sum over all modes whose roots
    !! have no more digits than those of binary64, and 0 of others.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    logical, intent(in) :: velocity             !! of the velocity, else of the displacement
    real(dp) :: errors(size(scene%response%points))
    class(mode_set), allocatable :: free
    type(time_grid) :: grid
    integer :: captured
    errors = 0.0_dp
    if (.not. allocated(motion%modes%loaded%square_rounding)) return
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    captured = captured_samples(motion%plan, grid)
    associate (loaded => motion%modes%loaded, step => grid%step%hi, rate => motion%initial%modal_velocity)
      errors = drift_of(loaded, 0.0_dp*rate, rate, grid, &
                        observation_type(scene%response%points, stretch_type(step, captured*step, step), velocity))
    end associate
    if (shows_release(motion%plan, grid)) then
      associate (after => motion%later%segments(2))
        call motion%sources%free%find(first_numbers(size(after%q)), free)
        errors = max(errors, drift_of(free, after%q, after%rate, grid, &
                                      seen_after_release(scene, motion%plan%release%time, grid, velocity)))
      end associate
    end if
    errors = errors*abs(scene%impact%approach_velocity)
    if (.not. velocity) errors = errors*motion%units%time%hi
  end function drift_errors

  function drift_of(modes, q, rate, grid, seen) result(drift)
    !! The same of one motion in V l²/h or V. A phase that is lost altogether moves a point by twice the amplitude.
    class(mode_set), intent(in) :: modes            !! with `square_rounding`
    real(dp), intent(in) :: q(:), rate(:)           !! their state at the start of the motion
    type(time_grid), intent(in) :: grid
    type(observation_type), intent(in) :: seen
    real(dp) :: drift(size(seen%points)), swing(size(q)), c
    integer :: k
    c = 0.0_dp
    do k = 1, size(q)
      if (allocated(modes%damping)) c = modes%damping(k)
      swing(k) = min(2.0_dp, phase_drift(modes, k, modes%square_rounding(k), grid)) &
        *amplitude_of(modes%beta_squared(k), c, q(k), rate(k), seen%stretch, seen%velocity)
    end do
    drift = matmul(swing, abs(modes%some_shapes(1, size(q), seen%points)))
  end function drift_of

  pure real(dp) function phase_drift(modes, k, square_error, grid) result(drift)
    !! What an error of β² comes to at the end of the record, in the phase of mode k or as a part of its growth.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: k
    real(dp), intent(in) :: square_error
    type(time_grid), intent(in) :: grid
    real(dp) :: longest, half
    longest = grid%samples*grid%step%hi
    if (allocated(modes%damping) .and. modes%beta_squared(k)%hi > 0.0_dp) then
      half = 0.5_dp*max(modes%damping(k), tiny(1.0_dp))       ! the motion falls as e^(−ct/2) while phases drift as t,
      longest = min(longest, max(grid%step%hi, 1.0_dp/half))  ! together the most at 2/c; its peak may be the first sample
      longest = longest*exp(-half*max(0.0_dp, longest - grid%step%hi))
    end if
    drift = 0.5_dp*square_error*longest/max(sqrt(abs(modes%beta_squared(k)%hi)), 1.0_dp/longest)
  end function phase_drift

end module bw_case_drift
