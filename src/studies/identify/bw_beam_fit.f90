module bw_beam_fit
  !! The unknowns that fit the lines best, from several starts, and any other place that fits as well.
  !!
  !! From each start lines are assigned, unknowns fitted, and lines assigned anew until nothing changes, with a scatter τ of
  !! the model that is large at first. In the end τ is 0 if the noise of the lines explains what is left of them; else it is
  !! as large as to explain it (Mandel & Paule: the sum of squares is its number of degrees of freedom), so that lines that
  !! were measured to many more digits than the model has do not outweigh all others.
  use bw_fit_problem, only: chi_squared_tail, fit_problem, position_in
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: explain, fit_beam

  real(dp), parameter, public :: unlikely = 1.0e-3_dp    !! probability below which noise does not explain a misfit
  real(dp), parameter :: first_scatter = 0.05_dp         !! τ is not below, where a search begins
  real(dp), parameter :: merged = 0.02_dp                !! of half the range, within which two fits are one
  integer, parameter :: searched = 4                     !! starts from which is searched: those that cost least at once
  integer, parameter :: searched_on = 12                 !! where noise does not explain what is found from these
  integer, parameter :: looks_each = 16                  !! starts that are looked at, for each unknown
  integer, parameter :: primes(12) = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37]

  type, public :: fit_type
    !! A place that fits.
    real(dp), allocatable :: v(:)                !! of the unknowns in their ranges, (unknowns)
    integer, allocatable :: mode_of(:)           !! of the lines of all states, one state after another; 0: no mode
    real(dp) :: price = huge(1.0_dp)             !! −2 ln of its likelihood, apart from a constant
    real(dp) :: chi_squared = 0.0_dp             !! Σ((f_line − f)/s)² where that is least, with τ = 0
    integer :: freedom = 0                       !! residuals less unknowns
    real(dp) :: tail = 1.0_dp                    !! probability of a larger χ² by noise alone; 1 without a degree of freedom
    real(dp) :: scatter = 0.0_dp                 !! τ
    real(dp) :: sum = 0.0_dp                     !! of squares with τ
    real(dp), allocatable :: residuals(:)        !! with τ
  end type fit_type

