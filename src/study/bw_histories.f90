module bw_histories
  !! The histories of a case: from the modes that a scene counts, or from as many as its tolerance takes.
  use bw_kinds, only: dp
  use bw_case_modes, only: extend_modes, first_modes
  use bw_case_result, only: case_result, add_note, case_diverged, case_done, case_not_converged
  use bw_course_histories, only: last_sample, sum_courses
  use bw_continuum, only: continuum_velocity
  use bw_error, only: error_type, fail, status_bad_input
  use bw_mode_choice, only: modes_for, most_modes
  use bw_mode_set, only: mode_set, mode_source
  use bw_modes_par, only: by_tolerance
  use bw_input_values, only: position_of
  use bw_monitor, only: monitor_type, part_monitor, silent_monitor
  use bw_response, only: finish_histories, free_motion, start_histories, sum_tolerance
  use bw_streamed_modes, only: add_modes_of_source
  use bw_scene, only: scene_type
  use bw_reach, only: stretch_type
  use bw_release_error, only: release_error
  use bw_text, only: shortest, text_of
  use bw_time_grid, only: time_grid, time_grid_of
  use bw_truncation, only: tail_error, truncation_error, with_start
  implicit none (type, external)
  private
  public :: respond, plan_count

  integer, parameter :: previewed = 1000     !! samples that show the peak well enough to plan with
  real(dp), parameter :: sum_share = 0.01_dp !! of a tolerance that the sum of the modes may take
  real(dp), parameter :: loosest = 1.0e-4_dp !! tolerance of a sum, over its own peak

