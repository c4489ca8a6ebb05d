module bw_acting_loads
  !! Loads on a beam and on a mass beside it, in contact or not.
  !!
  !! In a contact loads are polynomials in each step through Chebyshev points, like the contact force. In flight the gap
  !! is a sum of free motions, whose zeros bw_signal finds, and a polynomial due to loads, for a short time. Oscillators
  !! with high frequencies follow a load in closed form, and move freely about that; the others, from rest, as a power
  !! series. Units of bw_segment.
  use bw_double_double, only: to_dd, operator(+)
  use bw_force_response, only: force_degree
  use bw_force_step, only: force_step, last_coefficient, node_places
  use bw_kinds, only: dp
  use bw_load_course, only: interval_at, largest_load, load_course, next_knot, part_of_course, rates_of
  use bw_load_step, only: load_step, load_step_of
  use bw_oscillators, only: moving_state, oscillators
  implicit none (type, external)
  private

  integer, parameter, public :: gap_degree = 16    !! of the gap due to loads in a short interval
  integer, parameter :: load_degree = 1            ! of loads, besides tones
  real(dp), parameter :: calm = 0.25_dp            ! rad, limit of power series of that degree to rounding
  complex(dp), parameter :: i_unit = (0.0_dp, 1.0_dp)

  type, public :: acting_loads
    type(load_course), allocatable :: course(:)    !! m_iV h/l², (loads)
    real(dp), allocatable :: drive(:, :)           !! acceleration of each oscillator under a load of 1, (oscillators, loads)
    real(dp), allocatable :: residual(:)           !! quasi-static opening of the gap by omitted modes under a load of 1
    real(dp), private :: slow = 0.0_dp             !! limit of |β²| for power series
    real(dp), private :: calm_time = 0.0_dp
    type(load_step), private :: step               !! of that interval, once needed
  contains
    procedure :: begin
    procedure :: calm_until
    procedure :: next
    procedure :: gap
    procedure :: pace
    procedure :: in_step
    procedure :: see
    procedure :: take_out
    procedure :: move
  end type acting_loads

