module bw_segment
  !! The motion between two events: a mode set, a start and an initial state. Until the next event the flow of each mode
  !! is exact, and energies come with a bound of their rounding error.
  !!
  !! In the plane of rotation energy is a difference: kinetic and elastic less the centrifugal part. Once a motion has
  !! grown by e²⁰ no digit of the difference is left, though energy is conserved. So energies are found both from the
  !! state and from the initial energy with its changes, and the more accurate one is used.
  !!
  !! Without dimensions: times in l²/h, velocities in the approach velocity V, displacements in V l²/h.
  use bw_double_double, only: accurate_sum, dd
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_modal_flow, only: energy_gain, flow, slow_exponent
  use bw_mode_set, only: damping_rates, mode_set
  implicit none (type, external)
  private
  public :: beam_energy, growth_ends, growth_error, known_energy, leaves_range, mass_energy, move, move_with_energy
  public :: more_accurate, state_energy, operator(+)

  integer, parameter, public :: alone = 1, together = 2
    !! configurations: the beam alone, and with a mass that is captured or pressed against it

  type, public :: lack_type
    !! Truncation errors of a segment's initial state.
    real(dp), allocatable :: q(:), rate(:)             !! known part, (modes)
    real(dp), allocatable :: q_doubt(:), rate_doubt(:) !! bounds of the unknown part, (modes)
    real(dp) :: likely = 1.0_dp                        !! likely part of these bounds
    real(dp) :: energy = 0.0_dp                        !! of modes that were not projected; `missing`: unknown
    integer :: bounded = huge(1)                       !! modes with these bounds; later modes may have this energy
  end type lack_type

  type, public :: load_type
    !! A force at the struck point: in each step a polynomial through Chebyshev points (bw_force_step).
    real(dp), allocatable :: length(:)       !! of the steps, l²/h
    integer, allocatable :: level(:) !! halvings from the longest step to each; the last may have any length
    real(dp), allocatable :: force(:, :)     !! m_iV h/l², (0:points, steps)
    integer :: taking_part = 0               !! modes that it drives; others are at rest
    real(dp), allocatable :: residual(:, :)
      !! quasi-static contribution of omitted modes to displacements, curvatures and hub rotation under a force of 1, (points, 3)
    real(dp), allocatable :: displacement(:, :), velocity(:, :), curvature(:, :)
      !! requested histories at the samples of the segment: V l²/h, V, and V l²/h over l², (samples, points)
    real(dp), allocatable :: hub_turn(:)     !! of a free hub: V l²/h over l, (samples)
  end type load_type

  type, public :: shape_term
    !! A term of an equilibrium shape, in modes of a configuration with these bodies.
    integer :: configuration = alone
    logical, allocatable :: there(:)         !! (bodies)
    real(dp), allocatable :: amplitude(:)    !! of the first modes
  end type shape_term

  type, public :: segment_type
    integer :: configuration = alone         !! that moves
    type(dd) :: start                        !! l²/h
    integer :: count = 0                     !! modes summed
    integer :: handed = 0                    !! modes of the segment before that were projected
    real(dp) :: force = 0.0_dp
      !! without a state: all modes start undeflected with velocities force·Φ_k(ξ₀)/M_k
    real(dp), allocatable :: q(:)            !! modal displacements at the start, (modes)
    real(dp), allocatable :: rate(:)         !! modal velocities at the start, (modes)
    real(dp), allocatable :: rest(:)
      !! modal displacements of the equilibrium; unallocated: 0, (modes)
    type(shape_term), allocatable :: shape(:)
      !! the equilibrium in modes of several configurations, if springs came to a bent beam; else unallocated
    real(dp) :: energy = 0.0_dp              !! of all modes at the start
    type(lack_type), allocatable :: lack     !! unallocated: none, or not requested
    real(dp) :: start_error = 0.0_dp         !! estimate of the error of `start` due to contacts
    type(load_type), allocatable :: load     !! unallocated: free motion
    real(dp), allocatable :: error(:, :)
      !! the same of modal displacements and velocities: until the next segment after contacts, or at the start after
      !! changes of bodies; else unallocated, (modes, 2)
    real(dp), allocatable :: beyond(:, :)
      !! projected state of the next octave of modes at the start, after a change of bodies; else unallocated, (modes of
      !! the octave, 2)
  end type segment_type

  real(dp), parameter, public :: largest_exponent = 300.0_dp   !! of growth whose energy does not overflow

  type, public :: energy_type
    real(dp) :: value = 0.0_dp            !! m_iV²
    real(dp) :: rounding = 0.0_dp         !! bound of its error, m_iV²
  end type energy_type

  real(dp), parameter :: state_rounding = 16.0_dp*epsilon(1.0_dp)   !! relative error of the square of a modal state
  real(dp), parameter :: worth = 1.0e3_dp                           !! value over rounding of an energy worth reporting

  interface operator(+)
    module procedure :: added
  end interface

