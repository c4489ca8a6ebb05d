module bw_case_validity
  !! Warnings if a case is outside the validity of the theory. They name the input that was likely meant otherwise, or the
  !! effect that is missing.
  use bw_beam_par, only: beam_par
  use bw_beam_units, only: beam_units, slenderness
  use bw_case_result, only: case_motion, contact_result
  use bw_case_strains, only: centrifugal_strain, largest_bending, placed_strain
  use bw_case_units, only: note_units
  use bw_constants, only: pi
  use bw_event, only: contact_event, event_type
  use bw_history_notes, only: negligible
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: scaled
  use bw_mode_set, only: damping_rates, mode_set
  use bw_note, only: remark
  use bw_reach, only: amplitude_of, stretch_type
  use bw_response, only: response_type
  use bw_rotation, only: speed_in_plane
  use bw_scene, only: changes_in_time, has_configurations, is_loaded, scene_type, unit_velocity
  use bw_text, only: append, shortest, string, text_of
  use bw_time_grid, only: time_grid, time_grid_of
  implicit none (type, external)
  private
  public :: note_validity

  integer, parameter :: looked_at = 20                        !! the first modes
  real(dp), parameter :: thickest = 0.1_dp                    !! largest D/l of a slender beam
  real(dp), parameter :: largest_deflection = 0.1_dp          !! over the length
  real(dp), parameter :: largest_strain = 0.005_dp
  real(dp), parameter :: largest_reported = 1.0e300_dp            !! largest strain in warnings: its per cent do not overflow

