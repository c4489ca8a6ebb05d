module bw_case_notes
  !! Notes on a case besides its numbers: warnings, and remarks on how it was computed.
  use bw_beam_units, only: beam_units, in_joules
  use bw_case_result, only: case_done, case_ill_conditioned, case_motion, contact_result
  use bw_constants, only: pi
  use bw_damping, only: law_of
  use bw_damping_par, only: by_ratio
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_mode_set, only: mode_set, mode_source, search_failure
  use bw_modes_par, only: default_tolerance, is_relaxed, relaxed_tolerance
  use bw_note, only: is_remark, kind_of, remark
  use bw_piece_set, only: piece_set
  use bw_recontact, only: contacts_type
  use bw_release, only: release_type
  use bw_scene, only: scene_type
  use bw_segment, only: together
  use bw_strain_set, only: strain_set
  use bw_text, only: append, shortest, string, text_of
  use bw_timeline, only: is_released
  implicit none (type, external)
  private
  public :: note_coupling, note_empty_bodies, note_failure, note_growth, note_no_effect, note_unresolved
  public :: note_added_energy, note_contacts, note_lasting_contacts, note_relaxed, note_release, note_rounding
  public :: most_of, out_of_reach, why_untrusted

  integer, parameter, public :: most_modes = 10000000      !! that a tolerance may sum
  integer, parameter, public :: most_released = 10000
    !! after a change, where projections are onto each mode from each mode before
  real(dp), parameter :: rpm = 30.0_dp/pi    !! turns a minute in 1 rad/s
  real(dp), parameter :: noteworthy = 1.0e6_dp     !! amplification that leaves nothing of data with six digits

