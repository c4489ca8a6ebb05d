module bw_static_shape
  !! How a beam gives to a force at one place, everywhere: deflection, bending moment and shear force under a force of 1 there that grows as
  !! e^(st), which is at rest for s = 0. As sums over all modes they are ΣΦ_k(ξ)Φ_k(ξ₀)/(M_k(β_k² + s²)), and likewise with Φ_k'', so that
  !! they tell what modes that are not summed add to a motion under that force: their residual flexibility.
  !!
  !! The state z = (v, ψ, M, Q) obeys v' = (ψ + sQ)/(1 + sT), ψ' = M/B, M' = −Q + Tv' − Rψ, Q' = −mλv with
  !! λ = ω² − s² in the plane of rotation, else −s², and R likewise of rotary inertia. Pieces are cut into parts over which the state changes
  !! little; Gauss's collocation carries it across each, and one system of equations joins them. Without dimensions, as the beam.
  !!
  !! A hub that is free turns by θ under the loads: what the root asks of it with the hub held, over what it asks where the hub turns by 1,
  !! D = T(0)v(0) − RQ(0) − M(0) + s²J, the stationary value of the energies. States are those in the frame that turns evenly, shapes those
  !! from the hub's line.
  use bw_double_double, only: dd
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_lapack, only: dgbsvx, dgesv
  use bw_mode_set, only: deflections, mode_set, turns, values_at
  use bw_piece_beam, only: arm_of, is_held, joint_position
  use bw_varying_beam, only: pull_at, value_of, varying_beam
  implicit none (type, external)
  private
  public :: find_residual, gauss_places, static_shape, static_shapes

  integer, parameter, public :: deflection = 1, moment = 2, shear = 3, hub_turn = 4, turning = 5   !! columns of a shape
  integer, parameter, public :: columns = 5
  integer, parameter :: stages = 8                !! of Gauss's collocation, which is exact to the order of twice as many
  real(dp), parameter :: calm = 0.7_dp            !! how much the state may change over a part
  integer, parameter :: band = 7                  !! diagonals beside the main one

  type :: beam_part
    integer :: piece = 1
    real(dp) :: from = 0.0_dp, to = 1.0_dp        !! places over the piece
    logical :: ends_piece = .false.               !! the joint at its end is passed after it
    real(dp) :: across(4, 4) = 0.0_dp             !! the state at its end by that at its start
  end type beam_part

