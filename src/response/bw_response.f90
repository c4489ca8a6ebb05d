module bw_response
  !! Histories at points of the beam (Eqs 27–30), and the times and points at which they are requested. They are summed
  !! by bw_set_sum from modes in memory, and by bw_streamed_modes from more modes than are held at a time.
  !!
  !! In modal coordinates the solution is exact; the only error of method is modal truncation. Velocities that are not
  !! requested are an unallocated array, passed to sums as an absent argument.
  use bw_double_double, only: dd_pi
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_mode_set, only: deflections
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: start_histories, finish_histories, fill_unknown, histories_of, turns_in_record

  type, public :: sampling_type
    !! Points and times of histories.
    real(dp), allocatable :: points(:)            !! ξ, (points)
    type(time_grid) :: grid
    real(dp) :: unit_time = 1.0_dp                !! of the grid, l²/h, s
    logical :: velocity = .false.                 !! velocities are requested
    integer :: quantity = deflections             !! or curvatures (bw_mode_set) in place of displacements
  end type sampling_type

  type, public :: response_type
    !! Histories in the rotating frame, SI units.
    type(sampling_type) :: sampling
    real(dp), allocatable :: displacement(:, :)   !! m, (samples, points); missing from the first overflow on
    real(dp), allocatable :: velocity(:, :)       !! m/s, (samples, points); allocated if requested
    real(dp), allocatable :: displacement_error(:)  !! m, estimate of the largest error, (points); none for a rebound
    real(dp), allocatable :: displacement_bound(:)  !! m, proved, (points)
    real(dp), allocatable :: velocity_error(:)      !! m/s, (points)
    real(dp), allocatable :: bending_moment(:, :)   !! N m, (samples, points); allocated if requested
    real(dp), allocatable :: bending_moment_error(:)  !! N m, (points)
    real(dp), allocatable :: acceleration(:, :)     !! m/s², (samples, points); allocated if requested
    real(dp), allocatable :: acceleration_error(:)  !! m/s², (points)
    real(dp), allocatable :: shear_force(:, :)      !! N, (samples, points); allocated if requested
    real(dp), allocatable :: shear_force_error(:)   !! N, (points)
    real(dp), allocatable :: hub_angle(:)           !! rad, of a free hub, (samples)
    real(dp), allocatable :: stress_of_moment(:)    !! c/I, m⁻³, (points); allocated if the section determines c
    real(dp) :: mode_seconds = 0.0_dp             !! wall time of solving streamed modes
    real(dp) :: sum_error = 0.0_dp                !! error of modal sums over the largest value at any point
    integer :: transformed = 0                    !! modes summed by the transform
    integer :: finite_samples = 0                 !! samples before the first overflow, or all
    integer :: failing_mode = 0                   !! first mode to overflow; 0: none
  end type response_type

contains

  subroutine start_histories(sampling, response)
    !! Return histories of a beam at rest. Until they are finished, velocities are in m per unit of the grid's time.
    type(sampling_type), intent(in) :: sampling
    type(response_type), intent(out) :: response
    response%sampling = sampling
    allocate (response%displacement(sampling%grid%samples, size(sampling%points)))
    response%displacement = 0.0_dp         ! a memory fill, unlike `source=`
    if (sampling%velocity) response%velocity = response%displacement
    response%finite_samples = sampling%grid%samples
  end subroutine start_histories

  subroutine finish_histories(response)
    !! Convert velocities to m/s, and fill from the first overflow on.
    type(response_type), intent(inout) :: response
    if (allocated(response%velocity)) then
      response%velocity(:response%finite_samples, :) = response%velocity(:response%finite_samples, :)/response%sampling%unit_time
    end if
    call fill_unknown(response)
  end subroutine finish_histories

  subroutine fill_unknown(response)
    !! Fill from the first overflow on, or from when the motion is unknown.
    type(response_type), intent(inout) :: response
    response%displacement(response%finite_samples + 1:, :) = missing
    if (allocated(response%velocity)) response%velocity(response%finite_samples + 1:, :) = missing
  end subroutine fill_unknown

  elemental logical function turns_in_record(beta, grid)
    !! Return whether a mode completes a cycle in the record. If not, its amplitude q̇/β exceeds its motion, and the
    !! transform's error is relative to the amplitude.
    real(dp), intent(in) :: beta
    type(time_grid), intent(in) :: grid
    turns_in_record = beta*(grid%samples*grid%step%hi) > 2.0_dp*dd_pi%hi
  end function turns_in_record

  pure integer function histories_of(response)
    !! Count the histories: displacements, and velocities if requested.
    type(response_type), intent(in) :: response
    histories_of = size(response%displacement, 2)
    if (allocated(response%velocity)) histories_of = 2*histories_of
  end function histories_of

end module bw_response