contains

  subroutine note_validity(scene, motion, response, contact, notes)
    !! Note the validity of the beam, and of its motion if a history is requested.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in), optional :: response      !! absent: no history is requested
    type(contact_result), intent(in), optional :: contact      !! absent: no contact lasts
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp), allocatable :: q(:), rate(:)         ! of the first modes
    integer :: moves
    allocate (q(0), rate(0))
    moves = motion%modes%moving
    if (allocated(motion%timeline%segments)) then
      if (size(motion%timeline%segments) > 0) moves = motion%timeline%segments(1)%configuration
    end if
    if (has_configurations(scene)) then
      call find_strongest(motion, moves, q, rate)
    else if (allocated(motion%initial%modal_velocity)) then
      rate = motion%initial%modal_velocity
      q = 0.0_dp*rate
    end if
    associate (modes => motion%modes%configuration(moves)%set)
      call note_units(scene, motion%units, modes, notes)
      call note_thickness(scene, notes)
      call note_rotation(centrifugal_strain(scene), notes)
      if (present(contact)) call note_contact(scene, motion%units, contact, motion%timeline%events, notes)
      if (.not. present(response)) return
      if (response%finite_samples == 0) return       ! another note explains it
      if (is_loaded(scene) .and. .not. allocated(scene%impact)) then
        call note_size(scene, largest_magnitude(response%displacement(:response%finite_samples, :)), placed_strain(), notes)
        return
      end if
      call note_amplitudes(scene, motion, modes, q, rate, &
                           largest_magnitude(response%displacement(:response%finite_samples, :)), notes)
      call note_return(scene, motion, response, notes)
    end associate
  end subroutine note_validity

  pure subroutine find_strongest(motion, configuration, q, rate)
    !! Find the segment with the most energy: its configuration and initial state.
    type(case_motion), intent(in) :: motion        !! of a beam that changes in time
    integer, intent(out) :: configuration
    real(dp), allocatable, intent(out) :: q(:), rate(:)
    real(dp) :: energy, largest
    integer :: i
    largest = -1.0_dp
    configuration = motion%modes%moving
    do i = 1, size(motion%timeline%segments)
      associate (segment => motion%timeline%segments(i))
        associate (modes => motion%modes%configuration(segment%configuration)%set)
          energy = sum(modes%modal_mass*(segment%rate**2 + abs(modes%beta_squared%hi)*segment%q**2))
        end associate
        if (energy <= largest) cycle
        largest = energy
        configuration = segment%configuration
        q = segment%q
        rate = segment%rate
      end associate
    end do
  end subroutine find_strongest

  subroutine note_return(scene, motion, response, notes)
    !! Note when a mass that rebounded, and is not followed, would strike again: the first sample at which it has
    !! passed the struck place, if that is one of the points.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    type(response_type), intent(in) :: response
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp) :: flight, step, spin                 ! V l²/h; l²/h; h/l²
    integer :: j, p
    if (changes_in_time(scene)) return
    p = findloc(scene%response%points, scene%impact%position, dim=1)
    if (allocated(scene%capture) .or. allocated(scene%recontact) .or. allocated(scene%contact)) return
    if (allocated(scene%hub) .or. p == 0) return
    if (scene%impact%mass_ratio == 0.0_dp .or. scene%impact%approach_velocity == 0.0_dp) return
    step = scene%response%duration/scene%response%samples/motion%units%time%hi
    spin = speed_in_plane(scene%rotation, motion%units)
    do j = 2, response%finite_samples
      flight = (j - 1)*step
      if (spin > 0.0_dp) flight = sinh(min(spin*flight, 700.0_dp))/spin
      flight = motion%initial%impact%mass_velocity*flight
      if (flight <= response%displacement(j, p)/(scene%impact%approach_velocity*motion%units%time%hi)) cycle
      call remark(notes, 'recontact: the rebounded mass would return at about t = '// &
                  shortest((j - 1)*step*motion%units%time%hi, 4)//' s; it strikes again only with &recontact')
      return
    end do
  end subroutine note_return

  subroutine note_contact(scene, units, found, events, notes)
    !! Warn if the hardest contact is shorter than the time in which shear crosses the section, or if the indentation is
    !! not small compared with the radius of the sphere.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(contact_result), intent(in) :: found
    type(event_type), intent(in) :: events(:)
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp), parameter :: largest_part = 0.1_dp   ! of the radius
    real(dp), parameter :: stretched = 1.612_dp    ! √(2(1 + ν)): the speed of longitudinal waves over that of shear, ν = 0.3
    real(dp) :: crossing
    integer :: i
    i = maxloc(abs(found%largest), dim=1, mask=events(:size(found%largest))%kind == contact_event)
    if (i == 0) return
    crossing = 4.0_dp*slenderness(scene%beam)**2*units%time%hi*stretched    ! thickness over √(G/ρ), √(E/ρ) being h over √(I/A)
    if (events(i)%end_time - events(i)%time < crossing) call append(notes, &
      'short contact: it lasts '//shortest(events(i)%end_time - events(i)%time, 3)//' s, less than the '// &
      shortest(crossing, 2)//' s in which a shear wave crosses the section: beam theory does not yet hold')
    if (scene%contact%radius > 0.0_dp .and. found%indentation > largest_part*scene%contact%radius) call append(notes, &
      'deep contact: the indentation reaches '//shortest(found%indentation, 3)//' m, more than a tenth of the radius, beyond '// &
      'which Hertz''s law does not hold')
  end subroutine note_contact

  pure subroutine note_thickness(scene, notes)
    !! Warn of a thick beam without shear.
    type(scene_type), intent(in) :: scene
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp) :: thickness
    thickness = 4.0_dp*slenderness(scene%beam)
    if (thickness <= thickest .or. allocated(scene%shear)) return
    call append(notes, 'thick beam: '//thickness_words(scene%beam)//' is '//shortest(thickness, 3)//' of the length, more than '// &
                'the 0.1 of a slender beam; its waves need &shear')
  end subroutine note_thickness

  pure subroutine note_rotation(found, notes)
    !! Warn if the centrifugal strain is large, with or without tension in the equations.
    type(placed_strain), intent(in) :: found
    type(string), allocatable, intent(inout) :: notes(:)
    if (found%strain <= largest_strain) return
    call append(notes, 'outside linear theory: the centrifugal force strains '//place_words(found)//' by about '// &
                shortest(100.0_dp*min(found%strain, largest_reported), 2)// &
                ' %, more than 0.5 %. Is angular_velocity in rad/s, not in rpm?')
  end subroutine note_rotation

  pure function place_words(found) result(words)
    !! Return where a strain is, in words.
    type(placed_strain), intent(in) :: found
    character(:), allocatable :: words
    words = 'the root'
    if (found%position > 0.0_dp) words = 'the beam at xi = '//shortest(found%position, 3)
  end function place_words

  pure function thickness_words(beam) result(words)
    !! Return which thickness is compared with the length, in words.
    type(beam_par), intent(in) :: beam
    character(:), allocatable :: words
    words = 'the diameter'
    if (.not. beam%round) words = '4 sqrt(I/A), the diameter of a circle,'
  end function thickness_words

  pure subroutine note_size(scene, peak, bending, notes)
    !! Warn in one note if deflection or strain is large. Beyond a deflection of the length, the strain is irrelevant.
    type(scene_type), intent(in) :: scene
    real(dp), intent(in) :: peak                   !! m
    type(placed_strain), intent(in) :: bending
    type(string), allocatable, intent(inout) :: notes(:)
    character(*), parameter :: limit = '; linear theory holds up to about '
    character(:), allocatable :: strained, text
    strained = 'bending strains '//place_words(bending)//' by about '// &
      shortest(100.0_dp*min(bending%strain, largest_reported), 2)//' %'
    associate (length => scene%beam%length, strain => bending%strain)
      if (peak > largest_deflection*length) then
        text = 'large deflection: up to '//shortest(peak, 3)//' m of a beam of '//shortest(length, 6)//' m'
        if (strain > largest_strain .and. peak <= length) then
          text = text//', and '//strained//limit//'a tenth of the length and 0.5 %'
        else
          text = text//limit//'a tenth of the length'
        end if
        call append(notes, text)
      else if (strain > largest_strain) then
        call append(notes, 'large strain: '//strained//limit//'0.5 %')
      end if
    end associate
  end subroutine note_size

  subroutine note_amplitudes(scene, motion, modes, q, rate, peak, notes)
    !! Check strain and sampling by the amplitudes of the first modes.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    class(mode_set), intent(in) :: modes           !! after t = 0, or of the strongest segment
    real(dp), intent(in) :: q(:), rate(:)          !! initial state
    real(dp), intent(in) :: peak                   !! of the displacement at all points, m
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp), parameter :: largest_shape = 2.0_dp
    type(placed_strain) :: bending
    type(time_grid) :: grid
    real(dp) :: amplitude(min(looked_at, modes%count)), c(modes%count)
    logical :: above(size(amplitude))              ! the Nyquist frequency
    real(dp) :: fast                               ! their largest amplitude
    integer :: n
    n = size(amplitude)
    c = damping_rates(modes)
    associate (units => motion%units, square => modes%beta_squared(:n))
      grid = time_grid_of(scene%response%duration, scene%response%samples, units%time)
      associate (step => grid%step%hi, unit => abs(unit_velocity(scene))*units%time%hi)
        amplitude = amplitude_of(square, c(:n), q(:n), rate(:n), stretch_type(0.0_dp, grid%samples*step, step), .false.)
        bending = largest_bending(scene, modes, amplitude)
        bending%strain = scaled(scaled(bending%strain, abs(unit_velocity(scene))), 1.0_dp/units%velocity)
        call note_size(scene, peak, bending, notes)
        above = sqrt(max(0.0_dp, square%hi))*step > pi
        fast = maxval(merge(amplitude, 0.0_dp, above))
        if (all(square%hi >= 0.0_dp) .and. largest_shape*fast*unit > negligible*peak) then
          call note_aliasing(scene, modes, amplitude, above, notes)
        end if
      end associate
    end associate
  end subroutine note_amplitudes

  subroutine note_aliasing(scene, modes, amplitude, above, notes)
    !! Warn of aliased modes whose amplitudes are not negligible in the displacement.
    type(scene_type), intent(in) :: scene
    class(mode_set), intent(in) :: modes           !! all stable
    real(dp), intent(in) :: amplitude(:)           !! of the first modes
    logical, intent(in) :: above(:)                !! above the Nyquist frequency
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp) :: moved(size(amplitude), size(scene%response%points)), part
    integer :: p, k
    if (scene%response%samples == 1) return
    moved = abs(modes%some_shapes(1, size(amplitude), scene%response%points))
    do p = 1, size(moved, 2)
      moved(:, p) = moved(:, p)*amplitude
    end do
    if (maxval(moved) == 0.0_dp) return
    part = maxval(moved, mask=spread(above, 2, size(moved, 2)))/maxval(moved)
    if (part <= negligible) return
    k = findloc(above, .true., dim=1)
    call append(notes, 'aliasing: modes from '//text_of(k)//' on, with up to '//shortest(100.0_dp*part, 2)//' % of the largest '// &
                'amplitude, are above the Nyquist frequency, '// &
                shortest(0.5_dp*scene%response%samples/scene%response%duration, 4)//' Hz, and are aliased to lower frequencies')
  end subroutine note_aliasing

end module bw_case_validity
