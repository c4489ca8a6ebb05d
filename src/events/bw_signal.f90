module bw_signal
  !! A sum of modal motions, such as the gap between tip and mass or the force between them, and its first zero.
  !!
  !! The search skips nothing: from a time at which the signal is positive it steps as far as a bound proves that it stays
  !! so. With u the sum, its value and slope at hand, and |ü| ≤ B from the amplitudes, u > 0 as long as
  !! u + u̇h − ½Bh² > 0. Motions of high frequency are taken by their amplitude alone where that gives the longer step.
  !! Near a zero the steps are Newton's, from the left.
  use bw_double_double, only: accurate_sum, dd, dd_pi, sqrt, to_dd, operator(+), operator(-), operator(*), operator(/)
  use bw_kinds, only: dp
  use bw_modal_flow, only: flow, turning_square
  implicit none (type, external)
  private

  type, public :: signal_type
    !! Parts u_k, each with ü + cu̇ + β²u = 0, ascending in frequency as far as they turn.
    type(dd), allocatable :: beta_squared(:)
    real(dp), allocatable :: c(:)
    real(dp), allocatable :: u(:), u_dot(:)        !! at the start
    real(dp) :: start = 0.0_dp                     !! the signal there; of the parts' sum, what rounding leaves is no matter
  contains
    procedure :: at
    procedure :: derivative
    procedure :: bound
    procedure :: first_zero
  end type signal_type

  type :: instant
    !! What a step is made from.
    real(dp) :: value = 0.0_dp
    real(dp), allocatable :: u(:), u_dot(:), reach(:), rate(:)   !! of the parts; reach times rate^m bounds derivatives
    logical, allocatable :: turning(:)
  end type instant

  real(dp), parameter :: growth = exp(0.5_dp)      !! of a part that does not turn, over a quarter of 1/rate
  real(dp), parameter :: quarter = 0.25_dp
  integer, parameter :: most_steps = 20000000      !! no search here takes nearly as many

