module bw_joined_lines
  !! Lines that are simpler than they were taken for: a drift of fewer powers of time, or one line where a peak has several, does as
  !! well but for noise.
  use bw_band_fit, only: fit_band, fit_type
  use bw_damped_line, only: damped_line
  use bw_kinds, only: dp
  use bw_line_bands, only: line_band, own_rows, weight_of
  use bw_noise_level, only: level_knots
  use bw_samples, only: samples_type, span_of
  use bw_shape_price, only: least_gain, price_of_drift
  implicit none (type, external)
  private
  public :: join_lines

  real(dp), parameter :: one_peak = 3           !! bins between lines that may be one

contains

  subroutine join_lines(samples, false_alarm, noise, bands, lines, still, changed, needless, missed)
    !! Leave a line out of each peak that has several, where the others, fitted again, do as well but for noise.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(level_knots), intent(in) :: noise
    type(line_band), intent(in) :: bands(:)
    type(damped_line), allocatable, intent(inout) :: lines(:)
    real(dp), intent(in) :: still(:, :)
    logical, intent(out) :: changed
    type(damped_line), allocatable, intent(out) :: needless(:)  !! the lines that have been left out
    real(dp), allocatable, intent(out) :: missed(:)  !! what they took off half the squares over the noise
    logical :: stays(size(lines)), straightened
    real(dp) :: gain(size(lines))
    integer :: i
    stays = .true.
    straightened = .false.
    gain = 0
    do i = 1, size(bands)
      if (size(bands(i)%member) > 0) call straighten(bands(i))
      if (size(bands(i)%member) > 1) call join_band(bands(i), least_gain(size(samples%value, 2), false_alarm/size(lines)))
    end do
    changed = straightened .or. .not. all(stays)
    needless = pack(lines, .not. stays)
    missed = pack(gain, .not. stays)
    if (.not. all(stays)) lines = pack(lines, stays)

  contains

    subroutine straighten(band)
      !! Take powers of time out of the exponents of lines that do not need them.
      type(line_band), intent(in) :: band
      type(fit_type) :: fit
      real(dp), allocatable :: rows(:, :), weight(:)
      type(damped_line), allocatable :: own(:)
      real(dp) :: left, chance
      integer :: j, powers
      own = lines(band%member)
      if (all(own%powers == 1)) return
      rows = own_rows(samples, lines, still, band)
      weight = weight_of(noise, band, size(samples%value, 2))
      chance = false_alarm/size(lines)
      fit%lines = own
      call fit_band(samples, band%band, rows, weight, band%with_still, fit)
      left = fit%left
      do j = 1, size(own)
        do powers = 1, own(j)%powers - 1
          fit%lines = own
          fit%lines(j)%powers = powers
          fit%lines(j)%bend(powers + 1:) = 0
          call fit_band(samples, band%band, rows, weight, band%with_still, fit)
          if (fit%left > left + price_of_drift(own(j)%powers, chance) - price_of_drift(powers, chance)) cycle
          lines(band%member) = fit%lines
          straightened = .true.
          return
        end do
      end do
    end subroutine straighten

    subroutine join_band(band, least)
      !! Leave out the line that is missed least.
      type(line_band), intent(in) :: band
      real(dp), intent(in) :: least
      type(fit_type) :: fit
      real(dp), allocatable :: rows(:, :), weight(:)
      type(damped_line), allocatable :: own(:), best(:)
      real(dp) :: left, least_left
      integer :: j, chosen
      own = lines(band%member)
      rows = own_rows(samples, lines, still, band)
      weight = weight_of(noise, band, size(samples%value, 2))
      fit%lines = own
      call fit_band(samples, band%band, rows, weight, band%with_still, fit)
      left = fit%left
      least_left = left + least
      chosen = 0
      do j = 1, size(own)
        if (count(abs(own%frequency - own(j)%frequency)*span_of(samples) < one_peak) < 2) cycle
        fit%lines = [own(:j - 1), own(j + 1:)]
        call fit_band(samples, band%band, rows, weight, band%with_still, fit)
        if (fit%left >= least_left) cycle
        least_left = fit%left
        chosen = j
        best = fit%lines
      end do
      if (chosen == 0) return
      stays(band%member(chosen)) = .false.
      gain(band%member(chosen)) = (least_left - left)/2
      lines(band%member(:chosen - 1)) = best(:chosen - 1)
      lines(band%member(chosen + 1:)) = best(chosen:)
    end subroutine join_band

  end subroutine join_lines

end module bw_joined_lines
