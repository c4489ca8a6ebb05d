module bw_spread
  !! Spreading of modes onto a grid of frequencies: the innermost loop of the non-uniform transform.
  use bw_kinds, only: dp
  use bw_spreading_kernel, only: cells, degree, spreading_kernel, vector
  implicit none (type, external)
  private
  public :: spread_modes, rows_of

  integer, parameter :: group = 8             !! tuned: modes whose weights are computed before use

contains

  elemental integer function rows_of(width) result(rows)
    !! Return the grid points that a mode touches: those of the kernel in whole vectors, with weights 0 beyond it.
    integer, intent(in) :: width
    rows = vector*((width + vector - 1)/vector)
  end function rows_of

  pure subroutine spread_modes(kernel, first, offset, coefficients, grid)
    !! Add every mode, times its coefficients and the kernel around its frequency, to the grids.
    type(spreading_kernel), intent(in) :: kernel
    integer, intent(in), contiguous :: first(:)
      !! index, from 1, of the first grid point that a mode touches, (modes)
    real(dp), intent(in) :: offset(:)
      !! position in the spacing left of the middle of those points, 0 … 1, (modes)
    real(dp), intent(in), contiguous :: coefficients(:, :)   !! (modes, grids)
    real(dp), intent(inout), contiguous :: grid(:, :)        !! (grid points, grids)
    real(dp) :: place(group), weights(vector, group)
    integer :: b, cell(group), k, n
    do k = 0, size(first) - 1, group
      n = min(group, size(first) - k)
      cell(:n) = min(cells, int(offset(k + 1:k + n)*cells) + 1)
      place(:n) = 2.0_dp*(offset(k + 1:k + n)*cells - (cell(:n) - 1)) - 1.0_dp
      do b = 1, rows_of(kernel%width)/vector
        call find_weights(kernel%table(:, :, :, b), n, cell, place, weights)
        call spread_group(n, weights, k, first, (b - 1)*vector, coefficients, grid)
      end do
    end do
  end subroutine spread_modes

  pure subroutine find_weights(t, n, cell, x, weights)
    !! Evaluate one vector of the weights of `n` modes. Horner's rule is written out: as a loop the compiler takes it apart.
    real(dp), intent(in) :: t(vector, 0:degree, cells)               !! of the kernel
    integer, intent(in) :: n, cell(n)
    real(dp), intent(in) :: x(n)                                     !! position in the cell, −1 … 1
    real(dp), intent(inout) :: weights(vector, group)
    integer :: c, i, k
    do k = 1, n
      c = cell(k)
      !GCC$ unroll 1
      do i = 1, vector
        weights(i, k) = ((((((t(i, 7, c)*x(k) + t(i, 6, c))*x(k) + t(i, 5, c))*x(k) + t(i, 4, c))*x(k) + t(i, 3, c))*x(k) &
                          + t(i, 2, c))*x(k) + t(i, 1, c))*x(k) + t(i, 0, c)
      end do
    end do
  end subroutine find_weights

  pure subroutine spread_group(n, weights, done, first, beyond, coefficients, grid)
    !! Apply one vector of the weights of the next `n` modes.
    integer, intent(in) :: n
    real(dp), intent(in) :: weights(vector, group)
    integer, intent(in) :: done                                      !! modes before them
    integer, intent(in), contiguous :: first(:)                      !! see `spread_modes`
    integer, intent(in) :: beyond                                    !! grid points before this vector
    real(dp), intent(in), contiguous :: coefficients(:, :)
    real(dp), intent(inout), contiguous :: grid(:, :)
    real(dp) :: coefficient
    integer :: i, k, low, p
    do k = 1, n
      do p = 1, size(grid, 2)
        coefficient = coefficients(done + k, p)
        low = first(done + k) + beyond - 1
        !GCC$ unroll 1
        do i = 1, vector
          grid(low + i, p) = grid(low + i, p) + weights(i, k)*coefficient
        end do
      end do
    end do
  end subroutine spread_group

end module bw_spread
