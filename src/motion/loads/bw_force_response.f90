module bw_force_response
  !! The exact response of an oscillator at rest to a force that is a power of time in a step: q̈ + cq̇ + β²q = x^j,
  !! with x from −1 to 1 in the step of length h.
  !!
  !! With g the motion from velocity 1, q̇_j = (2j/h)q_(j−1) + (−1)^j g, so the equation of motion is a recurrence in j:
  !! (4j(j−1)/h²)q_(j−2) + (2j/h)cq_(j−1) + β²q_j = x^j − (−1)^j(ġ + (c − 2j/h)g). Downwards, from a power so high that
  !! its start value no longer matters, this is stable if the roots s of s² + cs + β² are small, |s|h < 2(n!)^(1/n).
  !! Else, with the larger root s₁, the factors (d/dt − s₁)(d/dt − s₂) are solved one by one: s₁q_j = (2j/h)q_(j−1) +
  !! (−1)^j g − M_j(s₂) upwards, also for a double root, with M_j = ∫e^(s(t−τ))x^j dτ from sM_j = (2j/h)M_(j−1) − x^j +
  !! (−1)^j e^(st), upwards if |s|h is large, else downwards. Without dimensions.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: find_force_response, powers_of

  integer, parameter, public :: force_degree = 10  !! of a force in a step
  real(dp), parameter :: slow = 8.0_dp             !! |s|h up to which recurrences run downwards, about 2(n!)^(1/n)
  integer, parameter, public :: highest_power = force_degree + 40   !! from which downward recurrences start, at most
  integer :: power
  real(dp), parameter :: inverse(2:highest_power) = [(1.0_dp/(4*power*(power - 1)), power=2, highest_power)]

contains

  pure subroutine find_force_response(beta_squared, c, length, x, free, rate, displacement, velocity)
    !! Find the response to each power at given times of a step. **Limit**: e^(s₁t) must not overflow.
    real(dp), intent(in) :: beta_squared, c
    real(dp), intent(in) :: length                    !! of the step, h
    real(dp), intent(in), contiguous :: x(:, 0:)      !! powers of x at the times, (times, powers)
    real(dp), intent(in), contiguous :: free(:), rate(:)   !! g and ġ at the times
    real(dp), intent(out), contiguous :: displacement(:, 0:), velocity(:, 0:)   !! (times, powers)
    complex(dp) :: moment(force_degree, 0:force_degree), larger   ! of s₂; s₁
    real(dp) :: half
    integer :: j, n
    n = size(x, 1)
    half = 0.5_dp*c
    larger = -half - sqrt(cmplx(half**2 - beta_squared, 0.0_dp, dp))
    if (abs(larger)*length < slow) then
      call slow_response(beta_squared*length**2, c*length, x, free, rate, length, displacement)
    else
      call find_moments(beta_squared/larger*length, x, moment)
      displacement(:, 0) = real((free/length - moment(:n, 0))/(larger*length))
      do j = 1, force_degree
        displacement(:, j) = real(((2*j)*displacement(:, j - 1) + sign_of(j)*free/length - moment(:n, j))/(larger*length))
      end do
    end if
    displacement = length**2*displacement
    velocity(:, 0) = free
    do j = 1, force_degree
      velocity(:, j) = (2*j/length)*displacement(:, j - 1) + sign_of(j)*free
    end do
  end subroutine find_force_response

  pure subroutine slow_response(square, damping, x, free, rate, length, displacement)
    !! Solve y″ + Cy′ + By = x^j in a step of length 1.
    real(dp), intent(in) :: square, damping           !! B and C
    real(dp), intent(in), contiguous :: x(:, 0:)
    real(dp), intent(in), contiguous :: free(:), rate(:)
    real(dp), intent(in) :: length                    !! unit of g
    real(dp), intent(out), contiguous :: displacement(:, 0:)
    real(dp), dimension(force_degree) :: above, g, next, start
    real(dp) :: left
    integer :: i, j, n, top
    top = force_degree
    left = 1.0_dp                                     ! remaining effect of the start value
    do while (left > epsilon(left) .and. top < highest_power - 1)
      top = top + 2
      left = left*max(abs(square), damping**2)*inverse(top)
    end do
    n = size(x, 1)
    g(:n) = free/length
    start(:n) = rate + damping*g(:n)
    above(:n) = 0.0_dp                                ! powers j and j + 1, then j − 2 and j − 1
    next(:n) = 0.0_dp
    do j = top, 2, -2
      do i = 1, n
        next(i) = ((x(i, j + 1) + start(i) - (2*(j + 1))*g(i)) - (2*(j + 1)*damping)*above(i) - square*next(i))*inverse(j + 1)
      end do
      if (j - 1 <= force_degree) displacement(:, j - 1) = next(:n)
      do i = 1, n
        above(i) = ((x(i, j) - start(i) + (2*j)*g(i)) - (2*j*damping)*next(i) - square*above(i))*inverse(j)
      end do
      if (j - 2 <= force_degree) displacement(:, j - 2) = above(:n)
    end do
  end subroutine slow_response

  pure subroutine find_moments(z, x, moment)
    !! Return M_0 … M_n in a step of length 1.
    complex(dp), intent(in) :: z
    real(dp), intent(in), contiguous :: x(:, 0:)
    complex(dp), intent(out) :: moment(force_degree, 0:force_degree)   !! (times, powers)
    complex(dp) :: decayed(force_degree), next(force_degree), reciprocal
    integer :: j, n
    n = size(x, 1)
    decayed(:n) = exp(z*(0.5_dp*(1.0_dp + x(:, 1))))
    if (abs(z) >= slow) then
      reciprocal = 1.0_dp/z
      moment(:n, 0) = (decayed(:n) - 1.0_dp)*reciprocal
      do j = 1, force_degree
        moment(:n, j) = ((2*j)*moment(:n, j - 1) - x(:, j) + sign_of(j)*decayed(:n))*reciprocal
      end do
      return
    end if
    next = 0.0_dp
    do j = highest_power, 1, -1
      next(:n) = (z*next(:n) + x(:, j) - sign_of(j)*decayed(:n))/(2*j)
      if (j - 1 <= force_degree) moment(:n, j - 1) = next(:n)
    end do
  end subroutine find_moments

  pure real(dp) function sign_of(j)
    !! Return (−1)^j.
    integer, intent(in) :: j
    sign_of = 1 - 2*iand(j, 1)
  end function sign_of

  pure function powers_of(x) result(powers)
    !! Return 1, x, x² … up to `highest_power`, (places, powers).
    real(dp), intent(in) :: x(:)
    real(dp) :: powers(size(x), 0:highest_power)
    integer :: j
    powers(:, 0) = 1.0_dp
    do j = 1, highest_power
      powers(:, j) = x*powers(:, j - 1)
    end do
  end function powers_of

end module bw_force_response
