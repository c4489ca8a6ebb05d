module bw_identification
  !! Identification of a beam from measured lines: unknowns with intervals, unknowns that the record does not determine,
  !! and a test whether the model explains the lines.
  use bw_beam_fit, only: fit_beam, refit_from
  use bw_measured_state, only: measured_state
  use bw_fit_intervals, only: fit_uncertainty, find_intervals, interval_type
  use bw_fit_problem, only: fit_problem, is_at_end, problem_of, value_at
  use bw_fit_search, only: fit_type, place, misfit_chance
  use bw_identify_par, only: identify_par
  use bw_kinds, only: dp
  use bw_missing, only: missing
  implicit none (type, external)
  private
  public :: identify

  real(dp), parameter :: hardly_fixed = 0.25_dp  !! fraction of its range from which an unknown counts as undetermined
  real(dp), parameter :: together = 0.95_dp      !! correlation from which two unknowns cannot be separated

  type, public :: undetermined_direction
    !! An unknown that the record does not determine, and another that compensates for it.
    integer :: unknown = 0
    integer :: partner = 0                       !! 0: none compensates, the record is insensitive to it
    real(dp), allocatable :: one(:), other(:)    !! all unknowns at two places that fit equally well, (unknowns)
  end type undetermined_direction

  type, public :: identification
    type(identify_par), allocatable :: unknowns(:)
    type(fit_type) :: fit
    type(fit_uncertainty) :: uncertainty
    real(dp), allocatable :: values(:)           !! of the unknowns
    real(dp), allocatable :: low(:), high(:)     !! ends of their intervals; missing at an end of the range
    real(dp), allocatable :: others(:, :)        !! other places that fit as well, (unknowns, places)
    type(undetermined_direction), allocatable :: loose(:)
    logical :: explained = .true.                !! by noise
    integer :: evaluations = 0
  contains
    procedure :: width
  end type identification

contains

  subroutine identify(states, unknowns, quantile, found)
    !! Fit the unknowns to the lines of all states.
    type(measured_state), intent(inout) :: states(:) !! their assignments are those of the fit in the end
    type(identify_par), intent(in) :: unknowns(:)
    real(dp), intent(in) :: quantile             !! half width of intervals in standard deviations
    type(identification), intent(out) :: found
    type(fit_problem) :: problem
    type(fit_type), allocatable :: others(:)
    integer, parameter :: most_restarts = 3      !! from better places that were met
    integer :: i
    problem = problem_of(states, unknowns)
    call fit_beam(problem, quantile**2, .true., found%fit, others)
    do i = 1, most_restarts
      call find_intervals(problem, found%fit, quantile, found%uncertainty)
      if (.not. allocated(found%uncertainty%better) .or. i == most_restarts) exit
      call refit_from(problem, found%uncertainty%better, found%fit)
    end do
    found%unknowns = unknowns
    found%values = problem%values()
    found%explained = .not. found%fit%tail < misfit_chance
    found%evaluations = problem%evaluations
    call widen(found%uncertainty%intervals)
    call reach_others(problem, others, quantile, found)
    found%low = value_at(unknowns, found%uncertainty%intervals%low)
    found%high = value_at(unknowns, found%uncertainty%intervals%high)
    where (is_at_end(found%fit%v) .and. found%fit%v < 0) found%low = missing
    where (is_at_end(found%fit%v) .and. found%fit%v > 0) found%high = missing
    call find_loose(found)
    states = problem%states
  end subroutine identify

  pure real(dp) function width(self, i)
    !! Return the width of an unknown's interval, limited by its range.
    class(identification), intent(in) :: self
    integer, intent(in) :: i
    associate (unknown => self%unknowns(i), interval => self%uncertainty%intervals(i))
      width = value_at(unknown, interval%high) - value_at(unknown, interval%low)
    end associate
  end function width

  subroutine widen(intervals)
    !! Widen the intervals to hold the ends of all others, which fit equally well. (If a contour of equal fit turns
    !! back, the profile of one unknown misses part of it.)
    type(interval_type), intent(inout) :: intervals(:)
    type(interval_type) :: ends(size(intervals))
    integer :: i
    ends = intervals
    do i = 1, size(ends)
      call reach(intervals, ends(i)%at_low)
      call reach(intervals, ends(i)%at_high)
    end do
  end subroutine widen

  pure subroutine reach(intervals, place)
    !! Extend all intervals to hold a place that fits equally well.
    type(interval_type), intent(inout) :: intervals(:)
    real(dp), intent(in) :: place(:)             !! (unknowns)
    real(dp), parameter :: end = 0.999_dp        !! fraction of half the range that counts as its end
    integer :: i
    do i = 1, size(intervals)
      associate (interval => intervals(i))
        if (place(i) < interval%low) then
          interval%low = place(i)
          interval%low_open = place(i) < -end
          interval%at_low = place
        end if
        if (place(i) > interval%high) then
          interval%high = place(i)
          interval%high_open = place(i) > end
          interval%at_high = place
        end if
      end associate
    end do
  end subroutine reach

  subroutine reach_others(problem, others, quantile, found)
    !! Extend intervals to all other places that fit as well, and list those outside the intervals.
    type(fit_problem), intent(inout) :: problem
    type(fit_type), intent(in) :: others(:)
    real(dp), intent(in) :: quantile
    type(identification), intent(inout) :: found
    type(fit_uncertainty) :: uncertainty
    type(fit_type) :: other
    integer :: i, j, n
    allocate (found%others(size(found%unknowns), size(others)))
    n = 0
    do i = 1, size(others)
      associate (intervals => found%uncertainty%intervals)
        if (all(others(i)%v >= intervals%low .and. others(i)%v <= intervals%high)) cycle
        n = n + 1
        found%others(:, n) = value_at(found%unknowns, others(i)%v)
        call place(problem, others(i))
        other = others(i)
        call problem%minimise(other%residuals, .false.)
        other%v = problem%v
        other%sum = sum(other%residuals**2)
        if (all(other%mode_of == found%fit%mode_of)) other%sum = found%fit%sum     ! the same threshold limits both
        call find_intervals(problem, other, quantile, uncertainty)
        call reach(intervals, others(i)%v)
        do j = 1, size(intervals)
          call reach(intervals, uncertainty%intervals(j)%at_low)
          call reach(intervals, uncertainty%intervals(j)%at_high)
        end do
      end associate
    end do
    found%others = found%others(:, :n)
    call place(problem, found%fit)
  end subroutine reach_others

  subroutine find_loose(found)
    !! Find unknowns whose intervals fill much of their ranges, each with the most correlated one.
    type(identification), intent(inout) :: found
    type(undetermined_direction), allocatable :: loose(:)
    real(dp) :: others(size(found%values))
    integer :: i, j, n
    n = size(found%values)
    allocate (loose(n))
    j = 0
    do i = 1, n
      associate (interval => found%uncertainty%intervals(i))
        if (interval%high - interval%low < 2*hardly_fixed) cycle
        j = j + 1
        loose(j)%unknown = i
        others = abs(interval%at_high - interval%at_low)
        others(i) = 0
        loose(j)%partner = maxloc(others, dim=1)
        if (n == 1) loose(j)%partner = 0
        if (loose(j)%partner > 0) then
          if (abs(found%uncertainty%correlation(i, loose(j)%partner)) < together .and. maxval(others) < 0.1_dp) loose(j)%partner = 0
        end if
        loose(j)%one = value_at(found%unknowns, interval%at_low)
        loose(j)%other = value_at(found%unknowns, interval%at_high)
      end associate
    end do
    found%loose = loose(:j)
  end subroutine find_loose

end module bw_identification
