module bw_strain_source
  !! Modes that are known by the coefficients of their strains, by their numbers: as many as were solved for, and how amplitudes
  !! fall beyond them. The beam is uniform, and struck at its tip if at all, or of several pieces.
  use bw_beam_operator, only: beam_operator
  use bw_galerkin, only: galerkin_modes
  use bw_galerkin_set, only: galerkin_set
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set, mode_source
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: root_power
  use bw_piece_tension, only: tension_in_pieces
  use bw_scene_pieces, only: struck_beam
  use bw_strain_set, only: strain_set
  use bw_tension_modes, only: tension_modes
  use bw_tension_set, only: tension_set
  use bw_tension_system, only: tension_beam
  implicit none (type, external)
  private
  public :: strain_source_of

  type, public :: strain_problem
    !! What modes are sought of. A component that is added here stands in `same_problem`, too.
    type(beam_operator), allocatable :: operator   !! of a uniform beam; unallocated: the beam is of pieces
    type(struck_beam), allocatable :: pieces       !! with tension
    real(dp) :: hub_radius = 0.0_dp                !! R in l, of pieces
  contains
    procedure, private :: same_problem
    generic :: operator(==) => same_problem
  end type strain_problem

  type, extends(mode_source), public :: strain_source
    class(strain_set), allocatable :: solved       !! the first modes, from which others are taken
  contains
    procedure :: find => find_among_solved
  end type strain_source

contains

  pure logical function same_problem(self, other) result(same)
    !! To the bit, so that their modes are the same.
    class(strain_problem), intent(in) :: self
    type(strain_problem), intent(in) :: other
    same = (allocated(self%operator) .eqv. allocated(other%operator)) .and. self%hub_radius == other%hub_radius
    if (.not. same) return
    if (allocated(self%operator)) then
      same = self%operator == other%operator
    else
      same = self%pieces == other%pieces
    end if
  end function same_problem

  subroutine strain_source_of(problem, count, source, monitor)
    !! Make a source of the first `count` modes, and none beyond them.
    type(strain_problem), intent(in) :: problem
    integer, intent(in) :: count
    type(strain_source), intent(out) :: source
    class(monitor_type), intent(inout), optional :: monitor   !! none are found where it asks to stop
    source%highest = count
    if (allocated(problem%operator)) then
      call solve_uniform(problem%operator, source, monitor)
    else
      call solve_pieces(problem%pieces, problem%hub_radius, source, monitor)
    end if
  end subroutine strain_source_of

  subroutine solve_uniform(operator, source, monitor)
    type(beam_operator), intent(in) :: operator
    type(strain_source), intent(inout) :: source   !! its highest mode is known
    class(monitor_type), intent(inout), optional :: monitor
    type(galerkin_set), allocatable :: set
    real(dp) :: pull
    allocate (set)
    call galerkin_modes(operator, source%highest, set, monitor)
    call move_alloc(set, source%solved)
    source%gamma = operator%gamma
    pull = 0.0_dp
    if (allocated(operator%tension)) pull = operator%tension(1)
    source%decay = decay_of(source, allocated(operator%shear), pull)
  end subroutine solve_uniform

  subroutine solve_pieces(pieces, hub_radius, source, monitor)
    type(struck_beam), intent(in) :: pieces
    real(dp), intent(in) :: hub_radius
    type(strain_source), intent(inout) :: source   !! its highest mode is known
    class(monitor_type), intent(inout), optional :: monitor
    type(tension_set), allocatable :: set
    type(tension_beam) :: given
    given%beam = pieces%beam
    given%tension = tension_in_pieces(pieces%beam, hub_radius)
    source%gamma = pieces%captured%mass%hi
    source%struck_at = pieces%position
    source%uniform = .false.
    source%root_power = root_power(pieces%beam%root)
    source%decay = decay_of(source, any(pieces%beam%piece%compliance%hi > 0.0_dp), &
                            pieces%beam%spin_squared%hi*given%tension(1, 1))
    allocate (set)
    call tension_modes(given, source%highest, pieces%struck, set, monitor)
    set%gamma = source%gamma
    set%struck_at = source%struck_at
    set%uniform = .false.
    set%root_power = source%root_power
    set%body_inertia = pieces%captured%inertia%hi
    set%body_pull = pieces%beam%spin_squared%hi*source%gamma*(pieces%position + hub_radius)
    call move_alloc(set, source%solved)
  end subroutine solve_pieces

  pure real(dp) function decay_of(source, shears, pull) result(decay)
    !! The n of |Φ_k(ξ₀)Φ_k(ξ)|/(M_kβ_k) ∝ k⁻ⁿ beyond the highest mode: 3 where the captured mass holds the beam, α being above
    !! 1/γ; 2 where the mass is light, or waves are those of shear or of a string.
    class(mode_source), intent(in) :: source
    logical, intent(in) :: shears
    real(dp), intent(in) :: pull                   !! the largest tension, at the root
    real(dp) :: alpha
    alpha = source%highest*acos(-1.0_dp)
    decay = 3.0_dp
    if (alpha*source%gamma < 1.0_dp .or. shears .or. alpha**2 < pull) decay = 2.0_dp
  end function decay_of

  subroutine find_among_solved(self, number, modes, longest, monitor)
    !! Find the modes of these numbers among those that were solved for. `longest` has no use here: β² has the digits that it
    !! has. Nor has the monitor: all is found already.
    class(strain_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    class(monitor_type), intent(inout), optional :: monitor
    class(strain_set), allocatable :: found
    call self%solved%choose(number, found)
    call found%damp(self%damping)
    if (present(longest) .or. present(monitor)) continue
    call move_alloc(found, modes)
  end subroutine find_among_solved

end module bw_strain_source
