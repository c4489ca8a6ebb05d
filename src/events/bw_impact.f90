module bw_impact
  !! The blow: a mass strikes the tip of a beam at rest (Eqs 11 and 12, reference [8] of the paper).
  !!
  !! The hub's speed is prescribed, so only the modal velocities jump. With H the impulse on the tip,
  !! M_iΔq̇_i = φ_i(1)H, m_j(v_j⁺ − V) = −H and v_tip⁺ − v_j⁺ = eV:
  !! H = (1+e)V/(1/m_j + Σφ_i(1)²/M_i). **Limit**: the sum grows with the number of modes, so H belongs to its
  !! truncation. Without dimensions: masses in m_i, velocities in V; the mass then comes with velocity 1.
  use bw_kinds, only: dp
  use bw_double_double, only: accurate_sum
  use bw_event, only: event_type, impact_event
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: strike

  type, public :: impact_type
    !! The state just after the impact.
    real(dp) :: gamma = 0.0_dp                 !! mass ratio γ of the mass that struck
    real(dp) :: restitution = 0.0_dp           !! e
    real(dp) :: impulse = 0.0_dp               !! H
    real(dp) :: mass_velocity = 0.0_dp         !! v_j⁺
    real(dp) :: tip_velocity = 0.0_dp          !! v_tip⁺
    real(dp), allocatable :: modal_velocity(:) !! Δq̇_i, (modes)
    type(event_type) :: event
  end type impact_type

contains

  pure type(impact_type) function strike(modes, gamma, restitution) result(impact)
    !! Eqs 11 and 12 with restitution: the impulse, and the velocities just after it.
    class(mode_set), intent(in) :: modes       !! of the beam alone
    real(dp), intent(in) :: gamma              !! m_j/m_i ≥ 0; 0 moves nothing
    real(dp), intent(in) :: restitution        !! 0 ≤ e ≤ 1
    real(dp) :: mobility, light, heavy, total
    mobility = accurate_sum(modes%tip**2/modes%modal_mass)   ! Σφ_i(1)²/M_i
    light = 1.0_dp/max(1.0_dp, gamma)                        ! 1 and γ, both divided by the larger
    heavy = min(1.0_dp, gamma)
    total = light + heavy*mobility
    impact%gamma = gamma
    impact%restitution = restitution
    impact%impulse = (1.0_dp + restitution)*heavy/total
    impact%mass_velocity = (heavy*mobility - restitution*light)/total
    impact%tip_velocity = (1.0_dp + restitution)*heavy*mobility/total
    impact%modal_velocity = modes%tip*impact%impulse/modes%modal_mass
    impact%event = balance(modes, impact)
  end function strike

  pure type(event_type) function balance(modes, impact) result(event)
    !! Kinetic energy and the first mode's generalised momentum, M_1Δq̇_1/φ_1(1) + m_jv_j, before and after.
    class(mode_set), intent(in) :: modes
    type(impact_type), intent(in) :: impact
    event%kind = impact_event
    event%impulse = impact%impulse
    event%energy_before = 0.5_dp*impact%gamma
    event%energy_after = 0.5_dp*accurate_sum(modes%modal_mass*impact%modal_velocity**2) &
      + 0.5_dp*impact%gamma*impact%mass_velocity**2
    event%momentum_before = impact%gamma
    event%momentum_after = modes%modal_mass(1)*impact%modal_velocity(1)/modes%tip(1) &
      + impact%gamma*impact%mass_velocity
  end function balance

end module bw_impact
