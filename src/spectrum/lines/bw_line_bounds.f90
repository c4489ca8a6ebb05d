module bw_line_bounds
  !! This module tells how far fitted lines may be from the true ones.
  !!
  !! A bound is `safety` standard deviations of the fit. The noise is what the fit leaves in the group's bins, never less than
  !! rounding; where that is more than noise, it is what is left in the bins that the line itself reaches, since what is not
  !! explained elsewhere does not move it. The bound holds for a line that is alone. A line that lies d bins beside this one
  !! and is taken for a part of it moves it by up to d bins and leaves about d² of it in the residual, or d where its ratio is
  !! another: a residual that is the part ρ of the line may hide one that moves it by √ρ bins, and its ratio by the part √ρ.
  !! That is told apart.
  use bw_kinds, only: dp
  use bw_line_fit, only: factorise, gradient_length
  use bw_line, only: jacobian, line_position, line_type, main_lobe, points, unknowns
  use bw_line_group, only: band_of, correlated, group_image, group_noise, group_type, numbers_in
  use bw_line_residual, only: residual_type
  implicit none (type, external)
  private
  public :: bound_errors, line_strength

  real(dp), parameter :: safety = 10           !! tuned on random records: 5 holds without noise, not always with it
  real(dp), parameter :: unexplained = 10      !! times the noise: the residual hides a line
  real(dp), parameter :: unlikely = 1.0e-4_dp  !! that a line lies beside another by chance
  real(dp), parameter :: at_edge = 1.0e-3_dp   !! bins
  real(dp), parameter :: still = 1.0e-100_dp   !! of the midpoint's amplitude: a tip that moves less has no ratio; 1/c₁² overflows
  real(dp), parameter :: rounding = 32*epsilon(1.0_dp)
    !! of a position; the frequencies of modes, and so of a record that is their sum, have been seen 7 epsilon off

