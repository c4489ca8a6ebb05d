module bw_force_step
  !! A step in which a force is a polynomial through Chebyshev's points, and oscillators move exactly: what their sums come to at the
  !! points, and their state at the end, are linear in the state at the start and in the values of the force. These operators depend
  !! on the length of the step alone, so that steps of one length share them.
  !!
  !! The force drives each oscillator by a_k/M_k times its value, and what is looked at is −Σa_ku_k: of a beam and a mass beside it,
  !! with Φ_k(ξ₀) and −1, their approach. Units of bw_segment.
  use bw_double_double, only: to_dd
  use bw_force_response, only: find_force_response, force_degree
  use bw_kinds, only: dp
  use bw_modal_flow, only: flow
  use bw_oscillators, only: oscillators
  implicit none (type, external)
  private
  public :: force_step_of, last_coefficient, node_derivatives, part_values, polynomial_of, step_end_of

  integer :: point, term
  real(dp), parameter :: quarter_turn = acos(0.0_dp)
  real(dp), parameter, public :: node_places(0:force_degree) = &
    [(sin(quarter_turn*point/force_degree)**2, point=0, force_degree)]
    !! Chebyshev's extrema over a step from 0 to 1; the first is its start
  integer, parameter :: shifted(0:force_degree, 0:force_degree) = reshape([ &
    1, 0, 0, 0, 0, 0, 0, &
    -1, 2, 0, 0, 0, 0, 0, &
    1, -8, 8, 0, 0, 0, 0, &
    -1, 18, -48, 32, 0, 0, 0, &
    1, -32, 160, -256, 128, 0, 0, &
    -1, 50, -400, 1120, -1280, 512, 0, &
    1, -72, 840, -3584, 6912, -6144, 2048], [force_degree + 1, force_degree + 1])
    !! Chebyshev's polynomials of 2x − 1 by the powers of x, (powers, polynomials)
  real(dp), parameter :: ends_halved(0:force_degree) = &
    [(merge(0.5_dp, 1.0_dp, point == 0 .or. point == force_degree), point=0, force_degree)]
  real(dp), parameter :: series(0:force_degree, 0:force_degree) = reshape( &
    [((2.0_dp/force_degree*ends_halved(point)*ends_halved(term)*(-1)**term*cos(2.0_dp*quarter_turn*point*term/force_degree), &
       term=0, force_degree), point=0, force_degree)], [force_degree + 1, force_degree + 1])
    !! coefficients of Chebyshev's series by values at the points, (polynomials, points)
  real(dp), parameter :: node_powers(0:force_degree, 0:force_degree) = matmul(real(shifted, dp), series)
    !! coefficients of 1, x, x² … of the polynomial that is 1 at one point and 0 at the others, (powers, points)

  type, public :: step_end
    !! From the state at the start to that at the end.
    real(dp) :: length = 0.0_dp                    !! h; 0: not found yet
    real(dp), allocatable :: moved(:, :)           !! end state of each: q by q, q by v, v by q, v by v, (oscillators, 4)
    real(dp), allocatable :: pushed(:, :, :)       !! and by each value of the force, (oscillators, 0:points, 2)
  contains
    procedure :: advance
  end type step_end

  type, extends(step_end), public :: force_step
    !! And to what is seen at the points.
    real(dp), allocatable :: seen(:, :, :)         !! approach and its rate at the points, of displacements and velocities at the start,
                                                   !! (2 x points, 2, oscillators)
    real(dp), allocatable :: compliance(:, :)      !! how much less the approach at each point is for each value, (points, 0:points)
    real(dp), allocatable :: rate_compliance(:, :) !! its rate likewise
  contains
    procedure :: approach
  end type force_step