contains

  pure subroutine begin(self, parts)
    !! Set the limit of power series and the length of intervals.
    class(acting_loads), intent(inout) :: self
    type(oscillators), intent(in) :: parts
    real(dp) :: fastest
    fastest = max(1.0_dp, maxval(self%course%frequency))
    self%slow = max(1.0_dp, 4.0_dp*maxval(self%course%frequency)**2)
    self%calm_time = calm/max(fastest, maxval(parts%c, mask=abs(parts%beta_squared%hi) <= self%slow))
  end subroutine begin

  pure real(dp) function calm_until(self, time)
    !! Return the end of an interval from now on with smooth loads.
    class(acting_loads), intent(in) :: self
    real(dp), intent(in) :: time
    calm_until = min(time + self%calm_time, self%next(time))
  end function calm_until

  pure real(dp) function next(self, time)
    !! Return the next knot of any load.
    class(acting_loads), intent(in) :: self
    real(dp), intent(in) :: time
    next = next_knot(self%course, time)
  end function next

  pure real(dp) function gap(self, time, order)
    !! Return the quasi-static contribution of omitted modes to the gap, or to its rate.
    class(acting_loads), intent(in) :: self
    real(dp), intent(in) :: time
    integer, intent(in) :: order                   !! 0 or 1
    real(dp) :: load(0:gap_degree, size(self%course))
    load = powers_from(self, time)
    gap = dot_product(self%residual, load(order, :))
  end function gap

  pure real(dp) function pace(self, parts, weight)
    !! Estimate the speed of the gap under suddenly applied loads, with all oscillators out of phase.
    class(acting_loads), intent(in) :: self
    type(oscillators), intent(in) :: parts
    real(dp), intent(in) :: weight(:)              !! in the gap, (oscillators)
    pace = norm2(weight*matmul(self%drive, largest_load(self%course))/sqrt(max(1.0_dp, abs(parts%beta_squared%hi))))
  end function pace

  pure function powers_from(self, time) result(load)
    !! Return loads from a time on as power series, (0:degree, loads).
    class(acting_loads), intent(in) :: self
    real(dp), intent(in) :: time
    real(dp) :: load(0:gap_degree, size(self%course))
    complex(dp) :: tone
    integer :: l
    do l = 1, size(self%course)
      associate (course => self%course(l))
        call rates_of(course, interval_at(course, time), time, load(:, l), tone)
        load(:, l) = load(:, l) + tone_powers(course%frequency, tone)
      end associate
    end do
  end function powers_from

  pure function tone_powers(frequency, tone) result(powers)
    !! Return the power series of Re(c e^(iΩs)).
    real(dp), intent(in) :: frequency
    complex(dp), intent(in) :: tone
    real(dp) :: powers(0:gap_degree)
    complex(dp) :: term
    integer :: m
    term = tone
    do m = 0, gap_degree
      powers(m) = real(term)
      term = term*i_unit*frequency/(m + 1)
    end do
  end function tone_powers

  subroutine in_step(self, time, length, load, slope, lack)
    !! Return loads and their rates at the start and the points of a step in which they are smooth.
    class(acting_loads), intent(in) :: self
    real(dp), intent(in) :: time, length
    real(dp), intent(out) :: load(0:, :), slope(0:, :)   !! (0:points, loads)
    real(dp), intent(out) :: lack                  !! error of their polynomials through these points over their largest values
    real(dp) :: power(0:load_degree)
    complex(dp) :: tone
    integer :: l
    lack = 0.0_dp
    do l = 1, size(self%course)
      associate (course => self%course(l), s => length*node_places)
        call rates_of(course, interval_at(course, time), time, power, tone)
        load(:, l) = power(0) + power(1)*s + real(tone*exp(i_unit*course%frequency*s))
        slope(:, l) = power(1) + real(i_unit*course%frequency*tone*exp(i_unit*course%frequency*s))
        lack = max(lack, last_coefficient(load(:, l))/max(largest_load(course), tiny(lack)))
      end associate
    end do
  end subroutine in_step

  pure function see(self, step, load, slope) result(approach)
    !! Return the contribution of loads to the approach and its rate at the points of a step, (points, 2).
    class(acting_loads), intent(in) :: self
    type(force_step), intent(in) :: step           !! with operators of these loads
    real(dp), intent(in) :: load(0:, :), slope(0:, :)   !! see `in_step`
    real(dp) :: approach(force_degree, 2)
    integer :: l
    approach(:, 1) = -matmul(load(1:, :), self%residual)
    approach(:, 2) = -matmul(slope(1:, :), self%residual)
    do l = 1, size(self%course)
      approach(:, 1) = approach(:, 1) - matmul(step%load_compliance(:, :, l), load(:, l))
      approach(:, 2) = approach(:, 2) - matmul(step%load_rate_compliance(:, :, l), load(:, l))
    end do
  end function see

  pure subroutine take_out(self, parts, weight, state, free, polynomial)
    !! Split the gap, from a state on, into free motions from another state and a polynomial in time.
    class(acting_loads), intent(in) :: self
    type(oscillators), intent(in) :: parts
    real(dp), intent(in) :: weight(:)              !! in the gap, (oscillators)
    type(moving_state), intent(in) :: state
    type(moving_state), intent(out) :: free
    real(dp), intent(out) :: polynomial(0:gap_degree)
    real(dp), dimension(0:gap_degree, size(self%course)) :: load, straight
    real(dp), dimension(0:gap_degree) :: driven, moved
    complex(dp) :: tone(size(self%course)), part
    integer :: k, l, m
    free = state
    load = powers_from(self, state%time%hi)
    polynomial = matmul(load, self%residual)
    do l = 1, size(self%course)
      call rates_of(self%course(l), interval_at(self%course(l), state%time%hi), state%time%hi, straight(:, l), tone(l))
    end do
    do k = 1, size(weight)
      associate (square => parts%beta_squared(k)%hi, c => parts%c(k))
        moved = 0.0_dp
        if (abs(square) <= self%slow) then
          driven = matmul(load, self%drive(k, :))
          do m = 0, gap_degree - 2
            moved(m + 2) = (driven(m) - (m + 1)*c*moved(m + 1) - square*moved(m))/((m + 1)*(m + 2))
          end do
        else
          do l = 1, size(self%course)
            moved(0) = moved(0) + self%drive(k, l)*(straight(0, l) - c*straight(1, l)/square)/square
            moved(1) = moved(1) + self%drive(k, l)*straight(1, l)/square
            associate (frequency => self%course(l)%frequency)
              part = self%drive(k, l)*tone(l)/cmplx(square - frequency**2, c*frequency, dp)
              moved = moved + tone_powers(frequency, part)
            end associate
          end do
          free%u(k) = free%u(k) - moved(0)
          free%v(k) = free%v(k) - moved(1)
        end if
        polynomial = polynomial + weight(k)*moved
      end associate
    end do
  end subroutine take_out

  subroutine move(self, parts, time, state)
    !! Move the state forward within an interval of smooth loads.
    class(acting_loads), intent(inout) :: self
    type(oscillators), intent(in) :: parts
    real(dp), intent(in) :: time
    type(moving_state), intent(inout) :: state
    real(dp) :: power(0:load_degree, size(self%course))
    complex(dp) :: tone(size(self%course))
    type(load_step) :: odd
    integer :: l
    if (time <= 0.0_dp) return
    associate (now => state%time%hi)
      do l = 1, size(self%course)
        call part_of_course(self%course(l), interval_at(self%course(l), now), now, now + time, power(:, l), tone(l))
      end do
    end associate
    if (abs(time - self%calm_time) <= 4.0_dp*epsilon(time)*(state%time%hi + time)) then
      if (self%step%length < 0.0_dp) self%step = load_step_of(parts%beta_squared, parts%c, to_dd(self%calm_time), &
                                                              self%course%frequency, load_degree)
      call self%step%advance(self%drive, power, tone, state%u, state%v)
    else
      odd = load_step_of(parts%beta_squared, parts%c, to_dd(time), self%course%frequency, load_degree)
      call odd%advance(self%drive, power, tone, state%u, state%v)
    end if
    state%time = state%time + time
  end subroutine move

end module bw_acting_loads
