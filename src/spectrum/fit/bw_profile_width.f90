module bw_profile_width
  !! Intervals of decay and frequency by the profile likelihood, for lines that are not far above the noise.
  !!
  !! A quantile of the Cramér–Rao deviation holds so much of a normal number only where estimates follow the noise linearly. A line
  !! that noise moves by a part of its own width has a likelihood that is no parabola, and estimates that scatter more. So the
  !! place on either side is sought where the squares, all other unknowns fitted again, are by the quantile's square above the
  !! least; what is told is half of the way between them.
  use bw_band_fit, only: fit_band, fit_type
  use bw_damped_line, only: damped_line
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band
  use bw_samples, only: centre_of, samples_type
  implicit none (type, external)
  private
  public :: profile_widths

  real(dp), parameter :: pi = acos(-1.0_dp)
  real(dp), parameter :: nearly_linear = 0.04_dp !! deviation, of the line's width: below it profiles differ by less than 1 %
  real(dp), parameter :: hardly_told = 1         !! deviation, of the line's width, from which on there is no place to be found
  integer, parameter :: looks = 3                !! for each place
  real(dp), parameter :: farther = 2             !! times as far as the look before

contains

  function profile_widths(samples, band, rows, weight, own, j, deviation, quantile) result(width)
    !! Half the widths of the intervals of line j's decay and 2π·frequency over half the record. Those of a line that drifts, of one
    !! far above the noise, and of one that the record hardly tells are quantiles of the deviations.
    type(samples_type), intent(in) :: samples
    type(line_band), intent(in) :: band
    real(dp), intent(in) :: rows(:, :)           !! without the lines that are not the band's
    real(dp), intent(in) :: weight(:)            !! one over the noise's variance, (S)
    type(damped_line), intent(in) :: own(:)
    integer, intent(in) :: j
    real(dp), intent(in) :: deviation(2)         !! of −decay and of 2π·frequency, over half the record
    real(dp), intent(in) :: quantile             !! deviations
    real(dp) :: width(2)
    type(fit_type) :: best
    real(dp) :: scale
    integer :: k
    width = quantile*deviation
    scale = max(1.0_dp, abs(own(j)%decay)*centre_of(samples))
    if (own(j)%powers > 1) return
    if (maxval(deviation) < nearly_linear*scale .or. maxval(deviation) > hardly_told*scale) return
    best%lines = own
    call fit_band(samples, band%band, rows, weight, band%with_still, best)
    width = [(reach(k, -1) + reach(k, 1), k=1, 2)]/2

  contains

    real(dp) function reach(k, side) result(away)
      !! How far the decay (1) or the frequency (2) may go to one side.
      integer, intent(in) :: k, side
      type(fit_type) :: fit
      real(dp) :: rise
      integer :: i
      fit%lines = best%lines
      fit%lines(j)%steady = k == 1
      fit%lines(j)%fixed = k == 2
      away = quantile*deviation(k)
      do i = 1, looks
        if (k == 1) fit%lines(j)%decay = best%lines(j)%decay + side*away/centre_of(samples)
        if (k == 2) fit%lines(j)%frequency = best%lines(j)%frequency + side*away/(2*pi*centre_of(samples))
        call fit_band(samples, band%band, rows, weight, band%with_still, fit)
        rise = max(fit%left - best%left, tiny(1.0_dp))
        away = away*max(1/farther, min(farther, quantile/sqrt(rise)))
      end do
    end function reach

  end function profile_widths

end module bw_profile_width
