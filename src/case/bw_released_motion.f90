module bw_released_motion
  !! The motion after a release within a tolerance: how many modes of the beam alone it takes, how many of beam and mass the
  !! velocity of the tip when the mass leaves, and the state that it starts from.
  use bw_kinds, only: dp
  use bw_case_result, only: case_result
  use bw_coherence, only: stretch_type
  use bw_course, only: move
  use bw_course_histories, only: last_sample
  use bw_double_double, only: operator(*)
  use bw_energy, only: energy_type
  use bw_later_events, only: end_capture
  use bw_mode_choice, only: first_modes, modes_for, most_released
  use bw_mode_set, only: first_numbers, mode_set, mode_source
  use bw_monitor, only: monitor_type, part_monitor
  use bw_release, only: release_mass
  use bw_release_error, only: blow_reach, release_tail
  use bw_response, only: add_motion, response_type, start_histories
  use bw_rotation, only: speed_in_plane
  use bw_scene, only: scene_type
  use bw_time_grid, only: time_grid
  use bw_tip_rest, only: find_tip_rest
  implicit none (type, external)
  private
  public :: stretch_after, plan_released, peak_released, released_error, release_continuum

  real(dp), parameter :: tail_share = 0.8_dp    !! of a tolerance that may be missing of the beam's modes; the rest is the tip's
  real(dp), parameter :: tip_share = 0.25_dp    !! of what is missing of the modes, that the tip's need not be below
  real(dp), parameter :: least_share = 0.05_dp  !! of what the tip's may be, below which nothing is gained

