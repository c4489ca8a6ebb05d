module bw_response_extremes
  !! Resonances, with their half-power widths, and antiresonances of the response to a harmonic force. The response can
  !! be evaluated at any frequency, and modes show where to search, so nothing depends on the requested frequencies.
  !!
  !! A resonance is a maximum within 2c_k of the frequency of a damped mode that falls to half its power on at least one
  !! side; for an undamped mode it is a pole. At an antiresonance, between these widths, Re H changes sign. **Limit**:
  !! antiresonances within the width of a mode are not found, nor are two between adjacent samples. Frequencies are in
  !! the units of modes, responses in the caller's.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_lapack, only: dlasrt
  use bw_missing, only: missing
  use bw_monitor, only: monitor_type
  use bw_order, only: ascending
  implicit none (type, external)
  private
  public :: find_extremes

  type, abstract, public :: harmonic_response
    !! The displacements of points under a harmonic force.
  contains
    procedure(at_interface), deferred :: at
  end type harmonic_response

  abstract interface
    subroutine at_interface(self, omega, point, value)
      import :: dp, harmonic_response
      implicit none (type, external)
      class(harmonic_response), intent(inout) :: self
      real(dp), intent(in) :: omega              !! > 0
      integer, intent(in) :: point               !! index of the point; 0: all
      complex(dp), intent(out) :: value(:)       !! of all points, or of one
    end subroutine at_interface
  end interface

  type, public :: extreme_type
    integer :: point = 0
    logical :: is_resonance = .false.            !! else an antiresonance
    real(dp) :: omega = missing
    real(dp) :: amplitude = missing              !! of a damped resonance, else missing
    real(dp) :: ratio = missing                  !! damping ratio from the half-power width, if that exists
  end type extreme_type

  integer, parameter, public :: most_extremes = 100   !! limit after which no further points are searched
  integer, parameter :: samples = 33             !! near a mode, and between two modes
  real(dp), parameter :: beside_pole = 1.0e-7_dp !! relative distance from an undamped resonance

