module bw_case_plan
  !! How many modes of a case are summed: those that a scene counts, or as many as its tolerance takes, of the captured
  !! motion and of the motion after a release. A few modes show the peak that the tolerance is a part of.
  use bw_beam_units, only: beam_units
  use bw_case_modes, only: case_mode_cache, extend_sources
  use bw_case_result, only: case_modes, case_plan, release_plan
  use bw_coherence, only: observation_type, seen_from_blow, stretch_type
  use bw_double_double, only: dd, to_dd, operator(*), operator(/)
  use bw_initial_state, only: continuum_state
  use bw_kinds, only: dp
  use bw_mode_choice, only: first_modes, modes_for, most_released
  use bw_mode_set, only: first_numbers, mode_set, mode_source, mode_sources
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_release_error, only: blow_reach, release_tail
  use bw_response, only: response_type, sampling_type, start_histories, sum_tolerance
  use bw_scene, only: scene_type
  use bw_segment, only: leaves_range
  use bw_set_sum, only: add_motion
  use bw_streamed_modes, only: add_modes_of_source
  use bw_time_grid, only: first_sample, time_grid, time_grid_of
  use bw_tip_remainder, only: find_tip_remainder
  use bw_truncation, only: tail_error
  implicit none (type, external)
  private
  public :: captured_samples, force_of, plan_modes, seen_after_release, seen_while_captured, shows_release

  integer, parameter :: previewed = 1000       !! samples that show the peak well enough to plan with it
  integer, parameter :: most_previewed = 2**16 !! modes that are summed to see it
  real(dp), parameter :: tail_share(2) = [0.8_dp, 0.4_dp]
    !! of a tolerance that may be missing of the beam's modes after a release; the tip's velocity may take the others' part, and
    !! takes far more modes: the second is where these are dear (`tip_is_dear`)
  real(dp), parameter :: tip_share = 0.25_dp   !! of what is missing of the modes, that the tip's need not be below
  real(dp), parameter :: least_share = 0.05_dp !! of what the tip's may be, below which nothing is gained

