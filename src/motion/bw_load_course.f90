module bw_load_course
  !! How a load varies in time. Between two knots it is a + bτ + Re(c e^(iΩτ)), τ the time since the first of them; before the first knot
  !! and from the last one on it is 0. Pulses and tones are exponentials, what is measured is linear between its samples.
  !!
  !! Times in l²/h, the load in N or m/s².
  use bw_constants, only: pi, two_pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: course_of_samples, course_of_shape, end_jump, impulse_of, interval_at, lag_bound, largest_load, rates_of, scaled_course

  type, public :: load_course
    real(dp), allocatable :: knot(:)               !! ascending, (0:intervals)
    real(dp), allocatable :: constant(:)           !! a, (intervals)
    real(dp), allocatable :: slope(:)              !! b, (intervals)
    complex(dp), allocatable :: tone(:)            !! c, (intervals)
    real(dp) :: frequency = 0.0_dp                 !! Ω; 0: there is no tone
  end type load_course

contains

  pure type(load_course) function course_of_shape(shape, amplitude, start, duration, frequency) result(course)
    !! A pulse or a tone.
    character(*), intent(in) :: shape              !! half_sine, haversine, triangle, rectangle or sine
    real(dp), intent(in) :: amplitude              !! its largest value
    real(dp), intent(in) :: start, duration        !! duration > 0
    real(dp), intent(in) :: frequency              !! of a sine, turns in a unit of time
    complex(dp), parameter :: sine = (0.0_dp, -1.0_dp)
    course%knot = start + [0.0_dp, duration]
    course%constant = [0.0_dp]
    course%slope = [0.0_dp]
    course%tone = [(0.0_dp, 0.0_dp)]
    select case (shape)
    case ('half_sine')
      course%tone = amplitude*sine
      course%frequency = pi/duration
    case ('haversine')
      course%constant = 0.5_dp*amplitude
      course%tone = -0.5_dp*amplitude
      course%frequency = two_pi/duration
    case ('triangle')
      course%knot = start + duration*[0.0_dp, 0.5_dp, 1.0_dp]
      course%constant = [0.0_dp, amplitude]
      course%slope = [1.0_dp, -1.0_dp]*(2.0_dp*amplitude/duration)
      course%tone = [(0.0_dp, 0.0_dp), (0.0_dp, 0.0_dp)]
    case ('sine')
      course%tone = amplitude*sine
      course%frequency = two_pi*frequency
    case default
      course%constant = amplitude
    end select
    call begin_rotation(course)
  end function course_of_shape

  pure type(load_course) function course_of_samples(times, values) result(course)
    !! Straight lines between samples. What lies before t = 0 is left out.
    real(dp), intent(in) :: times(:), values(:)    !! ascending times, two or more
    integer :: n
    n = size(times)
    course%knot = times
    course%constant = values(:n - 1)
    course%slope = (values(2:) - values(:n - 1))/(times(2:) - times(:n - 1))
    course%tone = spread((0.0_dp, 0.0_dp), 1, n - 1)
    call begin_rotation(course)
  end function course_of_samples

  pure subroutine begin_rotation(course)
    !! Bounds of the knots from 0, and the part of a load that acts from t = 0 on: the beam is at rest until then.
    type(load_course), intent(inout) :: course
    real(dp) :: late
    integer :: first, n
    n = size(course%constant)
    first = max(1, count(course%knot(:n) <= 0.0_dp))
    late = max(0.0_dp, -course%knot(first))
    course%knot = course%knot(first:)
    course%constant = course%constant(first:)
    course%slope = course%slope(first:)
    course%tone = course%tone(first:)
    course%knot(1) = max(0.0_dp, course%knot(1))
    if (course%knot(2) <= 0.0_dp) then             ! it is over by then
      course%constant = 0.0_dp
      course%slope = 0.0_dp
      course%tone = 0.0_dp
      course%knot(2) = 1.0_dp
    else
      course%constant(1) = course%constant(1) + course%slope(1)*late
      course%tone(1) = course%tone(1)*exp(cmplx(0.0_dp, course%frequency*late, dp))
    end if
  end subroutine begin_rotation

  pure integer function interval_at(course, time) result(i)
    !! Which interval a time is in, its start included; 0 before the first, one more than there are after the last.
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

  pure subroutine rates_of(course, i, time, level, slope, tone)
    !! The load in an interval from a time on: a + bs + Re(c e^(iΩs)).
    type(load_course), intent(in) :: course
    integer, intent(in) :: i                       !! the interval
    real(dp), intent(in) :: time
    real(dp), intent(out) :: level, slope
    complex(dp), intent(out) :: tone
    level = 0.0_dp
    slope = 0.0_dp
    tone = 0.0_dp
    if (i < 1 .or. i > size(course%constant)) return
    associate (since => time - course%knot(i))
      level = course%constant(i) + course%slope(i)*since
      slope = course%slope(i)
      if (course%frequency > 0.0_dp) tone = course%tone(i)*exp(cmplx(0.0_dp, course%frequency*since, dp))
    end associate
  end subroutine rates_of

  elemental type(load_course) function scaled_course(course, factor) result(scaled)
    !! So many times the load.
    type(load_course), intent(in) :: course
    real(dp), intent(in) :: factor
    scaled = course
    scaled%constant = factor*course%constant
    scaled%slope = factor*course%slope
    scaled%tone = factor*course%tone
  end function scaled_course

  elemental real(dp) function impulse_of(course) result(impulse)
    !! The load's integral over time.
    type(load_course), intent(in) :: course
    complex(dp), parameter :: unit = (0.0_dp, 1.0_dp)
    integer :: i
    impulse = 0.0_dp
    do i = 1, size(course%constant)
      associate (length => course%knot(i + 1) - course%knot(i), w => course%frequency)
        impulse = impulse + length*(course%constant(i) + 0.5_dp*length*course%slope(i))
        if (w > 0.0_dp) impulse = impulse + real(course%tone(i)*(exp(unit*w*length) - 1.0_dp)/(unit*w))
      end associate
    end do
  end function impulse_of

  pure real(dp) function end_jump(course, until) result(jump)
    !! By how much a load that is linear between its knots is not 0 where it begins and ends.
    type(load_course), intent(in) :: course
    real(dp), intent(in) :: until                  !! the end of the record: what comes later is not seen
    integer :: n
    n = size(course%constant)
    jump = 0.0_dp
    if (course%knot(1) < until) jump = abs(course%constant(1))
    if (course%knot(n + 1) < until) &
      jump = max(jump, abs(course%constant(n) + course%slope(n)*(course%knot(n + 1) - course%knot(n))))
  end function end_jump

  elemental real(dp) function largest_load(course) result(largest)
    !! The largest magnitude, of a tone beside something else a bound of it.
    type(load_course), intent(in) :: course
    integer :: i
    largest = 0.0_dp
    do i = 1, size(course%constant)
      associate (last => course%constant(i) + course%slope(i)*(course%knot(i + 1) - course%knot(i)))
        largest = max(largest, abs(course%constant(i)) + abs(course%tone(i)), abs(last) + abs(course%tone(i)))
      end associate
    end do
  end function largest_load

  pure real(dp) function lag_bound(course, until, lag, drift) result(bound)
    !! By how much a mode's β²q may at most differ from the load f that drives it, −∫y(t − s) df(s), y its free motion from 1 at rest.
    !! With the integrals G_1(u) = ∫_u^∞ y, G_(j+1) = ∫_u^∞ G_j, none of which exceeds e^j, e = 1/β + c/β², and G_1(0) = c/β², it is for
    !! every m at most Σ_(j≤m) J_j e^j + Σ_(1≤j≤m) |G_j(0)| S_j + C_m e^m: J the jumps of the load's derivatives, S their largest
    !! magnitudes, C the variation of the last between jumps.
    type(load_course), intent(in) :: course
    real(dp), intent(in) :: until                  !! the end of the record
    real(dp), intent(in) :: lag, drift             !! e, c/β²
    integer, parameter :: most = 3
    real(dp) :: jump(0:most), largest(0:most), variation(0:most), before(0:most), at_rest(0:most)
    integer :: i, m
    jump = 0.0_dp
    variation = 0.0_dp
    largest = 0.0_dp
    before = 0.0_dp
    do i = 1, size(course%constant)
      if (course%knot(i) >= until) exit
      jump = jump + abs(derivatives(course, i, course%knot(i)) - before)
      associate (length => course%knot(i + 1) - course%knot(i), w => course%frequency, tone => abs(course%tone(i)))
        variation(0) = variation(0) + length*abs(course%slope(i))
        variation = variation + length*tone*w**[(m + 1, m=0, most)]
        largest(1:) = max(largest(1:), tone*w**[(m, m=1, most)] + [abs(course%slope(i)), (0.0_dp, m=2, most)])
      end associate
      before = derivatives(course, i, course%knot(i + 1))
    end do
    if (course%knot(size(course%knot)) < until) jump = jump + abs(before)
    at_rest = [0.0_dp, drift, (lag**m, m=2, most)]
    bound = minval([(sum(jump(:m)*lag**[(i, i=0, m)] + at_rest(:m)*largest(:m)) + variation(m)*lag**m, m=0, most)])
  contains
    pure function derivatives(course, i, time) result(values)
      !! The load and its derivatives.
      type(load_course), intent(in) :: course
      integer, intent(in) :: i
      real(dp), intent(in) :: time
      real(dp) :: values(0:most)
      complex(dp) :: tone
      integer :: j
      call rates_of(course, i, time, values(0), values(1), tone)
      values(2:) = 0.0_dp
      do j = 0, most
        values(j) = values(j) + real(tone*cmplx(0.0_dp, course%frequency, dp)**j)
      end do
    end function derivatives
  end function lag_bound

end module bw_load_course
