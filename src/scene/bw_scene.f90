module bw_scene
  !! A scene as plain data in SI units: one component per input group, unallocated if the group is absent. The file of each
  !! group provides its rules, derived values, component and words in a report; this module calls them.
  use bw_beam_par, only: beam_mass, beam_par, build_beam, check_beam
  use bw_body_par, only: bodies_text, body_par, build_body, check_body, comes_or_leaves
  use bw_capture_par, only: capture_par, capture_text
  use bw_contact_par, only: build_contact, check_contact, check_contact_place, complete_contact, contact_par, contact_text
  use bw_damping_par, only: build_damping, by_ratio, check_damping, damping_par, damping_text, complete_damping
  use bw_design_par, only: design_par
  use bw_frequency_response_par, only: build_frequency_response, check_frequency_response, complete_frequency_response, &
    frequency_response_par
  use bw_hub_par, only: complete_hub, hub_par, hub_text
  use bw_identify_par, only: check_identify, identify_par
  use bw_impact_par, only: build_impact, impact_par, impact_text
  use bw_initial_par, only: build_initial, check_initial, initial_par, initial_text
  use bw_input_name, only: has_word, is_simulated
  use bw_input_table, only: group_table, name_table
  use bw_input_values, only: group_values, input_value, position_of, positions_of
  use bw_kinds, only: dp, i8
  use bw_load_par, only: build_load, check_load, complete_loads, force_par, load_par, loads_text
  use bw_mass_or_ratio, only: check_mass
  use bw_missing, only: is_missing
  use bw_modes_par, only: build_modes, by_tolerance, modes_par, complete_modes
  use bw_record_par, only: build_record, check_record, record_par, complete_record
  use bw_recontact_par, only: recontact_par
  use bw_release_par, only: release_par, release_text
  use bw_response_par, only: build_response, check_limits, check_response, response_par
  use bw_rotation_par, only: build_rotation, rotation_par, rotation_text
  use bw_scene_messages, only: message_list
  use bw_scene_par, only: build_header, scene_par
  use bw_shear_par, only: build_shear, check_shear, complete_shear, shear_par, shear_text
  use bw_spectrum_par, only: build_spectrum, check_spectrum, complete_spectrum, spectrum_par
  use bw_stiffening_par, only: stiffening_par, stiffening_text
  use bw_support_par, only: build_support, check_support, support_par, support_text
  use bw_sweep_par, only: check_sweep, sweep_par
  use bw_text, only: text_of
  implicit none (type, external)
  private
  public :: build_scene, check_rules, check_rules_together, complete_groups
  public :: answers_by_modes, by_pieces, changes_shapes, count_methods, varies_along_pieces, effect_names, effects_text, &
    at_start, bodies_change, changes_in_time, converges_in_run, has_configurations, has_parts, is_built_up, is_loaded, is_planned, &
    method_name, unit_velocity

  type, public :: scene_type
    !! The content of one scene file. With sweeps, the components are those of the first case.
    character(:), allocatable :: file             !! path as the user gave it
    character(:), allocatable :: name             !! stem of the file, the name of the result
    type(scene_par) :: header                     !! &scene
    type(beam_par) :: beam                        !! &beam; of length 0 if only a record is analysed
    type(support_par), allocatable :: support     !! &support; absent: the root is clamped
    type(support_par), allocatable :: tip_support !! &tip_support; absent: the tip is free
    type(hub_par), allocatable :: hub             !! &hub; absent: the hub's motion is prescribed
    type(body_par), allocatable :: bodies(:)      !! &body, in the order of the scene, (n); unallocated: none
    type(rotation_par), allocatable :: rotation   !! &rotation; absent: the beam does not rotate
    type(stiffening_par), allocatable :: stiffening   !! &stiffening; absent: no tension
    type(shear_par), allocatable :: shear         !! &shear; absent: Euler–Bernoulli
    type(damping_par), allocatable :: damping     !! &damping; absent: undamped
    type(impact_par), allocatable :: impact       !! &impact; absent: modes and wave velocities only
    type(contact_par), allocatable :: contact     !! &contact; absent: the blow is instantaneous
    type(capture_par), allocatable :: capture     !! &capture; absent: the mass rebounds
    type(release_par), allocatable :: release     !! &release; absent: a captured mass stays
    type(recontact_par), allocatable :: recontact !! &recontact; absent: a rebounded mass never returns
    type(force_par), allocatable :: forces(:)     !! &force, in the order of the scene; unallocated: none
    type(load_par), allocatable :: bases(:)       !! &base, likewise
    type(initial_par), allocatable :: initial     !! &initial; absent: the beam is straight and at rest
    type(modes_par) :: modes                      !! &modes, always complete
    type(response_par), allocatable :: response   !! &response; absent: no time history
    type(frequency_response_par), allocatable :: frequency_response   !! &frequency_response; absent: none
    type(record_par), allocatable :: record       !! &record; absent: histories are simulated
    type(spectrum_par), allocatable :: spectrum   !! &spectrum; absent: no spectral analysis
    type(identify_par), allocatable :: unknowns(:)   !! &identify, in the order of the scene; of size 0 if nothing is fitted
    integer :: further_unknowns = 0               !! number of unknowns in the scenes that these name, once read
    type(design_par), allocatable :: design       !! &design, whose columns are among the sweeps; absent: none
    type(sweep_par), allocatable :: sweeps(:)     !! &sweep, the first varying slowest; of size 0 for one case
    type(group_values), allocatable :: groups(:)  !! all values by name, from which the components are built
  end type scene_type

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

  pure function effect_names(scene) result(names)
    !! Return the groups of a scene that are effects or events, separated by blanks, in the order of the table of groups.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: names
    integer :: i
    names = ''
    do i = 1, size(group_table)
      if (is_simulated(group_table(i)) .and. any(scene%groups%row == i)) names = names//' '//trim(group_table(i)%name)
    end do
    names = trim(adjustl(names))
  end function effect_names

  pure logical function changes_shapes(scene) result(changes)
    !! Tell whether the modes have no closed form: the beam has several pieces, or the table says so of a group or of a
    !! number that is not the plain one.
    type(scene_type), intent(in) :: scene
    integer :: g, v
    changes = allocated(scene%beam%pieces)
    if (changes) return
    do g = 1, size(scene%groups)
      changes = group_table(scene%groups(g)%row)%changes_shapes
      if (changes) return
      do v = 1, size(scene%groups(g)%values)
        if (name_table(scene%groups(g)%values(v)%row)%changes_shapes) changes = .not. is_plain(scene, scene%groups(g)%values(v))
        if (changes) return
      end do
    end do
    changes = .false.
  end function changes_shapes

  pure logical function is_plain(scene, value)
    !! Tell whether a number equals, in every case, the plain one, for which modes have a closed form.
    type(scene_type), intent(in) :: scene
    type(input_value), intent(in) :: value         !! one number
    is_plain = value%numbers(1) == name_table(value%row)%plain
    if (value%follows_sweep()) is_plain = all(scene%sweeps(value%sweeps(1))%values == name_table(value%row)%plain)
  end function is_plain

  pure function method_name(scene) result(name)
    !! Return how the modes of all cases of a scene are found; `record` if none are.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: name
    integer(i8) :: closed, cases
    name = 'record'
    if (allocated(scene%record)) return
    call count_methods(scene, closed, cases)
    name = 'closed form'
    if (closed == cases) return
    name = 'galerkin'
    if (by_pieces(scene)) name = 'pieces'
    if (closed > 0) name = 'closed form, '//name
  end function method_name

  pure subroutine count_methods(scene, closed, cases)
    !! Count the cases whose modes have a closed form: in them all swept numbers that change shapes have their plain
    !! values.
    type(scene_type), intent(in) :: scene
    integer(i8), intent(out) :: closed
    integer(i8), intent(out) :: cases              !! all cases, 1 without sweeps
    type(scene_type) :: rest                       ! with plain numbers in place of swept ones
    logical, allocatable :: plain(:)               ! along an axis
    integer :: axis, s
    rest%groups = scene%groups
    rest%beam = scene%beam
    cases = 1
    closed = 1
    do axis = 1, maxval([0, scene%sweeps%axis])
      s = findloc(scene%sweeps%axis, axis, dim=1)
      allocate (plain(size(scene%sweeps(s)%values)), source=.true.)
      call put_plain(scene, axis, rest%groups, plain)
      cases = cases*size(plain)
      closed = closed*count(plain)
      deallocate (plain)
    end do
    if (changes_shapes(rest)) closed = 0
  end subroutine count_methods

  pure subroutine put_plain(scene, axis, groups, plain)
    !! Set every number that changes shapes and follows an axis of the sweeps to its plain value.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: axis
    type(group_values), intent(inout) :: groups(:)
    logical, intent(inout) :: plain(:)             !! set to false where a value along the axis is not plain
    integer :: g, v
    do g = 1, size(groups)
      do v = 1, size(groups(g)%values)
        associate (value => groups(g)%values(v), row => name_table(groups(g)%values(v)%row))
          if (.not. (row%changes_shapes .and. value%follows_sweep())) cycle
          if (scene%sweeps(value%sweeps(1))%axis /= axis) cycle
          plain = plain .and. scene%sweeps(value%sweeps(1))%values == row%plain
          value%numbers = row%plain
          value%sweeps = 0
        end associate
      end do
    end do
  end subroutine put_plain

  pure logical function by_pieces(scene)
    !! Tell whether modes have no closed form but are found exactly by pieces, since nothing varies along a piece.
    type(scene_type), intent(in) :: scene
    by_pieces = changes_shapes(scene) .and. .not. varies_along_pieces(scene)
  end function by_pieces

  pure logical function varies_along_pieces(scene) result(varies)
    !! Tell whether tension or the section varies along a piece, or the hub is free: then modes are found by Galerkin's method.
    type(scene_type), intent(in) :: scene
    varies = allocated(scene%stiffening) .or. allocated(scene%beam%outer) .or. allocated(scene%hub)
  end function varies_along_pieces

  pure logical function answers_by_modes(scene) result(by_modes)
    !! Tell whether the response to a harmonic force is a sum of modes and not the solution of a boundary problem: with
    !! tension, a taper, a free hub, or the same damping ratio for all modes.
    type(scene_type), intent(in) :: scene
    by_modes = varies_along_pieces(scene)
    if (allocated(scene%damping)) by_modes = by_modes .or. by_ratio(scene%damping)
  end function answers_by_modes

  pure logical function is_loaded(scene)
    !! Tell whether forces act on the beam or its base is accelerated.
    type(scene_type), intent(in) :: scene
    is_loaded = allocated(scene%forces) .or. allocated(scene%bases)
  end function is_loaded

  pure logical function changes_in_time(scene) result(changes)
    !! Tell whether the motion is a timeline of several configurations: bodies come or leave, a captured one is released under
    !! loads, or the beam has initial conditions. Contacts of finite duration are run in another way.
    type(scene_type), intent(in) :: scene
    changes = .false.
    if (allocated(scene%contact)) return
    changes = allocated(scene%initial) .or. (allocated(scene%release) .and. is_loaded(scene)) .or. bodies_change(scene)
  end function changes_in_time

  pure logical function bodies_change(scene) result(change)
    !! Tell whether bodies come or leave, also a mass that is captured under loads after a contact of finite duration.
    type(scene_type), intent(in) :: scene
    change = allocated(scene%contact) .and. allocated(scene%capture) .and. is_loaded(scene)
    if (allocated(scene%bodies)) change = change &
      .or. any(.not. (is_missing(scene%bodies%from) .and. is_missing(scene%bodies%until)))
  end function bodies_change

  pure logical function has_configurations(scene) result(has)
    !! Tell whether the beam may have any number of configurations: it changes in time, also during a contact of finite duration.
    type(scene_type), intent(in) :: scene
    has = changes_in_time(scene) .or. bodies_change(scene)
  end function has_configurations

  pure logical function is_planned(scene)
    !! Tell whether the number of modes for a tolerance is found before the run.
    type(scene_type), intent(in) :: scene
    is_planned = by_tolerance(scene%modes) .and. .not. converges_in_run(scene)
  end function is_planned

  pure logical function converges_in_run(scene)
    !! Tell whether the number of modes for a tolerance is found during the run, by convergence, and not planned beforehand.
    type(scene_type), intent(in) :: scene
    converges_in_run = allocated(scene%contact) .or. changes_in_time(scene) .or. &
      (is_loaded(scene) .and. .not. allocated(scene%impact))
  end function converges_in_run

  pure real(dp) function unit_velocity(scene) result(velocity)
    !! Return the unit of dimensionless velocities, m/s: that of the striking mass, or 1 m/s if something else may move the beam.
    type(scene_type), intent(in) :: scene
    velocity = 1.0_dp
    if (.not. allocated(scene%impact) .or. changes_in_time(scene)) return
    if (scene%impact%approach_velocity /= 0.0_dp .or. .not. allocated(scene%contact)) velocity = scene%impact%approach_velocity
  end function unit_velocity

  pure function at_start(scene) result(present)
    !! Tell which bodies are attached after all events at t = 0, (bodies).
    type(scene_type), intent(in) :: scene
    logical, allocatable :: present(:)
    allocate (present(0))
    if (.not. allocated(scene%bodies)) return
    present = is_missing(scene%bodies%from) .or. scene%bodies%from <= 0.0_dp
  end function at_start

  pure logical function has_parts(groups)
    !! Tell whether the beam has several pieces, another support than a clamped root and a free tip, or attached parts.
    type(group_values), intent(in) :: groups(:)
    has_parts = any(group_table(groups%row)%builds_up)
    if (position_of(groups, 'beam') > 0) has_parts = has_parts .or. groups(position_of(groups, 'beam'))%count_of('length') > 1
  end function has_parts

  pure logical function is_built_up(scene)
    !! Tell whether the beam differs from the paper's, which has no parts and is struck at its tip.
    type(scene_type), intent(in) :: scene
    integer :: impact
    is_built_up = has_parts(scene%groups)
    impact = position_of(scene%groups, 'impact')
    if (is_built_up .or. impact == 0) return
    is_built_up = .not. is_plain(scene, scene%groups(impact)%values(scene%groups(impact)%at('position')))
  end function is_built_up

end module bw_scene
