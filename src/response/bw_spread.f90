module bw_spread
  !! Carries modes onto a grid of frequencies: the innermost loop of the non-uniform transform.
  use bw_kinds, only: dp
  use bw_spreading_kernel, only: cells, degree, spreading_kernel, vector
  implicit none (type, external)
  private
  public :: spread_modes

  integer, parameter :: few = 8              !! tuned: modes whose weights are made before any is put to use
  integer, parameter :: most_rows = 24       !! grid points of the widest kernel, in whole vectors

contains

  pure subroutine spread_modes(kernel, first, offset, re, im, rate, shapes, grid)
    !! Adds every mode, times the kernel around its frequency, to the grids of all histories: to those of displacements with
    !! the coefficient Φ(re + i·im), then, where there are more grids than points, to those of velocities with i·rate times it.
    type(spreading_kernel), intent(in) :: kernel
    integer, intent(in) :: first(:)
      !! place, from 1, of the first grid point that a mode reaches, (modes)
    real(dp), intent(in) :: offset(:)
      !! where in the spacing left of the middle of those points it lies, 0 … 1, (modes)
    real(dp), intent(in) :: re(:), im(:), rate(:)       !! (modes)
    real(dp), intent(in) :: shapes(:, :)                !! Φ, (modes, points)
    real(dp), intent(inout), contiguous :: grid(:, :)   !! real and imaginary parts in turn, (2·grid points, histories)
    real(dp) :: pairs(2*most_rows, few), place(few)
    integer :: cell(few), i, k, n
    do k = 0, size(first) - 1, few
      n = min(few, size(first) - k)
      cell(:n) = min(cells, int(offset(k + 1:k + n)*cells) + 1)
      place(:n) = 2.0_dp*(offset(k + 1:k + n)*cells - (cell(:n) - 1)) - 1.0_dp
      do i = 1, n
        call make_pairs(kernel%table(:, :, :, cell(i)), place(i), pairs(:, i))
      end do
      do i = k + 1, k + n
        associate (low => 2*first(i) - 1, high => 2*(first(i) + kernel%width) - 2)
          call add_mode(pairs(:2*kernel%width, i - k), re(i), im(i), rate(i), shapes(i, :), grid(low:high, :))
        end associate
      end do
    end do
  end subroutine spread_modes

  pure subroutine add_mode(pairs, re, im, rate, shapes, grid)
    real(dp), intent(in), contiguous :: pairs(:)
    real(dp), intent(in) :: re, im, rate
    real(dp), intent(in) :: shapes(:)                   !! (points)
    real(dp), intent(inout) :: grid(:, :)
    integer :: p
    do p = 1, size(shapes)
      call add_pairs(size(pairs)/8, pairs, shapes(p)*re, shapes(p)*im, grid(:, p))
    end do
    do p = 1, size(grid, 2) - size(shapes)
      call add_pairs(size(pairs)/8, pairs, -rate*(shapes(p)*im), rate*(shapes(p)*re), grid(:, size(shapes) + p))
    end do
  end subroutine add_mode

  pure subroutine make_pairs(table, place, pairs)
    !! The weights of neighbouring grid points, each twice: for the real and the imaginary part.
    real(dp), intent(in), contiguous :: table(:, 0:, :)      !! of a cell, (vector, 0:degree, vectors)
    real(dp), intent(in) :: place
    real(dp), intent(out) :: pairs(2*vector, most_rows/vector)
    integer :: b
    do b = 1, size(table, 3)
      call weigh(table(:, :, b), place, pairs(:, b))
    end do
  end subroutine make_pairs

  pure subroutine weigh(t, x, pairs)
    !! One vector of weights. Horner's rule is written out: as a loop the compiler takes it apart.
    real(dp), intent(in) :: t(vector, 0:degree), x
    real(dp), intent(out) :: pairs(2, vector)
    real(dp) :: weight(vector)
    integer :: i
    do i = 1, vector
      weight(i) = ((((((t(i, 7)*x + t(i, 6))*x + t(i, 5))*x + t(i, 4))*x + t(i, 3))*x + t(i, 2))*x + t(i, 1))*x + t(i, 0)
    end do
    do i = 1, vector
      pairs(1, i) = weight(i)
      pairs(2, i) = weight(i)
    end do
  end subroutine weigh

  pure subroutine add_pairs(eights, pairs, re, im, grid)
    integer, intent(in) :: eights                       !! vectors of 8 in what follows
    real(dp), intent(in) :: pairs(8, eights), re, im
    real(dp), intent(inout) :: grid(8, eights)
    real(dp) :: both(8)
    integer :: b, i
    both = [re, im, re, im, re, im, re, im]
    do b = 1, eights
      do i = 1, 8
        grid(i, b) = grid(i, b) + pairs(i, b)*both(i)
      end do
    end do
  end subroutine add_pairs

end module bw_spread
