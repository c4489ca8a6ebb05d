module bw_signal
  !! A sum of modal motions, such as the gap between tip and mass or the force between them, and its first zero.
  !!
  !! The search misses nothing: with the sum s and |s̈| ≤ B from the amplitudes, s > 0 while s + ṡh − ½Bh² > 0, and each
  !! step goes that far from a time with s > 0. High-frequency parts are bounded by their amplitude alone if that allows
  !! a longer step. Near a zero the steps become Newton's, from the left.
  use bw_double_double, only: accurate_sum
  use bw_kinds, only: dp
  use bw_monitor, only: between_questions, monitor_type, stops
  use bw_oscillators, only: moving_state, oscillators, weighted_sum
  implicit none (type, external)
  private
  public :: signal_of

  type, extends(oscillators), public :: signal_type
    !! Terms u_k, ascending in frequency as far as they oscillate.
    real(dp), allocatable :: u(:), u_dot(:)        !! at the start
    integer :: order = 0                           !! of the first nonzero derivative there, which is positive
    real(dp), allocatable :: polynomial(:)         !! added to the sum, in the time since the start; unallocated: none, (0:degree)
  contains
    procedure :: first_zero
    procedure, private :: leave_zero
    procedure, private :: bound
    procedure, private :: quarter
    procedure, private :: safe_step
    procedure, private :: polynomial_bound
  end type signal_type

  real(dp), parameter :: growth = exp(0.5_dp)      !! of a part without amplitude, in a quarter of 1/rate

