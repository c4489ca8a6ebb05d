module bw_fit_intervals
  !! Confidence intervals of fitted unknowns by profile likelihood, and correlations between them.
  !!
  !! The interval of an unknown ends where the least sum of squares over all others has grown by the square of the
  !! quantile. The values of the others there are stored: all ends fit equally well.
  use bw_fit_problem, only: fit_problem
  use bw_fit_search, only: fit_type
  use bw_kinds, only: dp
  use bw_lapack, only: dpotrf, dpotri
  implicit none (type, external)
  private
  public :: find_intervals

  type, public :: interval_type
    !! The interval of one unknown; all positions are v, −1 … 1 in the range.
    real(dp) :: low = -1.0_dp, high = 1.0_dp
    logical :: low_open = .true., high_open = .true.   !! the end is set by the range, not by the record
    real(dp), allocatable :: at_low(:), at_high(:)     !! all unknowns there, (unknowns)
  end type interval_type

  type, public :: fit_uncertainty
    type(interval_type), allocatable :: intervals(:)   !! (unknowns)
    real(dp), allocatable :: correlation(:, :)         !! 0 for unknowns that the record does not constrain, (unknowns, unknowns)
    real(dp), allocatable :: deviation(:)              !! of v, with linearised residuals, (unknowns)
    real(dp), allocatable :: better(:)                 !! a better fit met on the way; unallocated: none
  end type fit_uncertainty

contains

  subroutine find_intervals(problem, fit, quantile, uncertainty)
    !! Find intervals and correlations about a fit; the problem is set to it before and after.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(in) :: fit
    real(dp), intent(in) :: quantile             !! of the normal distribution, two-sided
    type(fit_uncertainty), intent(out) :: uncertainty
    integer :: i, n
    n = size(problem%unknowns)
    allocate (uncertainty%intervals(n))
    call find_covariance(problem, uncertainty)
    do i = 1, n
      associate (interval => uncertainty%intervals(i))
        call follow(problem, fit, i, -1, quantile, uncertainty, interval%low, interval%low_open, interval%at_low)
        call follow(problem, fit, i, 1, quantile, uncertainty, interval%high, interval%high_open, interval%at_high)
      end associate
    end do
    problem%v = fit%v
    problem%free = [(i, i=1, n)]
  end subroutine find_intervals

  subroutine find_covariance(problem, uncertainty)
    !! Find (JᵀJ + 1)⁻¹: the 1 is the prior of the range, v = 0 ± 1, so that the inverse exists even in directions that
    !! the record does not constrain.
    type(fit_problem), intent(inout) :: problem
    type(fit_uncertainty), intent(inout) :: uncertainty
    real(dp), allocatable :: jacobian(:, :), information(:, :), covariance(:, :)
    integer :: i, j, n
    n = size(problem%v)
    call problem%find_derivatives(jacobian)
    information = matmul(transpose(jacobian), jacobian)
    do i = 1, n
      information(i, i) = information(i, i) + 1
    end do
    call invert(information, covariance)
    allocate (uncertainty%correlation(n, n), uncertainty%deviation(n))
    uncertainty%deviation = sqrt([(covariance(i, i), i=1, n)])
    do j = 1, n
      do i = 1, n
        uncertainty%correlation(i, j) = covariance(i, j)/(uncertainty%deviation(i)*uncertainty%deviation(j))
      end do
    end do
  end subroutine find_covariance

  subroutine invert(matrix, inverse)
    !! Invert by Cholesky's factor, scaled by the diagonal.
    real(dp), intent(in) :: matrix(:, :)         !! symmetric, positive definite
    real(dp), allocatable, intent(out) :: inverse(:, :)
    real(dp) :: unit(size(matrix, 1))
    integer :: i, j, n, info
    n = size(matrix, 1)
    unit = [(1/sqrt(matrix(i, i)), i=1, n)]
    inverse = matrix*spread(unit, 1, n)*spread(unit, 2, n)
    call dpotrf('L', n, inverse, n, info)
    if (info == 0) call dpotri('L', n, inverse, n, info)
    if (info /= 0) then                          ! beyond the range of numbers: the prior alone
      inverse = merge(1.0_dp, 0.0_dp, spread([(i, i=1, n)], 1, n) == spread([(i, i=1, n)], 2, n))
      unit = 1
    end if
    do j = 1, n
      do i = 1, j - 1
        inverse(i, j) = inverse(j, i)
      end do
    end do
    inverse = inverse*spread(unit, 1, n)*spread(unit, 2, n)
  end subroutine invert

  subroutine follow(problem, fit, i, way, quantile, uncertainty, end, is_open, place)
    !! Move from the fit to one side until the least sum of squares has grown by the square of the quantile. The root of
    !! the growth is nearly linear, so that a few secant steps suffice; it has a kink where another unknown reaches the
    !! end of its range, and there bisection is the fallback.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(in) :: fit
    integer, intent(in) :: i                     !! the unknown
    integer, intent(in) :: way                   !! −1 or 1
    real(dp), intent(in) :: quantile
    type(fit_uncertainty), intent(inout) :: uncertainty
    real(dp), intent(out) :: end
    logical, intent(out) :: is_open
    real(dp), allocatable, intent(out) :: place(:)
    real(dp), parameter :: near = 0.01_dp
    real(dp), parameter :: lower = 0.01_dp       !! decrease of the sum of squares that makes a place a better fit
    integer, parameter :: most_steps = 20
    real(dp) :: t, inner, outer, g, g_inner, g_outer, room, share, width
    integer :: step
    room = 1 - way*fit%v(i)
    inner = 0
    g_inner = 0
    outer = -1
    g_outer = 0
    width = huge(width)
    place = fit%v
    t = min(room, quantile*uncertainty%deviation(i))
    do step = 1, most_steps
      g = growth_at(t)
      place = problem%v
      is_open = t >= room .and. g < quantile
      if (abs(g - quantile) < near*quantile .or. is_open) exit
      if (g < quantile) then
        inner = t
        g_inner = g
      else
        outer = t
        g_outer = g
      end if
      if (outer < 0) then
        t = min(room, merge(min(4*t, t*quantile/max(g, 0.1_dp*quantile)), 4*t, g > 0))
      else
        share = (quantile - g_inner)/(g_outer - g_inner)
        if (outer - inner > 0.5_dp*width) share = 0.5_dp
        width = outer - inner
        t = inner + width*min(0.9_dp, max(0.1_dp, share))
      end if
    end do
    end = fit%v(i) + way*t
  contains
    real(dp) function growth_at(distance) result(growth)
      !! Return the root of the growth of the least sum of squares.
      real(dp), intent(in) :: distance
      real(dp), allocatable :: residuals(:)
      integer :: j
      problem%free = pack([(j, j=1, size(fit%v))], [(j /= i, j=1, size(fit%v))])
      problem%v = max(-1.0_dp, min(1.0_dp, fit%v + (place - fit%v)))
      if (step == 1) problem%v = max(-1.0_dp, min(1.0_dp, fit%v + way*distance*uncertainty%correlation(:, i)* &
                                                  uncertainty%deviation/uncertainty%deviation(i)))
      problem%v(i) = max(-1.0_dp, min(1.0_dp, fit%v(i) + way*distance))
      call problem%minimise(residuals, .true.)
      growth = sqrt(max(0.0_dp, sum(residuals**2) - fit%sum))
      if (sum(residuals**2) < fit%sum - lower) uncertainty%better = problem%v
    end function growth_at
  end subroutine follow

end module bw_fit_intervals
