module bw_course
  !! The motion between two events: a set of modes, when it starts, and the state that it starts from. Everything that
  !! follows until the next event is exact: the flow of each mode.
  !!
  !! Without dimensions: times in l²/h, velocities in the approach velocity V, displacements in V l²/h.
  use bw_double_double, only: accurate_sum, dd
  use bw_kinds, only: dp
  use bw_modal_flow, only: flow, slow_exponent
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: move, beam_energy, growth_ends, growth_error, leaves_range

  integer, parameter, public :: free_modes = 1, loaded_modes = 2, held_modes = 3
    !! of the beam alone, of the beam with the captured mass, of the beam with a mass that is pressed against it

  type, public :: course_type
    integer :: modes = free_modes            !! which set moves, a number above
    type(dd) :: start                        !! when
    real(dp), allocatable :: q(:)            !! modal displacements then, (modes)
    real(dp), allocatable :: rate(:)         !! modal velocities then, (modes)
    real(dp) :: start_error = 0.0_dp         !! estimate of the error of `start`, where contacts amplify errors
    real(dp), allocatable :: error(:, :)
      !! the same of modal displacements and velocities until the next course; else unallocated, (modes, 2)
  end type course_type

  real(dp), parameter, public :: largest_exponent = 300.0_dp   !! of growth whose energy is still a number

contains

  pure subroutine move(modes, elapsed, q, rate)
    !! The state a time later.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed          !! ≥ 0
    real(dp), intent(inout) :: q(:), rate(:) !! (modes)
    if (allocated(modes%damping)) then
      call flow(modes%beta_squared, modes%damping, elapsed, q, rate)
    else
      call flow(modes%beta_squared, 0.0_dp, elapsed, q, rate)
    end if
  end subroutine move

  pure real(dp) function growth_ends(modes) result(time)
    !! When a mode has grown so much that its energy would be no number; beyond any number where none grows.
    class(mode_set), intent(in) :: modes
    type(dd) :: exponent(modes%count)
    if (allocated(modes%damping)) then
      exponent = slow_exponent(modes%beta_squared, modes%damping)
    else
      exponent = slow_exponent(modes%beta_squared, 0.0_dp)
    end if
    time = huge(time)
    if (any(exponent%hi > 0.0_dp)) time = largest_exponent/maxval(exponent%hi)
  end function growth_ends

  pure logical function leaves_range(modes, elapsed)
    !! A mode grows so much in that time that its energy would be no number.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed
    leaves_range = elapsed%hi > growth_ends(modes)
  end function leaves_range

  pure real(dp) function growth_error(modes, elapsed) result(error)
    !! Of exp(σt) at the end, as a part of it: the growth rate σ has the digits of binary64.
    class(mode_set), intent(in) :: modes     !! growing ones among them
    real(dp), intent(in) :: elapsed
    error = epsilon(error)*sqrt(max(0.0_dp, maxval(-modes%beta_squared%hi)))*elapsed
  end function growth_error

  pure real(dp) function beam_energy(modes, q, rate) result(energy)
    !! ½ΣM(q̇² + β²q²), m_iV²: kinetic energy and strain, less that of the centrifugal force in the plane of rotation.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:)
    energy = 0.5_dp*accurate_sum(modes%modal_mass*(rate**2 + modes%beta_squared%hi*q**2))
  end function beam_energy

end module bw_course