contains

  subroutine find_extremes(response, square, damping, order, band, points, monitor, found)
    !! Find the extremes of all points in order, each with ascending frequencies.
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: square(:), damping(:)   !! β_k² and c_k of modes, ascending
    integer, intent(in) :: order                 !! derivative of the displacement: 0, 1 or 2
    real(dp), intent(in) :: band(2)              !! Ω > 0, ascending
    integer, intent(in) :: points
    class(monitor_type), intent(inout) :: monitor   !! results are invalid if it requests a stop
    type(extreme_type), allocatable, intent(out) :: found(:)
    type(extreme_type), allocatable :: own(:)
    integer :: p
    allocate (found(0))
    do p = 1, points
      if (size(found) > most_extremes) exit
      allocate (own(0))
      call find_own(response, sqrt(max(0.0_dp, square)), damping, order, band, p, monitor, own)
      if (monitor%stop_requested()) return
      found = [found, own(ascending(own%omega))]
      deallocate (own)
    end do
  end subroutine find_extremes

  subroutine find_own(response, beta, damping, order, band, point, monitor, found)
    !! Find the extremes of one point.
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: beta(:), damping(:)  !! 0 for modes that do not oscillate
    integer, intent(in) :: order, point
    real(dp), intent(in) :: band(2)
    class(monitor_type), intent(inout) :: monitor
    type(extreme_type), allocatable, intent(inout) :: found(:)
    real(dp) :: lower
    integer :: k
    call find_resonances(response, pack(beta, beta*damping > 0.0_dp), pack(damping, beta*damping > 0.0_dp), order, band, point, &
                         monitor, found)
    lower = band(1)
    do k = 1, size(beta)
      if (monitor%stop_requested()) return
      if (beta(k) <= 0.0_dp) cycle
      associate (c => max(damping(k), beside_pole*beta(k)))
        call find_antiresonances(response, [lower, min(beta(k) - c, band(2))], point, found)
        lower = max(lower, beta(k) + c)
      end associate
      if (damping(k) <= 0.0_dp .and. beta(k) >= band(1) .and. beta(k) <= band(2)) call find_pole(response, beta(k), point, found)
      if (lower > band(2)) exit
    end do
    call find_antiresonances(response, [lower, band(2)], point, found)
  end subroutine find_own

  subroutine find_pole(response, beta, point, found)
    !! Find a pole: Re H changes sign there, and |H| is over ten times its value a hundred times farther off.
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: beta
    integer, intent(in) :: point
    type(extreme_type), allocatable, intent(inout) :: found(:)
    complex(dp) :: near(2), far(2)
    near = [value_at(response, beta*(1.0_dp - beside_pole), point), value_at(response, beta*(1.0_dp + beside_pole), point)]
    far = [value_at(response, beta*(1.0_dp - 100.0_dp*beside_pole), point), &
           value_at(response, beta*(1.0_dp + 100.0_dp*beside_pole), point)]
    if (near(1)%re*near(2)%re >= 0.0_dp .or. minval(abs(near)) <= 10.0_dp*maxval(abs(far))) return
    if (any(found%is_resonance .and. abs(found%omega - beta) <= 2.0_dp*beside_pole*beta)) return
    found = [found, extreme_type(point, .true., beta)]
  end subroutine find_pole

  subroutine find_resonances(response, beta, c, order, band, point, monitor, found)
    !! Find the maxima near damped modes. Modes with overlapping widths are searched together, as they may have one peak.
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: beta(:), c(:)
    integer, intent(in) :: order, point
    real(dp), intent(in) :: band(2)
    class(monitor_type), intent(inout) :: monitor
    type(extreme_type), allocatable, intent(inout) :: found(:)
    real(dp), allocatable :: omega(:)
    type(extreme_type) :: peak
    real(dp) :: half(2), power(3), width             ! power: of three adjacent samples
    integer :: i
    omega = places()
    power = 0.0_dp
    do i = 1, size(omega)
      if (mod(i, samples) == 0) then
        if (monitor%stop_requested()) return
      end if
      power = [power(2:), power_at(omega(i))]
      if (i < 3 .or. power(2) <= power(1) .or. power(2) < power(3)) cycle
      peak = extreme_type(point, .true., omega(i - 1))
      call refine(omega(i - 2:i))
      if (peak%omega < band(1) .or. peak%omega > band(2)) cycle
      width = minval(c, mask=abs(peak%omega - beta) <= 2.0_dp*c)
      half = [side(-1), side(1)]
      if (all(half >= missing)) cycle
      if (all(half < missing)) peak%ratio = ratio_of(half, peak%omega, order)
      found = [found, peak]
    end do
  contains
    pure function places() result(omega)
      !! Return the sample frequencies, ascending: eight in the width c_k of a mode, to twice that on either side.
      real(dp), allocatable :: omega(:)
      integer :: j, k, info                        ! info is 0
      omega = [((beta(k) + 4.0_dp*c(k)*(j - (samples + 1)/2)/(samples - 1), j=1, samples), k=1, size(beta))]
      omega = pack(omega, omega > 0.0_dp .and. omega >= 0.5_dp*band(1) .and. omega <= 2.0_dp*band(2))
      call dlasrt('I', size(omega), omega, info)
    end function places

    real(dp) function power_at(at) result(power)
      !! |Ωⁿ H|².
      real(dp), intent(in) :: at
      power = (abs(value_at(response, at, point))*at**order)**2
    end function power_at

    subroutine refine(ends)
      !! Refine a peak by parabolas of |H|⁻² in Ω², exact for one mode, on shrinking intervals.
      real(dp), intent(in) :: ends(3)
      integer, parameter :: times = 4, closer = 8
      real(dp) :: x(3), y(3), wide
      integer :: n
      wide = 0.5_dp*(ends(3) - ends(1))
      do n = 1, times
        x = [max(ends(1), peak%omega - wide), peak%omega, min(ends(3), peak%omega + wide)]
        if (x(1) >= x(2) .or. x(2) >= x(3)) exit
        y = 1.0_dp/[power_at(x(1)), power_at(x(2)), power_at(x(3))]
        peak%omega = sqrt(min(max(least_of(x**2, y), x(1)**2), x(3)**2))
        wide = wide/closer
      end do
      peak%amplitude = sqrt(power_at(peak%omega))
    end subroutine refine

    real(dp) function side(way) result(omega_half)
      !! Return the half-power frequency on one side; missing if |H| rises before.
      integer, intent(in) :: way
      integer, parameter :: times = 60
      real(dp), parameter :: near = 1.0e-9_dp        ! of the width
      real(dp) :: level, x(3), y(3)                  ! y: |H|⁻² less twice that of the peak
      integer :: i
      omega_half = missing
      level = 2.0_dp/peak%amplitude**2
      x(2) = peak%omega
      y(2) = -0.5_dp*level
      do i = 1, times
        x(1) = x(2)
        y(1) = y(2)
        x(2) = x(1) + way*0.25_dp*width
        if (x(2) <= 0.0_dp) return
        y(2) = 1.0_dp/power_at(x(2)) - level
        if (y(2) >= 0.0_dp) exit
        if (y(2) < y(1)) return
      end do
      if (y(2) < 0.0_dp) return
      do i = 1, times                                ! by the Illinois algorithm
        x(3) = (x(1)*y(2) - x(2)*y(1))/(y(2) - y(1))
        y(3) = 1.0_dp/power_at(x(3)) - level
        if (y(3)*y(2) < 0.0_dp) then
          x(1) = x(2)
          y(1) = y(2)
        else
          y(1) = 0.5_dp*y(1)
        end if
        if (abs(x(3) - x(2)) <= near*width) exit
        x(2) = x(3)
        y(2) = y(3)
      end do
      omega_half = x(3)
    end function side
  end subroutine find_resonances

  complex(dp) function value_at(response, omega, point) result(value)
    !! Return the response of one point.
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: omega
    integer, intent(in) :: point
    complex(dp) :: one(1)
    call response%at(omega, point, one)
    value = one(1)
  end function value_at

  pure real(dp) function ratio_of(half, omega, order) result(ratio)
    !! Return ζ from the half-power width, exact for one mode: by Ω² of displacements, Ω of velocities, Ω⁻² of accelerations.
    real(dp), intent(in) :: half(2), omega
    integer, intent(in) :: order
    select case (order)
    case (0); ratio = sin(0.5_dp*atan(0.5_dp*(half(2)**2 - half(1)**2)/omega**2))
    case (1); ratio = 0.5_dp*(half(2) - half(1))/omega
    case default; ratio = sin(0.5_dp*atan(0.5_dp*((omega/half(1))**2 - (omega/half(2))**2)))
    end select
  end function ratio_of

  pure real(dp) function least_of(x, y) result(at)
    !! Return the minimum of the parabola through three points.
    real(dp), intent(in) :: x(3), y(3)
    real(dp) :: bend, slope(2)
    slope = (y(2:) - y(:2))/(x(2:) - x(:2))
    bend = (slope(2) - slope(1))/(x(3) - x(1))
    at = x(2)
    if (bend > 0.0_dp) at = 0.5_dp*(x(1) + x(2) - slope(1)/bend)
  end function least_of

  subroutine find_antiresonances(response, between, point, found)
    !! Find sign changes of Re H at which |H| is less than at an end of the interval.
    class(harmonic_response), intent(inout) :: response
    real(dp), intent(in) :: between(2)
    integer, intent(in) :: point
    type(extreme_type), allocatable, intent(inout) :: found(:)
    real(dp), parameter :: near = 1.0e-9_dp
    real(dp) :: lower, middle, omega(samples), upper
    complex(dp) :: here, value(samples)
    integer :: j
    if (between(2) <= between(1)) return
    do j = 1, samples                                ! denser towards the ends, near the poles
      omega(j) = between(1) + (between(2) - between(1))*sin(0.5_dp*pi*(j - 1)/(samples - 1))**2
      value(j) = value_at(response, omega(j), point)
    end do
    do j = 1, samples - 1
      if (value(j)%re*value(j + 1)%re >= 0.0_dp) cycle
      lower = omega(j)
      upper = omega(j + 1)
      do
        middle = 0.5_dp*(lower + upper)
        here = value_at(response, middle, point)
        if (upper - lower <= near*middle) exit
        if (here%re*value(j)%re > 0.0_dp) then
          lower = middle
        else
          upper = middle
        end if
      end do
      if (abs(here) < max(abs(value(1)), abs(value(samples)))) found = [found, extreme_type(point, .false., middle)]
    end do
  end subroutine find_antiresonances

end module bw_response_extremes
