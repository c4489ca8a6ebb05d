module bw_histories
  !! The histories of a case: from the modes that a scene counts, or from as many as its tolerance takes.
  use bw_kinds, only: dp
  use bw_case_result, only: case_result, add_note, case_diverged
  use bw_closed_form, only: closed_form_set, numbered_modes
  use bw_continuum, only: continuum_velocity
  use bw_double_double, only: dd
  use bw_error, only: error_type, fail, status_bad_input
  use bw_mode_choice, only: modes_for, most_modes
  use bw_modes_par, only: by_tolerance, shown_modes
  use bw_monitor, only: monitor_type, part_monitor
  use bw_response, only: response_type, add_motion, finish_histories, free_motion, start_histories
  use bw_scene, only: scene_type
  use bw_text, only: shortest, text_of
  use bw_time_grid, only: time_grid, time_grid_of
  use bw_truncation, only: tail_error, truncation_error, with_start
  implicit none (type, external)
  private
  public :: respond

  integer, parameter :: first_modes = 64     !! enough to know the peak of the motion
  integer, parameter :: batch = 65536        !! modes held at a time

contains

  subroutine respond(scene, omega, loaded, monitor, result, error)
    !! Histories from the state after the last event at t = 0, and how far they may be from those of infinitely many modes.
    type(scene_type), intent(in) :: scene
    type(dd), intent(in), optional :: omega                  !! in-plane angular velocity in h/l²; absent: none
    type(closed_form_set), intent(in), optional :: loaded    !! modes of beam and mass; absent: the mass is not captured
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(inout) :: result
    type(error_type), allocatable, intent(out) :: error
    type(time_grid) :: grid
    if (.not. allocated(scene%response)) return
    grid = time_grid_of(scene%response%duration, scene%response%samples, result%units%time)
    allocate (result%response)
    if (by_tolerance(scene%modes)) then
      call sum_to_tolerance(scene, omega, grid, monitor, result, error)
      if (allocated(error)) return
    else
      call free_motion(result%modes, result%modal_velocity*result%approach_velocity, scene%response%points, grid, &
                       result%units%time%hi, scene%response%velocity, monitor, result%response)
    end if
    if (result%response%failing_mode > 0) then
      call note_overflow(scene, result)
    else if (present(loaded)) then
      call estimate_errors(scene, omega, loaded, grid, result)
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

  subroutine estimate_errors(scene, omega, loaded, grid, result)
    !! `displacement_error` and `velocity_error`, SI.
    type(scene_type), intent(in) :: scene
    type(dd), intent(in), optional :: omega
    type(closed_form_set), intent(in) :: loaded
    type(time_grid), intent(in) :: grid
    type(case_result), intent(inout) :: result
    real(dp) :: speed
    speed = abs(result%approach_velocity)
    result%response%displacement_error = errors(.false.)*(speed*result%units%time%hi)
    if (scene%response%velocity) result%response%velocity_error = &
      with_start(errors(.true.)*speed, result%response%velocity(1, :), scene%response%points, &
                 result%approach_velocity*(1.0_dp + scene%impact%restitution))
  contains
    function errors(velocity) result(values)
      logical, intent(in) :: velocity
      real(dp), allocatable :: values(:)
      real(dp) :: force, longest
      longest = grid%samples*grid%step%hi
      associate (gamma => scene%impact%mass_ratio, points => scene%response%points)
        force = (1.0_dp + scene%impact%restitution)*gamma
        if (by_tolerance(scene%modes)) then
          values = tail_error(result%mode_count, gamma, force, omega, points, longest, grid%samples, velocity)
        else
          values = truncation_error(loaded, result%modal_velocity &
                                    - continuum_velocity(loaded, gamma, scene%impact%restitution), &
                                    force, omega, points, longest, grid%samples, velocity)
        end if
      end associate
    end function errors
  end subroutine estimate_errors

  subroutine sum_to_tolerance(scene, omega, grid, monitor, result, error)
    !! The continuum's modes, the first of them to learn the peak, then as many as the tolerance takes.
    type(scene_type), intent(in) :: scene
    type(dd), intent(in), optional :: omega
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(inout) :: result
    type(error_type), allocatable, intent(out) :: error
    call start_histories(grid, size(scene%response%points), scene%response%velocity, result%response)
    call add_continuum(scene, omega, 1, first_modes, grid, monitor, result)
    call choose_count(scene, omega, grid, result, error)
    if (allocated(error)) return
    call add_continuum(scene, omega, first_modes + 1, result%mode_count, grid, monitor, result)
    call finish_histories(result%units%time%hi, result%response)
  end subroutine sum_to_tolerance

  subroutine choose_count(scene, omega, grid, result, error)
    !! `mode_count` from the tolerance and the peak of the first modes, less what the others may take off it.
    type(scene_type), intent(in) :: scene
    type(dd), intent(in), optional :: omega
    type(time_grid), intent(in) :: grid
    type(case_result), intent(inout) :: result
    type(error_type), allocatable, intent(out) :: error
    real(dp) :: peak, force, longest, reached, scale
    longest = grid%samples*grid%step%hi
    scale = abs(result%approach_velocity)*result%units%time%hi
    result%mode_count = first_modes
    peak = maxval(abs(result%response%displacement(:result%response%finite_samples, :)))
    if (peak == 0.0_dp) return
    peak = peak/scale
    associate (gamma => scene%impact%mass_ratio, points => scene%response%points)
      force = (1.0_dp + scene%impact%restitution)*gamma
      peak = max(0.5_dp*peak, peak - maxval(tail_error(first_modes, gamma, force, omega, points, longest, &
                                                       grid%samples, .false.)))
      call modes_for(scene%modes%tolerance*peak, first_modes, gamma, force, omega, points, longest, grid%samples, &
                     result%mode_count, reached)
    end associate
    if (reached > scene%modes%tolerance*peak) call refuse(scene, reached/peak, error)
  end subroutine choose_count

  subroutine refuse(scene, reached, error)
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: reached             !! relative error of `most_modes` modes
    type(error_type), allocatable, intent(out) :: error
    call fail(error, status_bad_input, scene%file//': modes%tolerance: '//shortest(scene%modes%tolerance, 6)// &
              ' cannot be reached with '//text_of(most_modes)//' modes; accepted: '//shortest(1.05_dp*reached, 2)//' or more')
  end subroutine refuse

  subroutine add_continuum(scene, omega, first, last, grid, monitor, result)
    !! Modes `first` … `last`, a batch at a time.
    type(scene_type), intent(in) :: scene
    type(dd), intent(in), optional :: omega
    integer, intent(in) :: first, last
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout), target :: monitor
    type(case_result), intent(inout) :: result
    type(closed_form_set) :: modes
    type(part_monitor) :: part
    integer :: k, i
    do k = first, last, batch
      part = part_monitor(monitor, real(k - 1, dp)/last, real(min(batch, last - k + 1), dp)/last)
      modes = numbered_modes([(i, i=k, min(k + batch - 1, last))], scene%impact%mass_ratio, omega, &
                             grid%samples*grid%step%hi)
      call add_motion(modes, continuum_velocity(modes, scene%impact%mass_ratio, scene%impact%restitution) &
                      *(result%approach_velocity*result%units%time%hi), scene%response%points, grid, &
                      result%units%time%hi, part, result%response)
      if (monitor%stop_requested()) return
    end do
  end subroutine add_continuum

end module bw_histories
