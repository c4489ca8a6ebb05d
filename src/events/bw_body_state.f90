module bw_body_state
  !! A beam and a mass that moves freely beside its tip: their state at a time, their energy and momentum, and how they
  !! move on. The mass runs in a guide that turns with the hub, y'' = ω²y in the plane of rotation and y'' = 0 out of it.
  !! Units of bw_course.
  use bw_course, only: move
  use bw_double_double, only: dd, to_dd, operator(+), operator(-), operator(*)
  use bw_energy, only: energy_later, energy_type, mass_energy, sharper, state_energy, operator(+)
  use bw_kinds, only: dp
  use bw_modal_flow, only: flow
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: energy_of, energy_reached, momentum_of, state_at

  type, public :: body_state
    !! Beam and mass at a time.
    type(dd) :: time
    real(dp), allocatable :: q(:), rate(:)
    real(dp) :: place = 0.0_dp, speed = 0.0_dp    !! of the mass
  end type body_state

contains

  pure type(energy_type) function energy_of(free, gamma, omega, state) result(energy)
    !! The Jacobi energy ½ΣM(q̇² + β²q²) + ½m_j(ẏ² − ω²y²), which never grows.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: gamma, omega
    type(body_state), intent(in) :: state
    energy = state_energy(free, state%q, state%rate) + mass_energy(gamma, state%place, state%speed, omega)
  end function energy_of

  pure type(energy_type) function energy_reached(free, gamma, omega, start, state, energy) result(later)
    !! The same after free motion from a start whose energy is known; that of the mass does not change.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: gamma, omega
    type(body_state), intent(in) :: start, state
    type(energy_type), intent(in) :: energy       !! at the start
    later = sharper(energy_later(free, state%time - start%time, start%q, start%rate, energy), &
                    energy_of(free, gamma, omega, state))
  end function energy_reached

  pure real(dp) function momentum_of(free, gamma, state) result(momentum)
    !! Generalised, of the first mode, per unit of its tip displacement.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: gamma
    type(body_state), intent(in) :: state
    momentum = free%modal_mass(1)*state%rate(1)/free%tip(1) + gamma*state%speed
  end function momentum_of

  type(body_state) function state_at(free, omega, state, elapsed) result(later)
    !! After a time of free motion.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: omega, elapsed
    type(body_state), intent(in) :: state
    later = state
    later%time = state%time + to_dd(elapsed)
    call move(free, to_dd(elapsed), later%q, later%rate)
    call flow(to_dd(omega)*(-omega), 0.0_dp, to_dd(elapsed), later%place, later%speed)
  end function state_at

end module bw_body_state
