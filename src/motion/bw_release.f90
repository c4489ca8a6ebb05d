module bw_release
  !! The release of the captured mass, which leaves with the velocity of its place on the beam: its energy, and that of
  !! the modes of the beam alone, onto which the motion is projected (bw_projection).
  !!
  !! Energies are those conserved in a rotating frame: kinetic and elastic, less ½ω² times the second moment of mass in the
  !! plane of motion, and with tension the work against the centrifugal force along the beam. A body takes its part with it, and
  !! its rotation. The projection onto finitely many modes never gains energy if all omitted modes are stable.
  use bw_event, only: event_type, release_event
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_mode_set, only: first_struck_mode, mean_rate, mode_set
  use bw_projection, only: projection_rounding, projection_type
  use bw_segment, only: energy_type, known_energy, mass_energy, state_energy, operator(+)
  implicit none (type, external)
  private
  public :: energy_after, release_mass


  type, public :: release_type
    !! The release of a mass. Units of bw_segment.
    real(dp) :: energy_leaving = missing         !! of the mass; missing if rounding leaves no digits
    real(dp) :: kinetic_leaving = 0.0_dp         !! without the centrifugal potential
    real(dp) :: energy_lost = missing            !! not in the modes of the beam alone; missing as above
    type(event_type) :: event
  end type release_type

contains

  type(release_type) function release_mass(projection, after, speed, energy, whole) result(release)
    !! Release the mass, and find the event's energies and momenta. With all modes the beam keeps what does not leave.
    type(projection_type), intent(in) :: projection
    class(mode_set), intent(in) :: after         !! modes of the beam alone
    real(dp), intent(in) :: speed                !! angular velocity in the plane of motion, else 0
    type(energy_type), intent(in) :: energy      !! of beam and mass before
    logical, intent(in) :: whole                 !! the motion is that of all modes, not only of those before
    type(energy_type) :: leaving, left
    real(dp) :: place(2)
    integer :: i, k
    associate (before => projection%before, q => projection%q, rate => projection%rate, event => release%event)
      place = [dot_product(before%struck, q), dot_product(before%struck, rate)]
      if (whole) place = [projection%place%displacement, projection%place%velocity]
      call take_body(projection, place, speed, leaving, release)
      left = energy
      if (.not. whole) left = state_energy(after, projection%q_after, projection%rate_after, projection_rounding) + leaving
      event%kind = release_event
      event%energy_before = known_energy(energy)
      event%energy_after = known_energy(left)
      k = first_struck_mode(after)
      event%momentum_before = dot_product(before%overlap(after, [(merge(1.0_dp, 0.0_dp, i == k), i=1, k)], .true.), rate) &
        /after%struck(k)
      event%momentum_after = after%modal_mass(k)*projection%rate_after(k)/after%struck(k) + before%gamma*place(2)
      event%hub_rate_change = mean_rate(after, projection%rate_after) - mean_rate(before, rate)
      if (.not. is_missing(event%energy_after)) release%energy_lost = energy%value - left%value
    end associate
  end function release_mass

  pure subroutine take_body(projection, place, speed, leaving, release)
    !! Find the energy of the leaving body.
    type(projection_type), intent(in) :: projection
    real(dp), intent(in) :: place(2)             !! displacement and velocity of the body
    real(dp), intent(in) :: speed
    type(energy_type), intent(out) :: leaving
    type(release_type), intent(inout) :: release
    type(energy_type) :: kinetic
    real(dp) :: body(2)
    associate (before => projection%before)
      body = before%body_energy(projection%q, projection%rate)
      leaving = mass_energy(before%gamma, place(1), place(2), speed) + energy_type(sum(body), projection_rounding*sum(body))
      kinetic = mass_energy(before%gamma, place(1), place(2), 0.0_dp)
    end associate
    release%energy_leaving = known_energy(leaving)
    release%kinetic_leaving = kinetic%value + body(1)
  end subroutine take_body

  pure real(dp) function energy_after(projection, after, speed) result(energy)
    !! Return an upper bound of the energy in all modes of the beam alone, with errors of the body's motion and rounding.
    type(projection_type), intent(in) :: projection
    class(mode_set), intent(in) :: after
    real(dp), intent(in) :: speed                !! see `release_mass`
    real(dp) :: doubt(2)
    type(energy_type) :: leaving, rounding
    type(release_type) :: release
    associate (place => projection%place, gamma => projection%before%gamma)
      call take_body(projection, [place%displacement, place%velocity], speed, leaving, release)
      doubt(2) = sqrt(2.0_dp*place%missing_energy*place%mobility)
      doubt(1) = 0.0_dp                          ! if unknown, see bound_errors of bw_projection
      if (place%square > 0.0_dp) doubt(1) = doubt(2)/sqrt(place%square)
      rounding = state_energy(after, projection%q_after, projection%rate_after, projection_rounding)
      energy = place%energy - leaving%value + leaving%rounding + rounding%rounding + gamma*(abs(place%velocity)*doubt(2) &
        + 0.5_dp*doubt(2)**2 + speed**2*(abs(place%displacement)*doubt(1) + 0.5_dp*doubt(1)**2))
    end associate
  end function energy_after

end module bw_release
