module bw_change_of_bodies
  !! Bodies come to a beam that moves, or leave it: its motion goes over to the modes of what it carries then. What it did before is
  !! projected on them with their own weight, M̄_kq̄_k = ∫ρAΦ̄_kv dx + Σ mΦ̄_kv_b + JΨ̄_kψ_b over all that is there then, and likewise the
  !! velocities. A body that comes takes the motion of the beam, or it brings a velocity u of its own and no spin: to the momenta of
  !! modes that adds m(u − v̇_b)Φ̄_k − Jψ̇_bΨ̄_k. What leaves takes along what it has.
  !!
  !! Springs that come are unstressed at the deflection and the slope that the beam has then. They pull towards these, a constant force
  !! f_k = Σ k_vv_bΦ̄_k + k_θψ_bΨ̄_k: the beam moves freely about the equilibrium f_k/(M̄_kβ̄_k²), until they leave.
  !!
  !! Energies are those of bw_release. What the equilibrium has itself follows from the potential energy, which does not jump as the
  !! displacement does not: springs that came hold the beam in a shape that few modes hardly have. Units of bw_segment.
  use bw_double_double, only: accurate_sum
  use bw_event, only: event_type
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_mode_set, only: first_struck, mean_rate, mode_set
  use bw_monitor, only: monitor_type, stops
  use bw_segment, only: energy_type, known_energy, operator(+)
  implicit none (type, external)
  private
  public :: equilibrium_of, energy_of, hand_over, strike_beam

  type, public :: body_type
    !! A body with its springs.
    real(dp) :: position = 1.0_dp
    real(dp) :: mass = 0.0_dp, inertia = 0.0_dp
    real(dp) :: stiffness = 0.0_dp, turning_stiffness = 0.0_dp
    real(dp) :: velocity = missing          !! that it brings; missing: that of the beam
    real(dp) :: pull = 0.0_dp               !! Ω²m(R + ξ): the tension that it brings into the beam inside of it
    real(dp) :: unstressed(2) = 0.0_dp      !! deflection and turning at which its springs are so
  end type body_type

  type, public :: beam_state
    !! Of the first modes of a configuration, all others being at rest; measured from the straight beam.
    integer :: count = 0                    !! how many
    real(dp), allocatable :: q(:), rate(:)  !! (modes of the set), 0 beyond the count
    real(dp) :: level = 0.0_dp              !! energy of the equilibrium, which springs that came to a bent beam hold
  end type beam_state

  real(dp), parameter :: same_place = 8.0_dp*epsilon(1.0_dp)
  real(dp), parameter :: projection_rounding = 1.0e-13_dp   !! of integrals of two shapes, relatively

