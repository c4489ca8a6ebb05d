module bw_line_bounds
  !! This module bounds the errors of fitted lines.
  !!
  !! A bound is `safety` standard deviations of the fit. The noise is the residual in the bins that the line itself reaches, since
  !! a residual elsewhere does not move the line; it is at least rounding. The bound holds for a line that is alone. A line d bins
  !! beside this one that is taken for a part of it moves it by up to d bins and leaves about d² of it in the residual, or d if its
  !! ratio is another: a residual that is the fraction ρ of the line may hide one that moves it by √ρ bins, and changes its ratio
  !! by the fraction √ρ. This effect is reported separately.
  use bw_constants, only: pi
  use bw_band, only: tapered_band
  use bw_band_fit, only: reduce
  use bw_kinds, only: dp
  use bw_line, only: line_type
  use bw_line_errors, only: amplitude_deviation, line_errors, line_errors_of, pole_deviation
  use bw_line_group, only: band_of, correlated, group_image, group_noise, group_type, numbers_in, unknowns
  use bw_pure_record, only: rounding, safety
  use bw_tapered_line, only: growth_of, main_lobe, position_of, strength_of
  use bw_tapered_residual, only: residual_type
  implicit none (type, external)
  private
  public :: bound_errors

  real(dp), parameter :: unexplained = 10      !! times the noise, above which the residual hides a line
  real(dp), parameter :: unlikely = 1.0e-4_dp  !! probability that a line lies beside another by chance
  real(dp), parameter :: at_edge = 1.0e-3_dp   !! bins from 0 or the Nyquist frequency
  real(dp), parameter :: motionless = 1.0e-100_dp   !! relative to the midpoint; a tip that moves less has no ratio: 1/c₁² overflows

  type, public :: bounded_line
    !! A line with bounds of its errors. Positions are in periods per record.
    real(dp) :: position = 0
    real(dp) :: position_error = 0
    real(dp) :: growth = 0                     !! logarithm of the growth over the record
    logical :: steady = .true.                 !! the growth is held at 0
    real(dp) :: strength = 0                   !! norm of the amplitudes of all sensors
    real(dp) :: strength_error = 0
    real(dp) :: ratio = 0                      !! signed, of the second sensor to the first
    real(dp) :: ratio_error = 0                !! huge if there is no ratio
    real(dp) :: hidden = 0                     !! fraction of it that may belong to a line hidden beside it
    logical :: doubtful = .true.               !! such a line cannot be excluded
  end type bounded_line

