module bw_mode_set
  !! A set of modes, whichever way they were found: what events, response and results ask of them. A `mode_source` finds
  !! such sets by the numbers of their modes.
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
  public :: attend, first_failure, first_numbers, first_struck, mean_rate, take_terms, terms_of_set, values_at

  integer, parameter, public :: deflections = 1, curvatures = 2, turns = 3   !! what histories show of modes, the last of a free hub

  type, abstract, public :: mode_set
    !! Modes of one beam, with what follows from them for each.
    integer :: count = 0                          !! number of modes n
    real(dp) :: gamma = 0.0_dp                    !! captured mass γ; 0 for the beam alone
    real(dp), allocatable :: alpha(:)             !! α = P l, wave number times length, (n)
    type(dd), allocatable :: beta_squared(:)      !! β², > 0 stable, 0 critical, < 0 growing, (n)
    real(dp), allocatable :: square_rounding(:)
      !! what rounding may have left β² off by; unallocated where roots have as many digits as a record asks for, (n)
    real(dp), allocatable :: damping(:)           !! c_k of q̈ + cq̇ + β²q = 0; unallocated where nothing damps, (n)
    type(dd), allocatable :: damped_squared(:)    !! β² − c²/4 where modes are damped, to more digits than c has, (n)
    type(damping_law), allocatable :: law         !! that c_k follow from; unallocated where nothing damps
    real(dp), allocatable :: struck(:)            !! Φ_k(ξ₀) at the place that a mass strikes, or has been captured at, (n)
    real(dp), allocatable :: modal_mass(:)        !! M_k, (n)
    real(dp), allocatable :: phase_velocity(:)    !! C_p, Eq. 32, missing where it does not exist, (n)
    real(dp), allocatable :: group_velocity(:)    !! C_g, Eq. 33, missing where it does not exist, (n)
    real(dp) :: struck_at = 1.0_dp                !! ξ₀
    logical :: uniform = .true.                   !! shapes are those of a uniform clamped beam that is struck at its tip
    integer :: root_power = 2                     !! of ξ, as which shapes rise at the root: 2 clamped, 1 hinged, 0 where it moves
    logical :: known_by_mass = .false.            !! shapes follow from γ and n alone: these are the first modes, in closed form
    type(dd) :: critical_speed                    !! lowest ω at which a mode is unstable; 0 where there is none
    logical :: grows_at_any_speed = .false.       !! nothing holds the beam against turning: it does so at every ω > 0
    logical :: resolved = .true.                  !! false where no modes could be found: the numbers of a set mean nothing then
  contains
    procedure(shapes_interface), deferred :: some_shapes
    procedure(shapes_interface), deferred :: some_curvatures      !! the same of Φ_k''(ξ); with shear ψ_k'(ξ), which bends
    procedure :: shapes => all_shapes
    procedure(overlap_interface), deferred :: overlap_with_mass   !! weight of the beam and of what its tip carries
    procedure(overlap_interface), deferred :: overlap_of_beam     !! weight of the beam alone
    procedure :: overlap_far_below                                !! the same, of modes far below these
    procedure(elastic_interface), deferred :: elastic
    procedure :: damp
    procedure :: rigid => rigid_modes
    procedure :: forget_rigid_waves
    procedure :: body_energy => no_body_energy
    procedure :: find_tip_shears => unknown_tip_shears
    procedure :: turnings => no_turnings
    procedure :: motion_at => plain_motion_at
    procedure :: share_of_turn => no_turnings                     !! ⟨Φ_k, R + x⟩: what a rigid turn is of each mode, times M_k; else 0
    procedure :: energy_of_pull => no_energy_of_pull
    procedure :: hub_turns => no_turnings                         !! how far a hub that is free turns in each mode, else 0
    procedure :: number_errors => errors_of_set
  end type mode_set

  type, public :: search_failure
    !! Numbers of modes among which one was not found, the first time that happened. A sum to which such a mode adds nothing is
    !! wrong, and so is an estimate: whoever asks for sums or estimates looks here afterwards.
    integer :: first = 0                          !! 0: all modes were found
    integer :: last = 0
  end type search_failure

  type, abstract, public :: mode_source
    !! Modes of any number, of one beam with what it carries.
    type(search_failure), pointer :: failure => null()
      !! where a search that fails is noted; null: nowhere. It outlives the source and its copies
    class(monitor_type), pointer :: monitor => null()
      !! asked in searches that have none of their own, whose modes then mean nothing; null: nobody is. It lives as long
    real(dp) :: gamma = 0.0_dp                    !! captured mass γ
    integer :: highest = 0                        !! the highest mode number that can be found
    integer :: at_most = huge(1)                  !! to which number it can be extended
    integer :: quickly = huge(1)                  !! as many as can be found in about a second
    real(dp) :: stretch = 1.0_dp                  !! phases are to be right for so many times the length of a record
    real(dp) :: struck_at = 1.0_dp                !! as those of a set
    logical :: uniform = .true.
    integer :: root_power = 2
    type(damping_law), allocatable :: damping     !! of the modes that are found; unallocated: undamped
    type(struck_beam) :: pieces                   !! what the modes are of, without its tension
  contains
    procedure(find_interface), deferred :: find
    procedure :: terms => terms_of_set
    procedure :: note_failure
  end type mode_source

  type, public :: configuration_type
    !! A beam with what it carries for some time: where modes of any number come from, and those that are in memory.
    class(mode_source), allocatable :: source     !! unallocated: there are none but those in memory
    class(mode_set), allocatable :: set           !! the first modes; unallocated: none were asked for
  end type configuration_type

  abstract interface
    pure function shapes_interface(self, first, last, xi) result(values)
      !! Φ_k(ξ) of modes `first` … `last` of the set, at points of the beam.
      import :: mode_set, dp
      class(mode_set), intent(in) :: self
      integer, intent(in) :: first, last
      real(dp), intent(in) :: xi(:)               !! 0 ≤ ξ ≤ 1, (points)
      real(dp) :: values(last - first + 1, size(xi))   !! (modes, points)
    end function shapes_interface

    function overlap_interface(self, from, amplitude, monitor) result(sums)
      !! What these modes see of a motion Σ_i a_iφ_i written in others: the sums over i of the weighted integrals of
      !! Φ_kφ_i, times a_i. Divided by the modal masses they are the motion's projection on these modes.
      !! **Limits**: both sets were found in the same way, for the same beam; else there is no number.
      import :: mode_set, monitor_type, dp
      class(mode_set), intent(in) :: self
      class(mode_set), intent(in) :: from         !! modes φ_i
      real(dp), intent(in) :: amplitude(:)        !! a_i of the first of them; the others are at rest
      class(monitor_type), intent(inout), optional :: monitor   !! the sums are invalid if it requests a stop
      real(dp) :: sums(self%count)
    end function overlap_interface

    subroutine find_interface(self, number, modes, longest, monitor)
      !! Find the modes of these numbers, damped by the source's law.
      import :: mode_set, mode_source, monitor_type, dp
      class(mode_source), intent(in) :: self
      integer, intent(in) :: number(:)            !! 1 ≤ k ≤ `highest`, ascending
      class(mode_set), allocatable, intent(out) :: modes
      real(dp), intent(in), optional :: longest
        !! the longest time, in l²/h, after which phases must still be right; absent: no history is asked for
      class(monitor_type), intent(inout), optional :: monitor   !! the modes are invalid if it requests a stop
    end subroutine find_interface

    pure function elastic_interface(self) result(squares)
      !! K_kk/M_kk, K the elastic stiffness without tension and rotation: what damping is proportional to. Where nothing else
      !! acts it is β² itself.
      import :: mode_set, dd
      class(mode_set), intent(in) :: self
      type(dd) :: squares(self%count)             !! (modes)
    end function elastic_interface
  end interface

