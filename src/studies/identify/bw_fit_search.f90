module bw_fit_search
  !! Local search for a fit, and the choice among several fits.
  !!
  !! Assignment of lines and fit of unknowns alternate until nothing changes, with a scatter τ of the model that is
  !! large at first. In the end τ is 0 if the noise of the lines explains the residuals; else it makes the sum of
  !! squares equal to its degrees of freedom (Mandel & Paule), so that very accurate lines do not outweigh all others.
  !! The error of amplitudes is set likewise, and is at least that of sensors: wrong shapes or a wrong scale of the
  !! hammer do not bias what frequencies determine.
  use bw_measured_state, only: sensor_error
  use bw_fit_problem, only: fit_problem, is_at_end
  use bw_kinds, only: dp
  use bw_quantile, only: chi_squared_tail
  implicit none (type, external)
  private
  public :: add_fit, estimate_model_error, is_near, misfit_of, place, refine_fits, search, choose_fit

  real(dp), parameter, public :: misfit_chance = 1.0e-3_dp    !! probability below which noise does not explain a misfit
  real(dp), parameter, public :: first_scatter = 0.05_dp !! lower bound of τ at the start of a search
  integer, parameter :: halvings = 40            !! of a logarithmic interval
  real(dp), parameter :: merged = 0.02_dp                !! of half the range, within which two fits are the same

  type, public :: misfit_type
    !! How well modes explain lines.
    real(dp) :: chi_squared = 0.0_dp             !! Σ((f_line − f)/s)², and penalties of lines taken for no modes
    integer :: freedom = 0                       !! degrees of freedom of χ²
    real(dp) :: tail = 1.0_dp                    !! probability of a larger χ² by noise alone
    real(dp) :: scatter = 0.0_dp                 !! τ
    real(dp) :: amplitude_error = sensor_error   !! relative to the largest amplitude of a line
    integer :: aside = 0                         !! lines taken for no modes that may well be some
  end type misfit_type

  type, extends(misfit_type), public :: fit_type
    !! A fit, and its misfit if it is a minimum.
    real(dp), allocatable :: v(:)                !! of the unknowns in their ranges, (unknowns)
    integer, allocatable :: mode_of(:)           !! of the lines of all states, one state after another; 0: no mode
    real(dp) :: penalty = huge(1.0_dp)             !! −2 ln likelihood, up to a constant
    integer :: spare = 0                         !! residuals less unknowns
    real(dp) :: sum = 0.0_dp                     !! of squares with τ
    real(dp), allocatable :: residuals(:)        !! with τ
  end type fit_type