contains

  subroutine note_coupling(scene, units, modes, notes)
    !! Note the coupling of modes by Rayleigh damping, which is diagonal only without tension and rotation.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes           !! in force after t = 0
    type(string), allocatable, intent(inout) :: notes(:)
    real(dp), parameter :: nothing = 1.0e-9_dp     ! rounding of orthogonal modes
    real(dp), parameter :: worth_a_warning = 0.01_dp
    character(:), allocatable :: text
    real(dp) :: ratio
    if (.not. allocated(scene%damping)) return
    if (by_ratio(scene%damping)) return
    ratio = 0.0_dp
    select type (modes)
    class is (strain_set)
      ratio = modes%coupling(law_of(scene%damping, units))
    type is (piece_set)
      ratio = modes%coupling(law_of(scene%damping, units))
    end select
    text = 'coupled damping: Rayleigh damping couples these modes, which is neglected: the coupling is at most '// &
      shortest(ratio, 2)//' of the modes'' own damping'
    if (ratio > worth_a_warning) then
      call append(notes, text)
    else if (ratio > nothing) then
      call remark(notes, text)
    end if
  end subroutine note_coupling

  subroutine note_growth(units, modes, notes, which)
    !! Note unstable modes.
    type(beam_units), intent(in) :: units
    class(mode_set), intent(in) :: modes           !! in force after t = 0
    type(string), allocatable, intent(inout) :: notes(:)
    character(*), intent(in), optional :: which    !! words after `modes`; absent: those after t = 0
    character(:), allocatable :: reason, of
    integer :: growing
    of = ''
    if (present(which)) of = which
    growing = count(modes%beta_squared%hi < 0.0_dp)
    if (growing == 0) return
    reason = 'since the angular velocity is above '//shortest(modes%critical_speed%hi*units%frequency, 6)//' rad/s ('// &
      shortest(modes%critical_speed%hi*units%frequency*rpm, 4)//' rpm)'
    if (modes%grows_at_any_speed) reason = 'at any angular velocity: the beam can turn about its root, and nothing restores it'
    call append(notes, 'unstable: '//text_of(growing)//' of '//text_of(modes%count)//' modes'//of//' grow without bound, '//reason)
  end subroutine note_growth

  subroutine note_no_effect(notes)
    !! Note that rotation has no effect.
    type(string), allocatable, intent(inout) :: notes(:)
    call append(notes, 'no effect: rotation out of plane changes nothing in this model, which has neither tension nor shear')
  end subroutine note_no_effect

  subroutine note_empty_bodies(scene, notes)
    !! Note bodies without effect.
    type(scene_type), intent(in) :: scene
    type(string), allocatable, intent(inout) :: notes(:)
    integer :: b
    if (.not. allocated(scene%bodies)) return
    do b = 1, size(scene%bodies)
      associate (body => scene%bodies(b))
        if (any([body%mass, body%rotary_inertia, body%stiffness, body%rotational_stiffness] > 0.0_dp)) cycle
        call append(notes, 'no effect: the body at xi = '//shortest(body%position, 15)// &
                    ' has neither mass nor inertia, and no spring holds it')
      end associate
    end do
  end subroutine note_empty_bodies

  subroutine note_unresolved(why, notes)
    !! Note that the modes of a beam are invalid.
    character(*), intent(in) :: why
    type(string), allocatable, intent(inout) :: notes(:)
    call append(notes, 'not converged: '//why//'; all numbers of the case are missing')
  end subroutine note_unresolved

  subroutine note_failure(failure, lost, notes)
    !! Note that a mode was not found among those that are found in turn and not stored.
    type(search_failure), intent(in) :: failure
    character(*), intent(in) :: lost               !! what is not given therefore
    type(string), allocatable, intent(inout) :: notes(:)
    call append(notes, 'not converged: one of the modes '//text_of(failure%first)//' to '//text_of(failure%last)// &
                ' was not found; '//lost)
  end subroutine note_failure

  subroutine note_added_energy(scene, motion)
    !! Note the energy added with e > 0, as the interface conditions 22–26 give the mass the tip's velocity.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion   !! impact and capture are in its timeline
    if (scene%impact%restitution == 0.0_dp) return
    associate (impact => motion%timeline%events(1), capture => motion%timeline%events(2), &
               approach => motion%timeline%events(1)%energy_before)
      if (approach == 0.0_dp .or. scene%impact%approach_velocity == 0.0_dp) return
      call append(motion%notes, 'added energy: restitution '//shortest(scene%impact%restitution, 6)// &
        ' with capture: the interface conditions give the rebounded mass the velocity of the tip, which adds the momentum '// &
        shortest((capture%momentum_after - capture%momentum_before)/impact%momentum_before, 4)// &
        ' and the energy '//shortest((capture%energy_after - capture%energy_before)/approach, 4)// &
        ' of the approaching mass; beam and mass then have '//shortest(capture%energy_after/approach, 4)// &
        ' of its energy')
    end associate
  end subroutine note_added_energy

  subroutine note_release(scene, release, motion)
    !! Note the energy balance of a release.
    type(scene_type), intent(in) :: scene
    type(release_type), intent(in) :: release
    type(case_motion), intent(inout) :: motion
    character(:), allocatable :: text
    real(dp) :: joules(4)
    joules = in_joules([release%kinetic_leaving, release%energy_leaving, release%event%energy_before, release%energy_lost], &
                       motion%units, scene%impact%approach_velocity)
    if (is_missing(joules(1))) then
      call append(motion%notes, 'energy of the release: too large for double precision')
      return
    end if
    text = 'energy of the release: the mass leaves with '//shortest(joules(1), 4)//' J of kinetic energy'
    if (.not. is_missing(joules(2))) text = text//' ('//shortest(joules(2), 4)//' J with the potential of the centrifugal force)'
    if (.not. is_missing(joules(3))) text = text//' of '//shortest(joules(3), 4)//' J in total'
    if (.not. (is_missing(joules(4)) .or. allocated(motion%plan%survey))) then
      text = text//'; the modes of the beam alone lack '//shortest(joules(4), 2)//' J'
    end if
    call remark(motion%notes, text)
  end subroutine note_release

  subroutine note_rounding(motion)
    !! Note energies lost in cancellation.
    type(case_motion), intent(inout) :: motion
    if (.not. any(is_missing([motion%timeline%events%energy_before, motion%timeline%events%energy_after]))) return
    call append(motion%notes, 'energy lost in rounding: after unstable growth it is a small difference of large numbers, and '// &
                'it is missing where fewer than three digits remain')
  end subroutine note_rounding

  subroutine note_contacts(scene, contacts, motion)
    !! Note how the search for contacts ended.
    type(scene_type), intent(in) :: scene
    type(contacts_type), intent(in) :: contacts
    type(case_motion), intent(inout) :: motion
    if (contacts%cut) call append(motion%notes, 'contacts used up: max_contacts is '//text_of(scene%recontact%max_contacts)// &
      ', and the mass strikes once more at t = '//known_until()//' s: the histories are missing from there on. Use '// &
      'max_contacts = '//text_of(2*scene%recontact%max_contacts)//', or duration = '//known_until())
    if (contacts%lasting) call remark(motion%notes, &
      'recontact: the last contact has not ended at the end of the record')
    if (contacts%out_of_range) call append(motion%notes, &
      'recontact: the motion grows beyond the range of double precision'//from_then_on())
    if (motion%ending == case_ill_conditioned) call append(motion%notes, &
      'ill-conditioned: after '//text_of(size(contacts%events))//' contacts, which amplify every error, the motion is unknown'// &
      from_then_on())
    if (contacts%amplification > noteworthy) call append(motion%notes, &
      'amplification: the contacts amplify every change of the data, '//shortest(contacts%amplification, 1)//' times in the '// &
      'end: a real beam, whose data are known less accurately, may move differently')
    if (any(is_missing(contacts%events%energy_after))) call append(motion%notes, &
      'energy: in a growing motion the energies of the last events have fewer than three digits, and are missing')
    if (size(contacts%events) == 0 .and. motion%ending == case_done) call remark(motion%notes, &
      'recontact: the mass does not come back within the record')
  contains
    pure function from_then_on() result(text)
      !! Return from when on the motion is unknown, in words.
      character(:), allocatable :: text
      text = ' from t = '//known_until()//' s on: the histories are missing from there, and later contacts are not listed'
    end function from_then_on
    pure function known_until() result(seconds)
      !! Return that time, s.
      character(:), allocatable :: seconds
      seconds = shortest(max(0.0_dp, motion%timeline%known_until)*motion%units%time%hi, 6)
    end function known_until
  end subroutine note_contacts

  subroutine note_lasting_contacts(scene, motion, found, cut, out_of_range, failed)
    !! Note how lasting contacts ended.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(inout) :: motion
    type(contact_result), intent(in) :: found
    logical, intent(in) :: cut, out_of_range, failed
    if (cut) call append(motion%notes, 'contacts used up: max_contacts is '//text_of(scene%contact%max_contacts)// &
      ', and the mass strikes once more at t = '//until()//' s: the histories are missing from there on. Use max_contacts = '// &
      text_of(2*scene%contact%max_contacts)//', or duration = '//until())
    if (out_of_range) call append(motion%notes, 'overflow: the motion grows beyond the range of double precision from t = '// &
      until()//' s on: the histories are missing from there')
    if (failed) call append(motion%notes, 'not converged: no force was found that satisfies the contact law at t = '//until()// &
      ' s; the histories are missing from there on')
    if (found%lasting) call remark(motion%notes, 'contact: the last contact has not ended at the end of the record')
  contains
    pure function until() result(seconds)
      !! Return when the histories end, s; the notes that use it imply such a time.
      character(:), allocatable :: seconds
      seconds = shortest(max(0.0_dp, motion%timeline%known_until)*motion%units%time%hi, 6)
    end function until
  end subroutine note_lasting_contacts

  pure function why_untrusted(notes) result(reason)
    !! Return the first of a case's notes that explains its status; every case that is not done has one.
    type(string), intent(in) :: notes(:)
    character(:), allocatable :: reason
    character(*), parameter :: kinds(*) = &
      [character(16) :: 'not converged', 'tolerance', 'overflow', 'ill-conditioned', 'recontact', 'contacts used up']
    integer :: i, k
    do k = 1, size(kinds)
      do i = 1, size(notes)
        if (is_remark(notes(i)%text) .or. kind_of(notes(i)%text) /= kinds(k)) cycle
        reason = notes(i)%text
        return
      end do
    end do
    reason = 'some of its numbers are missing'
  end function why_untrusted

  pure integer function most_of(scene, source) result(most)
    !! Return how many modes a tolerance may sum; a default one only those that are found quickly.
    type(scene_type), intent(in) :: scene
    class(mode_source), intent(in) :: source
    most = min(most_modes, source%at_most)
    if (.not. scene%modes%asked) most = min(most, source%quickly)
  end function most_of

  pure function out_of_reach(scene, motion) result(text)
    !! Explain a tolerance that cannot be met.
    type(scene_type), intent(in) :: scene
    type(case_motion), intent(in) :: motion
    character(:), allocatable :: text
    associate (plan => motion%plan, source => motion%modes%configuration(together)%source)
      text = repeat('the default ', merge(0, 1, scene%modes%asked))//shortest(scene%modes%tolerance, 6)// &
        ' cannot be reached with '//text_of(min(most_of(scene, source), source%highest))//' modes'
      if (is_released(scene)) text = text//' before the release and '//text_of(min(most_released, source%highest))//' after it'
      if (plan%drift > 0.5_dp*plan%reached) text = text//': in so long a record most of the error is due to the rounding of '// &
        'their frequencies under tension'
      if (.not. is_missing(relaxed_tolerance(plan%surely))) then
        text = text//'; accepted: '//shortest(plan%named(), 2)//' or more, or counts of modes (before and after)'
      else
        text = text//', nor can any other: the points move too little; accepted: other points or a longer duration'
      end if
    end associate
  end function out_of_reach

  subroutine note_relaxed(scene, notes)
    !! Note that the default tolerance was out of reach.
    type(scene_type), intent(in) :: scene
    type(string), allocatable, intent(inout) :: notes(:)
    if (is_relaxed(scene%modes)) call remark(notes, 'tolerance: relaxed for the displacement to '// &
      shortest(scene%modes%tolerance, 6)//' of its peak; the default '//shortest(default_tolerance, 6)//' is out of reach')
  end subroutine note_relaxed

end module bw_case_notes
