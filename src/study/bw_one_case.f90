module bw_one_case
  !! One case from scene to result: modes, events, response, spectrum.
  use bw_kinds, only: dp
  use bw_amplitude_spectrum, only: amplitude_spectrum
  use bw_beam_units, only: units_of
  use bw_capture, only: capture_type, capture_mass
  use bw_case_result, only: case_result, add_note, case_diverged
  use bw_closed_form, only: closed_form_set, closed_form_modes
  use bw_double_double, only: dd
  use bw_event, only: event_type
  use bw_impact, only: impact_type, strike
  use bw_measured, only: measure_waves
  use bw_monitor, only: monitor_type
  use bw_response, only: free_motion
  use bw_result_layout, only: result_layout
  use bw_rotation, only: acts_in_plane, dimensionless_speed
  use bw_scene, only: scene_type
  use bw_stopwatch, only: stopwatch, stage_modes, stage_events, stage_response, stage_spectrum
  use bw_text, only: shortest, text_of
  use bw_time_grid, only: time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: run_case

contains

  subroutine run_case(scene, layout, watch, monitor, result)
    !! The way the data goes. After a stop that the monitor asked for the result is not complete.
    type(scene_type), intent(in) :: scene          !! without sweeps
    type(result_layout), intent(in) :: layout
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(out) :: result
    type(closed_form_set), allocatable :: free, loaded
    call watch%start()
    allocate (result%notes(0))
    result%units = units_of(scene%beam)
    call find_modes(scene, result, free, loaded)
    call watch%lap(stage_modes)
    call apply_events(scene, free, loaded, result)
    call watch%lap(stage_events)
    call respond(scene, monitor, result)
    call watch%lap(stage_response)
    call take_spectrum(scene, layout, result)
    call watch%lap(stage_spectrum)
  end subroutine run_case

  subroutine find_modes(scene, result, free, loaded)
    !! Modes of the beam alone, and of beam and mass if the mass is captured; the last of them are in force.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    type(closed_form_set), allocatable, intent(out) :: free, loaded
    type(dd), allocatable :: omega                 ! absent: the beam does not rotate in the plane of its motion
    real(dp), allocatable :: longest               ! absent: no history is asked for
    result%can_grow = .true.
    if (allocated(scene%rotation)) then
      result%can_grow = acts_in_plane(scene%rotation)
      if (result%can_grow) omega = dimensionless_speed(scene%rotation, result%units)
      if (.not. result%can_grow) call add_note(result, &
        'no effect: rotation out of plane changes nothing in this model, which has neither tension nor shear')
    end if
    if (allocated(scene%response)) longest = scene%response%duration/result%units%time%hi
    if (allocated(scene%capture)) then
      free = closed_form_modes(scene%modes%before, 0.0_dp, omega)
      loaded = closed_form_modes(scene%modes%after, scene%impact%mass_ratio, omega, longest)
      result%before = free
      result%modes = loaded
    else
      free = closed_form_modes(scene%modes%before, 0.0_dp, omega, longest)
      result%modes = free
    end if
    call note_growth(result)
  end subroutine find_modes

  subroutine note_growth(result)
    !! Which modes grow.
    type(case_result), intent(inout) :: result
    integer :: growing
    growing = count(result%modes%beta_squared%hi < 0.0_dp)
    if (growing == 0) return
    call add_note(result, 'unstable: '//text_of(growing)//' of '//text_of(result%modes%count)// &
      ' modes grow without bound, the angular velocity being above '// &
      shortest(result%modes%critical_speed%hi*result%units%frequency, 6)//' rad/s')
  end subroutine note_growth

  subroutine apply_events(scene, free, loaded, result)
    !! The impact, and the capture if the mass stays.
    type(scene_type), intent(in) :: scene
    type(closed_form_set), intent(in) :: free
    type(closed_form_set), intent(in), optional :: loaded
    type(case_result), intent(inout) :: result
    type(capture_type) :: capture
    real(dp) :: profile(scene_profile(scene))
    integer :: j
    if (.not. allocated(scene%impact)) return
    result%approach_velocity = scene%impact%approach_velocity
    result%impact = strike(free, scene%impact%mass_ratio, scene%impact%restitution)
    result%modal_velocity = result%impact%modal_velocity
    result%events = [result%impact%event]
    profile = [(real(j, dp)/(size(profile) - 1), j=0, size(profile) - 1)]
    result%velocity_jump = matmul(result%impact%modal_velocity, free%shapes(profile))
    if (.not. present(loaded)) return
    capture = capture_mass(free, result%impact, loaded)
    result%modal_velocity = capture%modal_velocity
    result%events = [result%events, capture%event]
    if (scene%impact%restitution > 0.0_dp) call note_added_energy(scene, result)
  end subroutine apply_events

  pure integer function scene_profile(scene) result(points)
    type(scene_type), intent(in) :: scene
    points = 0
    if (allocated(scene%impact)) points = scene%impact%profile_points
  end function scene_profile

  subroutine note_added_energy(scene, result)
    !! With e > 0 the interface conditions 22–26 give the mass the tip's velocity.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    type(event_type) :: capture
    real(dp) :: approach
    capture = result%events(2)
    approach = result%events(1)%energy_before
    if (approach == 0.0_dp) return
    call add_note(result, 'added energy: restitution '//shortest(scene%impact%restitution, 6)// &
      ' with capture: the interface conditions give the mass the tip''s velocity, which adds the momentum '// &
      shortest((capture%momentum_after - capture%momentum_before)/result%events(1)%momentum_before, 4)// &
      ' and the energy '//shortest((capture%energy_after - capture%energy_before)/approach, 4)// &
      ' of what the mass brought; beam and mass then hold '//shortest(capture%energy_after/approach, 4)// &
      ' of its energy')
  end subroutine note_added_energy

  subroutine respond(scene, monitor, result)
    !! Histories from the state after the last event at t = 0.
    type(scene_type), intent(in) :: scene
    class(monitor_type), intent(inout) :: monitor
    type(case_result), intent(inout) :: result
    type(time_grid) :: grid
    if (.not. allocated(scene%response)) return
    grid = time_grid_of(scene%response%duration, scene%response%samples, result%units%time)
    allocate (result%response)
    call free_motion(result%modes, result%modal_velocity*result%approach_velocity, scene%response%points, grid, &
                     result%units%time%hi, scene%response%velocity, monitor, result%response)
    if (result%response%failing_mode == 0) return
    result%status = case_diverged
    call add_note(result, 'overflow: mode '//text_of(result%response%failing_mode)//' overflows at t = '// &
      shortest(result%response%finite_samples*(scene%response%duration/scene%response%samples), 6)// &
      ' s; the histories hold fill from there on')
  end subroutine respond

  subroutine take_spectrum(scene, layout, result)
    !! Amplitude spectra of all points; waves measured from the tip and midpoint histories alone.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(case_result), intent(inout) :: result
    integer :: p
    if (.not. allocated(scene%spectrum)) return
    associate (histories => result%response%displacement)
      if (result%status == case_diverged) then
        call add_note(result, 'no spectrum of histories that overflow')
      else
        allocate (result%amplitude(size(histories, 1)/2 + 1, size(histories, 2)))
        do p = 1, size(histories, 2)
          result%amplitude(:, p) = amplitude_spectrum(histories(:, p), scene%spectrum%window)
        end do
      end if
      if (layout%middle == 0 .or. layout%tip == 0) then
        call add_note(result, 'measured wave numbers and velocities need the points 0.5 and 1.0, so they are left out')
      else
        allocate (result%measured)
        call measure_waves(histories(:, layout%tip), histories(:, layout%middle), scene%response%duration, &
                           scene%beam%length, scene%spectrum%max_peaks, .true., result%measured)
      end if
    end associate
    if (.not. allocated(result%measured)) return
    do p = 1, size(result%measured%notes)
      call add_note(result, result%measured%notes(p)%text)
    end do
  end subroutine take_spectrum

end module bw_one_case
