module bw_segment
  !! The motion between two events: a set of modes, when it starts, and the state that it starts from. Everything that
  !! follows until the next event is exact: the flow of each mode, and the energy with what rounding may have taken of it.
  !!
  !! In the plane of rotation an energy is a difference: motion and strain, less the part of the centrifugal force. Where a
  !! motion has grown by e²⁰ nothing is left of the difference, though the energy is what it was at the start. So an energy
  !! is found in two ways, from the state and from an earlier energy and what has changed since, and the sharper one is taken.
  !!
  !! Without dimensions: times in l²/h, velocities in the approach velocity V, displacements in V l²/h.
  use bw_double_double, only: accurate_sum, dd
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_modal_flow, only: energy_gain, flow, slow_exponent
  use bw_mode_set, only: mode_set
  implicit none (type, external)
  private
  public :: beam_energy, growth_ends, growth_error, known_energy, leaves_range, mass_energy, move, move_with_energy
  public :: sharper, state_energy, operator(+)

  integer, parameter, public :: alone = 1, together = 2
    !! configurations: the beam alone, and with a mass that it has captured or that is pressed against it

  type, public :: lack_type
    !! What the modes of a segment, at its start, lack of the motion of all modes that there are.
    real(dp), allocatable :: q(:), rate(:)             !! that is known, (modes)
    real(dp), allocatable :: q_doubt(:), rate_doubt(:) !! bounds of the magnitude of what is not, (modes)
    real(dp) :: likely = 1.0_dp                        !! part of these bounds that is likely
    real(dp) :: energy = 0.0_dp                        !! that was in modes which were not handed on; `missing` where it is not known
    integer :: bounded = huge(1)                       !! modes that the bounds are of; those after them may have this energy
  end type lack_type

  type, public :: load_type
    !! A force at the place that the mass strikes: in each step a polynomial through Chebyshev's points (bw_force_step).
    real(dp), allocatable :: length(:)       !! of the steps, l²/h
    integer, allocatable :: level(:)         !! how often the longest step was halved to theirs, but for the last that a record ends in
    real(dp), allocatable :: force(:, :)     !! m_iV h/l², (0:points, steps)
    integer :: taking_part = 0               !! modes that it drives; the others are at rest
    real(dp), allocatable :: residual(:, :)
      !! what modes that are not summed add for a force of 1, at once, to displacements, curvatures and the turn of the hub where they are
      !! seen, (points, 3)
    real(dp), allocatable :: displacement(:, :), velocity(:, :), curvature(:, :)
      !! what is seen at the samples of the segment, of what is asked for: V l²/h, V, and V l²/h over l², (samples, points)
    real(dp), allocatable :: hub_turn(:)     !! of a hub that is free: V l²/h over l, (samples)
  end type load_type

  type, public :: shape_term
    !! A part of a shape in which a beam rests: modes of a configuration, that carried these bodies.
    integer :: configuration = alone
    logical, allocatable :: there(:)         !! (bodies)
    real(dp), allocatable :: amplitude(:)    !! of the first modes
  end type shape_term

  type, public :: segment_type
    integer :: configuration = alone         !! which modes move
    type(dd) :: start                        !! when
    integer :: count = 0                     !! modes that are summed
    integer :: handed = 0                    !! modes of the segment before, whose motion went over to them
    real(dp) :: force = 0.0_dp
      !! of all modes there are, that start from rest position with the velocities force·Φ_k(ξ₀)/M_k, where no state is given
    real(dp), allocatable :: q(:)            !! modal displacements at the start, (modes)
    real(dp), allocatable :: rate(:)         !! modal velocities then, (modes)
    real(dp), allocatable :: rest(:)
      !! modal displacements of the equilibrium that displacements are measured from; unallocated: that of the beam at rest, (modes)
    type(shape_term), allocatable :: shape(:)
      !! the equilibrium in modes of several configurations, where springs came to a beam that was bent; else unallocated
    real(dp) :: energy = 0.0_dp              !! of all modes there are, then
    type(lack_type), allocatable :: lack     !! unallocated: the modes lack nothing, or nobody asks
    real(dp) :: start_error = 0.0_dp         !! estimate of the error of `start`, where contacts amplify errors
    type(load_type), allocatable :: load     !! unallocated: the modes move freely
    real(dp), allocatable :: error(:, :)
      !! the same of modal displacements and velocities, where contacts amplify errors until the next segment, where bodies come and leave at
      !! the start; else unallocated, (modes, 2)
    real(dp), allocatable :: beyond(:, :)
      !! modal displacements and velocities that the next octave of modes would have at the start by what the motion before hands on, where
      !! bodies come and leave then; else unallocated, (modes of the octave, 2)
  end type segment_type

  real(dp), parameter, public :: largest_exponent = 300.0_dp   !! of growth whose energy is still a number

  type, public :: energy_type
    real(dp) :: value = 0.0_dp            !! m_iV²
    real(dp) :: rounding = 0.0_dp         !! bound of its error, m_iV²
  end type energy_type

  real(dp), parameter :: state_rounding = 16.0_dp*epsilon(1.0_dp)   !! relatively, of the square of a modal state
  real(dp), parameter :: worth = 1.0e3_dp                           !! an energy with fewer digits than that is none

  interface operator(+)
    module procedure :: added
  end interface