contains

  subroutine bound_errors(lines, others, density, residual, explained)
    !! Fill in the errors of a group's lines, and what hidden lines may add to them.
    type(line_type), intent(inout) :: lines(:)
    type(line_type), intent(in) :: others(:)   !! of the group, which count as a part of what is left
    real(dp), intent(in) :: density            !! lines per bin of the whole record
    type(residual_type), intent(in) :: residual
    logical, intent(out) :: explained          !! the lines leave no more than noise
    complex(dp), allocatable :: image(:, :)
    real(dp) :: left(size(lines)), noise(size(lines)), expected, free
    integer :: bins(2), i
    bins = band_of(group_type([lines, others], [integer ::]), residual%count)
    allocate (image(bins(1):bins(2), points), source=group_image(residual, others, bins))
    expected = group_noise(residual, lines, 0.0_dp)
    free = max(1.0_dp, numbers_in(bins)/correlated - sum(unknowns(lines)))
    left = norm2(abs(image))
    noise = max(left/sqrt(free), expected)
    explained = all(noise <= unexplained*expected)
    if (.not. explained) then
      do i = 1, size(lines)
        associate (own => own_bins(lines(i), bins))
          left(i) = norm2(abs(image(own(1):own(2), :)))
          noise(i) = max(left(i)/sqrt(free*numbers_in(own)/numbers_in(bins)), expected)
        end associate
      end do
    end if
    call settle(lines, residual%count)
    call line_errors(lines, residual%count, bins(1), bins(2) - bins(1) + 1, safety*noise)
    lines%hidden = sqrt(left/(line_strength(lines)*residual%count*main_lobe/2))
    lines%doubtful = .not. explained .or. 2*density*lines%hidden > unlikely
    lines%position_error = min(lines%position_error, real(residual%count, dp)) + rounding*line_position(lines)
    lines%ratio_error = min(lines%ratio_error, sqrt(huge(1.0_dp))) + 4*epsilon(1.0_dp)*abs(lines%ratio) &
      & + abs(aimag(lines%amplitude(2)*conjg(lines%amplitude(1))))/max(abs(lines%amplitude(1))**2, tiny(1.0_dp))
  end subroutine bound_errors

  pure function own_bins(line, bins) result(own)
    !! The first and last of the group's bins that are in the band of this line by itself too.
    type(line_type), intent(in) :: line
    integer, intent(in) :: bins(2)             !! of the group
    integer :: own(2)
    own = band_of(group_type([line], [integer ::]), 2*bins(2))
    own = max(bins(1), min(bins(2), own))
  end function own_bins

  elemental subroutine settle(line, count)
    !! A steady line that is at 0 or the Nyquist frequency but for rounding is put there: it has no phase, and the fit
    !! must not be asked for one.
    type(line_type), intent(inout) :: line
    integer, intent(in) :: count
    if (.not. line%steady .or. abs(line%offset) > at_edge) return
    if (line%bin /= 0 .and. 2*line%bin /= count) return
    line%offset = 0
    line%amplitude%im = 0
  end subroutine settle

  elemental real(dp) function line_strength(line)
    !! The largest amplitude of both histories together; it is never 0.
    type(line_type), intent(in) :: line
    line_strength = max(sqrt(abs(line%amplitude(1))**2 + abs(line%amplitude(2))**2), sqrt(tiny(1.0_dp)))
  end function line_strength

  subroutine line_errors(lines, count, first, bins, noise)
    !! Fill in the ratio of each line, and the errors of position, strength and ratio that noise makes. A ratio whose tip does not
    !! move but for rounding does not exist: it is 0 with a huge error.
    type(line_type), intent(inout) :: lines(:)
    integer, intent(in) :: count, first, bins
    real(dp), intent(in) :: noise(:)           !! standard deviation of a real number of the image beside each line, (line)
    real(dp), allocatable :: matrix(:, :), triangle(:, :), length(:), gradient(:)
    integer :: i, last
    allocate (matrix, source=jacobian(lines, count, first, bins))
    lines%position_error = huge(1.0_dp)
    lines%strength_error = huge(1.0_dp)
    lines%ratio_error = huge(1.0_dp)
    if (size(matrix, 1) < size(matrix, 2)) return
    allocate (triangle(size(matrix, 2), size(matrix, 2)), length(size(matrix, 2)), gradient(size(matrix, 2)))
    call factorise(matrix, triangle, length)
    last = 0
    do i = 1, size(lines)
      gradient = 0
      gradient(last + 2*points + 1) = 1
      lines(i)%position_error = noise_times(gradient_length(triangle, length, gradient), noise(i))
      gradient(last + 2*points + 1) = 0
      gradient(last + 1:last + 2*points) = direction(lines(i)%amplitude)
      lines(i)%strength_error = noise_times(gradient_length(triangle, length, gradient), noise(i))
      if (abs(lines(i)%amplitude(1)) > still*abs(lines(i)%amplitude(2))) then
        call ratio_of(lines(i)%amplitude, lines(i)%ratio, gradient(last + 1:last + 2*points))
        lines(i)%ratio_error = noise_times(gradient_length(triangle, length, gradient), noise(i))
      end if
      last = last + unknowns(lines(i))
    end do
  end subroutine line_errors

  pure function direction(amplitude) result(gradient)
    !! The slopes of the length of both amplitudes together with respect to their real and imaginary parts.
    complex(dp), intent(in) :: amplitude(:)
    real(dp) :: gradient(2*points)
    gradient = [amplitude(1)%re, amplitude(1)%im, amplitude(2)%re, amplitude(2)%im]
    gradient = gradient/max(norm2(gradient), tiny(1.0_dp))
  end function direction

  elemental real(dp) function noise_times(factor, noise)
    !! The product, or huge if the factor is.
    real(dp), intent(in) :: factor, noise
    noise_times = huge(1.0_dp)
    if (factor < sqrt(huge(1.0_dp))) noise_times = factor*noise
  end function noise_times

  pure subroutine ratio_of(amplitude, ratio, gradient)
    !! The ratio R = Re(c₂/c₁) of two amplitudes, and its slopes with respect to Re c₁, Im c₁, Re c₂, Im c₂.
    complex(dp), intent(in) :: amplitude(:)
    real(dp), intent(out) :: ratio, gradient(:)
    complex(dp) :: inverse, slope
    inverse = 1/amplitude(1)
    ratio = real(amplitude(2)*inverse, dp)
    slope = -amplitude(2)*inverse*inverse
    gradient = [slope%re, -slope%im, inverse%re, -inverse%im]
  end subroutine ratio_of

end module bw_line_bounds
