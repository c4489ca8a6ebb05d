module bw_one_case
  !! One case from scene to result: modes, events, response, spectrum.
  use bw_kinds, only: dp
  use bw_beam_units, only: units_of
  use bw_blow, only: blow_type, continuum_blow
  use bw_case_modes, only: find_modes
  use bw_case_result, only: case_result, add_note, case_done
  use bw_case_shares, only: case_shares, events_share, histories_share, modes_share, spectrum_share, stage_part
  use bw_case_spectrum, only: take_spectrum
  use bw_error, only: error_type
  use bw_event, only: event_type
  use bw_histories, only: respond
  use bw_kept_blows, only: find_blow, kept_blows
  use bw_kept_work, only: kept_work
  use bw_later_events, only: follow_events
  use bw_mode_check, only: known_modes
  use bw_mode_set, only: mode_set, mode_source
  use bw_modes_at_end, only: modes_at_end
  use bw_monitor, only: monitor_type, part_monitor
  use bw_result_layout, only: result_layout
  use bw_scene, only: scene_type
  use bw_stopwatch, only: stopwatch, stage_modes, stage_events, stage_response, stage_spectrum
  use bw_text, only: shortest, text_of
  use bw_tolerance_sum, only: plan_count
  implicit none (type, external)
  private
  public :: run_case, plan_case

contains

  subroutine run_case(scene, layout, watch, monitor, kept, result, whole)
    !! The way the data goes.
    type(scene_type), intent(in) :: scene          !! without sweeps
    type(result_layout), intent(in) :: layout
    type(stopwatch), intent(inout) :: watch
    class(monitor_type), intent(inout), target :: monitor
    type(kept_work), intent(inout), target :: kept !! what other cases have found
    type(case_result), intent(out), target :: result
    logical, intent(out) :: whole                  !! false where the monitor asked to stop before all was done
    class(mode_set), pointer :: free, loaded       ! modes of the beam alone, and of beam and mass
    class(mode_source), allocatable :: source     ! of beam and mass
    class(mode_source), allocatable :: alone      ! of the beam alone
    type(part_monitor) :: part                    ! for a stage
    type(known_modes), allocatable :: known       ! that move after the last event
    real(dp), allocatable :: share(:)
    call watch%start()
    allocate (result%notes(0))
    result%units = units_of(scene%beam)
    share = case_shares(scene)
    part = stage_part(monitor, share, modes_share)
    call find_modes(scene, result, free, loaded, source, alone, part, kept%modes, kept%operators)
    whole = .not. monitor%stop_requested()
    if (.not. whole) return
    call note_growth(result)
    call watch%lap(stage_modes)
    allocate (result%events(0))
    if (result%status == case_done) then
      result%mode_count = result%modes%count
      part = stage_part(monitor, share, events_share)
      call apply_events(scene, free, loaded, part, kept%blows, result)
      whole = .not. monitor%stop_requested()
      part = part_monitor(monitor, sum(share(:events_share)), 0.0_dp)     ! how long later events take is not known
      if (whole) call follow_events(scene, free, loaded, part, result)
      whole = .not. monitor%stop_requested()
      if (.not. whole) return
    end if
    if (allocated(scene%impact)) call watch%lap(stage_events)
    part = stage_part(monitor, share, histories_share)
    call respond(scene, free, loaded, source, alone, part, kept%sum, result, whole)
    if (.not. whole) return
    if (allocated(scene%response)) call watch%lap(stage_response)
    if (allocated(result%response)) call watch%rebook(stage_response, stage_modes, result%response%mode_seconds)
    part = stage_part(monitor, share, spectrum_share)
    call modes_at_end(scene, free, loaded, source, alone, result, known)
    call take_spectrum(scene, layout, known, kept%spectrum, part, result, whole)
    if (.not. whole) return
    if (allocated(scene%spectrum)) call watch%lap(stage_spectrum)
  end subroutine run_case

  subroutine plan_case(scene, monitor, count, error, reached)
    !! How many modes a scene with a tolerance will sum.
    !! **Errors**: `status_bad_input` where the tolerance is out of reach.
    type(scene_type), intent(in) :: scene          !! without sweeps
    class(monitor_type), intent(inout) :: monitor  !! nothing is planned where it asks to stop
    integer, intent(out) :: count
    type(error_type), allocatable, intent(out) :: error
    real(dp), intent(out), optional :: reached     !! the estimated error over the peak
    type(case_result), target :: result
    class(mode_set), pointer :: free, loaded
    class(mode_source), allocatable :: source, alone     ! of beam and mass, of the beam alone
    result%units = units_of(scene%beam)
    allocate (result%notes(0))
    count = 0
    call find_modes(scene, result, free, loaded, source, alone, monitor)
    if (monitor%stop_requested()) return
    if (result%status /= case_done) return         ! the run says so
    result%approach_velocity = scene%impact%approach_velocity
    call follow_events(scene, free, loaded, monitor, result)
    call plan_count(scene, source, alone, monitor, result, error, reached)
    count = result%mode_count
  end subroutine plan_case

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

  subroutine apply_events(scene, free, loaded, monitor, kept, result)
    !! The impact, and the capture if the mass stays.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in), optional :: free, loaded
    class(monitor_type), intent(inout) :: monitor  !! what is left means nothing where it asks to stop
    type(kept_blows), intent(inout) :: kept
    type(case_result), intent(inout) :: result
    type(blow_type) :: blow
    if (.not. allocated(scene%impact)) return
    result%approach_velocity = scene%impact%approach_velocity
    associate (gamma => scene%impact%mass_ratio, e => scene%impact%restitution, points => scene%impact%profile_points)
      if (present(free)) then
        call find_blow(free, loaded, gamma, e, points, monitor, kept, blow)
        if (monitor%stop_requested()) return
      else
        call continuum_blow(result%modes, gamma, e, points, blow)
      end if
      result%impact = blow%impact
      call move_alloc(blow%modal_velocity, result%modal_velocity)
      call move_alloc(blow%velocity_jump, result%velocity_jump)
      call move_alloc(blow%events, result%events)
      if (present(loaded) .and. e > 0.0_dp) call note_added_energy(scene, result)
    end associate
  end subroutine apply_events

  subroutine note_added_energy(scene, result)
    !! With e > 0 the interface conditions 22–26 give the mass the tip's velocity.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    type(event_type) :: capture
    real(dp) :: approach
    capture = result%events(2)
    approach = result%events(1)%energy_before
    if (approach == 0.0_dp .or. result%approach_velocity == 0.0_dp) return
    call add_note(result, 'added energy: restitution '//shortest(scene%impact%restitution, 6)// &
      ' with capture: the interface conditions give the mass the tip''s velocity, which adds the momentum '// &
      shortest((capture%momentum_after - capture%momentum_before)/result%events(1)%momentum_before, 4)// &
      ' and the energy '//shortest((capture%energy_after - capture%energy_before)/approach, 4)// &
      ' of what the mass brought; beam and mass then hold '//shortest(capture%energy_after/approach, 4)// &
      ' of its energy')
  end subroutine note_added_energy

end module bw_one_case
