module bw_case_drift
  !! Rounding errors at the end of a record: of the sums, of the phase of the first mode, and of frequencies, whose
  !! phase errors grow with time. Roots of beams without tension have the digits that a record needs; those of beams
  !! with tension have the digits of binary64.
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
    !! The initial state of the first modes in memory and the samples that show them; no modes if there are none.
    real(dp), allocatable :: q(:), rate(:)
    type(stretch_type) :: stretch
  end type moving_type

contains

  function moving_in(scene, motion, i, grid, most) result(moving)
    !! Return the initial state of modes in a segment; none if no sample shows it.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: i
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: most                 !! upper limit of modes
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
    !! Return the displacement or velocity errors at the end of the record due to rounding of β², m or m/s: the largest
    !! of all segments, (points).
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    integer, intent(in) :: quantity             !! deflections or curvatures
    logical, intent(in) :: velocity             !! errors of the velocity, else of the displacement
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
    !! Return the same for modes with a given initial state, V l²/h or V: a sum over modes with roots in binary64, else
    !! 0. A lost phase counts as twice the amplitude.
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
    !! Return the rounding errors of the modal sum and of the phase of the first, dominant mode, m or m/s, (points).
    !! Samples may lie near zeros of that mode, so its amplitude between them counts.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    logical, intent(in) :: velocity             !! errors of the velocity, else of the displacement
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
    !! Return the phase or growth error of the first mode at the end of the record, due to rounding of its root. Roots
    !! that need more digits than binary64 have them; those that never do are left to `drift_errors`.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: modes
    type(time_grid), intent(in) :: grid
    real(dp), parameter :: least_turning = 0.1_dp   ! β/α²; below it roots have more digits as well (bw_refined_root)
    error = 0.0_dp
    if (allocated(modes%square_rounding)) return
    error = phase_drift(modes, 1, 4.0_dp*epsilon(error)*modes%alpha(1)**4, grid)
    error = min(error, largest_phase_error(scene)/least_turning)
  end function phase_error

  pure real(dp) function phase_drift(modes, k, square_error, grid) result(drift)
    !! Return the error at the end of the record due to an error of β²: of the phase of mode k, or relative if it grows.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: k
    real(dp), intent(in) :: square_error
    type(time_grid), intent(in) :: grid
    real(dp) :: longest, half
    longest = grid%samples*grid%step%hi
    if (allocated(modes%damping) .and. modes%beta_squared(k)%hi > 0.0_dp) then
      half = 0.5_dp*max(modes%damping(k), tiny(1.0_dp))       ! amplitudes fall as e^(−ct/2), phase errors grow as t,
      longest = min(longest, max(grid%step%hi, 1.0_dp/half))  ! the product is largest at 2/c; its peak may be the first sample
      longest = longest*exp(-half*max(0.0_dp, longest - grid%step%hi))
    end if
    drift = 0.5_dp*square_error*longest/max(sqrt(abs(modes%beta_squared(k)%hi)), 1.0_dp/longest)
  end function phase_drift

end module bw_case_drift
