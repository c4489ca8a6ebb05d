module bw_limited_range
  !! Sensors that clip: near the end of a sensor's range only those samples remain that noise pushed inwards.
  !!
  !! A sample of expectation μ that is known to be below a limit L is on average σφ(a)/Φ(a) less than μ, where a = (L − μ)/σ, φ is
  !! the normal density and Φ its integral, and its variance is σ²(1 − m(m + a)) with m = φ/Φ. With this correction the normal
  !! equations of least squares are those of the likelihood of truncated samples. Source: Amemiya, Econometrica 41 (1973) 997.
  use bw_band_fit, only: converged
  use bw_constants, only: pi
  use bw_cost, only: order_price
  use bw_kinds, only: dp
  use bw_model, only: find_misfit, model_type
  use bw_monitor, only: monitor_type, stops
  use bw_refit, only: all_steps, refit_all
  use bw_renewal, only: renew
  use bw_samples, only: samples_type, validity
  implicit none (type, external)
  private
  public :: allow_for_limits

  integer, parameter :: most_rounds = 50
  real(dp), parameter :: least_change = 0.01_dp  !! in a round, in variances: smaller ones move lines by less than half a deviation
  real(dp), parameter :: far = sqrt(huge(1.0_dp))
  real(dp), parameter :: reach = 6               !! standard deviations from a limit within which it truncates noise

contains

  subroutine allow_for_limits(samples, model, recorded, monitor)
    !! Fit the lines to samples corrected for the mean of the noise that limits truncate.
    type(samples_type), intent(inout) :: samples   !! with corrected values on return
    type(model_type), intent(inout) :: model
    real(dp), allocatable, intent(inout) :: recorded(:, :)  !! the values, before any correction; unallocated if no sensor clips
    class(monitor_type), intent(inout), optional :: monitor  !! results are undefined after a stop request
    real(dp) :: limits(2, size(samples%value, 2))
    real(dp), allocatable :: residual(:, :)
    real(dp) :: change
    integer :: round, s
    if (.not. allocated(samples%missing) .or. size(model%lines) == 0) return
    if (allocated(recorded)) samples%value = recorded
    limits = limits_of(samples)
    if (all(abs(limits) >= far)) return
    if (.not. allocated(recorded)) allocate (recorded, source=samples%value)
    allocate (residual(samples%count, size(limits, 2)))
    do round = 1, most_rounds
      call find_misfit(samples, model, [(s, s=1, size(residual, 2))], residual)
      call correct(limits, recorded, residual, samples, change)
      if (change < least_change) exit
      if (stops(monitor)) return
      if (allocated(model%last)) deallocate (model%last)
      call renew(samples, order_price(samples), .false., model)
      call refit_all(all_steps, converged, model)
    end do
    call renew(samples, order_price(samples), .false., model)
  end subroutine allow_for_limits

  pure function limits_of(samples) result(limits)
    !! The lowest and highest value that each sensor can record; ±`far` if it does not clip. All samples at a limit are invalid.
    type(samples_type), intent(in) :: samples
    real(dp) :: limits(2, size(samples%value, 2)), ends(2)
    logical :: valid(samples%count)
    integer :: s
    limits(1, :) = -far
    limits(2, :) = far
    do s = 1, size(limits, 2)
      associate (x => samples%value(:samples%count, s))
        ends = [minval(x), maxval(x)]
        valid = validity(samples, s)
        if (.not. any(valid .and. x <= ends(1))) limits(1, s) = ends(1)
        if (.not. any(valid .and. x >= ends(2))) limits(2, s) = ends(2)
      end associate
    end do
  end function limits_of

  pure subroutine correct(limits, recorded, residual, samples, change)
    !! Add to each sample the mean that truncation takes from the noise of such a motion.
    real(dp), intent(in) :: limits(:, :), recorded(:, :)
    real(dp), intent(in) :: residual(:, :)       !! residual of the samples as corrected last
    type(samples_type), intent(inout) :: samples
    real(dp), intent(out) :: change              !! sum of squares, in variances of the noise
    real(dp), dimension(samples%count, 2) :: distance, mean   !! to either limit; that the limit takes
    real(dp), dimension(samples%count) :: motion, corrected
    real(dp) :: deviation
    logical :: valid(samples%count)
    integer :: s, step
    change = 0
    do s = 1, size(residual, 2)
      valid = validity(samples, s)
      motion = samples%value(:samples%count, s) - residual(:, s)
      deviation = max(sqrt(sum(residual(:, s)**2, mask=valid)/max(1, count(valid))), epsilon(1.0_dp)*maxval(abs(motion)), &
        & tiny(1.0_dp)/epsilon(1.0_dp))
      do step = 1, 2                              ! as if all noise were left, and with the part that is
        distance(:, 1) = motion - limits(1, s)
        distance(:, 2) = limits(2, s) - motion
        distance = max(-reach, min(distance, reach*deviation)/deviation)
        mean = truncated_mean(distance)
        if (step == 1) deviation = deviation*sqrt(count(valid)/sum(1 - sum(mean*(mean + distance), dim=2), mask=valid))
      end do
      corrected = recorded(:samples%count, s) + deviation*(mean(:, 2) - mean(:, 1))
      associate (x => samples%value(:samples%count, s))
        change = change + sum(((corrected - x)/deviation)**2, mask=valid)
        where (valid) x = corrected
      end associate
    end do
  end subroutine correct

  elemental real(dp) function truncated_mean(a)
    !! The ratio φ(a)/Φ(a).
    real(dp), intent(in) :: a
    truncated_mean = 0
    if (a < reach) truncated_mean = sqrt(2/pi)/erfc_scaled(-a/sqrt(2.0_dp))
  end function truncated_mean

end module bw_limited_range
