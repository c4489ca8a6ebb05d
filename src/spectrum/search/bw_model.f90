module bw_model
  !! The model of a record during the search for lines: its stretches, lines, noise and residual. Lines are exchanged in the
  !! present noise; `bw_renewal` estimates it anew.
  use bw_autoregression, only: autoregression
  use bw_constants, only: pi
  use bw_fourier, only: real_fourier
  use bw_kinds, only: dp
  use bw_lapack, only: ddot, dgemm
  use bw_line, only: find_wave, life_of, line_type
  use bw_missing_samples, only: missing_among, project_out_missing
  use bw_noise, only: noise_type, white_amplitude
  use bw_samples, only: gaps_type, place_of, samples_type
  implicit none (type, external)
  private
  public :: add_lines, at_sensors, clear_missing, colour_at, find_misfit, find_residual, has_gaps, rows_of_stretches, &
    & steps_between, subtract_missing, white_lines

  real(dp), parameter :: negligible = 40         !! e-folds after which a line is negligible
  integer, parameter, public :: chunk = 2048     !! rows handled at once

  type, public :: renewal_type
    !! The input of the last noise estimate.
    type(line_type), allocatable :: lines(:)
    integer, allocatable :: stretches(:, :)      !! (2, 0:B)
    logical :: robust = .false.
    integer :: order = 0                         !! the highest one
    real(dp) :: penalty = 0                      !! per coefficient
  end type renewal_type

  type, public :: model_type
    integer, allocatable :: stretches(:, :)      !! first and last sample: before any blow, and after each, (2, 0:B)
    type(line_type), allocatable :: lines(:)
    real(dp), allocatable :: trend(:, :, :)      !! offset at a stretch's first sample and slope per step, (2, S, 0:B)
    type(noise_type) :: noise
    real(dp), allocatable :: place(:)            !! times of uneven samples, in steps, (N); their noise is white up to `level`
    real(dp), allocatable :: level(:, :)         !! of uneven samples: power of the noise over its mean, (bins, S)
    type(gaps_type), allocatable :: missing(:)   !! of each component, (S)
    real(dp), allocatable :: white(:, :)         !! prediction errors over their standard deviation; 0 where there is none, (N, S)
    real(dp), allocatable :: last_values(:, :, :)  !! the components' residual at the last samples of each stretch, (lost, S, 0:B)
    type(real_fourier) :: fourier
    type(renewal_type), allocatable :: last      !! the last renewal
    type(autoregression), allocatable :: start(:)  !! last noise estimate of each sensor, if samples are missing
  end type model_type

