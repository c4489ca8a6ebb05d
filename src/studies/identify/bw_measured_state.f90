module bw_measured_state
  !! One state of the identified beam: the lines measured in it, and its modes as functions of the unknowns.
  use bw_beam_units, only: beam_units, units_of
  use bw_error, only: error_type
  use bw_spurious_lines, only: spurious_chance
  use bw_identify_par, only: identify_par
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type, silent_monitor
  use bw_scene, only: scene_type
  use bw_scene_resolved, only: resolved_text
  use bw_scene_unknowns, only: scene_with, with_unknowns
  use bw_scene_variant, only: without_group
  use bw_some_modes, only: find_some_modes
  implicit none (type, external)
  private
  public :: amplitude_weights, state_of

  real(dp), parameter, public :: vague_deviation = 0.05_dp !! chosen: relative deviation from which a line may be any mode
  real(dp), parameter, public :: sensor_error = 0.01_dp
    !! chosen: relative to the largest amplitude: sensors are seldom calibrated or placed better

  type, public :: state_lines
    !! The lines of a record, in ascending order of frequency.
    real(dp), allocatable :: frequency(:)        !! |z| = √(β² + δ²) [rad/s]: that of the mode without its damping, (lines)
    real(dp), allocatable :: deviation(:)        !! its standard deviation [rad/s], > 0, (lines)
    real(dp), allocatable :: decay(:)            !! δ [1/s], (lines)
    real(dp), allocatable :: decay_deviation(:)  !! > 0, (lines)
    real(dp), allocatable :: strength(:)         !! over all sensors; unallocated: unknown, (lines)
    complex(dp), allocatable :: amplitude(:, :)  !! unallocated: unknown places, or not comparable, (sensors, lines)
    real(dp), allocatable :: amplitude_deviation(:, :)   !! of real and imaginary part, > 0, (sensors, lines)
    real(dp), allocatable :: points(:)           !! ξ, (sensors)
    integer, allocatable :: sensor(:)            !! their numbers in the record, (sensors)
    logical :: bends = .false.                   !! sensors measure strain, else motion
    logical :: over_blow = .false.               !! amplitudes are modal constants φ_sφ_f/M [1/kg] of a hammer blow
  end type state_lines

  type, public :: state_modes
    !! Modes by their numbers.
    integer, allocatable :: number(:)            !! ascending, (modes)
    real(dp), allocatable :: frequency(:)        !! β [rad/s]; −√(−β²) of an unstable mode, (modes)
    real(dp), allocatable :: decay(:)            !! c/2 [1/s], (modes)
    real(dp), allocatable :: shape(:, :)         !! Φ, or curvature, at sensors whose amplitudes are known, (modes, sensors)
    logical :: found = .false.                   !! false if these unknowns make no beam, or its modes are not found
  end type state_modes

  type, public :: measured_state
    type(state_lines) :: lines
    logical, allocatable :: is_harmonic(:)       !! lines known to be no modes, (lines)
    real(dp), allocatable :: chance(:)           !! probability that a line is spurious, before modes are considered, (lines)
    integer, allocatable :: mode_of(:)           !! the mode assigned to each line; 0: none, (lines)
    integer :: most_modes = 0                    !! limit set by the scene
    logical, allocatable :: concerned(:)         !! affected by an unknown, (unknowns)
    type(scene_type), private :: varied, one
    real(dp), allocatable, private :: values(:)  !! of the unknowns of the last modes found
    type(state_modes), private :: last
    integer :: solutions = 0                     !! how often modes were found
    class(monitor_type), pointer :: monitor => null()    !! no modes are found once it asks to stop; unassociated: never
    character(:), allocatable, private :: beam   !! all groups but those of measurement, unknowns at their starts
  contains
    procedure :: modes_at
    procedure :: scene_at
    procedure :: shapes_along
    procedure :: is_twin_of
    procedure :: odds_left
  end type measured_state