contains

  subroutine hand_over(before, state, was, after, count, is, bodies, spin_squared, later, event, monitor)
    !! The state of the modes after a change, and the balance of the event; its kind and its time are the caller's.
    class(mode_set), intent(in) :: before
    type(beam_state), intent(in) :: state
    logical, intent(in) :: was(:), is(:)            !! which bodies are there before and after, (bodies)
    class(mode_set), intent(in) :: after            !! found in the same way, of the same pieces
    integer, intent(in) :: count                    !! modes after that take part
    type(body_type), intent(inout) :: bodies(:)     !! springs of those that come are unstressed from now on
    real(dp), intent(in) :: spin_squared            !! ω² in the plane of the motion, else 0
    type(beam_state), intent(out) :: later
    type(event_type), intent(inout) :: event
    class(monitor_type), intent(inout), optional :: monitor   !! the state means nothing where it asks to stop
    real(dp), dimension(size(bodies), 2) :: gain, moved, moving, push
    real(dp) :: shape(after%count, 2), first(2)
    type(energy_type) :: coming(2), held, leaving(2), left     ! kinetic and potential
    real(dp) :: going, staying
    integer :: b, k, n
    n = state%count
    moved = motions_at(bodies, before, n, state%q)
    moving = motions_at(bodies, before, n, state%rate)
    gain = gains(bodies, was, is)
    push = blows(bodies, is .and. .not. was, moving)
    coming = brought(before, state, bodies, is .and. .not. was, moved, moving, spin_squared)
    leaving = brought(before, state, bodies, was .and. .not. is, moved, moving, spin_squared, leaving=.true.)
    held = part_of_energy(before, state, bodies, was, .false.)
    held%value = held%value + state%level + coming(2)%value - leaving(2)%value
    event%energy_before = known_energy(energy_of(before, state, bodies, was) + coming(1) + coming(2))

    later%count = count
    later%q = after%overlap_of_beam(before, state%q(:n), monitor)
    later%rate = after%overlap_of_beam(before, state%rate(:n), monitor)
    if (stops(monitor)) return
    k = first_struck(after)
    staying = 0.0_dp                                ! momenta of mode k: of what goes over, and of what leaves
    going = 0.0_dp
    associate (seen => before%overlap_of_beam(after, unit_of(k)))
      staying = accurate_sum(seen(:n)*state%rate(:n))
    end associate
    do b = 1, size(bodies)
      shape = after%motion_at(bodies(b)%position)
      later%q = later%q + matmul(shape, max(0.0_dp, gain(b, :))*moved(b, :))
      later%rate = later%rate + matmul(shape, max(0.0_dp, gain(b, :))*moving(b, :) + push(b, :))
      first = shape(k, :)
      staying = staying + sum(first*(max(0.0_dp, gain(b, :))*moving(b, :) + push(b, :)))
      going = going - sum(first*min(0.0_dp, gain(b, :))*moving(b, :))
      if (is(b) .and. .not. was(b)) bodies(b)%unstressed = moved(b, :)
    end do
    later%q = later%q/after%modal_mass
    later%rate = later%rate/after%modal_mass
    later%q(count + 1:) = 0.0_dp
    later%rate(count + 1:) = 0.0_dp

    if (any(is_bent(bodies) .and. is)) then
      left = part_of_energy(after, later, bodies, is, .false.)
      later%level = held%value - left%value
    end if
    event%energy_after = known_energy(energy_of(after, later, bodies, is) + leaving(1) + leaving(2))
    event%momentum_before = (staying + going)/after%struck(k)
    event%momentum_after = (after%modal_mass(k)*later%rate(k) + going)/after%struck(k)
    event%hub_rate_change = mean_rate(after, later%rate) - mean_rate(before, state%rate)
  end subroutine hand_over

  pure function unit_of(k) result(amplitude)
    !! Mode k alone.
    integer, intent(in) :: k
    real(dp) :: amplitude(k)
    amplitude = 0.0_dp
    amplitude(k) = 1.0_dp
  end function unit_of

  pure function motions_at(bodies, modes, count, amplitude) result(motion)
    !! Deflection and turning at the bodies, or their rates, (bodies, 2).
    type(body_type), intent(in) :: bodies(:)
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: count
    real(dp), intent(in) :: amplitude(:)            !! of the modes
    real(dp) :: motion(size(bodies), 2)
    real(dp) :: shape(modes%count, 2)
    integer :: b
    do b = 1, size(bodies)
      shape = modes%motion_at(bodies(b)%position)
      motion(b, 1) = accurate_sum(shape(:count, 1)*amplitude(:count))
      motion(b, 2) = accurate_sum(shape(:count, 2)*amplitude(:count))
    end do
  end function motions_at

  pure function gains(bodies, was, is) result(gain)
    !! By how much mass and inertia at a place grow or fall, told with the first body there, (bodies, 2): as one body comes where another
    !! leaves, what both have stays.
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
  end function gains

  pure function blows(bodies, comes, moving) result(push)
    !! Momentum and spin that bodies with a velocity of their own bring beyond those of the beam's motion, (bodies, 2).
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: comes(:)
    real(dp), intent(in) :: moving(:, :)            !! velocities of the beam at them
    real(dp) :: push(size(bodies), 2)
    integer :: b
    push = 0.0_dp
    do b = 1, size(bodies)
      if (.not. comes(b) .or. is_missing(bodies(b)%velocity)) cycle
      push(b, :) = [bodies(b)%mass*(bodies(b)%velocity - moving(b, 1)), -bodies(b)%inertia*moving(b, 2)]
    end do
  end function blows

  function brought(modes, state, bodies, these, moved, moving, spin_squared, leaving) result(energy)
    !! Kinetic and potential energy of some bodies: of what they bring as they come with springs that are unstressed, or take along as they leave.
    class(mode_set), intent(in) :: modes            !! before the change
    type(beam_state), intent(in) :: state
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: these(:)
    real(dp), intent(in) :: moved(:, :), moving(:, :)
    real(dp), intent(in) :: spin_squared
    logical, intent(in), optional :: leaving        !! absent: they come
    type(energy_type) :: energy(2)
    real(dp) :: part(5)
    integer :: b
    do b = 1, size(bodies)
      if (.not. these(b)) cycle
      associate (body => bodies(b), stretch => moved(b, :) - bodies(b)%unstressed)
        part = 0.0_dp
        part(1:2) = 0.5_dp*[body%mass, body%inertia]*moving(b, :)**2
        if (present(leaving)) then
          part(3) = 0.5_dp*(body%stiffness*stretch(1)**2 + body%turning_stiffness*stretch(2)**2)
        else if (.not. is_missing(body%velocity)) then
          part(1:2) = [0.5_dp*body%mass*body%velocity**2, 0.0_dp]
        end if
        part(4) = -0.5_dp*body%mass*spin_squared*moved(b, 1)**2
        if (body%pull > 0.0_dp) part(5) = body%pull*modes%energy_of_pull(body%position, state%q(:state%count))
        energy = energy + [energy_type(sum(part(:2)), projection_rounding*sum(abs(part(:2)))), &
                           energy_type(sum(part(3:)), projection_rounding*sum(abs(part(3:))))]
      end associate
    end do
  end function brought

  function energy_of(modes, state, bodies, there) result(energy)
    !! ½ΣM(q̇² + β²(q − r)²) about the equilibrium r, and what that has itself.
    class(mode_set), intent(in) :: modes
    type(beam_state), intent(in) :: state
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: there(:)
    type(energy_type) :: energy
    energy = part_of_energy(modes, state, bodies, there, .true.) + part_of_energy(modes, state, bodies, there, .false.) &
      + energy_type(state%level, 0.0_dp)
  end function energy_of

  function part_of_energy(modes, state, bodies, there, kinetic) result(energy)
    !! ½ΣMq̇², or ½ΣMβ²(q − r)².
    class(mode_set), intent(in) :: modes
    type(beam_state), intent(in) :: state
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: there(:)
    logical, intent(in) :: kinetic
    type(energy_type) :: energy
    real(dp) :: parts(state%count)
    associate (n => state%count, mass => modes%modal_mass)
      if (kinetic) then
        parts = 0.5_dp*mass(:n)*state%rate(:n)**2
      else
        parts = 0.5_dp*mass(:n)*modes%beta_squared(:n)%hi*(state%q(:n) - equilibrium_of(modes, n, bodies, there))**2
      end if
    end associate
    energy = energy_type(accurate_sum(parts), projection_rounding*sum(abs(parts)))
  end function part_of_energy

  elemental logical function is_bent(body)
    !! Its springs are unstressed elsewhere than in a straight beam.
    type(body_type), intent(in) :: body
    is_bent = any([body%stiffness, body%turning_stiffness]*body%unstressed /= 0.0_dp)
  end function is_bent

  pure function forces_of(modes, count, bodies, there) result(force)
    !! f_k of springs towards where they are unstressed, (count).
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: count
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: there(:)
    real(dp) :: force(count)
    real(dp) :: shape(modes%count, 2)
    integer :: b
    force = 0.0_dp
    do b = 1, size(bodies)
      if (.not. (there(b) .and. is_bent(bodies(b)))) cycle
      shape = modes%motion_at(bodies(b)%position)
      force = force + matmul(shape(:count, :), [bodies(b)%stiffness, bodies(b)%turning_stiffness]*bodies(b)%unstressed)
    end do
  end function forces_of

  pure function equilibrium_of(modes, count, bodies, there) result(rest)
    !! Modal displacements of the equilibrium, (count). A mode that nothing holds is not bent by springs.
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: count
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: there(:)
    real(dp) :: rest(count)
    rest = forces_of(modes, count, bodies, there)
    where (modes%beta_squared(:count)%hi /= 0.0_dp)
      rest = rest/(modes%modal_mass(:count)*modes%beta_squared(:count)%hi)
    elsewhere
      rest = 0.0_dp
    end where
  end function equilibrium_of

  subroutine strike_beam(modes, state, bodies, there, mass, velocity, restitution, speed_after, jump, event)
    !! A mass strikes the beam, which may move, and rebounds: H = (1 + e)(V − v̇)/(1/m + ΣΦ_k²/M_k) of the modes that take part.
    class(mode_set), intent(in) :: modes
    type(beam_state), intent(inout) :: state
    type(body_type), intent(in) :: bodies(:)
    logical, intent(in) :: there(:)
    real(dp), intent(in) :: mass, velocity, restitution
    real(dp), intent(out) :: speed_after            !! of the mass
    real(dp), allocatable, intent(out) :: jump(:)   !! of modal velocities, (modes)
    type(event_type), intent(inout) :: event
    type(energy_type) :: energy
    real(dp) :: momentum
    integer :: k, n
    n = state%count
    k = first_struck(modes)
    associate (struck => modes%struck(:n), modal => modes%modal_mass(:n))
      energy = energy_of(modes, state, bodies, there)
      event%energy_before = known_energy(energy + energy_type(0.5_dp*mass*velocity**2, 0.0_dp))
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
      energy = energy_of(modes, state, bodies, there)
      event%energy_after = known_energy(energy + energy_type(0.5_dp*mass*speed_after**2, 0.0_dp))
      event%hub_rate_change = mean_rate(modes, jump)
    end associate
  end subroutine strike_beam

end module bw_change_of_bodies
