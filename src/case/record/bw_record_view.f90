module bw_record_view
  !! Plotted data of a record on the axes of its result: histories and their fit over time, amplitudes and noise over frequency.
  use bw_amplitude_spectrum, only: window_at
  use bw_case_result, only: record_result
  use bw_found_lines, only: found_lines
  use bw_fourier, only: real_fourier
  use bw_hammer, only: hammer_type
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_order, only: quantile_of
  use bw_record, only: record_type
  use bw_record_flaws, only: find_spikes, mark_flaws
  use bw_record_lines, only: fitted_history, noise_level
  use bw_result_layout, only: record_layout, result_layout
  use bw_samples, only: gaps_of, gaps_type, place_of, samples_type, set_missing, span_of, validity
  use bw_uneven_fourier, only: uneven_transform
  implicit none (type, external)
  private
  public :: samples_of, step_of, take_values, view_fit, view_histories, view_response, view_spectra

contains

  pure real(dp) function step_of(record) result(step)
    !! Return the sampling interval [s]; for uneven samples the median.
    type(record_type), intent(in) :: record
    step = record%interval
    if (step > 0) return
    associate (times => record%times, n => size(record%times))
      step = quantile_of(times(2:) - times(:n - 1), 0.5_dp)
    end associate
  end function step_of

  pure function samples_of(record) result(samples)
    !! Return the times of a record for the search for lines, without values, and mark valid samples. Missing rows of an
    !! even record become invalid samples.
    type(record_type), intent(in) :: record
    type(samples_type) :: samples
    type(gaps_type), allocatable :: missing(:)
    logical :: sound(size(record%times))
    logical, allocatable :: valid(:)
    integer, allocatable :: row(:)
    integer :: s, n
    samples%count = size(record%times)
    samples%step = step_of(record)
    if (.not. record%interval > 0) call find_rows(record%times, record%resolution, samples)
    if (.not. allocated(record%values)) return
    if (any(record%sensors%left_out)) samples%left_out = record%sensors%left_out
    row = [(n, n=1, samples%count)]
    if (allocated(samples%row)) row = samples%row
    allocate (missing(size(record%values, 2)), valid(samples%count))
    do s = 1, size(missing)
      sound = .true.
      if (.not. record%sensors(s)%left_out) call mark_flaws(record%values(:, s), sound)
      valid = .false.
      valid(row) = sound .or. 2*count(sound) < size(sound)          ! so many are no flaws
      missing(s) = gaps_of(valid)
    end do
    call set_missing(missing, samples)
    if (.not. allocated(samples%missing) .and. allocated(samples%row)) deallocate (samples%row)
  end function samples_of

  pure subroutine find_rows(times, resolution, samples)
    !! Find the rows of samples on an even grid from which some are missing; else take their times as uneven.
    real(dp), intent(in) :: times(:), resolution     !! s
    type(samples_type), intent(inout) :: samples
    integer, parameter :: most_missing = 2           !! times the existing samples
    integer, parameter :: rounding = 4               !! of a computed time, in its spacing
    real(dp) :: step, off
    integer :: j, n, row(size(times))
    n = size(times)
    samples%place = times/samples%step
    if (samples%place(n) > most_missing*real(n, dp)) return
    row(1) = 1
    do j = 2, n
      row(j) = row(j - 1) + nint(samples%place(j) - samples%place(j - 1))
    end do
    step = times(n)/(row(n) - 1)
    off = min(0.25_dp*step, 2*(resolution + rounding*spacing(times(n))))   ! of two times, and of the step
    if (any(row(2:) <= row(:n - 1)) .or. any(abs(times - (row - 1)*step) > off)) return
    samples%row = row
    samples%step = step
    samples%count = samples%row(n)
    deallocate (samples%place)
  end subroutine find_rows

  subroutine take_values(record, samples)
    !! Move the values of a record into the samples that are searched.
    type(record_type), intent(inout) :: record
    type(samples_type), intent(inout) :: samples
    real(dp), allocatable :: values(:, :)
    logical, allocatable :: is_spike(:)
    integer :: n, s, last
    call move_alloc(record%values, values)
    do s = 1, size(values, 2)                        ! a spike, as a missing value, repeats the one before
      call find_spikes(values(:, s), is_spike)
      if (.not. allocated(is_spike)) cycle
      do n = 2, size(values, 1)
        if (is_spike(n)) values(n, s) = values(n - 1, s)
      end do
    end do
    if (.not. allocated(samples%row)) then
      call move_alloc(values, samples%value)
      return
    end if
    allocate (samples%value(samples%count, size(values, 2)))
    do n = 1, size(samples%row)                      ! a missing value repeats the one before
      last = samples%count
      if (n < size(samples%row)) last = samples%row(n + 1) - 1
      samples%value(samples%row(n):last, :) = spread(values(n, :), 1, last - samples%row(n) + 1)
    end do
  end subroutine take_values

  subroutine view_spectra(samples, layout, window, found, amplitude, noise)
    !! Find the amplitude spectrum of each sensor from the first impact on: the largest amplitude around each frequency
    !! of the result, and the rms amplitude of the noise. Where samples are invalid, the motion is that of the lines.
    type(samples_type), intent(in) :: samples        !! in which the lines were found
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: window               !! of `&spectrum`
    type(found_lines), intent(in) :: found
    real(dp), allocatable, intent(out) :: amplitude(:, :), noise(:, :)   !! (frequencies, sensors); unallocated if not plotted
    type(real_fourier) :: fourier
    complex(dp), allocatable :: spectrum(:)
    real(dp), allocatable :: own(:)
    real(dp) :: weight(samples%count), factor, mean
    integer :: length, s, j
    if (layout%frequencies == 0) return
    weight = weight_from_blow(samples, window, found)
    length = 2*ceiling(span_of(samples)/2)
    if (.not. allocated(samples%place)) length = samples%count
    allocate (amplitude(layout%frequencies, layout%points), noise(layout%frequencies, layout%points), source=missing)
    allocate (spectrum(0:length/2))
    do s = 1, layout%points
      associate (distinct => found%distinct)
        mean = distinct%constant(s)
        if (is_missing(mean)) cycle
        spectrum = 0
        if (distinct%place(s) > 0) then
          own = distinct%factor(s)*samples%value(:samples%count, distinct%place(s))
          if (allocated(samples%missing)) own = merge(own, fitted_history(samples, found, s), validity(samples, distinct%place(s)))
          mean = sum(own*weight)/sum(weight)
          own = (own - mean)*weight
          if (allocated(samples%place)) then
            call uneven_transform(samples%place, own, length, fourier, spectrum)
          else
            call fourier%prepare(length)
            fourier%samples = own
            call fourier%transform()
            spectrum = fourier%spectrum
          end if
        end if
      end associate
      own = 2*abs(spectrum)/sum(weight)
      factor = 2*norm2(weight)/sum(weight)
      own(1) = abs(mean)                             ! the mean of the record is all that is known there
      associate (frequency => layout%record%frequencies)
        amplitude(:, s) = on_axis(own, 1/(length*samples%step), frequency)
        do j = 1, layout%frequencies
          if (2*frequency(j)*samples%step <= 1) noise(j, s) = factor*noise_level(samples, found, frequency(j), s)
        end do
      end associate
    end do
  end subroutine view_spectra

  subroutine view_response(samples, layout, hammer, found, result)
    !! Find the transforms of sensors over that of the force, at the bins nearest to the frequencies of the result; 0 where the
    !! force has none. Where samples of a decay are invalid, the motion is that of its lines.
    type(samples_type), intent(in) :: samples        !! in which the lines were found
    type(result_layout), intent(in) :: layout
    type(hammer_type), intent(in) :: hammer
    type(found_lines), intent(in) :: found
    type(record_result), intent(inout) :: result     !! response and impulse are set
    type(real_fourier) :: fourier
    complex(dp) :: force(layout%frequencies), response(layout%frequencies)
    real(dp) :: own(samples%count)
    integer :: bin(layout%frequencies), s
    if (layout%frequencies == 0) return
    associate (n => samples%count, distinct => found%distinct)
      bin = min(n/2, nint(layout%record%frequencies*n*samples%step))
      call fourier%prepare(n)
      fourier%samples = hammer%force
      call fourier%transform()
      force = fourier%spectrum(bin)
      result%impulse = reshape(samples%step*abs(force), [size(force), 1])
      allocate (result%response_real(size(force), layout%points), source=missing)
      result%response_imag = result%response_real
      do s = 1, layout%points
        if (distinct%place(s) == 0 .or. any(hammer%unseen == s)) cycle
        own = fitted_history(samples, found, s)
        where (validity(samples, distinct%place(s)) .or. hammer%acts) &
          own = distinct%factor(s)*samples%value(:n, distinct%place(s))
        fourier%samples = own - sum(own)/n
        call fourier%transform()
        response = 0
        where (abs(force) > 0) response = fourier%spectrum(bin)/force
        result%response_real(:, s) = response%re
        result%response_imag(:, s) = response%im
      end do
    end associate
  end subroutine view_response

  pure function weight_from_blow(samples, window, found) result(weight)
    !! Return a window that rises soon after the first impact, to keep the start of decays, and falls to the end of the
    !! record. It is 0 before the impact.
    type(samples_type), intent(in) :: samples
    character(*), intent(in) :: window
    type(found_lines), intent(in) :: found
    real(dp) :: weight(samples%count), since(samples%count), rest
    real(dp), parameter :: rise = 1.0_dp/32          !! of the remaining record: a sudden start would hide weak lines
    integer :: first, n
    first = 1
    associate (stretches => found%model%stretches)
      if (ubound(stretches, 2) > 0) first = stretches(1, 1)
    end associate
    if (2*first > samples%count) first = 1           ! too few samples remain
    since = [(place_of(samples, n) - place_of(samples, first), n=1, samples%count)]
    rest = span_of(samples) - place_of(samples, first)
    weight = window_at(window, merge(since/rise, rest + (since - rise*rest)/(1 - rise), since < rise*rest)/2, rest)
    weight(:first - 1) = 0
  end function weight_from_blow

  pure function on_axis(own, spacing, axis) result(values)
    !! Return the largest ordinate nearest to each frequency of the axis, or the nearest one if there is none; `missing` beyond.
    real(dp), intent(in) :: own(0:)                  !! ordinates at multiples of `spacing`
    real(dp), intent(in) :: spacing                  !! Hz
    real(dp), intent(in) :: axis(:)                  !! evenly spaced from 0, Hz
    real(dp) :: values(size(axis)), cell
    integer :: j, first, last
    cell = axis(2)/spacing
    values = missing
    do j = 1, size(axis)
      first = max(0, ceiling((j - 1.5_dp)*cell))
      last = min(size(own) - 1, ceiling((j - 0.5_dp)*cell) - 1)
      if (first > size(own) - 1) exit
      if (last < first) last = min(size(own) - 1, nint((j - 1)*cell))
      values(j) = maxval(own(min(first, last):last))
    end do
  end function on_axis

  pure subroutine view_histories(times, samples, layout, shown)
    !! Return the samples at the times of the result; `missing` where they are left out.
    real(dp), intent(in) :: times(:)                 !! of the recorded samples, since the first [s]
    type(samples_type), intent(in) :: samples
    type(result_layout), intent(in) :: layout
    real(dp), allocatable, intent(out) :: shown(:, :)        !! (times, sensors)
    integer :: s
    if (layout%samples == 0) return
    allocate (shown(layout%samples, layout%points))
    do s = 1, layout%points
      associate (used => merge(samples%value(:samples%count, s), missing, validity(samples, s)))
        if (allocated(samples%row)) then
          shown(:, s) = at_times(times, used(samples%row), layout%record)
        else
          shown(:, s) = at_times(times, used, layout%record)
        end if
      end associate
    end do
  end subroutine view_histories

  subroutine view_fit(record, samples, layout, found, result)
    !! Find the history of the fitted lines at the same times.
    type(record_type), intent(in) :: record          !! without values
    type(samples_type), intent(in) :: samples        !! without values
    type(result_layout), intent(in) :: layout
    type(found_lines), intent(in) :: found
    type(record_result), intent(inout) :: result     !! `fitted` is set
    real(dp), allocatable :: history(:)
    integer :: s
    if (layout%samples == 0) return
    allocate (result%fitted(layout%samples, layout%points))
    do s = 1, layout%points
      history = fitted_history(samples, found, s)
      if (allocated(samples%row)) history = history(samples%row)
      result%fitted(:, s) = at_times(record%times, history, layout%record)
    end do
  end subroutine view_fit

  pure function at_times(times, history, axes) result(shown)
    !! Return a history at the times of the result: its samples, or the smallest and the largest of each interval in turn.
    real(dp), intent(in) :: times(:), history(:)     !! since the first sample [s]; (samples)
    type(record_layout), intent(in) :: axes
    real(dp) :: shown(size(axes%times))
    real(dp) :: stretch
    integer :: j, k
    shown = missing
    if (.not. axes%stretched) then
      shown(:size(history)) = history
      return
    end if
    stretch = 2*axes%times(2)
    do j = 1, size(history)
      if (is_missing(history(j))) cycle
      k = 2*min(int(times(j)/stretch + 0.25_dp), size(shown)/2 - 1) + 1
      if (is_missing(shown(k))) shown(k:k + 1) = history(j)
      shown(k) = min(shown(k), history(j))
      shown(k + 1) = max(shown(k + 1), history(j))
    end do
  end function at_times

end module bw_record_view
