module bw_force_step
  !! A time step with a force that is a polynomial through Chebyshev points, and exact motion of the oscillators. Their
  !! sums at the points and their final state are linear in the initial state and in the values of the force. These
  !! operators depend only on the length of the step, so steps of one length share them.
  !!
  !! The force acts on each oscillator with a_k/M_k, and the sum −Σa_ku_k is evaluated: with Φ_k(ξ₀) for modes and −1
  !! for the mass, this is their approach. Units of bw_segment.
  use bw_force_response, only: find_force_response, force_degree, highest_power, powers_of
  use bw_kinds, only: dp
  use bw_oscillators, only: oscillators
  implicit none (type, external)
  private
  public :: add_loads, advance_state, force_in_step, find_force_step, find_step_end, last_coefficient, mean_force, polynomial_of

  integer :: point, term
  real(dp), parameter :: quarter_turn = acos(0.0_dp)
  real(dp), parameter, public :: node_places(0:force_degree) = &
    [(sin(quarter_turn*point/force_degree)**2, point=0, force_degree)]
    !! Chebyshev extrema over a step from 0 to 1; the first is its start
  integer, parameter :: chebyshev(0:force_degree, 0:force_degree) = reshape([ &
    1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, &
    0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, &
    -1, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, &
    0, -3, 0, 4, 0, 0, 0, 0, 0, 0, 0, &
    1, 0, -8, 0, 8, 0, 0, 0, 0, 0, 0, &
    0, 5, 0, -20, 0, 16, 0, 0, 0, 0, 0, &
    -1, 0, 18, 0, -48, 0, 32, 0, 0, 0, 0, &
    0, -7, 0, 56, 0, -112, 0, 64, 0, 0, 0, &
    1, 0, -32, 0, 160, 0, -256, 0, 128, 0, 0, &
    0, 9, 0, -120, 0, 432, 0, -576, 0, 256, 0, &
    -1, 0, 50, 0, -400, 0, 1120, 0, -1280, 0, 512], [force_degree + 1, force_degree + 1])
    !! Chebyshev polynomials by powers of x, (powers, polynomials)
  real(dp), parameter :: ends_halved(0:force_degree) = &
    [(merge(0.5_dp, 1.0_dp, point == 0 .or. point == force_degree), point=0, force_degree)]
  real(dp), parameter :: series(0:force_degree, 0:force_degree) = reshape( &
    [((2.0_dp/force_degree*ends_halved(point)*ends_halved(term)*(-1)**term*cos(2.0_dp*quarter_turn*point*term/force_degree), &
       term=0, force_degree), point=0, force_degree)], [force_degree + 1, force_degree + 1])
    !! coefficients of the Chebyshev series by values at the points, (polynomials, points)
  real(dp), parameter :: node_powers(0:force_degree, 0:force_degree) = matmul(real(chebyshev, dp), series)
    !! coefficients of 1, x, x² … (x from −1 to 1) of the Lagrange polynomials of the points, (powers, points)
  real(dp), parameter, public :: node_slopes(force_degree, 0:force_degree) = matmul(reshape( &
    [((2*term*(2.0_dp*node_places(point) - 1.0_dp)**max(0, term - 1), point=1, force_degree), term=0, force_degree)], &
    [force_degree, force_degree + 1]), node_powers)
    !! derivatives at the points by values there, for a step of length 1, (points, 0:points)

  type, public :: step_end
    !! The final state of a step by its initial state and the force.
    real(dp) :: length = 0.0_dp                    !! h; 0: not computed yet
    real(dp), allocatable :: moved(:, :)  !! final q and v by initial q and v: q by q, q by v, v by q, v by v, (oscillators, 4)
    real(dp), allocatable :: pushed(:, :, :)       !! final q and v by the coefficient of each power of time in the force,
                                                   !! (oscillators, 0:powers, 2)
    real(dp), allocatable :: by_unit(:, :, :)      !! the same by an acceleration; unallocated: no other loads
  contains
    procedure :: advance
    procedure :: push
  end type step_end

  type, extends(step_end), public :: force_step
    !! The final state, and the sums at the points.
    real(dp), allocatable :: seen(:, :, :)         !! approach and its rate at the points by initial displacements and velocities,
                                                   !! (2 x points, 2, oscillators)
    real(dp), allocatable :: compliance(:, :)      !! reduction of approach at each point by each value, (points, 0:points)
    real(dp), allocatable :: rate_compliance(:, :) !! the same of its rate
    real(dp), allocatable :: load_compliance(:, :, :)        !! the same by values of loads, (points, 0:points, loads)
    real(dp), allocatable :: load_rate_compliance(:, :, :)
  contains
    procedure :: approach
  end type force_step

