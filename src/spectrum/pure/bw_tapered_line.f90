module bw_tapered_line
  !! The transform of a line with the taper sin⁶(πj/N), in closed form at whole bins. Ten bins away it is below a millionth,
  !! so that lines in other bins need not be known. Without the taper it serves to find poles from a few bins.
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_line, only: line_type
  implicit none (type, external)
  private
  public :: growth_of, line_image, line_in_record, parts, position_of, sidelobe, strength_of, tapered_columns

  real(dp), parameter, public :: main_lobe = 10/32.0_dp  !! mean of the taper
  real(dp), parameter, public :: taper_costs = 4.2_dp
    !! standard deviation of frequencies fitted to tapered bins over that of a fit to samples: √(Σw⁴u² Σu²)/Σw²u², w = sin⁶(πj/N)
  real(dp), parameter :: nearest = 1.0e-4_dp   !! of 1/N; a derivative needs a few digits only, and loses them closer to its bin
  real(dp), parameter :: taper(-3:3) = [-1, 6, -15, 20, -15, 6, -1]/64.0_dp  !! Fourier coefficients of sin⁶(πj/N)

contains

  pure type(line_type) function line_in_record(position, growth, count) result(line)
    !! A line without amplitude, from its periods in a record of `count` samples and the logarithm of its growth over the record.
    real(dp), intent(in) :: position, growth
    integer, intent(in) :: count
    line%pole = cmplx(growth, 2*pi*position, dp)/count
    allocate (line%courses(0))
  end function line_in_record

  elemental real(dp) function position_of(line, count) result(position)
    !! The number of periods of a line in a record of `count` samples.
    type(line_type), intent(in) :: line
    integer, intent(in) :: count
    position = line%pole%im*count/(2*pi)
  end function position_of

  elemental real(dp) function growth_of(line, count) result(growth)
    !! The logarithm of a line's growth over a record of `count` samples.
    type(line_type), intent(in) :: line
    integer, intent(in) :: count
    growth = line%pole%re*count
  end function growth_of

  elemental real(dp) function strength_of(line, count) result(strength)
    !! The norm of all sensors' amplitudes where it is largest in a record of `count` samples; it is never 0.
    type(line_type), intent(in) :: line
    integer, intent(in) :: count
    strength = sqrt(tiny(1.0_dp))
    if (allocated(line%amplitude)) &
      & strength = max(strength, norm2(abs(line%amplitude(:, 2)))*exp(max(0.0_dp, line%pole%re*(count - 1))))
  end function strength_of

  pure function tapered_columns(line, count, bins, slopes) result(columns)
    !! The bins first … last of a line of amplitude 1 and of one of amplitude i, and their derivatives by the pole, imaginary parts
    !! below real ones, (2 bins, 2, 0:slopes); slopes ≤ 1.
    type(line_type), intent(in) :: line
    integer, intent(in) :: count               !! samples in the record, N
    integer, intent(in) :: bins(2), slopes
    real(dp) :: columns(2*(bins(2) - bins(1) + 1), 2, 0:slopes)
    complex(dp), dimension(bins(2) - bins(1) + 1, 0:1) :: row, mirror
    integer :: m
    row = transform(line%pole, count, bins, .true.)/2
    mirror = transform(conjg(line%pole), count, bins, .true.)/2
    do m = 0, slopes
      columns(:, 1, m) = parts(row(:, m) + mirror(:, m))
      columns(:, 2, m) = parts((0, 1)*(row(:, m) - mirror(:, m)))
    end do
  end function tapered_columns

  pure function line_image(line, count, bins, tapered) result(image)
    !! The bins first … last of a line's transform at all sensors, (bins, S).
    type(line_type), intent(in) :: line
    integer, intent(in) :: count, bins(2)
    logical, intent(in) :: tapered
    complex(dp) :: image(bins(1):bins(2), size(line%amplitude, 1))
    complex(dp), dimension(bins(1):bins(2), 0:1) :: row, mirror
    integer :: s
    row = transform(line%pole, count, bins, tapered)/2
    mirror = transform(conjg(line%pole), count, bins, tapered)/2
    do s = 1, size(image, 2)
      image(:, s) = line%amplitude(s, 2)*row(:, 0) + conjg(line%amplitude(s, 2))*mirror(:, 0)
    end do
  end function line_image

  pure function transform(pole, count, bins, tapered) result(row)
    !! The sums Σ_j w_j e^(zj − 2πi mj/N) at the bins m for the pole z, and their derivatives by z, (bins, 0:1).
    complex(dp), intent(in) :: pole
    integer, intent(in) :: count, bins(2)
    logical, intent(in) :: tapered
    complex(dp) :: row(bins(1):bins(2), 0:1)
    complex(dp) :: plain(bins(1) - 3:bins(2) + 3, 0:1), numerator, denominator
    real(dp) :: offset, growth
    integer :: bin, m, away
    offset = pole%im*count/(2*pi)
    bin = nint(offset)
    offset = offset - bin
    numerator = exp_less_one(growth_by(pole%re*count), 2*pi*offset)
    growth = growth_by(pole%re)
    do m = bins(1) - 3, bins(2) + 3
      away = modulo(bin - m + count/2, count) - count/2
      denominator = exp_less_one(growth, 2*pi*(away + offset)/count)
      plain(m, 0) = count
      plain(m, 1) = count*(count - 1.0_dp)/2
      if (max(abs(denominator%re), abs(denominator%im)) > 0) plain(m, 0) = numerator/denominator
      if (max(abs(denominator%re), abs(denominator%im)) > nearest/count) &
        & plain(m, 1) = (count*(1 + numerator) - plain(m, 0)*(1 + denominator))/denominator
    end do
    row = plain(bins(1):bins(2), :)
    if (.not. tapered) return
    do m = bins(1), bins(2)
      row(m, :) = matmul(taper, plain(m - 3:m + 3, :))
    end do
  end function transform

  pure real(dp) function growth_by(exponent)
    !! The number e^x − 1, without cancellation near 0.
    real(dp), intent(in) :: exponent
    growth_by = exp(exponent) - 1
    if (abs(exponent) < 1) growth_by = 2*exp(exponent/2)*sinh(exponent/2)
  end function growth_by

  pure complex(dp) function exp_less_one(growth, turn)
    !! The number e^(x + iφ) − 1, without cancellation near 0.
    real(dp), intent(in) :: growth             !! e^x − 1
    real(dp), intent(in) :: turn               !! φ
    real(dp) :: half
    half = sin(turn/2)
    exp_less_one = cmplx(growth - (1 + growth)*2*half**2, (1 + growth)*2*half*cos(turn/2), dp)
  end function exp_less_one

  elemental real(dp) function sidelobe(distance)
    !! The largest leakage of a steady line through the taper at a distance, relative to the line's peak.
    real(dp), intent(in) :: distance         !! bins, of either sign
    real(dp) :: d
    d = abs(distance)
    sidelobe = 1
    if (d >= 4) sidelobe = 36/(pi*d*(d*d - 1)*(d*d - 4)*(d*d - 9))
  end function sidelobe

  pure function parts(values) result(stacked)
    !! The real parts of an image, followed by its imaginary parts.
    complex(dp), intent(in) :: values(:)
    real(dp) :: stacked(2*size(values))
    stacked = [values%re, values%im]
  end function parts

end module bw_tapered_line
