module bw_response
  !! Histories at points of the beam (Eqs 27–30), and where and when they are wanted. What they are summed from is the matter
  !! of bw_set_sum, of modes in memory, and of bw_streamed_modes, of more than are held at a time.
  !!
  !! The answer is exact in modal coordinates: what limits it is the truncation of the modes. Velocities that are not asked
  !! for are an unallocated array, which sums receive as an absent argument.
  use bw_double_double, only: dd_pi
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_mode_set, only: deflections
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: start_histories, finish_histories, fill_unknown, histories_of, turns_in_record

  real(dp), parameter, public :: sum_tolerance = 2.0e-13_dp
    !! of the sum of modes, over the peak: far below what their number leaves

  type, public :: sampling_type
    !! Where and when histories are wanted.
    real(dp), allocatable :: points(:)            !! ξ, (points)
    type(time_grid) :: grid
    real(dp) :: unit_time = 1.0_dp                !! of the grid, l²/h, s
    logical :: velocity = .false.                 !! velocities too
    integer :: quantity = deflections             !! or curvatures (bw_mode_set), of which histories then are
  end type sampling_type

  type, public :: response_type
    !! Histories in the rotating frame, SI units.
    type(sampling_type) :: sampling
    real(dp), allocatable :: displacement(:, :)   !! m, (samples, points); missing from the first overflow on
    real(dp), allocatable :: velocity(:, :)       !! m/s, (samples, points); allocated only if asked for
    real(dp), allocatable :: displacement_error(:)  !! m, estimate of the largest error, (points); not of a rebound
    real(dp), allocatable :: displacement_bound(:)  !! m, proved, (points)
    real(dp), allocatable :: velocity_error(:)      !! m/s, (points)
    real(dp), allocatable :: bending_moment(:, :)   !! N m, (samples, points); allocated only if asked for
    real(dp), allocatable :: bending_moment_error(:)  !! N m, (points)
    real(dp), allocatable :: acceleration(:, :)     !! m/s², (samples, points); allocated only if asked for
    real(dp), allocatable :: acceleration_error(:)  !! m/s², (points)
    real(dp), allocatable :: shear_force(:, :)      !! N, (samples, points); allocated only if asked for
    real(dp), allocatable :: shear_force_error(:)   !! N, (points)
    real(dp), allocatable :: hub_angle(:)           !! rad, of a hub that is free, (samples)
    real(dp), allocatable :: stress_of_moment(:)    !! c/I, m⁻³, (points); allocated where the section tells it
    real(dp) :: mode_seconds = 0.0_dp             !! wall time of finding the modes that were streamed
    real(dp) :: sum_error = 0.0_dp                !! of the sums of modes, as a part of the largest value at any point
    integer :: transformed = 0                    !! modes that were summed by the transform
    integer :: finite_samples = 0                 !! samples before the first overflow; all where there is none
    integer :: failing_mode = 0                   !! the mode that overflows first; 0 where none does
  end type response_type

contains

  subroutine start_histories(sampling, response)
    !! Histories of a beam at rest. Until they are finished velocities are in m per unit of the grid's time.
    type(sampling_type), intent(in) :: sampling
    type(response_type), intent(out) :: response
    response%sampling = sampling
    allocate (response%displacement(sampling%grid%samples, size(sampling%points)))
    response%displacement = 0.0_dp         ! by a fill of memory, which `source=` is not
    if (sampling%velocity) response%velocity = response%displacement
    response%finite_samples = sampling%grid%samples
  end subroutine start_histories

  subroutine finish_histories(response)
    !! Fill from the first overflow on, and velocities in m/s.
    type(response_type), intent(inout) :: response
    if (allocated(response%velocity)) then
      response%velocity(:response%finite_samples, :) = response%velocity(:response%finite_samples, :)/response%sampling%unit_time
    end if
    call fill_unknown(response)
  end subroutine finish_histories

  subroutine fill_unknown(response)
    !! Fill from the first overflow on, or from where on nothing is known.
    type(response_type), intent(inout) :: response
    response%displacement(response%finite_samples + 1:, :) = missing
    if (allocated(response%velocity)) response%velocity(response%finite_samples + 1:, :) = missing
  end subroutine fill_unknown

  elemental logical function turns_in_record(beta, grid)
    !! A slower mode's amplitude q̇/β is larger than its motion, and the transform's error follows the amplitude.
    real(dp), intent(in) :: beta
    type(time_grid), intent(in) :: grid
    turns_in_record = beta*(grid%samples*grid%step%hi) > 2.0_dp*dd_pi%hi
  end function turns_in_record

  pure integer function histories_of(response)
    !! Of displacements, and of velocities where they are asked for.
    type(response_type), intent(in) :: response
    histories_of = size(response%displacement, 2)
    if (allocated(response%velocity)) histories_of = 2*histories_of
  end function histories_of

end module bw_response
