module bw_event
  !! What is recorded of an instant at which the state jumps.
  use bw_kinds, only: dp
  implicit none (type, external)
  private

  integer, parameter, public :: impact_event = 1, capture_event = 2
  character(*), parameter, public :: event_words(*) = [character(8) :: 'impact', 'capture']   !! by number

  type, public :: event_type
    !! Masses in m_i, velocities in the approach velocity V; times in s.
    integer :: kind = impact_event
    real(dp) :: time = 0.0_dp                       !! s
    real(dp) :: end_time = 0.0_dp                   !! s, equal to `time` for an instant
    real(dp) :: impulse = 0.0_dp                    !! on the beam's tip, m_i V
    real(dp) :: energy_before = 0.0_dp              !! kinetic energy of beam and mass, m_i V²
    real(dp) :: energy_after = 0.0_dp
    real(dp) :: momentum_before = 0.0_dp
      !! generalised momentum of the first mode of the set in force, per unit of its tip displacement, m_i V
    real(dp) :: momentum_after = 0.0_dp
  end type event_type

end module bw_event
