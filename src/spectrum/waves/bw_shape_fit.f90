module bw_shape_fit
  !! Least-squares fit of one line's amplitudes at sensors by functions of a uniform beam, over α = k l (variable projection:
  !! Golub & Pereyra 1973). Each function has a complex factor, so that a motion may travel or be damped; strain has its own
  !! factors, since its constant is not known.
  use bw_constants, only: two_pi
  use bw_kinds, only: dp
  use bw_model_shapes, only: model_shape
  use bw_piece_beam, only: piece_beam
  use bw_text, only: text_of
  use bw_wave_shapes, only: function_count, shape_functions
  implicit none (type, external)
  private
  public :: candidates_of, costs_of, fits_anything, freedom_of, interval_of, reason_against, scanned

  real(dp), parameter :: lowest = 0.1_dp       !! α; with a smaller one the beam looks straight to any sensor
  real(dp), parameter :: highest = 200         !! α; about the 64th mode. With many lines the scan goes to twice as many modes
  real(dp), parameter :: step = 0.15_dp        !! of a scan; misfits vary over π
  real(dp), parameter :: dependent = 1.0e-8_dp !! part of a function independent of the others; a smaller one is rounding
  integer, parameter :: most_steps = 60
  real(dp), parameter, public :: rounding = 8*epsilon(1.0_dp)
  real(dp), parameter, public :: worse = 25    !! five standard deviations squared: the highest cost of a candidate above the best

  type, public :: wave_sensor
    !! The sensors, and what is known of the beam's ends.
    real(dp), allocatable :: position(:)       !! ξ, (S)
    logical, allocatable :: strain(:)          !! strain is measured, else displacement, (S)
    character(:), allocatable :: ends          !! 'model', 'tip', 'clamped' or 'any'
    type(piece_beam) :: model                  !! with 'model': the beam with its supports and attached bodies
  end type wave_sensor

  type, public :: motion_type
    !! Amplitudes of one line at the sensors, over their standard deviations.
    complex(dp), allocatable :: data(:)        !! (S)
    real(dp), allocatable :: weight(:)         !! 1 over the standard deviation of real and of imaginary part, up to a factor, (S)
    real(dp), allocatable :: separating(:, :)  !! decorrelates the noise of the sensors; unallocated if it is independent, (S, S)
    logical :: freed = .false.                 !! standard deviations are known up to a factor only
  end type motion_type

  type, public :: wave_candidate
    !! A wave number that fits better than its neighbours.
    real(dp) :: alpha = 0
    real(dp) :: deviation = huge(1.0_dp)       !! standard deviation of α in linear theory
    real(dp) :: misfit = huge(1.0_dp)          !! sum of squared residuals
    real(dp) :: cost = 0                       !! above the best, from `costs_of`
  end type wave_candidate

  type :: shape_projection
    !! Residual of the fit at one α.
    real(dp) :: misfit = 0
    real(dp) :: slope = 0, curvature = 0       !! half the derivatives by α (Gauss & Newton, Kaufman 1975)
  end type shape_projection

