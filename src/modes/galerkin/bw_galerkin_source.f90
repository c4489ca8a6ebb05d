module bw_galerkin_source
  !! Modes without a closed form by their numbers: as many as were solved for, and how amplitudes fall beyond them.
  use bw_kinds, only: dp
  use bw_beam_operator, only: beam_operator
  use bw_galerkin, only: galerkin_modes
  use bw_galerkin_set, only: galerkin_set
  use bw_mode_set, only: mode_set, mode_source
  use bw_monitor, only: monitor_type
  implicit none (type, external)
  private
  public :: galerkin_source_of

  type, extends(mode_source), public :: galerkin_source
    type(galerkin_set) :: solved                   !! the first modes, from which others are taken
  contains
    procedure :: find => find_among_solved
  end type galerkin_source

contains

  subroutine galerkin_source_of(operator, count, source, monitor)
    !! The first `count` modes, and none beyond them.
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count
    type(galerkin_source), intent(out) :: source
    class(monitor_type), intent(inout), optional :: monitor   !! none are found where it asks to stop
    call galerkin_modes(operator, count, source%solved, monitor)
    source%gamma = operator%gamma
    source%highest = count
    source%decay = decay_of(operator, count)
  end subroutine galerkin_source_of

  pure real(dp) function decay_of(operator, count) result(decay)
    !! Of |Φ_k(1)Φ_k(ξ)|/(M_kβ_k) beyond mode `count`: k⁻³ in a beam that its tip mass holds, α being above 1/γ. Where
    !! the mass is light, or waves are those of shear or of a string, k⁻².
    type(beam_operator), intent(in) :: operator
    integer, intent(in) :: count
    real(dp) :: alpha
    alpha = count*acos(-1.0_dp)
    decay = 3.0_dp
    if (alpha*operator%gamma < 1.0_dp .or. allocated(operator%shear)) decay = 2.0_dp
    if (.not. allocated(operator%tension)) return
    if (alpha**2 < operator%tension(1)) decay = 2.0_dp
  end function decay_of

  subroutine find_among_solved(self, number, modes, longest, monitor)
    !! `longest` has no use here: β² has the digits that it has. Nor has the monitor: all is found already.
    class(galerkin_source), intent(in) :: self
    integer, intent(in) :: number(:)
    class(mode_set), allocatable, intent(out) :: modes
    real(dp), intent(in), optional :: longest
    class(monitor_type), intent(inout), optional :: monitor
    type(galerkin_set), allocatable :: found
    allocate (found)
    associate (all => self%solved)
      found%count = size(number)
      found%gamma = all%gamma
      found%resolved = all%resolved
      found%body = all%body
      found%critical_speed = all%critical_speed
      found%alpha = all%alpha(number)
      found%beta_squared = all%beta_squared(number)
      found%tip = all%tip(number)
      found%modal_mass = all%modal_mass(number)
      found%phase_velocity = all%phase_velocity(number)
      found%group_velocity = all%group_velocity(number)
      found%deflection = all%deflection(:, number)
      found%strain = all%strain(:, number)
      found%rotation = all%rotation(number)
      if (allocated(all%turning)) found%turning = all%turning(:, number)
    end associate
    call found%damp(self%damping)
    if (present(longest) .or. present(monitor)) continue
    call move_alloc(found, modes)
  end subroutine find_among_solved

end module bw_galerkin_source
