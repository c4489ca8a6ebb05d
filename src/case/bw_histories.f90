module bw_histories
  !! The histories of a case: from the modes that a scene counts, or from as many as its tolerance takes.
  use bw_kinds, only: dp
  use bw_case_result, only: case_result, add_note, case_diverged, case_done, case_not_converged
  use bw_contact_errors, only: estimate_contact_errors
  use bw_course_histories, only: last_sample, sum_courses
  use bw_coherence, only: stretch_type
  use bw_continuum, only: continuum_velocity
  use bw_magnitude, only: largest_magnitude
  use bw_mode_set, only: first_numbers, mode_set, mode_source
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_nonuniform_sum, only: nonuniform_sum
  use bw_response, only: finish_histories, free_motion, start_histories, sum_tolerance
  use bw_record_stretch, only: kept_phase
  use bw_scene, only: scene_type
  use bw_release_error, only: amplitude_of, release_error
  use bw_released_motion, only: released_error, stretch_after
  use bw_text, only: shortest, text_of
  use bw_time_grid, only: time_grid, time_grid_of
  use bw_tolerance_sum, only: force_of, sum_to_tolerance
  use bw_truncation, only: tail_error, truncation_error, with_start
  implicit none (type, external)
  private
  public :: respond

contains

  subroutine respond(scene, free, loaded, source, alone, monitor, sum, result, whole)
    !! Histories from the state after each event to the next, and how far they may be from those of infinitely many modes.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in), optional :: free, loaded    !! modes of the beam alone, and of beam and mass
    class(mode_source), intent(inout), optional :: source    !! modes of beam and mass; absent: the mass is not captured
    class(mode_source), intent(inout) :: alone               !! modes of the beam alone
    class(monitor_type), intent(inout) :: monitor
    type(nonuniform_sum), intent(inout) :: sum               !! any, also one that another case has used
    type(case_result), intent(inout) :: result
    logical, intent(out) :: whole                            !! false where the monitor asked to stop before the end
    type(time_grid) :: grid
    whole = .true.
    if (.not. allocated(scene%response)) return
    grid = time_grid_of(scene%response%duration, scene%response%samples, result%units%time)
    allocate (result%response)
    if (result%status /= case_done) then
      call start_histories(grid, size(scene%response%points), scene%response%velocity, result%response)
      result%response%finite_samples = 0
      call finish_histories(1.0_dp, result%response)
    else if (by_tolerance(scene%modes)) then
      call sum_to_tolerance(scene, source, alone, grid, monitor, sum, result)
    else if (allocated(result%courses)) then
      call start_histories(grid, size(scene%response%points), scene%response%velocity, result%response)
      call sum_courses(free, loaded, scene%response%points, grid, monitor, result)
      if (allocated(scene%release)) result%response%sum_error = sum_tolerance
    else
      call free_motion(result%modes, result%modal_velocity*result%approach_velocity, scene%response%points, grid, &
                       result%units%time%hi, scene%response%velocity, monitor, result%response, sum)
    end if
    whole = .not. monitor%stop_requested()
    if (.not. whole) return
    if (result%response%failing_mode > 0) then
      call note_overflow(scene, result)
    else if (allocated(scene%recontact)) then
      call estimate_contact_errors(scene, free, grid, result)
    else if (present(source) .and. result%status == case_done) then
      call estimate_errors(scene, source, alone, grid, monitor, result)
      whole = .not. monitor%stop_requested()
      if (.not. whole) return
      if (by_tolerance(scene%modes) .and. grid%samples > 1) call note_missed_tolerance(scene, alone, grid, result)
    end if
  end subroutine respond

  subroutine note_missed_tolerance(scene, alone, grid, result)
    !! The number of modes was planned for a larger motion than there is.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: alone
    type(time_grid), intent(in) :: grid
    type(case_result), intent(inout) :: result
    real(dp), parameter :: slack = 1.5_dp        ! of the peak that was planned with
    real(dp) :: error, peak
    error = maxval(result%response%displacement_error)
    peak = largest_magnitude(result%response%displacement)
    if (error <= slack*scene%modes%tolerance*peak + maxval(rounding_errors(scene, alone, grid, result, .false.))) return
    result%status = case_not_converged
    call add_note(result, 'tolerance: '//shortest(scene%modes%tolerance, 6)//' of the peak is missed: the displacement is '// &
                  shortest(peak, 3)//' m at most, and its error is estimated at '//shortest(error, 2)//' m')
  end subroutine note_missed_tolerance

  subroutine note_overflow(scene, result)
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    result%status = case_diverged
    call add_note(result, 'overflow: mode '//text_of(result%response%failing_mode)//' overflows at t = '// &
      shortest(result%response%finite_samples*(scene%response%duration/scene%response%samples), 6)// &
      ' s; the histories hold fill from there on')
  end subroutine note_overflow

  subroutine estimate_errors(scene, source, alone, grid, monitor, result)
    !! `displacement_error` and `velocity_error`, SI.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source, alone
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout), target :: monitor
    type(case_result), intent(inout) :: result
    type(part_monitor) :: part
    real(dp) :: speed
    part = part_monitor(monitor, 1.0_dp, 0.0_dp)
    speed = abs(result%approach_velocity)
    result%response%displacement_error = errors(.false.)*(speed*result%units%time%hi) &
      + rounding_errors(scene, alone, grid, result, .false.)
    if (scene%response%velocity) result%response%velocity_error = &
      with_start(errors(.true.)*speed, result%response%velocity(1, :), scene%response%points, &
                 result%approach_velocity*(1.0_dp + scene%impact%restitution)) &
      + rounding_errors(scene, alone, grid, result, .true.)
  contains
    function errors(velocity) result(values)
      logical, intent(in) :: velocity
      real(dp), allocatable :: values(:)
      real(dp) :: force, longest
      integer :: samples
      samples = grid%samples
      if (allocated(result%courses)) samples = last_sample(result%courses, 1, grid)
      longest = samples*grid%step%hi
      associate (gamma => scene%impact%mass_ratio, points => scene%response%points)
        force = force_of(scene)
        if (by_tolerance(scene%modes)) then
          values = tail_error(result%mode_count, source, force, points, longest, samples, velocity)
        else
          values = truncation_error(result%modes, result%modal_velocity &
                                    - continuum_velocity(result%modes, gamma, scene%impact%restitution), &
                                    source, force, points, longest, samples, velocity)
        end if
        if (.not. allocated(result%courses)) return
        if (allocated(result%tip_rest)) then
          values = max(values, released_error(source, alone, force, points, grid, result, velocity))
        else if (.not. by_tolerance(scene%modes)) then
          values = max(values, after_release(scene, source, alone, force, grid, result, velocity, part))
        end if
      end associate
    end function errors
  end subroutine estimate_errors

  function rounding_errors(scene, alone, grid, result, velocity) result(errors)
    !! What the sum of the modes is off by, and the phase of the first mode, whose motion is most of the whole, m or m/s,
    !! (points). The samples may all be near the zeros of that motion: it counts as far as it swings between them.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: alone
    type(time_grid), intent(in) :: grid
    type(case_result), intent(in) :: result
    logical, intent(in) :: velocity
    real(dp) :: errors(size(scene%response%points))
    class(mode_set), allocatable :: free
    real(dp) :: peak, phase, unit
    integer :: captured
    captured = grid%samples
    if (allocated(result%courses)) captured = last_sample(result%courses, 1, grid)
    unit = abs(result%approach_velocity)
    if (velocity) then
      peak = largest_magnitude(result%response%velocity)
    else
      peak = largest_magnitude(result%response%displacement)
      unit = unit*result%units%time%hi
    end if
    associate (points => scene%response%points, step => grid%step%hi)
      phase = phase_error(scene, result%modes, grid)
      errors = swing_of_first(result%modes, 0.0_dp, result%modal_velocity(1), points, &
                              stretch_type(step, captured*step, step), velocity)
      if (allocated(result%courses)) then
        call alone%find(first_numbers(1), free)
        phase = max(phase, phase_error(scene, free, grid))
        errors = max(errors, swing_of_first(free, result%courses(2)%q(1), result%courses(2)%rate(1), points, &
                                            stretch_after(grid, result), velocity))
      end if
    end associate
    errors = (result%response%sum_error + phase)*max(peak, errors*unit)
  end function rounding_errors

  function swing_of_first(modes, q, rate, points, stretch, velocity) result(swing)
    !! How far the first mode moves each point, or how fast, in V l²/h or V, (points).
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q, rate                 !! its state at the start of the motion
    real(dp), intent(in) :: points(:)
    type(stretch_type), intent(in) :: stretch       !! the record, in which it has decayed at the first sample
    logical, intent(in) :: velocity
    real(dp) :: swing(size(points)), c
    c = 0.0_dp
    if (allocated(modes%damping)) c = modes%damping(1)
    swing = amplitude_of(modes%beta_squared(1), c, q, rate, stretch, velocity)*abs(reshape(modes%some_shapes(1, 1, points), &
                                                                                           [size(points)]))
  end function swing_of_first

  pure real(dp) function phase_error(scene, modes, grid) result(error)
    !! Of the first mode, whose motion is most of the whole: what the rounding of its root comes to at the end of the record,
    !! in its phase or as a part of its growth. A root that binary64 does not carry so far has more digits.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: modes
    type(time_grid), intent(in) :: grid
    real(dp), parameter :: least_turning = 0.1_dp   ! β/α²; where it is less roots have more digits too (bw_refined_root)
    real(dp) :: longest, half
    longest = grid%samples*grid%step%hi
    if (allocated(modes%damping) .and. modes%beta_squared(1)%hi > 0.0_dp) then
      half = 0.5_dp*max(modes%damping(1), tiny(1.0_dp))       ! the motion falls as e^(−ct/2) while phases drift as t,
      longest = min(longest, max(grid%step%hi, 1.0_dp/half))  ! together the most at 2/c; its peak may be the first sample
      longest = longest*exp(-half*max(0.0_dp, longest - grid%step%hi))
    end if
    error = 2.0_dp*epsilon(error)*modes%alpha(1)**4*longest/max(sqrt(abs(modes%beta_squared(1)%hi)), 1.0_dp/longest)
    error = min(error, kept_phase(scene)/least_turning)
  end function phase_error

  function after_release(scene, source, alone, force, grid, result, velocity, monitor) result(values)
    !! The same after the mass has left, (points).
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source, alone
    real(dp), intent(in) :: force
    type(time_grid), intent(in) :: grid
    type(case_result), intent(in) :: result
    logical, intent(in) :: velocity
    class(monitor_type), intent(inout) :: monitor
    real(dp), allocatable :: values(:)
    associate (course => result%courses(2))
      values = release_error(course%q, course%rate, source, alone, result%mode_count, force, course%start, &
                             scene%response%points, stretch_after(grid, result), velocity, monitor)
    end associate
  end function after_release

end module bw_histories