contains

  subroutine fit_beam(problem, as_good, thorough, fit, others)
    !! Find the best fit, at which the problem is left, and others that are as good.
    type(fit_problem), intent(inout) :: problem
    real(dp), intent(in) :: as_good              !! −2 ln of the likelihood over that of the best, up to which a fit is as good
    logical, intent(in) :: thorough              !! look further where noise does not explain the misfit: in seconds
    type(fit_type), intent(out) :: fit
    type(fit_type), allocatable, intent(out) :: others(:)
    type(fit_type), allocatable :: fits(:)
    real(dp), allocatable :: starts(:, :)
    integer :: i, j
    problem%free = [(i, i=1, size(problem%unknowns))]
    call choose_starts(problem, starts)
    allocate (fits(searched_on), others(0))
    do i = 1, searched_on
      problem%v = starts(:, i)
      call search(problem, fits(i))
      if (fits(i)%price < fit%price) fit = fits(i)
      if (i < searched) cycle
      if (i > searched .and. .not. thorough) exit
      if (i == searched .or. all(fits(:i - 1)%price > fits(i)%price)) call settle(problem, fit)
      if (.not. fit%tail < unlikely) exit
    end do
    do i = 1, size(fits)
      if (fits(i)%price > fit%price + as_good) cycle
      if (is_near(fits(i), fit)) cycle
      if (any([(is_near(fits(i), others(j)), j=1, size(others))])) cycle
      call add(others, fits(i))
    end do
    if (fit%tail < unlikely .and. thorough) call drop_lines(problem, starts, fit)
    call place(problem, fit)
    problem%scatter = fit%scatter
  end subroutine fit_beam

  subroutine choose_starts(problem, starts)
    !! Where searches begin: the scene's own values, and those of evenly spread points of the ranges that cost least.
    type(fit_problem), intent(inout) :: problem
    real(dp), allocatable, intent(out) :: starts(:, :)   !! (unknowns, starts)
    real(dp), allocatable :: looks(:, :), price(:)
    logical :: changed
    integer :: i, n, best
    n = size(problem%unknowns)
    allocate (looks(n, 1 + looks_each*n), price(1 + looks_each*n))
    looks(:, 1) = position_in(problem%unknowns, problem%unknowns%start)
    do i = 2, size(price)
      looks(:, i) = 2*radical_inverse(i - 1, primes(:n)) - 1
    end do
    do i = 1, size(price)
      problem%v = looks(:, i)
      call problem%match(first_scatter, price(i), changed)
    end do
    price(1) = -huge(price)
    allocate (starts(n, searched_on))
    do i = 1, searched_on
      best = minloc(price, dim=1)
      starts(:, i) = looks(:, best)
      price(best) = huge(price)
    end do
  end subroutine choose_starts

  elemental real(dp) function radical_inverse(i, base) result(x)
    !! Number i in a base, mirrored at the point: Halton's sequence.
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

  subroutine search(problem, fit)
    !! Assign and fit in turn from where the unknowns are.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(inout) :: fit
    integer, parameter :: most_rounds = 8
    real(dp), parameter :: finer(3) = [first_scatter, 0.1_dp*first_scatter, 0.0_dp]
    real(dp), allocatable :: residuals(:)
    logical :: changed
    integer :: round
    do round = 1, most_rounds
      call problem%match(finer(min(round, size(finer))), fit%price, changed)
      if (round > size(finer) .and. .not. changed) exit
      call problem%minimise(residuals)
    end do
    call place_at(problem, fit)
  end subroutine search

  subroutine settle(problem, fit)
    !! Fit with τ = 0; where noise does not explain what is left, with the τ that does.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(inout) :: fit
    integer, parameter :: most_rounds = 8
    real(dp), parameter :: same = 1.0e-3_dp
    real(dp) :: before
    integer :: round
    call place(problem, fit)
    problem%scatter = 0
    call problem%minimise(fit%residuals)
    fit%chi_squared = sum(fit%residuals(:problem%count_tested())**2)
    fit%freedom = problem%count_tested() - size(problem%free)
    fit%tail = 1
    if (fit%freedom > 0) fit%tail = chi_squared_tail(fit%chi_squared, fit%freedom)
    if (fit%tail < unlikely) then
      do round = 1, most_rounds
        before = problem%scatter
        call explain(problem, fit%freedom)
        call problem%minimise(fit%residuals)
        if (abs(problem%scatter - before) <= same*before) exit
      end do
    end if
    call place_at(problem, fit)
    fit%sum = sum(fit%residuals**2)
  end subroutine settle

  subroutine explain(problem, freedom)
    !! Set τ so that the sum of squares of what is tested, where the unknowns are, is its number of degrees of freedom.
    type(fit_problem), intent(inout) :: problem
    integer, intent(in) :: freedom
    integer, parameter :: halvings = 40
    real(dp) :: low, high, ignored(problem%count())
    integer :: i
    low = log(1.0e-12_dp)
    high = 0
    do i = 1, halvings
      problem%scatter = exp(0.5_dp*(low + high))
      call problem%find_residuals(problem%v(problem%free), ignored)
      if (sum(ignored(:problem%count_tested())**2) > freedom) low = log(problem%scatter)
      if (sum(ignored(:problem%count_tested())**2) <= freedom) high = log(problem%scatter)
    end do
  end subroutine explain

  subroutine drop_lines(problem, starts, fit)
    !! A line that is no mode may have been taken for one and spoil the fit: set aside each in turn, and keep what costs least.
    type(fit_problem), intent(inout) :: problem
    real(dp), intent(in) :: starts(:, :)
    type(fit_type), intent(inout) :: fit
    type(fit_type) :: trial, best
    logical :: changed
    integer :: i, k, start
    call problem%match(0.0_dp, fit%price, changed)
    best = fit
    do i = 1, size(problem%states)
      do k = 1, size(problem%states(i)%foreign)
        if (problem%states(i)%foreign(k)) cycle
        problem%states(i)%foreign(k) = .true.
        do start = 0, size(starts, 2)
          problem%v = fit%v
          if (start > 0) problem%v = starts(:, start)
          call search(problem, trial)
          if (trial%price < best%price) best = trial
        end do
        problem%states(i)%foreign(k) = .false.
      end do
    end do
    if (.not. best%price < fit%price) return
    call settle(problem, best)
    fit = best
  end subroutine drop_lines

  subroutine place(problem, fit)
    !! Bring the problem to a fit: its unknowns and its assignment.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(in) :: fit
    integer :: i, n
    problem%v = fit%v
    n = 0
    do i = 1, size(problem%states)
      associate (mode_of => problem%states(i)%mode_of)
        mode_of = fit%mode_of(n + 1:n + size(mode_of))
        n = n + size(mode_of)
      end associate
    end do
  end subroutine place

  subroutine place_at(problem, fit)
    !! The fit that the problem is at.
    type(fit_problem), intent(in) :: problem
    type(fit_type), intent(inout) :: fit
    integer :: i
    fit%v = problem%v
    fit%scatter = problem%scatter
    fit%mode_of = [integer ::]
    do i = 1, size(problem%states)
      fit%mode_of = [fit%mode_of, problem%states(i)%mode_of]
    end do
  end subroutine place_at

  pure logical function is_near(one, other)
    !! Two fits are the same place.
    type(fit_type), intent(in) :: one, other
    is_near = maxval(abs(one%v - other%v)) < merged
  end function is_near

  subroutine add(fits, fit)
    !! One more fit in a list. (Array constructors of such types leak in gfortran 12.)
    type(fit_type), allocatable, intent(inout) :: fits(:)
    type(fit_type), intent(in) :: fit
    type(fit_type), allocatable :: more(:)
    integer :: n
    n = size(fits)
    allocate (more(n + 1))
    more(:n) = fits
    more(n + 1) = fit
    call move_alloc(more, fits)
  end subroutine add

end module bw_beam_fit
