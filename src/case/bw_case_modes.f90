module bw_case_modes
  !! The modes of a case: the one place that knows how they are found.
  use bw_kinds, only: dp
  use bw_beam_units, only: beam_units
  use bw_case_result, only: case_result
  use bw_closed_form_source, only: closed_form_source, source_in_closed_form
  use bw_damping, only: law_of
  use bw_double_double, only: dd
  use bw_galerkin_source, only: galerkin_cache, galerkin_source, galerkin_source_of
  use bw_mode_cache, only: mode_cache
  use bw_mode_choice, only: first_modes
  use bw_mode_set, only: first_numbers, mode_set, mode_source
  use bw_mode_notes, only: note_coupling, note_no_effect, note_strain, note_unresolved
  use bw_modes_par, only: by_tolerance
  use bw_monitor, only: monitor_type, part_monitor
  use bw_record_stretch, only: record_stretch
  use bw_rotation, only: acts_in_plane, dimensionless_speed
  use bw_scene, only: changes_shapes, scene_type
  use bw_beam_operator, only: operator_of
  implicit none (type, external)
  private
  public :: find_modes, extend_modes

  integer, parameter :: most_to_tolerance(2) = [400, 256]
    !! modes without a closed form that a tolerance may take, without and with shear: about two seconds' work

