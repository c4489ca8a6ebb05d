module bw_case_modes
  !! The modes of a case: the one place that knows how they are found.
  use bw_beam_units, only: beam_units
  use bw_case_notes, only: note_coupling, note_empty_bodies, note_growth, note_no_effect, note_unresolved
  use bw_case_result, only: case_modes
  use bw_closed_form_source, only: closed_form_source, source_in_closed_form
  use bw_damping, only: law_of
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_mode_cache, only: mode_cache
  use bw_mode_choice, only: first_modes
  use bw_mode_set, only: first_numbers, mode_set, mode_source, mode_sources
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_piece_source, only: source_of_pieces
  use bw_rotation, only: acts_in_plane, dimensionless_speed
  use bw_scene, only: by_pieces, changes_shapes, is_built_up, scene_type
  use bw_scene_pieces, only: pieces_of, struck_beam
  use bw_strain_cache, only: strain_cache
  use bw_strain_source, only: strain_problem, strain_source, strain_source_of
  use bw_varying_beam, only: under_tension
  implicit none (type, external)
  private
  public :: enough_for_errors, extend_sources, find_modes, find_sources, largest_phase_error, most_to_tolerance, record_stretch

  type, public :: case_mode_cache
    !! Modes that cases of a sweep share.
    type(mode_cache) :: closed_form      !! roots and shapes by mass ratio
    type(strain_cache) :: strains        !! modes under tension by the beam and what acts on it
  end type case_mode_cache

  integer, parameter :: most_to_tolerance(2) = [400, 256]
    !! modes under tension that a tolerance may take, without and with shear: about two seconds' work
  character(*), parameter :: lost_mode = &
    'a mode was not found (none is looked for where rotation bends the beam in more than some hundred waves)'
  character(*), parameter :: no_basis = 'the polynomials of the Galerkin basis do not resolve the modes'
  real(dp), parameter :: least_phase = 1.0e-13_dp     !! rad, to which roots are right over the record, whatever the tolerance
  real(dp), parameter :: phase_share = 1.0e-3_dp      !! of a tolerance that phases may take

