module bw_scene_groups
  !! The groups of a scene, in terms of their own files: rules, derived values, components of the scene, and words in a
  !! report.
  use bw_beam_par, only: beam_mass, build_beam, check_beam
  use bw_body_par, only: bodies_text, build_body, check_body, comes_or_leaves
  use bw_capture_par, only: capture_par, capture_text
  use bw_contact_par, only: build_contact, check_contact, check_contact_place, complete_contact, contact_text
  use bw_damping_par, only: build_damping, check_damping, damping_text, complete_damping
  use bw_frequency_response_par, only: build_frequency_response, check_frequency_response, complete_frequency_response
  use bw_hub_par, only: complete_hub, hub_par, hub_text
  use bw_identify_par, only: check_identify
  use bw_impact_par, only: build_impact, impact_text
  use bw_initial_par, only: build_initial, check_initial, initial_text
  use bw_input_name, only: has_word
  use bw_input_table, only: group_table
  use bw_input_values, only: group_values, position_of, positions_of
  use bw_kinds, only: dp
  use bw_load_par, only: build_load, check_load, complete_loads, load_par, loads_text
  use bw_mass_or_ratio, only: check_mass
  use bw_modes_par, only: build_modes, complete_modes
  use bw_recontact_par, only: recontact_par
  use bw_record_par, only: build_record, check_record, complete_record
  use bw_release_par, only: release_par, release_text
  use bw_response_par, only: build_response, check_limits, check_response
  use bw_rotation_par, only: build_rotation, rotation_text
  use bw_scene, only: has_parts, scene_type
  use bw_scene_messages, only: message_list
  use bw_scene_par, only: build_header
  use bw_shear_par, only: build_shear, check_shear, complete_shear, shear_text
  use bw_spectrum_par, only: build_spectrum, check_spectrum, complete_spectrum
  use bw_stiffening_par, only: stiffening_par, stiffening_text
  use bw_support_par, only: build_support, check_support, support_text
  use bw_sweep_par, only: check_sweep
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: build_scene, check_rules, check_rules_together, complete_groups, effects_text

  character(*), parameter :: movers(4) = [character(7) :: 'impact', 'initial', 'force', 'base']   !! groups that move the beam