contains

  subroutine search(problem, fits)
    !! Alternate assignment and fit from the present unknowns, and append the result.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), allocatable, intent(inout) :: fits(:)
    real(dp), parameter :: finer(2) = [first_scatter, 0.1_dp*first_scatter]
    real(dp), allocatable :: residuals(:)
    real(dp) :: penalty
    logical :: changed
    integer :: round
    do round = 1, size(finer)
      call problem%match(finer(round), penalty, changed)
      call explain_amplitudes(problem)
      call problem%minimise(residuals, .true.)
    end do
    call refine_fits(problem, fits)
  end subroutine search

  subroutine refine_fits(problem, fits)
    !! Do the same from a place where the assignment is nearly right.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), allocatable, intent(inout) :: fits(:)
    integer, parameter :: most_rounds = 6
    type(fit_type) :: fit
    real(dp), allocatable :: residuals(:)
    logical :: changed
    integer :: round
    do round = 1, most_rounds
      call problem%match(0.0_dp, fit%penalty, changed)
      if (round > 1 .and. .not. changed) exit
      call explain_amplitudes(problem)
      call problem%minimise(residuals, .true.)
    end do
    call place_at(problem, fit)
    call add_fit(fits, fit)
  end subroutine refine_fits

  subroutine choose_fit(problem, fits, fit)
    !! Choose the fit of least penalty with τ = 0 or, if noise does not explain its residuals, with the τ that does.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(in) :: fits(:)
    type(fit_type), intent(inout) :: fit
    integer, parameter :: most_rounds = 8
    real(dp), parameter :: same = 1.0e-3_dp
    real(dp) :: before(2)
    integer :: round
    fit = fits(minloc(fits%penalty, dim=1))
    call place(problem, fit)
    problem%scatter = 0
    call take_least(problem, fits, fit)
    fit%misfit_type = misfit_of(problem, fit%residuals)
    fit%spare = problem%count_tested() - size(problem%free)
    do round = 1, most_rounds
      before = [problem%scatter, problem%amplitude_error]
      call explain_amplitudes(problem)
      if (fit%tail < misfit_chance) call estimate_model_error(problem)
      if (all(abs([problem%scatter, problem%amplitude_error] - before) <= same*before)) exit
      if (round == 1) call take_least(problem, fits, fit)
      if (round > 1) call problem%minimise(fit%residuals, .false.)
    end do
    call place_at(problem, fit)
    fit%sum = sum(fit%residuals**2)
  end subroutine choose_fit

  subroutine take_least(problem, fits, fit)
    !! Fit at this τ from the present place and from all fits with the same assignment.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(in) :: fits(:)
    type(fit_type), intent(inout) :: fit
    real(dp), parameter :: same = 1.0e-4_dp      !! of half the range: another fit from there gains nothing
    real(dp), allocatable :: best(:), residuals(:)
    integer :: i, j
    call problem%minimise(fit%residuals, .false.)
    best = problem%v
    do i = 1, size(fits)
      if (any(fits(i)%mode_of /= fit%mode_of)) cycle
      if (any([(maxval(abs(fits(i)%v - fits(j)%v)) < same, j=1, i - 1)]) .or. maxval(abs(fits(i)%v - best)) < same) cycle
      problem%v = fits(i)%v
      call problem%minimise(residuals, .true.)
      if (.not. sum(residuals**2) < sum(fit%residuals**2)) cycle
      call problem%minimise(fit%residuals, .false.)
      best = problem%v
    end do
    problem%v = best
  end subroutine take_least

  type(misfit_type) function misfit_of(problem, residuals) result(misfit)
    !! Find the misfit of the present fit. An unknown at the end of its range takes no degree of freedom; a line that may be a
    !! mode and is taken for none counts as a residual of square 2 ln odds. Below one degree of freedom the test assumes one.
    type(fit_problem), intent(in) :: problem
    real(dp), intent(in) :: residuals(:)         !! with τ = 0
    real(dp), allocatable :: odds(:)             ! of lines taken for no modes to be modes
    integer :: i
    odds = [(problem%states(i)%odds_left(), i=1, size(problem%states))]
    misfit%aside = size(odds)
    misfit%chi_squared = sum(residuals(:problem%count_tested())**2) + 2*sum(log(odds))
    misfit%freedom = problem%count_tested() + misfit%aside - count(.not. is_at_end(problem%v(problem%free)))
    misfit%tail = chi_squared_tail(misfit%chi_squared, max(1, misfit%freedom))
  end function misfit_of

  subroutine estimate_model_error(problem)
    !! Set τ so that the sum of squares of the tested residuals equals its degrees of freedom.
    type(fit_problem), intent(inout) :: problem
    real(dp) :: low, high, residuals(problem%count())
    integer :: i, freedom
    freedom = max(1, problem%count_tested() - count(.not. is_at_end(problem%v(problem%free))))
    low = log(1.0e-12_dp)
    high = 0
    do i = 1, halvings
      problem%scatter = exp(0.5_dp*(low + high))
      call problem%find_residuals(problem%v(problem%free), residuals)
      if (sum(residuals(:problem%count_tested())**2) > freedom) low = log(problem%scatter)
      if (sum(residuals(:problem%count_tested())**2) <= freedom) high = log(problem%scatter)
    end do
  end subroutine estimate_model_error

  subroutine explain_amplitudes(problem)
    !! Set the error of amplitudes likewise; at least that of sensors.
    type(fit_problem), intent(inout) :: problem
    real(dp) :: low, high, residuals(problem%count())
    integer :: i, freedom, tested
    problem%amplitude_error = sensor_error
    freedom = problem%amplitude_freedom()
    tested = problem%count_tested()
    low = log(sensor_error)
    high = -low                                  ! a scale may be wrong by a factor of 100
    do i = 1, halvings
      call problem%find_residuals(problem%v(problem%free), residuals)
      if (i == 1 .and. sum(residuals(tested + 1:)**2) <= freedom) return
      if (sum(residuals(tested + 1:)**2) > freedom) low = log(problem%amplitude_error)
      if (sum(residuals(tested + 1:)**2) <= freedom) high = log(problem%amplitude_error)
      problem%amplitude_error = exp(0.5_dp*(low + high))
    end do
  end subroutine explain_amplitudes

  subroutine place(problem, fit)
    !! Set the problem to a fit: its unknowns and its assignment.
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
    !! Store the present fit of the problem.
    type(fit_problem), intent(in) :: problem
    type(fit_type), intent(inout) :: fit
    integer :: i
    fit%v = problem%v
    fit%mode_of = [(problem%states(i)%mode_of, i=1, size(problem%states))]
    fit%scatter = problem%scatter
    fit%amplitude_error = problem%amplitude_error
  end subroutine place_at

  pure logical function is_near(one, other)
    !! Return whether two fits are the same place.
    type(fit_type), intent(in) :: one, other
    is_near = maxval(abs(one%v - other%v)) < merged
  end function is_near

  subroutine add_fit(fits, fit)
    !! Append a fit to a list. (Array constructors of such types leak in gfortran 12.)
    type(fit_type), allocatable, intent(inout) :: fits(:)
    type(fit_type), intent(in) :: fit
    type(fit_type), allocatable :: more(:)
    integer :: n
    n = size(fits)
    allocate (more(n + 1))
    more(:n) = fits
    more(n + 1) = fit
    call move_alloc(more, fits)
  end subroutine add_fit

end module bw_fit_search
