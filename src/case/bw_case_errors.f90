module bw_case_errors
  !! How far the histories of a case may be from the truth. Of a captured mass that is the motion of infinitely many modes:
  !! what the modes that are not summed add, after a release too. Of contacts it is the exact motion of the modes at hand: what
  !! the contacts have made of every error. Rounding of the sums and of phases is added to either.
  use bw_case_drift, only: drift_errors, phase_drift
  use bw_case_histories, only: last_sample
  use bw_case_modes, only: largest_phase_error
  use bw_case_notes, only: note_failure
  use bw_case_plan, only: captured_samples, force_of, seen_after_release, seen_while_captured, shows_release
  use bw_case_result, only: case_done, case_histories, case_motion, case_not_converged, history_errors
  use bw_coherence, only: observation_type, stretch_type
  use bw_double_double, only: dd, operator(*), operator(-)
  use bw_impact, only: continuum_velocity
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_mode_set, only: first_numbers, mode_set
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_note, only: remark
  use bw_reach, only: amplitude_of
  use bw_release_error, only: blow_reach, release_error, release_tail
  use bw_response, only: response_type
  use bw_scene, only: scene_type
  use bw_segment, only: beam_in_contact, growth_error, move, segment_type
  use bw_text, only: append, shortest
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  use bw_truncation, only: tail_error, truncation_error, with_start
  implicit none (type, external)
  private
  public :: drop_errors, estimate_errors
  public :: estimate_contacts, missing_motion, rounding_errors     ! of bending moments too

  type :: shapes_at_points
    !! Φ_k at the points of the histories, (modes, points).
    real(dp), allocatable :: free(:, :)          !! of the beam alone
    real(dp), allocatable :: in_contact(:, :)    !! of beam and mass in contact; unallocated where no contact lasts
  end type shapes_at_points