contains

  pure subroutine build_scene(scene, messages)
    !! Check, complete and build the components of the groups of `scene%groups` that have changed; keep the others. Report
    !! derived numbers that overflow or underflow in double precision.
    type(scene_type), intent(inout) :: scene
    type(message_list), intent(inout) :: messages
    logical :: new, other_beam
    integer :: before, beam, g
    before = messages%count
    beam = position_of(scene%groups, 'beam')
    other_beam = .false.
    if (beam > 0) other_beam = scene%groups(beam)%changed
    if (other_beam) call build_beam(scene%groups(beam), scene%beam, messages)
    if (messages%count > before) return
    do g = 1, size(scene%groups)
      new = scene%groups(g)%changed
      if (.not. new .and. other_beam) new = any(scene%groups(g)%group == ['impact', 'body  ']) ! body masses depend on the beam's
      if (scene%groups(g)%group == 'contact') new = .true.   ! its law depends on the place of impact
      if (new) call build_group(scene, g, messages)
    end do
  end subroutine build_scene

  pure subroutine build_group(scene, g, messages)
    !! Build the component of one group; that of the beam exists already.
    type(scene_type), intent(inout) :: scene
    integer, intent(in) :: g                       !! place of the group in `scene%groups`
    type(message_list), intent(inout) :: messages
    select case (scene%groups(g)%group)
    case ('scene'); scene%header = build_header(scene%groups(g))
    case ('body', 'force', 'base'); call build_one(scene, g, messages)
    case ('support'); scene%support = build_support(scene%groups(g))
    case ('tip_support'); scene%tip_support = build_support(scene%groups(g))
    case ('hub'); scene%hub = hub_par(scene%groups(g)%number('rotary_inertia'), scene%groups(g)%number('radius'))
    case ('rotation'); scene%rotation = build_rotation(scene%groups(g))
    case ('stiffening'); scene%stiffening = stiffening_par(scene%groups(g)%number('hub_radius'))
    case ('shear'); scene%shear = build_shear(scene%groups(g))
    case ('damping'); scene%damping = build_damping(scene%groups(g))
    case ('impact'); call build_impact(scene%groups(g), beam_mass(scene%beam), scene%impact, messages)
    case ('contact')
      associate (impact => scene%groups(position_of(scene%groups, 'impact')))
        call build_contact(scene%groups(g), scene%beam, impact%number('position'), scene%contact)
      end associate
    case ('capture'); scene%capture = capture_par(scene%groups(g)%number('rotary_inertia'))
    case ('release'); scene%release = release_par(scene%groups(g)%number('time'))
    case ('recontact'); scene%recontact = recontact_par(scene%groups(g)%whole('max_contacts'))
    case ('initial'); scene%initial = build_initial(scene%groups(g))
    case ('modes'); scene%modes = build_modes(scene%groups(g))
    case ('response'); scene%response = build_response(scene%groups(g))
    case ('frequency_response'); scene%frequency_response = build_frequency_response(scene%groups(g))
    case ('record'); scene%record = build_record(scene%groups(g))
    case ('spectrum'); scene%spectrum = build_spectrum(scene%groups(g))
    case default                                   ! the beam was built before
    end select
  end subroutine build_group

  pure subroutine build_one(scene, g, messages)
    !! Build the component of one body, one force, or one motion of the base.
    type(scene_type), intent(inout) :: scene
    integer, intent(in) :: g                       !! place of the group in `scene%groups`
    type(message_list), intent(inout) :: messages
    integer :: n, i                                ! number of such groups, and index of this one
    associate (group => scene%groups(g), alike => positions_of(scene%groups, scene%groups(g)%group))
      n = size(alike)
      i = findloc(alike, g, dim=1)
      select case (group%group)
      case ('body')
        if (.not. allocated(scene%bodies)) allocate (scene%bodies(n))
        call build_body(group, beam_mass(scene%beam), scene%bodies(i), messages)
      case ('force')
        if (.not. allocated(scene%forces)) allocate (scene%forces(n))
        scene%forces(i)%load_par = build_load(group)
        scene%forces(i)%position = group%number('position')
      case default
        if (.not. allocated(scene%bases)) allocate (scene%bases(n))
        scene%bases(i) = build_load(group)
      end select
    end associate
  end subroutine build_one

  pure subroutine check_rules(group, messages)
    !! Check the rules of a group's own names, apart from those in the table of names.
    type(group_values), intent(in) :: group
    type(message_list), intent(inout) :: messages
    select case (group%group)
    case ('beam'); call check_beam(group, messages)
    case ('support'); call check_support(group, messages)
    case ('body'); call check_body(group, messages)
    case ('damping'); call check_damping(group, messages)
    case ('impact'); call check_mass(group, 0, '', messages)
    case ('contact'); call check_contact(group, messages)
    case ('force', 'base'); call check_load(group, messages)
    case ('initial'); call check_initial(group, messages)
    case ('response'); call check_response(group, messages)
    case ('record'); call check_record(group, messages)
    case ('identify'); call check_identify(group, messages)
    case ('sweep'); call check_sweep(group, messages)
    case default                                   ! the others have no rules of their own
    end select
  end subroutine check_rules

  pure subroutine check_rules_together(groups, messages)
    !! Check the rules between groups, apart from their needs.
    type(group_values), intent(in) :: groups(:)    !! without &sweep
    type(message_list), intent(inout) :: messages
    call check_shear(groups, messages)
    call check_spectrum(groups, messages)
    call check_frequency_response(groups, messages)
    call check_contact_place(groups, messages)
    call check_limits(groups, messages)
    call check_timeline(groups, messages)
  end subroutine check_rules_together

  pure subroutine check_timeline(groups, messages)
    !! Check bodies that come or leave, and initial conditions, against other groups; and that something moves the beam.
    type(group_values), intent(in) :: groups(:)
    type(message_list), intent(inout) :: messages
    character(*), parameter :: elsewhere(2) = [character(9) :: 'recontact', 'record']
    integer :: g, i, response
    logical :: moves, timed
    moves = any([(position_of(groups, trim(movers(i))) > 0, i=1, size(movers))])
    do g = 1, size(groups)
      timed = groups(g)%group == 'initial'
      if (groups(g)%group == 'body') then
        moves = moves .or. groups(g)%given('velocity')
        timed = groups(g)%given('from') .or. groups(g)%given('until')
      end if
      if (.not. timed) cycle
      do i = 1, size(elsewhere)
        if (position_of(groups, trim(elsewhere(i))) == 0) cycle
        if (has_word(group_table(groups(g)%row)%excludes, trim(elsewhere(i)))) cycle      ! reported already
        call messages%add(groups(g)%line, '&'//trim(groups(g)%group), 'begins a motion that changes in time, which excludes &'// &
                          trim(elsewhere(i))//' of line '//text_of(groups(position_of(groups, trim(elsewhere(i))))%line)// &
                          '; accepted: without one of them, or &body without from and until')
      end do
    end do
    response = position_of(groups, 'response')
    if (response > 0 .and. .not. moves) call messages%add(groups(response)%line, '&response', 'nothing moves the beam; '// &
      'accepted: with &impact, &force, &base, &initial, or a &body with a velocity')
  end subroutine check_timeline

  pure subroutine complete_groups(groups, messages)
    !! Fill in derived values of changed groups; they may differ from case to case.
    type(group_values), intent(inout) :: groups(:)   !! of one case
    type(message_list), intent(inout) :: messages
    logical :: struck, captured, lasting, loaded, timed
    integer :: g
    do g = 1, size(groups)
      if (.not. groups(g)%changed) cycle
      select case (groups(g)%group)
      case ('damping'); call complete_damping(groups(g))
      case ('shear'); call complete_shear(groups)
      case ('frequency_response'); call complete_frequency_response(groups, g)
      case ('contact'); call complete_contact(groups)
      case ('initial')
        if (.not. groups(g)%known('force')) call groups(g)%drop('position')     ! the place of that force
      case ('hub', 'stiffening'); call complete_hub(groups)
      case ('force', 'base'); call complete_loads(groups, messages)
      case ('record'); call complete_record(groups, messages)
      case ('spectrum'); call complete_spectrum(groups(g), has_parts(groups))
      case ('modes')
        struck = position_of(groups, 'impact') > 0
        captured = struck .and. position_of(groups, 'capture') > 0
        lasting = struck .and. position_of(groups, 'contact') > 0
        loaded = position_of(groups, 'force') > 0 .or. position_of(groups, 'base') > 0
        timed = comes_or_leaves(groups)
        lasting = lasting .or. (.not. struck .and. (loaded .or. timed .or. position_of(groups, 'initial') > 0))
        call complete_modes(groups(g), struck .and. .not. (captured .or. lasting), captured .or. timed, lasting, &
                            position_of(groups, 'response') > 0, messages)
      case default                                   ! no derived values
      end select
    end do
  end subroutine complete_groups

  pure function effects_text(scene) result(text)
    !! Return the effects and events of a scene with their numbers, for a report.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: text
    integer :: i, g
    text = ''
    do i = 1, size(group_table)
      g = position_of(scene%groups, group_table(i)%name)
      if (g == 0) cycle
      select case (group_table(i)%name)
      case ('support', 'tip_support'); text = text//', '//support_text(scene%groups(g))
      case ('hub'); text = text//', '//hub_text(scene%groups(g))
      case ('body'); text = text//', '//bodies_text(scene%groups)
      case ('rotation'); text = text//', '//rotation_text(scene%groups(g))
      case ('stiffening'); text = text//', '//stiffening_text(scene%groups(g))
      case ('shear'); text = text//', '//shear_text(scene%groups(g))
      case ('damping'); text = text//', '//damping_text(scene%groups(g))
      case ('impact')
        text = text//', '//impact_text(scene%groups(g), scene%impact, allocated(scene%contact))
        if (.not. (allocated(scene%capture) .or. allocated(scene%contact))) text = text//', '// &
          trim(merge('no capture', 'rebound   ', scene%groups(g)%number('restitution') == 0.0_dp .and. &
                     .not. scene%groups(g)%is_swept('restitution')))
      case ('contact'); text = text//', '//contact_text(scene%groups(g), scene%contact, size(scene%sweeps) == 0)
      case ('capture'); text = text//', '//capture_text(scene%groups(g))
      case ('release'); text = text//', '//release_text(scene%groups(g))
      case ('recontact'); text = text//', recontact'
      case ('force', 'base'); text = text//', '//loads_text(scene%groups, trim(group_table(i)%name))
      case ('initial'); text = text//', '//initial_text(scene%groups(g))
      case default                                   ! no effect
      end select
    end do
    if (text == '') text = ', none: modes and wave velocities of the beam alone'
    text = text(3:)
  end function effects_text

end module bw_scene_groups
