module bw_sampled_peak
  !! How far the peak of a history may lie above its largest sample.
  !!
  !! Between samples a history is about the parabola through three of them. Its peak lies at most half a step from the nearest
  !! sample, and so at most an eighth of the second difference above it. Where samples follow the motion this is a bound, but for
  !! terms of fourth order in their distance. Where they do not follow it, as when modes are faster than half the sampling rate,
  !! second differences are as large as the motion, and the estimate says that much may be hidden: some ten per cent, or more.
  use bw_kinds, only: dp
  use bw_magnitude, only: largest_magnitude
  use bw_missing, only: is_missing, missing
  implicit none (type, external)
  private
  public :: hidden_share, known_samples

contains

  pure integer function known_samples(history) result(samples)
    !! How many samples come before the first that is missing.
    real(dp), intent(in) :: history(:)
    samples = findloc(is_missing(history), .true., dim=1) - 1
    if (samples < 0) samples = size(history)
  end function known_samples

  pure real(dp) function hidden_share(history) result(share)
    !! Estimate of what samples hide of the peak, over the largest of them; missing of fewer than three, and where all are 0.
    real(dp), intent(in), contiguous :: history(:)     !! none missing, (samples)
    real(dp) :: largest, peak, nearby(3)
    integer :: j
    share = missing
    largest = largest_magnitude(history)
    if (size(history) < 3 .or. .not. largest > 0.0_dp) return
    peak = 1.0_dp
    do j = 2, size(history) - 1
      nearby = history(j - 1:j + 1)/largest            ! histories may be as large as numbers are
      peak = max(peak, abs(nearby(2)) + abs(nearby(3) - 2.0_dp*nearby(2) + nearby(1))/8.0_dp)
    end do
    share = peak - 1.0_dp
  end function hidden_share

end module bw_sampled_peak