contains

  pure function all_shapes(self, xi) result(values)
    !! Φ_k(ξ) at points of the beam.
    class(mode_set), intent(in) :: self
    real(dp), intent(in) :: xi(:)                 !! 0 ≤ ξ ≤ 1, (points)
    real(dp) :: values(self%count, size(xi))      !! (modes, points)
    values = self%some_shapes(1, self%count, xi)
  end function all_shapes

  pure function values_at(modes, quantity, first, last, xi) result(values)
    !! Φ_k(ξ), or Φ_k''(ξ), of some modes of a set.
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

  function overlap_far_below(self, from, amplitude, monitor) result(sums)
    !! `overlap_of_beam` where modes of beam and mass are far below these of the beam alone, and their limit may be known.
    class(mode_set), intent(in) :: self
    class(mode_set), intent(in) :: from
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor
    real(dp) :: sums(self%count)
    sums = self%overlap_of_beam(from, amplitude, monitor)
  end function overlap_far_below

  subroutine note_failure(self, number)
    !! One of the modes of these numbers was not found.
    class(mode_source), intent(in) :: self
    integer, intent(in) :: number(:)              !! ascending
    if (.not. associated(self%failure) .or. size(number) == 0) return
    if (self%failure%first == 0) self%failure = search_failure(number(1), number(size(number)))
  end subroutine note_failure

  subroutine attend(configurations, failure, monitor)
    !! Have searches that fail noted, and all left where a monitor asks to stop. Both outlive the sources.
    type(configuration_type), intent(inout) :: configurations(:)
    type(search_failure), intent(in), target :: failure
    class(monitor_type), intent(inout), target :: monitor
    integer :: i
    do i = 1, size(configurations)
      if (.not. allocated(configurations(i)%source)) cycle
      configurations(i)%source%failure => failure
      configurations(i)%source%monitor => monitor
    end do
  end subroutine attend

  pure type(search_failure) function first_failure(configurations) result(failure)
    !! The first that was noted.
    type(configuration_type), intent(in) :: configurations(:)
    if (.not. allocated(configurations(1)%source)) return
    if (associated(configurations(1)%source%failure)) failure = configurations(1)%source%failure
  end function first_failure

  pure function first_numbers(count) result(number)
    !! 1 … count: the first modes of a source.
    integer, intent(in) :: count
    integer :: number(count)
    integer :: k
    number = [(k, k=1, count)]
  end function first_numbers

  pure integer function first_struck(modes) result(k)
    !! The first mode that a blow reaches: not one that is at rest where the mass strikes.
    class(mode_set), intent(in) :: modes
    real(dp), parameter :: at_rest = 1.0e-3_dp
    associate (shape => abs(modes%struck))
      k = max(1, findloc(shape > at_rest*maxval(shape), .true., dim=1))
    end associate
  end function first_struck

  pure real(dp) function mean_rate(modes, rate)
    !! Angular velocity that the rigid turn has, of a hub that is free; else 0.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: rate(:)               !! modal velocities, (modes)
    mean_rate = 0.0_dp
    if (size(rate) == 0) return
    associate (turning => modes%hub_turns())
      if (turning(1) /= 0.0_dp) mean_rate = turning(1)*rate(1)
    end associate
  end function mean_rate

  pure function rigid_modes(self) result(rigid)
    !! Which of the first two modes move the beam as a rigid body: their shapes are straight to within a hundredth. No other
    !! mode does, since a straight line has two numbers.
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
    !! A beam that moves as a rigid body carries no wave.
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
    !! Damp the modes that were found: set c_k, and β² − c²/4.
    class(mode_set), intent(inout) :: self
    type(damping_law), intent(in), optional :: law      !! absent: they stay undamped
    type(dd) :: elastic(self%count)
    if (.not. present(law)) return
    elastic = self%elastic()
    self%law = law
    self%damping = law%rates(elastic%hi)
    self%damped_squared = self%beta_squared - law%quarter_squares(elastic)
  end subroutine damp

  pure subroutine errors_of_set(self, square_error, mass_error)
    !! Standard errors of the numbers that move modes which were found in binary64: they may be off by a few of these. LAPACK's
    !! singular values give β² to rounding of its elastic part, of 200 modes within 7e-15; their vectors, and with them M, are
    !! good to rounding over the gap to the next value, about 2/(kα²).
    class(mode_set), intent(in) :: self
    real(dp), intent(out) :: square_error(:)      !! of β², (modes)
    real(dp), intent(out) :: mass_error(:)        !! of M, relatively, beside rounding, (modes)
    real(dp), parameter :: relative_error = 2.0e-15_dp
    type(dd) :: elastic(self%count)
    integer :: k
    elastic = self%elastic()
    square_error = relative_error*(elastic%hi + abs(self%beta_squared%hi))
    if (allocated(self%square_rounding)) square_error = max(square_error, self%square_rounding)
    mass_error = relative_error + 0.5_dp*epsilon(1.0_dp)*[(k, k=1, self%count)]*sqrt(elastic%hi)
  end subroutine errors_of_set

  pure function no_body_energy(self, q, rate) result(energy)
    !! Energy of what the tip carries, beside that of its mass moving with the deflection: kinetic, and potential. A point
    !! mass has none where there is no tension.
    class(mode_set), intent(in) :: self
    real(dp), intent(in) :: q(:), rate(:)         !! state of the modes, (modes)
    real(dp) :: energy(2)
    energy = 0.0_dp
    if (self%count + size(q) + size(rate) == 0) return     ! it depends on none of them
  end function no_body_energy

  pure subroutine unknown_tip_shears(self, shear, known)
    !! Shear forces at a tip that is held, EI/l³ of the root piece, where the modes themselves have them.
    class(mode_set), intent(in) :: self
    real(dp), intent(out) :: shear(:)             !! (modes)
    logical, intent(out) :: known
    shear = 0.0_dp*self%modal_mass
    known = .false.
  end subroutine unknown_tip_shears

  pure function no_turnings(self) result(turning)
    !! How far sections turn at ξ₀ in each mode where a body with rotary inertia has been captured; 0 where nothing asks, (modes).
    class(mode_set), intent(in) :: self
    real(dp) :: turning(self%count)
    turning = 0.0_dp
  end function no_turnings

  pure function plain_motion_at(self, xi) result(motion)
    !! Deflection of all modes at a place, and the turning of the section there, both in the frame that turns evenly: what a body
    !! at that place does, (modes, 2). Sets that never carry more than a point mass leave the turning out.
    class(mode_set), intent(in) :: self
    real(dp), intent(in) :: xi                    !! 0 ≤ ξ ≤ 1
    real(dp) :: motion(self%count, 2)
    motion(:, 1:1) = self%some_shapes(1, self%count, [xi])
    motion(:, 2) = 0.0_dp
  end function plain_motion_at

  pure real(dp) function no_energy_of_pull(self, xi, q) result(energy)
    !! ½∫v'² from the axis to a place: how far a centrifugal force of 1 there has been drawn inwards. 0 where there is no tension.
    class(mode_set), intent(in) :: self
    real(dp), intent(in) :: xi
    real(dp), intent(in) :: q(:)                  !! of the first modes
    energy = 0.0_dp*(self%count + size(q) + xi)
  end function no_energy_of_pull

  subroutine terms_of_set(self, number, xi, longest, beta, drive, shapes, mass)
    !! Find what a sum over modes asks of them, and no more: a source may find it for less than a whole set.
    class(mode_source), intent(in) :: self
    integer, intent(in) :: number(:)              !! as those of `find`
    real(dp), intent(in) :: xi(:)                 !! 0 ≤ ξ ≤ 1, (points)
    real(dp), intent(in), optional :: longest     !! as that of `find`
    type(dd), intent(out) :: beta(:)              !! √|β²| with the sign of β²: below zero for a growing mode, (modes)
    real(dp), intent(out) :: drive(:)             !! Φ_k(ξ₀)/M_k, (modes)
    real(dp), intent(out) :: shapes(:, :)         !! Φ_k(ξ), (modes, points)
    real(dp), intent(out), optional :: mass(:)    !! M_k, (modes)
    class(mode_set), allocatable :: modes
    call self%find(number, modes, longest, self%monitor)
    call take_terms(modes, beta, drive)
    shapes = modes%shapes(xi)
    if (present(mass)) mass = modes%modal_mass
  end subroutine terms_of_set

  subroutine take_terms(modes, beta, drive)
    !! What a sum over modes asks of a set, beside its shapes.
    class(mode_set), intent(in) :: modes
    type(dd), intent(out) :: beta(:)              !! those of `terms_of_set`
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
