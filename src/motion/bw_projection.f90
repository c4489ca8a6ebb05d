module bw_projection
  !! The projection of a motion onto the modes of another configuration, as a body leaves. Displacement and velocity of
  !! the beam are continuous, so the new state is their projection weighted by the mass of the beam alone. A mode k of
  !! beam and body and a mode i of the beam alone overlap by −(m Λ_kΦ_kφ_i + J β_k²Ψ_kψ_i)/(β_k² − β_i²), all at the
  !! body, with Λ = β² (+ ω² in plane), by Green's identity.
  !!
  !! Modes k far above i act on the beam alone as an impulse, −m φ_i times the motion of the body in them, so a million
  !! of them cost little. The same bounds the contribution of modes beyond the last, N: with their energy E_N and their
  !! mobility at the body, μ_N = Σ_{k>N}Φ_k²/M_k, both known as differences, they move the body by at most √(2E_Nμ_N).
  !! The likely part of this follows from the last two octaves, as in bw_truncation_error. **Limit**: the tension that
  !! leaves with a body is in the overlaps, but not in that bound, where it is smaller by 1/β_N².
  !!
  !! Units of bw_segment.
  use bw_double_double, only: accurate_sum, dd, dd_pi, operator(*), operator(/)
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_modal_flow, only: damping_factor_beyond
  use bw_mode_set, only: configuration_type, first_numbers, mode_set, mode_source
  use bw_monitor, only: monitor_type, stops
  use bw_segment, only: beam_energy, energy_type, lack_type, move, move_with_energy, segment_type, state_energy
  use bw_turn, only: phase_angles
  implicit none (type, external)
  private
  public :: project

  real(dp), parameter :: nearest = 2.5_dp       !! modes with individual overlaps over modes after, and their least number:
  integer, parameter :: least_near = 1024       !! beyond them three terms of a series in (i/k)⁴ have an error of 1e-5
  real(dp), parameter, public :: projection_rounding = 1.0e-13_dp   !! relative error of integrals of two shapes
  real(dp), parameter, public :: likely = 2.0_dp   !! tuned: sums may be so many times what blocks show
  integer, parameter :: chunk = 256             !! further modes held at a time

  type, public :: place_type
    !! The motion of the body in the modes considered, and bounds for all others.
    integer :: count = 0                        !! N
    real(dp) :: displacement = 0.0_dp, velocity = 0.0_dp
    real(dp) :: energy = 0.0_dp                 !! of all modes
    real(dp) :: missing_energy = 0.0_dp         !! E_N
    real(dp) :: mobility = 0.0_dp               !! μ_N
    real(dp) :: turning_mobility = 0.0_dp       !! the same with Ψ², if the body has inertia
    real(dp) :: square = 0.0_dp                 !! β_N²
    real(dp) :: part = 1.0_dp                   !! |sum of an octave| over the sum of its amplitudes, for the last octaves
    real(dp) :: left = 1.0_dp                   !! factor by which damping reduces amplitudes of modes beyond
  end type place_type

  type :: far_modes
    !! Modes without individual overlaps.
    integer :: first = 1, last = 0              !! those known
    real(dp), allocatable :: of(:, :)           !! data of each mode, from the first, with room for more, (modes, kinds)
  end type far_modes

  ! Kinds of data of far modes: β², Φ²/M at the body, energy at the start and after damping, displacement and velocity
  ! of the body, velocity amplitude, and the factor of damping for amplitudes beyond.
  integer, parameter :: square = 1, mobility = 2, energy = 3, kept = 4, moved = 5, rate_moved = 6, reach = 7, left = 8, kinds = 8

  type, public :: projection_type
    class(mode_set), allocatable :: before      !! the first modes before
    real(dp), allocatable :: q(:), rate(:)      !! their state at the change, as summed
    real(dp), allocatable :: q_after(:), rate_after(:)   !! state of the modes after
    type(lack_type) :: lack
    type(place_type) :: place
    type(far_modes), private :: far             !! from a projection of the same motion with fewer modes
    real(dp), allocatable, private :: near_q(:), near_rate(:)   !! part of modes with individual overlaps, (modes after)
    type(place_type), private :: near_place     !! motion of the body in these modes
  end type projection_type


