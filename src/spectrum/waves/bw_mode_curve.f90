module bw_mode_curve
  !! Peaks as modes of a uniform beam, and the curve ν² = c₁ α⁴ + c₀ that they lie on, with the errors of both.
  use bw_kinds, only: dp
  use bw_line_peaks, only: peak_type
  use bw_mode_ratio, only: alpha_of_ratio, alpha_range, mass_angle
  implicit none (type, external)
  private
  public :: as_mode, same_mass, curve_through, on_curve, chance_on_curve, chance_of_mass, slope_of

  real(dp), parameter :: pi = acos(-1.0_dp)

  type, public :: mode_type
    !! What a peak tells if it is a given mode: its wave number, the mass at the tip, and its squared frequency.
    integer :: number = 0                        !! 0: none
    real(dp) :: alpha = 0, alpha_error = 0
    real(dp) :: mass(2) = 0                      !! least and largest angle whose tangent is the mass ratio
    real(dp) :: square = 0, square_error = 0     !! ν² of the undamped mode and its error, ν in periods in the record
  end type mode_type

  type, public :: curve_type
    !! The curve ν² = slope α⁴ + start through two modes.
    real(dp) :: slope = 0
    real(dp) :: start = 0
    real(dp) :: power(2) = 0                     !! α⁴ of both
    real(dp) :: error(2) = 0                     !! of their ν² − slope α⁴
    real(dp) :: mass(2) = 0                      !! the mass angles that both allow
  end type curve_type

contains

  elemental type(mode_type) function as_mode(peak, number) result(mode)
    !! The peak as the mode of that number; the number is 0 if its ratio forbids it.
    type(peak_type), intent(in) :: peak
    integer, intent(in) :: number
    real(dp) :: rounding
    logical :: found
    call alpha_of_ratio(peak%ratio, peak%ratio_error, number, mode%alpha, mode%alpha_error, found)
    if (.not. found) return
    mode%number = number
    rounding = 8*epsilon(1.0_dp)
    mode%mass = [mass_angle(mode%alpha + mode%alpha_error, number) - rounding, &
      & mass_angle(max(mode%alpha - mode%alpha_error, mode%alpha/2), number) + rounding]
    mode%square = peak%position**2 + (peak%growth/(2*pi))**2
    mode%square_error = (2*peak%position + peak%position_error)*peak%position_error &
      & + (2*abs(peak%growth)/(2*pi) + peak%position_error)*peak%position_error + 4*epsilon(1.0_dp)*mode%square
  end function as_mode

  elemental logical function same_mass(one, other)
    !! Whether both may be modes of one beam.
    type(mode_type), intent(in) :: one, other
    same_mass = one%mass(1) <= other%mass(2) .and. other%mass(1) <= one%mass(2)
  end function same_mass

  pure subroutine curve_through(low, high, curve, possible)
    !! Find the curve through two modes.
    type(mode_type), intent(in) :: low, high     !! of different numbers
    type(curve_type), intent(out) :: curve
    logical, intent(out) :: possible             !! c₁ > 0, and c₀ ≤ 0 within the errors
    curve%power = [low%alpha, high%alpha]**4
    curve%slope = (high%square - low%square)/(curve%power(2) - curve%power(1))
    curve%start = low%square - curve%slope*curve%power(1)
    curve%error = curve_error([low, high], curve%slope)
    curve%mass = [max(low%mass(1), high%mass(1)), min(low%mass(2), high%mass(2))]
    possible = curve%slope > 0
    if (possible) possible = curve%start <= tolerance(0.0_dp, curve)
  end subroutine curve_through

  pure real(dp) function tolerance(power, curve)
    !! The error of the curve's ν² at α⁴ = power.
    real(dp), intent(in) :: power
    type(curve_type), intent(in) :: curve
    real(dp) :: share
    share = (curve%power(2) - power)/(curve%power(2) - curve%power(1))
    tolerance = abs(share)*curve%error(1) + abs(1 - share)*curve%error(2)
  end function tolerance

  elemental real(dp) function curve_error(mode, slope)
    !! The error of a mode's ν² − slope·α⁴.
    type(mode_type), intent(in) :: mode
    real(dp), intent(in) :: slope
    curve_error = mode%square_error + slope*((mode%alpha + mode%alpha_error)**4 - mode%alpha**4)
  end function curve_error

  pure real(dp) function both_errors(mode, curve)
    !! The error of the difference between a mode's ν² and the curve's.
    type(mode_type), intent(in) :: mode
    type(curve_type), intent(in) :: curve
    both_errors = curve_error(mode, curve%slope) + tolerance(mode%alpha**4, curve)
  end function both_errors

  pure logical function on_curve(mode, curve)
    !! Whether frequency and wave number agree with the curve within their errors and its own.
    type(mode_type), intent(in) :: mode
    type(curve_type), intent(in) :: curve
    on_curve = abs(mode%square - curve%start - curve%slope*mode%alpha**4) <= both_errors(mode, curve)
  end function on_curve

  pure real(dp) function chance_on_curve(mode, curve) result(chance)
    !! How likely a ratio that allows the mode agrees with the curve by chance: its errors' part of the mode's range.
    type(mode_type), intent(in) :: mode
    type(curve_type), intent(in) :: curve
    real(dp) :: range(2)
    range = alpha_range(mode%number)
    chance = min(1.0_dp, 2*both_errors(mode, curve)/(curve%slope*(range(2)**4 - range(1)**4)))
  end function chance_on_curve

  pure real(dp) function chance_of_mass(mode, curve) result(chance)
    !! How likely a ratio that allows the mode implies the curve's mass by chance, likewise.
    type(mode_type), intent(in) :: mode
    type(curve_type), intent(in) :: curve
    real(dp) :: range(2), width
    range = alpha_range(mode%number)
    width = mode%mass(2) - mode%mass(1)
    chance = min(1.0_dp, 2*mode%alpha_error*(width + curve%mass(2) - curve%mass(1))/(width*(range(2) - range(1))))
  end function chance_of_mass

  pure subroutine slope_of(modes, slope, slope_error)
    !! Find c₁ of the curve through numbered peaks: any two of them allow an interval of slopes, and the true one is in all. The
    !! narrowest gives the value, all together the bound.
    type(mode_type), intent(in) :: modes(:)
    real(dp), intent(out) :: slope, slope_error  !! 0 where fewer than two have a number, or no slope is in all intervals
    real(dp) :: between, error, least, low, high
    integer :: i, j
    slope = 0
    slope_error = 0
    least = huge(1.0_dp)
    low = 0
    high = huge(1.0_dp)
    do i = 1, size(modes)
      do j = 1, i - 1
        if (modes(i)%number == 0 .or. modes(j)%number == 0) cycle
        associate (step => modes(i)%alpha**4 - modes(j)%alpha**4)
          between = (modes(i)%square - modes(j)%square)/step
          error = sum(curve_error(modes([i, j]), abs(between)))/abs(step) + 8*epsilon(1.0_dp)*abs(between)
        end associate
        low = max(low, between - error)
        high = min(high, between + error)
        if (error >= least) cycle
        least = error
        slope = between
      end do
    end do
    if (low <= high .and. least < huge(1.0_dp)) then
      slope_error = max(high - slope, slope - low)
    else
      slope = 0
    end if
  end subroutine slope_of

end module bw_mode_curve
