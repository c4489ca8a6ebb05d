module bw_oscillators
  !! Uncoupled oscillators ü + cu̇ + β²u = 0: the modes of a beam and the mass beside it, or the modes of both together.
  !! Weighted sums over them are the gap between tip and mass, or the contact force. Units of bw_segment.
  use bw_double_double, only: accurate_sum, dd, sqrt, to_dd, operator(*), operator(+), operator(-)
  use bw_kinds, only: dp
  use bw_modal_flow, only: angle_of, flow, joined_below, turning_square
  implicit none (type, external)
  private
  public :: oscillators_of

  type, public :: moving_state
    real(dp), allocatable :: u(:), v(:)           !! displacements and velocities, (oscillators)
    type(dd) :: time
  end type moving_state

  type, public :: weighted_sum
    !! Σ(a u + b u̇).
    real(dp), allocatable :: a(:), b(:)           !! (oscillators)
  end type weighted_sum

  type, public :: oscillators
    type(dd), allocatable :: beta_squared(:)      !! β²
    real(dp), allocatable :: c(:)                 !! ≥ 0
    type(dd), allocatable :: root(:)              !! √|β² − c²/4|
    logical, allocatable :: turning(:)            !! β² > c²/4: oscillates
    real(dp), allocatable :: rate(:)              !! bound of the ratio of successive derivatives
  contains
    procedure :: advance
    procedure :: motion
    procedure :: move
    procedure :: accelerations
    procedure :: derivative
    procedure :: amplitude
    procedure :: extent
  end type oscillators


