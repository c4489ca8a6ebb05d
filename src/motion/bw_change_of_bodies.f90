module bw_change_of_bodies
  !! Changes of the bodies on a moving beam. The motion is projected onto the modes of the beam with the bodies that it
  !! carries afterwards, weighted by all mass that is there afterwards: M̄_kq̄_k = ∫ρAΦ̄_kv dx + Σ mΦ̄_kv_b + JΨ̄_kψ_b,
  !! and likewise for velocities. An arriving body takes the motion of the beam, or brings a velocity u and no rotation:
  !! this adds m(u − v̇_b)Φ̄_k − Jψ̇_bΨ̄_k to the modal momenta. A leaving body keeps its motion.
  !!
  !! Arriving springs are unstressed at the current deflection and slope. They pull towards these with a constant force
  !! f_k = Σ k_vv_bΦ̄_k + k_θψ_bΨ̄_k, so the beam moves freely about an equilibrium. Its modal displacements
  !! f_k/(M̄_kβ̄_k²) converge slowly for stiff springs, as few modes fit the shape in which a joint was locked. The
  !! distance from it at that instant, u_k = q̄_k − f_k/(M̄_kβ̄_k²), converges fast. So the equilibrium is stored as the
  !! shape of the beam then less Σu_kΦ̄_k, and displacements have no jump.
  !!
  !! Energies are those of bw_release. The energy of the equilibrium follows from the continuity of the potential
  !! energy. Units of bw_segment.
  use bw_double_double, only: accurate_sum
  use bw_event, only: event_type
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_mode_set, only: configuration_type, first_struck_mode, mean_rate, mode_set
  use bw_monitor, only: monitor_type, stops
  use bw_projection, only: projection_rounding
  use bw_segment, only: energy_type, known_energy, shape_term, operator(+)
  implicit none (type, external)
  private
  public :: energy_at, energy_of, change_bodies, strike_beam

  type, public :: body_type
    !! A body with its springs.
    real(dp) :: position = 1.0_dp
    real(dp) :: mass = 0.0_dp, inertia = 0.0_dp
    real(dp) :: stiffness = 0.0_dp, turning_stiffness = 0.0_dp
    real(dp) :: velocity = missing          !! at arrival; missing: that of the beam
    real(dp) :: pull = 0.0_dp               !! Ω²m(R + ξ): tension due to the body, inwards of it
    real(dp) :: unstressed(2) = 0.0_dp      !! deflection and rotation at which its springs are so
    real(dp) :: beside = 0.0_dp             !! offset from the beam's axis, across the beam
  end type body_type

  type, public :: beam_state
    !! An equilibrium shape, and a motion of the first modes of a configuration about it.
    integer :: count = 0                    !! number of these modes
    real(dp), allocatable :: q(:), rate(:)  !! (modes of the set), 0 beyond `count`
    type(shape_term), allocatable :: shape(:)       !! empty: straight
    real(dp) :: level = 0.0_dp              !! energy of the shape
  end type beam_state

  type, public :: change_type
    !! A change of the bodies that the beam carries.
    integer :: from = 1, onto = 1           !! configurations before and after
    logical, allocatable :: was(:), is(:)   !! bodies that are there before and after, (bodies)
    integer :: count = 0                    !! modes after the change that take part
  end type change_type

  real(dp), parameter :: same_place = 8.0_dp*epsilon(1.0_dp)

