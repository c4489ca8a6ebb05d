module bw_release
  !! The captured mass leaves. Displacement and velocity of the beam are continuous; the state goes over to the modes of
  !! the beam alone by its projection with the beam's own weight ρA. The mass leaves with the velocity of the tip.
  !!
  !! Energies are those that a rotating frame keeps: kinetic and elastic, less ½ω² times the second moment of what
  !! turns in the plane of the motion, and with tension the work against the centrifugal force along the beam. What a body
  !! has of that leaves with it, and so does its spin. What a projection on finitely many modes loses is never negative where
  !! none of those that are left out grows.
  use bw_event, only: event_type, release_event
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_mode_set, only: first_struck, mode_set
  use bw_monitor, only: monitor_type
  use bw_segment, only: energy_type, known_energy, mass_energy, state_energy, operator(+)
  implicit none (type, external)
  private
  public :: release_mass

  real(dp), parameter :: projection_rounding = 1.0e-13_dp   !! of integrals of two shapes, relatively

  type, public :: tip_remainder
    !! Of infinitely many modes at the release: what those that are not there add. Units of bw_segment.
    integer :: count = 0                         !! modes that were looked at
    real(dp) :: displacement = 0.0_dp            !! of the tip, by those of them that are not there
    real(dp) :: velocity = 0.0_dp
    real(dp) :: uncertainty = 0.0_dp             !! of that velocity, by modes that were not looked at
    real(dp) :: energy = 0.0_dp                  !! of beam and body, by all modes
  end type tip_remainder

  type, public :: release_type
    !! The state just after the release; units of bw_segment.
    real(dp), allocatable :: q(:), rate(:)       !! of the beam alone, (modes)
    real(dp) :: energy_leaving = missing         !! that the mass takes with it; missing where rounding has left no digits
    real(dp) :: kinetic_leaving = 0.0_dp         !! the same without the part of the centrifugal force
    real(dp) :: energy_lost = missing            !! that the modes of the beam alone do not hold; missing as above
    type(event_type) :: event
  end type release_type

contains

  type(release_type) function release_mass(loaded, q, rate, free, speed, remainder, energy, monitor) result(release)
    !! Displacement and velocity of the beam go on as they were, the mass leaves with the tip's velocity. Where modes far
    !! above those of the beam alone are not there, all of them together are the blow −γφ_i(1) times what they add at the
    !! tip (bw_tip_remainder).
    class(mode_set), intent(in) :: loaded        !! modes of beam and mass
    real(dp), intent(in) :: q(:), rate(:)        !! their state
    class(mode_set), intent(in) :: free          !! modes of the beam alone
    real(dp), intent(in) :: speed                !! angular velocity in the plane of the motion, else 0
    type(tip_remainder), intent(in), optional :: remainder !! absent: the modes are what there is, however few
    type(energy_type), intent(in), optional :: energy    !! of beam and mass until then; absent: that of the state
    class(monitor_type), intent(inout), optional :: monitor   !! the state means nothing where it asks to stop
    real(dp) :: tip_displacement, tip_velocity
    integer :: i, k
    type(energy_type) :: before, leaving, after
    tip_displacement = dot_product(loaded%struck, q)
    tip_velocity = dot_product(loaded%struck, rate)
    allocate (release%q(free%count), release%rate(free%count))
    release%q = free%overlap_of_beam(loaded, q, monitor)/free%modal_mass
    release%rate = free%overlap_of_beam(loaded, rate, monitor)/free%modal_mass
    if (present(remainder)) then
      release%q = release%q - loaded%gamma*remainder%displacement*free%struck/free%modal_mass
      release%rate = release%rate - loaded%gamma*remainder%velocity*free%struck/free%modal_mass
      tip_displacement = tip_displacement + remainder%displacement
      tip_velocity = tip_velocity + remainder%velocity
    end if
    call take_body(loaded, q, rate, tip_displacement, tip_velocity, speed, leaving, release)
    before = state_energy(loaded, q, rate)
    if (present(energy)) before = energy
    after = before                               ! infinitely many modes of the beam alone hold what is not leaving
    if (.not. present(remainder)) after = state_energy(free, release%q, release%rate, projection_rounding) + leaving
    associate (event => release%event)
      event%kind = release_event
      event%energy_before = known_energy(before)
      event%energy_after = known_energy(after)
      k = first_struck(free)
      event%momentum_before = dot_product(loaded%overlap_with_mass(free, [(merge(1.0_dp, 0.0_dp, i == k), i=1, k)]), rate) &
        /free%struck(k)
      event%momentum_after = free%modal_mass(k)*release%rate(k)/free%struck(k) + loaded%gamma*tip_velocity
    end associate
    if (.not. is_missing(release%event%energy_after)) release%energy_lost = before%value - after%value
  end function release_mass

  pure subroutine take_body(loaded, q, rate, displacement, velocity, speed, leaving, release)
    !! What the body takes with it.
    class(mode_set), intent(in) :: loaded
    real(dp), intent(in) :: q(:), rate(:)
    real(dp), intent(in) :: displacement, velocity       !! of the tip
    real(dp), intent(in) :: speed
    type(energy_type), intent(out) :: leaving
    type(release_type), intent(inout) :: release
    type(energy_type) :: kinetic
    real(dp) :: body(2)
    body = loaded%body_energy(q, rate)
    leaving = mass_energy(loaded%gamma, displacement, velocity, speed) &
      + energy_type(sum(body), projection_rounding*sum(body))
    kinetic = mass_energy(loaded%gamma, displacement, velocity, 0.0_dp)
    release%energy_leaving = known_energy(leaving)
    release%kinetic_leaving = kinetic%value + body(1)
  end subroutine take_body

end module bw_release
