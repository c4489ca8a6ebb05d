module bw_recontact
  !! A mass that rebounded strikes the tip again: contacts in order, each an impact with restitution e, until the record
  !! ends. Contacts that follow each other ever faster become one that lasts: beam and mass then move in the modes of
  !! bw_contact_modes until the force between them falls to zero.
  !!
  !! Contacts amplify errors, as a mass that bounces off a moving body does: twofold and more each. The motion is therefore
  !! followed in binary128, together with what its errors become (bw_perturbations), and no further than something is known
  !! of it: until the tip's displacement has fewer than three digits, or until it is open whether the mass touches the tip. Nor is
  !! it followed into a contact beyond the number that is asked for.
  !!
  !! The gap is v_tip − y ≥ 0. Units of bw_segment: times in l²/h, velocities in V, displacements in V l²/h.
  use bw_contact_modes, only: contact_set, find_contact_modes
  use bw_contact_motion, only: contact_motion, motion_of
  use bw_contact_segments, only: follow_contact, follow_flight, judge_rebound, leaves, slow, stays, undecided
  use bw_event, only: contact_event, event_type
  use bw_kinds, only: dp, qp
  use bw_missing, only: rounded
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, stops
  use bw_next_zero, only: certain, in_doubt, never
  use bw_perturbations, only: error_from
  use bw_segment, only: growth_ends, largest_exponent, segment_type
  implicit none (type, external)
  private
  public :: follow_contacts

  type, public :: contacts_type
    !! What became of the mass.
    type(event_type), allocatable :: events(:)       !! contacts, in order
    type(segment_type), allocatable :: segments(:)   !! of the motion, in order
    type(contact_set), allocatable :: modes          !! unallocated where no contact lasted
    real(dp) :: known_until = huge(1.0_dp)        !! from then on nothing is known
    logical :: out_of_range = .false.             !! since the motion grows out of the range of numbers then
    logical :: cut = .false.                      !! since a contact more than were asked for begins then
    logical :: lasting = .false.                  !! the last contact had not ended when the record did
    real(dp) :: amplification = 1.0_dp            !! by the contacts, of a relative change of what the motion follows from
    real(dp), private :: sway = 0.0_dp            !! the largest the tip's displacement may have been
    real(dp), private :: data_error = 1.0_dp      !! what the error of the motion would be if nothing amplified it
  end type contacts_type

