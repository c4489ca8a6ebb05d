module bw_fit_escapes
  !! Further places from a fit that noise does not explain: it may be the lesser of several minima, or a line that is no mode
  !! may spoil it.
  use bw_fit_problem, only: fit_problem, position_in
  use bw_fit_search, only: fit_type, place, polish
  use bw_kinds, only: dp
  use bw_lapack, only: dgeqp3, dormqr
  implicit none (type, external)
  private
  public :: fit_with_one_held, fit_without_lines
  public :: leverages                                ! for its own test

contains

  subroutine fit_with_one_held(problem, fit, fits)
    !! Each unknown is held at either end of its range and at the scene's own value while the others are fitted, then let go. So
    !! a fit is not worse than one with fewer unknowns.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(in) :: fit
    type(fit_type), allocatable, intent(inout) :: fits(:)
    real(dp), parameter :: end = 0.999_dp        !! derivatives vanish at 1
    real(dp), allocatable :: residuals(:)
    real(dp) :: held(3)
    integer :: i, j, k, n
    n = size(problem%unknowns)
    do i = 1, n
      held = [-end, end, position_in(problem%unknowns(i), problem%unknowns(i)%start)]
      do j = 1, size(held)
        call place(problem, fit)
        problem%scatter = fit%scatter
        problem%v(i) = held(j)
        problem%free = pack([(k, k=1, n)], [(k /= i, k=1, n)])
        call problem%minimise(residuals, .true.)
        problem%free = [(k, k=1, n)]
        call problem%minimise(residuals, .true.)
        call polish(problem, fits)
      end do
    end do
  end subroutine fit_with_one_held

  subroutine fit_without_lines(problem, fit, fits)
    !! The lines whose absence mends the fit most, as far as residuals are linear, are taken for no modes, lines of the same
    !! frequency together, and what is left is fitted.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(in) :: fit
    type(fit_type), allocatable, intent(inout) :: fits(:)
    integer, parameter :: most = 3               !! frequencies
    real(dp), parameter :: same = 1.0e-3_dp      !! relative
    real(dp), allocatable :: frequency(:), gain(:), residuals(:), group(:)
    integer :: i, j
    call place(problem, fit)
    problem%scatter = fit%scatter
    call find_gains(problem, fit, frequency, gain)
    if (size(gain) < size(problem%unknowns) + 2) return
    group = [(sum(gain, mask=abs(frequency - frequency(j)) < same*frequency(j)), j=1, size(gain))]
    do i = 1, most
      j = maxloc(group, dim=1)
      if (.not. group(j) > 0.0_dp) return
      call set_foreign(.true.)
      call problem%minimise(residuals, .true.)
      call polish(problem, fits)
      call set_foreign(.false.)
      call polish(problem, fits)
      where (abs(frequency - frequency(j)) < same*frequency(j)) group = 0
      call place(problem, fit)
      problem%scatter = fit%scatter
    end do
  contains
    subroutine set_foreign(foreign)
      logical, intent(in) :: foreign
      integer :: s
      do s = 1, size(problem%states)
        associate (state => problem%states(s))
          where (abs(state%lines%frequency - frequency(j)) < same*frequency(j) .and. .not. state%is_harmonic)
            state%foreign = foreign
            state%mode_of = merge(0, state%mode_of, foreign)
          end where
        end associate
      end do
    end subroutine set_foreign
  end subroutine fit_without_lines

  subroutine find_gains(problem, fit, frequency, gain)
    !! By how much the sum of squares falls without each of the lines that are modes: r²/(1 − h), h the diagonal of the matrix that
    !! projects residuals on what the unknowns change.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(in) :: fit
    real(dp), allocatable, intent(out) :: frequency(:), gain(:)   !! (lines that are modes)
    real(dp), parameter :: alone = 1.0e-3_dp     !! 1 − h of a line that some unknown follows wherever it is
    real(dp), allocatable :: jacobian(:, :), leverage(:)
    integer, allocatable :: row(:)
    integer :: i, n
    call problem%find_derivatives(jacobian)
    leverage = leverages(jacobian)
    frequency = [(pack(problem%states(i)%lines%frequency, problem%states(i)%mode_of > 0), i=1, size(problem%states))]
    row = problem%frequency_rows()
    n = size(frequency)
    gain = fit%residuals(row)**2/max(alone, 1 - leverage(row))
    where (1 - leverage(row) < alone) gain = 0
  end subroutine find_gains

  function leverages(jacobian) result(h)
    !! The diagonal of QQᵀ, Q of the factors QR of the derivatives, as many columns of it as are independent.
    real(dp), intent(in) :: jacobian(:, :)       !! (residuals, unknowns)
    real(dp) :: h(size(jacobian, 1))
    real(dp), parameter :: dependent = 1.0e-8_dp !! of a column's length, what is left of it beside the others
    real(dp) :: factors(size(jacobian, 1), size(jacobian, 2)), q(size(jacobian, 1), min(size(jacobian, 1), size(jacobian, 2)))
    real(dp) :: tau(size(q, 2)), work(64*size(jacobian, 2) + 1), length
    integer :: pivot(size(jacobian, 2)), j, m, info
    m = size(jacobian, 1)
    do j = 1, size(jacobian, 2)
      length = norm2(jacobian(:, j))
      factors(:, j) = merge(jacobian(:, j)/max(length, tiny(length)), 0.0_dp, length > 0)
    end do
    pivot = 0
    q = 0
    do j = 1, size(q, 2)
      q(j, j) = 1
    end do
    h = 0
    if (size(q) == 0) return
    call dgeqp3(m, size(factors, 2), factors, m, pivot, tau, work, size(work), info)
    call dormqr('L', 'N', m, size(q, 2), size(q, 2), factors, m, tau, q, m, work, size(work), info)
    do j = 1, size(q, 2)
      if (abs(factors(j, j)) > dependent) h = h + q(:, j)**2
    end do
  end function leverages

end module bw_fit_escapes