contains

  subroutine respond(scene, free, loaded, source, alone, monitor, result, whole)
    !! Histories from the state after each event to the next, and how far they may be from those of infinitely many modes.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in), optional :: free, loaded    !! modes of the beam alone, and of beam and mass
    class(mode_source), intent(inout), optional :: source    !! modes of beam and mass; absent: the mass is not captured
    class(mode_source), intent(in) :: alone                  !! modes of the beam alone
    class(monitor_type), intent(inout) :: monitor
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
      call sum_to_tolerance(scene, source, grid, monitor, result)
    else if (allocated(result%courses)) then
      call start_histories(grid, size(scene%response%points), scene%response%velocity, result%response)
      call sum_courses(free, loaded, scene%response%points, grid, monitor, result)
      result%response%sum_error = sum_tolerance
    else
      call free_motion(result%modes, result%modal_velocity*result%approach_velocity, scene%response%points, grid, &
                       result%units%time%hi, scene%response%velocity, monitor, result%response)
    end if
    whole = .not. monitor%stop_requested()
    if (.not. whole) return
    if (result%response%failing_mode > 0) then
      call note_overflow(scene, result)
    else if (present(source) .and. result%status == case_done) then
      call estimate_errors(scene, source, alone, grid, result)
    end if
  end subroutine respond

  subroutine note_overflow(scene, result)
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    result%status = case_diverged
    call add_note(result, 'overflow: mode '//text_of(result%response%failing_mode)//' overflows at t = '// &
      shortest(result%response%finite_samples*(scene%response%duration/scene%response%samples), 6)// &
      ' s; the histories hold fill from there on')
  end subroutine note_overflow

  subroutine estimate_errors(scene, source, alone, grid, result)
    !! `displacement_error` and `velocity_error`, SI.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source, alone
    type(time_grid), intent(in) :: grid
    type(case_result), intent(inout) :: result
    real(dp) :: speed
    speed = abs(result%approach_velocity)
    result%response%displacement_error = errors(.false.)*(speed*result%units%time%hi) &
      + result%response%sum_error*maxval(abs(result%response%displacement))
    if (scene%response%velocity) result%response%velocity_error = &
      with_start(errors(.true.)*speed, result%response%velocity(1, :), scene%response%points, &
                 result%approach_velocity*(1.0_dp + scene%impact%restitution)) &
      + result%response%sum_error*maxval(abs(result%response%velocity))
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
        force = (1.0_dp + scene%impact%restitution)*gamma
        if (by_tolerance(scene%modes)) then
          values = tail_error(result%mode_count, source, force, points, longest, grid%samples, velocity)
        else
          values = truncation_error(result%modes, result%modal_velocity &
                                    - continuum_velocity(result%modes, gamma, scene%impact%restitution), &
                                    source, force, points, longest, samples, velocity)
        end if
        if (allocated(result%courses)) values = max(values, after_release(scene, source, alone, force, grid, result, velocity))
      end associate
    end function errors
  end subroutine estimate_errors

  function after_release(scene, source, alone, force, grid, result, velocity) result(values)
    !! The same after the mass has left, (points).
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source, alone
    real(dp), intent(in) :: force
    type(time_grid), intent(in) :: grid
    type(case_result), intent(in) :: result
    logical, intent(in) :: velocity
    real(dp), allocatable :: values(:)
    integer :: before
    before = last_sample(result%courses, 1, grid)
    associate (course => result%courses(2))
      values = release_error(course%q, course%rate, source, alone, result%mode_count, force, course%start, &
                             scene%response%points, &
                             stretch_type(0.0_dp, grid%samples*grid%step%hi - course%start%hi, grid%samples - before), velocity)
    end associate
  end function after_release

  subroutine sum_to_tolerance(scene, source, grid, monitor, result)
    !! The continuum's modes, the first of them to learn the peak, then as many as the tolerance takes. Where 10⁷ do not
    !! reach it the histories are fill.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(inout) :: source
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(inout) :: result
    real(dp) :: reached, rest, error
    call start_histories(grid, size(scene%response%points), scene%response%velocity, result%response)
    call add_some(scene, source, 1, first_modes, grid, sum_tolerance, monitor, result)
    call choose_count(scene, source, grid, result, reached, rest)
    if (reached > scene%modes%tolerance) then
      result%status = case_not_converged
      result%response%finite_samples = 0
      call add_note(result, 'tolerance: '//out_of_reach(scene%modes%tolerance, source, reached)//'; the histories are fill')
    else
      if (scene%response%velocity) rest = 1.0_dp      ! their velocity is no smaller than that of the first
      error = result%response%sum_error
      call add_some(scene, source, first_modes + 1, result%mode_count, grid, &
                    min(loosest, max(sum_tolerance, sum_share*scene%modes%tolerance/rest)), monitor, result)
      result%response%sum_error = error + rest*(result%response%sum_error - error)
    end if
    call finish_histories(result%units%time%hi, result%response)
  end subroutine sum_to_tolerance

  subroutine choose_count(scene, source, grid, result, reached, rest)
    !! `mode_count` from the tolerance and the peak of the first modes, less what the others may take off it.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(inout) :: source
    type(time_grid), intent(in) :: grid
    type(case_result), intent(inout) :: result
    real(dp), intent(out) :: reached            !! the estimated error over the peak
    real(dp), intent(out), optional :: rest     !! what the modes after the first are estimated to add, over the peak; at most 1
    real(dp) :: peak, force, longest, scale, tail
    logical :: extended
    longest = grid%samples*grid%step%hi
    scale = abs(result%approach_velocity)*result%units%time%hi
    result%mode_count = first_modes
    reached = 0.0_dp
    if (present(rest)) rest = 1.0_dp
    peak = maxval(abs(result%response%displacement(:result%response%finite_samples, :)))
    if (peak == 0.0_dp) return
    peak = peak/scale
    associate (points => scene%response%points)
      force = (1.0_dp + scene%impact%restitution)*scene%impact%mass_ratio
      tail = maxval(tail_error(first_modes, source, force, points, longest, grid%samples, .false.))
      peak = max(0.5_dp*peak, peak - tail)
      if (present(rest)) rest = min(1.0_dp, max(epsilon(1.0_dp), tail/peak))
      do
        call modes_for(scene%modes%tolerance*peak, first_modes, source, force, points, longest, grid%samples, &
                       result%mode_count, reached)
        if (reached <= scene%modes%tolerance*peak) exit
        call extend_modes(scene, result%units, source, extended)
        if (.not. extended) exit
      end do
    end associate
    reached = reached/peak
  end subroutine choose_count

  pure function out_of_reach(tolerance, source, reached) result(text)
    real(dp), intent(in) :: tolerance
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: reached             !! relative error of the most modes
    character(:), allocatable :: text
    text = shortest(tolerance, 6)//' cannot be reached with '//text_of(min(most_modes, source%highest))//' modes; accepted: '// &
      shortest(1.05_dp*reached, 2)//' or more'
  end function out_of_reach

  subroutine plan_count(scene, source, result, error)
    !! How many modes a tolerance takes, from a preview of the history: before a run, and for `beamwave check`.
    !! **Errors**: `status_bad_input` where more modes than there may be would be needed.
    type(scene_type), intent(in) :: scene       !! without sweeps, with a tolerance
    class(mode_source), intent(inout) :: source    !! modes of beam and mass
    type(case_result), intent(inout) :: result
    type(error_type), allocatable, intent(out) :: error
    type(silent_monitor) :: monitor
    type(time_grid) :: grid
    real(dp) :: reached
    integer :: line
    grid = time_grid_of(scene%response%duration, min(previewed, scene%response%samples), result%units%time)
    allocate (result%response)
    call start_histories(grid, size(scene%response%points), .false., result%response)
    call add_some(scene, source, 1, first_modes, grid, sum_tolerance, monitor, result)
    call choose_count(scene, source, grid, result, reached)
    if (reached <= scene%modes%tolerance) return
    line = scene%groups(position_of(scene%groups, 'modes'))%line_of('tolerance')
    call fail(error, status_bad_input, scene%file//':'//text_of(line)//': modes%tolerance: '// &
              out_of_reach(scene%modes%tolerance, source, reached))
  end subroutine plan_count

  subroutine add_some(scene, source, first, last, grid, tolerance, monitor, result)
    !! Modes `first` … `last` of the continuum.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source
    integer, intent(in) :: first, last
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: tolerance           !! of the sum
    class(monitor_type), intent(inout), target :: monitor
    type(case_result), intent(inout) :: result
    type(part_monitor) :: part
    part = part_monitor(monitor, real(first - 1, dp)/last, real(last - first + 1, dp)/last)
    call add_modes_of_source(source, (1.0_dp + scene%impact%restitution)*scene%impact%mass_ratio &
                       *(result%approach_velocity*result%units%time%hi), first, last, scene%response%points, grid, &
                       result%units%time%hi, tolerance, part, result%response)
  end subroutine add_some

end module bw_histories
