module bw_blow
  !! All that happens at t = 0: the impact, and the capture if the mass stays. Without dimensions: masses in m_i, velocities
  !! in the approach velocity V.
  use bw_capture, only: capture_type, capture_mass
  use bw_continuum, only: continuum_capture, continuum_impact, continuum_velocity
  use bw_event, only: event_type
  use bw_impact, only: impact_type, strike
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, part_monitor
  implicit none (type, external)
  private
  public :: blow_of, continuum_blow

  type, public :: blow_type
    !! What it leaves.
    type(impact_type) :: impact
    real(dp), allocatable :: modal_velocity(:)    !! after the last event, (modes)
    real(dp), allocatable :: velocity_jump(:)     !! at the impact along the beam, Fig. 3, (profile)
    type(event_type), allocatable :: events(:)
  end type blow_type

contains

  subroutine blow_of(free, loaded, gamma, e, profile_points, monitor, blow)
    !! With finitely many modes.
    class(mode_set), intent(in) :: free                !! modes of the beam alone
    class(mode_set), intent(in), optional :: loaded    !! modes of beam and mass; absent: the mass is not captured
    real(dp), intent(in) :: gamma, e                   !! mass ratio, restitution
    integer, intent(in) :: profile_points
    class(monitor_type), intent(inout), target :: monitor    !! what is left means nothing where it asks to stop
    type(blow_type), intent(out) :: blow
    real(dp), parameter :: handed_on = 10.0_dp               ! a mode takes as long as its shape at so many points
    type(capture_type) :: capture
    type(part_monitor) :: part
    real(dp) :: share
    blow%impact = strike(free, gamma, e)
    share = 0.0_dp
    if (present(loaded)) then
      share = handed_on*(1.0_dp + loaded%count/real(free%count, dp))
      share = share/(share + profile_points)
      part = part_monitor(monitor, 0.0_dp, share)
      capture = capture_mass(free, blow%impact, loaded, part)
      call move_alloc(capture%modal_velocity, blow%modal_velocity)
      blow%events = [blow%impact%event, capture%event]
    else
      blow%modal_velocity = blow%impact%modal_velocity
      blow%events = [blow%impact%event]
    end if
    part = part_monitor(monitor, share, 1.0_dp - share)
    call find_jump(free, blow%impact%modal_velocity, profile_points, part, blow%velocity_jump)
  end subroutine blow_of

  pure subroutine continuum_blow(loaded, gamma, e, profile_points, blow)
    !! With infinitely many modes before the capture: only the tip jumps.
    class(mode_set), intent(in) :: loaded              !! modes of beam and mass
    real(dp), intent(in) :: gamma, e
    integer, intent(in) :: profile_points
    type(blow_type), intent(out) :: blow
    blow%impact = continuum_impact(gamma, e)
    blow%modal_velocity = continuum_velocity(loaded, gamma, e)
    blow%events = [blow%impact%event, continuum_capture(gamma, e)]
    allocate (blow%velocity_jump(profile_points), source=0.0_dp)
    blow%velocity_jump(profile_points) = blow%impact%tip_velocity
  end subroutine continuum_blow

  subroutine find_jump(free, modal_velocity, profile_points, monitor, jump)
    !! Σφ_i(ξ)Δq̇_i along the beam, as many shapes at a time as may be held.
    class(mode_set), intent(in) :: free
    real(dp), intent(in) :: modal_velocity(:)
    integer, intent(in) :: profile_points
    class(monitor_type), intent(inout) :: monitor
    real(dp), allocatable, intent(out) :: jump(:)      !! (profile)
    real(dp) :: profile(profile_points)
    integer, parameter :: most_numbers = 2000000       ! of shapes held at a time
    integer :: block, first, i, j, k, last
    profile = [(real(j, dp)/(profile_points - 1), j=0, profile_points - 1)]
    allocate (jump(profile_points), source=0.0_dp)
    block = max(1, most_numbers/free%count)
    do first = 1, profile_points, block
      last = min(first + block - 1, profile_points)
      do i = 1, free%count, most_numbers
        if (monitor%stop_requested()) return
        k = min(i + most_numbers - 1, free%count)
        jump(first:last) = jump(first:last) + matmul(modal_velocity(i:k), free%some_shapes(i, k, profile(first:last)))
      end do
      call monitor%advance(real(last, dp)/profile_points)
    end do
  end subroutine find_jump

end module bw_blow
