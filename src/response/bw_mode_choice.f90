module bw_mode_choice
  !! How many modes of the continuum a tolerance takes.
  use bw_kinds, only: dp
  use bw_mode_set, only: mode_source
  use bw_truncation, only: tail_error
  implicit none (type, external)
  private
  public :: modes_for

  integer, parameter, public :: most_modes = 10000000
  integer, parameter :: halvings = 5          !! the count is within 1/32 of the least that would do

contains

  subroutine modes_for(bound, fewest, source, force, points, longest, samples, count, reached)
    !! The least number of modes, nearly, whose estimated truncation error is within a bound at every point.
    real(dp), intent(in) :: bound             !! of the displacement, in the unit of `force` times l²/h
    integer, intent(in) :: fewest             !! never less than this
    class(mode_source), intent(in) :: source
    real(dp), intent(in) :: force             !! see `tail_error`
    real(dp), intent(in) :: points(:), longest
    integer, intent(in) :: samples
    integer, intent(out) :: count             !! `most_modes`, or all there are, where more would be needed
    real(dp), intent(out) :: reached          !! the estimate for `count` modes
    integer :: enough, few, middle, most, i
    most = min(most_modes, source%highest)
    few = fewest
    enough = fewest
    do
      reached = error_of(enough)
      if (reached <= bound .or. enough == most) exit
      few = enough
      enough = min(2*enough, most)
    end do
    do i = 1, halvings
      middle = (few + enough)/2
      if (enough == fewest .or. reached > bound .or. middle == few) exit
      if (error_of(middle) <= bound) then
        enough = middle
      else
        few = middle
      end if
    end do
    count = enough
    reached = error_of(count)

  contains

    real(dp) function error_of(n)
      integer, intent(in) :: n
      error_of = maxval(tail_error(n, source, force, points, longest, samples, .false.))
    end function error_of

  end subroutine modes_for

end module bw_mode_choice
