module bw_sum_choice
  !! The choice of a method to sum stable modes: the products of bw_modal_sum or the transform of bw_nonuniform_sum,
  !! whichever is faster by a model of their costs.
  !!
  !! A wider kernel allows a coarser grid: widths are tried in turn, each with the smallest grid that keeps the transform's
  !! error. Narrower kernels than these need grids so fine that they are never faster.
  use bw_kinds, only: dp
  use bw_modal_sum, only: block_length
  use bw_sine_sum, only: next_fast_half
  use bw_spread, only: rows_of
  use bw_spreading_kernel, only: transform_error, vector
  implicit none (type, external)
  private
  public :: chosen_sum, error_of_sum, grid_for_width, product_seconds, sum_seconds

  real(dp), parameter, public :: sum_tolerance = 2.0e-13_dp
    !! error of the transform over the peak: far below truncation errors

  type, public :: sum_choice
    logical :: transform = .false.    !! use the non-uniform transform
    integer :: width = 0              !! of its kernel
    integer :: half = 0               !! half the points of its grid of frequencies
  end type sum_choice

  real(dp), parameter :: rounding = 8.0_dp*epsilon(1.0_dp)   ! of the products, over the peak
  integer, parameter :: widths(2) = [16, 20]         ! wider kernels amplify rounding more than they save
  integer, parameter :: most_samples = 2**27         ! so that points of the largest grid have default integer numbers

  ! Seconds, tuned: printed by bench/sum/constants.py on one core with AVX-512, gfortran 12 -O3 -march=native. Only
  ! their ratios matter.
  real(dp), parameter :: product_set_up = 25.5e-6_dp   ! a call
  real(dp), parameter :: product_mode = 292e-9_dp      ! a mode
  real(dp), parameter :: product_turn = 0e0_dp         ! an entry of the tables of cosines and sines, for each mode
  real(dp), parameter :: product_entry = 36.1e-12_dp   ! an entry of these tables, read for all histories of a block
  real(dp), parameter :: product_state = 1.34e-9_dp    ! a mode's state at a block of a history
  real(dp), parameter :: product_term = 69.4e-12_dp    ! a mode at a sample of a history
  real(dp), parameter :: product_sample = 1.64e-9_dp   ! a sample of a history
  real(dp), parameter :: set_up = 88.4e-6_dp           ! kernel and plan
  real(dp), parameter :: mode_phase = 7.08e-9_dp       ! position and phase of a mode
  real(dp), parameter :: mode_weight = 11.4e-9_dp      ! a vector of weights
  real(dp), parameter :: mode_spread = 4.11e-9_dp      ! adding a vector of weights, for each history
  real(dp), parameter :: grid_point = 917e-12_dp       ! a point of the grid and step of the fast transform, for each history
  real(dp), parameter :: sample = 2.45e-9_dp           ! computing and adding a sample, for each history
  real(dp), parameter :: factor = 7.92e-9_dp           ! the kernel's factor of a sample

contains

  pure type(sum_choice) function chosen_sum(modes, samples, histories, must_transform) result(choice)
    !! Return the fastest method.
    integer, intent(in) :: modes
    integer, intent(in) :: samples
    integer, intent(in) :: histories      !! displacements and velocities at all points
    logical, intent(in), optional :: must_transform   !! exclude the products
    real(dp) :: least, seconds
    integer :: half, i, width
    if (modes == 0 .or. samples > most_samples) return
    least = product_seconds(modes, samples, histories)
    if (present(must_transform)) least = merge(huge(least), least, must_transform)
    do i = 1, size(widths)
      width = widths(i)
      if (transform_seconds(modes, samples, histories, width, max(width, samples/2 + 1)) >= least) cycle  ! on any grid
      half = grid_for_width(width, samples)
      seconds = transform_seconds(modes, samples, histories, width, half)
      if (seconds >= least) cycle
      least = seconds
      choice = sum_choice(.true., width, half)
    end do
  end function chosen_sum

  pure real(dp) function sum_seconds(modes, samples, histories) result(seconds)
    !! Return the time of the chosen method, by the model.
    integer, intent(in) :: modes, samples, histories
    type(sum_choice) :: choice
    choice = chosen_sum(modes, samples, histories)
    if (choice%transform) then
      seconds = transform_seconds(modes, samples, histories, choice%width, choice%half)
    else
      seconds = product_seconds(modes, samples, histories)
    end if
  end function sum_seconds

  elemental real(dp) function error_of_sum(choice, samples) result(error)
    !! Return the error over the peak.
    type(sum_choice), intent(in) :: choice
    integer, intent(in) :: samples
    error = rounding
    if (choice%transform) error = max(rounding, transform_error(choice%width, 2.0_dp*choice%half/samples))
  end function error_of_sum

  pure integer function grid_for_width(width, samples) result(half)
    !! Return half the points of the smallest fast grid within `sum_tolerance`.
    integer, intent(in) :: width, samples
    half = next_fast_half(max(width, samples/2 + 1))
    do while (transform_error(width, 2.0_dp*half/samples) > sum_tolerance)
      half = next_fast_half(half + 1)
    end do
  end function grid_for_width

  pure real(dp) function product_seconds(modes, samples, histories) result(seconds)
    !! Return the time of products, by the model.
    integer, intent(in) :: modes, samples, histories
    real(dp) :: blocks, length, states
    length = block_length(samples)
    blocks = aint((samples - 1)/length) + 1.0_dp
    states = modes*blocks*histories
    seconds = product_set_up + modes*(product_mode + product_turn*(length + blocks) + product_entry*(length*blocks)) &
      + states*(product_state + product_term*length) + product_sample*samples*histories
  end function product_seconds

  pure real(dp) function transform_seconds(modes, samples, histories, width, half) result(seconds)
    !! Return the time of the transform with this kernel and grid, by the model.
    integer, intent(in) :: modes, samples, histories, width, half
    real(dp) :: points, vectors
    points = 2.0_dp*half
    vectors = rows_of(width)/vector
    seconds = set_up + modes*(mode_phase + vectors*(mode_weight + mode_spread*histories)) + factor*samples &
      + histories*(grid_point*points*log(points)/log(2.0_dp) + sample*samples)
  end function transform_seconds

end module bw_sum_choice