contains

  pure type(oscillators) function oscillators_of(beta_squared, c) result(parts)
    !! Return oscillators with given β² and c.
    type(dd), intent(in) :: beta_squared(:)
    real(dp), intent(in) :: c(:)
    type(dd) :: square(size(c))
    square = turning_square(beta_squared, c)
    parts%beta_squared = beta_squared
    parts%c = c
    parts%turning = square%hi > 0.0_dp
    where (.not. parts%turning) square = -square
    parts%root = sqrt(square)
    parts%rate = c + sqrt(abs(beta_squared%hi))
  end function oscillators_of

  pure subroutine advance(self, time, u, v, change, velocity)
    !! Return the change of displacements in a time, without cancellation, and the velocities at its end.
    class(oscillators), intent(in) :: self
    real(dp), intent(in) :: time                  !! ≥ 0
    real(dp), intent(in) :: u(:), v(:)            !! at the start
    real(dp), intent(out) :: change(:), velocity(:)
    real(dp) :: by(4)
    integer :: k
    do k = 1, size(u)
      by = self%motion(k, time)
      change(k) = by(1)*u(k) + by(2)*v(k)
      velocity(k) = by(3)*u(k) + by(4)*v(k)
    end do
  end subroutine advance

  pure function motion(self, k, time) result(by)
    !! Return for one oscillator the change of displacement per displacement and per velocity at the start, and the
    !! velocity at the end per both.
    class(oscillators), intent(in) :: self
    integer, intent(in) :: k
    real(dp), intent(in) :: time                  !! ≥ 0
    real(dp) :: by(4)
    real(dp), parameter :: many = 1.0e7_dp        ! rad, below which the square of a phase's rounding error is negligible
    type(dd) :: half
    real(dp) :: c, cosine, less, sine, square
    c = self%c(k)
    square = self%root(k)%hi**2
    half = self%root(k)*(0.5_dp*time)
    if (self%turning(k)) then
      if (half%hi > many) half = to_dd(angle_of(half))
      sine = sin(half%hi) + half%lo*cos(half%hi)
      cosine = cos(half%hi) - half%lo*sin(half%hi)
      less = -2.0_dp*sine**2                      ! cos − 1
      sine = 2.0_dp*sine*cosine/self%root(k)%hi
    else if (2.0_dp*half%hi < joined_below) then
      square = -square
      less = 2.0_dp*sinh(half%hi)**2              ! cosh − 1
      sine = time
      if (half%hi > 0.0_dp) sine = time*sinh(half%hi)*cosh(half%hi)/half%hi
    else
      by = [1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
      call flow(self%beta_squared(k), c, to_dd(time), by(1), by(3))
      call flow(self%beta_squared(k), c, to_dd(time), by(2), by(4))
      by(1) = by(1) - 1.0_dp
      return
    end if
    by = [less, sine, -square*sine, 1.0_dp + less]
    if (c == 0.0_dp) return
    by(1) = less + 0.5_dp*c*sine                  ! without decay
    by(3) = 0.5_dp*c*(1.0_dp + less) - square*sine
    less = decay_less_one(0.5_dp*c*time)
    by(1) = by(1) + less*(1.0_dp + by(1))
    by(2) = by(2) + less*by(2)
    by(3:4) = by(3:4) + less*by(3:4) - 0.5_dp*c*[1.0_dp + by(1), by(2)]
  end function motion

  pure real(dp) function decay_less_one(x) result(less)
    !! Return e⁻ˣ − 1 without cancellation, for any x ≥ 0.
    real(dp), intent(in) :: x
    if (x < 1.0_dp) then
      less = -2.0_dp*exp(-0.5_dp*x)*sinh(0.5_dp*x)
    else
      less = exp(-x) - 1.0_dp
    end if
  end function decay_less_one

  pure subroutine move(self, time, state)
    !! Move the state forward in time.
    class(oscillators), intent(in) :: self
    real(dp), intent(in) :: time                  !! ≥ 0
    type(moving_state), intent(inout) :: state
    real(dp), dimension(size(state%u)) :: change, velocity
    call self%advance(time, state%u, state%v, change, velocity)
    state%u = state%u + change
    state%v = velocity
    state%time = state%time + time
  end subroutine move

  pure function accelerations(self, u, v) result(a)
    !! Return ü, or any derivative from the two before it.
    class(oscillators), intent(in) :: self
    real(dp), intent(in) :: u(:), v(:)
    real(dp) :: a(size(u))
    a = -self%c*v - self%beta_squared%hi*u
  end function accelerations

  pure real(dp) function derivative(self, sum_of, state, order)
    !! Return a derivative of a sum; order 0 is the sum.
    class(oscillators), intent(in) :: self
    type(weighted_sum), intent(in) :: sum_of
    type(moving_state), intent(in) :: state
    integer, intent(in) :: order                  !! ≥ 0
    real(dp), dimension(size(state%u)) :: now, next, last
    integer :: i
    now = state%u
    next = state%v
    do i = 1, order
      last = now
      now = next
      next = self%accelerations(last, now)
    end do
    derivative = accurate_sum(sum_of%a*now + sum_of%b*next)
  end function derivative

  pure function amplitude(self, u, v)
    !! Return the amplitudes of oscillating parts, and |u| of others.
    class(oscillators), intent(in) :: self
    real(dp), intent(in) :: u(:), v(:)
    real(dp) :: amplitude(size(u))
    amplitude = abs(u)
    where (self%turning) amplitude = hypot(u, (v + 0.5_dp*self%c*u)/self%root%hi)
  end function amplitude

  pure function extent(self, u, v, time)
    !! Bound displacements and velocities of oscillating parts within a time: by their amplitude, or in a short time by
    !! |u| plus speed times time. Others keep their values.
    class(oscillators), intent(in) :: self
    real(dp), intent(in) :: u(:), v(:), time
    real(dp) :: extent(size(u), 2)                !! of displacements and velocities
    extent(:, 1) = abs(u)
    extent(:, 2) = abs(v)
    associate (largest => self%amplitude(u, v))
      where (self%turning)
        extent(:, 1) = min(largest, abs(u) + abs(v + 0.5_dp*self%c*u)*time)
        extent(:, 2) = self%rate*largest
      end where
    end associate
  end function extent

end module bw_oscillators
