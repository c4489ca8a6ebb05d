module bw_mode_set
  !! A set of modes, found by any method, as events, responses and results use it. A `mode_source` finds such sets by mode numbers.
  !!
  !! Everything is without dimensions: lengths in l, times in l²/h, masses in the beam's mass m_i.
  use bw_kinds, only: dp
  use bw_damping, only: damping_law
  use bw_double_double, only: dd, sqrt, operator(-)
  use bw_missing, only: missing
  use bw_monitor, only: monitor_type
  use bw_scene_pieces, only: struck_beam
  implicit none (type, external)
  private
  public :: damping_rates, first_failure, first_numbers, first_struck_mode, mean_rate, observe_searches, take_terms, &
    terms_of_set, values_at

  integer, parameter, public :: deflections = 1, curvatures = 2, turns = 3   !! quantities of histories, the last for a free hub
  integer, parameter, public :: batch = 256             !! tuned: modes whose arrays stay in the fastest cache
  real(dp), parameter, public :: least_phase = 1.0e-13_dp    !! rad, phase error at the end of a history without a tolerance
  real(dp), parameter, public :: near_critical = 1.0e-2_dp   !! |ω² − Ω²| over ω² below which binary64 frequencies lose digits

  type, abstract, public :: mode_set
    !! Modes of one beam and their properties.
    integer :: count = 0                          !! number of modes n
    real(dp) :: gamma = 0.0_dp                    !! captured mass γ; 0 for the beam alone
    real(dp), allocatable :: alpha(:)             !! α = P l, wave number times length, (n)
    type(dd), allocatable :: beta_squared(:)      !! β²: > 0 stable, 0 critical, < 0 growing, (n)
    real(dp), allocatable :: square_rounding(:)
      !! rounding error of β²; unallocated if roots have the digits that a record needs, (n)
    real(dp), allocatable :: damping(:)           !! c_k of q̈ + cq̇ + β²q = 0; unallocated: undamped, (n)
    type(dd), allocatable :: damped_squared(:)    !! β² − c²/4 of damped modes, to more digits than c, (n)
    type(damping_law), allocatable :: law         !! law of c_k; unallocated: undamped
    real(dp), allocatable :: struck(:)            !! Φ_k(ξ₀) at the place where a mass strikes or was captured, (n)
    real(dp), allocatable :: modal_mass(:)        !! M_k, (n)
    real(dp), allocatable :: phase_velocity(:)    !! C_p, Eq. 32; missing if it does not exist, (n)
    real(dp), allocatable :: group_velocity(:)    !! C_g, Eq. 33; missing if it does not exist, (n)
    real(dp) :: struck_at = 1.0_dp                !! ξ₀
    logical :: uniform = .true.                   !! shapes of a uniform clamped beam struck at its tip
    integer :: root_power = 2                     !! power of ξ with which shapes rise at the root: 2 clamped, 1 hinged, 0 free
    logical :: known_by_mass = .false.            !! the first modes in closed form: shapes depend only on γ and n
    type(dd) :: critical_speed                    !! lowest ω with an unstable mode; 0: none
    logical :: grows_at_any_speed = .false.       !! nothing holds the beam against rotation: it is unstable at every ω > 0
    logical :: resolved = .true.                  !! false: modes were not found, and the numbers are invalid
  contains
    procedure(shapes_interface), deferred :: some_shapes
    procedure(shapes_interface), deferred :: some_curvatures      !! the same of Φ_k''(ξ); with shear of ψ_k'(ξ)
    procedure :: shapes => all_shapes
    procedure(overlap_interface), deferred :: overlap
    procedure(elastic_interface), deferred :: elastic
    procedure :: damp
    procedure :: rigid => rigid_modes
    procedure :: forget_rigid_waves
    procedure :: body_energy => no_body_energy
    procedure :: find_tip_shears => unknown_tip_shears
    procedure :: turnings => no_turnings
    procedure :: motion_at => plain_motion_at
    procedure :: share_of_turn => no_turnings  !! ⟨Φ_k, R + x⟩, M_k times the modal part of a rigid rotation; else 0
    procedure :: energy_of_pull => no_energy_of_pull
    procedure :: hub_turns => no_turnings                         !! rotation of a free hub in each mode; else 0
    procedure :: number_errors => errors_of_set
  end type mode_set

  type, public :: search_failure
    !! Numbers of the first modes of which one was not found. Sums and estimates without that mode are wrong, so their
    !! callers check here.
    integer :: first = 0                          !! 0: all modes were found
    integer :: last = 0
  end type search_failure

  type, abstract, public :: mode_source
    !! A source of modes of any numbers, of one beam with what it carries.
    type(search_failure), pointer :: failure => null()
      !! records failed searches; null: nowhere. Outlives the source and its copies
    class(monitor_type), pointer :: monitor => null()
      !! for searches without a monitor of their own; null: none. Outlives them, too
    real(dp) :: gamma = 0.0_dp                    !! captured mass γ
    integer :: highest = 0                        !! highest mode number that can be found
    integer :: at_most = huge(1)                  !! to which it can be extended
    integer :: quickly = huge(1)                  !! modes that are found in about a second
    real(dp) :: stretch = 1.0_dp                  !! phases are accurate for so many lengths of a record
    real(dp) :: struck_at = 1.0_dp                !! see mode_set
    logical :: uniform = .true.
    integer :: root_power = 2
    type(damping_law), allocatable :: damping     !! of the modes; unallocated: undamped
    type(struck_beam) :: pieces                   !! the beam, without its tension
  contains
    procedure(find_interface), deferred :: find
    procedure :: terms => terms_of_set
    procedure :: note_failure
  end type mode_source

  type, public :: configuration_type
    !! A beam with what it carries for some time: its source of modes, and the modes in memory.
    class(mode_source), allocatable :: source     !! unallocated: only modes in memory
    class(mode_set), allocatable :: set           !! the first modes; unallocated: not requested
  end type configuration_type

  abstract interface
    pure function shapes_interface(self, first, last, xi) result(values)
      !! Return Φ_k(ξ) of modes `first` … `last` of the set at points of the beam.
      import :: mode_set, dp
      class(mode_set), intent(in) :: self
      integer, intent(in) :: first, last
      real(dp), intent(in) :: xi(:)               !! 0 ≤ ξ ≤ 1, (points)
      real(dp) :: values(last - first + 1, size(xi))   !! (modes, points)
    end function shapes_interface

    function overlap_interface(self, from, amplitude, with_mass, monitor) result(sums)
      !! Return the overlaps of these modes with a motion Σ_i a_iφ_i in other modes: Σ_i a_i times the integral of Φ_kφ_i,
      !! weighted by mass. Over the modal masses they are the motion's projection.
      !! **Limits**: both sets belong to the same beam and were found in the same way.
      import :: mode_set, monitor_type, dp
      class(mode_set), intent(in) :: self
      class(mode_set), intent(in) :: from         !! modes φ_i
      real(dp), intent(in) :: amplitude(:)        !! a_i of the first of them, 0 for others
      logical, intent(in) :: with_mass            !! of the beam and of the captured mass; else of the beam
      class(monitor_type), intent(inout), optional :: monitor   !! the sums are invalid if it requests a stop
      real(dp) :: sums(self%count)
    end function overlap_interface

    subroutine find_interface(self, number, modes, longest, monitor)
      !! Find modes by numbers, with the source's damping.
      import :: mode_set, mode_source, monitor_type, dp
      class(mode_source), intent(in) :: self
      integer, intent(in) :: number(:)            !! 1 ≤ k ≤ `highest`, ascending
      class(mode_set), allocatable, intent(out) :: modes
      real(dp), intent(in), optional :: longest
        !! time, in l²/h, up to which phases are accurate; absent: no history is requested
      class(monitor_type), intent(inout), optional :: monitor   !! the modes are invalid if it requests a stop
    end subroutine find_interface

    pure function elastic_interface(self) result(squares)
      !! Return K_kk/M_kk with the elastic stiffness K without tension and rotation, for damping. It is β² if nothing else acts.
      import :: mode_set, dd
      class(mode_set), intent(in) :: self
      type(dd) :: squares(self%count)             !! (modes)
    end function elastic_interface
  end interface