contains

  pure function rows_of_stretches(model) result(rows)
    !! First and last sample of each stretch that have a prediction error, (2, 0:B).
    type(model_type), intent(in) :: model
    integer :: rows(2, 0:ubound(model%stretches, 2))
    rows = model%stretches
    rows(2, :) = rows(2, :) - model%noise%lost
  end function rows_of_stretches

  pure function white_lines(model, lines) result(white)
    !! The lines with their amplitudes in the white components.
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: lines(:)
    type(line_type) :: white(size(lines))
    integer :: k
    white = lines
    do k = 1, size(lines)
      white(k)%amplitude = white_amplitude(model%noise, lines(k))
    end do
  end function white_lines

  pure real(dp) function steps_between(model, first, last)
    !! The length of a part of the record, in steps.
    type(model_type), intent(in) :: model
    integer, intent(in) :: first, last           !! samples
    steps_between = last - first + 1
    if (allocated(model%place) .and. last > first) steps_between = model%place(last) - model%place(first) + 1
  end function steps_between

  pure real(dp) function colour_at(model, frequency) result(colour)
    !! The noise's power near a frequency over that of its prediction: 1 except for uneven samples.
    type(model_type), intent(in) :: model
    real(dp), intent(in) :: frequency            !! rad per step
    colour = 1
    if (.not. allocated(model%level)) return
    associate (bins => size(model%level, 1))
      colour = maxval(model%level(max(1, min(bins, nint(frequency/pi*bins))), :))
    end associate
  end function colour_at

  pure subroutine add_lines(rows, lines, factor, values, place, fall)
    !! Add lines times a factor to the values of all sensors, in parts that fit a processor's cache.
    integer, intent(in) :: rows(:, 0:)           !! of the stretches
    type(line_type), intent(in) :: lines(:)
    real(dp), intent(in) :: factor
    real(dp), intent(inout), contiguous :: values(:, :)
    real(dp), intent(in), optional :: place(:)   !! times of uneven samples
    real(dp), intent(out), optional :: fall      !! by which the sum of the squares falls
    real(dp) :: waves(chunk, 2*size(lines)), amplitudes(2*size(lines), size(values, 2))
    integer :: b, k, m, n, first
    if (present(fall)) fall = 0
    do b = 0, ubound(rows, 2)
      do first = rows(1, b), rows(2, b), chunk
        n = min(chunk, rows(2, b) - first + 1)
        m = 0
        do k = 1, size(lines)
          if (.not. is_there(lines(k), b, first)) cycle
          call fill(lines(k), first - rows(1, b), first, waves(:n, m + 1:m + 2))
          amplitudes(m + 1, :) = factor*lines(k)%amplitude(:, b + 1)%re
          amplitudes(m + 2, :) = -factor*lines(k)%amplitude(:, b + 1)%im
          m = m + 2
        end do
        if (m == 0) cycle
        call add_part(size(values, 1), size(values, 2), first, n, waves, amplitudes, m, values, fall)
      end do
    end do

  contains

    pure logical function is_there(line, b, first)
      !! Whether a line is not yet negligible in a part of a stretch.
      type(line_type), intent(in) :: line
      integer, intent(in) :: b, first
      is_there = b > 0 .or. line%steady
      if (is_there .and. .not. present(place)) &
        & is_there = first - rows(1, b) < life_of(line, negligible, real(rows(2, b) - rows(1, b) + 1, dp))
    end function is_there

    pure subroutine fill(line, from, first, wave)
      !! Real and imaginary part of a line of amplitude 1.
      type(line_type), intent(in) :: line
      integer, intent(in) :: from, first
      real(dp), intent(out) :: wave(:, :)
      complex(dp) :: own(size(wave, 1))
      if (present(place)) then
        call find_wave(line, place(first - from), place(first:first + size(own) - 1), own)
      else
        call find_wave(line, real(from, dp), wave=own)
      end if
      wave(:, 1) = own%re
      wave(:, 2) = own%im
    end subroutine fill

  end subroutine add_lines

  pure subroutine add_part(count, sensors, first, rows, waves, amplitudes, used, values, fall)
    !! Add the first `used` waves, times their amplitudes, to `rows` rows of values.
    integer, intent(in) :: count, sensors, first, rows, used
    real(dp), intent(in) :: waves(:, :), amplitudes(:, :)
    real(dp), intent(inout) :: values(count, sensors)
    real(dp), intent(inout), optional :: fall    !! of the squares
    if (present(fall)) fall = fall + squares()
    call dgemm('N', 'N', rows, sensors, used, 1.0_dp, waves, size(waves, 1), amplitudes, size(amplitudes, 1), 1.0_dp, &
      & values(first, 1), count)
    if (present(fall)) fall = fall - squares()

  contains

    pure real(dp) function squares()
      integer :: s
      squares = sum([(ddot(rows, values(first, s), 1, values(first, s), 1), s=1, sensors)])
    end function squares

  end subroutine add_part

  pure function at_sensors(lines, sensors) result(chosen)
    !! The lines with their amplitudes at some sensors only.
    type(line_type), intent(in) :: lines(:)
    integer, intent(in) :: sensors(:)
    type(line_type) :: chosen(size(lines))
    integer :: k
    chosen = lines
    do k = 1, size(lines)
      chosen(k)%amplitude = lines(k)%amplitude(sensors, :)
    end do
  end function at_sensors

  pure subroutine find_residual(samples, model, sensors, residual)
    !! Find the residual of some sensors, offset and slope included; 0 at invalid samples.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, intent(in) :: sensors(:)
    real(dp), intent(out), contiguous :: residual(:, :)
    integer :: s
    do s = 1, size(residual, 2)
      residual(:, s) = samples%value(:samples%count, sensors(s))
    end do
    call add_lines(model%stretches, at_sensors(model%lines, sensors), -1.0_dp, residual, model%place)
    if (allocated(samples%missing)) call clear_missing(samples%missing(sensors), residual)
  end subroutine find_residual

  pure subroutine find_misfit(samples, model, sensors, residual)
    !! Find the residual of the samples after lines, offset and slope of each stretch; undefined at invalid samples.
    type(samples_type), intent(in) :: samples
    type(model_type), intent(in) :: model
    integer, intent(in) :: sensors(:)
    real(dp), intent(out), contiguous :: residual(:, :)
    integer :: s, b, n
    call find_residual(samples, model, sensors, residual)
    do s = 1, size(residual, 2)
      do b = 0, ubound(model%stretches, 2)
        associate (first => model%stretches(1, b), trend => model%trend(:, sensors(s), b))
          do n = first, model%stretches(2, b)
            residual(n, s) = residual(n, s) - trend(1) - trend(2)*(place_of(samples, n) - place_of(samples, first))
          end do
        end associate
      end do
    end do
  end subroutine find_misfit

  pure subroutine clear_missing(missing, values)
    !! Set missing samples to 0.
    type(gaps_type), intent(in) :: missing(:)    !! (columns)
    real(dp), intent(inout) :: values(:, :)
    integer :: s
    do s = 1, size(values, 2)
      values(missing(s)%place, s) = 0
    end do
  end subroutine clear_missing

  pure logical function has_gaps(model)
    !! Whether any samples are missing.
    type(model_type), intent(in) :: model
    integer :: s
    has_gaps = any([(size(model%missing(s)%place) > 0, s=1, size(model%missing))])
  end function has_gaps

  pure subroutine subtract_missing(model)
    !! Subtract from the white rows the part that missing samples explain.
    type(model_type), intent(inout) :: model
    integer :: rows(2, 0:ubound(model%stretches, 2)), b, s
    rows = rows_of_stretches(model)
    do s = 1, size(model%white, 2)
      if (size(model%missing(s)%place) == 0) cycle
      do b = 0, ubound(rows, 2)
        call project_out_missing(missing_among(model%missing(s)%place, rows(1, b), rows(2, b) - rows(1, b) + 1, &
          & model%noise%filter(:model%noise%order(s), s)), model%white(rows(1, b):rows(2, b), s))
      end do
    end do
  end subroutine subtract_missing

end module bw_model