contains

  subroutine plan_modes(scene, units, modes, monitor, sources, plan, cache)
    !! Nothing is planned for modes that are not resolved.
    type(scene_type), intent(in) :: scene          !! without sweeps
    type(beam_units), intent(in) :: units
    type(case_modes), intent(in) :: modes
    class(monitor_type), intent(inout), target :: monitor   !! nothing is planned where it asks to stop
    type(mode_sources), intent(inout) :: sources   !! of a basis that a tolerance finds too small there will be more modes
    type(case_plan), intent(out) :: plan
    type(case_mode_cache), intent(inout), optional :: cache   !! absent: no modes are shared
    if (.not. modes%resolved) return
    if (allocated(scene%release)) call plan_release(scene, units, modes%loaded, plan)
    if (by_tolerance(scene%modes)) then
      call choose_counts(scene, units, modes%loaded, monitor, sources, plan, cache)
    else if (allocated(modes%loaded)) then
      plan%count = modes%loaded%count
      if (allocated(plan%release)) plan%release%count = modes%free%count
    else
      plan%count = modes%free%count
    end if
  end subroutine plan_modes

  pure subroutine plan_release(scene, units, loaded, plan)
    !! A release counts where it comes before the record ends, and before a growing mode leaves the range of numbers.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: loaded          !! modes of beam and mass
    type(case_plan), intent(inout) :: plan
    type(dd) :: time
    time = to_dd(scene%release%time)/units%time
    if (allocated(scene%response)) then
      if (scene%release%time >= scene%response%duration) return
    end if
    if (leaves_range(loaded, time)) return
    plan%release = release_plan(time)
  end subroutine plan_release

  subroutine choose_counts(scene, units, loaded, monitor, sources, plan, cache)
    !! From the tolerance and the peak of the first modes, less what the others may take off it.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: loaded          !! the first modes of beam and mass
    class(monitor_type), intent(inout), target :: monitor
    type(mode_sources), intent(inout) :: sources
    type(case_plan), intent(inout) :: plan
    type(case_mode_cache), intent(inout), optional :: cache
    type(time_grid) :: grid
    real(dp) :: peak
    logical :: extended
    plan%count = first_modes
    if (allocated(plan%release)) plan%release%count = first_modes
    grid = time_grid_of(scene%response%duration, scene%response%samples, units%time)
    if (scene%impact%approach_velocity == 0.0_dp .or. force_of(scene) == 0.0_dp) return
    if (allocated(plan%release) .and. .not. shows_release(plan, grid)) then     ! no sample, but it takes energy along
      call find_tip_remainder(sources%loaded, force_of(scene), first_modes, plan%release%time, scene%modes%tolerance, &
                         plan%release%tip, monitor=monitor)
    end if
    if (grid%samples == 1) return                   ! nothing has moved yet
    call find_peak(scene, units, loaded, sources, monitor, plan, peak)
    if (monitor%stop_requested()) return
    if (peak == 0.0_dp) return
    do
      call choose_within(scene%modes%tolerance*peak, scene, sources, grid, monitor, plan)
      if (monitor%stop_requested()) return
      if (plan%reached <= scene%modes%tolerance*peak) exit
      call extend_sources(scene, units, monitor, sources, extended, cache)
      if (.not. extended) exit
    end do
    plan%reached = plan%reached/peak
  end subroutine choose_counts

  subroutine find_peak(scene, units, loaded, sources, monitor, plan, peak)
    !! The largest displacement, V l²/h, at least: what few modes show of it less what the others may take off it.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: loaded
    type(mode_sources), intent(in) :: sources
    class(monitor_type), intent(inout), target :: monitor    !! the peak means nothing where it asks to stop
    type(case_plan), intent(in) :: plan
    real(dp), intent(out) :: peak
    type(time_grid) :: captured, grid
    type(observation_type) :: seen
    real(dp) :: missing
    integer :: count
    grid = time_grid_of(scene%response%duration, scene%response%samples, units%time)
    captured = time_grid(captured_samples(plan, grid), grid%step)
    seen = seen_while_captured(scene, plan, grid, .false.)
    missing = maxval(tail_error(first_modes, sources%loaded, force_of(scene), seen))
    count = first_modes
    do
      peak = captured_peak(scene, units, count, captured, any(loaded%beta_squared%hi <= 0.0_dp), sources%loaded, monitor)
      if (monitor%stop_requested()) return
      if (missing <= 0.5_dp*peak .or. 4*count > min(most_previewed, sources%loaded%highest)) exit
      count = 4*count                               ! what is missing is all that is seen: nothing has moved far yet
      missing = maxval(tail_error(count, sources%loaded, force_of(scene), seen))
    end do
    peak = max(0.5_dp*peak, peak - missing)
    if (shows_release(plan, grid)) peak = max(peak, released_peak(peak, scene, units, sources, plan%release%time, monitor))
  end subroutine find_peak

  real(dp) function captured_peak(scene, units, count, grid, grows, source, monitor) result(peak)
    !! The largest displacement of the first modes, in l²/h times the approach velocity, at some of the samples; at all
    !! of them where a mode grows, whose peak is at the end.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    integer, intent(in) :: count                    !! of the modes
    type(time_grid), intent(in) :: grid             !! of the captured motion
    logical, intent(in) :: grows                    !! a mode does
    class(mode_source), intent(in) :: source        !! modes of beam and mass
    class(monitor_type), intent(inout), target :: monitor
    type(response_type) :: response
    type(part_monitor) :: part
    type(time_grid) :: coarse
    coarse = coarser(grid, grows)
    part = part_monitor(monitor, share=0.0_dp)
    call start_histories(sampling_type(scene%response%points, coarse, units%time%hi), response)
    call add_modes_of_source(source, force_of(scene), 1, count, sum_tolerance, part, response)
    peak = maxval(abs(response%displacement(:response%finite_samples, :)))
  end function captured_peak

  real(dp) function released_peak(seen, scene, units, sources, time, monitor) result(peak)
    !! The largest displacement after the release that is sure, V l²/h: of so many modes that what is missing of it is less
    !! than half of what they or those before the release show.
    real(dp), intent(in) :: seen                    !! the largest displacement before the release, V l²/h
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(mode_sources), intent(in) :: sources
    type(dd), intent(in) :: time                    !! of the release, l²/h
    class(monitor_type), intent(inout), target :: monitor    !! the peak means nothing where it asks to stop
    type(time_grid) :: grid
    real(dp) :: missing
    integer :: count
    grid = time_grid_of(scene%response%duration, scene%response%samples, units%time)
    count = first_modes
    do
      peak = first_released_peak(count, scene, grid, sources, time, units%time%hi, monitor)
      if (monitor%stop_requested()) return
      missing = maxval(release_tail(count, sources, force_of(scene), time, seen_after_release(scene, time, grid, .false.)))
      if (missing <= 0.5_dp*max(peak, seen)) exit
      if (4*count > min(most_released, sources%loaded%highest, sources%free%highest)) exit
      count = 4*count
    end do
    peak = max(0.5_dp*peak, peak - missing)
  end function released_peak

  real(dp) function first_released_peak(count, scene, grid, sources, time, unit_time, monitor) result(peak)
    !! The largest displacement after the release as the first modes show it, V l²/h.
    integer, intent(in) :: count                    !! of the modes
    type(scene_type), intent(in) :: scene
    type(time_grid), intent(in) :: grid             !! of the whole record
    type(mode_sources), intent(in) :: sources
    type(dd), intent(in) :: time                    !! of the release, l²/h
    real(dp), intent(in) :: unit_time               !! s
    class(monitor_type), intent(inout), target :: monitor
    class(mode_set), allocatable :: loaded, free
    type(response_type) :: response
    type(part_monitor) :: part
    type(time_grid) :: coarse
    real(dp) :: q(count), rate(count)
    call continuum_state(sources%loaded, force_of(scene), time, grid%samples*grid%step%hi, monitor, loaded, q, rate)
    call sources%free%find(first_numbers(count), free, grid%samples*grid%step%hi)
    coarse = coarser(time_grid(grid%samples - first_sample(time, grid) + 1, grid%step), any(free%beta_squared%hi <= 0.0_dp))
    part = part_monitor(monitor, share=0.0_dp)
    call start_histories(sampling_type(scene%response%points, coarse, unit_time), response)
    call add_motion(free, free%overlap_of_beam(loaded, rate)/free%modal_mass, part, response, &
                    displaced=free%overlap_of_beam(loaded, q)/free%modal_mass)
    peak = maxval(abs(response%displacement(:response%finite_samples, :)))
  end function first_released_peak

  pure type(time_grid) function coarser(grid, grows) result(coarse)
    !! Some of the samples; all where a mode grows.
    type(time_grid), intent(in) :: grid
    logical, intent(in) :: grows
    integer :: stride
    stride = (grid%samples - 1)/previewed + 1
    if (grows) stride = 1
    coarse = time_grid((grid%samples - 1)/stride + 1, grid%step*real(stride, dp))
  end function coarser

  subroutine choose_within(bound, scene, sources, grid, monitor, plan)
    !! Counts for the captured motion, and for that after a release, of which the modes that are left out and the velocity of
    !! the tip when the mass leaves share the error.
    real(dp), intent(in) :: bound                   !! of the displacement, V l²/h
    type(scene_type), intent(in) :: scene
    type(mode_sources), intent(in) :: sources
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor
    type(case_plan), intent(inout) :: plan
    real(dp) :: errors(2), share
    share = merge(tail_share(2), tail_share(1), tip_is_dear(sources%loaded))
    call modes_for(bound, sources, force_of(scene), seen_while_captured(scene, plan, grid, .false.), plan%count, plan%reached)
    if (.not. shows_release(plan, grid)) return
    call choose_released(share*bound)
    if (sum(errors) > bound) call choose_released(max(least_share*bound, bound - errors(2)))   ! what the tip leaves of it
    plan%reached = max(plan%reached, sum(errors))
  contains
    subroutine choose_released(tail_bound)
      real(dp), intent(in) :: tail_bound
      call choose_after_release([tail_bound, (1.0_dp - share)*bound], scene, sources, grid, monitor, plan%release, errors)
    end subroutine choose_released
  end subroutine choose_within

  subroutine choose_after_release(bounds, scene, sources, grid, monitor, release, errors)
    !! A count within bounds of two errors; where they cannot be kept, that which comes nearest.
    real(dp), intent(in) :: bounds(2)               !! of `errors`, V l²/h
    type(scene_type), intent(in) :: scene
    type(mode_sources), intent(in) :: sources
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor   !! nothing is chosen where it asks to stop
    type(release_plan), intent(inout) :: release
    real(dp), intent(out) :: errors(2)
      !! estimates: by modes of the beam alone that are left out, and by the velocity of the tip when the mass leaves, V l²/h
    class(mode_set), allocatable :: free
    type(observation_type) :: seen
    real(dp) :: strength, tip_bound
    errors = 0.0_dp
    seen = seen_after_release(scene, release%time, grid, .false.)
    call modes_for(bounds(1), sources, force_of(scene), seen, release%count, errors(1), release%time)
    call sources%free%find(first_numbers(first_modes), free)
    if (monitor%stop_requested()) return
    tip_bound = min(bounds(2), max(least_share*bounds(2), tip_share*errors(1)))
    if (tip_is_dear(sources%loaded)) tip_bound = sum(bounds) - errors(1)
    strength = sources%loaded%gamma*maxval(blow_reach(free, seen, sources%free%quadratic))
    call find_tip_remainder(sources%loaded, force_of(scene), release%count, release%time, &
                       tip_bound/strength, release%tip, monitor=monitor)
    errors(2) = strength*release%tip%uncertainty
  end subroutine choose_after_release

  pure logical function tip_is_dear(source)
    !! Modes take long to find, and so few of them move far after a release that most are looked at for the tip's velocity: with
    !! shear amplitudes fall as k⁻² alone, and a smaller part of the tolerance would take as many modes more.
    class(mode_source), intent(in) :: source
    tip_is_dear = source%quickly < huge(1) .and. source%decay > 2.0_dp
  end function tip_is_dear

  pure integer function captured_samples(plan, grid) result(samples)
    !! Samples before a release; all where there is none.
    type(case_plan), intent(in) :: plan
    type(time_grid), intent(in) :: grid
    samples = grid%samples
    if (allocated(plan%release)) samples = first_sample(plan%release%time, grid) - 1
  end function captured_samples

  pure logical function shows_release(plan, grid)
    !! Whether a sample of the record comes after a release.
    type(case_plan), intent(in) :: plan
    type(time_grid), intent(in) :: grid             !! of the whole record
    shows_release = captured_samples(plan, grid) < grid%samples
  end function shows_release

  pure type(observation_type) function seen_while_captured(scene, plan, grid, velocity) result(seen)
    !! The record up to a release, or all of it.
    type(scene_type), intent(in) :: scene
    type(case_plan), intent(in) :: plan
    type(time_grid), intent(in) :: grid             !! of the whole record
    logical, intent(in) :: velocity                 !! velocities, else displacements
    associate (samples => captured_samples(plan, grid))
      seen = seen_from_blow(scene%response%points, samples*grid%step%hi, samples, velocity)
    end associate
  end function seen_while_captured

  pure type(observation_type) function seen_after_release(scene, time, grid, velocity) result(seen)
    !! The record after a release, times from there.
    type(scene_type), intent(in) :: scene
    type(dd), intent(in) :: time                    !! of the release, l²/h
    type(time_grid), intent(in) :: grid             !! of the whole record
    logical, intent(in) :: velocity                 !! velocities, else displacements
    associate (before => first_sample(time, grid) - 1, step => grid%step%hi)
      seen = observation_type(scene%response%points, &
                              stretch_type(max(0.0_dp, before*step - time%hi), grid%samples*step - time%hi, step), velocity)
    end associate
  end function seen_after_release

  pure real(dp) function force_of(scene)
    !! Modal velocities of infinitely many modes are this times Φ_k(1)/M_k and the approach velocity.
    type(scene_type), intent(in) :: scene
    force_of = (1.0_dp + scene%impact%restitution)*scene%impact%mass_ratio
  end function force_of

end module bw_case_plan
