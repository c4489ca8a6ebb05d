module bw_static_shape
  !! The response of a beam to a point force that grows as e^(st), static for s = 0: deflection, bending moment and
  !! shear force for a force of 1. As modal sums they are ΣΦ_k(ξ)Φ_k(ξ₀)/(M_k(β_k² + s²)), and likewise with Φ_k'', so
  !! they give the residual flexibility of omitted modes.
  !!
  !! One system of equations joins the states of all parts of the beam (bw_beam_parts). Without dimensions, as the beam.
  !!
  !! A free hub rotates by θ under the loads: the reaction of the root with the hub held, over that for a hub rotation
  !! of 1, D = T(0)v(0) − RQ(0) − M(0) + s²J, the stationary value of the energies. States are those in the uniformly
  !! rotating frame, shapes are relative to the hub's line.
  use bw_beam_parts, only: beam_part, cut_parts
  use bw_double_double, only: dd
  use bw_kinds, only: dp
  use bw_lapack, only: dgbsvx
  use bw_mode_set, only: deflections, mode_set, turns, values_at
  use bw_piece_beam, only: arm_of, is_held, joint_position
  use bw_varying_beam, only: pull_at, varying_beam
  implicit none (type, external)
  private
  public :: find_motion_residual, find_residual, static_shape, static_shapes

  integer, parameter, public :: deflection = 1, moment = 2, shear = 3, hub_turn = 4, turning = 5   !! columns of a shape
  integer, parameter, public :: columns = 5
  integer, parameter :: band = 7                  !! sub- and superdiagonals

