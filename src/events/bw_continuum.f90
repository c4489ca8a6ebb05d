module bw_continuum
  !! The limit of infinitely many modes before the capture: the beam is at rest and only the mass moves. This is what
  !! tolerance-driven runs approximate, and what the error of a truncation is measured against.
  !!
  !! The impulse of the impact goes to 0 and the jump gathers at the tip, so the modes of beam and mass start with
  !! q̄̇_k(0) = (1+e)γΦ̄_k(1)/M̄_k. Without dimensions: masses in m_i, velocities in V.
  use bw_kinds, only: dp
  use bw_event, only: event_type, impact_event, capture_event
  use bw_impact, only: impact_type
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: continuum_velocity, continuum_impact, continuum_capture

contains

  pure function continuum_velocity(modes, gamma, restitution) result(velocity)
    !! q̄̇_k(0), (modes).
    class(mode_set), intent(in) :: modes       !! of beam and mass
    real(dp), intent(in) :: gamma              !! mass ratio
    real(dp), intent(in) :: restitution        !! e
    real(dp) :: velocity(modes%count)
    velocity = (1.0_dp + restitution)*gamma*modes%tip/modes%modal_mass
  end function continuum_velocity

  pure type(impact_type) function continuum_impact(gamma, restitution) result(impact)
    !! The state just after the impact: all of the beam at rest but its tip.
    real(dp), intent(in) :: gamma, restitution
    impact%gamma = gamma
    impact%restitution = restitution
    impact%impulse = 0.0_dp
    impact%mass_velocity = 1.0_dp
    impact%tip_velocity = 1.0_dp + restitution
    impact%event%kind = impact_event
    impact%event%energy_before = 0.5_dp*gamma
    impact%event%energy_after = 0.5_dp*gamma
    impact%event%momentum_before = gamma
    impact%event%momentum_after = gamma
  end function continuum_impact

  pure type(event_type) function continuum_capture(gamma, restitution) result(event)
    !! The capture gives the mass the tip's velocity: all modes together hold its momentum and energy.
    real(dp), intent(in) :: gamma, restitution
    event%kind = capture_event
    event%energy_before = 0.5_dp*gamma
    event%energy_after = 0.5_dp*gamma*(1.0_dp + restitution)**2
    event%momentum_before = gamma
    event%momentum_after = gamma*(1.0_dp + restitution)
  end function continuum_capture

end module bw_continuum
