module bw_oscillators
  !! Oscillators that move without each other, ü + cu̇ + β²u = 0, in binary128: the modes of a beam and the mass beside it, or
  !! the modes of both together; and sums over them, such as the gap between tip and mass or the force that presses them
  !! together, whose zeros are events. Units of bw_segment.
  use bw_double_double, only: accurate_sum, dd, to_dd
  use bw_kinds, only: dp, qp
  use bw_precise_flow, only: extended_flow
  use bw_signal, only: signal_type
  implicit none (type, external)
  private
  public :: reach

  type, public :: moving_state
    real(qp), allocatable :: u(:), v(:)           !! displacements and velocities, (oscillators)
    real(qp) :: time = 0.0_qp
  end type moving_state

  type, public :: weighted_sum
    !! Σ(a u + b u̇).
    real(qp), allocatable :: a(:), b(:)           !! (oscillators)
  end type weighted_sum

  type, public :: oscillators
    real(qp), allocatable :: square(:)            !! β²
    real(qp), allocatable :: c(:)                 !! ≥ 0
    real(dp), allocatable :: square_error(:)      !! by which β² may be off
    real(dp), allocatable :: c_error(:)           !! the same of c
    real(qp), allocatable, private :: root(:)     !! √|β² − c²/4|
    type(dd), allocatable :: beta_squared(:)      !! β² for motions in binary64
  contains
    procedure :: ready
    procedure :: move
    procedure :: accelerations
    procedure :: sway
    procedure :: derivative
    procedure :: signal
    procedure :: closest
  end type oscillators

contains

  pure subroutine ready(self)
    !! To be called once β² and c are set.
    class(oscillators), intent(inout) :: self
    self%root = sqrt(abs(self%square - 0.25_qp*self%c**2))
    self%beta_squared = to_dd(self%square)
  end subroutine ready

  pure subroutine move(self, time, state)
    !! The state a time later.
    class(oscillators), intent(in) :: self
    real(qp), intent(in) :: time                  !! of either sign
    type(moving_state), intent(inout) :: state
    call extended_flow(self%square, self%c, self%root, time, state%u, state%v)
    state%time = state%time + time
  end subroutine move

  pure function accelerations(self, u, v) result(a)
    !! ü, or any derivative from the two before it.
    class(oscillators), intent(in) :: self
    real(qp), intent(in) :: u(:), v(:)
    real(qp) :: a(size(u))
    a = -self%c*v - self%square*u
  end function accelerations

  pure real(dp) function sway(self, weight, from, to)
    !! How large a weighted sum of displacements may be in a motion between two states.
    class(oscillators), intent(in) :: self
    real(qp), intent(in) :: weight(:)             !! of the first oscillators; of others it is 0
    type(moving_state), intent(in) :: from, to
    real(dp) :: time
    integer :: n
    n = size(weight)
    time = real(to%time - from%time, dp)
    sway = max(largest_from(from), largest_from(to))

  contains

    pure real(dp) function largest_from(state) result(largest)
      !! The sum of the largest magnitudes of all terms, on the way from or to a state.
      type(moving_state), intent(in) :: state
      largest = sum(real(abs(weight), dp)*reach(self%beta_squared(:n)%hi, real(self%c(:n), dp), real(state%u(:n), dp), &
                                                real(state%v(:n), dp), time))
    end function largest_from
  end function sway

  elemental real(dp) function reach(beta_squared, c, u, v, time)
    !! How large the displacement of one that turns may be within a time from a state: its amplitude, or what it comes to at
    !! its speed where the time is short; of one that does not turn, what it is.
    real(dp), intent(in) :: beta_squared, c, u, v, time
    real(dp) :: rate, square
    reach = abs(u)
    square = beta_squared - 0.25_dp*c**2
    if (square <= 0.0_dp) return
    rate = v + 0.5_dp*c*u
    reach = min(hypot(u, rate/sqrt(square)), reach + abs(rate)*time)
  end function reach

  pure real(qp) function derivative(self, sum_of, state, order)
    !! Of a sum, 0 for itself.
    class(oscillators), intent(in) :: self
    type(weighted_sum), intent(in) :: sum_of
    type(moving_state), intent(in) :: state
    integer, intent(in) :: order                  !! ≥ 0
    real(qp), dimension(size(state%u)) :: now, next, last
    integer :: i
    now = state%u
    next = state%v
    do i = 1, order
      last = now
      now = next
      next = self%accelerations(last, now)
    end do
    derivative = sum(sum_of%a*now + sum_of%b*next)
  end function derivative

  pure type(signal_type) function signal(self, sum_of, state, order)
    !! A sum as a signal in binary64. Of its value and slope at the start nothing is lost to what cancels in them.
    class(oscillators), intent(in) :: self
    type(weighted_sum), intent(in) :: sum_of
    type(moving_state), intent(in) :: state
    integer, intent(in) :: order                  !! of the first derivative that is not zero at the start
    real(qp), dimension(size(state%u)) :: part, slope
    real(qp) :: unit
    integer :: n
    n = size(state%u)
    part = sum_of%a*state%u + sum_of%b*state%v
    slope = sum_of%a*state%v + sum_of%b*self%accelerations(state%u, state%v)
    unit = scale(1.0_qp, exponent(maxval(abs(part)) + maxval(abs(slope))))
    signal%unit = real(unit, dp)
    signal%beta_squared = self%beta_squared
    signal%c = real(self%c, dp)
    signal%u = real(part/unit, dp)
    signal%u_dot = real(slope/unit, dp)
    signal%u_dot(n) = real(sum(slope)/unit, dp) - accurate_sum(signal%u_dot(:n - 1))
    if (order == 0) signal%start = real(sum(part)/unit, dp)
  end function signal

  pure subroutine closest(self, sum_of, state, converged)
    !! Moves a state near a zero of a sum to that zero, by Newton's steps.
    class(oscillators), intent(in) :: self
    type(weighted_sum), intent(in) :: sum_of
    type(moving_state), intent(inout) :: state
    logical, intent(out) :: converged
    integer, parameter :: most = 12
    real(qp) :: value, slope, step
    integer :: i
    converged = .false.
    do i = 1, most
      value = self%derivative(sum_of, state, 0)
      slope = self%derivative(sum_of, state, 1)
      if (slope >= 0.0_qp) return
      step = -value/slope
      converged = abs(step) <= 8.0_qp*epsilon(step)*(state%time + sum(abs(sum_of%a*state%u))/(-slope))
      if (converged) return
      call self%move(step, state)
    end do
  end subroutine closest

end module bw_oscillators