contains

  subroutine follow_contacts(free, mass_ratio, restitution, omega, longest, most, contacts, monitor)
    !! From the impact on, with the mass arriving at a beam at rest.
    class(mode_set), intent(in) :: free           !! modes of the beam alone, found for a record without end
    real(qp), intent(in) :: mass_ratio            !! γ > 0
    real(dp), intent(in) :: restitution           !! e
    real(qp), intent(in) :: omega                 !! angular velocity in the plane of the motion, else 0
    real(dp), intent(in) :: longest               !! the record
    integer, intent(in) :: most                   !! contacts that are followed
    type(contacts_type), intent(out) :: contacts
    class(monitor_type), intent(inout), optional :: monitor   !! what is found means nothing where it asks to stop
    type(contact_motion) :: motion
    type(event_type) :: event
    real(dp) :: impact, last
    integer :: opening, outcome, verdict
    motion = motion_of(free, mass_ratio, restitution, omega)
    contacts%data_error = error_from([motion%data_error()])
    last = min(longest, growth_ends(free))
    if (omega > 0.0_qp) last = min(last, largest_exponent/real(omega, dp))
    allocate (contacts%events(0), contacts%segments(0))
    call motion%strike(impact)                    ! which is another event
    event = started_event(motion)
    verdict = judge_rebound(motion, longest)
    do
      if (stops(monitor)) return
      opening = first_opening(motion)
      if (verdict == undecided) then
        outcome = in_doubt
        contacts%known_until = event%time - event%time_error
        exit
      else if (verdict == stays) then
        call add_contact(free, motion, last, event, contacts, outcome, monitor)
        if (outcome /= certain) exit
        opening = 3                               ! for the force between beam and mass, the second, has gone to zero
      end if
      call add_flight(free%struck, motion, opening, last, most, contacts, outcome, monitor)
      if (outcome /= certain .or. contacts%cut) exit
      event = started_event(motion)
      call motion%strike(event%impulse)
      verdict = judge_rebound(motion, longest)
      if (verdict /= leaves) cycle
      call end_event(motion, event)
      contacts%events = [contacts%events, event]
    end do
    if (outcome == never .and. last < longest) then
      contacts%out_of_range = .true.
      contacts%known_until = last
      if (contacts%lasting) contacts%events = contacts%events(:size(contacts%events) - 1)     ! its end is beyond that
      contacts%lasting = .false.
    end if
  end subroutine follow_contacts

  subroutine add_contact(free, motion, last, event, contacts, outcome, monitor)
    !! A contact that lasts: an event and a segment more, or `known_until` where the event's end is not known.
    class(mode_set), intent(in) :: free
    type(contact_motion), intent(inout) :: motion
    real(dp), intent(in) :: last                  !! the end of the search
    type(event_type), intent(inout) :: event      !! as it began
    type(contacts_type), intent(inout) :: contacts
    integer, intent(out) :: outcome               !! certain where the contact ends before the search
    class(monitor_type), intent(inout), optional :: monitor
    type(segment_type) :: segment
    real(qp) :: impulse
    real(dp) :: sway
    logical :: worthless
    if (.not. allocated(contacts%modes)) then
      allocate (contacts%modes)
      call find_contact_modes(free, motion, contacts%modes, monitor)
    end if
    outcome = in_doubt
    if (stops(monitor)) return
    call follow_contact(motion, contacts%modes, real(last - motion%state%time, dp), outcome, impulse, segment, sway, monitor)
    call judge(contacts%modes%struck, segment, sway, contacts, worthless)
    if (outcome == in_doubt .or. worthless) then
      outcome = in_doubt
      contacts%known_until = event%time - event%time_error
      return
    end if
    event%impulse = rounded(event%impulse + impulse)
    call end_event(motion, event)
    contacts%lasting = outcome == never
    call add_segment(segment, contacts%segments)
    contacts%events = [contacts%events, event]
  end subroutine add_contact

  subroutine add_flight(tip, motion, opening, last, most, contacts, outcome, monitor)
    !! A free flight: a segment more, and `known_until` where nothing is known of it or of what follows.
    real(dp), intent(in) :: tip(:)                !! Φ_k(1) of the beam alone, (modes)
    type(contact_motion), intent(inout) :: motion
    integer, intent(in) :: opening                !! the first derivative of the gap that is not zero
    real(dp), intent(in) :: last                  !! the end of the search
    integer, intent(in) :: most                   !! contacts that are followed
    type(contacts_type), intent(inout) :: contacts
    integer, intent(out) :: outcome               !! certain where a contact ends it
    class(monitor_type), intent(inout), optional :: monitor
    type(segment_type) :: segment
    real(dp) :: sway
    logical :: worthless
    call follow_flight(motion, opening, real(last - motion%state%time, dp), outcome, segment, sway, monitor)
    call judge(tip, segment, sway, contacts, worthless)
    if (worthless) then
      outcome = in_doubt
      contacts%known_until = segment%start%hi - segment%start_error
      return
    end if
    contacts%cut = outcome == certain .and. size(contacts%events) == most
    if (outcome == in_doubt) contacts%known_until = real(motion%state%time, dp)
    if (contacts%cut) contacts%known_until = real(motion%state%time, dp) - error_from(motion%near%lag)
    call add_segment(segment, contacts%segments)
  end subroutine add_flight

  pure subroutine add_segment(segment, segments)
    !! Add a segment to a list. The arrays of the others are handed on, not copied.
    type(segment_type), intent(in) :: segment
    type(segment_type), allocatable, intent(inout) :: segments(:)
    type(segment_type), allocatable :: more(:)
    integer :: i
    allocate (more(size(segments) + 1))
    do i = 1, size(segments)
      more(i)%configuration = segments(i)%configuration
      more(i)%count = segments(i)%count
      more(i)%start = segments(i)%start
      more(i)%start_error = segments(i)%start_error
      call move_alloc(segments(i)%q, more(i)%q)
      call move_alloc(segments(i)%rate, more(i)%rate)
      call move_alloc(segments(i)%error, more(i)%error)
    end do
    more(size(more)) = segment
    call move_alloc(more, segments)
  end subroutine add_segment

  pure integer function first_opening(motion) result(order)
    !! The first derivative of the gap that is not zero after a blow.
    type(contact_motion), intent(in) :: motion
    order = merge(1, 2, motion%separation() > slow)
  end function first_opening

  subroutine judge(tip, segment, sway, contacts, worthless)
    !! How much of the tip's displacement is known in a segment, of the largest that there has been.
    real(dp), intent(in) :: tip(:)                !! Φ_k(1), (modes)
    type(segment_type), intent(in) :: segment
    real(dp), intent(in) :: sway                  !! the largest in the segment
    type(contacts_type), intent(inout) :: contacts
    logical, intent(out) :: worthless             !! fewer than three digits
    real(dp), parameter :: three_digits = 1.0e-3_dp
    real(dp) :: error
    contacts%sway = max(contacts%sway, sway)
    error = sum(abs(tip)*segment%error(:, 1))
    worthless = error > three_digits*contacts%sway
    if (worthless .or. contacts%sway == 0.0_dp) return                 ! below the range of numbers nothing is amplified
    contacts%amplification = error/contacts%sway/contacts%data_error
  end subroutine judge

  type(event_type) function started_event(motion) result(event)
    !! What there is before a blow.
    type(contact_motion), intent(in) :: motion
    event%kind = contact_event
    event%time = real(motion%state%time, dp)
    event%time_error = error_from(motion%near%lag)
    event%energy_before = motion%energy()
    event%momentum_before = rounded(motion%momentum())
  end function started_event

  subroutine end_event(motion, event)
    !! What there is after it.
    type(contact_motion), intent(in) :: motion
    type(event_type), intent(inout) :: event
    event%end_time = real(motion%state%time, dp)
    event%end_error = error_from(motion%near%lag)
    event%energy_after = motion%energy()
    event%momentum_after = rounded(motion%momentum())
  end subroutine end_event

end module bw_recontact