contains

  subroutine find_modes(scene, units, monitor, modes, sources, cache)
    !! Sources of all modes, and those sets of them that are held in memory. Where a tolerance says how many are summed,
    !! there are none of the beam alone, and the first few stand for those of beam and mass.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(monitor_type), intent(inout), target :: monitor    !! the modes mean nothing where it asks to stop
    type(case_modes), intent(out) :: modes
    type(mode_sources), intent(out) :: sources
    type(case_mode_cache), intent(inout), target, optional :: cache
      !! must live as long as the sources do; absent: no modes are shared
    real(dp), allocatable :: longest               ! absent: no history is asked for
    type(part_monitor) :: first, second
    first = part_monitor(monitor, 0.0_dp, scene%modes%after/(scene%modes%after + real(scene%modes%before, dp)))
    second = part_monitor(monitor, first%share, 1.0_dp - first%share)
    call find_sources(scene, units, monitor, modes, sources, cache)
    if (monitor%stop_requested()) return
    if (allocated(scene%response)) longest = record_stretch(scene)*(scene%response%duration/units%time%hi)
    if (allocated(scene%capture)) then
      call sources%loaded%find(first_numbers(scene%modes%after), modes%loaded, longest, first)
      if (monitor%stop_requested()) return
      call modes%loaded%forget_rigid_waves()
      call look_at(modes%loaded)
      call note_coupling(scene, units, modes%loaded, modes%notes)
      call note_growth(units, modes%loaded, modes%notes)
      if (by_tolerance(scene%modes)) return
      call sources%free%find(first_numbers(scene%modes%before), modes%free, monitor=second)
      call modes%free%forget_rigid_waves()
      call look_at(modes%free)
    else
      call sources%free%find(first_numbers(scene%modes%before), modes%free, longest, second)
      call modes%free%forget_rigid_waves()
      call look_at(modes%free)
      call note_coupling(scene, units, modes%free, modes%notes)
      call note_growth(units, modes%free, modes%notes)
    end if
  contains
    subroutine look_at(set)
      !! Was every mode found?
      class(mode_set), intent(in) :: set
      if (modes%resolved .and. .not. set%resolved) call note_unresolved(lost_mode, modes%notes)
      modes%resolved = modes%resolved .and. set%resolved
    end subroutine look_at
  end subroutine find_modes

  subroutine find_sources(scene, units, monitor, modes, sources, cache)
    !! By the closed form where shapes are those of the paper's beam, by Galerkin's method where there is tension, else exactly by
    !! pieces.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(monitor_type), intent(inout) :: monitor
    type(case_modes), intent(inout) :: modes       !! no sets, but what is known of them before they are found
    type(mode_sources), intent(out) :: sources
    type(case_mode_cache), intent(inout), target, optional :: cache
    if (by_pieces(scene)) then
      call find_pieces(scene, units, modes, sources)
    else if (changes_shapes(scene)) then
      call find_galerkin(scene, units, monitor, modes, sources, cache)
      if (monitor%stop_requested()) return
    else
      call find_closed_form(scene, units, modes, sources, cache)
    end if
    call note_empty_bodies(scene, modes%notes)
    call prepare(scene, units, sources%free)
    if (.not. allocated(scene%capture)) return
    call prepare(scene, units, sources%loaded)
    sources%loaded%stretch = record_stretch(scene)
  end subroutine find_sources

  subroutine prepare(scene, units, source)
    !! Say what damps the modes.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_source), intent(inout) :: source
    if (allocated(scene%damping)) source%damping = law_of(scene%damping, units)
  end subroutine prepare

  subroutine find_closed_form(scene, units, modes, sources, cache)
    !! Rotation acts on modes in closed form in its own plane only.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(case_modes), intent(inout) :: modes
    type(mode_sources), intent(inout) :: sources
    type(case_mode_cache), intent(inout), target, optional :: cache
    type(dd), allocatable :: omega                 ! absent: the beam does not rotate in the plane of its motion
    if (allocated(scene%rotation)) then
      modes%can_grow = acts_in_plane(scene%rotation)
      if (modes%can_grow) omega = dimensionless_speed(scene%rotation, units)
      if (.not. modes%can_grow) call note_no_effect(modes%notes)
    end if
    call make_source(dd(), sources%free)
    if (allocated(scene%capture)) call make_source(dd(scene%impact%mass_ratio, scene%impact%mass_ratio_low), sources%loaded)
  contains
    subroutine make_source(gamma, source)
      type(dd), intent(in) :: gamma
      class(mode_source), allocatable, intent(out) :: source
      type(closed_form_source), allocatable :: found
      allocate (found)
      found = source_in_closed_form(gamma, omega)
      if (present(cache)) found%cache => cache%closed_form
      if (allocated(scene%response)) found%points = scene%response%points
      call move_alloc(found, source)
    end subroutine make_source
  end subroutine find_closed_form

  subroutine find_pieces(scene, units, modes, sources)
    !! Rotation acts out of its own plane by the turning of the sections alone.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(case_modes), intent(inout) :: modes
    type(mode_sources), intent(inout) :: sources
    if (allocated(scene%rotation)) then
      modes%can_grow = acts_in_plane(scene%rotation) .or. allocated(scene%shear)
      if (.not. modes%can_grow) call note_no_effect(modes%notes)
    end if
    allocate (sources%free, source=source_of_pieces(pieces_of(scene, units, .false.)))
    if (allocated(scene%capture)) allocate (sources%loaded, source=source_of_pieces(pieces_of(scene, units, .true.)))
  end subroutine find_pieces

  subroutine find_galerkin(scene, units, monitor, modes, sources, cache)
    !! As many as are summed, and as estimates of errors take.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(monitor_type), intent(inout) :: monitor
    type(case_modes), intent(inout) :: modes
    type(mode_sources), intent(inout) :: sources
    type(case_mode_cache), intent(inout), optional :: cache
    if (allocated(scene%capture)) call solve(.true., max(scene%modes%after, enough_for_errors(scene)), sources%loaded)
    if (monitor%stop_requested()) return
    if (allocated(scene%release)) then
      call solve(.false., max(scene%modes%before, enough_for_errors(scene)), sources%free)
    else
      call solve(.false., max(scene%modes%before, 1), sources%free)
    end if
  contains
    subroutine solve(carries_mass, count, source)
      logical, intent(in) :: carries_mass
      integer, intent(in) :: count
      class(mode_source), allocatable, intent(out) :: source
      type(strain_source), allocatable :: found
      allocate (found)
      call solve_strains(problem_of(scene, units, carries_mass), count, found, monitor, cache)
      if (modes%resolved .and. .not. found%solved%resolved) call note_unresolved(no_basis, modes%notes)
      modes%resolved = modes%resolved .and. found%solved%resolved
      call move_alloc(found, source)
    end subroutine solve
  end subroutine find_galerkin

  type(strain_problem) function problem_of(scene, units, carries_mass) result(problem)
    !! What modes under tension are sought of.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    logical, intent(in) :: carries_mass            !! the captured mass is there
    type(struck_beam) :: pieces
    pieces = pieces_of(scene, units, carries_mass)
    problem%given = under_tension(pieces%beam, scene%stiffening%hub_radius/units%length)
    problem%struck = pieces%struck
    problem%position = pieces%position
    problem%captured = pieces%captured
    problem%uniform = .not. is_built_up(scene)
  end function problem_of

  subroutine solve_strains(problem, count, source, monitor, cache)
    !! Modes under tension, from the cache if they are there.
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

  pure integer function enough_for_errors(scene) result(count)
    !! Modes that an estimate of what is not summed looks at; more are judged from the last of them.
    type(scene_type), intent(in) :: scene
    integer :: most
    count = 0
    if (.not. allocated(scene%response)) return
    count = first_modes
    if (.not. allocated(scene%release)) return
    most = max(scene%modes%before, scene%modes%after)
    count = max(count, most, min(most_to_tolerance(2), 2*most))
  end function enough_for_errors

  subroutine extend_sources(scene, units, monitor, sources, extended, cache)
    !! Twice as many modes, if there may be more: only a basis for tension has an end.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(monitor_type), intent(inout) :: monitor  !! nothing is extended where it asks to stop
    type(mode_sources), intent(inout) :: sources
    logical, intent(out) :: extended
    type(case_mode_cache), intent(inout), optional :: cache
    call extend(.true., sources%loaded)
    if (extended .and. allocated(scene%release)) call extend(.false., sources%free)
  contains
    subroutine extend(carries_mass, source)
      logical, intent(in) :: carries_mass
      class(mode_source), intent(inout) :: source
      type(strain_source) :: more
      integer :: most
      extended = .false.
      most = most_to_tolerance(merge(2, 1, allocated(scene%shear)))
      select type (source)
      type is (strain_source)
        if (source%highest >= most) return
        call solve_strains(problem_of(scene, units, carries_mass), min(2*source%highest, most), more, monitor, cache)
        extended = more%solved%resolved
        if (.not. extended) return
        call prepare(scene, units, more)
        source = more
      end select
    end subroutine extend
  end subroutine extend_sources

  pure real(dp) function record_stretch(scene) result(stretch)
    !! For how many times the record roots keep phases to `least_phase`, which decides which of them are solved in extended
    !! precision. Errors of phases grow with time, so that where a tolerance lets them be larger it is less than 1.
    type(scene_type), intent(in) :: scene
    stretch = 1.0_dp
    if (scene%modes%extended .or. allocated(scene%recontact)) then
      stretch = sqrt(huge(stretch))                   ! calls for extended precision in every root: contacts amplify errors
    else if (by_tolerance(scene%modes)) then
      stretch = min(1.0_dp, least_phase/(phase_share*scene%modes%tolerance))
    end if
  end function record_stretch

  pure real(dp) function largest_phase_error(scene) result(error)
    !! How far phases may go wrong over the record, rad.
    type(scene_type), intent(in) :: scene
    error = least_phase/record_stretch(scene)
  end function largest_phase_error

end module bw_case_modes
