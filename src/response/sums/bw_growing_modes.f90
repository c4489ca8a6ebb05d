module bw_growing_modes
  !! Histories of modes at or beyond their critical speed, β² ≤ 0, and of others that are moved from sample to sample; and the
  !! sample at which growing ones overflow.
  use bw_double_double, only: dd, sqrt, operator(*), operator(-)
  use bw_kinds, only: dp
  use bw_modal_flow, only: flow
  use bw_time_grid, only: time_grid
  implicit none (type, external)
  private
  public :: add_sample_by_sample, find_overflow

  real(dp), parameter :: log_half = log(0.5_dp)
  real(dp), parameter :: largest_exponent = 1400.0_dp   !! of e^x in `flow`
  real(dp), parameter :: room = 2.0_dp**64     !! so that velocities do not overflow before displacements

contains

  pure subroutine find_overflow(beta_squared, q, q_dot, shapes, grid, limits, samples, failing)
    !! Find the samples at which the sum of growing modes is within given limits at every point. Each mode moves as
    !! Φ·½(q + q̇/|β|)e^(|β|t), and a decaying part.
    type(dd), intent(in) :: beta_squared(:)      !! β² ≤ 0, (modes)
    real(dp), intent(in) :: q(:), q_dot(:)       !! modal displacements and velocities at t = 0, (modes)
    real(dp), intent(in) :: shapes(:, :)         !! Φ(ξ_p), (modes, points)
    type(time_grid), intent(in) :: grid
    real(dp), intent(in) :: limits(:)            !! logarithms of the largest displacement and, if requested, velocity
    integer, intent(out) :: samples              !! samples within the limits
    integer, intent(out) :: failing              !! largest mode at the first sample beyond; 0: none
    type(dd) :: root(size(q))
    real(dp) :: rate(size(q)), start(size(q))    ! |β|; logarithm of the growing part of the velocity at t = 0
    integer, allocatable :: grows(:)
    integer :: k, above, middle
    samples = grid%samples
    failing = 0
    root = sqrt(-beta_squared)
    start = abs(root%hi*q + q_dot)*maxval(abs(shapes), 2)
    grows = pack([(k, k=1, size(q))], root%hi > 0.0_dp .and. start > 0.0_dp)
    rate = root%hi
    start(grows) = log_half + log(start(grows))
    if (size(grows) == 0 .or. excess(samples) <= 0.0_dp) return
    samples = 1                                  ! at t = 0 nothing has grown
    above = grid%samples
    do while (above - samples > 1)
      middle = samples + (above - samples)/2
      if (excess(middle) > 0.0_dp) then
        above = middle
      else
        samples = middle
      end if
    end do
    failing = grows(maxloc(start(grows) + rate(grows)*time(above), 1))

  contains

    pure real(dp) function time(sample)
      !! Return the time of a sample in the grid's unit.
      integer, intent(in) :: sample              ! from 1
      time = grid%step%hi*(sample - 1)
    end function time

    pure real(dp) function excess(sample)
      !! Return how far the logarithm of the sum's bound exceeds the limits.
      integer, intent(in) :: sample
      real(dp), dimension(size(grows)) :: exponent, level
      exponent = rate(grows)*time(sample)
      level = start(grows) + exponent
      excess = max(maxval(exponent) - largest_exponent, log_of_sum(level - log(rate(grows))) - limits(1))
      if (size(limits) > 1) excess = max(excess, log_of_sum(level) - limits(2))
    end function excess

  end subroutine find_overflow

  pure real(dp) function log_of_sum(logs)
    !! Return log Σ exp(logs) without overflow.
    real(dp), intent(in) :: logs(:)
    log_of_sum = maxval(logs)
    log_of_sum = log_of_sum + log(sum(exp(logs - log_of_sum)))
  end function log_of_sum

  pure subroutine add_sample_by_sample(beta_squared, c, q, q_dot, shapes, grid, samples, displacement, velocity)
    !! Add one mode, of any kind, to a range of samples.
    type(dd), intent(in) :: beta_squared
    real(dp), intent(in) :: c                    !! damping; 0: undamped
    real(dp), intent(in) :: q, q_dot
    real(dp), intent(in) :: shapes(:)
    type(time_grid), intent(in) :: grid
    integer, intent(in) :: samples(2)            !! first and last, at most the last of `find_overflow`
    real(dp), intent(inout) :: displacement(:, :)          !! (samples, points)
    real(dp), intent(inout), optional :: velocity(:, :)
    real(dp), dimension(size(shapes)) :: now, rate
    integer :: j
    do j = samples(1), samples(2)
      now = q*shapes/room
      rate = q_dot*shapes/room
      call flow(beta_squared, c, grid%step*real(j - 1, dp), now, rate)
      displacement(j, :) = displacement(j, :) + now*room
      if (present(velocity)) velocity(j, :) = velocity(j, :) + rate*room
    end do
  end subroutine add_sample_by_sample

end module bw_growing_modes
