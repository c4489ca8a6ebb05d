module bw_case_modes
  !! The modes of a case, found by the method that its beam needs (bw_some_modes does the same for studies of many beams).
  use bw_beam_motion, only: case_modes
  use bw_beam_units, only: beam_units
  use bw_case_notes, only: note_coupling, note_empty_bodies, note_growth, note_no_effect, note_unresolved
  use bw_closed_form_source, only: closed_form_source, source_in_closed_form
  use bw_damping, only: law_of
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_mode_cache, only: mode_cache
  use bw_mode_set, only: configuration_type, first_numbers, least_phase, mode_source
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_piece_beam, only: cut_all
  use bw_piece_source, only: source_of_pieces
  use bw_piece_waves, only: parts_at_rest
  use bw_rotation, only: acts_in_plane, dimensionless_speed
  use bw_scene, only: by_pieces, changes_shapes, has_configurations, is_built_up, scene_type
  use bw_scene_pieces, only: pieces_of, struck_beam, varying_of
  use bw_strain_cache, only: strain_cache
  use bw_strain_source, only: strain_problem, strain_source, strain_source_of
  use bw_text, only: text_of
  use bw_timeline, only: carried_type, is_released, configurations_of, number_of, start_of
  implicit none (type, external)
  private
  public :: extend_source, find_modes, find_sources, largest_phase_error, most_in_run, most_to_tolerance, record_stretch

  type, public :: case_mode_cache
    !! Modes shared by the cases of a sweep.
    type(mode_cache) :: closed_form      !! roots and shapes by mass ratio
    type(strain_cache) :: strains        !! modes under tension, by beam and attached bodies
  end type case_mode_cache

  integer, parameter, public :: first_modes = 64   !! enough for the peak of a motion, and to estimate the remainder
  integer, parameter :: most_to_tolerance(2) = [400, 256]
    !! modes under tension that a tolerance may sum, without and with shear: about two seconds of work
  character(*), parameter :: lost_mode = &
    'a mode was not found (modes are not sought if rotation bends the beam into more than some hundred waves)'
  character(*), parameter :: no_basis = 'the polynomials of the Galerkin basis do not resolve the modes'
  real(dp), parameter :: phase_share = 1.0e-3_dp      !! share of a tolerance left to phase errors

