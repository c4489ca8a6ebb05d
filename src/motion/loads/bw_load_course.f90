module bw_load_course
  !! A load as a function of time. Between two knots it is Σb_jx^j + Re(c e^(iΩτ)), with x from −1 to 1 and τ the time since the
  !! first of them; it is 0 before the first knot and from the last one on. Pulses and tones are exponentials, measured loads
  !! are linear between samples, and a contact force is a polynomial in each step. Times in l²/h, loads in N.
  use bw_constants, only: pi, two_pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: course_of_samples, course_of_shape, degree_of, end_jump, impulse_of, interval_at, is_over, lag_bound, largest_load
  public :: loads_before, next_knot, part_of_course, rates_of, scaled_course

  type, public :: load_course
    real(dp), allocatable :: knot(:)               !! ascending, (intervals + 1)
    real(dp), allocatable :: power(:, :)           !! b_j, (0:degree, intervals), degree ≥ 1
    complex(dp), allocatable :: tone(:)            !! c, (intervals)
    real(dp) :: frequency = 0.0_dp                 !! Ω; 0: no tone
    real(dp) :: left_out = 0.0_dp                  !! impulse before t = 0, which is cut off
  end type load_course

contains

  pure type(load_course) function course_of_shape(shape, amplitude, start, duration, frequency) result(course)
    !! Return a pulse or a tone.
    character(*), intent(in) :: shape              !! half_sine, haversine, triangle, rectangle or sine
    real(dp), intent(in) :: amplitude              !! largest value
    real(dp), intent(in) :: start, duration        !! duration > 0
    real(dp), intent(in) :: frequency              !! of a sine, cycles in a unit of time
    complex(dp), parameter :: sine = (0.0_dp, -1.0_dp)
    real(dp) :: constant
    constant = 0.0_dp
    course%knot = start + [0.0_dp, duration]
    course%tone = [(0.0_dp, 0.0_dp)]
    select case (shape)
    case ('half_sine')
      course%tone = amplitude*sine
      course%frequency = pi/duration
    case ('haversine')
      constant = 0.5_dp*amplitude
      course%tone = -0.5_dp*amplitude
      course%frequency = two_pi/duration
    case ('triangle')
      course = course_of_samples(start + duration*[0.0_dp, 0.5_dp, 1.0_dp], amplitude*[0.0_dp, 1.0_dp, 0.0_dp])
      return
    case ('sine')
      course%tone = amplitude*sine
      course%frequency = two_pi*frequency
    case default
      constant = amplitude
    end select
    allocate (course%power(0:1, 1), source=0.0_dp)
    course%power(0, 1) = constant
    call begin_at_rest(course)
  end function course_of_shape

  pure type(load_course) function course_of_samples(times, values) result(course)
    !! Return the linear interpolation of samples, without what lies before t = 0.
    real(dp), intent(in) :: times(:), values(:)    !! ascending times, at least two
    integer :: n
    n = size(times)
    course%knot = times
    allocate (course%power(0:1, n - 1))
    course%power(0, :) = 0.5_dp*(values(2:) + values(:n - 1))
    course%power(1, :) = 0.5_dp*(values(2:) - values(:n - 1))
    course%tone = spread((0.0_dp, 0.0_dp), 1, n - 1)
    call begin_at_rest(course)
  end function course_of_samples

  pure subroutine begin_at_rest(course)
    !! Cut off the load before t = 0, as the beam is at rest until then.
    type(load_course), intent(inout) :: course
    type(load_course) :: whole
    integer :: first, n
    n = size(course%tone)
    if (course%knot(1) >= 0.0_dp) return
    whole = course
    first = count(whole%knot(:n) <= 0.0_dp)
    deallocate (course%power)
    allocate (course%power(0:1, n - first + 1))
    course%knot = whole%knot(first:)
    course%tone = whole%tone(first:)
    course%power(:, :) = whole%power(:, first:)
    course%knot(1) = 0.0_dp
    if (course%knot(2) <= 0.0_dp) then             ! all of it is cut off
      course%power = 0.0_dp
      course%tone = 0.0_dp
      course%knot(2) = 1.0_dp
    else
      call part_of_course(whole, first, 0.0_dp, course%knot(2), course%power(:, 1), course%tone(1))
    end if
    course%left_out = impulse_of(whole) - impulse_of(course)
  end subroutine begin_at_rest

  elemental logical function is_over(course)
    !! Return whether all of a load lies before t = 0.
    type(load_course), intent(in) :: course
    is_over = course%left_out /= 0.0_dp .and. largest_load(course) <= 0.0_dp
  end function is_over

  pure integer function degree_of(course) result(degree)
    !! Return the largest degree of some loads.
    type(load_course), intent(in) :: course(:)
    integer :: l
    degree = maxval([1, (ubound(course(l)%power, 1), l=1, size(course))])
  end function degree_of

  pure integer function interval_at(course, time) result(i)
    !! Return the interval of a time, including its start; 0 before the first, one more than the last after it.
    type(load_course), intent(in) :: course
    real(dp), intent(in) :: time
    integer :: above, middle
    i = 0
    above = size(course%knot) + 1
    do while (above - i > 1)
      middle = (i + above)/2
      if (course%knot(middle) <= time) then
        i = middle
      else
        above = middle
      end if
    end do
  end function interval_at

  pure real(dp) function next_knot(course, time) result(knot)
    !! Return the first knot of any load after a time.
    type(load_course), intent(in) :: course(:)
    real(dp), intent(in) :: time
    integer :: i, l
    knot = huge(knot)
    do l = 1, size(course)
      i = interval_at(course(l), time) + 1
      if (i <= size(course(l)%knot)) knot = min(knot, course(l)%knot(i))
    end do
  end function next_knot

  pure subroutine rates_of(course, i, time, power, tone)
    !! Return the load in an interval from a time on: Σb_js^j + Re(c e^(iΩs)), s the time since then.
    type(load_course), intent(in) :: course
    integer, intent(in) :: i                       !! the interval
    real(dp), intent(in) :: time
    real(dp), intent(out) :: power(0:)             !! of the size of the load's, or larger
    complex(dp), intent(out) :: tone
    call look_at(course, i, time, time, 1.0_dp, power, tone)
  end subroutine rates_of

  pure function loads_before(course, time) result(load)
    !! Return loads and their rates just before a time, (loads, 2).
    type(load_course), intent(in) :: course(:)
    real(dp), intent(in) :: time
    real(dp) :: load(size(course), 2)
    real(dp), allocatable :: power(:)
    complex(dp) :: tone
    integer :: l
    allocate (power(0:degree_of(course)))
    do l = 1, size(course)
      call rates_of(course(l), interval_at(course(l), nearest(time, -1.0_dp)), time, power, tone)
      load(l, :) = [power(0) + real(tone), power(1) - course(l)%frequency*aimag(tone)]
    end do
  end function loads_before

  pure subroutine part_of_course(course, i, from, to, power, tone)
    !! Return the load in part of an interval: Σb_jx^j + Re(c e^(iΩs)), x from −1 to 1 in it, s the time since its start.
    type(load_course), intent(in) :: course
    integer, intent(in) :: i                       !! the interval
    real(dp), intent(in) :: from, to
    real(dp), intent(out) :: power(0:)             !! of the size of the load's, or larger
    complex(dp), intent(out) :: tone
    call look_at(course, i, from, 0.5_dp*(from + to), 0.5_dp*(to - from), power, tone)
  end subroutine part_of_course

  pure subroutine look_at(course, i, from, middle, unit, power, tone)
    !! Return the polynomial in the time since `middle`, in units of `unit`, and the tone from a time on.
    type(load_course), intent(in) :: course
    integer, intent(in) :: i
    real(dp), intent(in) :: from, middle, unit
    real(dp), intent(out) :: power(0:)
    complex(dp), intent(out) :: tone
    real(dp) :: half, away
    integer :: degree, j, m
    power = 0.0_dp
    tone = 0.0_dp
    if (i < 1 .or. i > size(course%tone)) return
    degree = ubound(course%power, 1)
    half = 0.5_dp*(course%knot(i + 1) - course%knot(i))
    away = (middle - 0.5_dp*(course%knot(i + 1) + course%knot(i)))/half
    power(:degree) = course%power(:, i)
    do j = 0, degree - 1                           ! shift of the origin by Horner's scheme
      do m = degree - 1, j, -1
        power(m) = power(m) + away*power(m + 1)
      end do
    end do
    do j = 1, degree
      power(j) = power(j)*(unit/half)**j
    end do
    if (course%frequency > 0.0_dp) tone = course%tone(i)*exp(cmplx(0.0_dp, course%frequency*(from - course%knot(i)), dp))
  end subroutine look_at

  elemental type(load_course) function scaled_course(course, factor) result(scaled)
    !! Return a load times a factor.
    type(load_course), intent(in) :: course
    real(dp), intent(in) :: factor
    scaled = course
    scaled%power = factor*course%power
    scaled%tone = factor*course%tone
  end function scaled_course

  elemental real(dp) function impulse_of(course) result(impulse)
    !! Return the integral of a load over time.
    type(load_course), intent(in) :: course
    complex(dp), parameter :: unit = (0.0_dp, 1.0_dp)
    integer :: i, j
    impulse = 0.0_dp
    do i = 1, size(course%tone)
      associate (length => course%knot(i + 1) - course%knot(i), w => course%frequency)
        impulse = impulse + length*sum([(course%power(j, i)/(j + 1), j=0, ubound(course%power, 1), 2)])
        if (w > 0.0_dp) impulse = impulse + real(course%tone(i)*(exp(unit*w*length) - 1.0_dp)/(unit*w))
      end associate
    end do
  end function impulse_of

  pure real(dp) function end_jump(course, until) result(jump)
    !! Return the jump at the ends of a piecewise linear load, beyond rounding.
    type(load_course), intent(in) :: course
    real(dp), intent(in) :: until                  !! end of the record
    integer :: n
    n = size(course%tone)
    jump = 0.0_dp
    if (course%knot(1) < until) jump = abs(course%power(0, 1) - course%power(1, 1))
    if (course%knot(n + 1) < until) jump = max(jump, abs(course%power(0, n) + course%power(1, n)))
    if (jump <= 16*epsilon(jump)*largest_load(course)) jump = 0.0_dp
  end function end_jump

  elemental real(dp) function largest_load(course) result(largest)
    !! Return the largest magnitude of a piecewise linear load; with a tone a bound of it.
    type(load_course), intent(in) :: course
    integer :: i
    largest = 0.0_dp
    do i = 1, size(course%tone)
      largest = max(largest, abs(course%power(0, i)) + abs(course%power(1, i)) + abs(course%tone(i)))
    end do
  end function largest_load

  pure real(dp) function lag_bound(course, until, lag, drift) result(bound)
    !! Bound the difference between a mode's β²q and the load f that drives it, −∫y(t − s) df(s), with y its free motion from 1
    !! at rest. The integrals G_1(u) = ∫_u^∞ y, G_(j+1) = ∫_u^∞ G_j are at most e^j, e = 1/β + c/β², and G_1(0) = c/β². So the
    !! bound is, for every m, Σ_(j≤m) J_j e^j + Σ_(1≤j≤m) |G_j(0)| S_j + C_m e^m, with the jumps J of the load's derivatives,
    !! their largest magnitudes S, and the variation C of the last between jumps. For piecewise linear loads and tones.
    type(load_course), intent(in) :: course
    real(dp), intent(in) :: until                  !! end of the record
    real(dp), intent(in) :: lag, drift             !! e, c/β²
    integer, parameter :: most = 3
    real(dp) :: jump(0:most), largest(0:most), variation(0:most), before(0:most), at_rest(0:most)
    integer :: i, m
    jump = 0.0_dp
    variation = 0.0_dp
    largest = 0.0_dp
    before = 0.0_dp
    do i = 1, size(course%tone)
      if (course%knot(i) >= until) exit
      jump = jump + abs(derivatives(course, i, course%knot(i)) - before)
      associate (length => course%knot(i + 1) - course%knot(i), w => course%frequency, tone => abs(course%tone(i)))
        variation(0) = variation(0) + 2.0_dp*abs(course%power(1, i))
        variation = variation + length*tone*w**[(m + 1, m=0, most)]
        largest(1:) = max(largest(1:), tone*w**[(m, m=1, most)] + [2.0_dp*abs(course%power(1, i))/length, (0.0_dp, m=2, most)])
      end associate
      before = derivatives(course, i, course%knot(i + 1))
    end do
    if (course%knot(size(course%knot)) < until) jump = jump + abs(before)
    at_rest = [0.0_dp, drift, (lag**m, m=2, most)]
    bound = minval([(sum(jump(:m)*lag**[(i, i=0, m)] + at_rest(:m)*largest(:m)) + variation(m)*lag**m, m=0, most)])
  contains
    pure function derivatives(course, i, time) result(values)
      !! Return the load and its derivatives.
      type(load_course), intent(in) :: course
      integer, intent(in) :: i
      real(dp), intent(in) :: time
      real(dp) :: values(0:most)
      complex(dp) :: tone
      integer :: j
      call rates_of(course, i, time, values, tone)
      do j = 0, most
        values(j) = values(j) + real(tone*cmplx(0.0_dp, course%frequency, dp)**j)
      end do
    end function derivatives
  end function lag_bound

end module bw_load_course
