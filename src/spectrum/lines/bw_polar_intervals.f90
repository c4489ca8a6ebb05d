module bw_polar_intervals
  !! Intervals of the modulus and the phase of a complex amplitude in known noise, also if it barely exceeds the noise.
  !!
  !! With noise of standard deviation ν in each part, the modulus of a/ν = α is about normal around √(α² + 1) (Rice, 1944): the true
  !! modulus is at least √((x − qν)² − ν²), x being the modulus found and q a normal quantile, and may be 0 where this has no root.
  !! Noise across the true direction is normal for any α: the phase φ₀ satisfies |x sin(φ − φ₀)| ≤ qν. If noise alone may have
  !! a modulus like x, the phase is unknown.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  implicit none (type, external)
  private
  public :: length_error, phase_error


contains

  elemental real(dp) function length_error(length, along, across, quantile) result(error)
    !! Half-width of the interval of a modulus; `missing` if its standard deviation is.
    real(dp), intent(in) :: length               !! the modulus found
    real(dp), intent(in) :: along, across        !! standard deviations of the amplitude along and across its direction
    real(dp), intent(in) :: quantile             !! q
    real(dp) :: least
    error = missing
    if (is_missing(along)) return
    least = sqrt(max(max(length - quantile*along, 0.0_dp)**2 - across**2, 0.0_dp))
    error = max(quantile*along, length - least)
  end function length_error

  elemental real(dp) function phase_error(deviation, quantile, confidence) result(error)
    !! Half-width of the interval of a phase; π if it may be any.
    real(dp), intent(in) :: deviation            !! standard deviation of the amplitude across its direction, over its modulus
    real(dp), intent(in) :: quantile             !! q
    real(dp), intent(in) :: confidence           !! of the interval, 0 … 1
    error = pi
    if (deviation*sqrt(-2*log(1 - confidence)) < 1) error = asin(min(quantile*deviation, 1.0_dp))
  end function phase_error

end module bw_polar_intervals
