module bw_line_needless
  !! Lines that the others do without: what was left while stronger lines were not at their places yet may have been taken
  !! for a line beside one of them.
  use bw_kinds, only: dp
  use bw_line, only: line_position, line_type
  use bw_line_fit, only: fit_lines
  use bw_line_group, only: band_of, goal_of, group_image, group_type
  use bw_line_residual, only: residual_type
  implicit none (type, external)
  private
  public :: drop_needless

  real(dp), parameter, public :: resolution = 1  !! bins; closer lines are one
  real(dp), parameter :: no_worse = 1.01_dp      !! times what is left

contains

  subroutine drop_needless(residual, group)
    !! Leave out, the weakest first, lines within the resolution of another one without which the group's fit leaves no more
    !! than it may, or no more than with them: what lies in one place is one line. What is needed stays as it is, to the bit.
    type(residual_type), intent(in) :: residual  !! what all lines leave
    type(group_type), intent(inout) :: group
    type(line_type), allocatable :: whole(:), trial(:)
    real(dp) :: goal, left, left_now
    integer :: weakest, bins(2)
    allocate (whole, source=group%lines)
    bins = band_of(group, residual%count)
    left_now = norm2(abs(residual%windowed(bins(1):bins(2), :)))
    do
      weakest = weakest_of_close(group%lines)
      if (weakest == 0) exit
      trial = [group%lines(:weakest - 1), group%lines(weakest + 1:)]
      goal = goal_of(residual, trial, 0.0_dp, bins)
      call fit_lines(trial, residual%count, bins(1), group_image(residual, whole, bins), goal, left)
      if (left > max(goal, no_worse*left_now)) exit
      left_now = left
      call move_alloc(trial, group%lines)
    end do
  end subroutine drop_needless

  pure integer function weakest_of_close(lines) result(weakest)
    !! The weakest line that has another one within the resolution; 0 where none has.
    type(line_type), intent(in) :: lines(:)
    real(dp) :: strength(size(lines))
    integer :: i
    strength = huge(1.0_dp)
    do i = 1, size(lines)
      if (count(abs(line_position(lines) - line_position(lines(i))) < resolution) < 2) cycle
      strength(i) = norm2(abs(lines(i)%amplitude))
    end do
    weakest = 0
    if (any(strength < huge(1.0_dp))) weakest = minloc(strength, dim=1)
  end function weakest_of_close

end module bw_line_needless