contains

  subroutine change_bodies(configuration, change, state, bodies, spin_squared, later, event, monitor, beyond, unsummed)
    !! Project the state at a change of bodies, and find the event's energies and momenta. Its kind and time are left to
    !! the caller.
    type(configuration_type), intent(in) :: configuration(:)   !! modes found in the same way, for the same pieces
    type(change_type), intent(in) :: change
    type(beam_state), intent(in) :: state
    type(body_type), intent(inout) :: bodies(:)     !! `unstressed` is set for arriving bodies
    real(dp), intent(in) :: spin_squared            !! ω² in the plane of motion, else 0
    type(beam_state), intent(out) :: later
    type(event_type), intent(inout) :: event
    class(monitor_type), intent(inout), optional :: monitor   !! the state is invalid if it requests a stop
    real(dp), intent(in), optional :: beyond(:, :, :)
      !! known deflection and rotation at the bodies that the state lacks, and their rates, (bodies, 2, 2)
    real(dp), allocatable, intent(in), optional :: unsummed(:)
      !! the same for the beam between bodies, ∫ρAΦ_kv dx of its displacement, (modes after); unallocated: none
    type(shape_term), allocatable :: whole(:)       ! the displacement
    type(shape_term) :: motion(1)                   ! the velocity
    real(dp), dimension(size(bodies), 2) :: moved, moving, push, stretch
    real(dp) :: momenta(2)
    real(dp), allocatable :: bent(:), rest(:)
    type(energy_type) :: coming(2), leaving(2), left, potential
    integer :: b
    motion(1) = shape_term(change%from, change%was, state%rate(:state%count))
    whole = [state%shape, shape_term(change%from, change%was, state%q(:state%count))]
    moved = motions_at(bodies, configuration, whole)
    moving = motions_at(bodies, configuration, motion)
    stretch = motions_at(bodies, configuration, whole, while_there=.true.)
    if (present(beyond)) then
      moved = moved + beyond(:, :, 1)
      moving = moving + beyond(:, :, 2)
    end if
    push = relative_momenta(bodies, change%is .and. .not. change%was, moving)
    associate (before => configuration(change%from)%set, after => configuration(change%onto)%set)
      bent = state%q(:state%count)                  ! all of the displacement in these modes
      if (size(state%shape) > 0 .and. any(bodies%pull > 0.0_dp)) &
        bent = overlaps_with(before, change%was, bodies, configuration, whole, monitor)/before%modal_mass
      coming = energy_of_bodies(before, bent, bodies, change%is .and. .not. change%was, moved, moving, spin_squared)
      leaving = energy_of_bodies(before, bent, bodies, change%was .and. .not. change%is, moved, moving, spin_squared, stretch)
      potential = part_of_energy(before, state, .false.)
      potential%value = potential%value + state%level + coming(2)%value - leaving(2)%value
      event%energy_before = known_energy(energy_of(before, state) + coming(1) + coming(2))
      do b = 1, size(bodies)
        if (change%is(b) .and. .not. change%was(b)) bodies(b)%unstressed = moved(b, :)
      end do

      later%count = change%count
      later%q = overlaps_with(after, change%is, bodies, configuration, whole, monitor)
      if (stops(monitor)) return
      later%rate = overlaps_with(after, change%is, bodies, configuration, motion, monitor) + modal_loads(after, bodies, push)
      if (stops(monitor)) return
      if (present(beyond)) then
        associate (gain => max(0.0_dp, mass_gains(bodies, change%was, change%is)))
          later%q = later%q + modal_loads(after, bodies, gain*beyond(:, :, 1))
          later%rate = later%rate + modal_loads(after, bodies, gain*beyond(:, :, 2))
        end associate
      end if
      if (present(unsummed)) then
        if (allocated(unsummed)) later%q = later%q + unsummed
      end if
      later%q = later%q/after%modal_mass
      later%rate = later%rate/after%modal_mass
      later%shape = state%shape(:0)
      later%q(change%count + 1:) = 0.0_dp
      later%rate(change%count + 1:) = 0.0_dp
      if (any(is_strained(bodies) .and. change%is)) then
        rest = equilibrium_of(after, change%count, bodies, spring_forces(bodies, change%is))
        later%q(:change%count) = later%q(:change%count) - rest
        later%shape = [whole, shape_term(change%onto, change%is, -later%q(:change%count))]
      end if
      if (any(change%is .and. bodies%beside /= 0.0_dp)) then
        rest = equilibrium_of(after, change%count, bodies, offset_forces(bodies, change%is, spin_squared))
        later%q(:change%count) = later%q(:change%count) - rest
        later%shape = [later%shape, shape_term(change%onto, change%is, rest)]
        later%level = -0.5_dp*(sum(after%modal_mass(:change%count)*after%beta_squared(:change%count)%hi*rest**2) &
                               + spin_squared*sum(bodies%mass*bodies%beside**2, mask=change%is))
      end if
      if (any(is_strained(bodies) .and. change%is)) then       ! its shape is included
        left = part_of_energy(after, later, .false.)
        later%level = potential%value - left%value
      end if
      event%energy_after = known_energy(energy_of(after, later) + leaving(1) + leaving(2))
      call find_momenta(before, state, change%was, after, change%is, bodies, moving, push, momenta)
      event%momentum_before = missing
      event%momentum_after = missing
      associate (k => first_struck_mode(after))
        if (abs(after%struck(k)) > epsilon(1.0_dp)) then   ! else the point is held, and shapes have size 1
          event%momentum_before = (momenta(1) + momenta(2))/after%struck(k)
          event%momentum_after = (after%modal_mass(k)*later%rate(k) + momenta(2))/after%struck(k)
        end if
      end associate
      event%hub_rate_change = mean_rate(after, later%rate) - mean_rate(before, state%rate)
    end associate
  end subroutine change_bodies

  function overlaps_with(modes, is, bodies, configuration, terms, monitor) result(sums)
    !! Return ∫ρAΦ_kv dx + Σ mΦ_kv_b + JΨ_kψ_b of a motion, with all bodies after the change, (modes).
    class(mode_set), intent(in) :: modes
    logical, intent(in) :: is(:)
    type(body_type), intent(in) :: bodies(:)
    type(configuration_type), intent(in) :: configuration(:)
    type(shape_term), intent(in) :: terms(:)
    class(monitor_type), intent(inout), optional :: monitor   !! the sums are invalid if it requests a stop
    real(dp) :: sums(modes%count), seen(modes%count)
    integer :: i
    sums = 0.0_dp
    do i = 1, size(terms)
      associate (term => terms(i), set => configuration(terms(i)%configuration)%set)
        seen = beam_overlaps(modes, set, term%amplitude)
        if (stops(monitor)) return
        sums = sums + seen &
          + modal_loads(modes, bodies, max(0.0_dp, mass_gains(bodies, term%there, is)) &
                        *motions_at(bodies, configuration, terms(i:i)))
      end associate
    end do
  contains
    function beam_overlaps(onto, set, amplitude) result(seen)
      !! Return the part of the beam.
      class(mode_set), intent(in) :: onto, set
      real(dp), intent(in) :: amplitude(:)
      real(dp) :: seen(onto%count)
      seen = onto%overlap(set, amplitude, .false., monitor)
    end function beam_overlaps
  end function overlaps_with

  pure function modal_loads(modes, bodies, push) result(sums)
    !! Return the modal loads of forces and moments, or impulses, at the bodies, (modes).
    class(mode_set), intent(in) :: modes
    type(body_type), intent(in) :: bodies(:)
    real(dp), intent(in) :: push(:, :)              !! (bodies, 2)
    real(dp) :: sums(modes%count)
    integer :: b
    sums = 0.0_dp
    do b = 1, size(bodies)
      if (any(push(b, :) /= 0.0_dp)) sums = sums + matmul(modes%motion_at(bodies(b)%position), push(b, :))
    end do
  end function modal_loads

  subroutine find_momenta(before, state, was, after, is, bodies, moving, push, momenta)
    !! Find the generalised momenta of the first struck mode after the change, times its displacement there: of what it
    !! takes over, with the modes before, and of what leaves.
    class(mode_set), intent(in) :: before, after
    type(beam_state), intent(in) :: state
    logical, intent(in) :: was(:), is(:)
    type(body_type), intent(in) :: bodies(:)
    real(dp), intent(in) :: moving(:, :), push(:, :)
    real(dp), intent(out) :: momenta(2)
    real(dp) :: gain(size(bodies), 2), shape(after%count, 2), amplitude(first_struck_mode(after))
    integer :: b, k
    k = size(amplitude)
    amplitude = 0.0_dp
    amplitude(k) = 1.0_dp
    gain = mass_gains(bodies, was, is)
    associate (seen => before%overlap(after, amplitude, .false.), n => state%count)
      momenta = [accurate_sum(seen(:n)*state%rate(:n)), 0.0_dp]
    end associate
    do b = 1, size(bodies)
      shape = after%motion_at(bodies(b)%position)
      momenta(1) = momenta(1) + sum(shape(k, :)*(max(0.0_dp, gain(b, :))*moving(b, :) + push(b, :)))
      momenta(2) = momenta(2) - sum(shape(k, :)*min(0.0_dp, gain(b, :))*moving(b, :))
    end do
  end subroutine find_momenta

  function motions_at(bodies, configuration, terms, while_there) result(motion)
    !! Return deflection and rotation at the bodies, or their rates, (bodies, 2).
    type(body_type), intent(in) :: bodies(:)
    type(configuration_type), intent(in) :: configuration(:)
    type(shape_term), intent(in) :: terms(:)
    logical, intent(in), optional :: while_there
      !! only terms during which the body was there: they strain its springs, which are unstressed in the others
    real(dp) :: motion(size(bodies), 2)
    real(dp), allocatable :: shape(:, :)
    integer :: b, i
    motion = 0.0_dp
    do i = 1, size(terms)
      associate (set => configuration(terms(i)%configuration)%set, amplitude => terms(i)%amplitude)
        do b = 1, size(bodies)
          if (present(while_there)) then
            if (.not. terms(i)%there(b)) cycle
          end if
          shape = set%motion_at(bodies(b)%position)
          motion(b, 1) = motion(b, 1) + accurate_sum(shape(:size(amplitude), 1)*amplitude)
          motion(b, 2) = motion(b, 2) + accurate_sum(shape(:size(amplitude), 2)*amplitude)
        end do
      end associate
    end do
  end function motions_at

  pure function mass_gains(bodies, was, is) result(gain)
    !! Return the increase of mass and inertia at a place, stored with the first body there, (bodies, 2). If a body
    !! replaces another, only the difference counts.
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: was(:), is(:)
    real(dp) :: gain(size(bodies), 2)
    integer :: a, b
    gain = 0.0_dp
    do b = 1, size(bodies)
      do a = 1, b
        if (abs(bodies(a)%position - bodies(b)%position) <= same_place) exit
      end do
      gain(a, 1) = gain(a, 1) + merge(bodies(b)%mass, 0.0_dp, is(b)) - merge(bodies(b)%mass, 0.0_dp, was(b))
      gain(a, 2) = gain(a, 2) + merge(bodies(b)%inertia, 0.0_dp, is(b)) - merge(bodies(b)%inertia, 0.0_dp, was(b))
    end do
  end function mass_gains

  pure function relative_momenta(bodies, comes, moving) result(push)
    !! Return the momentum, linear and angular, of bodies that arrive with a velocity, relative to the beam, (bodies, 2).
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: comes(:)
    real(dp), intent(in) :: moving(:, :)            !! velocities of the beam there
    real(dp) :: push(size(bodies), 2)
    integer :: b
    push = 0.0_dp
    do b = 1, size(bodies)
      if (.not. comes(b) .or. is_missing(bodies(b)%velocity)) cycle
      push(b, :) = [bodies(b)%mass*(bodies(b)%velocity - moving(b, 1)), -bodies(b)%inertia*moving(b, 2)]
    end do
  end function relative_momenta

  function energy_of_bodies(modes, bent, bodies, these, moved, moving, spin_squared, stretch) result(energy)
    !! Return kinetic and potential energy of some bodies, which arrive with unstressed springs, or leave.
    class(mode_set), intent(in) :: modes            !! before the change
    real(dp), intent(in) :: bent(:)                 !! modal displacements then
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: these(:)
    real(dp), intent(in) :: moved(:, :), moving(:, :)
    real(dp), intent(in) :: spin_squared
    real(dp), intent(in), optional :: stretch(:, :) !! of the springs of leaving bodies; absent: they arrive
    type(energy_type) :: energy(2)
    real(dp) :: part(5)
    integer :: b
    do b = 1, size(bodies)
      if (.not. these(b)) cycle
      associate (body => bodies(b))
        part = 0.0_dp
        part(1:2) = 0.5_dp*[body%mass, body%inertia]*moving(b, :)**2
        if (present(stretch)) then
          part(3) = 0.5_dp*(body%stiffness*stretch(b, 1)**2 + body%turning_stiffness*stretch(b, 2)**2)
        else if (.not. is_missing(body%velocity)) then
          part(1:2) = [0.5_dp*body%mass*body%velocity**2, 0.0_dp]
        end if
        part(4:5) = energy_at(modes, bent, body, moved(b, :), spin_squared)
        energy = energy + [energy_type(sum(part(:2)), projection_rounding*sum(abs(part(:2)))), &
                           energy_type(sum(part(3:)), projection_rounding*sum(abs(part(3:))))]
      end associate
    end do
  end function energy_of_bodies

  pure function energy_at(modes, bent, body, moved, spin_squared) result(energy)
    !! Return a body's centrifugal potential: across the beam, and along it, as bending and rotation move it inwards.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: bent(:)                 !! modal displacements
    type(body_type), intent(in) :: body
    real(dp), intent(in) :: moved(2)                !! deflection and rotation of the beam there
    real(dp), intent(in) :: spin_squared
    real(dp) :: energy(2)
    energy = [-0.5_dp*body%mass*spin_squared*(moved(1) + body%beside)**2, 0.0_dp]
    if (body%pull > 0.0_dp) energy(2) = body%pull*(modes%energy_of_pull(body%position, bent) + body%beside*moved(2))
  end function energy_at

  pure type(energy_type) function energy_of(modes, state) result(energy)
    !! Return ½ΣM(q̇² + β²q²) about the equilibrium, and the energy of the latter.
    class(mode_set), intent(in) :: modes
    type(beam_state), intent(in) :: state
    energy = part_of_energy(modes, state, .true.) + part_of_energy(modes, state, .false.) + energy_type(state%level, 0.0_dp)
  end function energy_of

  pure type(energy_type) function part_of_energy(modes, state, kinetic) result(energy)
    !! Return ½ΣMq̇², or ½ΣMβ²q².
    class(mode_set), intent(in) :: modes
    type(beam_state), intent(in) :: state
    logical, intent(in) :: kinetic
    real(dp) :: parts(state%count)
    associate (n => state%count, mass => modes%modal_mass)
      if (kinetic) then
        parts = 0.5_dp*mass(:n)*state%rate(:n)**2
      else
        parts = 0.5_dp*mass(:n)*modes%beta_squared(:n)%hi*state%q(:n)**2
      end if
    end associate
    energy = energy_type(accurate_sum(parts), projection_rounding*sum(abs(parts)))
  end function part_of_energy

  elemental logical function is_strained(body)
    !! Return whether a body's springs are strained in a straight beam.
    type(body_type), intent(in) :: body
    is_strained = any([body%stiffness, body%turning_stiffness]*body%unstressed /= 0.0_dp)
  end function is_strained

  pure function spring_forces(bodies, there) result(forces)
    !! Return the spring forces on a straight beam, and their moments, (bodies, 2).
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: there(:)
    real(dp) :: forces(size(bodies), 2)
    forces(:, 1) = merge(bodies%stiffness*bodies%unstressed(1), 0.0_dp, there)
    forces(:, 2) = merge(bodies%turning_stiffness*bodies%unstressed(2), 0.0_dp, there)
  end function spring_forces

  pure function offset_forces(bodies, there, spin_squared) result(forces)
    !! Return the centrifugal forces across the beam on bodies beside its axis, and the moments of those along it, (bodies, 2).
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: there(:)
    real(dp), intent(in) :: spin_squared
    real(dp) :: forces(size(bodies), 2)
    forces(:, 1) = merge(spin_squared*bodies%mass*bodies%beside, 0.0_dp, there)
    forces(:, 2) = merge(-bodies%pull*bodies%beside, 0.0_dp, there)
  end function offset_forces

  pure function equilibrium_of(modes, count, bodies, forces) result(rest)
    !! Return f_k/(M_kβ_k²), (count); 0 for a mode with β = 0.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: count
    type(body_type), intent(in) :: bodies(:)
    real(dp), intent(in) :: forces(:, :)            !! and moments, (bodies, 2)
    real(dp) :: rest(count)
    real(dp) :: pushed(modes%count)
    pushed = modal_loads(modes, bodies, forces)
    rest = pushed(:count)
    where (modes%beta_squared(:count)%hi /= 0.0_dp)
      rest = rest/(modes%modal_mass(:count)*modes%beta_squared(:count)%hi)
    elsewhere
      rest = 0.0_dp
    end where
  end function equilibrium_of

  subroutine strike_beam(modes, state, mass, velocity, restitution, place, speed_after, jump, event)
    !! Let a mass strike a beam, at rest or not, and rebound: H = (1 + e)(V − v̇)/(1/m + ΣΦ_k²/M_k) over the modes that take part.
    class(mode_set), intent(in) :: modes
    type(beam_state), intent(inout) :: state
    real(dp), intent(in) :: mass, velocity, restitution
    real(dp), intent(in) :: place                   !! potential energy of the mass
    real(dp), intent(out) :: speed_after            !! of the mass
    real(dp), allocatable, intent(out) :: jump(:)   !! of modal velocities, (modes)
    type(event_type), intent(inout) :: event
    real(dp) :: momentum
    integer :: k, n
    n = state%count
    k = first_struck_mode(modes)
    associate (struck => modes%struck(:n), modal => modes%modal_mass(:n))
      event%energy_before = known_energy(energy_of(modes, state) + energy_type(0.5_dp*mass*velocity**2 + place, 0.0_dp))
      momentum = modes%modal_mass(k)*state%rate(k)/modes%struck(k)
      event%momentum_before = momentum + mass*velocity
      event%impulse = (1.0_dp + restitution)*mass*(velocity - accurate_sum(struck*state%rate(:n))) &
        /(1.0_dp + mass*accurate_sum(struck**2/modal))
      allocate (jump(modes%count), source=0.0_dp)
      jump(:n) = struck*event%impulse/modal
      state%rate = state%rate + jump
      speed_after = velocity
      if (mass > 0.0_dp) speed_after = velocity - event%impulse/mass
      event%momentum_after = momentum + modes%modal_mass(k)*jump(k)/modes%struck(k) + mass*speed_after
      event%energy_after = known_energy(energy_of(modes, state) + energy_type(0.5_dp*mass*speed_after**2 + place, 0.0_dp))
      event%hub_rate_change = mean_rate(modes, jump)
    end associate
  end subroutine strike_beam

end module bw_change_of_bodies
