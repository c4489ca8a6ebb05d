module bw_line_windows
  !! Lines in halves and quarters of the longest interval after a blow: frequencies and decay rates from each window alone.
  use bw_band, only: add_to_band, band_around, fill_rows
  use bw_band_columns, only: band_type
  use bw_band_fit, only: fit_band, reduced_type
  use bw_constants, only: pi
  use bw_kinds, only: dp
  use bw_line, only: later, line_type, pole_at
  use bw_line_errors, only: amplitude_noise, line_errors, line_errors_of, pole_deviation
  use bw_model, only: model_type, rows_of_stretches, steps_between, white_lines
  use bw_penalty, only: line_penalty
  implicit none (type, external)
  private
  public :: windows_of

  integer, parameter :: most_steps = 6
  real(dp), parameter :: no_estimate(4) = [0.0_dp, 0.0_dp, huge(1.0_dp), huge(1.0_dp)] !! of a window that gives no estimate
  real(dp), parameter, public :: window_start(6) = [0.0_dp, 0.5_dp, 0.0_dp, 0.25_dp, 0.5_dp, 0.75_dp]
  real(dp), parameter, public :: window_end(6) = [0.5_dp, 1.0_dp, 0.25_dp, 0.5_dp, 0.75_dp, 1.0_dp]

contains

  function windows_of(model, lines, false_alarm) result(windows)
    !! Frequency [periods per step], decay [per step] and their bounds of overlapping lines, fitted together in each window,
    !! (4, windows, lines). If a window gives no estimate, its bounds are huge.
    type(model_type), intent(in) :: model
    type(line_type), intent(in) :: lines(:)
    real(dp), intent(in) :: false_alarm          !! probability that noise alone passes for a line in a window
    real(dp) :: windows(4, size(window_start), size(lines))
    integer :: rows(2, 0:ubound(model%stretches, 2)), own(2, 0:1), b, i, k, n
    type(line_type) :: of_white(size(lines))
    windows = spread(spread(no_estimate, 2, size(windows, 2)), 3, size(lines))
    rows = rows_of_stretches(model)
    b = maxloc(rows(2, 1:) - rows(1, 1:), dim=1)
    n = rows(2, b) - rows(1, b) + 1
    of_white = white_lines(model, lines)
    do k = 1, size(lines)
      of_white(k)%amplitude = of_white(k)%amplitude(:, [b, b + 1])
    end do
    do i = 1, size(window_start)
      own(:, 0) = [1, 0]
      own(:, 1) = rows(1, b) + [int(window_start(i)*n), int(window_end(i)*n) - 1]
      if (own(2, 1) - own(1, 1) < 6*size(lines) + 16) cycle
      windows(:, i, :) = in_window(own)
    end do

  contains

    function in_window(own) result(window)
      !! The estimates from one window, for the lines that are significant in it.
      integer, intent(in) :: own(:, 0:)
      real(dp) :: window(4, size(lines)), deviation(2)
      type(line_type) :: moved(size(lines))
      type(band_type) :: band
      type(reduced_type), allocatable :: reduced(:)
      type(line_errors) :: errors
      real(dp) :: since, least, gain
      integer :: j, p
      least = line_penalty(false_alarm, own(2, 1) - own(1, 1) + 1, 2*size(model%white, 2))
      since = steps_between(model, rows(1, b), own(1, 1)) - 1
      do j = 1, size(lines)
        moved(j)%pole = pole_at(of_white(j), since + (own(2, 1) - own(1, 1))/2)
        moved(j)%steady = lines(j)%steady
        allocate (moved(j)%courses(0))
      end do
      band = band_around(moved, own, model%noise, model%missing, model%place)
      call fill_rows(model%white, band)
      call add_to_band([(later(of_white(j), since), j=1, size(lines))], band)
      call fit_band(band, .false., most_steps, moved, reduced)
      errors = line_errors_of(moved, reduced)
      window = spread(no_estimate, 2, size(lines))
      do j = 1, size(lines)
        gain = sum([(sum((reduced(p)%linear_part(2*j - 1:2*j, :)/amplitude_noise(errors, p, j))**2), p=1, size(reduced))])
        if (.not. gain > least) cycle
        deviation = pole_deviation(errors, j, 0.0_dp)
        if (.not. all(deviation < huge(1.0_dp))) cycle
        window(:, j) = [moved(j)%pole%im/(2*pi), -moved(j)%pole%re, deviation(2)/(2*pi), deviation(1)]
      end do
    end function in_window

  end function windows_of

end module bw_line_windows
