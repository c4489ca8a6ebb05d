module bw_response_extremes
  !! Where the response to a harmonic force is largest, with the width of that, and where its parts cancel. It can be had at any
  !! frequency, and modes tell where to look, so that nothing depends on the frequencies that were asked for.
  !!
  !! A resonance is the largest value near a mode, within twice the width c_k of its damping and half way to the next, if it falls to half
  !! of its power on one side at least; of an undamped mode it is a pole. Between neighbours, but for these widths, Re H changes sign at
  !! antiresonances. **Limit**: those that lie within the width of a mode are not found, and neither are two between two samples.
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_monitor, only: monitor_type
  implicit none (type, external)
  private
  public :: find_extremes

  type, abstract, public :: harmonic_response
    !! The displacements of points under a harmonic force.
  contains
    procedure(at_interface), deferred :: at
  end type harmonic_response

  abstract interface
    subroutine at_interface(self, omega, value)
      import :: dp, harmonic_response
      implicit none (type, external)
      class(harmonic_response), intent(inout) :: self
      real(dp), intent(in) :: omega              !! > 0
      complex(dp), intent(out) :: value(:)       !! (points)
    end subroutine at_interface
  end interface

  type, public :: extreme_type
    integer :: point = 0
    logical :: is_resonance = .false.            !! else an antiresonance
    real(dp) :: omega = missing
    real(dp) :: amplitude = missing              !! of a damped resonance
    real(dp) :: ratio = missing                  !! of its damping, by its half-power width, where that is there
  end type extreme_type

  integer, parameter :: samples = 33             !! near a resonance, eight in a width c_k or more, and between two of them
  real(dp), parameter :: beside_pole = 1.0e-7_dp !! relatively, where an undamped resonance is looked at

