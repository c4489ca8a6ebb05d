module bw_beam_fit
  !! The best fit of the unknowns to the lines, from several starts, and other fits that are as good.
  use bw_fit_problem, only: fit_problem, position_in
  use bw_fit_search, only: add_fit, first_scatter, fit_type, is_near, place, refine_fits, search, choose_fit, misfit_chance
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: fit_beam, refit_from

  integer, parameter :: searched = 4             !! starts of full searches: those of least penalty
  integer, parameter :: searched_on = 12         !! if the result of these is in doubt
  integer, parameter :: looks_each = 16                  !! points evaluated for each unknown
  integer, parameter :: primes(12) = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37]

contains

  subroutine fit_beam(problem, as_good, thorough, fit, others, near)
    !! Find the best fit, to which the problem is set, and others that are as good.
    type(fit_problem), intent(inout) :: problem
    real(dp), intent(in) :: as_good              !! difference in −2 ln likelihood from the best within which a fit is as good
    logical, intent(in) :: thorough              !! search further if noise does not explain the misfit
    type(fit_type), intent(out) :: fit
    type(fit_type), allocatable, intent(out) :: others(:)
    real(dp), intent(in), optional :: near(:)    !! a fit of fewer unknowns, below which this one cannot fall, (unknowns)
    type(fit_type), allocatable :: fits(:)
    real(dp) :: starts(size(problem%unknowns), searched_on)
    integer :: i, n
    problem%free = [(i, i=1, size(problem%unknowns))]
    call choose_starts(problem, first_scatter, starts)
    allocate (fits(0))
    if (present(near)) then
      problem%v = near
      call refine_fits(problem, fits)
    end if
    do i = 1, searched_on
      problem%v = starts(:, i)
      call search(problem, fits)
      if (i < searched) cycle
      n = size(fits)
      if (i == searched .or. all(fits(:n - 1)%penalty > fits(n)%penalty)) call choose_fit(problem, fits, fit)
      if (.not. (is_doubtful(fit) .and. thorough)) exit
    end do
    if (is_doubtful(fit) .and. thorough) call leave_out_each(problem, fits, fit)
    problem%scatter = fit%scatter
    problem%amplitude_error = fit%amplitude_error
    call find_others(problem, fits, fit, as_good, others)
    call place(problem, fit)
  end subroutine fit_beam

  subroutine choose_starts(problem, scatter, starts)
    !! Choose the scene's own values, and the points of least penalty of an even spread over the ranges.
    type(fit_problem), intent(inout) :: problem
    real(dp), intent(in) :: scatter              !! lower bound of τ
    real(dp), intent(out) :: starts(:, :)        !! (unknowns, starts)
    real(dp), allocatable :: looks(:, :), penalty(:)
    logical :: changed
    integer :: i, n, best
    n = size(problem%unknowns)
    allocate (looks(n, 1 + looks_each*n), penalty(1 + looks_each*n))
    looks(:, 1) = position_in(problem%unknowns, problem%unknowns%start)
    do i = 2, size(penalty)
      looks(:, i) = 2*radical_inverse(i - 1, primes(:n)) - 1
    end do
    do i = 1, size(penalty)
      problem%v = looks(:, i)
      call problem%match(scatter, penalty(i), changed)
    end do
    penalty(1) = -huge(penalty)
    do i = 1, size(starts, 2)
      best = minloc(penalty, dim=1)
      starts(:, i) = looks(:, best)
      penalty(best) = huge(penalty)
    end do
  end subroutine choose_starts

  elemental real(dp) function radical_inverse(i, base) result(x)
    !! Return number i in a base, mirrored at the point: Halton's sequence.
    integer, intent(in) :: i, base
    real(dp) :: digit
    integer :: left
    x = 0
    digit = 1.0_dp/base
    left = i
    do while (left > 0)
      x = x + digit*mod(left, base)
      left = left/base
      digit = digit/base
    end do
  end function radical_inverse

  subroutine leave_out_each(problem, fits, fit)
    !! Look for a better fit from this one without one of its lines: a spurious line that is near an undetected mode
    !! draws the unknowns away.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), allocatable, intent(inout) :: fits(:)
    type(fit_type), intent(inout) :: fit
    type(fit_type) :: without
    real(dp), allocatable :: residuals(:)
    real(dp) :: least
    integer :: i
    least = minval(fits%penalty)
    do i = 1, size(fit%mode_of)
      if (fit%mode_of(i) == 0) cycle
      without = fit
      without%mode_of(i) = 0
      call place(problem, without)
      problem%scatter = fit%scatter
      call problem%minimise(residuals, .true.)
      call refine_fits(problem, fits)
    end do
    if (minval(fits%penalty) < least) call choose_fit(problem, fits, fit)
  end subroutine leave_out_each

  pure logical function is_doubtful(fit)
    !! Return whether noise does not explain a fit, or it explains no more lines than it has unknowns and omits others.
    type(fit_type), intent(in) :: fit
    is_doubtful = fit%tail < misfit_chance .or. (fit%spare < 1 .and. any(fit%mode_of == 0))
  end function is_doubtful

  subroutine refit_from(problem, v, fit)
    !! Fit again from a better place.
    type(fit_problem), intent(inout) :: problem
    real(dp), intent(in) :: v(:)
    type(fit_type), intent(inout) :: fit
    type(fit_type), allocatable :: fits(:)
    allocate (fits(0))
    problem%v = v
    call refine_fits(problem, fits)
    call choose_fit(problem, fits, fit)
  end subroutine refit_from

  subroutine find_others(problem, fits, fit, as_good, others)
    !! Find other places about as probable as the fit: by the sum of squares with its τ if the assignment of lines is
    !! the same, else by the penalty.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(in) :: fits(:), fit
    real(dp), intent(in) :: as_good
    type(fit_type), allocatable, intent(out) :: others(:)
    type(fit_type) :: other
    integer :: i, j
    allocate (others(0))
    do i = 1, size(fits)
      other = fits(i)
      if (is_near(other, fit)) cycle
      if (all(other%mode_of == fit%mode_of)) then
        call place(problem, other)
        call problem%minimise(other%residuals, .false.)
        other%v = problem%v
        other%sum = sum(other%residuals**2)
        if (.not. other%sum < fit%sum + as_good) cycle
      else if (.not. other%penalty < minval(fits%penalty) + as_good) then
        cycle
      end if
      if (is_near(other, fit) .or. any([(is_near(other, others(j)), j=1, size(others))])) cycle
      call add_fit(others, other)
    end do
  end subroutine find_others

end module bw_beam_fit
