module bw_least_squares
  !! The least sum of squares of residuals inside of ranges, by MINPACK's `lmdif`: the method of Levenberg and Marquardt as Moré
  !! has it, derivatives by differences.
  !!
  !! MINPACK knows no ranges. A variable v, −1 ≤ v ≤ 1, is therefore the sine of the one that it changes, which leaves no
  !! range by any step and has a minimum at the end of the range where the residuals have theirs beyond it.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: least_squares

  type, abstract, public :: residual_problem
    !! Residuals that depend on variables.
  contains
    procedure(residuals_interface), deferred :: find_residuals
  end type residual_problem

  abstract interface
    subroutine residuals_interface(self, v, residuals)
      !! Find the residuals of these variables.
      import :: dp, residual_problem
      implicit none (type, external)
      class(residual_problem), intent(inout) :: self
      real(dp), intent(in) :: v(:)               !! −1 ≤ v ≤ 1, (variables)
      real(dp), intent(out) :: residuals(:)      !! finite
    end subroutine residuals_interface

    subroutine minpack_function(m, n, x, fvec, iflag)
      !! As MINPACK asks for residuals.
      import :: dp
      implicit none (type, external)
      integer, intent(in) :: m, n
      real(dp), intent(in) :: x(n)
      real(dp), intent(inout) :: fvec(m)
      integer, intent(inout) :: iflag
    end subroutine minpack_function
  end interface

  interface
    subroutine lmdif(fcn, m, n, x, fvec, ftol, xtol, gtol, maxfev, epsfcn, diag, mode, factor, nprint, info, nfev, fjac, &
                     ldfjac, ipvt, qtf, wa1, wa2, wa3, wa4)
      !! MINPACK's own documentation says what each argument is.
      import :: dp, minpack_function
      implicit none (type, external)
      procedure(minpack_function) :: fcn
      integer, intent(in) :: m, n, maxfev, mode, nprint, ldfjac
      real(dp), intent(inout) :: x(n), diag(n)
      real(dp), intent(out) :: fvec(m), fjac(ldfjac, n), qtf(n), wa1(n), wa2(n), wa3(n), wa4(m)
      real(dp), intent(in) :: ftol, xtol, gtol, epsfcn, factor
      integer, intent(out) :: info, nfev, ipvt(n)
    end subroutine lmdif
  end interface

  real(dp), parameter :: nearest = 1.0e-7_dp     !! to an end of the range, where a search begins: derivatives vanish at the end
  class(residual_problem), pointer :: current => null()   !! the problem that MINPACK is at: it passes nothing on to `fcn`

contains

  subroutine least_squares(problem, count, accuracy, v, residuals, evaluations)
    !! Change variables until the sum of squares of the residuals is least, from where they are.
    class(residual_problem), intent(inout), target :: problem
    integer, intent(in) :: count                 !! of the residuals; fewer than variables are allowed
    real(dp), intent(in) :: accuracy             !! relative error of the residuals' model, from which steps of differences follow
    real(dp), intent(inout) :: v(:)              !! −1 ≤ v ≤ 1
    real(dp), allocatable, intent(out) :: residuals(:)   !! at the end, (count)
    integer, intent(out) :: evaluations
    real(dp), parameter :: tolerance = 1.0e-9_dp, largest_step = 0.5_dp
    integer, parameter :: evaluations_each = 40  !! variable
    real(dp) :: u(size(v)), scales(size(v)), qtf(size(v)), work(size(v), 3)
    real(dp), allocatable :: jacobian(:, :), fvec(:), last_work(:)
    integer :: m, n, info, pivots(size(v))
    n = size(v)
    m = max(count, n)
    allocate (fvec(m), jacobian(m, n), last_work(m))
    u = asin(max(nearest - 1, min(1 - nearest, v)))
    scales = 1
    current => problem
    call lmdif(find_padded, m, n, u, fvec, tolerance, tolerance, 0.0_dp, evaluations_each*(n + 1), accuracy, scales, 2, &
               largest_step, 0, info, evaluations, jacobian, m, pivots, qtf, work(:, 1), work(:, 2), work(:, 3), last_work)
    nullify (current)
    v = sin(u)
    residuals = fvec(:count)
  end subroutine least_squares

  subroutine find_padded(m, n, x, fvec, iflag)
    !! The residuals of the current problem, with zeros behind them where there are fewer than variables.
    integer, intent(in) :: m, n
    real(dp), intent(in) :: x(n)
    real(dp), intent(inout) :: fvec(m)
    integer, intent(inout) :: iflag
    fvec = 0
    if (iflag < 0) return
    call current%find_residuals(sin(x), fvec)
  end subroutine find_padded

end module bw_least_squares