contains

  subroutine find_residual(given, struck, modes, summed, xi, residual)
    !! What modes that are not summed add to deflection, curvature and the turn of a hub under a force of 1, at once: all modes less those
    !! that are.
    !! Modes that grow, or that nothing holds, are taken out of both: shifted by s² and by 2s², from which s² = 0 follows.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: struck                 !! the joint at which the force acts
    class(mode_set), intent(in) :: modes          !! of this beam, struck there
    integer, intent(in) :: summed                 !! how many of them are
    real(dp), intent(in) :: xi(:)                 !! 0 ≤ ξ ≤ 1, (points)
    real(dp), intent(out) :: residual(:, :)       !! as deflections, curvatures and turns of bw_mode_set, (points, 3)
    real(dp) :: shift
    integer :: i
    shift = 2.0_dp*given%beam%spin_squared%hi + 1.0_dp
    residual = 0.0_dp
    do i = 1, 2
      associate (whole => static_shape(given, struck, i*shift, xi))
        residual = residual + (5 - 3*i)*(whole(:, [deflection, moment, hub_turn]) - sums_of(modes, summed, i*shift, xi))
      end associate
    end do
  end subroutine find_residual

  pure function sums_of(modes, summed, shift, xi) result(sums)
    !! ΣΦ_kΦ_k(ξ₀)/(M_k(β_k² + s²)), and the same with Φ_k'' and with the turn of a hub, (points, 3).
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: summed
    real(dp), intent(in) :: shift, xi(:)
    real(dp) :: sums(size(xi), 3), part(summed)
    integer :: q
    part = modes%struck(:summed)/(modes%modal_mass(:summed)*(modes%beta_squared(:summed)%hi + shift))
    do q = deflections, turns
      sums(:, q) = matmul(part, values_at(modes, q, 1, summed, xi))
    end do
  end function sums_of

  function static_shape(given, struck, shift, xi) result(shape)
    !! Deflection, moment and shear force at points under a force of 1, of the inner side where something jumps, the turn of the hub, and
    !! the turning of sections in the frame, (points, 5).
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: struck                 !! the joint at which the force acts
    real(dp), intent(in) :: shift                 !! s² ≥ 0, with which no mode is at rest
    real(dp), intent(in) :: xi(:)                 !! 0 ≤ ξ ≤ 1, (points)
    real(dp) :: shape(size(xi), columns), shapes(size(xi), columns, 1)
    type(dd) :: place
    place = joint_position(given%beam, struck)
    shapes = static_shapes(given, [place%hi], [.false.], .false., shift, xi)
    shape = shapes(:, :, 1)
  end function static_shape

  function static_shapes(given, place, turned, accelerated, shift, xi, from_line) result(shape)
    !! The same under a force or a moment of 1 at each of some places, and under an acceleration of the frame by −1 where that is asked
    !! for, which loads the beam with its mass. Seen from where the frame would be without it the frame is displaced by c = 1/λ evenly,
    !! and nothing but what holds the beam to it feels that: the deflection is that of displaced ends and springs, less c.
    !! (points, 5, places)
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: place(:)              !! ξ of forces and moments
    logical, intent(in) :: turned(:)              !! a moment acts there
    logical, intent(in) :: accelerated            !! the last column is that of the acceleration, of a hub whose motion is prescribed
    real(dp), intent(in) :: shift                 !! s² ≥ 0, with which no mode is at rest; λ is not 0 where accelerated
    real(dp), intent(in) :: xi(:)                 !! 0 ≤ ξ ≤ 1, (points)
    logical, intent(in), optional :: from_line(:) !! the force stands on the line of a hub that is free, (places)
    real(dp) :: shape(size(xi), columns, size(place) + merge(1, 0, accelerated))
    type(beam_part), allocatable :: parts(:)
    integer :: end_of(size(xi) + size(place))     ! the part that ends at each point; 0: the root
    real(dp), allocatable :: matrix(:, :), right(:, :)
    real(dp) :: lambda, lever(size(shape, 3)), turn(size(shape, 3))   ! moments of the loads about the axis that are taken by the hub itself
    integer :: f, i, n, p
    call cut_parts(given, shift, [xi, place], parts, end_of)
    n = 8*size(parts)                             ! the states at the start and at the end of each part
    allocate (matrix(2*band + 1, n), right(n, size(shape, 3) + merge(1, 0, given%beam%root%on_hub)))
    lambda = inertia_of(given, shift)
    call join_parts(given, shift, parts, matrix)
    right = 0.0_dp
    do f = 1, size(place)
      associate (e => end_of(size(xi) + f), root => given%beam%root)
        right(row_of_force(size(parts), e) - merge(1, 0, turned(f)), f) = merge(1.0_dp, -1.0_dp, e == size(parts))
        if (e == 0 .and. merge(root%holds_turning, root%holds_deflection, turned(f))) right(:, f) = 0.0_dp
      end associate
    end do
    if (accelerated) call displace_ends(given, parts, 1.0_dp/lambda, right(:, size(shape, 3)))
    if (given%beam%root%on_hub) call turn_root(given, right(:, size(right, 2)))
    call solve(matrix, right)
    lever = 0.0_dp
    do f = 1, size(place)
      if (end_of(size(xi) + f) == 0) lever(f) = merge(1.0_dp, given%beam%root%hub_radius%hi, turned(f))
      if (present(from_line)) lever(f) = lever(f) - merge(arm_of(given%beam, place(f)), 0.0_dp, from_line(f))
    end do
    turn = 0.0_dp
    if (given%beam%root%on_hub) call let_hub_turn(given, shift, lever, right, turn)
    do p = 1, size(xi)
      i = max(0, 8*end_of(p) - 4)
      shape(p, [deflection, moment, shear, turning], :) = right(i + [1, 3, 4, 2], :size(turn))
      shape(p, deflection, :) = shape(p, deflection, :) - arm_of(given%beam, xi(p))*turn
      shape(p, shear, :) = shape(p, shear, :) - pull_inside(given, parts, end_of(p))*turn
      shape(p, hub_turn, :) = turn
    end do
    if (accelerated) shape(:, deflection, size(shape, 3)) = shape(:, deflection, size(shape, 3)) - 1.0_dp/lambda
    do p = 1, size(xi)
      if (is_held(given%beam, xi(p))) shape(p, deflection, :) = 0.0_dp
    end do
  end function static_shapes

  pure subroutine turn_root(given, right)
    !! A hub turned by 1, and with it what it holds the root by.
    type(varying_beam), intent(in) :: given
    real(dp), intent(inout) :: right(:)
    associate (root => given%beam%root)
      right(1) = merge(1.0_dp, -root%turning_stiffness%hi, root%holds_turning)
      right(2) = merge(root%hub_radius%hi, pull_at(given, 1, 0.0_dp) - root%stiffness%hi*root%hub_radius%hi, root%holds_deflection)
    end associate
  end subroutine turn_root

  pure subroutine let_hub_turn(given, shift, lever, right, turn)
    !! From states with the hub held, and one where it turns by 1, to those of a hub that is free.
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: shift, lever(:)        !! what the loads turn the hub by beside the root's reactions, (loads)
    real(dp), intent(inout) :: right(:, :)         !! the states, and behind them those of the turn
    real(dp), intent(out) :: turn(:)               !! (loads)
    real(dp) :: asked(size(right, 2))              ! of the hub
    integer :: last
    last = size(right, 2)
    associate (root => given%beam%root)
      asked = pull_at(given, 1, 0.0_dp)*right(1, :) - root%hub_radius%hi*right(4, :) - right(3, :)
      turn = (lever - asked(:last - 1))/(asked(last) + shift*root%hub_inertia%hi)
    end associate
    right(:, :last - 1) = right(:, :last - 1) + spread(right(:, last), 2, last - 1)*spread(turn, 1, size(right, 1))
  end subroutine let_hub_turn

  pure real(dp) function pull_inside(given, parts, end) result(pull)
    !! The tension at the end of a part, of the inner side where it jumps.
    type(varying_beam), intent(in) :: given
    type(beam_part), intent(in) :: parts(:)
    integer, intent(in) :: end                    !! 0: the root
    if (end == 0) then
      pull = pull_at(given, 1, 0.0_dp)
    else
      pull = pull_at(given, parts(end)%piece, parts(end)%to)
    end if
  end function pull_inside

  pure subroutine solve(matrix, right)
    !! Solve the equations of all states, whose unknowns and rows are of very different sizes where s is large.
    real(dp), intent(inout) :: matrix(:, :), right(:, :)    !! then the states
    real(dp), allocatable :: factors(:, :), states(:, :)
    real(dp), dimension(size(right, 1)) :: by_row, by_column
    real(dp) :: work(3*size(right, 1)), forward(size(right, 2)), backward(size(right, 2)), condition
    integer :: info, pivot(size(right, 1)), more(size(right, 1))
    character :: scaled
    associate (n => size(right, 1), m => size(right, 2))
      allocate (factors(3*band + 1, n), states(n, m))
      call dgbsvx('E', 'N', n, band, band, m, matrix, 2*band + 1, factors, 3*band + 1, pivot, scaled, by_row, by_column, right, n, &
                  states, n, condition, forward, backward, work, more, info)
      right(:, :) = states
      if (info > 0 .and. info <= n) right = 0.0_dp   ! no beam that is held by its inertia has such equations
    end associate
  end subroutine solve

  pure real(dp) function inertia_of(given, shift) result(lambda)
    !! λ.
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: shift
    lambda = -shift
    if (given%beam%in_plane) lambda = lambda + given%beam%spin_squared%hi
  end function inertia_of

  pure integer function row_of_force(parts, end) result(row)
    !! The equation in which a force stands that acts at the end of a part.
    integer, intent(in) :: parts, end             !! how many; which, 0: the root
    row = 2
    if (end > 0) row = 8*end + 2
    if (end == parts) row = 8*end
  end function row_of_force

  pure subroutine displace_ends(given, parts, by, right)
    !! What holds the beam, displaced.
    type(varying_beam), intent(in) :: given
    type(beam_part), intent(in) :: parts(:)
    real(dp), intent(in) :: by
    real(dp), intent(inout) :: right(:)
    real(dp) :: spring
    integer :: e, row
    right(2) = -given%beam%root%stiffness%hi*by
    if (given%beam%root%holds_deflection) right(2) = by
    do e = 1, size(parts)
      if (.not. parts(e)%ends_piece) cycle
      spring = given%beam%joint(parts(e)%piece)%stiffness%hi
      row = row_of_force(size(parts), e)
      right(row) = right(row) + merge(1.0_dp, -1.0_dp, e == size(parts))*spring*by
    end do
  end subroutine displace_ends

  pure subroutine cut_parts(given, shift, xi, parts, end_of)
    !! Parts that end where pieces do, and at all points.
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: shift, xi(:)
    type(beam_part), allocatable, intent(out) :: parts(:)
    integer, intent(out) :: end_of(:)             !! (points)
    real(dp), parameter :: same_place = 1.0e-13_dp
    real(dp), allocatable :: places(:)
    type(dd) :: start
    real(dp) :: length, x
    integer :: i, j, p
    allocate (parts(0), places(0))
    end_of = 0
    do i = 1, size(given%beam%piece)
      start = joint_position(given%beam, i - 1)
      length = given%beam%piece(i)%length%hi
      associate (many => parts_of(given, i, shift))
        places = [(real(j, dp)/many, j=1, many)]
      end associate
      do p = 1, size(xi)
        x = ((xi(p) - start%hi) - start%lo)/length
        if (x <= same_place .or. x >= 1.0_dp - same_place) cycle
        j = count(places < x - same_place)
        if (abs(places(j + 1) - x) > same_place) places = [places(:j), x, places(j + 1:)]
      end do
      do j = 1, size(places)
        x = 0.0_dp
        if (j > 1) x = places(j - 1)
        parts = [parts, beam_part(i, x, places(j), j == size(places))]
        parts(size(parts))%across = carried(given, shift, parts(size(parts)))
        where (abs(xi - start%hi - start%lo - places(j)*length) <= 2*same_place) end_of = size(parts)
      end do
    end do
  end subroutine cut_parts

  pure integer function parts_of(given, i, shift) result(parts)
    !! Into how many parts a piece is cut.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: i                      !! the piece
    real(dp), intent(in) :: shift
    integer, parameter :: most = 4000
    real(dp) :: change, law, mass, pull, softest
    associate (piece => given%beam%piece(i), laws => given%law(i))
      law = shift + given%beam%spin_squared%hi
      softest = piece%stiffness%hi*max(minval(value_of(laws%stiffness, [0.0_dp, 0.5_dp, 1.0_dp])), 1.0e-6_dp)
      mass = piece%mass%hi*maxval(abs(value_of(laws%mass, [0.0_dp, 0.5_dp, 1.0_dp])))
      pull = 0.0_dp
      if (given%is_pulled) pull = given%beam%spin_squared%hi*maxval(abs(value_of(given%tension(i), [0.0_dp, 0.5_dp, 1.0_dp])))
      change = piece%length%hi*max(sqrt(sqrt(mass*law/softest)), sqrt((pull + piece%rotary%hi*law)/softest), &
                                   1.0e-30_dp)
      if (any([size(laws%stiffness), size(laws%mass), size(laws%shear), size(laws%rotary)] > 1)) change = max(change, 4.0_dp)
    end associate
    parts = min(most, 1 + int(change/calm))
  end function parts_of

  pure function carried(given, shift, part) result(across)
    !! The state at the end of a part by that at its start.
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: shift
    type(beam_part), intent(in) :: part
    real(dp) :: across(4, 4)
    real(dp) :: place(stages), weight(stages), a(stages, stages), system(4*stages, 4*stages), slopes(4*stages, 4)
    real(dp) :: law(4, 4, stages), length
    integer :: i, info, j, pivot(4*stages)
    call gauss_rule(place, weight, a)
    length = (part%to - part%from)*given%beam%piece(part%piece)%length%hi
    law = state_law(given, part%piece, shift, part%from + (part%to - part%from)*place)
    system = 0.0_dp
    do i = 1, stages
      do j = 1, stages
        system(4*i - 3:4*i, 4*j - 3:4*j) = -length*a(i, j)*law(:, :, i)
      end do
      slopes(4*i - 3:4*i, :) = law(:, :, i)
    end do
    do i = 1, 4*stages
      system(i, i) = system(i, i) + 1.0_dp
    end do
    call dgesv(4*stages, 4, system, 4*stages, pivot, slopes, 4*stages, info)
    across = 0.0_dp
    do i = 1, 4
      across(i, i) = 1.0_dp
    end do
    do i = 1, stages
      across = across + length*weight(i)*slopes(4*i - 3:4*i, :)
    end do
  end function carried

  pure function state_law(given, i, shift, x) result(law)
    !! z' = law z at places over a piece, (4, 4, places).
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: i                      !! the piece
    real(dp), intent(in) :: shift, x(:)
    real(dp) :: law(4, 4, size(x))
    real(dp), dimension(size(x)) :: stiffness, mass, compliance, rotary, pull
    real(dp) :: lambda, rho
    integer :: j
    lambda = -shift
    rho = -shift
    if (given%beam%in_plane) then
      lambda = lambda + given%beam%spin_squared%hi
    else
      rho = rho + given%beam%spin_squared%hi
    end if
    associate (piece => given%beam%piece(i), laws => given%law(i))
      stiffness = piece%stiffness%hi*value_of(laws%stiffness, x)
      mass = piece%mass%hi*value_of(laws%mass, x)
      compliance = piece%compliance%hi/value_of(laws%shear, x)
      rotary = piece%rotary%hi*value_of(laws%rotary, x)
    end associate
    pull = 0.0_dp
    if (given%is_pulled) pull = given%beam%spin_squared%hi*value_of(given%tension(i), x)
    law = 0.0_dp
    do j = 1, size(x)
      law(1, 2, j) = 1.0_dp/(1.0_dp + compliance(j)*pull(j))
      law(1, 4, j) = compliance(j)*law(1, 2, j)
      law(2, 3, j) = 1.0_dp/stiffness(j)
      law(3, 2, j) = pull(j)*law(1, 2, j) - rotary(j)*rho
      law(3, 4, j) = pull(j)*law(1, 4, j) - 1.0_dp
      law(4, 1, j) = -mass(j)*lambda
    end do
  end function state_law

  subroutine join_parts(given, shift, parts, matrix)
    !! The equations of all states: what the root holds, each part, what joints do, and the free tip.
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: shift
    type(beam_part), intent(in) :: parts(:)
    real(dp), intent(out) :: matrix(:, :)
    real(dp) :: lambda, spring, turning
    integer :: e, i, row
    matrix = 0.0_dp
    lambda = inertia_of(given, shift)
    associate (root => given%beam%root)
      if (root%holds_turning) then
        call put(1, 2, 1.0_dp)
      else
        call put(1, 2, -root%turning_stiffness%hi)
        call put(1, 3, 1.0_dp)
      end if
      if (root%holds_deflection) then
        call put(2, 1, 1.0_dp)
      else
        call put(2, 1, -root%stiffness%hi)
        call put(2, 4, 1.0_dp)
      end if
    end associate
    row = 2
    do e = 1, size(parts)
      do i = 1, 4                                 ! from the start to the end of the part
        call put_row(row + i, 8*e - 8, -parts(e)%across(i, :))
        call put(row + i, 8*e - 4 + i, 1.0_dp)
      end do
      row = row + 4
      spring = 0.0_dp
      turning = 0.0_dp
      if (parts(e)%ends_piece) then
        associate (joint => given%beam%joint(parts(e)%piece))
          turning = joint%turning_stiffness%hi + joint%inertia%hi*shift
          spring = joint%stiffness%hi - joint%mass%hi*lambda
        end associate
      end if
      if (e == size(parts)) then                  ! nothing beyond
        call put(row + 1, 8*e - 4 + 3, 1.0_dp)
        call put(row + 1, 8*e - 4 + 2, turning)
        call put(row + 2, 8*e - 4 + 4, 1.0_dp)
        call put(row + 2, 8*e - 4 + 1, spring)
      else
        do i = 1, 4
          call put(row + i, 8*e + i, 1.0_dp)
          call put(row + i, 8*e - 4 + i, -1.0_dp)
        end do
        call put(row + 3, 8*e - 4 + 2, -turning)
        call put(row + 4, 8*e - 4 + 1, -spring)
      end if
      row = row + 4
    end do
  contains
    subroutine put(row, column, value)
      integer, intent(in) :: row, column
      real(dp), intent(in) :: value
      matrix(band + 1 + row - column, column) = value
    end subroutine put
    subroutine put_row(row, before, values)
      integer, intent(in) :: row, before          !! columns before the first
      real(dp), intent(in) :: values(4)
      integer :: k
      do k = 1, 4
        call put(row, before + k, values(k))
      end do
    end subroutine put_row
  end subroutine join_parts

  pure subroutine gauss_places(place, weight)
    !! Gauss's points from 0 to 1 and their weights.
    real(dp), allocatable, intent(out) :: place(:), weight(:)
    real(dp) :: a(stages, stages)
    allocate (place(stages), weight(stages))
    call gauss_rule(place, weight, a)
  end subroutine gauss_places

  pure subroutine gauss_rule(place, weight, a)
    !! Gauss's points from 0 to 1, their weights, and the integrals of Lagrange's polynomials up to each of them.
    real(dp), intent(out) :: place(stages), weight(stages), a(stages, stages)
    real(dp) :: p(0:stages), slope, x
    real(dp) :: powers(stages, stages), integrals(stages, stages)
    integer :: i, info, iteration, j, pivot(stages)
    do i = 1, stages
      x = -cos(pi*(i - 0.25_dp)/(stages + 0.5_dp))
      do iteration = 1, 8
        p(0) = 1.0_dp
        p(1) = x
        do j = 2, stages
          p(j) = ((2*j - 1)*x*p(j - 1) - (j - 1)*p(j - 2))/j
        end do
        slope = stages*(x*p(stages) - p(stages - 1))/(x**2 - 1.0_dp)
        x = x - p(stages)/slope
      end do
      place(i) = 0.5_dp*(1.0_dp + x)
      weight(i) = 1.0_dp/((1.0_dp - x**2)*slope**2)
      ! ∫_{-1}^{x} P_j = (P_{j+1} - P_{j-1})/(2j + 1)
      integrals(1, i) = 0.5_dp*(x + 1.0_dp)
      do j = 1, stages - 1
        integrals(j + 1, i) = 0.5_dp*(p(j + 1) - p(j - 1))/(2*j + 1)
      end do
      powers(:, i) = p(:stages - 1)
    end do
    ! a(i, :) solves Σ_k a(i, k) P_j(x_k) = ∫ P_j for all j
    call dgesv(stages, stages, powers, stages, pivot, integrals, stages, info)
    a = transpose(integrals)
  end subroutine gauss_rule

end module bw_static_shape
