module bw_samples_of_grid
  !! The last steps of the non-uniform transform: fold back what was spread beyond the ends of a grid, and add the sums
  !! over its points, divided by the kernel's transform, to histories.
  use bw_kinds, only: dp
  use bw_sine_sum, only: block, fine_turns, middle_sum, pair_sums, quarter_sums, turn_block, turns_of_block
  use bw_spreading_kernel, only: kernel_factors, spreading_kernel
  implicit none (type, external)
  private
  public :: add_samples, fold_ends

contains

  pure subroutine fold_ends(half, width, cosine, spectra)
    !! Fold what was spread below frequency 0 or above Nyquist onto its mirror image, with the same sign for cosines and
    !! the opposite one for sines.
    integer, intent(in) :: half                       !! half the points of a grid
    integer, intent(in) :: width                      !! of the kernel, half of which lies before the first point
    logical, intent(in) :: cosine(:)                  !! (grids)
    real(dp), intent(inout), contiguous :: spectra(:, :)   !! (rows, grids)
    real(dp) :: sign_of
    integer :: c, low, r, top
    low = width/2 + 1                   ! the first grid point
    top = width/2 + 2*half              ! the last
    do c = 1, size(cosine)
      sign_of = merge(1.0_dp, -1.0_dp, cosine(c))
      do r = 0, width/2 - 1
        spectra(low + r, c) = spectra(low + r, c) + sign_of*spectra(low - 1 - r, c)
        spectra(top - r, c) = spectra(top - r, c) + sign_of*spectra(top + 1 + r, c)
      end do
    end do
  end subroutine fold_ends

  pure subroutine add_samples(kernel, half, cosine, skip, grids, history)
    !! Add all samples but the first, which follows from the state at t = 0.
    type(spreading_kernel), intent(in) :: kernel
    integer, intent(in) :: half                       !! half the points of a grid
    logical, intent(in) :: cosine
    integer, intent(in) :: skip                       !! rows before the first point of a grid
    real(dp), intent(in), contiguous :: grids(0:, :)  !! transformed, (rows, points)
    real(dp), intent(inout), contiguous :: history(0:, :)   !! (samples, points)
    type(turn_block) :: fine, turns
    real(dp) :: factor(block, 4), sums(block, 4)
    integer :: first, p
    fine = fine_turns(half)
    do first = 1, (half - 1)/2, block
      call turns_of_block(half, fine, first, turns)
      call factors_of_block(kernel, half, turns, size(history, 1), factor)
      associate (low => skip + 2*first, high => skip + 2*(half - first - turns%count + 1), n => turns%count)
        do p = 1, size(history, 2)
          call pair_sums(turns, n, grids(low:low + 2*n - 1, p), grids(high:high + 2*n - 1, p), cosine, sums)
          call add_runs(half, turns, factor, sums, history(:, p))
        end do
      end associate
    end do
    do p = 1, size(history, 2)
      call add_sample(kernel, half, half, middle_sum(grids(skip:, p)), history(:, p))
      if (mod(half, 2) == 0) then
        sums(1, :2) = quarter_sums(half, grids(skip:, p), cosine)
        call add_sample(kernel, half, half/2, sums(1, 1), history(:, p))
        call add_sample(kernel, half, half/2 + half, sums(1, 2), history(:, p))
      end if
    end do
  end subroutine add_samples

  pure integer function sample_of(half, run, j) result(sample)
    !! Return the sample of the sum number `j` in one of the four runs of `pair_sums`.
    integer, intent(in) :: half, run, j
    integer, parameter :: origin(4) = [0, 1, 1, 2], step(4) = [1, 1, -1, -1]
    sample = origin(run)*half + step(run)*j
  end function sample_of

  pure subroutine factors_of_block(kernel, half, turns, samples, factor)
    !! Find the factors of the requested samples.
    type(spreading_kernel), intent(in) :: kernel
    integer, intent(in) :: half
    type(turn_block), intent(in) :: turns
    integer, intent(in) :: samples
    real(dp), intent(out) :: factor(block, 4)
    integer :: run
    do run = 1, 4
      if (min(sample_of(half, run, turns%first), sample_of(half, run, turns%first + turns%count - 1)) >= samples) cycle
      call kernel_factors(kernel, sample_of(half, run, turns%first), merge(1, -1, run < 3), 4*half, factor(:turns%count, run))
    end do
  end subroutine factors_of_block

  pure subroutine add_runs(half, turns, factor, sums, history)
    !! Add the sums of a block to their samples: two runs ascend, two descend.
    integer, intent(in) :: half
    type(turn_block), intent(in) :: turns
    real(dp), intent(in), dimension(block, 4) :: factor, sums
    real(dp), intent(inout), contiguous :: history(0:)
    integer :: beyond, first, i, last, run
    do run = 1, 2
      first = sample_of(half, run, turns%first)
      do i = 1, min(turns%count, size(history) - first)
        history(first + i - 1) = history(first + i - 1) + factor(i, run)*sums(i, run)
      end do
    end do
    do run = 3, 4
      first = sample_of(half, run, turns%first)
      beyond = max(0, first - size(history) + 1)          ! sums beyond the record
      last = turns%count
      do i = beyond + 1, last
        history(first - i + 1) = history(first - i + 1) + factor(i, run)*sums(i, run)
      end do
    end do
  end subroutine add_runs

  pure subroutine add_sample(kernel, half, sample, sum, history)
    !! Add one sum to its sample, if that is in the record.
    type(spreading_kernel), intent(in) :: kernel
    integer, intent(in) :: half, sample
    real(dp), intent(in) :: sum
    real(dp), intent(inout) :: history(0:)
    real(dp) :: factor(1)
    if (sample >= size(history)) return
    call kernel_factors(kernel, sample, 1, 4*half, factor)
    history(sample) = history(sample) + factor(1)*sum
  end subroutine add_sample

end module bw_samples_of_grid
