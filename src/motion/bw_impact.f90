module bw_impact
  !! The impact of a mass on a beam at rest (Eqs 11 and 12, reference [8] of the paper), its capture if it stays (Eqs
  !! 22–26), and the limit of both for infinitely many modes.
  !!
  !! The hub's speed is prescribed, so only modal velocities jump. With the impulse H on the tip, M_iΔq̇_i = φ_i(1)H, m_j(v_j⁺ −
  !! V) = −H and v_tip⁺ − v_j⁺ = eV: H = (1+e)V/(1/m_j + Σφ_i(1)²/M_i). **Limit**: the sum grows with the number of modes, so H
  !! depends on the truncation. Without dimensions: masses in m_i, velocities in V, so the mass arrives with velocity 1.
  !!
  !! In the limit of infinitely many modes before the capture only the mass and the struck point move: the impulse tends
  !! to 0, and the modes of beam and mass start with q̄̇_k(0) = (1+e)γΦ̄_k(1)/M̄_k. Runs with a tolerance converge to
  !! this limit, and truncation errors refer to it. If bodies of mass m are at the struck point, Σφ_i²/M_i tends to 1/m:
  !! both masses collide as if there were no beam, and q̄̇_k(0) is the same.
  use bw_double_double, only: accurate_sum
  use bw_event, only: capture_event, event_type, impact_event
  use bw_kinds, only: dp
  use bw_mode_set, only: first_struck_mode, mode_set
  use bw_monitor, only: monitor_type
  implicit none (type, external)
  private
  public :: strike, capture_mass, continuum_velocity, continuum_impact, continuum_capture

  type, public :: impact_type
    !! The state just after the impact.
    real(dp) :: gamma = 0.0_dp                 !! mass ratio γ of the striking mass
    real(dp) :: restitution = 0.0_dp           !! e
    real(dp) :: impulse = 0.0_dp               !! H
    real(dp) :: mass_velocity = 0.0_dp         !! v_j⁺
    real(dp) :: tip_velocity = 0.0_dp          !! v_tip⁺
    real(dp), allocatable :: modal_velocity(:) !! Δq̇_i, (modes)
    type(event_type) :: event
  end type impact_type

  type, public :: capture_type
    !! The state just after the capture.
    real(dp), allocatable :: modal_velocity(:)   !! q̄̇_k(0) in V, (modes after)
    type(event_type) :: event
  end type capture_type

