module bw_spread
  !! Carries modes onto a grid of frequencies: the innermost loop of the non-uniform transform.
  use bw_kinds, only: dp
  use bw_spreading_kernel, only: cells, degree, spreading_kernel, vector
  implicit none (type, external)
  private
  public :: spread_modes

contains

  pure subroutine spread_modes(kernel, first, offset, coefficient, grid)
    !! Adds every mode, times the kernel around its frequency, to the grids of all histories.
    type(spreading_kernel), intent(in) :: kernel
    integer, intent(in) :: first(:)
      !! place, from 1, of the first grid point that a mode reaches, (modes)
    real(dp), intent(in) :: offset(:)
      !! where in the spacing left of the middle of those points it lies, 0 … 1, (modes)
    real(dp), intent(in), contiguous :: coefficient(:, :, :)   !! real and imaginary part, (2, histories, modes)
    real(dp), intent(inout), contiguous :: grid(:, :)   !! real and imaginary parts in turn, (2·points, histories)
    real(dp) :: pair(2, vector), place
    integer :: b, cell, h, k, start
    do k = 1, size(first)
      cell = min(cells, int(offset(k)*cells) + 1)
      place = 2.0_dp*(offset(k)*cells - (cell - 1)) - 1.0_dp
      do b = 1, kernel%width/vector
        pair = weight_pairs(kernel%table(:, :, b, cell), place)
        start = 2*(first(k) + vector*(b - 1)) - 1
        do h = 1, size(grid, 2)
          call add_pairs(pair, coefficient(:, h, k), grid(start:start + 2*vector - 1, h))
        end do
      end do
    end do
  end subroutine spread_modes

  pure function weight_pairs(table, place) result(pair)
    !! The weights of neighbouring grid points, each twice: for the real and the imaginary part.
    real(dp), intent(in) :: table(vector, 0:degree), place
    real(dp) :: pair(2, vector)
    real(dp) :: weight(vector)
    integer :: i
    weight = table(:, degree)
    do i = degree - 1, 0, -1
      weight = weight*place + table(:, i)
    end do
    pair(1, :) = weight
    pair(2, :) = weight
  end function weight_pairs

  pure subroutine add_pairs(pair, coefficient, grid)
    real(dp), intent(in) :: pair(2*vector), coefficient(2)
    real(dp), intent(inout) :: grid(2*vector)
    real(dp) :: both(2*vector)
    integer :: i
    do i = 1, vector
      both(2*i - 1:2*i) = coefficient
    end do
    grid = grid + pair*both
  end subroutine add_pairs

end module bw_spread