contains

  type(force_step) function force_step_of(parts, a, inertia, length) result(step)
    !! The operators of a step.
    type(oscillators), intent(in) :: parts
    real(dp), intent(in) :: a(:), inertia(:)       !! a_k and M_k, (oscillators)
    real(dp), intent(in) :: length
    real(dp) :: unit(4), pushed(0:force_degree, 2)
    integer :: i, k
    step%step_end = step_end_of(parts, a, inertia, length)
    allocate (step%seen(2*force_degree, 2, size(a)))
    allocate (step%compliance(force_degree, 0:force_degree), step%rate_compliance(force_degree, 0:force_degree), source=0.0_dp)
    do i = 1, force_degree
      do k = 1, size(a)
        if (i < force_degree) then
          call move_and_push(parts, k, a(k)/inertia(k), node_places(i)*length, unit, pushed, node_places(i))
        else
          unit = step%moved(k, :)
          pushed = step%pushed(k, :, :)
        end if
        step%seen(i, :, k) = -a(k)*unit(:2)
        step%seen(force_degree + i, :, k) = -a(k)*unit(3:)
        step%compliance(i, :) = step%compliance(i, :) + a(k)*pushed(:, 1)
        step%rate_compliance(i, :) = step%rate_compliance(i, :) + a(k)*pushed(:, 2)
      end do
    end do
  end function force_step_of

  type(step_end) function step_end_of(parts, a, inertia, length) result(step)
    !! Those that lead to the end of a step.
    type(oscillators), intent(in) :: parts
    real(dp), intent(in) :: a(:), inertia(:), length   !! as those of `force_step_of`
    integer :: k
    step%length = length
    allocate (step%moved(size(a), 4), step%pushed(size(a), 0:force_degree, 2))
    do k = 1, size(a)
      call move_and_push(parts, k, a(k)/inertia(k), length, step%moved(k, :), step%pushed(k, :, :), 1.0_dp)
    end do
  end function step_end_of

  pure subroutine move_and_push(parts, k, driven, time, moved, pushed, place)
    !! One oscillator at a time after the start of a step.
    type(oscillators), intent(in) :: parts
    integer, intent(in) :: k
    real(dp), intent(in) :: driven                 !! a_k/M_k
    real(dp), intent(in) :: time, place            !! the same as a part of the step
    real(dp), intent(out) :: moved(4), pushed(0:force_degree, 2)
    real(dp), dimension(0:force_degree) :: displacement, velocity
    real(dp) :: unit(2, 2)
    integer :: j
    unit = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 2])
    call flow(parts%beta_squared(k), parts%c(k), to_dd(time), unit(1, :), unit(2, :))
    moved = [unit(1, :), unit(2, :)]
    pushed = 0.0_dp
    if (driven == 0.0_dp) return
    call find_force_response(parts%beta_squared(k)%hi, parts%c(k), time, displacement, velocity)
    associate (raised => [(driven*place**j, j=0, force_degree)])
      pushed(:, 1) = matmul(displacement*raised, node_powers)
      pushed(:, 2) = matmul(velocity*raised, node_powers)
    end associate
  end subroutine move_and_push

  pure subroutine approach(self, u, v, value, rate)
    !! What the approach and its rate at the points would be without a force.
    class(force_step), intent(in) :: self
    real(dp), intent(in) :: u(:), v(:)             !! at the start, (oscillators)
    real(dp), intent(out) :: value(force_degree), rate(force_degree)
    real(dp) :: both(2*force_degree)
    integer :: k
    both = 0.0_dp
    do k = 1, size(u)
      both = both + self%seen(:, 1, k)*u(k) + self%seen(:, 2, k)*v(k)
    end do
    value = both(:force_degree)
    rate = both(force_degree + 1:)
  end subroutine approach

  pure subroutine advance(self, force, u, v)
    !! The state at the end of the step.
    class(step_end), intent(in) :: self
    real(dp), intent(in) :: force(0:)              !! at the start and at the points
    real(dp), intent(inout) :: u(:), v(:)
    real(dp) :: start(size(u))
    start = u
    u = self%moved(:, 1)*start + self%moved(:, 2)*v + matmul(self%pushed(:, :, 1), force)
    v = self%moved(:, 3)*start + self%moved(:, 4)*v + matmul(self%pushed(:, :, 2), force)
  end subroutine advance

  pure function polynomial_of(values) result(coefficients)
    !! Coefficients of 1, x, x² … of the force in a step, from its values at the points.
    real(dp), intent(in) :: values(0:)
    real(dp) :: coefficients(0:force_degree)
    coefficients = matmul(node_powers, values)
  end function polynomial_of

  pure function part_values(values, part) result(shorter)
    !! A step's force at the points of its first part.
    real(dp), intent(in) :: values(0:)
    real(dp), intent(in) :: part                   !! 0 to 1
    real(dp) :: shorter(0:force_degree)
    real(dp) :: coefficients(0:force_degree), places(0:force_degree)
    integer :: j
    coefficients = polynomial_of(values)
    places = part*node_places
    shorter = coefficients(force_degree)
    do j = force_degree - 1, 0, -1
      shorter = coefficients(j) + places*shorter
    end do
  end function part_values

  pure function node_derivatives() result(slopes)
    !! Derivatives at the points from values at them, over a step of length 1, (points, 0:points).
    real(dp) :: slopes(force_degree, 0:force_degree)
    integer :: i, j
    slopes = 0.0_dp
    do i = 1, force_degree
      do j = 1, force_degree
        slopes(i, :) = slopes(i, :) + j*node_places(i)**(j - 1)*node_powers(j, :)
      end do
    end do
  end function node_derivatives

  pure real(dp) function last_coefficient(values) result(size_of)
    !! How large the last terms of Chebyshev's series of the force are, which tells what the polynomial lacks.
    real(dp), intent(in) :: values(0:)
    real(dp), parameter :: earlier = 0.1_dp        ! of the last but one: the series may be that of an even function
    size_of = abs(dot_product(series(force_degree, :), values)) + earlier*abs(dot_product(series(force_degree - 1, :), values))
  end function last_coefficient

end module bw_force_step
