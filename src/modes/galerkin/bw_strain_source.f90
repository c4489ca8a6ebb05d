module bw_strain_source
  !! Modes by strains, by their numbers, as many as were solved for; and a beam of uniform pieces that bounds those beyond.
  use bw_double_double, only: operator(*), operator(==)
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set, mode_source
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: beam_joint, modes_at_rest, root_power, operator(==)
  use bw_piece_critical, only: without_inertia
  use bw_scene_pieces, only: struck_beam
  use bw_strain_modes, only: strain_modes
  use bw_strain_set, only: strain_set
  use bw_varying_beam, only: soft_parts, softest, turning_inertia, varying_beam
  implicit none (type, external)
  private
  public :: strain_source_of

  type, public :: strain_problem
    !! The beam of the modes. A component added here belongs in `same_problem` as well.
    type(varying_beam) :: given
    integer :: struck = 1                          !! joint at which the mass strikes
    real(dp) :: position = 1.0_dp                  !! ξ₀ of it
    type(beam_joint) :: captured                   !! what the captured mass adds there
    logical :: uniform = .false.                   !! see mode_source
  contains
    procedure, private :: same_problem
    generic :: operator(==) => same_problem
  end type strain_problem

  type, extends(mode_source), public :: strain_source
    type(strain_set) :: solved                     !! the first modes, from which others are taken
  contains
    procedure :: find => find_among_solved
  end type strain_source

contains

  pure logical function same_problem(self, other) result(same)
    !! Compare two problems bitwise: equal ones have the same modes.
    class(strain_problem), intent(in) :: self
    type(strain_problem), intent(in) :: other
    same = self%given == other%given .and. self%struck == other%struck .and. self%position == other%position &
      .and. self%captured == other%captured .and. (self%uniform .eqv. other%uniform)
  end function same_problem

  subroutine strain_source_of(problem, count, source, monitor)
    !! Make a source of the first `count` modes, and none beyond.
    type(strain_problem), intent(in) :: problem
    integer, intent(in) :: count
    type(strain_source), intent(out) :: source
    class(monitor_type), intent(inout), optional :: monitor   !! none are found if it requests a stop
    associate (given => problem%given, set => source%solved)
      source%highest = count
      source%gamma = problem%captured%mass%hi
      source%struck_at = problem%position
      source%pieces = struck_beam(given%beam, problem%struck, problem%position, problem%captured)
      if (given%tapers()) &
        source%pieces = struck_beam(softest(given), soft_parts*problem%struck, problem%position, problem%captured)
      if (given%beam%root%on_hub) call lighten(given, source%pieces)
      source%uniform = problem%uniform
      source%root_power = root_power(given%beam%root)
      call strain_modes(given, count, problem%struck, set, monitor)
      if (.not. given%is_pulled) set%grows_at_any_speed = modes_at_rest(without_inertia(given%beam)) > 0 .and. &
        (given%beam%in_plane .or. given%beam%spin_squared%hi == 0.0_dp)
      set%gamma = source%gamma
      set%struck_at = source%struck_at
      set%uniform = source%uniform
      set%root_power = source%root_power
      set%body_inertia = problem%captured%inertia%hi
      set%body_pull = given%beam%spin_squared%hi*source%gamma*(problem%position + given%hub_radius)
    end associate
  end subroutine strain_source_of

  pure subroutine lighten(given, pieces)
    !! Scale the masses to bound a beam on a free hub: relative to the hub's line it has at least the part J/(J + I) of
    !! the kinetic energy of a clamped beam, with the inertias J of the hub and I of the beam.
    type(varying_beam), intent(in) :: given
    type(struck_beam), intent(inout) :: pieces
    associate (hub => given%beam%root%hub_inertia%hi, beam => pieces%beam)
      pieces%lightness = hub/(hub + turning_inertia(given))
      beam%piece%mass = beam%piece%mass*pieces%lightness
      beam%piece%rotary = beam%piece%rotary*pieces%lightness
      beam%joint%mass = beam%joint%mass*pieces%lightness
      beam%joint%inertia = beam%joint%inertia*pieces%lightness
    end associate
  end subroutine lighten

  subroutine find_among_solved(self, number, modes, longest, monitor)
    !! Find modes by numbers among those solved for. `longest` and the monitor are not used, as all modes are known to
    !! the same digits.
    class(strain_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    class(monitor_type), intent(inout), optional :: monitor
    type(strain_set), allocatable :: found
    allocate (found)
    found = self%solved%choose(number)
    call found%damp(self%damping)
    if (present(longest) .or. present(monitor)) continue
    call move_alloc(found, modes)
  end subroutine find_among_solved

end module bw_strain_source
