module bw_load_modes
  !! Modal quantities for loads: modal loads, shear forces and participation of the modes, and the residual flexibility
  !! of omitted modes.
  !!
  !! Shear force and participation in base motion are integrals of mass times shape beyond a place, by Gauss quadrature
  !! over half waves of the highest mode: the section carries the inertia beyond it, less the forces of springs there.
  !! Without dimensions, as modes.
  use bw_constants, only: pi
  use bw_beam_parts, only: gauss_places
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_mode_set, only: curvatures, deflections, mode_set, values_at
  use bw_monitor, only: monitor_type
  use bw_piece_beam, only: arm_of, holds_tip, joint_position
  use bw_static_shape, only: deflection, hub_turn, static_shapes
  use bw_varying_beam, only: pull_at, value_of, varying_beam
  implicit none (type, external)
  private
  public :: effective_mass, find_residuals, find_shears, total_mass


contains

  subroutine find_shears(given, modes, xi, shear, participation, monitor)
    !! Find the shear force of each mode at points, on the inner side of a body, normal to the line of a free hub, and positive
    !! where the outer part pulls in the direction of positive displacement; and the participation ∫ρAΦ dx + Σm_bΦ(ξ_b).
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: xi(:)                  !! (points)
    real(dp), intent(out) :: shear(:, :)           !! (modes, points)
    real(dp), intent(out) :: participation(:)      !! (modes)
    class(monitor_type), intent(inout) :: monitor  !! results are invalid if it requests a stop
    real(dp) :: inertia(modes%count), reaction(modes%count), beyond(modes%count), ends(0:size(given%beam%piece))
    real(dp) :: edges(size(xi) + 2)
    type(dd) :: place
    logical :: held(2), known
    integer :: e, i, many, n, p
    n = size(given%beam%piece)
    do i = 0, n
      place = joint_position(given%beam, i)
      ends(i) = place%hi
    end do
    ends(n) = 1.0_dp
    inertia = modes%beta_squared%hi
    if (given%beam%in_plane) inertia = inertia + given%beam%spin_squared%hi
    held = holds_tip(given%beam)
    reaction = 0.0_dp                              ! of all springs beyond
    if (held(1)) then
      call modes%find_tip_shears(reaction, known)
      if (.not. known) reaction = tip_shears(given, modes, inertia)
      reaction = -reaction
    end if
    beyond = 0.0_dp                                ! mass times shape beyond
    do i = n, 1, -1
      if (i < n .or. .not. held(1)) then
        associate (joint => given%beam%joint(i), there => motion_in_frame(given, modes, [ends(i)]))
          beyond = beyond + joint%mass%hi*there(:, 1)
          reaction = reaction + joint%stiffness%hi*there(:, 1)
        end associate
      end if
      call find_edges(ends(i - 1), ends(i), xi, edges, many)
      do e = many, 1, -1
        do p = 1, size(xi)
          if (xi(p) == edges(e)) shear(:, p) = inertia*beyond - reaction &
            - modes%hub_turns()*pull_at(given, i, (edges(e) - ends(i - 1))/(ends(i) - ends(i - 1)))
        end do
        if (e > 1) beyond = beyond + mass_times_shape(given, modes, i, ends(i - 1:i), edges(e - 1:e), monitor)
      end do
    end do
    participation = beyond
  end subroutine find_shears

  pure subroutine find_edges(first, last, xi, edges, count)
    !! Return the ends of a piece and the points inside it, ascending.
    real(dp), intent(in) :: first, last, xi(:)
    real(dp), intent(out) :: edges(:)              !! (points + 2)
    integer, intent(out) :: count
    edges = first
    count = 1
    do while (edges(count) < last)
      edges(count + 1) = min(last, minval(xi, mask=xi > edges(count)))
      count = count + 1
    end do
  end subroutine find_edges

  function mass_times_shape(given, modes, i, ends, part, monitor) result(integral)
    !! Return the integral of mass times shape over part of a piece, (modes).
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: i                       !! the piece
    real(dp), intent(in) :: ends(2), part(2)       !! of the piece and of the part
    class(monitor_type), intent(inout) :: monitor
    real(dp) :: integral(modes%count)
    integer, parameter :: at_once = 32             ! half waves with shapes in memory
    real(dp), allocatable :: place(:), rule(:), rule_weight(:)
    real(dp) :: width
    integer :: halves, j, first, last
    call gauss_places(rule, rule_weight)
    halves = 1 + int((part(2) - part(1))*wave_number(given, modes, i)/pi)
    width = (part(2) - part(1))/halves
    integral = 0.0_dp
    do first = 0, halves - 1, at_once
      if (monitor%stop_requested()) return
      last = min(first + at_once, halves) - 1
      place = [(part(1) + width*(j + rule), j=first, last)]
      associate (mass => given%beam%piece(i)%mass%hi*value_of(given%law(i)%mass, (place - ends(1))/(ends(2) - ends(1))))
        integral = integral + matmul(motion_in_frame(given, modes, place), mass*[(width*rule_weight, j=first, last)])
      end associate
    end do
  end function mass_times_shape

  pure function motion_in_frame(given, modes, place) result(motion)
    !! Return the deflection of each mode in the uniformly rotating frame.
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: place(:)               !! ξ
    real(dp) :: motion(modes%count, size(place)), turned(modes%count)
    integer :: p
    motion = modes%some_shapes(1, modes%count, place)
    if (.not. given%beam%root%on_hub) return
    turned = modes%hub_turns()
    do p = 1, size(place)
      motion(:, p) = motion(:, p) + arm_of(given%beam, place(p))*turned
    end do
  end function motion_in_frame

  pure real(dp) function wave_number(given, modes, i) result(largest)
    !! Bound the wave number of the highest mode in a piece.
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: i
    real(dp), parameter :: places(3) = [0.0_dp, 0.5_dp, 1.0_dp]
    real(dp) :: law, softest, heaviest
    associate (piece => given%beam%piece(i), laws => given%law(i))
      law = maxval(abs(modes%beta_squared%hi)) + given%beam%spin_squared%hi
      softest = piece%stiffness%hi*max(minval(value_of(laws%stiffness, places)), 1.0e-6_dp)
      heaviest = piece%mass%hi*maxval(value_of(laws%mass, places))
      largest = sqrt(sqrt(heaviest*law/softest) + piece%rotary%hi*law/softest &
                     + heaviest*law*piece%compliance%hi/max(minval(value_of(laws%shear, places)), 1.0e-6_dp))
    end associate
  end function wave_number

  pure function tip_shears(given, modes, inertia) result(shear)
    !! Return the shear force at a rigidly held tip from moment and deflection near it, differentiated through Chebyshev
    !! points over a quarter wave, by M' = Tv' − Q − Rψ and v' = (ψ + sQ)/(1 + sT).
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: inertia(:)             !! λ, (modes)
    real(dp) :: shear(modes%count)
    integer, parameter :: degree = 12
    real(dp), dimension(0:degree) :: node, slope, place
    real(dp) :: rotary, compliance, pull, rho, width, wave, one(1)
    integer :: j, k, n
    n = size(given%beam%piece)
    associate (piece => given%beam%piece(n), laws => given%law(n))
      one = value_of(laws%rotary, [1.0_dp])
      rotary = piece%rotary%hi*one(1)
      one = value_of(laws%shear, [1.0_dp])
      compliance = piece%compliance%hi/one(1)
      pull = 0.0_dp
      if (given%is_pulled) then
        one = value_of(given%tension(n), [1.0_dp])
        pull = given%beam%spin_squared%hi*one(1)
      end if
      node = [(cos(pi*j/degree), j=0, degree)]     ! from 1 down to −1
      slope = end_slopes(node)
      do k = 1, modes%count
        wave = sqrt(sqrt(piece%mass%hi*abs(inertia(k))/piece%stiffness%hi) + 1.0_dp)
        width = min(piece%length%hi, 0.5_dp*pi/wave)
        place = 1.0_dp - 0.5_dp*width*(1.0_dp - node)
        rho = modes%beta_squared(k)%hi
        if (.not. given%beam%in_plane) rho = rho + given%beam%spin_squared%hi
        rho = rotary*rho
        associate (moments => given%beam%piece(1)%stiffness%hi*values_at(modes, curvatures, k, k, place), &
                   shapes => values_at(modes, deflections, k, k, place))
          shear(k) = sum(slope*(-moments(1, :) + (pull - rho*(1.0_dp + compliance*pull))*shapes(1, :)))*2.0_dp/width &
            /(1.0_dp - compliance*rho)
        end associate
      end do
    end associate
  end function tip_shears

  pure function end_slopes(node) result(slope)
    !! Return the derivative at 1 of a polynomial by its values at Chebyshev points.
    real(dp), intent(in) :: node(0:)
    real(dp) :: slope(0:size(node) - 1)
    integer :: j, n
    n = size(node) - 1
    do j = 1, n
      slope(j) = (-1)**j*merge(1.0_dp, 2.0_dp, j == n)/(1.0_dp - node(j))
    end do
    slope(0) = -sum(slope(1:))
  end function end_slopes

  subroutine find_residuals(given, modes, summed, place, accelerated, drive, weights, xi, residual, terms, flexibility, from_line)
    !! Find the residuals of omitted modes under loads of 1, static solution less summed modes; and their flexibility
    !! ΣΦ²/(Mβ²) at each point and at the place of each force.
    !!
    !! Unstable and rigid modes make the static solution singular. So β² is raised by s², 2s², 3s² and 4s², and the
    !! results are extrapolated to 0, with an error of 24(s/β)⁸ of the contribution of each omitted mode. Larger s means
    !! less cancellation: it is chosen such that this error equals rounding.
    type(varying_beam), intent(in) :: given
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: summed                  !! of these modes
    real(dp), intent(in) :: place(:)               !! ξ of forces
    logical, intent(in) :: accelerated             !! the last load is an acceleration of the frame by −1
    real(dp), intent(in) :: drive(:, :)            !! Φ_k at these places, and the participation, (modes, loads)
    real(dp), intent(in) :: weights(:, :, :)
      !! deflection, curvature, shear force, hub rotation and rotation of sections of modes at points, or the first of
      !! these, (modes, points, quantities)
    real(dp), intent(in) :: xi(:)                  !! (points)
    real(dp), intent(out) :: residual(:, :, :)     !! (loads, points, quantities)
    real(dp), intent(out) :: terms(:, :, :)        !! magnitude of the terms that cancel, (loads, points, quantities)
    real(dp), intent(out) :: flexibility(:)        !! at the points and at the places of forces, (points + places)
    logical, intent(in), optional :: from_line(:)  !! the force acts relative to the line of a free hub; absent: in the frame
    integer, parameter :: signs(4) = [4, -6, 4, -1]
    real(dp), parameter :: far_below = sqrt(sqrt(epsilon(1.0_dp)/24.0_dp))   ! (s/β)²
    real(dp) :: gives, shift, soft(summed), own(summed, size(xi) + size(place)), arms(size(xi) + size(place))
    real(dp), allocatable :: whole(:, :, :), of_modes(:)
    logical :: on_line(size(place))
    integer :: f, i, l, p, q
    on_line = .false.
    if (present(from_line)) on_line = from_line
    shift = 0.25_dp
    if (given%beam%in_plane) shift = 2.0_dp*given%beam%spin_squared%hi + 0.25_dp
    shift = max(shift, far_below*modes%beta_squared(summed)%hi)
    arms = [(arm_of(given%beam, xi(p)), p=1, size(xi)), (merge(0.0_dp, arm_of(given%beam, place(p)), on_line(p)), &
                                                            p=1, size(place))]
    own(:, :size(xi)) = modes%some_shapes(1, summed, xi)
    own(:, size(xi) + 1:) = drive(:summed, :size(place))
    residual = 0.0_dp
    terms = 0.0_dp
    flexibility = 0.0_dp
    do i = 1, size(signs)
      whole = static_shapes(given, [place, xi], accelerated, i*shift, [xi, place], [on_line, spread(.true., 1, size(xi))])
      soft = 1.0_dp/(modes%modal_mass(:summed)*(modes%beta_squared(:summed)%hi + i*shift))
      do l = 1, size(drive, 2)
        f = l                                      ! its column
        if (l > size(place)) f = size(whole, 3)
        do q = 1, size(weights, 3)
          of_modes = matmul(soft*drive(:summed, l), weights(:summed, :, q))
          residual(l, :, q) = residual(l, :, q) + signs(i)*(whole(:size(xi), q, f) - of_modes)
          terms(l, :, q) = terms(l, :, q) + abs(signs(i))*(abs(whole(:size(xi), q, f)) + abs(of_modes))
          if (q == deflection) terms(l, :, q) = terms(l, :, q) + abs(signs(i))*abs(arms(:size(xi))*whole(:size(xi), hub_turn, f))
          if (l > size(place)) terms(l, :, q) = terms(l, :, q) + abs(signs(i))*2.0_dp/(i*shift)   ! displacement of the frame
        end do
      end do
      do p = 1, size(flexibility)
        f = size(place) + p
        if (p > size(xi)) f = p - size(xi)
        gives = whole(p, deflection, f)
        if (p > size(xi)) gives = gives + arms(p)*whole(p, hub_turn, f)
        flexibility(p) = flexibility(p) + signs(i)*(gives - sum(soft*own(:, p)**2))
      end do
    end do
    flexibility = max(0.0_dp, flexibility)
    do p = 1, size(xi)
      if (any(weights(:, p, 1) /= 0.0_dp)) cycle     ! else a fixed point
      residual(:, p, 1) = 0.0_dp
      terms(:, p, 1) = 0.0_dp
    end do
  end subroutine find_residuals

  pure real(dp) function total_mass(given) result(mass)
    !! Return the mass of beam and bodies.
    type(varying_beam), intent(in) :: given
    real(dp), allocatable :: place(:), weight(:)
    integer :: i
    call gauss_places(place, weight)
    mass = sum(given%beam%joint%mass%hi)
    do i = 1, size(given%beam%piece)
      associate (piece => given%beam%piece(i))
        mass = mass + piece%length%hi*piece%mass%hi*sum(weight*value_of(given%law(i)%mass, place))
      end associate
    end do
  end function total_mass

  pure real(dp) function effective_mass(modes, participation) result(mass)
    !! Return the effective mass of the modes in base motion, Σp²/M.
    class(mode_set), intent(in) :: modes
    real(dp), intent(in) :: participation(:)       !! of the first modes
    mass = sum(participation**2/modes%modal_mass(:size(participation)))
  end function effective_mass

end module bw_load_modes