contains

  pure type(stretch_type) function stretch_after(grid, result) result(stretch)
    !! The record after the release, times from there.
    type(time_grid), intent(in) :: grid         !! of the whole record
    type(case_result), intent(in) :: result
    integer :: before
    before = last_sample(result%courses, 1, grid)
    associate (released => result%courses(2)%start%hi, step => grid%step%hi)
      stretch = stretch_type(max(0.0_dp, before*step - released), grid%samples*step - released, step)
    end associate
  end function stretch_after

  subroutine plan_released(bound, fewest, source, alone, force, points, grid, result, reached, monitor)
    !! `released_count` and `tip_rest` of the result.
    real(dp), intent(in) :: bound               !! of the displacement, in V l²/h
    integer, intent(in) :: fewest               !! modes at least
    class(mode_source), intent(in) :: source    !! of beam and mass
    class(mode_source), intent(in) :: alone     !! of the beam alone
    real(dp), intent(in) :: force               !! the continuum's modal velocities are force·Φ_k(1)/M_k
    real(dp), intent(in) :: points(:)
    type(time_grid), intent(in) :: grid
    type(case_result), intent(inout) :: result
    real(dp), intent(out) :: reached            !! estimated error, V l²/h
    class(monitor_type), intent(inout) :: monitor    !! nothing is planned where it asks to stop
    real(dp) :: tail, tip
    call plan_share(tail_share*bound)
    if (tail + tip > bound) call plan_share(max(least_share*bound, bound - tip))    ! what the tip leaves of it
    reached = tail + tip
  contains
    subroutine plan_share(tail_bound)
      real(dp), intent(in) :: tail_bound
      call plan_counts(tail_bound, (1.0_dp - tail_share)*bound, fewest, source, alone, force, points, grid, result, tail, tip, &
                       monitor)
    end subroutine plan_share
  end subroutine plan_released

  subroutine plan_counts(tail_bound, tip_bound, fewest, source, alone, force, points, grid, result, tail, tip, monitor)
    !! Counts within bounds for each; where they cannot be kept, those that come nearest.
    real(dp), intent(in) :: tail_bound, tip_bound
    integer, intent(in) :: fewest
    class(mode_source), intent(in) :: source, alone
    real(dp), intent(in) :: force, points(:)
    type(time_grid), intent(in) :: grid
    type(case_result), intent(inout) :: result
    real(dp), intent(out) :: tail               !! estimated error by modes of the beam alone that are left out, V l²/h
    real(dp), intent(out) :: tip                !! and by the velocity of the tip when the mass leaves
    class(monitor_type), intent(inout) :: monitor
    class(mode_set), allocatable :: free
    type(stretch_type) :: stretch
    real(dp) :: strength
    stretch = stretch_after(grid, result)
    call modes_for(tail_bound, fewest, source, force, points, stretch, result%released_count, tail, alone, &
                   result%courses(2)%start)
    call alone%find(first_numbers(fewest), free)
    strength = source%gamma*maxval(blow_reach(free, points, stretch, .false., alone%quadratic))
    call find_tip_rest(source, force, result%released_count, result%courses(2)%start, &
                       min(tip_bound, max(least_share*tip_bound, tip_share*tail))/strength, result%tip_rest, monitor=monitor)
    tip = strength*result%tip_rest%uncertainty
  end subroutine plan_counts

  function released_error(source, alone, force, points, grid, result, velocity) result(error)
    !! Estimates of the largest error of the samples after the release, V l²/h or V, (points).
    class(mode_source), intent(in) :: source, alone
    real(dp), intent(in) :: force, points(:)    !! as those of `plan_released`
    type(time_grid), intent(in) :: grid
    type(case_result), intent(in) :: result
    logical, intent(in) :: velocity             !! of the velocity, else of the displacement
    real(dp) :: error(size(points))
    class(mode_set), allocatable :: free
    associate (stretch => stretch_after(grid, result))
      call alone%find(first_numbers(result%released_count), free)
      error = release_tail(result%released_count, source, alone, force, result%courses(2)%start, points, stretch, velocity) &
        + source%gamma*result%tip_rest%uncertainty*blow_reach(free, points, stretch, velocity, alone%quadratic)
    end associate
  end function released_error

  subroutine release_continuum(scene, source, alone, force, grid, monitor, result, free)
    !! The release as infinitely many modes have it, but for those of the beam alone beyond `released_count`.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source, alone
    real(dp), intent(in) :: force
    type(time_grid), intent(in) :: grid
    class(monitor_type), intent(inout) :: monitor        !! what is found means nothing where it asks to stop
    type(case_result), intent(inout) :: result
    class(mode_set), allocatable, intent(out) :: free    !! modes that move after it
    class(mode_set), allocatable :: loaded
    real(dp), dimension(result%released_count) :: q, rate
    call find_state(source, force, grid, result, monitor, loaded, q, rate)
    call alone%find(first_numbers(size(q)), free, grid%samples*grid%step%hi, monitor)
    if (monitor%stop_requested()) return
    associate (energy => energy_type(result%tip_rest%energy, epsilon(1.0_dp)*result%tip_rest%energy))
      call end_capture(scene, release_mass(loaded, q, rate, free, speed_in_plane(scene%rotation, result%units), &
                                           result%tip_rest, energy, monitor), result)
    end associate
  end subroutine release_continuum

  subroutine find_state(source, force, grid, result, monitor, loaded, q, rate)
    !! Beam and mass when it leaves, in V l²/h and V.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    type(time_grid), intent(in) :: grid
    type(case_result), intent(in) :: result
    class(monitor_type), intent(inout) :: monitor
    class(mode_set), allocatable, intent(out) :: loaded
    real(dp), intent(out) :: q(:), rate(:)
    call source%find(first_numbers(size(q)), loaded, source%stretch*(grid%samples*grid%step%hi), monitor)
    q = 0.0_dp
    rate = force*loaded%tip/loaded%modal_mass
    call move(loaded, result%courses(2)%start, q, rate)
  end subroutine find_state

  real(dp) function peak_released(seen, source, alone, force, points, grid, most, result, monitor) result(peak)
    !! The largest displacement after the release that is sure, V l²/h: of so many modes that what is missing of it is less
    !! than half of what they or those before the release show.
    real(dp), intent(in) :: seen                !! the largest displacement before the release, V l²/h
    class(mode_source), intent(in) :: source, alone
    real(dp), intent(in) :: force, points(:)
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: most                 !! samples that are looked at, nearly
    type(case_result), intent(in) :: result
    class(monitor_type), intent(inout), target :: monitor    !! the peak means nothing where it asks to stop
    real(dp) :: missing
    integer :: count
    count = first_modes
    do
      peak = peak_of_few(count, source, alone, force, points, grid, most, result, monitor)
      if (monitor%stop_requested()) return
      missing = maxval(release_tail(count, source, alone, force, result%courses(2)%start, points, stretch_after(grid, result), &
                                    .false.))
      if (missing <= 0.5_dp*max(peak, seen) .or. 4*count > min(most_released, source%highest, alone%highest)) exit
      count = 4*count
    end do
    peak = max(0.5_dp*peak, peak - missing)
  end function peak_released

  real(dp) function peak_of_few(count, source, alone, force, points, grid, most, result, monitor) result(peak)
    !! The largest displacement after the release as few modes show it, V l²/h: at some samples, at all where a mode grows.
    integer, intent(in) :: count                !! of the modes
    class(mode_source), intent(in) :: source, alone
    real(dp), intent(in) :: force, points(:)
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: most
    type(case_result), intent(in) :: result
    class(monitor_type), intent(inout), target :: monitor
    class(mode_set), allocatable :: loaded, free
    type(response_type) :: response
    type(part_monitor) :: part
    type(time_grid) :: coarse
    real(dp) :: q(count), rate(count)
    integer :: samples, stride
    call find_state(source, force, grid, result, monitor, loaded, q, rate)
    call alone%find(first_numbers(count), free, grid%samples*grid%step%hi)
    samples = grid%samples - last_sample(result%courses, 1, grid)
    stride = (samples - 1)/most + 1
    if (any(free%beta_squared%hi <= 0.0_dp)) stride = 1
    coarse = time_grid((samples - 1)/stride + 1, grid%step*real(stride, dp))
    part = part_monitor(monitor, share=0.0_dp)
    call start_histories(coarse, size(points), .false., response)
    call add_motion(free, free%overlap_of_beam(loaded, rate)/free%modal_mass, points, coarse, result%units%time%hi, part, &
                    response, displaced=free%overlap_of_beam(loaded, q)/free%modal_mass)
    peak = maxval(abs(response%displacement(:response%finite_samples, :)))
  end function peak_of_few

end module bw_released_motion
