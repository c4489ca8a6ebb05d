module bw_least_squares
  !! The least sum of squares of residuals inside of ranges, by MINPACK's `lmder`: the method of Levenberg and Marquardt as Moré
  !! has it.
  !!
  !! Residuals are dear, and derivatives by differences take as many of them as there are variables. So derivatives are taken
  !! once, and mended by Broyden's formula from what each step brings (J gains (Δr − Js)sᵀ/s²), as long as the step was about
  !! what they had foretold. Where a search ends with mended derivatives it goes on with true ones.
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

    subroutine minpack_function(m, n, x, fvec, fjac, ldfjac, iflag)
      !! As MINPACK asks for residuals (1) and derivatives (2).
      import :: dp
      implicit none (type, external)
      integer, intent(in) :: m, n, ldfjac
      real(dp), intent(in) :: x(n)
      real(dp), intent(inout) :: fvec(m), fjac(ldfjac, n)
      integer, intent(inout) :: iflag
    end subroutine minpack_function
  end interface

  interface
    subroutine lmder(fcn, m, n, x, fvec, fjac, ldfjac, ftol, xtol, gtol, maxfev, diag, mode, factor, nprint, info, nfev, njev, &
                     ipvt, qtf, wa1, wa2, wa3, wa4)
      !! MINPACK's own documentation says what each argument is.
      import :: dp, minpack_function
      implicit none (type, external)
      procedure(minpack_function) :: fcn
      integer, intent(in) :: m, n, ldfjac, maxfev, mode, nprint
      real(dp), intent(inout) :: x(n), diag(n)
      real(dp), intent(out) :: fvec(m), fjac(ldfjac, n), qtf(n), wa1(n), wa2(n), wa3(n), wa4(m)
      real(dp), intent(in) :: ftol, xtol, gtol, factor
      integer, intent(out) :: info, nfev, njev, ipvt(n)
    end subroutine lmder
  end interface

  type :: search_type
    !! The search that MINPACK is at: it passes nothing on to its function.
    class(residual_problem), pointer :: problem => null()
    integer :: count = 0                         !! of residuals; zeros follow where there are fewer than variables
    real(dp) :: step = 0.0_dp                    !! of differences
    real(dp), allocatable :: x(:), f(:)          !! where derivatives were found last
    real(dp), allocatable :: jacobian(:, :)      !! there; unallocated: none are known yet
    logical :: mended = .false.                  !! they are no true ones
    integer :: evaluations = 0
  end type search_type

  real(dp), parameter :: nearest = 1.0e-7_dp     !! to an end of the range, where a search begins: derivatives vanish at the end
  type(search_type) :: current

contains

  subroutine least_squares(problem, count, accuracy, tolerance, v, residuals, evaluations)
    !! Change variables until the sum of squares of the residuals is least, from where they are.
    class(residual_problem), intent(inout), target :: problem
    integer, intent(in) :: count                 !! of the residuals; fewer than variables are allowed
    real(dp), intent(in) :: accuracy             !! relative error of the residuals' model, from which steps of differences follow
    real(dp), intent(in) :: tolerance            !! relative, of the sum, that a step must gain for another to follow
    real(dp), intent(inout) :: v(:)              !! −1 ≤ v ≤ 1
    real(dp), allocatable, intent(out) :: residuals(:)   !! at the end, (count)
    integer, intent(out) :: evaluations
    real(dp), parameter :: largest_step = 0.5_dp, precise = 1.0e-6_dp
    integer, parameter :: evaluations_each = 20, most_legs = 4
    real(dp) :: u(size(v)), scales(size(v)), qtf(size(v)), work(size(v), 3)
    real(dp), allocatable :: jacobian(:, :), fvec(:), last_work(:)
    integer :: m, n, info, tries, fresh, leg, pivots(size(v))
    n = size(v)
    m = max(count, n)
    allocate (fvec(m), jacobian(m, n), last_work(m))
    u = asin(max(nearest - 1, min(1 - nearest, v)))
    scales = 1
    current%problem => problem
    current%count = count
    current%step = sqrt(accuracy)
    do leg = 1, most_legs
      call lmder(find_padded, m, n, u, fvec, jacobian, m, tolerance, tolerance, 0.0_dp, evaluations_each*(n + 1), scales, 2, &
                 largest_step, 0, info, tries, fresh, pivots, qtf, work(:, 1), work(:, 2), work(:, 3), last_work)
      if (.not. current%mended .or. tolerance > precise) exit
      deallocate (current%jacobian)
    end do
    evaluations = current%evaluations
    current = search_type()
    v = sin(u)
    residuals = fvec(:count)
  end subroutine least_squares

  subroutine find_padded(m, n, x, fvec, fjac, ldfjac, iflag)
    !! The residuals of the current problem, or their derivatives at the place where they were found last.
    integer, intent(in) :: m, n, ldfjac
    real(dp), intent(in) :: x(n)
    real(dp), intent(inout) :: fvec(m), fjac(ldfjac, n)
    integer, intent(inout) :: iflag
    if (iflag == 1) then
      call find_at(x, fvec)
    else if (iflag == 2) then
      call find_derivatives(x, fvec)
      fjac(:m, :) = current%jacobian
    end if
  end subroutine find_padded

  subroutine find_at(x, f)
    !! Residuals, with zeros behind them where there are fewer than variables.
    real(dp), intent(in) :: x(:)
    real(dp), intent(out) :: f(:)
    f = 0
    current%evaluations = current%evaluations + 1
    call current%problem%find_residuals(sin(x), f(:current%count))
  end subroutine find_at

  subroutine find_derivatives(x, f)
    !! Mend the derivatives of the last place, or take differences where there are none, or where these foretold the step ill.
    real(dp), intent(in) :: x(:), f(:)           !! residuals there
    real(dp), parameter :: ill = 0.3_dp          !! error of what was foretold, over the change of the residuals
    real(dp), parameter :: least = 0.1_dp        !! variable that a step of differences is a share of
    real(dp) :: step(size(x)), error(size(f)), moved(size(x)), there(size(f))
    integer :: i
    if (allocated(current%jacobian)) then
      step = x - current%x
      if (.not. any(abs(step) > 0.0_dp)) return
      error = f - current%f - matmul(current%jacobian, step)
      current%mended = norm2(error) <= ill*norm2(f - current%f)
      if (current%mended) current%jacobian = current%jacobian + &
        spread(error/sum(step**2), 2, size(x))*spread(step, 1, size(f))
    else
      allocate (current%jacobian(size(f), size(x)))
      current%mended = .false.
    end if
    if (.not. current%mended) then
      do i = 1, size(x)
        moved = x
        moved(i) = x(i) + current%step*max(abs(x(i)), least)
        call find_at(moved, there)
        current%jacobian(:, i) = (there - f)/(moved(i) - x(i))
      end do
    end if
    current%x = x
    current%f = f
  end subroutine find_derivatives

end module bw_least_squares
