module bw_capture
  !! The mass stays at the tip: the velocities carry over into the modes of beam and mass (Eqs 22–26).
  use bw_kinds, only: dp
  use bw_double_double, only: accurate_sum
  use bw_event, only: event_type, capture_event
  use bw_impact, only: impact_type
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  implicit none (type, external)
  private
  public :: capture_mass

  type, public :: capture_type
    !! The state just after the capture.
    real(dp), allocatable :: modal_velocity(:)   !! q̄̇_k(0) in V, (modes after)
    type(event_type) :: event
  end type capture_type

contains

  type(capture_type) function capture_mass(before, impact, after, monitor) result(capture)
    !! Eq. 26. With restitution e > 0 Eqs 22–26 give the mass the tip's velocity: the capture then adds the
    !! momentum m_j e V, and energy.
    class(mode_set), intent(in) :: before  !! modes of the beam alone
    type(impact_type), intent(in) :: impact      !! the state just after the impact
    class(mode_set), intent(in) :: after   !! modes of beam and mass
    class(monitor_type), intent(inout), optional :: monitor   !! the state means nothing where it asks to stop
    real(dp), allocatable :: momentum(:)
    allocate (momentum, source=after%overlap_with_mass(before, impact%modal_velocity, monitor))
    capture%modal_velocity = momentum/after%modal_mass
    capture%event = balance(before, impact, after, capture%modal_velocity)
  end function capture_mass

  type(event_type) function balance(before, impact, after, velocity) result(event)
    !! Kinetic energy, and the generalised momentum of the first mode after, ∫Φ̄_1v dξ + γΦ̄_1(1)v_j over Φ̄_1(1).
    class(mode_set), intent(in) :: before, after
    type(impact_type), intent(in) :: impact
    real(dp), intent(in) :: velocity(:)
    real(dp) :: seen(before%count)             ! what the modes before see of the first mode after
    seen = before%overlap_of_beam(after, [1.0_dp])
    event%kind = capture_event
    event%energy_before = impact%event%energy_after
    event%energy_after = 0.5_dp*accurate_sum(after%modal_mass*velocity**2)
    event%momentum_before = accurate_sum(seen*impact%modal_velocity)/after%tip(1) + impact%gamma*impact%mass_velocity
    event%momentum_after = after%modal_mass(1)*velocity(1)/after%tip(1)
  end function balance

end module bw_capture
