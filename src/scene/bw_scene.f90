module bw_scene
  !! A scene as plain data in SI units: one component per input group, unallocated if the group is absent; and which effects,
  !! methods and kinds of motion follow from it.
  use bw_beam_par, only: beam_par
  use bw_body_par, only: body_par
  use bw_capture_par, only: capture_par
  use bw_contact_par, only: contact_par
  use bw_damping_par, only: by_ratio, damping_par
  use bw_design_par, only: design_par
  use bw_frequency_response_par, only: frequency_response_par
  use bw_hub_par, only: hub_par
  use bw_identify_par, only: identify_par
  use bw_impact_par, only: impact_par
  use bw_initial_par, only: initial_par
  use bw_input_name, only: is_simulated
  use bw_input_table, only: group_table, name_table
  use bw_input_values, only: group_values, input_value, position_of
  use bw_kinds, only: dp, i8
  use bw_load_par, only: force_par, load_par
  use bw_missing, only: is_missing
  use bw_modes_par, only: by_tolerance, modes_par
  use bw_record_par, only: record_par
  use bw_recontact_par, only: recontact_par
  use bw_release_par, only: release_par
  use bw_response_par, only: response_par
  use bw_rotation_par, only: rotation_par
  use bw_scene_par, only: scene_par
  use bw_shear_par, only: shear_par
  use bw_spectrum_par, only: spectrum_par
  use bw_stiffening_par, only: stiffening_par
  use bw_support_par, only: support_par
  use bw_sweep_par, only: sweep_par
  implicit none (type, external)
  private
  public :: answers_by_modes, by_pieces, changes_shapes, count_methods, varies_along_pieces, effect_names, at_start, &
    bodies_change, changes_in_time, converges_in_run, has_configurations, has_parts, is_built_up, is_let_go, is_loaded, &
    is_planned, method_name, unit_velocity

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

contains

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
    !! Return whether the modes have no closed form: the beam has several pieces, or the table says so of a group or of a
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
    !! Return whether a number equals, in every case, the plain one, for which modes have a closed form.
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
    !! Return whether modes have no closed form but are found exactly by pieces, since nothing varies along a piece.
    type(scene_type), intent(in) :: scene
    by_pieces = changes_shapes(scene) .and. .not. varies_along_pieces(scene)
  end function by_pieces

  pure logical function varies_along_pieces(scene) result(varies)
    !! Return whether tension or the section varies along a piece, or the hub is free: then modes are found by Galerkin's method.
    type(scene_type), intent(in) :: scene
    varies = allocated(scene%stiffening) .or. allocated(scene%beam%outer) .or. allocated(scene%hub)
  end function varies_along_pieces

  pure logical function answers_by_modes(scene) result(by_modes)
    !! Return whether the response to a harmonic force is a sum of modes and not the solution of a boundary problem: with
    !! tension, a taper, a free hub, or the same damping ratio for all modes.
    type(scene_type), intent(in) :: scene
    by_modes = varies_along_pieces(scene)
    if (allocated(scene%damping)) by_modes = by_modes .or. by_ratio(scene%damping)
  end function answers_by_modes

  pure logical function is_loaded(scene)
    !! Return whether forces act on the beam or its base is accelerated.
    type(scene_type), intent(in) :: scene
    is_loaded = allocated(scene%forces) .or. allocated(scene%bases)
  end function is_loaded

  pure logical function changes_in_time(scene) result(changes)
    !! Return whether the motion is a timeline of several configurations: bodies come or leave, a captured one is released under
    !! loads, or the beam has initial conditions. Contacts of finite duration are run in another way.
    type(scene_type), intent(in) :: scene
    changes = .false.
    if (allocated(scene%contact)) return
    changes = allocated(scene%initial) .or. (allocated(scene%release) .and. is_loaded(scene)) .or. bodies_change(scene)
  end function changes_in_time

  pure logical function bodies_change(scene) result(change)
    !! Return whether bodies come or leave, also a mass that is captured under loads after a contact of finite duration.
    type(scene_type), intent(in) :: scene
    change = allocated(scene%contact) .and. allocated(scene%capture) .and. is_loaded(scene)
    if (allocated(scene%bodies)) change = change &
      .or. any(.not. (is_missing(scene%bodies%from) .and. is_missing(scene%bodies%until)))
  end function bodies_change

  pure logical function is_let_go(scene)
    !! Return whether a beam with a prescribed root is let go at rest from its static deflection, with at most loads beside that.
    type(scene_type), intent(in) :: scene
    is_let_go = .false.
    if (.not. allocated(scene%initial) .or. allocated(scene%impact) .or. allocated(scene%contact) .or. allocated(scene%hub) .or. &
        bodies_change(scene)) return
    is_let_go = .not. scene%groups(position_of(scene%groups, 'initial'))%given('angular_velocity')
  end function is_let_go

  pure logical function has_configurations(scene) result(has)
    !! Return whether the beam may have any number of configurations: it changes in time, also during a contact of finite duration.
    type(scene_type), intent(in) :: scene
    has = changes_in_time(scene) .or. bodies_change(scene)
  end function has_configurations

  pure logical function is_planned(scene)
    !! Return whether the number of modes for a tolerance is found before the run.
    type(scene_type), intent(in) :: scene
    is_planned = by_tolerance(scene%modes) .and. .not. converges_in_run(scene)
  end function is_planned

  pure logical function converges_in_run(scene)
    !! Return whether the number of modes for a tolerance is found during the run, by convergence, and not planned beforehand.
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
    !! Return which bodies are attached after all events at t = 0, (bodies).
    type(scene_type), intent(in) :: scene
    logical, allocatable :: present(:)
    allocate (present(0))
    if (.not. allocated(scene%bodies)) return
    present = is_missing(scene%bodies%from) .or. scene%bodies%from <= 0.0_dp
  end function at_start

  pure logical function has_parts(groups)
    !! Return whether the beam has several pieces, another support than a clamped root and a free tip, or attached parts.
    type(group_values), intent(in) :: groups(:)
    has_parts = any(group_table(groups%row)%builds_up)
    if (position_of(groups, 'beam') > 0) has_parts = has_parts .or. groups(position_of(groups, 'beam'))%count_of('length') > 1
  end function has_parts

  pure logical function is_built_up(scene)
    !! Return whether the beam differs from the paper's, which has no parts and is struck at its tip.
    type(scene_type), intent(in) :: scene
    integer :: impact
    is_built_up = has_parts(scene%groups)
    impact = position_of(scene%groups, 'impact')
    if (is_built_up .or. impact == 0) return
    is_built_up = .not. is_plain(scene, scene%groups(impact)%values(scene%groups(impact)%at('position')))
  end function is_built_up

end module bw_scene
