module bw_event
  !! The record of an event, at which the state jumps.
  use bw_kinds, only: dp
  implicit none (type, external)
  private

  integer, parameter, public :: no_event = 0, impact_event = 1, capture_event = 2, release_event = 3, contact_event = 4, &
    arrival_event = 5, departure_event = 6, exchange_event = 7
    !! the last three: bodies arrive, leave, or some arrive as others leave
  character(*), parameter, public :: event_words(0:*) = &
    [character(9) :: 'none', 'impact', 'capture', 'release', 'contact', 'arrival', 'departure', 'exchange']   !! by number

  type, public :: event_type
    !! An event. Masses in m_i, velocities in the approach velocity V, times in s.
    integer :: kind = impact_event
    real(dp) :: time = 0.0_dp                       !! s
    real(dp) :: end_time = 0.0_dp                   !! s, equal to `time` for an instant
    real(dp) :: time_error = 0.0_dp                 !! s, estimate of the error of `time`
    real(dp) :: end_error = 0.0_dp                  !! s, the same of `end_time`
    real(dp) :: impulse = 0.0_dp                    !! on the beam's tip, m_i V
    real(dp) :: largest_force = 0.0_dp              !! in a lasting contact, m_i V h/l²
    real(dp) :: largest_force_time = 0.0_dp         !! when it is reached, s
    real(dp) :: energy_before = 0.0_dp              !! energy of beam and mass in the rotating frame, m_i V²
    real(dp) :: energy_after = 0.0_dp
    real(dp) :: momentum_before = 0.0_dp
      !! generalised momentum of the first mode of the current set (of the beam alone at a release), per unit of its
      !! tip displacement, m_i V
    real(dp) :: momentum_after = 0.0_dp
    real(dp) :: hub_rate_change = 0.0_dp
      !! jump of a free hub's mean angular velocity, that of its rigid rotation, V/l
  end type event_type

end module bw_event
