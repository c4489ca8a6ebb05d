module bw_signal
  !! A sum of modal motions, such as the gap between tip and mass or the force between them, and its first zero.
  !!
  !! The search skips nothing: from a time at which the signal is positive it steps as far as a bound proves that it stays
  !! so (bw_safe_step). Near a zero the steps are Newton's, from the left. Of a signal that is known within a margin it finds
  !! the first time at which it may be zero; `falls_through` tells whether it is so then for certain.
  use bw_double_double, only: accurate_sum, dd, to_dd
  use bw_kinds, only: dp
  use bw_modal_flow, only: flow
  use bw_monitor, only: monitor_type, stops
  use bw_precise_flow, only: increment
  use bw_safe_step, only: instant, instant_of, longest_step, quarter, safe_step
  implicit none (type, external)
  private

  type, public :: margin_type
    !! The smaller of two bounds of what errors of the state make of the signal, and the noise of computing it.
    integer :: order = 0                 !! of the first derivative of the signal whose value at the start is in doubt
    real(dp) :: first = 0.0_dp           !! the doubt of that derivative
    real(dp) :: next = 0.0_dp            !! a bound of the one after it
    real(dp) :: swing = 0.0_dp           !! a bound of what parts that turn may do
    real(dp) :: drift = 0.0_dp           !! of the rate of what parts that do not turn may do
    real(dp) :: growth = 0.0_dp          !! rate at which such parts grow
    real(dp) :: blur = 0.0_dp            !! rate at which errors of frequencies add to it
    real(dp) :: noise = 0.0_dp           !! of rounding
    real(dp) :: noise_rate = 0.0_dp      !! the same soon after the start, over the time since then
  contains
    procedure :: until
  end type margin_type

  type, public :: signal_type
    !! Parts u_k, each with ü + cu̇ + β²u = 0, ascending in frequency as far as they turn.
    type(dd), allocatable :: beta_squared(:)
    real(dp), allocatable :: c(:)
    real(dp), allocatable :: u(:), u_dot(:)        !! at the start
    real(dp) :: start = 0.0_dp                     !! the signal there; of the parts' sum, what rounding leaves is no matter
    real(dp) :: unit = 1.0_dp                      !! of all this: a power of two that keeps squares in range
    type(margin_type) :: margin                    !! within which it is known; 0 unless said
  contains
    procedure :: at
    procedure :: derivative
    procedure :: bound
    procedure :: first_zero
    procedure :: falls_through
  end type signal_type

  integer, parameter :: most_steps = 20000000      !! no search here takes nearly as many
  integer, parameter :: between_questions = 64     !! steps

contains

  elemental real(dp) function until(self, time) result(margin)
    !! A bound from the start to a time.
    class(margin_type), intent(in) :: self
    real(dp), intent(in) :: time                   !! since the start, ≥ 0
    real(dp) :: power, grown
    integer :: i
    power = 1.0_dp
    do i = 1, self%order
      power = power*time/i
    end do
    grown = time*exp(self%growth*time)
    margin = min(power*(self%first + self%next*grown/(self%order + 1)), self%swing + self%drift*grown) &
      + self%blur*grown + min(self%noise, self%noise_rate*time)
  end function until

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
    start = instant_of(self%beta_squared, self%c, 0.0_dp, self%u, self%u_dot)
    bound = sum(start%reach*start%rate**order)
  end function bound

  subroutine first_zero(self, start, longest, resolution, found, time, opening, monitor)
    !! The first time after `start`, within `resolution`, at which the signal falls to its margin.
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: start                  !! ≥ 0; the signal is positive there, or `opening` says that it rises
    real(dp), intent(in) :: longest                !! where the search ends
    real(dp), intent(in) :: resolution
    logical, intent(out) :: found
    real(dp), intent(out) :: time                  !! `longest` where none was found
    integer, intent(in), optional :: opening
      !! at time 0 the signal and its derivatives below this order are zero, and this one is positive
    class(monitor_type), intent(inout), optional :: monitor   !! none is found where it asks to stop
    real(dp) :: u(size(self%u)), u_dot(size(self%u)), step, lower, now, horizon
    integer :: i
    found = .false.
    time = start
    lower = 0.0_dp
    if (present(opening)) call open_signal(self, opening, longest, time, lower)
    do i = 1, most_steps
      if (time >= longest) exit
      if (mod(i, between_questions) == 0) then
        if (stops(monitor)) exit
      end if
      call self%at(to_dd(time), u, u_dot)
      horizon = horizon_of(self, time)
      now = max(accurate_increment(self, time), lower) - self%margin%until(horizon)
      lower = 0.0_dp
      step = 0.0_dp
      if (now > 0.0_dp) step = safe_step(instant_of(self%beta_squared, self%c, now, u, u_dot), min(longest, horizon) - time)
      time = time + step
      if (time >= longest) exit
      found = step < resolution
      if (found) return
    end do
    time = longest
  end subroutine first_zero

  pure real(dp) function horizon_of(self, time) result(horizon)
    !! To which the margin at a time is taken: no further than it may grow a little.
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: time
    real(dp) :: ahead
    ahead = time
    if (time == 0.0_dp) ahead = quarter/maxval(self%c + sqrt(abs(self%beta_squared%hi)))
    if (self%margin%growth > 0.0_dp) ahead = min(ahead, quarter/self%margin%growth)
    horizon = time + ahead
  end function horizon_of

  pure subroutine falls_through(self, time, sure, zero)
    !! Whether the signal, near the upper end of its margin, falls to below the lower end without a pause: then it has one
    !! zero on the way, and so has every signal that the margin leaves possible.
    class(signal_type), intent(in) :: self
    real(dp), intent(in) :: time                   !! as `first_zero` finds it
    logical, intent(out) :: sure
    real(dp), intent(out) :: zero                  !! a Newton step from where it has fallen through, where that is sure
    type(instant) :: now
    real(dp) :: u(size(self%u)), u_dot(size(self%u)), through, value, speed, slowest, margin
    integer, parameter :: most = 1000
    integer :: i
    sure = .false.
    zero = time
    through = time
    slowest = 0.0_dp
    margin = self%margin%until(horizon_of(self, time))
    do i = 1, most
      call self%at(to_dd(through), u, u_dot)
      value = accurate_increment(self, through)
      speed = -accurate_sum(u_dot)
      if (i == 1) slowest = 0.5_dp*speed
      sure = value < -margin .and. speed > slowest
      if (sure) zero = through + value/speed
      if (sure .or. speed <= slowest) return
      now = instant_of(self%beta_squared, self%c, value, u, u_dot)
      through = through + min(1.5_dp*(value + margin + tiny(1.0_dp))/speed, longest_step(now, 0.5_dp*(speed - slowest)))
    end do
  end subroutine falls_through

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

end module bw_signal
