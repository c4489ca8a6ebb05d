module bw_polar_intervals
  !! Intervals of the length and the phase of a complex amplitude whose noise is known, also where it hardly stands out of it.
  !!
  !! Noise of deviation ν on each part makes the length of a/ν = α that of √(α² + 1) with about a normal number added (Rice, 1944):
  !! a length is at least √((x − qν)² − ν²), x being what was found and q a normal quantile, and may be 0 where this has no root.
  !! What noise adds across the true direction is normal for any α: the phase φ₀ has |x sin(φ − φ₀)| ≤ qν. Where noise alone makes
  !! a length like x, nothing is known of the phase.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  implicit none (type, external)
  private
  public :: length_error, phase_error


contains

  elemental real(dp) function length_error(length, along, across, quantile) result(error)
    !! Half the width of the interval of a length; `missing` where its deviation is.
    real(dp), intent(in) :: length               !! as it was found
    real(dp), intent(in) :: along, across        !! deviations of the amplitude in its direction and across it
    real(dp), intent(in) :: quantile             !! q
    real(dp) :: least
    error = missing
    if (is_missing(along)) return
    least = sqrt(max(max(length - quantile*along, 0.0_dp)**2 - across**2, 0.0_dp))
    error = max(quantile*along, length - least)
  end function length_error

  elemental real(dp) function phase_error(deviation, quantile, confidence) result(error)
    !! Half the width of the interval of a phase, π where it may be any.
    real(dp), intent(in) :: deviation            !! of the amplitude across its direction, over its length
    real(dp), intent(in) :: quantile             !! q
    real(dp), intent(in) :: confidence           !! of the interval, 0 … 1
    error = pi
    if (deviation*sqrt(-2*log(1 - confidence)) < 1) error = asin(min(quantile*deviation, 1.0_dp))
  end function phase_error

end module bw_polar_intervals
