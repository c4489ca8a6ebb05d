module bw_junction_waves
  !! Transmission and reflection of bending waves at a junction: a body, a spring or a step of the section between two pieces.
  !!
  !! Both pieces are taken as infinite, so the coefficients belong to the junction alone. A bending wave of frequency Ω arrives
  !! from the root's side. Two waves leave in either piece, e^(∓κx); decaying ones carry no power by themselves. v, ψ, M and N
  !! on the two sides differ by what the junction adds, which gives four equations for four amplitudes. Undamped, the power ½Ω
  !! Im(v*N + ψ*M) is conserved. Outgoing waves are those that decay outwards under vanishing damping.
  use bw_beam_states, only: deflection, inertia_at, inertia_type, states_before_joint, moment, piece_state, shear_force, solve, &
    turning, waves_of
  use bw_kinds, only: dp
  use bw_piece_beam, only: piece_beam
  implicit none (type, external)
  private
  public :: find_scattered

  integer, parameter :: bending = 2              !! the wave that propagates at every frequency

contains

  pure subroutine find_scattered(beam, joint, square, transmitted, reflected)
    !! Find the shares of a bending wave's power that a junction transmits and reflects; beyond the shear cutoff into
    !! both waves of a piece.
    type(piece_beam), intent(in) :: beam         !! without tension
    integer, intent(in) :: joint                 !! one of `junctions_of`
    real(dp), intent(in) :: square               !! Ω² > 0
    real(dp), intent(out) :: transmitted, reflected
    real(dp), parameter :: damping = 1.0e-30_dp  ! vanishes beside 1
    type(inertia_type) :: inertia
    complex(dp) :: incident(4), back(4, 2), onwards(4, 2), system(4, 4), amplitude(4)
    inertia = inertia_at(beam, square*cmplx(1.0_dp, -damping, dp))
    back = running(waves_of(beam%piece(joint), inertia), -1.0_dp)
    onwards = running(waves_of(beam%piece(joint + 1), inertia), 1.0_dp)
    incident = back(:, bending)
    incident([turning, shear_force]) = -incident([turning, shear_force])
    system(:, :2) = states_before_joint(beam%joint(joint), inertia, onwards)
    system(:, 3:) = -back
    amplitude = incident
    call solve(system, amplitude)
    transmitted = power(matmul(onwards, amplitude(:2)))/power(incident)
    reflected = -power(matmul(back, amplitude(3:)))/power(incident)
  end subroutine find_scattered

  pure function running(waves, direction) result(states)
    !! Return the states of a piece's two waves with v = 1.
    type(piece_state), intent(in) :: waves
    real(dp), intent(in) :: direction            !! 1: outwards; -1: towards the root
    complex(dp) :: states(4, 2)
    states(deflection, :) = 1.0_dp
    states(turning, :) = -direction*waves%turn
    states(moment, :) = waves%bend
    states(shear_force, :) = -direction*waves%force
  end function running

  pure real(dp) function power(state)
    !! Return the outward power over −½Ω.
    complex(dp), intent(in) :: state(4)
    power = aimag(conjg(state(deflection))*state(shear_force) + conjg(state(turning))*state(moment))
  end function power

end module bw_junction_waves