contains

  subroutine find_modes(scene, result, free, loaded, source, alone, monitor, kept, operators)
    !! `result%modes`, those in force: of beam and mass if the mass is captured, else of the beam alone; with a capture also
    !! `result%before`, of the beam alone. Where a tolerance says how many are summed, there are none before the capture,
    !! and the first few stand for those after it.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout), target :: result
    class(mode_set), pointer, intent(out) :: free, loaded
      !! modes of the beam alone, and of beam and mass, in `result`: many modes are not held twice; null: there are none
    class(mode_source), allocatable, intent(out) :: source   !! of beam and mass; absent: the mass is not captured
    class(mode_source), allocatable, intent(out) :: alone    !! of the beam alone
    class(monitor_type), intent(inout), target :: monitor    !! the modes mean nothing where it asks to stop
    type(mode_cache), intent(inout), target, optional :: kept
      !! what cases share, for as long as the sources live; absent: nothing is kept
    type(galerkin_cache), intent(inout), optional :: operators   !! the same of modes without a closed form
    real(dp), allocatable :: longest               ! absent: no history is asked for
    type(part_monitor) :: first, second
    first = part_monitor(monitor, 0.0_dp, scene%modes%after/(scene%modes%after + real(scene%modes%before, dp)))
    second = part_monitor(monitor, first%share, 1.0_dp - first%share)
    nullify (free, loaded)
    if (changes_shapes(scene)) then
      call find_galerkin(scene, result, operators, alone, source, monitor)
      if (monitor%stop_requested()) return
    else
      call find_closed_form(scene, result, kept, alone, source)
    end if
    if (allocated(scene%response)) longest = record_stretch(scene)*(scene%response%duration/result%units%time%hi)
    call prepare(scene, result, alone)
    call prepare(scene, result, source)
    if (allocated(scene%capture)) then
      source%stretch = record_stretch(scene)
      call source%find(first_numbers(scene%modes%after), result%modes, longest, first)
      loaded => result%modes
      if (monitor%stop_requested()) return
      call note_coupling(scene, result)
      if (by_tolerance(scene%modes)) return
      call alone%find(first_numbers(scene%modes%before), result%before, monitor=second)
      free => result%before
    else
      call alone%find(first_numbers(scene%modes%before), result%modes, longest, second)
      free => result%modes
      call note_coupling(scene, result)
    end if
  end subroutine find_modes

  subroutine prepare(scene, result, source)
    !! Say what damps the modes.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(in) :: result
    class(mode_source), allocatable, intent(inout) :: source
    if (.not. allocated(source)) return
    if (allocated(scene%damping)) source%damping = law_of(scene%damping, result%units)
  end subroutine prepare

  subroutine find_closed_form(scene, result, kept, alone, loaded)
    !! Rotation acts on modes in closed form in its own plane only.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    type(mode_cache), intent(inout), target, optional :: kept
    class(mode_source), allocatable, intent(out) :: alone, loaded
    type(dd), allocatable :: omega                 ! absent: the beam does not rotate in the plane of its motion
    result%can_grow = .true.
    if (allocated(scene%rotation)) then
      result%can_grow = acts_in_plane(scene%rotation)
      if (result%can_grow) omega = dimensionless_speed(scene%rotation, result%units)
      if (.not. result%can_grow) call note_no_effect(result)
    end if
    call take_source(dd(), alone)
    if (allocated(scene%capture)) call take_source(dd(scene%impact%mass_ratio, scene%impact%mass_ratio_low), loaded)
  contains
    subroutine take_source(gamma, source)
      type(dd), intent(in) :: gamma
      class(mode_source), allocatable, intent(out) :: source
      type(closed_form_source), allocatable :: found
      allocate (found)
      found = source_in_closed_form(gamma, omega)
      if (present(kept)) found%cache => kept
      call move_alloc(found, source)
    end subroutine take_source
  end subroutine find_closed_form

  subroutine find_galerkin(scene, result, operators, alone, loaded, monitor)
    !! As many as are summed, and as estimates of errors take.
    type(scene_type), intent(in) :: scene
    type(case_result), intent(inout) :: result
    type(galerkin_cache), intent(inout), optional :: operators
    class(mode_source), allocatable, intent(out) :: alone, loaded
    class(monitor_type), intent(inout) :: monitor
    result%can_grow = .true.                       ! the modes know
    if (allocated(scene%rotation)) then
      if (.not. (acts_in_plane(scene%rotation) .or. allocated(scene%stiffening) .or. allocated(scene%shear))) then
        call note_no_effect(result)
      end if
      call note_strain(scene, result)
    end if
    if (allocated(scene%capture)) call solve(.true., max(scene%modes%after, enough_for_errors(scene)), loaded)
    if (monitor%stop_requested()) return
    if (allocated(scene%release)) then
      call solve(.false., max(scene%modes%before, enough_for_errors(scene)), alone)
    else
      call solve(.false., max(scene%modes%before, 1), alone)
    end if
  contains
    subroutine solve(carries_mass, count, source)
      logical, intent(in) :: carries_mass
      integer, intent(in) :: count
      class(mode_source), allocatable, intent(out) :: source
      type(galerkin_source), allocatable :: found
      allocate (found)
      if (present(operators)) then
        call operators%find(operator_of(scene, result%units, carries_mass), count, found, monitor)
      else
        call galerkin_source_of(operator_of(scene, result%units, carries_mass), count, found, monitor)
      end if
      if (.not. found%solved%resolved) call note_unresolved(result)
      call move_alloc(found, source)
    end subroutine solve
  end subroutine find_galerkin

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

  subroutine extend_modes(scene, units, source, alone, monitor, extended)
    !! Twice as many modes, if there may be more: closed forms know them all.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    class(mode_source), intent(inout) :: source    !! of beam and mass
    class(mode_source), intent(inout) :: alone     !! of the beam alone, which move after a release
    class(monitor_type), intent(inout) :: monitor  !! nothing is extended where it asks to stop
    logical, intent(out) :: extended
    call extend_source(scene, units, .true., source, monitor, extended)
    if (extended .and. allocated(scene%release)) call extend_source(scene, units, .false., alone, monitor, extended)
  end subroutine extend_modes

  subroutine extend_source(scene, units, carries_mass, source, monitor, extended)
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    logical, intent(in) :: carries_mass
    class(mode_source), intent(inout) :: source
    class(monitor_type), intent(inout) :: monitor
    logical, intent(out) :: extended
    type(galerkin_source) :: more
    integer :: most
    extended = .false.
    most = most_to_tolerance(merge(2, 1, allocated(scene%shear)))
    select type (source)
    type is (galerkin_source)
      if (source%highest >= most) return
      call galerkin_source_of(operator_of(scene, units, carries_mass), min(2*source%highest, most), more, monitor)
      extended = more%solved%resolved
      if (.not. extended) return
      if (allocated(scene%damping)) more%damping = law_of(scene%damping, units)
      source = more
    end select
  end subroutine extend_source

end module bw_case_modes