contains

  pure subroutine at(self, time, u, u_dot)
    !! The parts at a time.
    class(signal_type), intent(in) :: self
    type(dd), intent(in) :: time
    real(dp), intent(out) :: u(:), u_dot(:)
    u = self%u
    u_dot = self%u_dot
    call flow(self%beta_squared, self%c, time, u, u_dot)
  end subroutine at

  pure real(dp) function derivative(self, order)
    !! Of the signal at its start, order 0 … 3.
    class(signal_type), intent(in) :: self
    integer, intent(in) :: order
    real(dp) :: now(size(self%u)), next(size(self%u)), last(size(self%u))
    integer :: i
    now = self%u
    next = self%u_dot
    do i = 1, order
      last = now
      now = next
      next = -self%c*now - self%beta_squared%hi*last
    end do
    derivative = accurate_sum(now)
  end function derivative

  pure real(dp) function bound(self, order)
    !! Of a derivative over the first quarter of the shortest time in which a part that does not turn changes.
    class(signal_type), intent(in) :: self
    integer, intent(in) :: order
    type(instant) :: start
    start = instant_of(self, 0.0_dp, self%u, self%u_dot)
    bound = sum(start%reach*start%rate**order)
  end function bound

  pure type(instant) function instant_of(self, value, u, u_dot) result(now)
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: value, u(:), u_dot(:)
    type(dd) :: square(size(u))
    square = turning_square(self%beta_squared, self%c)
    now%value = value
    now%u = u
    now%u_dot = u_dot
    now%turning = square%hi > 0.0_dp
    now%rate = merge(sqrt(max(0.0_dp, self%beta_squared%hi)), self%c + sqrt(abs(self%beta_squared%hi)), now%turning)
    allocate (now%reach(size(u)))
    where (now%turning)
      now%reach = hypot(u, (u_dot + 0.5_dp*self%c*u)/sqrt(max(tiny(1.0_dp), square%hi)))
    elsewhere (now%rate > 0.0_dp)
      now%reach = growth*(abs(u) + abs(u_dot)/max(tiny(1.0_dp), now%rate))
    elsewhere
      now%reach = 0.0_dp                           ! a steady drift has no further derivatives
    end where
  end function instant_of

  pure real(dp) function safe_step(now, longest) result(step)
    !! How far the signal stays positive for certain.
    type(instant), intent(in) :: now
    real(dp), intent(in) :: longest
    real(dp) :: above, fast
    integer :: low, n
    n = size(now%u)
    fast = maxval(now%rate, mask=.not. now%turning .and. now%rate > 0.0_dp)
    step = 0.0_dp
    low = n
    do
      above = now%value - sum(now%reach(low + 1:) + abs(now%u(low + 1:)), mask=now%turning(low + 1:))
      if (above >= 0.0_dp) step = max(step, parabola(above, slope(low), curvature(low)))
      if (low == 0) exit
      low = low/2
    end do
    if (fast > 0.0_dp) step = min(step, quarter/fast)
    step = min(step, longest)
  contains
    pure real(dp) function slope(low)
      integer, intent(in) :: low
      slope = sum(now%u_dot(:low)) + sum(now%u_dot(low + 1:), mask=.not. now%turning(low + 1:))
    end function slope
    pure real(dp) function curvature(low)
      integer, intent(in) :: low
      curvature = sum(now%reach(:low)*now%rate(:low)**2) &
        + sum(now%reach(low + 1:)*now%rate(low + 1:)**2, mask=.not. now%turning(low + 1:))
    end function curvature
    pure real(dp) function parabola(value, slope, curvature) result(root)
      !! The first zero of value + slope h − ½ curvature h².
      real(dp), intent(in) :: value, slope, curvature
      real(dp) :: both
      both = sqrt(slope**2 + 2.0_dp*curvature*value)
      if (slope >= 0.0_dp) then
        root = huge(1.0_dp)
        if (curvature > (slope + both)/longest) root = (slope + both)/curvature
      else
        root = 2.0_dp*value/(both - slope)
      end if
    end function parabola
  end function safe_step

  pure subroutine first_zero(self, start, longest, resolution, found, time, opening)
    !! The first time after `start`, within `resolution`, at which the signal falls to zero.
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: start                  !! ≥ 0; the signal is positive there, or `opening` says that it rises
    real(dp), intent(in) :: longest                !! where the search ends
    real(dp), intent(in) :: resolution
    logical, intent(out) :: found
    real(dp), intent(out) :: time                  !! `longest` where none was found
    integer, intent(in), optional :: opening
      !! at time 0 the signal and its derivatives below this order are zero, and this one is positive
    real(dp) :: u(size(self%u)), u_dot(size(self%u)), step, lower, now
    integer :: i
    found = .false.
    time = start
    lower = 0.0_dp
    if (present(opening)) call open_signal(self, opening, longest, time, lower)
    do i = 1, most_steps
      if (time >= longest) exit
      call self%at(to_dd(time), u, u_dot)
      now = max(accurate_increment(self, time), lower)
      lower = 0.0_dp
      step = 0.0_dp
      if (now > 0.0_dp) step = safe_step(instant_of(self, now, u, u_dot), longest - time)
      time = time + step
      if (time >= longest) exit
      found = step < resolution
      if (found) return
    end do
    time = longest
  end subroutine first_zero

  pure subroutine open_signal(self, order, longest, time, lower)
    !! The first step from a zero: half of what the first derivative that is not zero and a bound of the next allow.
    class(signal_type), intent(in) :: self
    integer, intent(in) :: order
    real(dp), intent(in) :: longest
    real(dp), intent(out) :: time, lower
    real(dp) :: rise, most, fast
    integer :: i
    rise = self%derivative(order)
    most = self%bound(order + 1)
    fast = maxval(self%c + sqrt(abs(self%beta_squared%hi)))
    time = longest
    if (most > 0.5_dp*(order + 1)*rise/longest) time = 0.5_dp*(order + 1)*rise/most
    if (fast > 0.0_dp) time = min(time, quarter/fast)
    lower = 0.5_dp*rise
    do i = 1, order
      lower = lower*time/i
    end do
  end subroutine open_signal

  pure real(dp) function accurate_increment(self, time) result(value)
    !! The signal, as its start and what each part adds to it: near a zero at the start nothing is lost.
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: time
    value = self%start + accurate_sum(increment(self%beta_squared, self%c, self%u, self%u_dot, time))
  end function accurate_increment

  elemental real(dp) function increment(beta_squared, c, u, u_dot, time) result(change)
    !! u(t) − u(0).
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c, u, u_dot, time
    type(dd) :: square, root
    real(dp) :: x, less, sine, rate, now, now_dot
    square = turning_square(beta_squared, c)
    root = sqrt(square)
    if (square%hi <= 0.0_dp) root = sqrt(-square)
    x = root%hi*time
    if (square%hi <= 0.0_dp .and. x >= 1.0_dp) then
      now = u
      now_dot = u_dot
      call flow(beta_squared, c, to_dd(time), now, now_dot)
      change = now - u
      return
    end if
    sine = time
    if (square%hi > 0.0_dp) then
      x = reduced(root*time)
      less = -2.0_dp*sin(0.5_dp*x)**2                  ! cos x − 1
      sine = sin(x)/root%hi
    else
      less = 2.0_dp*sinh(0.5_dp*x)**2                  ! cosh x − 1
      if (x > 0.0_dp) sine = sinh(x)/root%hi
    end if
    rate = u_dot + 0.5_dp*c*u
    change = u*less + rate*sine
    if (c > 0.0_dp) change = change - 2.0_dp*exp(-0.25_dp*c*time)*sinh(0.25_dp*c*time)*(u + change)
  end function increment

  elemental real(dp) function reduced(phase) result(angle)
    !! A phase less whole turns.
    type(dd), intent(in) :: phase
    type(dd) :: turns
    angle = phase%hi
    if (abs(phase%hi) < 1.0_dp) return
    turns = phase/(dd_pi*2.0_dp)
    angle = 2.0_dp*dd_pi%hi*((turns%hi - anint(turns%hi)) + turns%lo)
  end function reduced

end module bw_signal