contains

  type(measured_state) function state_of(scene, unknowns, lines) result(state)
    !! Return a state whose lines are not assigned yet.
    type(scene_type), intent(in) :: scene        !! without sweeps
    type(identify_par), intent(in) :: unknowns(:)   !! those of group 0 do not affect this scene
    type(state_lines), intent(in) :: lines
    type(error_type), allocatable :: error
    state%lines = lines
    state%concerned = unknowns%group > 0
    state%most_modes = scene%modes%before
    allocate (state%mode_of(size(lines%frequency)), source=0)
    allocate (state%is_harmonic(size(lines%frequency)), source=.false.)
    state%chance = spurious_chance(lines%frequency, lines%deviation, lines%decay, lines%decay_deviation, lines%strength)
    call with_unknowns(scene, unknowns, state%varied)
    call scene_with(state%varied, unknowns%start, state%one, error)
    state%beam = resolved_text(scene)
    if (.not. allocated(error)) state%beam = resolved_text(state%one)
    state%beam = without_group(without_group(without_group(without_group(state%beam, 'scene'), 'record'), 'spectrum'), 'identify')
  end function state_of

  pure function amplitude_weights(amplitude, deviation, error) result(weight)
    !! Return inverse variances of the amplitudes of one line, (sensors).
    complex(dp), intent(in) :: amplitude(:)
    real(dp), intent(in) :: deviation(:)
    real(dp), intent(in) :: error                !! further error, relative to the largest amplitude
    real(dp) :: weight(size(amplitude))
    weight = 1/(deviation**2 + (error*maxval(abs(amplitude)))**2)
  end function amplitude_weights

  pure logical function is_twin_of(self, other)
    !! Return whether two states have the same modes, as repeats do.
    class(measured_state), intent(in) :: self
    type(measured_state), intent(in) :: other
    is_twin_of = self%beam == other%beam .and. all(self%concerned .eqv. other%concerned) .and. &
      (allocated(self%lines%points) .eqv. allocated(other%lines%points)) .and. (self%lines%bends .eqv. other%lines%bends) &
      .and. (self%lines%over_blow .eqv. other%lines%over_blow)
    if (.not. is_twin_of .or. .not. allocated(self%lines%points)) return
    is_twin_of = size(self%lines%points) == size(other%lines%points)
    if (is_twin_of) is_twin_of = all(self%lines%points == other%lines%points)
    if (is_twin_of .and. self%lines%over_blow) is_twin_of = self%one%record%force_point == other%one%record%force_point
  end function is_twin_of

  pure function odds_left(self) result(odds)
    !! Return the odds of unassigned lines to be modes, before modes are considered, without lines that hardly are.
    class(measured_state), intent(in) :: self
    real(dp), allocatable :: odds(:)
    odds = pack((1 - self%chance)/self%chance, self%mode_of == 0 .and. self%chance < 0.5_dp .and. .not. self%is_harmonic &
                .and. self%lines%deviation <= vague_deviation*self%lines%frequency)
  end function odds_left

  subroutine modes_at(self, values, number, modes)
    !! Find modes; the last ones are cached.
    class(measured_state), intent(inout) :: self
    real(dp), intent(in) :: values(:)            !! of the unknowns
    integer, intent(in) :: number(:)             !! ascending, ≤ most_modes
    type(state_modes), intent(out) :: modes
    integer :: place(size(number)), i
    if (self%last%found .and. allocated(self%values)) then
      if (all(values == self%values .or. .not. self%concerned)) then
        place = [(findloc(self%last%number, number(i), dim=1), i=1, size(number))]
        if (all(place > 0)) then
          modes%found = .true.
          modes%number = number
          modes%frequency = self%last%frequency(place)
          modes%decay = self%last%decay(place)
          if (allocated(self%last%shape)) modes%shape = self%last%shape(place, :)
          return
        end if
      end if
    end if
    self%solutions = self%solutions + 1
    self%values = values
    call solve(self, values, number, modes)
    self%last = modes
  end subroutine modes_at

  subroutine scene_at(self, values, scene, error)
    !! Return the scene with these values. **Errors**: they make none.
    class(measured_state), intent(inout) :: self
    real(dp), intent(in) :: values(:)            !! of the unknowns
    type(scene_type), intent(out) :: scene
    type(error_type), allocatable, intent(out) :: error
    call scene_with(self%varied, values, scene, error)
  end subroutine scene_at

  subroutine shapes_along(self, values, number, places, shapes)
    !! Find shapes along the whole beam, as seen by sensors of the measured kind.
    class(measured_state), intent(in) :: self
    real(dp), intent(in) :: values(:)            !! of the unknowns
    integer, intent(in) :: number(:)             !! of the modes, ascending
    real(dp), intent(in) :: places(:)            !! ξ
    real(dp), allocatable, intent(out) :: shapes(:, :)   !! (modes, places); unallocated if there are none
    type(measured_state) :: other
    type(state_modes) :: modes
    other = self
    other%last%found = .false.
    other%lines%points = places
    other%lines%over_blow = .false.
    call other%modes_at(values, number, modes)
    if (modes%found) shapes = modes%shape
  end subroutine shapes_along

  subroutine solve(state, values, number, modes)
    !! Find modes of the scene with these values.
    class(measured_state), intent(inout) :: state
    real(dp), intent(in) :: values(:)
    integer, intent(in) :: number(:)
    type(state_modes), intent(inout) :: modes
    type(error_type), allocatable :: error
    type(beam_units) :: units
    class(mode_set), allocatable :: set
    type(silent_monitor), target :: silence
    class(monitor_type), pointer :: monitor
    real(dp), allocatable :: shape(:, :)
    integer :: place(size(number))
    modes%number = number
    allocate (modes%frequency(size(number)), modes%decay(size(number)), source=0.0_dp)
    monitor => silence
    if (associated(state%monitor)) monitor => state%monitor
    if (monitor%stop_requested()) return
    call scene_with(state%varied, values, state%one, error)
    if (allocated(error)) return
    units = units_of(state%one%beam)
    call find_some_modes(state%one, units, number, set, place, monitor)
    if (allocated(set)) modes%found = set%resolved
    if (.not. modes%found) return
    associate (square => set%beta_squared(place)%hi)
      modes%frequency = sign(sqrt(abs(square)), square)*units%frequency
    end associate
    if (allocated(state%lines%points)) then
      if (state%lines%bends) shape = set%some_curvatures(1, set%count, state%lines%points)
      if (.not. state%lines%bends) shape = set%shapes(state%lines%points)
      modes%shape = shape(place, :)
      if (state%lines%over_blow) then
        associate (struck => set%shapes([state%one%record%force_point]))
          modes%shape = modes%shape*spread(struck(place, 1)/set%modal_mass(place)/units%mass, 2, size(modes%shape, 2))
        end associate
      end if
    end if
    if (allocated(set%damping)) modes%decay = 0.5_dp*set%damping(place)*units%frequency
  end subroutine solve

end module bw_measured_state
