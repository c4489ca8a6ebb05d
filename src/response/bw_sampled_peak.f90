module bw_sampled_peak
  !! Estimate of how far the peak of a history exceeds its largest sample.
  !!
  !! Between samples a history is close to the parabola through three of them. Its peak is at most half a step from the
  !! nearest sample, and thus at most an eighth of the second difference above it. If the samples resolve the motion,
  !! this is a bound to fourth order in their distance. If not, as for modes above the Nyquist frequency, second
  !! differences are as large as the motion, and the estimate is about that large: ten per cent or more.
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: is_missing, missing
  implicit none (type, external)
  private
  public :: hidden_share, known_samples

contains

  pure integer function known_samples(history) result(samples)
    !! Count the samples before the first missing one.
    real(dp), intent(in) :: history(:)
    samples = findloc(is_missing(history), .true., dim=1) - 1
    if (samples < 0) samples = size(history)
  end function known_samples

  pure real(dp) function hidden_share(history) result(share)
    !! Return the estimated excess of the peak over the largest sample; missing for fewer than three samples or if all are 0.
    real(dp), intent(in), contiguous :: history(:)     !! none missing, (samples)
    real(dp) :: largest, peak, nearby(3)
    integer :: j
    share = missing
    largest = largest_magnitude(history)
    if (size(history) < 3 .or. .not. largest > 0.0_dp) return
    peak = 1.0_dp
    do j = 2, size(history) - 1
      nearby = history(j - 1:j + 1)/largest            ! avoids overflow
      peak = max(peak, abs(nearby(2)) + abs(nearby(3) - 2.0_dp*nearby(2) + nearby(1))/8.0_dp)
    end do
    share = peak - 1.0_dp
  end function hidden_share

end module bw_sampled_peak