contains

  pure type(signal_type) function signal_of(parts, sum_of, state, order, polynomial) result(signal)
    !! Return a sum over oscillators from a state on, scaled to keep squares in range. If its slope is zero, the slope's
    !! rounding is removed.
    class(oscillators), intent(in) :: parts
    type(weighted_sum), intent(in) :: sum_of
    type(moving_state), intent(in) :: state
    integer, intent(in) :: order                  !! of the first nonzero derivative at the start
    real(dp), intent(in), optional :: polynomial(0:)   !! added to it, of degree ≥ 2
    real(dp) :: unit
    integer :: n
    n = size(state%u)
    signal%oscillators = parts
    signal%order = order
    signal%u = sum_of%a*state%u + sum_of%b*state%v
    signal%u_dot = sum_of%a*state%v + sum_of%b*parts%accelerations(state%u, state%v)
    if (order > 2) signal%u_dot(n) = -accurate_sum(signal%u_dot(:n - 1))
    unit = scale(1.0_dp, exponent(maxval(abs(signal%u)) + maxval(abs(signal%u_dot))))
    signal%u = signal%u/unit
    signal%u_dot = signal%u_dot/unit
    if (.not. present(polynomial)) return
    allocate (signal%polynomial(0:ubound(polynomial, 1)), source=polynomial/unit)
    if (order > 2) signal%u_dot(n) = signal%u_dot(n) - signal%polynomial(1)
  end function signal_of

  subroutine first_zero(self, longest, found, time, monitor)
    !! Find the first time after the start at which the signal falls to zero.
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: longest                !! end of the search
    logical, intent(out) :: found
    real(dp), intent(out) :: time                  !! `longest` if none was found
    class(monitor_type), intent(inout), optional :: monitor   !! none is found if it requests a stop
    integer, parameter :: most_steps = 20000000    ! far more than any search needs
    real(dp), dimension(size(self%u)) :: change, velocity
    real(dp) :: bend, lower, moved, now, slope, start, step
    integer :: i
    start = 0.0_dp
    lower = 0.0_dp
    time = 0.0_dp
    slope = 0.0_dp
    bend = 0.0_dp
    if (self%order == 0) start = accurate_sum(self%u)
    if (allocated(self%polynomial)) then
      if (self%order == 0) start = accurate_sum([self%u, self%polynomial(0)])
      bend = self%polynomial_bound(longest, 2)
    end if
    if (self%order > 0) call self%leave_zero(longest, time, lower)
    found = .false.
    do i = 1, most_steps
      if (time >= longest) exit
      if (mod(i, between_questions) == 0) then
        if (stops(monitor)) exit
      end if
      call self%advance(time, self%u, self%u_dot, change, velocity)
      if (allocated(self%polynomial)) then
        call move_polynomial(self%polynomial, time, moved, slope)
        now = max(start + accurate_sum([change, moved]), lower)
      else
        now = max(start + accurate_sum(change), lower)
      end if
      lower = 0.0_dp
      step = 0.0_dp
      if (now > 0.0_dp) step = self%safe_step(now, slope, bend, self%u + change, velocity, longest)
      found = step <= epsilon(step)*time
      if (found) return
      time = time + step
    end do
    time = longest
  end subroutine first_zero

  pure subroutine leave_zero(self, longest, time, lower)
    !! Take the first step from a zero: half of what the first nonzero derivative and a bound of the next allow.
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: longest
    real(dp), intent(out) :: time, lower           !! lower bound of the signal then
    type(weighted_sum) :: sum_of
    real(dp) :: rise, most
    integer :: i
    sum_of = weighted_sum(0.0_dp*self%u + 1.0_dp, 0.0_dp*self%u)
    rise = self%derivative(sum_of, moving_state(self%u, self%u_dot), self%order)
    most = sum(self%bound(self%u, self%u_dot, self%order + 1))
    if (allocated(self%polynomial)) then
      rise = rise + gamma(self%order + 1.0_dp)*self%polynomial(self%order)
      most = most + self%polynomial_bound(longest, self%order + 1)
    end if
    time = longest
    if (most > 0.5_dp*(self%order + 1)*rise/longest) time = max(0.0_dp, 0.5_dp*(self%order + 1)*rise/most)
    time = min(time, self%quarter())
    lower = 0.5_dp*rise
    do i = 1, self%order
      lower = lower*time/i
    end do
  end subroutine leave_zero

  pure function bound(self, u, u_dot, order)
    !! Bound a derivative of each term from a state on: for all times if β² > 0, by the energy, which never grows, or by
    !! the two exponentials if these are far apart; else for a quarter of 1/rate.
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: u(:), u_dot(:)
    integer, intent(in) :: order                   !! ≥ 2, or 0 where β² > 0; a uniform drift has none
    real(dp) :: bound(size(u)), fast, slow
    integer :: k
    bound = 0.0_dp
    do k = 1, size(u)
      associate (square => self%beta_squared(k)%hi, root => self%root(k)%hi, rate => self%rate(k))
        if (square > 0.0_dp) then
          bound(k) = sqrt(u(k)**2 + u_dot(k)**2/square)*rate**order
          if (self%turning(k) .or. 4.0_dp*root < self%c(k)) cycle
          fast = root + 0.5_dp*self%c(k)
          slow = square/fast
          bound(k) = (abs(u_dot(k) + fast*u(k))*slow**order + abs(u_dot(k) + slow*u(k))*fast**order)/(2.0_dp*root)
        else if (rate > 0.0_dp) then
          bound(k) = growth*(abs(u(k)) + abs(u_dot(k))/rate)*rate**order
        end if
      end associate
    end do
  end function bound

  pure real(dp) function polynomial_bound(self, time, order) result(bend)
    !! Bound a derivative of the polynomial within a time.
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: time
    integer, intent(in) :: order
    integer :: m
    bend = 0.0_dp
    do m = order, ubound(self%polynomial, 1)
      bend = bend + abs(self%polynomial(m))*gamma(m + 1.0_dp)/gamma(m - order + 1.0_dp)*time**(m - order)
    end do
  end function polynomial_bound

  pure subroutine move_polynomial(polynomial, time, change, slope)
    !! Find the change of a polynomial since time 0, and its slope.
    real(dp), intent(in) :: polynomial(0:)
    real(dp), intent(in) :: time
    real(dp), intent(out) :: change, slope
    real(dp) :: value
    integer :: m
    value = 0.0_dp
    slope = 0.0_dp
    do m = ubound(polynomial, 1), 1, -1
      slope = slope*time + value
      value = value*time + polynomial(m)
    end do
    slope = slope*time + value                     ! of (value)·time
    change = value*time
  end subroutine move_polynomial

  pure real(dp) function safe_step(self, value, drift, lift, u, u_dot, longest) result(step)
    !! Return a step within which the signal surely stays positive.
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: value, u(:), u_dot(:)
    real(dp), intent(in) :: drift, lift            !! slope of the polynomial, bound of its second derivative; 0: none
    real(dp), intent(in) :: longest                !! limit of the step
    real(dp), dimension(0:size(u)) :: slope, curvature   ! of terms without amplitude, and the first with one
    real(dp), dimension(size(u)) :: bend, swing
    logical :: oscillates(size(u))
    real(dp) :: above
    integer :: k, low
    oscillates = self%beta_squared%hi > 0.0_dp
    bend = self%bound(u, u_dot, 2)
    swing = merge(abs(u) + self%bound(u, u_dot, 0), 0.0_dp, oscillates)
    slope = [drift + sum(u_dot, mask=.not. oscillates), merge(u_dot, 0.0_dp, oscillates)]
    curvature = [lift + sum(bend, mask=.not. oscillates), merge(bend, 0.0_dp, oscillates)]
    do k = 1, size(u)
      slope(k) = slope(k) + slope(k - 1)
      curvature(k) = curvature(k) + curvature(k - 1)
    end do
    step = 0.0_dp
    above = value
    low = size(u)
    do
      step = max(step, parabola(above, slope(low), curvature(low), longest))
      if (low == 0) exit
      above = above - sum(swing(low/2 + 1:low))
      low = low/2
      if (above < 0.0_dp) exit                     ! more terms only lower it
    end do
    step = min(step, self%quarter())
  end function safe_step

  pure real(dp) function quarter(self)
    !! Return a quarter of the shortest time in which a term without amplitude changes.
    class(signal_type), intent(in) :: self
    real(dp) :: fast
    fast = maxval(self%rate, mask=self%beta_squared%hi <= 0.0_dp)
    quarter = huge(fast)
    if (fast > 0.0_dp) quarter = 0.25_dp/max(fast, 1.0_dp/huge(fast))
  end function quarter

  pure real(dp) function parabola(value, slope, curvature, longest) result(root)
    !! Return the first zero of value + slope h − ½ curvature h².
    real(dp), intent(in) :: value, slope, curvature, longest
    real(dp) :: both
    both = sqrt(slope**2 + 2.0_dp*curvature*value)
    if (slope >= 0.0_dp) then
      root = huge(1.0_dp)
      if (curvature > (slope + both)/longest) root = (slope + both)/curvature
    else
      root = 2.0_dp*value/(both - slope)
    end if
  end function parabola

end module bw_signal