contains

  subroutine find_modes(scene, units, monitor, modes, cache)
    !! Find the source of modes of each configuration, and the modes held in memory. If a tolerance chooses their
    !! number, none are held for the beam alone, and the first few of beam and mass are held.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(monitor_type), intent(inout), target :: monitor    !! the modes are invalid if it requests a stop
    type(case_modes), intent(out) :: modes
    type(case_mode_cache), intent(inout), target, optional :: cache
      !! must outlive the sources; absent: no modes are shared
    type(part_monitor) :: part
    integer, allocatable :: counts(:)
    real(dp) :: done
    integer :: i
    call find_sources(scene, units, monitor, modes, cache)
    if (monitor%stop_requested()) return
    counts = counts_of(scene, size(modes%configuration))
    done = 0.0_dp
    do i = size(counts), 1, -1
      if (counts(i) == 0) cycle
      part = part_monitor(monitor, done, real(counts(i), dp)/sum(counts))
      done = done + part%share
      call find_set(scene, units, i == modes%moving .or. has_configurations(scene), counts(i), part, modes%configuration(i), modes)
      if (monitor%stop_requested()) return
      if (.not. modes%configuration(i)%set%resolved) cycle
      associate (set => modes%configuration(i)%set)
        if (i == modes%moving) then
          call note_coupling(scene, units, set, modes%notes)
          call note_growth(units, set, modes%notes)
        else if (has_configurations(scene)) then
          call note_growth(units, set, modes%notes, ' of configuration '//text_of(i))
        end if
      end associate
    end do
  end subroutine find_modes

  pure function counts_of(scene, configurations) result(counts)
    !! Return how many modes of each configuration are held: `before` of the first, `after` of all others.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: configurations
    integer :: counts(configurations)
    counts = scene%modes%after
    counts(1) = scene%modes%before
  end function counts_of

  subroutine find_set(scene, units, moves, count, monitor, configuration, modes)
    !! Find the first modes of a configuration.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    logical, intent(in) :: moves                   !! its modes appear in a history
    integer, intent(in) :: count
    class(monitor_type), intent(inout) :: monitor
    type(configuration_type), intent(inout) :: configuration
    type(case_modes), intent(inout) :: modes
    real(dp), allocatable :: longest               ! absent: no history is requested
    if (moves .and. allocated(scene%response)) longest = record_stretch(scene)*(scene%response%duration/units%time%hi)
    call configuration%source%find(first_numbers(count), configuration%set, longest, monitor)
    if (monitor%stop_requested()) return
    if (.not. configuration%set%resolved) then           ! modes that were not found are unknown
      if (modes%resolved) call note_unresolved(lost_mode, modes%notes)
      modes%resolved = .false.
      return
    end if
    call configuration%set%forget_rigid_waves()
  end subroutine find_set

  subroutine find_sources(scene, units, monitor, modes, cache)
    !! Choose a source of modes for every configuration, with the bodies that it carries: in closed form for the paper's
    !! beam, by Galerkin's method with tension or taper, else exactly by pieces.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(monitor_type), intent(inout) :: monitor
    type(case_modes), intent(out) :: modes         !! sources and notes, but no sets
    type(case_mode_cache), intent(inout), target, optional :: cache
    type(carried_type), allocatable :: carried(:)
    integer :: i
    carried = configurations_of(scene)
    modes%moving = number_of(carried, start_of(scene))
    allocate (modes%configuration(size(carried)))
    call note_rotation(scene, modes)
    do i = 1, size(modes%configuration)
      associate (source => modes%configuration(i)%source)
        if (by_pieces(scene)) then
          allocate (source, source=source_of_pieces(cut_alike(scene, pieces_of(scene, units, carried(i)%captured, &
                                                                              carried(i)%body))))
        else if (changes_shapes(scene)) then
          call find_galerkin(scene, units, carried(i), i > 1, monitor, modes, source, cache)
          if (monitor%stop_requested()) return
        else
          call find_closed_form(scene, units, carried(i)%captured, source, cache)
        end if
        if (allocated(scene%damping)) source%damping = law_of(scene%damping, units)
        if (i > 1) source%stretch = record_stretch(scene)
      end associate
    end do
    call note_empty_bodies(scene, modes%notes)
  end subroutine find_sources

  pure type(struck_beam) function cut_alike(scene, pieces) result(cut)
    !! Cut pieces as the search for modes with λ ≤ 0 does, if the beam has several configurations: any of them may have
    !! such modes, and all must have the same joints.
    type(scene_type), intent(in) :: scene
    type(struck_beam), intent(in) :: pieces
    integer :: parts(size(pieces%beam%piece))
    cut = pieces
    if (.not. has_configurations(scene)) return
    parts = parts_at_rest(pieces%beam)
    cut%struck = sum(parts(:pieces%struck))
    cut%beam = cut_all(pieces%beam, parts)
  end function cut_alike

  subroutine note_rotation(scene, modes)
    !! Note whether rotation has an effect. Without tension it acts in its plane, and out of it only through rotary inertia.
    type(scene_type), intent(in) :: scene
    type(case_modes), intent(inout) :: modes
    if (.not. allocated(scene%rotation) .or. allocated(scene%stiffening)) return
    modes%can_grow = acts_in_plane(scene%rotation) .or. allocated(scene%shear)
    if (.not. modes%can_grow) call note_no_effect(modes%notes)
  end subroutine note_rotation

  subroutine find_closed_form(scene, units, with_mass, source, cache)
    !! Make a source of modes in closed form, on which rotation acts in its plane only.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    logical, intent(in) :: with_mass
    class(mode_source), allocatable, intent(out) :: source
    type(case_mode_cache), intent(inout), target, optional :: cache
    type(closed_form_source), allocatable :: found
    type(dd), allocatable :: omega                 ! absent: the beam does not rotate in the plane of its motion
    type(dd) :: gamma
    if (allocated(scene%rotation)) then
      if (acts_in_plane(scene%rotation)) omega = dimensionless_speed(scene%rotation, units)
    end if
    if (with_mass) gamma = dd(scene%impact%mass_ratio, scene%impact%mass_ratio_low)
    allocate (found)
    found = source_in_closed_form(gamma, omega)
    if (present(cache)) found%cache => cache%closed_form
    if (allocated(scene%response)) found%points = scene%response%points
    call move_alloc(found, source)
  end subroutine find_closed_form

  subroutine find_galerkin(scene, units, carried, later, monitor, modes, source, cache)
    !! Make a source of Galerkin modes: as many as are summed or needed by error estimates.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(carried_type), intent(in) :: carried
    logical, intent(in) :: later                   !! than the first configuration
    class(monitor_type), intent(inout) :: monitor
    type(case_modes), intent(inout) :: modes
    class(mode_source), allocatable, intent(out) :: source
    type(case_mode_cache), intent(inout), optional :: cache
    type(strain_source), allocatable :: found
    integer :: count
    count = max(1, scene%modes%before)
    if (later) count = scene%modes%after
    if (allocated(scene%response) .and. (later .or. is_released(scene))) count = max(count, first_modes)
    allocate (found)
    call solve_strains(problem_of(scene, units, carried), count, found, monitor, cache)
    if (modes%resolved .and. .not. found%solved%resolved) call note_unresolved(no_basis, modes%notes)
    modes%resolved = modes%resolved .and. found%solved%resolved
    found%at_most = most_to_tolerance(merge(2, 1, allocated(scene%shear)))
    call move_alloc(found, source)
  end subroutine find_galerkin

  type(strain_problem) function problem_of(scene, units, carried) result(problem)
    !! Describe the beam whose modes under tension are sought.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(carried_type), intent(in) :: carried      !! what the beam carries
    type(struck_beam) :: pieces
    pieces = pieces_of(scene, units, carried%captured, carried%body)
    problem%given = varying_of(scene, units, pieces)
    problem%struck = pieces%struck
    problem%position = pieces%position
    problem%captured = pieces%captured
    problem%uniform = .not. is_built_up(scene)
  end function problem_of

  subroutine solve_strains(problem, count, source, monitor, cache)
    !! Find modes under tension, or take them from the cache.
    type(strain_problem), intent(in) :: problem
    integer, intent(in) :: count
    type(strain_source), intent(out) :: source
    class(monitor_type), intent(inout) :: monitor
    type(case_mode_cache), intent(inout), optional :: cache
    if (present(cache)) then
      call cache%strains%find(problem, count, source, monitor)
    else
      call strain_source_of(problem, count, source, monitor)
    end if
  end subroutine solve_strains

  subroutine extend_source(scene, units, configuration, monitor, source, extended, cache)
    !! Double the modes of a source whose basis is finite, as long as it may have more: only those under tension or with taper.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    integer, intent(in) :: configuration           !! of the source
    class(monitor_type), intent(inout) :: monitor  !! nothing is extended if it requests a stop
    class(mode_source), intent(inout) :: source
    logical, intent(out) :: extended
    type(case_mode_cache), intent(inout), optional :: cache
    type(strain_source) :: more
    type(carried_type), allocatable :: carried(:)
    extended = .false.
    select type (source)
    type is (strain_source)
      if (source%highest >= source%at_most) return
      carried = configurations_of(scene)
      call solve_strains(problem_of(scene, units, carried(configuration)), &
                         min(2*source%highest, source%at_most), more, monitor, cache)
      extended = more%solved%resolved
      if (.not. extended) return
      more%at_most = source%at_most
      if (allocated(source%damping)) more%damping = source%damping
      more%failure => source%failure
      more%monitor => source%monitor
      source = more
    end select
  end subroutine extend_source

  pure integer function most_in_run(scene, otherwise) result(most)
    !! Return how many modes a run may sum to meet a tolerance: fewer than `otherwise` under tension.
    type(scene_type), intent(in) :: scene
    integer, intent(in) :: otherwise
    most = otherwise
    if (changes_shapes(scene) .and. .not. by_pieces(scene)) most = most_to_tolerance(merge(2, 1, allocated(scene%shear)))
  end function most_in_run

  pure real(dp) function record_stretch(scene) result(stretch)
    !! Return for how many record lengths roots keep phases to `least_phase`; that decides which need extended
    !! precision. Phase errors grow with time: a tolerance that allows larger ones gives less than 1.
    type(scene_type), intent(in) :: scene
    stretch = 1.0_dp
    if (scene%modes%extended .or. allocated(scene%recontact)) then
      stretch = sqrt(huge(stretch))                   ! calls for extended precision in every root: contacts amplify errors
    else if (by_tolerance(scene%modes)) then
      stretch = min(1.0_dp, least_phase/(phase_share*scene%modes%tolerance))
    end if
  end function record_stretch

  pure real(dp) function largest_phase_error(scene) result(error)
    !! Return the largest phase error at the end of the record, rad.
    type(scene_type), intent(in) :: scene
    error = least_phase/record_stretch(scene)
  end function largest_phase_error

end module bw_case_modes