contains

  subroutine estimate_errors(scene, motion, histories, monitor, errors)
    !! There is none of a rebound without contacts, whose impulse depends on the number of modes, nor of histories that overflow.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(case_histories), intent(in) :: histories
    class(monitor_type), intent(inout), target :: monitor    !! the errors mean nothing where it asks to stop
    type(history_errors), intent(out) :: errors
    type(part_monitor) :: part
    errors%status = histories%status
    if (.not. allocated(histories%response) .or. histories%status /= case_done) return
    if (allocated(scene%recontact)) then
      call estimate_contacts(scene, motion, histories%response, errors)
      errors%status = motion%later%ending
    else if (allocated(scene%capture)) then
      part = part_monitor(monitor, 1.0_dp, 0.0_dp)
      call estimate_truncation(scene, motion, histories%response, part, errors)
      if (monitor%stop_requested()) return
      if (by_tolerance(scene%modes) .and. scene%response%samples > 1) then
        call note_missed_tolerance(scene, motion, histories%response, errors)
      end if
    end if
  end subroutine estimate_errors

  subroutine drop_errors(motion, errors)
    !! There are no estimates where a mode that they asked for was not found.
    type(case_motion), intent(in) :: motion
    type(history_errors), intent(inout) :: errors          !! all of a case
    associate (failure => motion%sources%failure())
      if (failure%first == 0 .or. errors%status /= case_done) return
      errors = history_errors(status=case_not_converged)
      call note_failure(failure, 'no errors of the histories are given', errors%notes)
    end associate
  end subroutine drop_errors

  subroutine note_missed_tolerance(scene, motion, response, errors)
    !! The number of modes was planned for a larger motion than there is. The tolerance is missed where it was asked for.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    type(history_errors), intent(inout) :: errors
    real(dp), parameter :: slack = 1.5_dp        ! of the peak that was planned with
    real(dp) :: error, peak
    character(:), allocatable :: text
    error = maxval(errors%displacement)
    peak = largest_magnitude(response%displacement)
    if (error <= slack*scene%modes%tolerance*peak + maxval(rounding_errors(scene, motion, response, .false.))) return
    text = 'tolerance: '//shortest(scene%modes%tolerance, 6)//' of the peak is missed: the displacement is '// &
      shortest(peak, 3)//' m at most, and its error is estimated at '//shortest(error, 2)//' m'//drifted()
    if (.not. scene%modes%asked) then
      call remark(errors%notes, text)
    else
      errors%status = case_not_converged
      call append(errors%notes, text)
    end if
  contains
    function drifted() result(words)
      !! Where most of it is that of phases.
      character(:), allocatable :: words
      real(dp) :: drift
      words = ''
      drift = maxval(drift_errors(scene, motion, .false.))
      if (drift > 0.5_dp*error) words = ', most of it what the rounding of frequencies under tension comes to by the end of so '// &
        'long a record; accepted: a tolerance of '//shortest(1.05_dp*error/peak, 2)//' or a shorter duration'
    end function drifted
  end subroutine note_missed_tolerance

  subroutine estimate_truncation(scene, motion, response, monitor, errors)
    !! What is missing of infinitely many modes, and rounding.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    class(monitor_type), intent(inout) :: monitor
    type(history_errors), intent(inout) :: errors
    real(dp) :: speed
    speed = abs(scene%impact%approach_velocity)
    errors%displacement = missing_motion(scene, motion, .false., monitor)*(speed*motion%units%time%hi) &
      + rounding_errors(scene, motion, response, .false.) + drift_errors(scene, motion, .false.)
    if (scene%response%velocity) errors%velocity = &
      with_start(missing_motion(scene, motion, .true., monitor)*speed, response%velocity(1, :), &
                 scene%response%points == scene%impact%position, &
                 scene%impact%approach_velocity*(1.0_dp + scene%impact%restitution)) &
      + rounding_errors(scene, motion, response, .true.) + drift_errors(scene, motion, .true.)
  end subroutine estimate_truncation

  function missing_motion(scene, motion, velocity, monitor) result(values)
    !! The largest displacement, V l²/h, or velocity, V, that the modes that are not summed may add, (points).
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    logical, intent(in) :: velocity             !! of the velocity, else of the displacement
    class(monitor_type), intent(inout) :: monitor
    real(dp), allocatable :: values(:)
    type(observation_type) :: seen
    type(time_grid) :: grid
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    seen = seen_while_captured(scene, motion%plan, grid, velocity)
    if (by_tolerance(scene%modes)) then
      values = tail_error(motion%plan%count, motion%sources%loaded, force_of(scene), seen)
    else
      associate (loaded => motion%modes%loaded, impact => scene%impact)
        values = truncation_error(loaded, motion%initial%modal_velocity &
                                  - continuum_velocity(loaded, impact%mass_ratio, impact%restitution), &
                                  motion%sources%loaded, force_of(scene), seen)
      end associate
    end if
    if (shows_release(motion%plan, grid)) values = max(values, missing_after_release(scene, motion, grid, velocity, monitor))
  end function missing_motion

  function missing_after_release(scene, motion, grid, velocity, monitor) result(values)
    !! The same of the samples after the release, (points).
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(time_grid), intent(in) :: grid
    logical, intent(in) :: velocity
    class(monitor_type), intent(inout) :: monitor
    real(dp), allocatable :: values(:)
    class(mode_set), allocatable :: free
    type(observation_type) :: seen
    associate (release => motion%plan%release, sources => motion%sources, force => force_of(scene))
      seen = seen_after_release(scene, release%time, grid, velocity)
      if (by_tolerance(scene%modes)) then
        call sources%free%find(first_numbers(release%count), free)
        values = release_tail(release%count, sources, force, release%time, seen) &
          + sources%loaded%gamma*release%tip%uncertainty*blow_reach(free, seen, sources%free%quadratic)
      else
        values = release_error(motion%later%segments(2), sources, motion%plan%count, force, seen, monitor)
      end if
    end associate
  end function missing_after_release

  function rounding_errors(scene, motion, response, velocity) result(errors)
    !! What the sum of the modes is off by, and the phase of the first mode, whose motion is most of the whole, m or m/s,
    !! (points). The samples may all be near the zeros of that motion: it counts as far as it swings between them.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    logical, intent(in) :: velocity             !! of the velocity, else of the displacement
    real(dp) :: errors(size(scene%response%points))
    class(mode_set), allocatable :: free
    type(time_grid) :: grid
    real(dp) :: peak, phase, unit
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    unit = abs(scene%impact%approach_velocity)
    if (velocity) then
      peak = largest_magnitude(response%velocity)
    else
      peak = largest_magnitude(response%displacement)
      unit = unit*motion%units%time%hi
    end if
    associate (points => scene%response%points, step => grid%step%hi, loaded => motion%modes%loaded, &
               captured => captured_samples(motion%plan, grid))
      phase = phase_error(scene, loaded, grid)
      errors = swing_of_first(loaded, 0.0_dp, motion%initial%modal_velocity(1), &
                              observation_type(points, stretch_type(step, captured*step, step), velocity))
      if (shows_release(motion%plan, grid)) then
        call motion%sources%free%find(first_numbers(1), free)
        phase = max(phase, phase_error(scene, free, grid))
        associate (after => motion%later%segments(2))
          errors = max(errors, swing_of_first(free, after%q(1), after%rate(1), &
                                              seen_after_release(scene, motion%plan%release%time, grid, velocity)))
        end associate
      end if
    end associate
    errors = (response%sum_error + phase)*max(peak, errors*unit)
  end function rounding_errors

  function swing_of_first(modes, q, rate, seen) result(swing)
    !! How far the first mode moves each point, or how fast, in V l²/h or V, (points).
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q, rate                 !! its state at the start of the motion
    type(observation_type), intent(in) :: seen      !! the record, in which it has decayed at the first sample
    real(dp) :: swing(size(seen%points)), c
    c = 0.0_dp
    if (allocated(modes%damping)) c = modes%damping(1)
    swing = amplitude_of(modes%beta_squared(1), c, q, rate, seen%stretch, seen%velocity) &
      *abs(reshape(modes%some_shapes(1, 1, seen%points), [size(seen%points)]))
  end function swing_of_first

  pure real(dp) function phase_error(scene, modes, grid) result(error)
    !! Of the first mode, whose motion is most of the whole: what the rounding of its root comes to at the end of the record,
    !! in its phase or as a part of its growth. A root that binary64 does not carry so far has more digits; of those that never have
    !! more, `drift_errors` tells.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: modes
    type(time_grid), intent(in) :: grid
    real(dp), parameter :: least_turning = 0.1_dp   ! β/α²; where it is less roots have more digits too (bw_refined_root)
    error = 0.0_dp
    if (allocated(modes%square_rounding)) return
    error = phase_drift(modes, 1, 4.0_dp*epsilon(error)*modes%alpha(1)**4, grid)
    error = min(error, largest_phase_error(scene)/least_turning)
  end function phase_error

  subroutine estimate_contacts(scene, motion, response, errors)
    !! What contacts have made of the errors of all that the motion follows from, and rounding.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    type(history_errors), intent(inout) :: errors
    type(shapes_at_points) :: shapes
    type(time_grid) :: grid
    real(dp) :: largest(size(scene%response%points), 2)    ! of displacements, V l²/h, and velocities, V
    real(dp) :: rounding, speed
    integer :: i, n
    grid = time_grid_of(scene%response%duration, scene%response%samples, motion%units%time)
    shapes%free = motion%modes%free%shapes(scene%response%points)
    if (allocated(motion%later%in_contact)) shapes%in_contact = motion%later%in_contact%shapes(scene%response%points)
    largest = 0.0_dp
    if (allocated(motion%later%segments)) then
      do i = 1, size(motion%later%segments)
        associate (segment => motion%later%segments(i))
          if (first_sample(segment%start, grid) <= last_sample(motion%later%segments, i, grid)) then
            largest = max(largest, matmul(transpose(abs(shapes_in(segment, shapes))), segment%error))
          end if
          if (i == 1) cycle
          if (is_blurred(segment, grid)) largest(:, 2) = max(largest(:, 2), jump_at(i, motion, shapes))
        end associate
      end do
    end if
    speed = abs(scene%impact%approach_velocity)
    n = response%finite_samples
    rounding = response%sum_error + growth_error(motion%modes%free, grid%samples*grid%step%hi)
    if (allocated(motion%later%in_contact)) then
      rounding = rounding + growth_error(motion%later%in_contact, grid%samples*grid%step%hi)
    end if
    errors%displacement = largest(:, 1)*(speed*motion%units%time%hi) &
      + rounding*largest_magnitude(response%displacement(:n, :))
    if (allocated(response%velocity)) then
      errors%velocity = largest(:, 2)*speed + rounding*largest_magnitude(response%velocity(:n, :))
    end if
  end subroutine estimate_contacts

  pure function shapes_in(segment, shapes) result(values)
    !! Those of the modes that move in a segment, (modes, points).
    type(segment_type), intent(in) :: segment
    type(shapes_at_points), intent(in) :: shapes
    real(dp), allocatable :: values(:, :)
    if (segment%modes == beam_in_contact) then
      values = shapes%in_contact
    else
      values = shapes%free
    end if
  end function shapes_in

  pure logical function is_blurred(segment, grid)
    !! A sample comes so close to the contact with which the segment starts that it may belong to the other side of it.
    type(segment_type), intent(in) :: segment
    type(time_grid), intent(in) :: grid
    type(dd) :: distance
    distance = segment%start - grid%step*anint(segment%start%hi/grid%step%hi)
    is_blurred = abs(distance%hi) <= segment%start_error
  end function is_blurred

  pure function jump_at(i, motion, shapes) result(jump)
    !! By how much the velocity jumps where segment i > 1 starts, V, (points).
    integer, intent(in) :: i
    type(case_motion), intent(in) :: motion
    type(shapes_at_points), intent(in) :: shapes
    real(dp) :: jump(size(shapes%free, 2))
    real(dp), allocatable :: q(:), rate(:)
    associate (before => motion%later%segments(i - 1), after => motion%later%segments(i))
      q = before%q
      rate = before%rate
      if (before%modes == beam_in_contact) then
        call move(motion%later%in_contact, after%start - before%start, q, rate)
      else
        call move(motion%modes%free, after%start - before%start, q, rate)
      end if
      jump = matmul(rate, shapes_in(before, shapes))
      jump = abs(matmul(after%rate, shapes_in(after, shapes)) - jump)
    end associate
  end function jump_at

end module bw_case_errors
