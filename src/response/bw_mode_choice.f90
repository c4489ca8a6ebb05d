module bw_mode_choice
  !! How many modes of the continuum a tolerance takes.
  use bw_kinds, only: dp
  use bw_double_double, only: dd
  use bw_truncation, only: tail_error
  implicit none (type, external)
  private
  public :: modes_for

  integer, parameter, public :: most_modes = 10000000
  integer, parameter :: halvings = 5          !! the count is within 1/32 of the least that would do

contains

  pure subroutine modes_for(bound, fewest, gamma, force, omega, points, longest, samples, count, reached)
    !! The least number of modes, nearly, whose estimated truncation error is within a bound at every point.
    real(dp), intent(in) :: bound             !! of the displacement, in the unit of `force` times l²/h
    integer, intent(in) :: fewest             !! never less than this
    real(dp), intent(in) :: gamma, force      !! mass ratio, and see `tail_error`
    type(dd), intent(in), optional :: omega
    real(dp), intent(in) :: points(:), longest
    integer, intent(in) :: samples
    integer, intent(out) :: count             !! `most_modes` where more would be needed
    real(dp), intent(out) :: reached          !! the estimate for `count` modes
    integer :: enough, few, middle, i
    few = fewest
    enough = fewest
    do
      reached = error_of(enough)
      if (reached <= bound .or. enough == most_modes) exit
      few = enough
      enough = min(2*enough, most_modes)
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

    pure real(dp) function error_of(n)
      integer, intent(in) :: n
      error_of = maxval(tail_error(n, gamma, force, omega, points, longest, samples, .false.))
    end function error_of

  end subroutine modes_for

end module bw_mode_choice