contains

  subroutine bound_errors(fitted, others, density, residual, lines, explained)
    !! Bound the errors of a group's lines, and the effect of hidden lines on them.
    type(line_type), intent(in) :: fitted(:)
    type(line_type), intent(in) :: others(:)   !! of the group, treated as part of the residual
    real(dp), intent(in) :: density              !! lines per bin of the whole record
    type(residual_type), intent(in) :: residual
    type(bounded_line), allocatable, intent(out) :: lines(:)  !! one for each
    logical, intent(out) :: explained            !! the residual is no more than noise
    complex(dp), allocatable :: image(:, :)
    real(dp) :: residual_norm(size(fitted)), noise(size(fitted)), expected, free
    integer :: bins(2), i
    bins = band_of(group_type([fitted, others], [integer ::]), residual%count)
    allocate (image(bins(1):bins(2), size(residual%tapered, 2)), source=group_image(residual, others, bins))
    expected = group_noise(residual, fitted)
    free = max(1.0_dp, numbers_in(residual, bins)/correlated - sum(unknowns(fitted, size(image, 2))))
    do i = 1, size(fitted)
      associate (own => own_bins(fitted(i), residual%count, bins))
        residual_norm(i) = norm2(abs(image(own(1):own(2), :)))
        noise(i) = max(residual_norm(i)/sqrt(free*numbers_in(residual, own)/numbers_in(residual, bins)), expected)
      end associate
    end do
    explained = norm2(abs(image)) <= unexplained*expected*sqrt(free)
    allocate (lines, source=lines_in_noise(without_phase_at_ends(fitted, residual%count), residual, bins, safety*noise))
    lines%hidden = sqrt(residual_norm/(lines%strength*residual%count*main_lobe/2))
    lines%doubtful = .not. explained .or. 2*density*lines%hidden > unlikely
    lines%position_error = min(lines%position_error, real(residual%count, dp)) + rounding*lines%position
    lines%ratio_error = min(lines%ratio_error, sqrt(huge(1.0_dp))) + 4*epsilon(1.0_dp)*abs(lines%ratio)
    do i = 1, size(fitted)
      associate (c => fitted(i)%amplitude(:, 2))
        lines(i)%ratio_error = lines(i)%ratio_error + abs(aimag(c(2)*conjg(c(1))))/max(abs(c(1))**2, tiny(1.0_dp))
      end associate
    end do
  end subroutine bound_errors

  pure function own_bins(line, count, bins) result(own)
    !! The first and last of the group's bins that are also in the band of this line alone.
    type(line_type), intent(in) :: line
    integer, intent(in) :: count, bins(2)      !! number of samples; bins of the group
    integer :: own(2)
    own = band_of(group_type([line], [integer ::]), count)
    own = max(bins(1), min(bins(2), own))
  end function own_bins

  pure function without_phase_at_ends(fitted, count) result(lines)
    !! The lines, with each steady one that is at 0 or the Nyquist frequency to within rounding put there exactly: it has no phase,
    !! and its errors must not depend on one.
    type(line_type), intent(in) :: fitted(:)
    integer, intent(in) :: count
    type(line_type) :: lines(size(fitted))
    real(dp) :: position
    integer :: i
    lines = fitted
    do i = 1, size(lines)
      position = position_of(lines(i), count)
      if (.not. lines(i)%steady .or. min(position, count/2.0_dp - position) > at_edge) cycle
      lines(i)%pole = merge((0.0_dp, 0.0_dp), cmplx(0, pi, dp), 4*position < count)
      lines(i)%amplitude = lines(i)%amplitude%re
    end do
  end function without_phase_at_ends

  function lines_in_noise(fitted, residual, bins, noise) result(lines)
    !! Find the ratio of each line, and the errors of position, strength and ratio due to noise. If the first sensor moves no more
    !! than by rounding, there is no ratio: it is 0 with a huge error.
    type(line_type), intent(in) :: fitted(:)
    type(residual_type), intent(in) :: residual
    integer, intent(in) :: bins(2)
    real(dp), intent(in) :: noise(:)           !! standard deviation of a real number of the image near each line, (line)
    type(bounded_line) :: lines(size(fitted))
    type(line_errors) :: errors
    real(dp) :: direction(2, 2)
    integer :: i
    errors = line_errors_of(fitted, reduce(tapered_band(residual%count, group_image(residual, fitted, bins), bins(1), 1.0_dp), &
      & fitted, .false.))
    do i = 1, size(fitted)
      associate (line => lines(i), c => fitted(i)%amplitude(:, 2), deviation => pole_deviation(errors, i, 0.0_dp))
        line%position = position_of(fitted(i), residual%count)
        line%growth = growth_of(fitted(i), residual%count)
        line%steady = fitted(i)%steady
        line%strength = strength_of(fitted(i), residual%count)
        line%position_error = noise_times(deviation(2), noise(i)*residual%count/(2*pi))
        line%strength_error = huge(1.0_dp)
        line%ratio_error = huge(1.0_dp)
        if (any(abs(c) > 0)) then                    ! of lines at one position, the fit may give one no amplitude
          direction = reshape([c(1)%re, c(1)%im, c(2)%re, c(2)%im], [2, 2])/norm2(abs(c))
          line%strength_error = noise_times(amplitude_deviation(errors, 1, i, direction), noise(i))
        end if
        if (abs(c(1)) > motionless*abs(c(2))) then
          call ratio_of(c, line%ratio, direction)
          line%ratio_error = noise_times(amplitude_deviation(errors, 1, i, direction), noise(i))
        end if
      end associate
    end do
  end function lines_in_noise

  elemental real(dp) function noise_times(factor, noise)
    !! The product, or huge if the factor is.
    real(dp), intent(in) :: factor, noise
    noise_times = huge(1.0_dp)
    if (factor < sqrt(huge(1.0_dp))) noise_times = factor*noise
  end function noise_times

  pure subroutine ratio_of(amplitude, ratio, gradient)
    !! The ratio R = Re(c₂/c₁) of two amplitudes, and its slopes with respect to Re c₁, Im c₁, Re c₂, Im c₂.
    complex(dp), intent(in) :: amplitude(:)
    real(dp), intent(out) :: ratio, gradient(:, :)  !! gradient: (2, sensor)
    complex(dp) :: inverse, slope
    inverse = 1/amplitude(1)
    ratio = real(amplitude(2)*inverse, dp)
    slope = -amplitude(2)*inverse*inverse
    gradient = reshape([slope%re, -slope%im, inverse%re, -inverse%im], [2, 2])
  end subroutine ratio_of

end module bw_line_bounds