contains

  pure integer function columns_of(sensors)
    !! Number of functions, counted separately for strain and other quantities.
    type(wave_sensor), intent(in) :: sensors
    columns_of = function_count(sensors%ends)*count([any(sensors%strain), any(.not. sensors%strain)])
  end function columns_of

  pure integer function places_of(sensors, strain)
    !! Number of distinct positions of sensors of a kind of quantity, without those where all functions vanish.
    type(wave_sensor), intent(in) :: sensors
    logical, intent(in) :: strain
    logical :: valid(size(sensors%position))
    integer :: i
    valid = sensors%strain .eqv. strain
    if (sensors%ends /= 'any' .and. sensors%model%root%holds_deflection .and. .not. strain) valid = valid .and. sensors%position > 0
    if (function_count(sensors%ends) == 1 .and. strain) valid = valid .and. sensors%position < 1
    places_of = count([(valid(i) .and. .not. any(valid(:i - 1) .and. sensors%position(:i - 1) == sensors%position(i)), &
      & i=1, size(valid))])
  end function places_of

  pure function reason_against(sensors) result(reason)
    !! Why the sensors cannot determine any wave number; '' if they can. One kind of quantity needs one position more than there are
    !! functions.
    type(wave_sensor), intent(in) :: sensors
    character(:), allocatable :: reason
    integer :: needed
    needed = function_count(sensors%ends) + 1
    reason = ''
    if (max(places_of(sensors, .false.), places_of(sensors, .true.)) >= needed) return
    reason = 'ends = '''//sensors%ends//''' needs '//text_of(needed)//' sensors of motion or '//text_of(needed)// &
      & ' of strain, at different places where the shape is not forced to be 0; there are '// &
      & text_of(places_of(sensors, .false.))//' and '//text_of(places_of(sensors, .true.))
  end function reason_against

  pure logical function fits_anything(sensors)
    !! Whether there are so few sensors that some α fits any real amplitudes.
    type(wave_sensor), intent(in) :: sensors
    fits_anything = max(places_of(sensors, .false.), places_of(sensors, .true.)) == function_count(sensors%ends) + 1
  end function fits_anything

  pure integer function freedom_of(sensors)
    !! Degrees of freedom of the fit: the real numbers in a line's amplitudes minus the unknowns.
    type(wave_sensor), intent(in) :: sensors
    integer :: n
    n = function_count(sensors%ends)
    freedom_of = 2*(size(sensors%position) - min(n, places_of(sensors, .false.)) - min(n, places_of(sensors, .true.))) - 1
  end function freedom_of

  pure function functions_at(sensors, alpha) result(values)
    !! The functions at the sensors; 0 at sensors of the other kind of quantity.
    type(wave_sensor), intent(in) :: sensors
    complex(dp), intent(in) :: alpha
    complex(dp) :: values(size(sensors%position), columns_of(sensors))
    integer, allocatable :: rows(:)
    integer :: kind, i, n, last
    n = function_count(sensors%ends)
    last = 0
    values = 0
    do kind = 1, 2                             ! motion, then strain
      rows = pack([(i, i=1, size(sensors%strain))], sensors%strain .eqv. kind == 2)
      if (size(rows) == 0) cycle
      if (sensors%ends == 'model') then
        values(rows, last + 1) = model_shape(sensors%model, alpha, sensors%position(rows), kind == 2)
      else
        values(rows, last + 1:last + n) = shape_functions(sensors%ends, alpha, sensors%position(rows), kind == 2)
      end if
      last = last + n
    end do
  end function functions_at

  pure subroutine scanned(sensors, motions, alpha, misfit)
    !! Compute the misfits of all lines over a grid of α.
    type(wave_sensor), intent(in) :: sensors
    type(motion_type), intent(in) :: motions(:)
    real(dp), allocatable, intent(out) :: alpha(:), misfit(:, :)  !! (n), (n, line)
    complex(dp) :: functions(size(sensors%position), columns_of(sensors))
    type(shape_projection) :: projection
    real(dp) :: top
    integer :: i, k
    top = max(highest, two_pi*size(motions))
    allocate (alpha, source=[(lowest + step*i, i=0, floor((top - lowest)/step))])
    allocate (misfit(size(alpha), size(motions)))
    do i = 1, size(alpha)
      functions = functions_at(sensors, cmplx(alpha(i), kind=dp))
      do k = 1, size(motions)
        projection = projected(functions, motions(k), .false.)
        misfit(i, k) = projection%misfit
      end do
    end do
  end subroutine scanned

  pure type(shape_projection) function projected(functions, motion, with_slope) result(projection)
    !! Residual of the fit to a motion; the slope from the functions' imaginary parts, `tiny_step` times their derivatives.
    complex(dp), intent(in) :: functions(:, :)  !! (S, column)
    type(motion_type), intent(in) :: motion
    logical, intent(in) :: with_slope
    real(dp) :: basis(size(functions, 1), size(functions, 2)), triangle(size(functions, 2), size(functions, 2)), length
    complex(dp), dimension(size(functions, 1)) :: residual, change
    complex(dp) :: factor(size(functions, 2))
    logical :: used(size(functions, 2))
    integer :: i, j, pass
    residual = motion%data
    triangle = 0
    factor = 0
    do j = 1, size(basis, 2)
      basis(:, j) = weighted(motion, functions(:, j)%re)
      length = norm2(basis(:, j))
      do pass = 1, 2
        do i = 1, j - 1
          associate (part => dot_product(basis(:, i), basis(:, j)))
            triangle(i, j) = triangle(i, j) + part
            basis(:, j) = basis(:, j) - part*basis(:, i)
          end associate
        end do
      end do
      triangle(j, j) = norm2(basis(:, j))
      used(j) = triangle(j, j) > dependent*max(length, norm2(motion%weight))
      basis(:, j) = merge(basis(:, j)/max(triangle(j, j), tiny(1.0_dp)), 0.0_dp, used(j))
      factor(j) = sum(basis(:, j)*residual)
      residual = residual - factor(j)*basis(:, j)
    end do
    projection%misfit = sum(residual%re**2 + residual%im**2)
    if (.not. with_slope) return
    do j = size(basis, 2), 1, -1
      factor(j) = factor(j) - sum(triangle(j, j + 1:)*factor(j + 1:))
      factor(j) = merge(factor(j)/merge(triangle(j, j), 1.0_dp, used(j)), (0.0_dp, 0.0_dp), used(j))
    end do
    change = 0
    do j = 1, size(basis, 2)
      change = change + factor(j)*weighted(motion, functions(:, j)%im)
    end do
    do j = 1, size(basis, 2)
      change = change - sum(basis(:, j)*change)*basis(:, j)
    end do
    projection%slope = -sum(change%re*residual%re + change%im*residual%im)
    projection%curvature = sum(change%re**2 + change%im**2)
  end function projected

  pure function weighted(motion, values) result(independent)
    !! Values at the sensors over the standard deviations, decorrelated.
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: values(:)          !! (S)
    real(dp) :: independent(size(values))
    independent = values*motion%weight
    if (allocated(motion%separating)) independent = matmul(motion%separating, independent)
  end function weighted

  pure type(shape_projection) function projection_at(sensors, motion, alpha) result(projection)
    !! Residual of the fit at one α, with slope and curvature.
    type(wave_sensor), intent(in) :: sensors
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: alpha
    real(dp), parameter :: tiny_step = 2.0_dp**(-100)
    projection = projected(functions_at(sensors, cmplx(alpha, tiny_step, dp)), motion, .true.)
    projection%slope = projection%slope/tiny_step
    projection%curvature = projection%curvature/tiny_step**2
  end function projection_at

  pure function candidates_of(sensors, motion, alpha, misfit, freedom) result(candidates)
    !! The refined local minima of a scan, without those that a parabola predicts to be too far above the best for a candidate.
    !! The scan's lower end is a minimum, too, if the misfit still falls there.
    type(wave_sensor), intent(in) :: sensors
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: alpha(:), misfit(:)  !! of the scan, (n)
    integer, intent(in) :: freedom             !! degrees of freedom of the fit
    type(wave_candidate), allocatable :: candidates(:)
    integer, allocatable :: low(:)
    real(dp) :: best, least
    integer :: i, first
    low = pack([(i, i=1, size(alpha))], misfit <= eoshift(misfit, -1, huge(1.0_dp)) &
      & .and. misfit <= eoshift(misfit, 1, huge(1.0_dp)))
    first = low(minloc(misfit(low), dim=1))
    candidates = [refined(sensors, motion, alpha(first))]
    best = candidates(1)%misfit
    do i = 1, size(low)
      if (low(i) == first) cycle
      least = predicted_minimum(sensors, motion, alpha(low(i)))
      if (costs_of(least, best, freedom, .true.) > worse .and. (motion%freed .or. least > best + worse)) cycle
      candidates = [candidates, refined(sensors, motion, alpha(low(i)))]
      best = min(best, candidates(size(candidates))%misfit)
    end do
  end function candidates_of

  elemental real(dp) function costs_of(misfit, least, freedom, scaled) result(cost)
    !! Twice the logarithm of the likelihood ratio of the best fit to this one. If the standard deviation is estimated from the
    !! misfit, each fit has its own maximum-likelihood estimate.
    real(dp), intent(in) :: misfit, least      !! sums of squares
    integer, intent(in) :: freedom
    logical, intent(in) :: scaled              !! the standard deviation is estimated from the misfit
    cost = misfit - least
    if (scaled) cost = (freedom + 1)*log((max(misfit, least) + freedom*rounding**2)/(least + freedom*rounding**2))
  end function costs_of

  pure real(dp) function predicted_minimum(sensors, motion, alpha) result(least)
    !! A cautious estimate of the minimum: the misfit less ten times the fall that a parabola predicts, since it is no parabola.
    type(wave_sensor), intent(in) :: sensors
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: alpha
    type(shape_projection) :: here
    here = projection_at(sensors, motion, alpha)
    least = here%misfit
    if (here%curvature > 0) least = least - 10*here%slope**2/here%curvature
  end function predicted_minimum

  pure type(wave_candidate) function refined(sensors, motion, start) result(candidate)
    !! The minimum of the misfit within a step of the scan, by Gauss–Newton steps that are shortened where they fail; the misfit
    !! is reduced by what rounding of α contributes.
    type(wave_sensor), intent(in) :: sensors
    type(motion_type), intent(in) :: motion
    real(dp), intent(in) :: start
    type(shape_projection) :: here, there
    real(dp) :: alpha, move
    integer :: i
    alpha = start
    here = projection_at(sensors, motion, alpha)
    do i = 1, most_steps
      if (.not. here%curvature > 0) exit
      move = min(max(alpha - here%slope/here%curvature, start - step, lowest/2), start + step) - alpha
      do
        if (abs(move) <= epsilon(1.0_dp)*alpha) exit
        there = projection_at(sensors, motion, alpha + move)
        if (there%misfit < here%misfit) exit
        move = move/4
      end do
      if (abs(move) <= epsilon(1.0_dp)*alpha) exit
      alpha = alpha + move
      here = there
    end do
    candidate%alpha = alpha
    candidate%misfit = max(0.0_dp, here%misfit - here%curvature*(rounding*alpha)**2)
    if (here%curvature > 0) candidate%deviation = 1/sqrt(here%curvature)
  end function refined

  pure function interval_of(sensors, motion, candidate, rise) result(interval)
    !! The interval around a candidate in which the misfit is at most `rise` above its minimum (profile likelihood). An end that
    !! is not found within the range of α is 0 or huge.
    type(wave_sensor), intent(in) :: sensors
    type(motion_type), intent(in) :: motion
    type(wave_candidate), intent(in) :: candidate
    real(dp), intent(in) :: rise
    real(dp) :: interval(2)
    interval = [end_at(-1), end_at(1)]

  contains

    pure real(dp) function end_at(side) result(outside)
      !! The end on one side: steps outwards, then bisection.
      integer, intent(in) :: side
      real(dp) :: inside, move, middle
      type(shape_projection) :: there
      integer :: i
      inside = candidate%alpha
      move = max(min(candidate%deviation*sqrt(rise), step), 4*epsilon(1.0_dp)*candidate%alpha)
      do
        outside = inside + side*move
        if (outside < lowest/2 .or. outside > max(highest, candidate%alpha) + 1) then
          outside = merge(0.0_dp, huge(1.0_dp), side < 0)
          return
        end if
        there = projection_at(sensors, motion, outside)
        if (there%misfit > candidate%misfit + rise) exit
        inside = outside
        move = min(2*move, step)
      end do
      do i = 1, 12
        middle = (inside + outside)/2
        there = projection_at(sensors, motion, middle)
        if (there%misfit > candidate%misfit + rise) then
          outside = middle
        else
          inside = middle
        end if
      end do
    end function end_at

  end function interval_of

end module bw_shape_fit
