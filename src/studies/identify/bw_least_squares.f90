module bw_least_squares
  !! Least squares of residuals within ranges, by MINPACK's `lmdif`: the method of Levenberg and Marquardt in Moré's
  !! form, with difference quotients.
  !!
  !! MINPACK knows no bounds. A variable v, −1 ≤ v ≤ 1, is therefore sin x of MINPACK's variable x, which no step takes
  !! out of the range; where the residuals would be least beyond the range, the minimum is at its end. Near x = π
  !! difference steps, which are relative, do not vanish.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: least_squares

  type, abstract, public :: residual_problem
    !! Residuals as a function of variables.
  contains
    procedure(residuals_interface), deferred :: find_residuals
  end type residual_problem

  abstract interface
    subroutine residuals_interface(self, v, residuals)
      !! Find the residuals of these variables.
      import :: dp, residual_problem
      class(residual_problem), intent(inout) :: self
      real(dp), intent(in) :: v(:)               !! −1 ≤ v ≤ 1, (variables)
      real(dp), intent(out) :: residuals(:)      !! finite
    end subroutine residuals_interface

    subroutine minpack_function(m, n, x, fvec, iflag)
      !! Residuals in the form that MINPACK calls.
      import :: dp
      integer, intent(in) :: m, n
      real(dp), intent(in) :: x(n)
      real(dp), intent(inout) :: fvec(m)
      integer, intent(inout) :: iflag
    end subroutine minpack_function
  end interface

  interface
    subroutine lmdif(fcn, m, n, x, fvec, ftol, xtol, gtol, maxfev, epsfcn, diag, mode, factor, nprint, info, nfev, fjac, ldfjac, &
                     ipvt, qtf, wa1, wa2, wa3, wa4)
      !! The arguments are documented in MINPACK.
      import :: dp, minpack_function
      procedure(minpack_function) :: fcn
      integer, intent(in) :: m, n, ldfjac, maxfev, mode, nprint
      real(dp), intent(inout) :: x(n), diag(n)
      real(dp), intent(out) :: fvec(m), fjac(ldfjac, n), qtf(n), wa1(n), wa2(n), wa3(n), wa4(m)
      real(dp), intent(in) :: ftol, xtol, gtol, epsfcn, factor
      integer, intent(out) :: info, nfev, ipvt(n)
    end subroutine lmdif
  end interface

  ! of the current search, as MINPACK passes no context to its function
  class(residual_problem), pointer :: current => null()
  integer :: count_of_current = 0                !! residuals

contains

  subroutine least_squares(problem, count, accuracy, tolerance, v, residuals)
    !! Minimise the sum of squares of the residuals, from the present variables.
    class(residual_problem), intent(inout), target :: problem
    integer, intent(in) :: count                 !! of residuals; may be below the number of variables
    real(dp), intent(in) :: accuracy             !! relative error of the residuals, from which difference steps follow
    real(dp), intent(in) :: tolerance            !! relative decrease of the sum at which iteration stops
    real(dp), intent(inout) :: v(:)              !! −1 ≤ v ≤ 1
    real(dp), allocatable, intent(out) :: residuals(:)   !! at the end, (count)
    real(dp), parameter :: largest_step = 0.5_dp
    real(dp), parameter :: nearest = 1.0e-7_dp   !! to an end of the range at the start: derivatives vanish at the end
    integer, parameter :: evaluations_each = 50
    real(dp) :: x(size(v)), scales(size(v)), qtf(size(v)), work(size(v), 3)
    real(dp), allocatable :: jacobian(:, :), padded(:), last_work(:)
    integer :: m, n, info, evaluations, pivots(size(v))
    n = size(v)
    m = max(count, n)
    allocate (padded(m), jacobian(m, n), last_work(m))
    x = pi - asin(max(nearest - 1, min(1 - nearest, v)))
    scales = 1
    current => problem
    count_of_current = count
    call lmdif(find_padded, m, n, x, padded, tolerance, tolerance, 0.0_dp, evaluations_each*(n + 1), accuracy, scales, 2, &
               largest_step/norm2(x), 0, info, evaluations, jacobian, m, pivots, qtf, work(:, 1), work(:, 2), work(:, 3), last_work)
    nullify (current)
    v = sin(x)
    residuals = padded(:count)
  end subroutine least_squares

  subroutine find_padded(m, n, x, fvec, iflag)
    !! Return the residuals, padded with zeros if there are fewer than variables.
    integer, intent(in) :: m, n
    real(dp), intent(in) :: x(n)
    real(dp), intent(inout) :: fvec(m)
    integer, intent(inout) :: iflag
    fvec = 0
    if (iflag >= 0) call current%find_residuals(sin(x), fvec(:count_of_current))
  end subroutine find_padded

end module bw_least_squares
