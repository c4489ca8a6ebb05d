module bw_line_names
  !! A line with its errors, and its status: drifting, one of a close pair, a harmonic, at an edge.
  use bw_kinds, only: dp
  use bw_samples, only: samples_type, span_of
  implicit none (type, external)
  private
  public :: name_lines

  real(dp), parameter :: beside = 1            !! bins within which lines are a close pair, or at an edge
  integer, parameter :: most_times = 6         !! largest order of a harmonic
  integer, parameter, public :: close_pair = 1, harmonic = 2, drifting = 4, at_edge = 8
    !! bits of a status; 0: none of these

  type, public :: estimated_line
    !! A line with its errors; frequencies are in periods per step, decay rates in e-folds per step.
    real(dp) :: frequency = 0, frequency_bound = 0, frequency_error = 0
    real(dp) :: decay = 0, decay_bound = 0, decay_error = 0
    complex(dp), allocatable :: amplitude(:)   !! at the record's first sample, (S)
    real(dp), allocatable :: amplitude_bound(:), phase_bound(:)  !! (S)
    real(dp), allocatable :: amplitude_noise(:)
      !! standard deviation of the amplitude's real part, and of its imaginary part, at known decay and frequency, (S)
    complex(dp), allocatable :: noise_correlation(:, :)
      !! correlations of these parts between sensors, (S, S); allocated if the sensors share noise
    integer :: status = 0
    real(dp) :: drift = 0, drift_bound = 0     !! change of frequency over the line's life, and its bound
    real(dp) :: windows(4, 6) = 0              !! frequency, decay and their bounds in each half and quarter
  end type estimated_line

contains

  pure subroutine name_lines(samples, false_alarm, estimated)
    !! Mark close pairs, harmonics and lines at an edge. A line is within w of the place of a harmonic by chance with the
    !! probability 2w over its frequency. A harmonic is named only if chance yields so close an agreement anywhere in the record
    !! with at most the probability `false_alarm`.
    type(samples_type), intent(in) :: samples
    real(dp), intent(in) :: false_alarm
    type(estimated_line), intent(inout) :: estimated(:)
    real(dp) :: strength(size(estimated)), away
    real(dp) :: places                           ! multiples, sums and differences of the lines that are stronger than each
    integer :: i, j, k, m
    places = sum([(real(k, dp)*(k + most_times - 2), k=0, size(estimated) - 1)])
    do i = 1, size(estimated)
      strength(i) = norm2(abs(estimated(i)%amplitude))
    end do
    do k = 1, size(estimated)
      associate (line => estimated(k))
        if (count(abs(estimated%frequency - line%frequency)*span_of(samples) < beside) > 1) &
          & line%status = ior(line%status, close_pair)
        away = line%frequency
        if (.not. allocated(samples%place)) away = min(away, 0.5_dp - line%frequency)
        if (away*span_of(samples) < beside) line%status = ior(line%status, at_edge)
        do i = 1, size(estimated)
          if (.not. strength(i) > strength(k)) cycle
          do m = 2, most_times
            if (is_at(line, m*estimated(i)%frequency, m*estimated(i)%frequency_error)) line%status = ior(line%status, harmonic)
          end do
          do j = 1, i - 1
            if (.not. strength(j) > strength(k)) cycle
            do m = -1, 1, 2
              if (is_at(line, estimated(i)%frequency + m*estimated(j)%frequency, &
                & hypot(estimated(i)%frequency_error, estimated(j)%frequency_error))) line%status = ior(line%status, harmonic)
            end do
          end do
        end do
      end associate
    end do

  contains

    pure logical function is_at(line, frequency, error)
      !! Whether a line is at a frequency, or at its alias, within both errors, and not by chance.
      type(estimated_line), intent(in) :: line
      real(dp), intent(in) :: frequency, error
      real(dp) :: aliased, within
      aliased = abs(frequency)
      if (.not. allocated(samples%place)) aliased = abs(aliased - anint(aliased))
      within = hypot(line%frequency_error, error)
      is_at = abs(line%frequency - aliased) <= within .and. 2*within*places <= false_alarm*line%frequency
    end function is_at

  end subroutine name_lines

end module bw_line_names
