module bw_perturbations
  !! How far a motion through events may be from the truth: neighbours of it, in which every number that is known within some
  !! error is off by it, up or down at random, followed as linear perturbations of the motion at hand.
  !!
  !! Between events they move as the motion does. An event comes to a neighbour at a time of its own, later by −δg/ġ where
  !! the sum g decides on it, and a blow changes it there as it does the motion: together this is the saltation matrix of the
  !! event (Aizerman and Gantmakher 1958; Leine and Nijmeijer 2004). Each neighbour is kept as it is at its own time of the
  !! last event, beside which stands its `lag`: what is zero for all of them at an event stays small.
  !!
  !! An error is `confidence` times the root mean square over the neighbours: of errors that add up at random one in ten
  !! thousand is larger. Units of bw_segment.
  use bw_double_double, only: to_dd
  use bw_kinds, only: dp, i8, qp
  use bw_modal_flow, only: flow
  use bw_oscillators, only: moving_state, oscillators, reach, weighted_sum
  implicit none (type, external)
  private
  public :: error_from

  integer, parameter, public :: neighbours = 32
  real(dp), parameter :: confidence = 5.0_dp
  real(dp), parameter :: rounding = 1.0e-33_dp          !! of a flight, which is computed in binary128
  integer(i8), parameter :: first_seed = 88172645463325252_i8   !! any but 0

  type, public :: perturbations
    real(dp), allocatable :: u(:, :), v(:, :)      !! displacements and velocities, (oscillators, neighbours)
    real(dp) :: lag(neighbours) = 0.0_dp           !! by which the last event comes to them later
    real(dp), allocatable :: sign(:, :)            !! which way their numbers are off, 1 or −1, (oscillators, neighbours)
    integer(i8), private :: seed = first_seed
  contains
    procedure :: start
    procedure :: move
    procedure :: meet
    procedure, private :: extent
    procedure, private :: signs
  end type perturbations