contains

  pure subroutine move(modes, elapsed, q, rate)
    !! Move a state forward in time.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed          !! ≥ 0
    real(dp), intent(inout) :: q(:), rate(:) !! (modes)
    call flow(modes%beta_squared, damping_rates(modes), elapsed, q, rate)
  end subroutine move

  pure real(dp) function growth_ends(modes) result(time)
    !! Return the time at which the energy of a growing mode overflows; `huge` if none grows.
    class(mode_set), intent(in) :: modes
    type(dd) :: exponent(modes%count)
    exponent = slow_exponent(modes%beta_squared, damping_rates(modes))
    time = huge(time)
    if (any(exponent%hi > 0.0_dp)) time = largest_exponent/maxval(exponent%hi)
  end function growth_ends

  pure logical function leaves_range(modes, elapsed)
    !! Return whether a growing mode overflows within a time.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed
    leaves_range = elapsed%hi > growth_ends(modes)
  end function leaves_range

  pure real(dp) function growth_error(modes, elapsed) result(error)
    !! Return the relative error of exp(σt) at the end, as the growth rate σ has the digits of binary64.
    class(mode_set), intent(in) :: modes     !! may include growing ones
    real(dp), intent(in) :: elapsed
    error = epsilon(error)*sqrt(max(0.0_dp, maxval(-modes%beta_squared%hi)))*elapsed
  end function growth_error

  pure real(dp) function beam_energy(modes, q, rate) result(energy)
    !! Return ½ΣM(q̇² + β²q²), m_iV²: kinetic and elastic energy, less the centrifugal potential in the plane of rotation.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:)
    energy = 0.5_dp*accurate_sum(modes%modal_mass*(rate**2 + modes%beta_squared%hi*q**2))
  end function beam_energy

  elemental type(energy_type) function added(a, b) result(c)
    !! Return the sum of two energies, with its rounding.
    type(energy_type), intent(in) :: a, b
    c = energy_type(a%value + b%value, a%rounding + b%rounding + state_rounding*abs(a%value + b%value))
  end function added

  elemental type(energy_type) function more_accurate(a, b) result(c)
    !! Return the more accurate of two values of the same energy.
    type(energy_type), intent(in) :: a, b
    c = b
    if (a%rounding <= b%rounding) c = a
  end function more_accurate

  elemental real(dp) function known_energy(energy) result(value)
    !! Return an energy with at least three digits, else `missing`.
    type(energy_type), intent(in) :: energy
    value = missing
    if (worth*energy%rounding <= abs(energy%value)) value = energy%value
  end function known_energy

  pure type(energy_type) function state_energy(modes, q, rate, rounding) result(energy)
    !! Return ½ΣM(q̇² + β²q²) of a state.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:)         !! (modes)
    real(dp), intent(in), optional :: rounding    !! relative error of the squares of the state; absent: that of a flow
    real(dp) :: unit
    unit = state_rounding
    if (present(rounding)) unit = rounding
    energy%value = beam_energy(modes, q, rate)
    energy%rounding = unit*sum(0.5_dp*modes%modal_mass*(rate**2 + abs(modes%beta_squared%hi)*q**2))
  end function state_energy

  pure type(energy_type) function energy_later(modes, elapsed, q, rate, before) result(energy)
    !! Return the energy after free motion: that before, less the dissipated part.
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
    !! Move a state and its energy forward in time.
    class(mode_set), intent(in) :: modes
    type(dd), intent(in) :: elapsed
    real(dp), intent(inout) :: q(:), rate(:)      !! (modes)
    type(energy_type), intent(inout) :: energy    !! of this state
    energy = energy_later(modes, elapsed, q, rate, energy)
    call move(modes, elapsed, q, rate)
    energy = more_accurate(energy, state_energy(modes, q, rate))
  end subroutine move_with_energy

  elemental type(energy_type) function mass_energy(gamma, displacement, velocity, speed) result(energy)
    !! Return ½γ(v² − ω²y²).
    real(dp), intent(in) :: gamma, displacement, velocity
    real(dp), intent(in) :: speed                 !! ω; 0 unless the mass moves in the plane of rotation
    energy%value = 0.5_dp*gamma*(velocity - speed*displacement)*(velocity + speed*displacement)
    energy%rounding = state_rounding*(0.5_dp*gamma*(velocity**2 + (speed*displacement)**2))
  end function mass_energy

end module bw_segment