contains

  subroutine find_residual(given, struck, modes, summed, xi, residual)
    !! Find the static contribution of omitted modes to deflection, curvature and hub rotation under a force of 1: the full
    !! response less the summed modes. Unstable and rigid modes are avoided by shifts s² and 2s², extrapolated to 0.
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: struck                 !! joint at which the force acts
    class(mode_set), intent(in) :: modes          !! of this beam, with the force there
    integer, intent(in) :: summed                 !! modes of these that are summed
    real(dp), intent(in) :: xi(:)                 !! 0 ≤ ξ ≤ 1, (points)
    real(dp), intent(out) :: residual(:, :)       !! deflections, curvatures and turns of bw_mode_set, (points, 3)
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

  function find_motion_residual(given, struck, modes, summed, xi) result(residual)
    !! Find the same for deflection in the frame and rotation of sections, (points, 2).
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: struck
    class(mode_set), intent(in) :: modes
    integer, intent(in) :: summed
    real(dp), intent(in) :: xi(:)
    real(dp) :: residual(size(xi), 2), whole(size(xi), columns), shape(modes%count, 2), part(summed), shift
    integer :: i, p
    residual = 0.0_dp
    do i = 1, 2
      shift = i*(2.0_dp*given%beam%spin_squared%hi + 1.0_dp)
      whole = static_shape(given, struck, shift, xi)
      part = modes%struck(:summed)/(modes%modal_mass(:summed)*(modes%beta_squared(:summed)%hi + shift))
      do p = 1, size(xi)
        shape = modes%motion_at(xi(p))
        residual(p, :) = residual(p, :) + (5 - 3*i)*([whole(p, deflection) + arm_of(given%beam, xi(p))*whole(p, hub_turn), &
                                                      whole(p, turning)] - matmul(part, shape(:summed, :)))
      end do
    end do
  end function find_motion_residual

  pure function sums_of(modes, summed, shift, xi) result(sums)
    !! Return ΣΦ_kΦ_k(ξ₀)/(M_k(β_k² + s²)), and the same with Φ_k'' and with hub rotation, (points, 3).
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
    !! Return deflection, moment and shear force at points under a force of 1, on the inner side of jumps, hub rotation,
    !! and rotation of sections in the frame, (points, 5).
    type(varying_beam), intent(in) :: given
    integer, intent(in) :: struck                 !! joint at which the force acts
    real(dp), intent(in) :: shift                 !! s² ≥ 0, such that the system is not singular
    real(dp), intent(in) :: xi(:)                 !! 0 ≤ ξ ≤ 1, (points)
    real(dp) :: shape(size(xi), columns), shapes(size(xi), columns, 1)
    type(dd) :: place
    place = joint_position(given%beam, struck)
    shapes = static_shapes(given, [place%hi], .false., shift, xi)
    shape = shapes(:, :, 1)
  end function static_shape

  function static_shapes(given, place, accelerated, shift, xi, from_line) result(shape)
    !! Return the same for a force of 1 at each of several places, and on request for an acceleration of the frame by −1, which
    !! loads the beam with its mass. Relative to the unaccelerated position the frame moves by c = 1/λ uniformly, which only the
    !! supports transmit: the deflection is that for displaced ends and springs, less c. (points, 5, places)
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: place(:)              !! ξ of forces
    logical, intent(in) :: accelerated            !! the last column is for the acceleration
    real(dp), intent(in) :: shift                 !! s² ≥ 0, such that the system is not singular; with acceleration λ ≠ 0
    real(dp), intent(in) :: xi(:)                 !! 0 ≤ ξ ≤ 1, (points)
    logical, intent(in), optional :: from_line(:) !! the force acts relative to the line of a free hub, (places)
    real(dp) :: shape(size(xi), columns, size(place) + merge(1, 0, accelerated))
    type(beam_part), allocatable :: parts(:)
    integer :: end_of(size(xi) + size(place))     ! part that ends at each point; 0: the root
    real(dp), allocatable :: matrix(:, :), right(:, :)
    real(dp) :: lambda, lever(size(shape, 3)), turn(size(shape, 3))   ! `lever`: moments of loads on the hub
    integer :: f, i, n, p
    call cut_parts(given, shift, [xi, place], parts, end_of)
    n = 8*size(parts)                             ! states at both ends of each part
    allocate (matrix(2*band + 1, n), right(n, size(shape, 3) + merge(1, 0, given%beam%root%on_hub)))
    lambda = inertia_of(given, shift)
    call join_parts(given, shift, parts, matrix)
    right = 0.0_dp
    do f = 1, size(place)
      associate (e => end_of(size(xi) + f), root => given%beam%root)
        right(row_of_force(size(parts), e), f) = merge(1.0_dp, -1.0_dp, e == size(parts))
        if (e == 0 .and. root%holds_deflection) right(:, f) = 0.0_dp
      end associate
    end do
    if (accelerated) call displace_ends(given, parts, 1.0_dp/lambda, right(:, size(shape, 3)))
    if (given%beam%root%on_hub) call turn_root(given, right(:, size(right, 2)))
    call solve(matrix, right)
    lever = 0.0_dp
    if (accelerated) lever(size(lever)) = pull_at(given, 1, 0.0_dp)/lambda   ! as the root is so much closer to the axis's line
    do f = 1, size(place)
      if (end_of(size(xi) + f) == 0) lever(f) = given%beam%root%hub_radius%hi
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
    !! Set the right side for a hub rotation of 1 with its support of the root.
    type(varying_beam), intent(in) :: given
    real(dp), intent(inout) :: right(:)
    associate (root => given%beam%root)
      right(1) = merge(1.0_dp, -root%turning_stiffness%hi, root%holds_turning)
      right(2) = merge(root%hub_radius%hi, pull_at(given, 1, 0.0_dp) - root%stiffness%hi*root%hub_radius%hi, root%holds_deflection)
    end associate
  end subroutine turn_root

  pure subroutine let_hub_turn(given, shift, lever, right, turn)
    !! Combine states for a held hub and for a hub rotation of 1 to those for a free hub.
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: shift, lever(:)        !! moments of the loads on the hub besides the root's reactions, (loads)
    real(dp), intent(inout) :: right(:, :)         !! states, last those of the rotation
    real(dp), intent(out) :: turn(:)               !! (loads)
    real(dp) :: asked(size(right, 2))              ! moment on the hub
    integer :: last
    last = size(right, 2)
    associate (root => given%beam%root)
      asked = pull_at(given, 1, 0.0_dp)*right(1, :) - root%hub_radius%hi*right(4, :) - right(3, :)
      turn = (lever - asked(:last - 1))/(asked(last) + shift*root%hub_inertia%hi)
    end associate
    right(:, :last - 1) = right(:, :last - 1) + spread(right(:, last), 2, last - 1)*spread(turn, 1, size(right, 1))
  end subroutine let_hub_turn

  pure real(dp) function pull_inside(given, parts, end) result(pull)
    !! Return the tension at the end of a part, on the inner side of jumps.
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
    !! Solve the system, with scaling, as sizes of unknowns and rows differ widely for large s.
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
      if (info > 0 .and. info <= n) right = 0.0_dp   ! cannot happen for a beam held by its inertia
    end associate
  end subroutine solve

  pure real(dp) function inertia_of(given, shift) result(lambda)
    !! Return λ.
    type(varying_beam), intent(in) :: given
    real(dp), intent(in) :: shift
    lambda = -shift
    if (given%beam%in_plane) lambda = lambda + given%beam%spin_squared%hi
  end function inertia_of

  pure integer function row_of_force(parts, end) result(row)
    !! Return the equation of a force at the end of a part.
    integer, intent(in) :: parts, end             !! number of parts; the part, 0: the root
    row = 2
    if (end > 0) row = 8*end + 2
    if (end == parts) row = 8*end
  end function row_of_force

  pure subroutine displace_ends(given, parts, by, right)
    !! Set the right side for displaced supports.
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

  subroutine join_parts(given, shift, parts, matrix)
    !! Build the equations of all states: the root's support, each part, the joints, and the free tip.
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
      if (e == size(parts)) then                  ! no part follows
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

end module bw_static_shape
