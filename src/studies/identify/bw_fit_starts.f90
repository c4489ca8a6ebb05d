module bw_fit_starts
  !! Where the search for unknowns begins.
  use bw_fit_problem, only: fit_problem, position_in
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: choose_starts

  integer, parameter :: looks_each = 16                  !! places that are looked at, for each unknown
  integer, parameter :: primes(12) = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37]

contains

  subroutine choose_starts(problem, scatter, starts)
    !! The scene's own values, and those of evenly spread points of the ranges that cost least.
    type(fit_problem), intent(inout) :: problem
    real(dp), intent(in) :: scatter              !! τ is not below
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

end module bw_fit_starts
