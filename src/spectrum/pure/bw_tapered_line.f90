module bw_tapered_line
  !! The transform of a line through the taper sin⁶(πj/N), in closed form at whole bins: ten bins away it is below a millionth,
  !! so that lines in other bins need not be known. Without the taper it is there for the poles of a few bins.
  use bw_constants, only: pi
  use bw_damped_line, only: damped_line, place_in_bins
  use bw_kinds, only: dp
  implicit none (type, external)
  private
  public :: line_image, parts, sidelobe, tapered_columns

  real(dp), parameter, public :: main_lobe = 10/32.0_dp  !! mean of the taper
  real(dp), parameter, public :: taper_costs = 4.2_dp
    !! deviations of frequencies fitted to tapered bins, of those fitted to samples: √(Σw⁴u² Σu²)/Σw²u², w = sin⁶(πj/N), |u| ≤ 1
  real(dp), parameter :: difference = 1.0e-4_dp  !! bins; slopes need a few digits only, images are exact
  real(dp), parameter :: taper(-3:3) = [-1, 6, -15, 20, -15, 6, -1]/64.0_dp  !! sin⁶(πj/N) as a row of bins

contains

  pure function tapered_columns(line, count, first, last, order) result(columns)
    !! The bins first … last of u^m e^(−dτ) cos 2πfτ and of −u^m e^(−dτ) sin 2πfτ, which are a line of amplitude 1 and one of
    !! amplitude i, for m = 0 … order ≤ 1, with imaginary parts below real ones, (2 bins, 2, 0:order); u = −1 … 1.
    type(damped_line), intent(in) :: line
    integer, intent(in) :: count               !! samples in the record, N
    integer, intent(in) :: first, last, order
    real(dp) :: columns(2*(last - first + 1), 2, 0:order)
    complex(dp), dimension(last - first + 1) :: row, mirror
    integer :: bin, m
    real(dp) :: offset, growth
    growth = -line%decay*count
    call place_in_bins(line, count, bin, offset)
    do m = 0, order
      row = moment(bin, offset, growth, count, first, last, m)/2
      mirror = moment(-bin, -offset, growth, count, first, last, m)/2
      columns(:, 1, m) = parts(row + mirror)
      columns(:, 2, m) = parts((0, 1)*(row - mirror))
    end do
  end function tapered_columns

  pure function line_image(line, count, first, last, tapered) result(image)
    !! The bins first … last of a line's transform at all sensors, (bins, S).
    type(damped_line), intent(in) :: line
    integer, intent(in) :: count, first, last
    logical, intent(in) :: tapered
    complex(dp) :: image(first:last, size(line%amplitude))
    complex(dp) :: row(first:last), mirror(first:last)
    integer :: bin, s
    real(dp) :: offset, growth
    growth = -line%decay*count
    call place_in_bins(line, count, bin, offset)
    row = transform(bin, offset, growth, count, first, last, tapered)/2
    mirror = transform(-bin, -offset, growth, count, first, last, tapered)/2
    do s = 1, size(image, 2)
      image(:, s) = line%amplitude(s)*row + conjg(line%amplitude(s))*mirror
    end do
  end function line_image

  pure function moment(bin, offset, growth, count, first, last, order) result(row)
    !! The tapered transform of u^m e^(p j/N), m = 0 or 1, p = growth + 2πi(bin + offset): u is 2j/(N − 1) − 1, and the factor
    !! j/N is a derivative by p.
    integer, intent(in) :: bin, count, first, last, order
    real(dp), intent(in) :: offset, growth
    complex(dp) :: row(first:last)
    row = transform(bin, offset, growth, count, first, last, .true.)
    if (order == 0) return
    row = (transform(bin, offset + difference, growth, count, first, last, .true.) &
      & - transform(bin, offset - difference, growth, count, first, last, .true.))/cmplx(0, 2*pi*difference, dp) &
      & *(count/(count - 1.0_dp)) - row
  end function moment

  pure function transform(bin, offset, growth, count, first, last, tapered) result(row)
    !! The geometric sum Σ_j w_j e^((growth + 2πi (bin − m + offset)) j/N) at the bins m = first … last, over e^(growth (N − 1)/N)
    !! where that grows.
    integer, intent(in) :: bin, count, first, last
    real(dp), intent(in) :: offset, growth
    logical, intent(in) :: tapered
    complex(dp) :: row(first:last)
    complex(dp) :: plain(first - 3:last + 3), numerator, denominator
    integer :: m, away
    if (growth > 0) then
      numerator = -exp(cmplx(growth/count, 2*pi*offset, dp))*exp_less_one(cmplx(-growth, -2*pi*offset, dp))
    else
      numerator = exp_less_one(cmplx(growth, 2*pi*offset, dp))
    end if
    do m = first - 3, last + 3
      away = modulo(bin - m + count/2, count) - count/2
      denominator = exp_less_one(cmplx(growth, 2*pi*(away + offset), dp)/count)
      if (abs(denominator) > 0) then
        plain(m) = numerator/denominator
      else
        plain(m) = count
      end if
    end do
    if (.not. tapered) then
      row = plain(first:last)
    else
      do m = first, last
        row(m) = sum(taper*plain(m - 3:m + 3))
      end do
    end if
  end function transform

  pure complex(dp) function exp_less_one(z)
    !! The number e^z − 1, without cancellation near 0.
    complex(dp), intent(in) :: z
    real(dp) :: half, growth
    half = sin(z%im/2)
    if (abs(z%re) < 1) then
      growth = 2*exp(z%re/2)*sinh(z%re/2)
    else
      growth = exp(z%re) - 1
    end if
    exp_less_one = cmplx(growth*cos(z%im) - 2*half*half, exp(z%re)*sin(z%im), dp)
  end function exp_less_one

  elemental real(dp) function sidelobe(distance)
    !! The largest leakage of a steady line through the taper at that distance, relative to the line's peak.
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
