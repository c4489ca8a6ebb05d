module bw_line_bounds
  !! How far fitted lines may be from the true ones.
  !!
  !! A bound is `safety` standard deviations of the fit, with the residual of the line's own bins as the noise (never less
  !! than rounding). It holds for a line that is alone. A line that lies d bins beside this one and is taken for a part of
  !! it moves it by up to d bins and leaves about d² of it in the residual, or d where its ratio is another: a residual that
  !! is the part ρ of the line may hide one that moves it by √ρ bins, and its ratio by the part √ρ. That is told apart.
  use bw_kinds, only: dp
  use bw_line, only: line_position, line_type, main_lobe
  use bw_line_errors, only: line_errors
  use bw_line_group, only: band_of, correlated, group_image, group_noise, group_type, numbers_in
  use bw_line_image, only: unknowns
  use bw_line_residual, only: residual_type
  implicit none (type, external)
  private
  public :: bound_errors, line_strength

  real(dp), parameter :: safety = 10           !! tuned on random records: 5 holds without noise, not always with it
  real(dp), parameter :: unexplained = 10      !! times the noise: the residual hides a line
  real(dp), parameter :: unlikely = 1.0e-4_dp  !! that a line lies beside another by chance
  real(dp), parameter :: at_edge = 1.0e-3_dp   !! bins
  real(dp), parameter :: rounding = 32*epsilon(1.0_dp)
    !! of a position; the frequencies of modes, and so of a record that is their sum, have been seen 7 epsilon off

contains

  subroutine bound_errors(lines, others, density, residual, explained)
    !! Fill the errors of a group's lines, and what hidden ones may add.
    type(line_type), intent(inout) :: lines(:)
    type(line_type), intent(in) :: others(:)   !! of the group, which count as a part of what is left
    real(dp), intent(in) :: density            !! lines per bin of the whole record
    type(residual_type), intent(in) :: residual
    logical, intent(out) :: explained          !! the lines leave no more than noise
    real(dp) :: left, noise, expected
    integer :: bins(2)
    bins = band_of(group_type([lines, others], [integer ::]), residual%count)
    left = norm2(abs(group_image(residual, others, bins)))
    expected = group_noise(residual, lines, 0.0_dp)
    noise = max(left/sqrt(max(1.0_dp, numbers_in(bins)/correlated - sum(unknowns(lines)))), expected)
    call settle(lines, residual%count)
    call line_errors(lines, residual%count, bins(1), bins(2) - bins(1) + 1, safety*noise)
    explained = noise <= unexplained*expected
    lines%hidden = sqrt(left/(line_strength(lines)*residual%count*main_lobe/2))
    lines%doubtful = .not. explained .or. 2*density*lines%hidden > unlikely
    lines%position_error = min(lines%position_error, real(residual%count, dp)) + rounding*line_position(lines)
    lines%ratio_error = min(lines%ratio_error, sqrt(huge(1.0_dp))) + 4*epsilon(1.0_dp)*abs(lines%ratio) &
      & + abs(aimag(lines%amplitude(2)*conjg(lines%amplitude(1))))/max(abs(lines%amplitude(1))**2, tiny(1.0_dp))
  end subroutine bound_errors

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
    !! Largest amplitude of both histories together, never 0.
    type(line_type), intent(in) :: line
    line_strength = max(sqrt(abs(line%amplitude(1))**2 + abs(line%amplitude(2))**2), sqrt(tiny(1.0_dp)))
  end function line_strength

end module bw_line_bounds