contains

  subroutine project(segment, configuration, time, longest, wanted, after, projection, monitor)
    !! Project a segment's motion, at a time after its start, onto the modes of the beam without the body.
    type(segment_type), intent(in) :: segment
    type(configuration_type), intent(in) :: configuration    !! of the segment
    type(dd), intent(in) :: time                 !! since its start, l²/h
    real(dp), intent(in) :: longest              !! the record, over which phases are accurate, l²/h
    integer, intent(in) :: wanted                !! least N, if the segment has no state of its own, as far as there are modes
    class(mode_set), intent(in) :: after         !! modes of the beam without the body
    type(projection_type), intent(inout) :: projection   !! new, or of the same motion with fewer modes
    class(monitor_type), intent(inout), optional :: monitor   !! the projection is invalid if it requests a stop
    real(dp), allocatable :: q(:), rate(:)       ! of the modes in the limit
    integer :: n
    associate (p => projection, source => configuration%source)
      if (.not. is_near_known(p, segment, source, after)) then
        call take_start(segment, configuration, longest, wanted, after%count, p, q, rate, monitor)
        if (stops(monitor)) return
        if (allocated(segment%lack)) then
          call take_place(p%before, q, rate, time, segment%energy, source, p%near_place)
          call move(p%before, time, p%q, p%rate)
        else
          call take_place(p%before, p%q, p%rate, time, segment%energy, source, p%near_place)
        end if
        p%near_q = after%overlap(p%before, p%q, .false., monitor)
        p%near_rate = after%overlap(p%before, p%rate, .false., monitor)
        if (allocated(segment%lack)) then
          p%lack%q = after%overlap(p%before, q - p%q, .false., monitor)/after%modal_mass
          p%lack%rate = after%overlap(p%before, rate - p%rate, .false., monitor)/after%modal_mass
        end if
      end if
      p%place = p%near_place
      p%q_after = p%near_q
      p%rate_after = p%near_rate
      n = p%place%count
      if (.not. allocated(segment%rate)) &
        call add_far(source, segment%force, time, longest, min(wanted, source%highest), p%place, p%far, monitor)
      if (stops(monitor)) return
      if (p%place%count > n) then
        associate (elastic => after%beta_squared%hi + spin(source), beta_squared => after%beta_squared%hi, &
                   blow => source%gamma*after%struck, of => p%far%of(n + 1:p%place%count, :))
          p%q_after = p%q_after - blow*(p%place%displacement - p%near_place%displacement &
            + elastic*(sum(of(:, moved)/of(:, square)) + beta_squared*sum(of(:, moved)/of(:, square)**2)))
          p%rate_after = p%rate_after - blow*(p%place%velocity - p%near_place%velocity &
            + elastic*(sum(of(:, rate_moved)/of(:, square)) + beta_squared*sum(of(:, rate_moved)/of(:, square)**2)))
        end associate
      end if
      p%q_after = p%q_after/after%modal_mass
      p%rate_after = p%rate_after/after%modal_mass
      p%place%missing_energy = max(0.0_dp, p%place%missing_energy)*p%place%left**2
      p%place%mobility = max(0.0_dp, p%place%mobility)
      if (allocated(p%before%damping)) p%place%energy = p%place%energy + p%place%missing_energy
      call bound_errors(source, after, p%place, p%lack)
    end associate
  end subroutine project

  pure logical function is_near_known(p, segment, source, after) result(known)
    !! Return whether overlaps of individual modes are known from the last projection of the same motion.
    type(projection_type), intent(in) :: p
    type(segment_type), intent(in) :: segment
    class(mode_source), intent(in) :: source
    class(mode_set), intent(in) :: after
    known = allocated(p%near_q) .and. .not. allocated(segment%rate) .and. source%pieces%captured%inertia%hi <= 0.0_dp
    if (known) known = size(p%near_q) == after%count
  end function is_near_known

  pure real(dp) function spin(source)
    !! Return ω² if it acts on translations, else 0.
    class(mode_source), intent(in) :: source
    spin = 0.0_dp
    if (source%pieces%beam%in_plane) spin = source%pieces%beam%spin_squared%hi
  end function spin

  subroutine take_start(segment, configuration, longest, wanted, modes_after, p, q, rate, monitor)
    !! Find the first modes before the change, their initial state, and that in the limit of infinitely many modes.
    type(segment_type), intent(in) :: segment
    type(configuration_type), intent(in) :: configuration
    real(dp), intent(in) :: longest
    integer, intent(in) :: wanted, modes_after
    type(projection_type), intent(inout) :: p
    real(dp), allocatable, intent(out) :: q(:), rate(:)
    class(monitor_type), intent(inout), optional :: monitor
    integer :: n
    associate (source => configuration%source)
      if (allocated(segment%rate)) then
        allocate (p%before, source=configuration%set)
        p%rate = segment%rate
        p%q = 0.0_dp*p%rate
        if (allocated(segment%q)) p%q = segment%q
      else
        n = max(int(nearest*modes_after), least_near)
        if (source%pieces%captured%inertia%hi > 0.0_dp) n = max(n, wanted)
        n = min(n, source%highest)
        call source%find(first_numbers(n), p%before, source%stretch*longest, monitor)
        if (stops(monitor)) return
        p%rate = segment%force*p%before%struck/p%before%modal_mass
        p%q = 0.0_dp*p%rate
      end if
      q = p%q
      rate = p%rate
      if (.not. allocated(segment%lack)) return
      if (allocated(segment%lack%q)) q = q + segment%lack%q
      if (allocated(segment%lack%rate)) rate = rate + segment%lack%rate
    end associate
  end subroutine take_start

  subroutine take_place(before, q, rate, time, energy, source, place)
    !! Find the motion of the body in the first modes, and the energy and mobility of all others.
    class(mode_set), intent(in) :: before
    real(dp), intent(inout) :: q(:), rate(:)     !! state in the limit, at the start and then at the change
    type(dd), intent(in) :: time
    real(dp), intent(in) :: energy               !! of all modes at the start
    class(mode_source), intent(in) :: source
    type(place_type), intent(out) :: place
    real(dp), parameter :: unit = 4.0_dp*epsilon(1.0_dp)
    type(energy_type) :: held
    real(dp) :: mass
    place%count = size(q)
    mass = source%pieces%beam%joint(source%pieces%struck)%mass%hi/source%pieces%lightness
    if (mass > 0.0_dp) place%mobility = max(0.0_dp, 1.0_dp/mass - accurate_sum(before%struck**2/before%modal_mass)) + unit/mass
    associate (inertia => source%pieces%captured%inertia%hi)
      if (inertia > 0.0_dp) place%turning_mobility = &
        max(0.0_dp, 1.0_dp/inertia - accurate_sum(before%turnings()**2/before%modal_mass)) + unit/inertia
    end associate
    place%missing_energy = max(0.0_dp, energy - beam_energy(before, q, rate)) + unit*energy
    place%square = before%beta_squared(size(q))%hi
    held = state_energy(before, q, rate)
    call move_with_energy(before, time, q, rate, held)
    place%displacement = accurate_sum(before%struck*q)
    place%velocity = accurate_sum(before%struck*rate)
    place%energy = energy
    if (allocated(before%damping)) place%energy = held%value
    place%left = left_of(before, time)
    call take_part(before%struck*rate, amplitudes(before, q, rate), place)
  end subroutine take_place

  pure function amplitudes(modes, q, rate) result(amplitude)
    !! Return the amplitudes of velocity at the body in oscillating modes, (modes).
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: q(:), rate(:)
    real(dp) :: amplitude(size(q))
    amplitude = abs(modes%struck)*sqrt(rate**2 + max(0.0_dp, modes%beta_squared%hi)*q**2)
  end function amplitudes

  pure real(dp) function left_of(before, time) result(left)
    !! Return the largest factor by which damping reduces amplitudes of modes beyond these.
    class(mode_set), intent(in) :: before
    type(dd), intent(in) :: time
    left = 1.0_dp
    if (.not. allocated(before%damping)) return
    associate (n => before%count)
      left = damping_factor_beyond(before%beta_squared(n), before%damping(n), real(before%law%stiffness, dp), time%hi)
    end associate
  end function left_of

  pure subroutine take_part(terms, reach, place)
    !! Find the ratio of sum to sum of amplitudes for the last octaves of modes.
    real(dp), intent(in) :: terms(:), reach(:)   !! Φq̇, and its amplitude
    type(place_type), intent(inout) :: place
    real(dp) :: octave(2), sums(2)
    integer :: n
    place%part = 1.0_dp
    n = size(terms)
    if (n < 4) return
    octave = abs([sum(terms(n/4 + 1:n/2)), sum(terms(n/2 + 1:))])
    sums = [sum(reach(n/4 + 1:n/2)), sum(reach(n/2 + 1:))]
    if (any(sums <= 0.0_dp)) return
    place%part = min(1.0_dp, max(octave(2)/sums(2), octave(1)/sums(1)/sqrt(2.0_dp), &
                                 sqrt(log(2.0_dp)*sum(reach(n/2 + 1:)**2))/sums(2)))
  end subroutine take_part

  subroutine add_far(source, force, time, longest, last, place, far, monitor)
    !! Add further modes up to number `last`, all in the limit and without initial displacement.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force
    type(dd), intent(in) :: time
    real(dp), intent(in) :: longest
    integer, intent(in) :: last
    type(place_type), intent(inout) :: place
    type(far_modes), intent(inout) :: far        !! those from earlier calls
    class(monitor_type), intent(inout), optional :: monitor
    integer :: first, n
    if (place%count >= last) return
    call make_room(far, place%count + 1, last)
    do first = far%last + 1, last, chunk
      if (stops(monitor)) return
      n = min(chunk, last - first + 1)
      call find_far(source, force, time, min(1.0_dp, source%stretch)*longest, first - 1 + first_numbers(n), &
                    far%of(first:first + n - 1, :))
      far%last = first + n - 1
    end do
    associate (of => far%of(place%count + 1:last, :))
      place%mobility = place%mobility - accurate_sum(of(:, mobility))
      place%missing_energy = place%missing_energy - accurate_sum(of(:, energy))
      place%energy = place%energy + sum(of(:, kept))
      place%displacement = place%displacement + accurate_sum(of(:, moved))
      place%velocity = place%velocity + accurate_sum(of(:, rate_moved))
      if (size(of, 1) >= 4) call take_part(of(:, rate_moved), of(:, reach), place)
    end associate
    place%left = far%of(last, left)
    place%square = far%of(last, square)
    place%count = last
  end subroutine add_far

  pure subroutine make_room(far, first, last)
    !! Make room for modes up to number `last`, and drop those before the first.
    type(far_modes), intent(inout) :: far
    integer, intent(in) :: first, last
    real(dp), allocatable :: of(:, :)
    integer :: known(2)
    if (.not. allocated(far%of)) far%last = first - 1
    if (far%last >= last) return
    allocate (of(first:last, kinds))
    known = [max(first, far%first), far%last]
    if (allocated(far%of)) of(known(1):known(2), :) = far%of(known(1):known(2), :)
    far%first = first
    far%last = max(far%last, first - 1)
    call move_alloc(of, far%of)
  end subroutine make_room

  subroutine find_far(source, force, time, longest, number, of)
    !! Find the data of modes with given numbers at the change.
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force, longest
    type(dd), intent(in) :: time
    integer, intent(in) :: number(:)
    real(dp), intent(out) :: of(:, :)            !! (modes, kinds)
    class(mode_set), allocatable :: modes
    real(dp), dimension(size(number)) :: angle, drive, mass, q, rate
    real(dp) :: none(size(number), 0)
    type(dd) :: beta(size(number))
    if (allocated(source%damping)) then
      call source%find(number, modes, longest)
      mass = modes%modal_mass
      drive = modes%struck/mass
      rate = force*drive
      q = 0.0_dp*rate
      of(:, square) = modes%beta_squared%hi
      of(:, energy) = 0.5_dp*mass*rate**2
      call move(modes, time, q, rate)
      of(:, kept) = 0.5_dp*mass*(rate**2 + of(:, square)*q**2)
      of(:, reach) = amplitudes(modes, q, rate)
      of(:, left) = left_of(modes, time)
    else                                         ! all oscillate
      call source%terms(number, [real(dp) ::], longest, beta, drive, none, mass)
      angle = phase_angles(beta*(time/(dd_pi*2.0_dp)), 1)
      q = force*drive*sin(angle)/beta%hi
      rate = force*drive*cos(angle)
      of(:, square) = beta%hi**2
      of(:, energy) = 0.5_dp*mass*(force*drive)**2
      of(:, kept) = 0.0_dp                       ! the energy at the start counts
      of(:, reach) = abs(mass*force)*drive**2
      of(:, left) = 1.0_dp
    end if
    of(:, mobility) = mass*drive**2
    of(:, moved) = mass*drive*q
    of(:, rate_moved) = mass*drive*rate
  end subroutine find_far

  pure subroutine bound_errors(source, after, place, lack)
    !! Bound the errors of the projected state due to modes beyond the last; unknown if none of the modes oscillates.
    class(mode_source), intent(in) :: source
    class(mode_set), intent(in) :: after
    type(place_type), intent(in) :: place
    type(lack_type), intent(inout) :: lack
    real(dp) :: blow(after%count), near(after%count), size_of(2)
    if (place%square <= 0.0_dp) then
      lack%bounded = 0
      lack%energy = missing
      return
    end if
    lack%bounded = count(after%beta_squared%hi <= 0.5_dp*place%square)
    near = (place%square + spin(source))/max(0.5_dp*place%square, place%square - after%beta_squared%hi)
    size_of = sqrt(2.0_dp*place%missing_energy*[place%mobility, place%turning_mobility])
    blow = near*(source%gamma*abs(after%struck)*size_of(1) &
                 + source%pieces%captured%inertia%hi*abs(after%turnings())*size_of(2))/after%modal_mass
    blow(lack%bounded + 1:) = 0.0_dp
    lack%rate_doubt = blow
    lack%q_doubt = blow/sqrt(place%square)
    lack%likely = min(1.0_dp, likely*place%part)
    lack%energy = place%missing_energy + 0.5_dp*source%gamma*spin(source)*size_of(1)**2/place%square
  end subroutine bound_errors

end module bw_projection