contains

  subroutine find_extremes(response, square, damping, order, band, points, monitor, found)
    !! Of all points, each with ascending frequencies.
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: square(:), damping(:)   !! β_k² and c_k of modes, ascending
    integer, intent(in) :: order                 !! derivative of the displacement that is looked at: 0, 1 or 2
    real(dp), intent(in) :: band(2)              !! Ω > 0, ascending
    integer, intent(in) :: points
    class(monitor_type), intent(inout) :: monitor   !! what is found means nothing where it asks to stop
    type(extreme_type), allocatable, intent(out) :: found(:)
    real(dp) :: beta(size(square)), half_way(0:size(square)), lower, reach(2)   ! half_way: from each mode to the next
    integer :: k
    allocate (found(0))
    beta = sqrt(max(0.0_dp, square))
    half_way = [0.0_dp, 0.5_dp*(beta(:size(beta) - 1) + beta(2:)), huge(lower)]
    lower = band(1)
    do k = 1, size(square)
      if (monitor%stop_requested()) return
      if (beta(k) <= 0.0_dp) cycle
      reach = [max(beta(k) - 2.0_dp*damping(k), half_way(k - 1)), min(beta(k) + 2.0_dp*damping(k), half_way(k))]
      if (reach(2) < band(1)) cycle
      if (reach(1) > band(2)) exit
      associate (c => max(damping(k), beside_pole*beta(k)))
        call find_antiresonances(response, [lower, min(beta(k) - c, band(2))], points, found)
        lower = max(lower, beta(k) + c)
      end associate
      if (damping(k) > 0.0_dp) then
        call find_resonance(response, beta(k), max(reach, 1.0e-3_dp*beta(k)), damping(k), order, band, points, found)
      else if (beta(k) >= band(1) .and. beta(k) <= band(2)) then
        call find_pole(response, beta(k), points, found)
      end if
    end do
    call find_antiresonances(response, [lower, band(2)], points, found)
    call sort(found)
  end subroutine find_extremes

  subroutine find_pole(response, beta, points, found)
    !! Where the response grows without bound: ten times at least of what it is a hundred times as far away.
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: beta
    integer, intent(in) :: points
    type(extreme_type), allocatable, intent(inout) :: found(:)
    complex(dp), dimension(points, 2) :: near, far
    integer :: p
    call response%at(beta*(1.0_dp - beside_pole), near(:, 1))
    call response%at(beta*(1.0_dp + beside_pole), near(:, 2))
    call response%at(beta*(1.0_dp - 100.0_dp*beside_pole), far(:, 1))
    call response%at(beta*(1.0_dp + 100.0_dp*beside_pole), far(:, 2))
    do p = 1, points
      if (near(p, 1)%re*near(p, 2)%re >= 0.0_dp .or. minval(abs(near(p, :))) <= 10.0_dp*maxval(abs(far(p, :)))) cycle
      found = [found, extreme_type(p, .true., beta)]
    end do
  end subroutine find_pole

  subroutine find_resonance(response, beta, reach, c, order, band, points, found)
    !! The largest values next to a mode.
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: beta, c
    real(dp), intent(in) :: reach(2)             !! in which they are sought
    integer, intent(in) :: order
    real(dp), intent(in) :: band(2)
    integer, intent(in) :: points
    type(extreme_type), allocatable, intent(inout) :: found(:)
    type(extreme_type) :: peak
    real(dp) :: half(2), omega(samples), power(samples, points), step
    integer :: j, p, top
    step = (reach(2) - reach(1))/(samples - 1)
    do j = 1, samples
      omega(j) = reach(1) + (j - 1)*step
      power(j, :) = power_at(response, omega(j), order, points)
    end do
    do p = 1, points
      top = 0
      do j = 2, samples - 1
        if (power(j, p) <= power(j - 1, p) .or. power(j, p) < power(j + 1, p)) cycle
        if (top == 0) top = j
        if (abs(omega(j) - beta) < abs(omega(top) - beta)) top = j
      end do
      if (top == 0) cycle
      peak = extreme_type(p, .true., omega(top))
      call refine(peak)
      if (peak%omega < band(1) .or. peak%omega > band(2)) cycle
      half = [side(-1), side(1)]
      if (all(half >= missing)) cycle
      if (all(half < missing)) peak%ratio = ratio_of(half, peak%omega, order)
      if (is_known(found, peak, 0.01_dp*c)) cycle
      found = [found, peak]
    end do
  contains
    subroutine refine(peak)
      !! By parabolas of |H|⁻² in Ω², which it is of one mode, ever closer to the peak.
      type(extreme_type), intent(inout) :: peak
      integer, parameter :: times = 3, closer = 8
      real(dp) :: here(points), x(3), y(3), width
      integer :: i, n
      width = step
      do n = 1, times
        x = peak%omega + [-width, 0.0_dp, width]
        do i = 1, 3
          here = power_at(response, x(i), order, points)
          y(i) = 1.0_dp/here(p)
        end do
        peak%omega = sqrt(min(max(least_of(x**2, y), x(1)**2), x(3)**2))
        width = width/closer
      end do
      here = power_at(response, peak%omega, order, points)
      peak%amplitude = sqrt(here(p))
    end subroutine refine

    real(dp) function side(way) result(omega_half)
      !! Where half of the power is left on one side; missing where it rises before.
      integer, intent(in) :: way
      integer, parameter :: times = 60
      real(dp) :: before, here(points), inner, middle, outer
      integer :: i
      omega_half = missing
      outer = peak%omega
      before = peak%amplitude**2
      do i = 1, times
        outer = outer + way*0.125_dp*c
        if (outer <= 0.0_dp) return
        here = power_at(response, outer, order, points)
        if (here(p) <= 0.5_dp*peak%amplitude**2) exit
        if (here(p) > before) return
        before = here(p)
      end do
      if (here(p) > 0.5_dp*peak%amplitude**2) return
      inner = outer - way*0.125_dp*c
      do i = 1, times
        middle = 0.5_dp*(inner + outer)
        here = power_at(response, middle, order, points)
        if (here(p) > 0.5_dp*peak%amplitude**2) then
          inner = middle
        else
          outer = middle
        end if
        if (abs(outer - inner) <= 1.0e-9_dp*c) exit
      end do
      omega_half = 0.5_dp*(inner + outer)
    end function side
  end subroutine find_resonance

  pure logical function is_known(found, peak, near)
    !! Two modes that lie close together may have one peak.
    type(extreme_type), intent(in) :: found(:), peak
    real(dp), intent(in) :: near
    is_known = any(found%is_resonance .and. found%point == peak%point .and. abs(found%omega - peak%omega) <= near)
  end function is_known

  pure real(dp) function ratio_of(half, omega, order) result(ratio)
    !! ζ of one mode, by its half-power width, exactly: with Ω² displacements, with Ω velocities, with Ω⁻² accelerations.
    real(dp), intent(in) :: half(2), omega
    integer, intent(in) :: order
    select case (order)
    case (0); ratio = sin(0.5_dp*atan(0.5_dp*(half(2)**2 - half(1)**2)/omega**2))
    case (1); ratio = 0.5_dp*(half(2) - half(1))/omega
    case default; ratio = sin(0.5_dp*atan(0.5_dp*((omega/half(1))**2 - (omega/half(2))**2)))
    end select
  end function ratio_of

  pure real(dp) function least_of(x, y) result(at)
    !! Where the parabola through three points is least.
    real(dp), intent(in) :: x(3), y(3)
    real(dp) :: bend, slope(2)
    slope = (y(2:) - y(:2))/(x(2:) - x(:2))
    bend = (slope(2) - slope(1))/(x(3) - x(1))
    at = x(2)
    if (bend > 0.0_dp) at = 0.5_dp*(x(1) + x(2) - slope(1)/bend)
  end function least_of

  subroutine find_antiresonances(response, between, points, found)
    !! Where Re H changes sign and |H| is less than where a neighbour begins.
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: between(2)
    integer, intent(in) :: points
    type(extreme_type), allocatable, intent(inout) :: found(:)
    real(dp), parameter :: pi = acos(-1.0_dp)
    real(dp) :: omega(samples)
    complex(dp) :: value(points, samples)
    integer :: j, p
    if (between(2) <= between(1)) return
    do j = 1, samples                                ! many near the ends, where poles are
      omega(j) = between(1) + (between(2) - between(1))*sin(0.5_dp*pi*(j - 1)/(samples - 1))**2
      call response%at(omega(j), value(:, j))
    end do
    do p = 1, points
      do j = 1, samples - 1
        if (value(p, j)%re*value(p, j + 1)%re < 0.0_dp) call add(omega(j:j + 1), value(p, j)%re)
      end do
    end do
  contains
    subroutine add(ends, at_first)
      real(dp), intent(in) :: ends(2)
      real(dp), intent(in) :: at_first           !! Re H
      complex(dp) :: here(points)
      real(dp) :: lower, middle, upper
      integer, parameter :: times = 40
      integer :: i
      lower = ends(1)
      upper = ends(2)
      do i = 1, times
        middle = 0.5_dp*(lower + upper)
        call response%at(middle, here)
        if (here(p)%re*at_first > 0.0_dp) then
          lower = middle
        else
          upper = middle
        end if
        if (upper - lower <= 1.0e-9_dp*middle) exit
      end do
      if (abs(here(p)) < max(abs(value(p, 1)), abs(value(p, samples)))) found = [found, extreme_type(p, .false., middle)]
    end subroutine add
  end subroutine find_antiresonances

  function power_at(response, omega, order, points) result(power)
    !! |Ωⁿ H|², (points).
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: omega
    integer, intent(in) :: order, points
    real(dp) :: power(points)
    complex(dp) :: value(points)
    call response%at(omega, value)
    power = (abs(value)*omega**order)**2
  end function power_at

  pure subroutine sort(found)
    !! By points, and by frequencies.
    type(extreme_type), intent(inout) :: found(:)
    type(extreme_type) :: next
    integer :: i, j
    do i = 2, size(found)
      next = found(i)
      do j = i - 1, 1, -1
        if (found(j)%point < next%point .or. (found(j)%point == next%point .and. found(j)%omega <= next%omega)) exit
        found(j + 1) = found(j)
      end do
      found(j + 1) = next
    end do
  end subroutine sort

end module bw_response_extremes