contains

  pure function all_shapes(self, xi) result(values)
    !! Return Φ_k(ξ) at points of the beam.
    class(mode_set), intent(in) :: self
    real(dp), intent(in) :: xi(:)                 !! 0 ≤ ξ ≤ 1, (points)
    real(dp) :: values(self%count, size(xi))      !! (modes, points)
    values = self%some_shapes(1, self%count, xi)
  end function all_shapes

  pure function values_at(modes, quantity, first, last, xi) result(values)
    !! Return Φ_k(ξ), Φ_k''(ξ) or hub rotations of some modes of a set.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: quantity               !! deflections, curvatures or turns
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)                 !! (points)
    real(dp) :: values(last - first + 1, size(xi))
    if (quantity == curvatures) then
      values = modes%some_curvatures(first, last, xi)
    else if (quantity == turns) then
      associate (turning => modes%hub_turns())
        values = spread(turning(first:last), 2, size(xi))
      end associate
    else
      values = modes%some_shapes(first, last, xi)
    end if
  end function values_at

  subroutine note_failure(self, number)
    !! Record that one of these modes was not found.
    class(mode_source), intent(in) :: self
    integer, intent(in) :: number(:)              !! ascending
    if (.not. associated(self%failure) .or. size(number) == 0) return
    if (self%failure%first == 0) self%failure = search_failure(number(1), number(size(number)))
  end subroutine note_failure

  subroutine observe_searches(configurations, failure, monitor)
    !! Set where failed searches are recorded, and the monitor of searches without their own. Both outlive the sources.
    type(configuration_type), intent(inout) :: configurations(:)
    type(search_failure), intent(in), target :: failure
    class(monitor_type), intent(inout), target :: monitor
    integer :: i
    do i = 1, size(configurations)
      if (.not. allocated(configurations(i)%source)) cycle
      configurations(i)%source%failure => failure
      configurations(i)%source%monitor => monitor
    end do
  end subroutine observe_searches

  pure type(search_failure) function first_failure(configurations) result(failure)
    !! Return the first failure that was recorded.
    type(configuration_type), intent(in) :: configurations(:)
    if (.not. allocated(configurations(1)%source)) return
    if (associated(configurations(1)%source%failure)) failure = configurations(1)%source%failure
  end function first_failure

  pure function first_numbers(count) result(number)
    !! Return 1 … count, the numbers of the first modes.
    integer, intent(in) :: count
    integer :: number(count)
    integer :: k
    number = [(k, k=1, count)]
  end function first_numbers

  pure function damping_rates(modes) result(c)
    !! Return c_k of q̈ + cq̇ + β²q = 0, (modes).
    class(mode_set), intent(in) :: modes
    real(dp) :: c(modes%count)
    c = 0.0_dp
    if (allocated(modes%damping)) c = modes%damping
  end function damping_rates

  pure integer function first_struck_mode(modes) result(k)
    !! Return the first mode with motion at the struck place.
    class(mode_set), intent(in) :: modes
    real(dp), parameter :: negligible = 1.0e-3_dp
    associate (shape => abs(modes%struck))
      k = max(1, findloc(shape > negligible*maxval(shape), .true., dim=1))
    end associate
  end function first_struck_mode

  pure real(dp) function mean_rate(modes, rate)
    !! Return the angular velocity of the rigid rotation on a free hub; else 0.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: rate(:)               !! modal velocities, (modes)
    mean_rate = 0.0_dp
    if (size(rate) == 0) return
    associate (turning => modes%hub_turns())
      if (turning(1) /= 0.0_dp) mean_rate = turning(1)*rate(1)
    end associate
  end function mean_rate

  pure function rigid_modes(self) result(rigid)
    !! Return which of the first two modes are rigid-body modes: their shapes are straight to within 1 %. There are no
    !! others, as a straight line has two parameters.
    class(mode_set), intent(in) :: self
    logical :: rigid(min(2, self%count))
    real(dp), parameter :: xi(5) = [0.0_dp, 0.25_dp, 0.5_dp, 0.75_dp, 1.0_dp], straight = 0.01_dp
    real(dp) :: shape(size(rigid), size(xi))
    integer :: k
    rigid = .false.
    associate (turning => self%hub_turns())
      rigid(:min(1, self%count)) = turning(:min(1, self%count)) /= 0.0_dp
    end associate
    if (self%root_power == 2) return
    shape = self%some_shapes(1, size(rigid), xi)
    do k = 1, size(rigid)
      associate (line => shape(k, 1) + xi*(shape(k, size(xi)) - shape(k, 1)))
        rigid(k) = maxval(abs(shape(k, :) - line)) <= straight*maxval(abs(shape(k, :)))
      end associate
    end do
  end function rigid_modes

  pure subroutine forget_rigid_waves(self)
    !! Remove the wave numbers and velocities of rigid-body modes.
    class(mode_set), intent(inout) :: self
    integer :: k
    associate (rigid => self%rigid())
      do k = 1, size(rigid)
        if (.not. rigid(k)) cycle
        self%phase_velocity(k) = missing
        self%group_velocity(k) = missing
      end do
    end associate
  end subroutine forget_rigid_waves

  pure subroutine damp(self, law)
    !! Damp the modes: set c_k and β² − c²/4.
    class(mode_set), intent(inout) :: self
    type(damping_law), intent(in), optional :: law      !! absent: undamped
    type(dd) :: elastic(self%count)
    if (.not. present(law)) return
    elastic = self%elastic()
    self%law = law
    self%damping = law%rates(elastic%hi)
    self%damped_squared = self%beta_squared - law%quarter_squares(elastic)
  end subroutine damp

  pure subroutine errors_of_set(self, square_error, mass_error)
    !! Return standard errors of modes found in binary64; true errors may be a few of these. Singular values by LAPACK
    !! give β² with the rounding error of its elastic part, within 7e-15 for 200 modes; vectors, and so M, have rounding
    !! error over the gap to the next value, about 2/(kα²).
    class(mode_set), intent(in) :: self
    real(dp), intent(out) :: square_error(:)      !! of β², (modes)
    real(dp), intent(out) :: mass_error(:)        !! of M, relative, besides rounding, (modes)
    real(dp), parameter :: relative_error = 2.0e-15_dp
    type(dd) :: elastic(self%count)
    integer :: k
    elastic = self%elastic()
    square_error = relative_error*(elastic%hi + abs(self%beta_squared%hi))
    if (allocated(self%square_rounding)) square_error = max(square_error, self%square_rounding)
    mass_error = relative_error + 0.5_dp*epsilon(1.0_dp)*[(k, k=1, self%count)]*sqrt(elastic%hi)
  end subroutine errors_of_set

  pure function no_body_energy(self, q, rate) result(energy)
    !! Return kinetic and potential energy of the captured body besides its mass moving with the deflection. A point
    !! mass without tension has none.
    class(mode_set), intent(in) :: self
    real(dp), intent(in) :: q(:), rate(:)         !! state of the modes, (modes)
    real(dp) :: energy(2)
    energy = 0.0_dp
    if (self%count + size(q) + size(rate) == 0) return     ! it depends on neither
  end function no_body_energy

  pure subroutine unknown_tip_shears(self, shear, known)
    !! Return the shear forces at a held tip, EI/l³ of the root piece, if the modes contain them.
    class(mode_set), intent(in) :: self
    real(dp), intent(out) :: shear(:)             !! (modes)
    logical, intent(out) :: known
    shear = 0.0_dp*self%modal_mass
    known = .false.
  end subroutine unknown_tip_shears

  pure function no_turnings(self) result(turning)
    !! Return rotations of sections at ξ₀ for a captured body with rotary inertia; else 0, (modes).
    class(mode_set), intent(in) :: self
    real(dp) :: turning(self%count)
    turning = 0.0_dp
  end function no_turnings

  pure function plain_motion_at(self, xi) result(motion)
    !! Return deflection and rotation of sections at a place in the uniformly rotating frame, as a body there sees them,
    !! (modes, 2). Sets that carry at most point masses omit the rotation.
    class(mode_set), intent(in) :: self
    real(dp), intent(in) :: xi                    !! 0 ≤ ξ ≤ 1
    real(dp) :: motion(self%count, 2)
    motion(:, 1:1) = self%some_shapes(1, self%count, [xi])
    motion(:, 2) = 0.0_dp
  end function plain_motion_at

  pure real(dp) function no_energy_of_pull(self, xi, q) result(energy)
    !! Return ½∫v'² from the axis to a place, the work of a centrifugal force of 1 there; 0 without tension.
    class(mode_set), intent(in) :: self
    real(dp), intent(in) :: xi
    real(dp), intent(in) :: q(:)                  !! of the first modes
    energy = 0.0_dp*(self%count + size(q) + xi)
  end function no_energy_of_pull

  subroutine terms_of_set(self, number, xi, longest, beta, drive, shapes, mass)
    !! Find the terms of a sum over modes, and no more, as a source may do that faster than for a whole set.
    class(mode_source), intent(in) :: self
    integer, intent(in) :: number(:)              !! see `find`
    real(dp), intent(in) :: xi(:)                 !! 0 ≤ ξ ≤ 1, (points)
    real(dp), intent(in) :: longest               !! see `find`
    type(dd), intent(out) :: beta(:)              !! √|β²| with the sign of β², (modes)
    real(dp), intent(out) :: drive(:)             !! Φ_k(ξ₀)/M_k, (modes)
    real(dp), intent(out) :: shapes(:, :)         !! Φ_k(ξ), (modes, points)
    real(dp), intent(out) :: mass(:)              !! M_k, (modes)
    class(mode_set), allocatable :: modes
    call self%find(number, modes, longest, self%monitor)
    call take_terms(modes, beta, drive)
    shapes = modes%shapes(xi)
    mass = modes%modal_mass
  end subroutine terms_of_set

  subroutine take_terms(modes, beta, drive)
    !! Take the terms of a sum over modes from a set, except shapes.
    class(mode_set), intent(in) :: modes
    type(dd), intent(out) :: beta(:)              !! see `terms_of_set`
    real(dp), intent(out) :: drive(:)
    integer :: k
    do k = 1, modes%count
      if (modes%beta_squared(k)%hi >= 0.0_dp) then
        beta(k) = sqrt(modes%beta_squared(k))
      else
        beta(k) = -sqrt(-modes%beta_squared(k))
      end if
    end do
    drive = modes%struck/modes%modal_mass
  end subroutine take_terms

end module bw_mode_set