contains

  pure type(impact_type) function strike(modes, gamma, restitution) result(impact)
    !! Return the impulse, and the velocities just after it, by Eqs 11 and 12 with restitution.
    class(mode_set), intent(in) :: modes       !! of the beam alone
    real(dp), intent(in) :: gamma              !! m_j/m_i ≥ 0; 0 moves nothing
    real(dp), intent(in) :: restitution        !! 0 ≤ e ≤ 1
    real(dp) :: mobility, light, heavy, total
    mobility = accurate_sum(modes%struck**2/modes%modal_mass)   ! Σφ_i(1)²/M_i
    light = 1.0_dp/max(1.0_dp, gamma)                        ! 1 and γ, both divided by the larger
    heavy = min(1.0_dp, gamma)
    total = light + heavy*mobility
    impact%gamma = gamma
    impact%restitution = restitution
    impact%impulse = (1.0_dp + restitution)*heavy/total
    impact%mass_velocity = (heavy*mobility - restitution*light)/total
    impact%tip_velocity = (1.0_dp + restitution)*heavy*mobility/total
    impact%modal_velocity = modes%struck*impact%impulse/modes%modal_mass
    impact%event = impact_balance(modes, impact)
  end function strike

  pure type(event_type) function impact_balance(modes, impact) result(event)
    !! Return kinetic energy and the first mode's generalised momentum, M_1Δq̇_1/φ_1(ξ₀) + m_jv_j, before and after the impact.
    class(mode_set), intent(in) :: modes
    type(impact_type), intent(in) :: impact
    integer :: k
    event%kind = impact_event
    event%impulse = impact%impulse
    event%energy_before = 0.5_dp*impact%gamma
    event%energy_after = 0.5_dp*accurate_sum(modes%modal_mass*impact%modal_velocity**2) &
      + 0.5_dp*impact%gamma*impact%mass_velocity**2
    event%momentum_before = impact%gamma
    k = first_struck_mode(modes)
    event%momentum_after = modes%modal_mass(k)*impact%modal_velocity(k)/modes%struck(k) &
      + impact%gamma*impact%mass_velocity
  end function impact_balance

  type(capture_type) function capture_mass(before, impact, after, monitor) result(capture)
    !! Capture the mass by Eq. 26. With restitution e > 0 Eqs 22–26 give it the tip's velocity: this adds the momentum
    !! m_j e V, and energy.
    class(mode_set), intent(in) :: before  !! modes of the beam alone
    type(impact_type), intent(in) :: impact      !! the state just after the impact
    class(mode_set), intent(in) :: after   !! modes of beam and mass
    class(monitor_type), intent(inout), optional :: monitor   !! the state is invalid if it requests a stop
    real(dp), allocatable :: momentum(:)
    allocate (momentum, source=after%overlap(before, impact%modal_velocity, .true., monitor))
    capture%modal_velocity = momentum/after%modal_mass
    capture%event = capture_balance(before, impact, after, capture%modal_velocity)
  end function capture_mass

  type(event_type) function capture_balance(before, impact, after, velocity) result(event)
    !! Return kinetic energy, and the generalised momentum of the first mode after, (∫Φ̄_1v dξ + γΦ̄_1(ξ₀)v_j)/Φ̄_1(ξ₀).
    class(mode_set), intent(in) :: before, after
    type(impact_type), intent(in) :: impact
    real(dp), intent(in) :: velocity(:)
    real(dp) :: seen(before%count)             ! overlaps with the first mode after
    integer :: i, k
    k = first_struck_mode(after)
    seen = before%overlap(after, [(merge(1.0_dp, 0.0_dp, i == k), i=1, k)], .false.)
    event%kind = capture_event
    event%energy_before = impact%event%energy_after
    event%energy_after = 0.5_dp*accurate_sum(after%modal_mass*velocity**2)
    event%momentum_before = accurate_sum(seen*impact%modal_velocity)/after%struck(k) + impact%gamma*impact%mass_velocity
    event%momentum_after = after%modal_mass(k)*velocity(k)/after%struck(k)
  end function capture_balance

  pure function continuum_velocity(modes, gamma, restitution) result(velocity)
    !! Return q̄̇_k(0), (modes).
    class(mode_set), intent(in) :: modes       !! of beam and mass
    real(dp), intent(in) :: gamma              !! mass ratio
    real(dp), intent(in) :: restitution        !! e
    real(dp) :: velocity(modes%count)
    velocity = (1.0_dp + restitution)*gamma*modes%struck/modes%modal_mass
  end function continuum_velocity

  pure type(impact_type) function continuum_impact(gamma, restitution, held) result(impact)
    !! Return the state just after the impact in the limit: the beam is at rest except at the struck point.
    real(dp), intent(in) :: gamma, restitution
    real(dp), intent(in) :: held               !! mass of bodies at the struck point
    real(dp) :: share                          !! of the striking mass in all that moves then
    share = 1.0_dp
    if (held > 0.0_dp) share = gamma/(gamma + held)
    impact%gamma = gamma
    impact%restitution = restitution
    impact%impulse = (1.0_dp + restitution)*held*share
    impact%mass_velocity = share
    if (held > 0.0_dp) impact%mass_velocity = share - restitution*(held/(gamma + held))
    impact%tip_velocity = (1.0_dp + restitution)*share
    impact%event%kind = impact_event
    impact%event%impulse = impact%impulse
    impact%event%energy_before = 0.5_dp*gamma
    impact%event%energy_after = 0.5_dp*gamma*impact%mass_velocity**2 + 0.5_dp*held*impact%tip_velocity**2
    impact%event%momentum_before = gamma
    impact%event%momentum_after = gamma*impact%mass_velocity + held*impact%tip_velocity
  end function continuum_impact

  pure type(event_type) function continuum_capture(impact, held) result(event)
    !! Return the capture in that limit. The mass takes the velocity of the struck point, which has all momentum and energy.
    type(impact_type), intent(in) :: impact
    real(dp), intent(in) :: held               !! see `continuum_impact`
    event%kind = capture_event
    event%energy_before = impact%event%energy_after
    event%energy_after = 0.5_dp*(impact%gamma + held)*impact%tip_velocity**2
    event%momentum_before = impact%event%momentum_after
    event%momentum_after = impact%gamma*(1.0_dp + impact%restitution)
  end function continuum_capture

end module bw_impact