contains

  subroutine find_force_step(parts, a, inertia, length, step)
    !! Compute the operators of a step.
    type(oscillators), intent(in) :: parts
    real(dp), intent(in) :: a(:), inertia(:)       !! a_k and M_k, (oscillators)
    real(dp), intent(in) :: length
    type(force_step), intent(out) :: step
    real(dp), dimension(force_degree, 0:force_degree) :: given, given_rate, pushed, pushed_rate   ! by powers, (points, powers)
    real(dp) :: moved(force_degree, 4), x(force_degree, 0:highest_power)
    integer :: k
    step%length = length
    allocate (step%moved(size(a), 4), step%pushed(size(a), 0:force_degree, 2), step%seen(2*force_degree, 2, size(a)))
    x = powers_of(2.0_dp*node_places(1:) - 1.0_dp)
    given = 0.0_dp
    given_rate = 0.0_dp
    do k = 1, size(a)
      call move_and_push(parts, k, a(k)/inertia(k), length, x, moved, pushed, pushed_rate)
      step%seen(:force_degree, :, k) = -a(k)*moved(:, :2)
      step%seen(force_degree + 1:, :, k) = -a(k)*moved(:, 3:)
      given = given + a(k)*pushed
      given_rate = given_rate + a(k)*pushed_rate
      step%moved(k, :) = moved(force_degree, :)
      step%pushed(k, :, 1) = pushed(force_degree, :)
      step%pushed(k, :, 2) = pushed_rate(force_degree, :)
    end do
    step%compliance = matmul(given, node_powers)
    step%rate_compliance = matmul(given_rate, node_powers)
  end subroutine find_force_step

  pure subroutine find_step_end(parts, a, inertia, length, step)
    !! Compute the operators of the final state alone, for a known force.
    type(oscillators), intent(in) :: parts
    real(dp), intent(in) :: a(:), inertia(:)       !! see `find_force_step`
    real(dp), intent(in) :: length
    type(step_end), intent(out) :: step
    real(dp), dimension(1, 0:force_degree) :: pushed, pushed_rate
    real(dp) :: moved(1, 4), x(1, 0:highest_power)
    integer :: k
    step%length = length
    allocate (step%moved(size(a), 4), step%pushed(size(a), 0:force_degree, 2))
    x = 1.0_dp
    do k = 1, size(a)
      call move_and_push(parts, k, a(k)/inertia(k), length, x, moved, pushed, pushed_rate)
      step%moved(k, :) = moved(1, :)
      step%pushed(k, :, 1) = pushed(1, :)
      step%pushed(k, :, 2) = pushed_rate(1, :)
    end do
  end subroutine find_step_end

  subroutine add_loads(parts, a, driven, step)
    !! Add the operators of other loads to a step.
    type(oscillators), intent(in) :: parts
    real(dp), intent(in) :: a(:)                   !! see `find_force_step`
    real(dp), intent(in) :: driven(:, :)           !! acceleration of each under a load of 1, (oscillators, loads)
    type(force_step), intent(inout) :: step
    real(dp), dimension(force_degree, 0:force_degree) :: pushed, pushed_rate   ! by powers, (points, powers)
    real(dp) :: moved(force_degree, 4), x(force_degree, 0:highest_power)
    integer :: k, l
    allocate (step%by_unit, mold=step%pushed)
    allocate (step%load_compliance(force_degree, 0:force_degree, size(driven, 2)), source=0.0_dp)
    step%load_rate_compliance = step%load_compliance
    x = powers_of(2.0_dp*node_places(1:) - 1.0_dp)
    do k = 1, size(a)
      call move_and_push(parts, k, 1.0_dp, step%length, x, moved, pushed, pushed_rate)
      step%by_unit(k, :, 1) = pushed(force_degree, :)
      step%by_unit(k, :, 2) = pushed_rate(force_degree, :)
      do l = 1, size(driven, 2)
        step%load_compliance(:, :, l) = step%load_compliance(:, :, l) + a(k)*driven(k, l)*pushed
        step%load_rate_compliance(:, :, l) = step%load_rate_compliance(:, :, l) + a(k)*driven(k, l)*pushed_rate
      end do
    end do
    do l = 1, size(driven, 2)
      step%load_compliance(:, :, l) = matmul(step%load_compliance(:, :, l), node_powers)
      step%load_rate_compliance(:, :, l) = matmul(step%load_rate_compliance(:, :, l), node_powers)
    end do
  end subroutine add_loads

  pure subroutine move_and_push(parts, k, driven, length, x, moved, pushed, pushed_rate)
    !! Find one oscillator's motion at given times of a step, by its initial state and by each power in the force.
    type(oscillators), intent(in) :: parts
    integer, intent(in) :: k
    real(dp), intent(in) :: driven                 !! a_k/M_k
    real(dp), intent(in) :: length
    real(dp), intent(in), contiguous :: x(:, 0:)   !! powers of x at the times, (times, powers)
    real(dp), intent(out), contiguous :: moved(:, :)   !! (times, 4)
    real(dp), intent(out), contiguous :: pushed(:, 0:), pushed_rate(:, 0:)   !! (times, powers)
    integer :: i
    do i = 1, size(x, 1)
      moved(i, :) = parts%motion(k, 0.5_dp*(1.0_dp + x(i, 1))*length)
    end do
    moved(:, 1) = 1.0_dp + moved(:, 1)
    pushed = 0.0_dp
    pushed_rate = 0.0_dp
    if (driven == 0.0_dp) return
    call find_force_response(parts%beta_squared(k)%hi, parts%c(k), length, x, moved(:, 2), moved(:, 4), pushed, pushed_rate)
    pushed = driven*pushed
    pushed_rate = driven*pushed_rate
  end subroutine move_and_push

  pure subroutine advance_state(parts, a, inertia, length, place, force, u, v)
    !! Move the state to a place in a step, from 0 to 1.
    type(oscillators), intent(in) :: parts
    real(dp), intent(in) :: a(:), inertia(:)       !! see `find_force_step`
    real(dp), intent(in) :: length, place
    real(dp), intent(in) :: force(0:)              !! at the start and the points
    real(dp), intent(inout) :: u(:), v(:)
    real(dp), dimension(1, 0:force_degree) :: pushed, pushed_rate
    real(dp) :: coefficients(0:force_degree), moved(1, 4), start, x(1, 0:highest_power)
    integer :: k
    coefficients = polynomial_of(force)
    x = powers_of([2.0_dp*place - 1.0_dp])
    do k = 1, size(u)
      call move_and_push(parts, k, a(k)/inertia(k), length, x, moved, pushed, pushed_rate)
      start = u(k)
      u(k) = moved(1, 1)*start + moved(1, 2)*v(k) + dot_product(pushed(1, :), coefficients)
      v(k) = moved(1, 3)*start + moved(1, 4)*v(k) + dot_product(pushed_rate(1, :), coefficients)
    end do
  end subroutine advance_state

  pure subroutine approach(self, u, v, value, rate)
    !! Return the approach and its rate at the points without a force.
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
    !! Move the state to the end of the step.
    class(step_end), intent(in) :: self
    real(dp), intent(in) :: force(0:)              !! at the start and the points
    real(dp), intent(inout) :: u(:), v(:)          !! of all oscillators, or of the first
    real(dp) :: coefficients(0:force_degree)
    real(dp), dimension(size(u)) :: driven, driven_rate, start
    coefficients = polynomial_of(force)
    associate (n => size(u))
      driven = matmul(self%pushed(:n, :, 1), coefficients)
      driven_rate = matmul(self%pushed(:n, :, 2), coefficients)
      start = u
      u = self%moved(:n, 1)*start + self%moved(:n, 2)*v + driven
      v = self%moved(:n, 3)*start + self%moved(:n, 4)*v + driven_rate
    end associate
  end subroutine advance

  pure subroutine push(self, driven, load, u, v)
    !! Add the contribution of other loads to the state at the end of the step.
    class(step_end), intent(in) :: self
    real(dp), intent(in) :: driven(:, :)           !! see `add_loads`
    real(dp), intent(in) :: load(0:, :)            !! at the start and the points, (0:points, loads)
    real(dp), intent(inout) :: u(:), v(:)          !! of all oscillators
    integer :: l
    do l = 1, size(load, 2)
      associate (coefficients => polynomial_of(load(:, l)))
        u = u + driven(:, l)*matmul(self%by_unit(:, :, 1), coefficients)
        v = v + driven(:, l)*matmul(self%by_unit(:, :, 2), coefficients)
      end associate
    end do
  end subroutine push

  pure function polynomial_of(values) result(coefficients)
    !! Return the coefficients of 1, x, x² … of the force in a step, x from −1 to 1, from its values at the points.
    real(dp), intent(in) :: values(0:)
    real(dp) :: coefficients(0:force_degree)
    coefficients = matmul(node_powers, values)
  end function polynomial_of

  pure subroutine force_in_step(coefficients, place, force, slope)
    !! Return the force and its derivative by the place, a fraction of the step; also beyond its end.
    real(dp), intent(in) :: coefficients(0:)       !! of the polynomial in the step
    real(dp), intent(in) :: place
    real(dp), intent(out) :: force
    real(dp), intent(out), optional :: slope
    real(dp) :: rate
    integer :: j
    force = 0.0_dp
    rate = 0.0_dp
    do j = force_degree, 0, -1
      rate = rate*(2.0_dp*place - 1.0_dp) + force
      force = force*(2.0_dp*place - 1.0_dp) + coefficients(j)
    end do
    if (present(slope)) slope = 2.0_dp*rate
  end subroutine force_in_step

  pure real(dp) function mean_force(values) result(mean)
    !! Return the mean over the step.
    real(dp), intent(in) :: values(0:)
    integer :: j
    associate (coefficients => polynomial_of(values))
      mean = sum([(coefficients(j + 1)/(j + 1), j=0, force_degree, 2)])
    end associate
  end function mean_force

  pure real(dp) function last_coefficient(values) result(size_of)
    !! Return the size of the last terms of the force's Chebyshev series, an estimate of the polynomial's error.
    real(dp), intent(in) :: values(0:)
    real(dp), parameter :: earlier = 0.1_dp        ! weight of the last but one: the force may be nearly even
    size_of = abs(dot_product(series(force_degree, :), values)) + earlier*abs(dot_product(series(force_degree - 1, :), values))
  end function last_coefficient

end module bw_force_step