contains

  pure real(dp) function error_from(deviation) result(error)
    !! Of a number, from its deviations in the neighbours.
    real(dp), intent(in) :: deviation(:)           !! (neighbours)
    error = confidence*norm2(deviation)/sqrt(real(size(deviation), dp))
  end function error_from

  pure subroutine start(self, count)
    !! Neighbours that do not differ yet.
    class(perturbations), intent(inout) :: self
    integer, intent(in) :: count                   !! oscillators
    allocate (self%u(count, neighbours), self%v(count, neighbours), source=0.0_dp)
    allocate (self%sign(count, neighbours))
    call self%signs(self%sign)
  end subroutine start

  pure subroutine signs(self, sign)
    !! New ones by Marsaglia's generator, the same in every run.
    class(perturbations), intent(inout) :: self
    real(dp), intent(out) :: sign(:, :)
    integer :: i, j
    do j = 1, size(sign, 2)
      do i = 1, size(sign, 1)
        self%seed = ieor(self%seed, ishft(self%seed, 13))
        self%seed = ieor(self%seed, ishft(self%seed, -7))
        self%seed = ieor(self%seed, ishft(self%seed, 17))
        sign(i, j) = merge(1.0_dp, -1.0_dp, btest(self%seed, 40))
      end do
    end do
  end subroutine signs

  pure subroutine move(self, parts, from, to, error)
    !! Moves with the motion from one event to the next: what they differ by, what numbers that are off add, and rounding.
    class(perturbations), intent(inout) :: self
    type(oscillators), intent(in) :: parts
    type(moving_state), intent(in) :: from, to     !! of the motion
    real(dp), intent(out) :: error(:, :)           !! the largest of displacements and velocities on the way, (oscillators, 2)
    real(dp) :: last_error(size(from%u), 2)
    real(dp), dimension(size(from%u), neighbours) :: before, up, down
    real(dp) :: matrix(2, 2), off(2), blur(2)
    real(qp) :: time
    integer :: j
    time = to%time - from%time
    call self%extent(parts, from, real(time, dp), error)
    call self%signs(up)
    call self%signs(down)
    before = self%u
    do j = 1, size(from%u)
      matrix = propagator(parts, j, time)
      off = change(parts, j, from, to, real(time, dp), matrix)
      blur = rounded(parts, j, from, to, real(time, dp))
      self%u(j, :) = matrix(1, 1)*before(j, :) + matrix(1, 2)*self%v(j, :) + off(1)*self%sign(j, :) + blur(1)*up(j, :)
      self%v(j, :) = matrix(2, 1)*before(j, :) + matrix(2, 2)*self%v(j, :) + off(2)*self%sign(j, :) + blur(2)*down(j, :)
    end do
    call self%extent(parts, to, real(time, dp), last_error)
    error = max(error, last_error)
  end subroutine move

  pure function propagator(parts, j, time) result(matrix)
    !! Of one oscillator: from displacement and velocity to both.
    type(oscillators), intent(in) :: parts
    integer, intent(in) :: j
    real(qp), intent(in) :: time
    real(dp) :: matrix(2, 2)
    matrix = reshape([1.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], [2, 2])
    call flow(parts%beta_squared(j), real(parts%c(j), dp), to_dd(time), matrix(1, :), matrix(2, :))
  end function propagator

  pure function change(parts, j, from, to, t, matrix) result(off)
    !! What errors of β² and c change in displacement and velocity. With β and c larger by ε the motion is that of time
    !! (1+ε)t, from a velocity smaller by ε.
    type(oscillators), intent(in) :: parts
    integer, intent(in) :: j
    type(moving_state), intent(in) :: from, to
    real(dp), intent(in) :: t, matrix(2, 2)
    real(dp) :: off(2)
    real(dp) :: u, v, a, first_v, square, faster
    real(dp), parameter :: slow = 1.0e-3_dp        ! rad: a phase so small that the frequency does not show but as a force
    u = real(to%u(j), dp)
    v = real(to%v(j), dp)
    first_v = real(from%v(j), dp)
    square = parts%beta_squared(j)%hi
    if (abs(square)*t**2 > slow**2) then
      a = -real(parts%c(j), dp)*v - square*u
      faster = 0.5_dp*parts%square_error(j)/abs(square)
      off = faster*[t*v - matrix(1, 2)*first_v, t*a + v - matrix(2, 2)*first_v]
    else
      off = parts%square_error(j)*(abs(u) + t*abs(first_v))*[0.5_dp*t**2, t]
    end if
    off = off - 0.5_dp*parts%c_error(j)*t*[u, v]
  end function change

  pure function rounded(parts, j, from, to, t) result(blur)
    !! Rounding of displacement and velocity, and of the phase.
    type(oscillators), intent(in) :: parts
    integer, intent(in) :: j
    type(moving_state), intent(in) :: from, to
    real(dp), intent(in) :: t
    real(dp) :: blur(2)
    real(dp) :: beta, amplitude, rate
    beta = sqrt(abs(parts%beta_squared(j)%hi))
    rate = real(max(abs(from%v(j)), abs(to%v(j))), dp)
    amplitude = real(max(abs(from%u(j)), abs(to%u(j))), dp) + rate*min(t, 1.0_dp/max(beta, tiny(t)))
    blur = rounding*(1.0_dp + beta*t)*[amplitude, rate + beta*amplitude]
  end function rounded

  pure subroutine meet(self, parts, sum_of, state)
    !! An event where a sum falls through zero: each neighbour goes to its own time of it.
    class(perturbations), intent(inout) :: self
    type(oscillators), intent(in) :: parts
    type(weighted_sum), intent(in) :: sum_of
    type(moving_state), intent(in) :: state        !! of the motion, at the event
    real(dp), dimension(size(state%u)) :: a, b, rate, bend
    real(dp) :: slope, later
    integer :: p
    slope = real(parts%derivative(sum_of, state, 1), dp)
    a = real(sum_of%a, dp)
    b = real(sum_of%b, dp)
    rate = real(state%v, dp)
    bend = real(parts%accelerations(state%u, state%v), dp)
    do p = 1, neighbours
      later = -(dot_product(a, self%u(:, p)) + dot_product(b, self%v(:, p)))/slope
      self%lag(p) = self%lag(p) + later
      self%u(:, p) = self%u(:, p) + later*rate
      self%v(:, p) = self%v(:, p) + later*bend
    end do
  end subroutine meet

  pure subroutine extent(self, parts, state, time, error)
    !! Errors of displacements and velocities within a time from a state, compared at one and the same time.
    class(perturbations), intent(in) :: self
    type(oscillators), intent(in) :: parts
    type(moving_state), intent(in) :: state        !! of the motion then
    real(dp), intent(in) :: time
    real(dp), intent(out) :: error(:, :)           !! (oscillators, 2)
    real(dp), dimension(neighbours) :: u, v
    real(dp) :: c, square, turning
    integer :: j
    do j = 1, size(state%u)
      c = real(parts%c(j), dp)
      square = parts%beta_squared(j)%hi
      turning = square - 0.25_dp*c**2
      u = self%u(j, :) - self%lag*real(state%v(j), dp)
      v = self%v(j, :) + self%lag*(c*real(state%v(j), dp) + square*real(state%u(j), dp))
      error(j, 1) = error_from(reach(square, c, u, v, time))
      error(j, 2) = error_from(v)
      if (turning > 0.0_dp) error(j, 2) = error_from(hypot(sqrt(square)*u, (v + 0.5_dp*c*u)*sqrt(square/turning)))
    end do
  end subroutine extent

end module bw_perturbations
