module bw_limited_range
  !! Sensors that clip: near the end of a sensor's range only those samples remain that noise pushed inwards.
  !!
  !! A sample of expectation μ that is known to be below a limit L is on average σφ(a)/Φ(a) less than μ, where a = (L − μ)/σ, φ is
  !! the normal density and Φ its integral. With this correction the normal equations of least squares are those of the likelihood
  !! of truncated samples. Source: Amemiya, Econometrica 41 (1973) 997.
  use bw_band_fit, only: converged
  use bw_constants, only: pi
  use bw_cost, only: order_price
  use bw_kinds, only: dp
  use bw_model, only: find_misfit, model_type
  use bw_refit, only: all_steps, refit_all
  use bw_renewal, only: renew
  use bw_samples, only: samples_type
  implicit none (type, external)
  private
  public :: allow_for_limits

  integer, parameter :: rounds = 3
  real(dp), parameter :: far = sqrt(huge(1.0_dp))
  real(dp), parameter :: reach = 6               !! standard deviations from a limit within which it truncates noise

contains

  subroutine allow_for_limits(samples, model)
    !! Fit the lines to samples corrected for the mean of the noise that limits truncate.
    type(samples_type), intent(inout) :: samples   !! unchanged on return
    type(model_type), intent(inout) :: model
    real(dp) :: limits(2, size(samples%value, 2))
    real(dp), allocatable :: recorded(:, :), residual(:, :)
    integer :: round, s
    if (.not. allocated(samples%valid) .or. size(model%lines) == 0) return
    limits = limits_of(samples)
    if (all(abs(limits) >= far)) return
    allocate (recorded, source=samples%value)
    allocate (residual(samples%count, size(limits, 2)))
    do round = 1, rounds
      call find_misfit(samples, model, [(s, s=1, size(residual, 2))], residual)
      call correct(limits, recorded, residual, samples)
      if (allocated(model%last)) deallocate (model%last)
      call renew(samples, order_price(samples), .false., model)
      call refit_all(all_steps, converged, model)
    end do
    call renew(samples, order_price(samples), .false., model)
    call move_alloc(recorded, samples%value)
  end subroutine allow_for_limits

  pure function limits_of(samples) result(limits)
    !! The lowest and highest value that each sensor can record; ±`far` if it does not clip. All samples at a limit are invalid.
    type(samples_type), intent(in) :: samples
    real(dp) :: limits(2, size(samples%value, 2)), ends(2)
    integer :: s, n
    limits(1, :) = -far
    limits(2, :) = far
    do s = 1, size(limits, 2)
      associate (x => samples%value(:samples%count, s))
        ends = [minval(x), maxval(x)]
        if (.not. any([(samples%valid(n) .and. x(n) <= ends(1), n=1, size(x))])) limits(1, s) = ends(1)
        if (.not. any([(samples%valid(n) .and. x(n) >= ends(2), n=1, size(x))])) limits(2, s) = ends(2)
      end associate
    end do
  end function limits_of

  pure subroutine correct(limits, recorded, residual, samples)
    !! Add to each sample the mean that truncation takes from the noise of such a motion.
    real(dp), intent(in) :: limits(:, :), recorded(:, :)
    real(dp), intent(in) :: residual(:, :)       !! residual of the samples as corrected last
    type(samples_type), intent(inout) :: samples
    real(dp) :: deviation, motion
    integer :: s, n
    do s = 1, size(residual, 2)
      deviation = sqrt(sum(residual(:, s)**2, mask=samples%valid)/max(1, count(samples%valid)))
      do n = 1, size(residual, 1)
        if (.not. samples%valid(n)) cycle
        motion = samples%value(n, s) - residual(n, s)
        samples%value(n, s) = recorded(n, s) + deviation*(truncated_mean((limits(2, s) - motion)/deviation) &
          & - truncated_mean((motion - limits(1, s))/deviation))
      end do
    end do
  end subroutine correct

  elemental real(dp) function truncated_mean(a)
    !! The ratio φ(a)/Φ(a).
    real(dp), intent(in) :: a
    truncated_mean = 0
    if (a < reach) truncated_mean = sqrt(2/pi)/erfc_scaled(-max(a, -reach)/sqrt(2.0_dp))
  end function truncated_mean

end module bw_limited_range
