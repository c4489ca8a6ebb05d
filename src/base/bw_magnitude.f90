module bw_magnitude
  !! The largest magnitude in a long record. `maxval` handles NaN and therefore proceeds number by number; records here
  !! contain none.
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: largest_magnitude

  integer, parameter :: lanes = 32         !! tuned: a few vector registers

  interface largest_magnitude
    module procedure :: largest_of_list, largest_of_table
  end interface largest_magnitude

contains

  pure real(dp) function largest_of_list(values) result(largest)
    !! Return the largest magnitude in a list; 0 for an empty one.
    real(dp), intent(in), contiguous :: values(:)   !! no NaN
    real(dp) :: lane(lanes)
    integer :: i, whole
    whole = size(values) - mod(size(values), lanes)
    lane = 0.0_dp
    do i = 1, whole, lanes
      lane = max(lane, abs(values(i:i + lanes - 1)))
    end do
    largest = max(maxval(lane), maxval(abs(values(whole + 1:))))
  end function largest_of_list

  pure real(dp) function largest_of_table(values) result(largest)
    !! Return the largest magnitude in a table.
    real(dp), intent(in), contiguous :: values(:, :)
    integer :: j
    largest = 0.0_dp
    do j = 1, size(values, 2)
      largest = max(largest, largest_of_list(values(:, j)))
    end do
  end function largest_of_table

end module bw_magnitude
