module bw_case_drift
  !! What rounding comes to by the end of a record: that of the sums, of the first mode's phase, and of frequencies, whose phases drift
  !! as time goes on. Roots of beams without tension get as many digits as a record asks for; those of beams with tension have the
  !! digits of binary64.
  use bw_case_modes, only: largest_phase_error
  use bw_case_result, only: case_motion
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_mode_set, only: mode_set, values_at
  use bw_reach, only: amplitude_of, stretch_type
  use bw_response, only: response_type
  use bw_scene, only: scene_type, unit_velocity
  use bw_segment_samples, only: samples_of_segment, stretch_of
  use bw_time_grid, only: time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: drift_errors, drift_of_state, rounding_errors

  type :: moving_type
    !! The state that the first modes in memory start from, and when they are seen; of no modes where nobody sees them.
    real(dp), allocatable :: q(:), rate(:)
    type(stretch_type) :: stretch
  end type moving_type

contains

  function moving_in(scene, motion, i, grid, most) result(moving)
    !! In a segment; none where no sample shows it.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: i
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: most                 !! modes that are wanted
    type(moving_type) :: moving
    integer :: n, samples(2)
    samples = samples_of_segment(motion, i, grid)
    if (i == 1) samples(1) = 2
    allocate (moving%q(0), moving%rate(0))
    if (samples(1) > samples(2) .and. .not. (i == 1 .and. scene%response%samples == 1)) return
    associate (segment => motion%timeline%segments(i), &
               modes => motion%modes%configuration(motion%timeline%segments(i)%configuration)%set)
      moving%stretch = stretch_of(grid, samples(1), samples(2), segment%start)
      n = min(most, modes%count)
      if (allocated(segment%rate)) then
        n = min(most, segment%count)
        moving%rate = segment%rate(:n)
      else
        moving%rate = segment%force*modes%struck(:n)/modes%modal_mass(:n)
      end if
      moving%q = 0.0_dp*moving%rate
      if (allocated(segment%q)) moving%q = segment%q(:n)
    end associate
  end function moving_in

  function drift_errors(scene, motion, quantity, velocity) result(errors)
    !! What the rounding of β² moves the points by at the end of the record, m or m/s: the largest of all segments, (points).
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: quantity             !! deflections or curvatures
    logical, intent(in) :: velocity             !! of the velocity, else of the displacement
    real(dp) :: errors(size(scene%response%points))
    type(moving_type) :: moving
    type(time_grid) :: grid
    integer :: i
    errors = 0.0_dp
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    do i = 1, size(motion%timeline%segments)
      associate (modes => motion%modes%configuration(motion%timeline%segments(i)%configuration)%set)
        if (.not. allocated(modes%square_rounding)) cycle
        moving = moving_in(scene, motion, i, grid, modes%count)
        errors = max(errors, drift_of_state(modes, quantity, scene%response%points, moving%q, moving%rate, moving%stretch, grid, &
                                            velocity))
      end associate
    end do
    errors = errors*abs(unit_velocity(scene))
    if (.not. velocity) errors = errors*motion%units%time%hi
  end function drift_errors

  pure function drift_of_state(modes, quantity, points, q, rate, stretch, grid, velocity) result(drift)
    !! The same of modes that start from a state, V l²/h or V: a sum over those whose roots have no more digits than those of binary64;
    !! of others 0. A phase that is lost altogether moves a point by twice the amplitude.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: quantity             !! deflections or curvatures
    real(dp), intent(in) :: points(:)
    real(dp), intent(in) :: q(:), rate(:)       !! of the first modes
    type(stretch_type), intent(in) :: stretch
    type(time_grid), intent(in) :: grid         !! of the record
    logical, intent(in) :: velocity
    real(dp) :: drift(size(points)), swing(size(q)), c
    integer :: k
    drift = 0.0_dp
    if (.not. allocated(modes%square_rounding) .or. size(q) == 0) return
    c = 0.0_dp
    do k = 1, size(q)
      if (allocated(modes%damping)) c = modes%damping(k)
      swing(k) = min(2.0_dp, phase_drift(modes, k, modes%square_rounding(k), grid)) &
        *amplitude_of(modes%beta_squared(k), c, q(k), rate(k), stretch, velocity)
    end do
    drift = matmul(swing, abs(values_at(modes, quantity, 1, size(q), points)))
  end function drift_of_state

  function rounding_errors(scene, motion, response, velocity) result(errors)
    !! What the sum of the modes is off by, and the phase of the first mode, whose motion is most of the whole, m or m/s,
    !! (points). The samples may all be near the zeros of that motion: it counts as far as it swings between them.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    logical, intent(in) :: velocity             !! of the velocity, else of the displacement
    real(dp) :: errors(size(scene%response%points))
    type(moving_type) :: moving
    type(time_grid) :: grid
    real(dp) :: c, peak, phase, unit
    integer :: i
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    unit = abs(unit_velocity(scene))
    if (velocity) then
      peak = largest_magnitude(response%velocity(:response%finite_samples, :))
    else
      peak = largest_magnitude(response%displacement(:response%finite_samples, :))
      unit = unit*motion%units%time%hi
    end if
    errors = 0.0_dp
    phase = 0.0_dp
    do i = 1, size(motion%timeline%segments)
      moving = moving_in(scene, motion, i, grid, 1)
      if (size(moving%q) == 0) cycle
      associate (modes => motion%modes%configuration(motion%timeline%segments(i)%configuration)%set)
        phase = max(phase, phase_error(scene, modes, grid))
        c = 0.0_dp
        if (allocated(modes%damping)) c = modes%damping(1)
        errors = max(errors, amplitude_of(modes%beta_squared(1), c, moving%q(1), moving%rate(1), moving%stretch, velocity) &
          *abs(reshape(values_at(modes, response%sampling%quantity, 1, 1, scene%response%points), [size(errors)])))
      end associate
    end do
    errors = (response%sum_error + phase)*max(peak, errors*unit)
  end function rounding_errors

  pure real(dp) function phase_error(scene, modes, grid) result(error)
    !! Of the first mode: what the rounding of its root comes to at the end of the record, in its phase or as a part of its growth. A
    !! root that binary64 does not carry so far has more digits; of those that never have more, `drift_errors` tells.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: modes
    type(time_grid), intent(in) :: grid
    real(dp), parameter :: least_turning = 0.1_dp   ! β/α²; where it is less roots have more digits too (bw_refined_root)
    error = 0.0_dp
    if (allocated(modes%square_rounding)) return
    error = phase_drift(modes, 1, 4.0_dp*epsilon(error)*modes%alpha(1)**4, grid)
    error = min(error, largest_phase_error(scene)/least_turning)
  end function phase_error

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