contains

  pure subroutine move(modes, elapsed, q, rate)
    !! The state a time later.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed          !! ≥ 0
    real(dp), intent(inout) :: q(:), rate(:) !! (modes)
    if (allocated(modes%damping)) then
      call flow(modes%beta_squared, modes%damping, elapsed, q, rate)
    else
      call flow(modes%beta_squared, 0.0_dp, elapsed, q, rate)
    end if
  end subroutine move

  pure real(dp) function growth_ends(modes) result(time)
    !! When a mode has grown so much that its energy would be no number; beyond any number where none grows.
    class(mode_set), intent(in) :: modes
    type(dd) :: exponent(modes%count)
    if (allocated(modes%damping)) then
      exponent = slow_exponent(modes%beta_squared, modes%damping)
    else
      exponent = slow_exponent(modes%beta_squared, 0.0_dp)
    end if
    time = huge(time)
    if (any(exponent%hi > 0.0_dp)) time = largest_exponent/maxval(exponent%hi)
  end function growth_ends

  pure logical function leaves_range(modes, elapsed)
    !! A mode grows so much in that time that its energy would be no number.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed
    leaves_range = elapsed%hi > growth_ends(modes)
  end function leaves_range

  pure real(dp) function growth_error(modes, elapsed) result(error)
    !! Of exp(σt) at the end, as a part of it: the growth rate σ has the digits of binary64.
    class(mode_set), intent(in) :: modes     !! growing ones among them
    real(dp), intent(in) :: elapsed
    error = epsilon(error)*sqrt(max(0.0_dp, maxval(-modes%beta_squared%hi)))*elapsed
  end function growth_error

  pure real(dp) function beam_energy(modes, q, rate) result(energy)
    !! ½ΣM(q̇² + β²q²), m_iV²: kinetic energy and strain, less that of the centrifugal force in the plane of rotation.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:)
    energy = 0.5_dp*accurate_sum(modes%modal_mass*(rate**2 + modes%beta_squared%hi*q**2))
  end function beam_energy

  elemental type(energy_type) function added(a, b) result(c)
    !! The sum of two energies, with its rounding.
    type(energy_type), intent(in) :: a, b
    c = energy_type(a%value + b%value, a%rounding + b%rounding + state_rounding*abs(a%value + b%value))
  end function added

  elemental type(energy_type) function sharper(a, b) result(c)
    !! Of two ways to the same energy.
    type(energy_type), intent(in) :: a, b
    c = b
    if (a%rounding <= b%rounding) c = a
  end function sharper

  elemental real(dp) function known_energy(energy) result(value)
    !! An energy with at least three digits, else `missing`.
    type(energy_type), intent(in) :: energy
    value = missing
    if (worth*energy%rounding <= abs(energy%value)) value = energy%value
  end function known_energy

  pure type(energy_type) function state_energy(modes, q, rate, rounding) result(energy)
    !! ½ΣM(q̇² + β²q²) from the state of the modes.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:)         !! (modes)
    real(dp), intent(in), optional :: rounding    !! of the squares of the state, relatively; absent: that of a flow
    real(dp) :: unit
    unit = state_rounding
    if (present(rounding)) unit = rounding
    energy%value = beam_energy(modes, q, rate)
    energy%rounding = unit*sum(0.5_dp*modes%modal_mass*(rate**2 + abs(modes%beta_squared%hi)*q**2))
  end function state_energy

  pure type(energy_type) function energy_later(modes, elapsed, q, rate, before) result(energy)
    !! After a time of free motion of the modes: what it was before, less what is damped.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed
    real(dp), intent(in) :: q(:), rate(:)         !! the state at the start, (modes)
    type(energy_type), intent(in) :: before       !! at the start
    real(dp) :: gain(modes%count)
    energy = before
    if (.not. allocated(modes%damping)) return
    gain = 0.5_dp*modes%modal_mass*energy_gain(modes%beta_squared, modes%damping, elapsed, q, rate)
    energy%value = before%value + accurate_sum(gain)
    energy%rounding = before%rounding + state_rounding*(abs(before%value) + sum(abs(gain)))
  end function energy_later

  pure subroutine move_with_energy(modes, elapsed, q, rate, energy)
    !! Moves the state of the modes on, and its energy with it.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed
    real(dp), intent(inout) :: q(:), rate(:)      !! (modes)
    type(energy_type), intent(inout) :: energy    !! of this state
    energy = energy_later(modes, elapsed, q, rate, energy)
    call move(modes, elapsed, q, rate)
    energy = sharper(energy, state_energy(modes, q, rate))
  end subroutine move_with_energy

  elemental type(energy_type) function mass_energy(gamma, displacement, velocity, speed) result(energy)
    !! ½γ(v² − ω²y²).
    real(dp), intent(in) :: gamma, displacement, velocity
    real(dp), intent(in) :: speed                 !! ω, 0 where the mass does not move in the plane of rotation
    energy%value = 0.5_dp*gamma*(velocity - speed*displacement)*(velocity + speed*displacement)
    energy%rounding = state_rounding*(0.5_dp*gamma*(velocity**2 + (speed*displacement)**2))
  end function mass_energy

end module bw_segment
