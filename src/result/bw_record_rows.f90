module bw_record_rows
  !! The variables of a record beside frequencies and waves: a row for each, with values in SI.
  use bw_case_result, only: record_result
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing
  use bw_record_lines, only: reason_words, status_words
  use bw_result_table, only: result_table, unit_of_sensors
  implicit none (type, external)
  private
  public :: record_rows

  character(*), parameter :: deviation_of = 'Cramer-Rao standard deviation of ', half_of = 'half the interval of the '

contains

  subroutine record_rows(table, record)
    !! Walk through all rows of a record.
    class(result_table), intent(inout) :: table
    type(record_result), intent(in), optional :: record      !! absent while rows are defined
    call line_rows(table, record)
    call noise_rows(table, record)
    call dispersion_rows(table, record)
    call candidate_rows(table, record)
    call sensor_rows(table, record)
    call hammer_rows(table, record)
  end subroutine record_rows

  subroutine line_rows(table, record)
    !! Put each line: its decay, drift, amplitudes at sensors, and values in parts of the record.
    class(result_table), intent(inout) :: table
    type(record_result), intent(in), optional :: record
    if (row('angular_frequency_bound', 'peak', 'rad s-1', deviation_of//'the angular frequency')) &
      call table%put(record%lines%angular_frequency_bound)
    if (row('decay_rate', 'peak', 's-1', 'rate of decay; negative grows')) call table%put(record%lines%decay_rate)
    if (row('decay_rate_error', 'peak', 's-1', half_of//'rate of decay')) call table%put(record%lines%decay_rate_error)
    if (row('decay_rate_bound', 'peak', 's-1', deviation_of//'the rate of decay')) call table%put(record%lines%decay_rate_bound)
    if (row('drift', 'peak', 'rad s-1', 'change of the angular frequency over the record or three decay times')) &
      call table%put(record%lines%drift)
    if (row('drift_bound', 'peak', 'rad s-1', deviation_of//'that change')) call table%put(record%lines%drift_bound)
    if (row('amplitude', 'point peak', unit_of_sensors, 'amplitude at the first sample')) &
      call table%put_columns(along_lines(known(abs(record%lines%amplitude))))
    if (row('amplitude_error', 'point peak', unit_of_sensors, half_of//'amplitude')) &
      call table%put_columns(along_lines(record%lines%amplitude_error))
    if (row('amplitude_bound', 'point peak', unit_of_sensors, deviation_of//'the amplitude')) &
      call table%put_columns(along_lines(record%lines%amplitude_bound))
    if (row('phase', 'point peak', 'rad', 'phase of the cosine at the first sample')) &
      call table%put_columns(along_lines(known(atan2(record%lines%amplitude%im, record%lines%amplitude%re))))
    if (row('phase_error', 'point peak', 'rad', half_of//'phase')) call table%put_columns(along_lines(record%lines%phase_error))
    if (row('phase_bound', 'point peak', 'rad', deviation_of//'the phase')) &
      call table%put_columns(along_lines(record%lines%phase_bound))
    if (table%whole_row('peak_status', 'peak', 'what the line is', status_words, has_masks=.true.)) &
      call table%put(record%lines%status)
    if (part('angular_frequency', 'rad s-1', 'angular frequency in a part of the record')) &
      call table%put_columns(record%lines%windows(1, :, :))
    if (part('angular_frequency_bound', 'rad s-1', 'its Cramer-Rao standard deviation')) &
      call table%put_columns(record%lines%windows(3, :, :))
    if (part('decay_rate', 's-1', 'rate of decay in a part of the record')) call table%put_columns(record%lines%windows(2, :, :))
    if (part('decay_rate_bound', 's-1', 'its Cramer-Rao standard deviation')) call table%put_columns(record%lines%windows(4, :, :))
  contains
    pure function known(numbers)
      !! Return numbers of sensors and lines, `missing` at sensors that were left out.
      real(dp), intent(in) :: numbers(:, :)
      real(dp) :: known(size(numbers, 1), size(numbers, 2))
      known = merge(missing, numbers, spread(is_missing(record%lines%noise_deviation), 2, size(numbers, 2)))
    end function known
    logical function row(name, dimensions, units, long_name)
      character(*), intent(in) :: name, dimensions, units, long_name
      row = table%real_row('measured_'//name, dimensions, units, long_name)
    end function row
    logical function part(name, units, long_name)
      character(*), intent(in) :: name, units, long_name
      part = table%real_row('window_'//name, 'peak window', units, long_name)
    end function part
  end subroutine line_rows

  subroutine noise_rows(table, record)
    !! Put the noise of amplitudes, and its correlation between sensors, for waves along a beam identified from all cases.
    class(result_table), intent(inout) :: table
    type(record_result), intent(in), optional :: record
    character(*), parameter :: needs = 'waves unknown', of_parts = ' of the real part of the amplitude, or the imaginary one'
    if (table%real_row('measured_amplitude_noise', 'point peak', unit_of_sensors, 'standard deviation'//of_parts// &
                       ', at known frequency and decay; none of a sensor that is constant or a multiple of another', &
                       needs=needs)) call table%put_columns(along_lines(noise_of_own()))
    if (row('real', 'correlation of that noise at two sensors, real part')) call table%put_columns(correlations(.false.))
    if (row('imag', 'its imaginary part')) call table%put_columns(correlations(.true.))
  contains
    logical function row(part, long_name)
      character(*), intent(in) :: part, long_name
      row = table%real_row('measured_noise_correlation_'//part, 'point point_too peak', '1', long_name, needs=needs)
    end function row
    pure function noise_of_own() result(noise)
      real(dp), allocatable :: noise(:, :)
      integer :: s
      noise = record%lines%amplitude_noise
      do s = 1, size(noise, 1)
        if (.not. record%lines%own(s)) noise(s, :) = missing
      end do
    end function noise_of_own
    pure function correlations(imaginary) result(columns)
      !! Return correlations, (lines, pairs of sensors); none if sensors share no noise.
      logical, intent(in) :: imaginary
      real(dp), allocatable :: columns(:, :)
      integer :: i, j, n
      n = 0
      if (allocated(record%lines%noise_correlation)) n = size(record%lines%own)
      allocate (columns(size(record%lines%decay_rate), n**2))
      do i = 1, n
        do j = 1, n
          if (imaginary) columns(:, (i - 1)*n + j) = record%lines%noise_correlation(i, j, :)%im
          if (.not. imaginary) columns(:, (i - 1)*n + j) = record%lines%noise_correlation(i, j, :)%re
        end do
      end do
    end function correlations
  end subroutine noise_rows

  pure function along_lines(numbers) result(columns)
    !! Return numbers of sensors and lines as columns along the lines. (gfortran 12 misorders the elements of
    !! `transpose(abs(z))`.)
    real(dp), intent(in) :: numbers(:, :)            !! (sensors, lines)
    real(dp) :: columns(size(numbers, 2), size(numbers, 1))
    columns = transpose(numbers)
  end function along_lines

  subroutine dispersion_rows(table, record)
    !! Put properties of the beam from all lines together.
    class(result_table), intent(inout) :: table
    type(record_result), intent(in), optional :: record
    if (row('stiffness_root', 'm2 s-1', 'sqrt(EI/(rho A)) from the dispersion of the lines')) &
      call table%put([record%stiffness_root(1)])
    if (row('stiffness_root_error', 'm2 s-1', 'half its interval')) call table%put([record%stiffness_root(2)])
    if (row('angular_velocity', 'rad s-1', 'angular velocity from the dispersion of the lines')) &
      call table%put([record%angular_velocity(1)])
    if (row('angular_velocity_error', 'rad s-1', 'half its interval')) call table%put([record%angular_velocity(2)])
  contains
    logical function row(name, units, long_name)
      character(*), intent(in) :: name, units, long_name
      row = table%real_row('measured_'//name, '', units, long_name, needs='waves')
    end function row
  end subroutine dispersion_rows

  subroutine candidate_rows(table, record)
    !! Put rejected candidates of lines.
    class(result_table), intent(inout) :: table
    type(record_result), intent(in), optional :: record
    if (table%real_row('candidate_angular_frequency', 'candidate', 'rad s-1', &
                       'where something was looked at that is no line')) &
      call table%put(record%lines%rejected%angular_frequency)
    if (table%real_row('candidate_ordinate', 'candidate', '1', 'power over that of the noise there')) &
      call table%put(record%lines%rejected%ordinate)
    if (table%whole_row('candidate_reason', 'candidate', 'why it is no line; 0: there is none', reason_words, 1)) &
      call table%put(record%lines%rejected%reason)
    if (table%whole_row('candidate_count', '', 'number of candidates that are no lines')) &
      call table%put([size(record%lines%rejected)])
  end subroutine candidate_rows

  subroutine sensor_rows(table, record)
    !! Put each sensor: its noise, and curves for plots.
    class(result_table), intent(inout) :: table
    type(record_result), intent(in), optional :: record
    if (row('noise_deviation', 'point', 'standard deviation of what the lines leave')) &
      call table%put(record%lines%noise_deviation)
    if (table%real_row('measured_blow_time', '', 's', 'time of the first blow since the first sample')) &
      call table%put(record%lines%blow(:min(1, size(record%lines%blow))))
    if (row('noise_level', 'point frequency', 'root mean square of what noise adds to the amplitude spectrum')) &
      call table%put_columns(record%noise)
    if (row('recorded', 'point time', 'samples, or in turn the least and the largest of a stretch of time')) &
      call table%put_columns(record%recorded)
    if (row('fitted', 'point time', 'the same of the lines, with an offset and a slope')) call table%put_columns(record%fitted)
  contains
    logical function row(name, dimensions, long_name)
      character(*), intent(in) :: name, dimensions, long_name
      row = table%real_row(name, dimensions, unit_of_sensors, long_name)
    end function row
  end subroutine sensor_rows

  subroutine hammer_rows(table, record)
    !! Put a hammer's blow: modal constants, and the frequency response of this record alone.
    class(result_table), intent(inout) :: table
    type(record_result), intent(in), optional :: record
    if (row('measured_modal_constant_real', 'point peak', 'kg-1', 'real part of phi phi/M of sensor and hammer')) &
      call table%put_columns(record%constant_real)
    if (row('measured_modal_constant_imag', 'point peak', 'kg-1', 'its imaginary part')) &
      call table%put_columns(record%constant_imag)
    if (row('measured_modal_constant_error', 'point peak', 'kg-1', half_of//'real and of the imaginary part')) &
      call table%put_columns(record%constant_error)
    if (row('frequency_response_real', 'point frequency', unit_of_sensors//' N-1', 'real part of the response over the force')) &
      call table%put_columns(record%response_real)
    if (row('frequency_response_imag', 'point frequency', unit_of_sensors//' N-1', 'its imaginary part')) &
      call table%put_columns(record%response_imag)
    if (row('force_spectrum', 'frequency', 'N s', 'size of the transform of the force')) call table%put_columns(record%impulse)
  contains
    logical function row(name, dimensions, units, long_name)
      character(*), intent(in) :: name, dimensions, units, long_name
      row = table%real_row(name, dimensions, units, long_name, needs='hammer')
    end function row
  end subroutine hammer_rows

end module bw_record_rows
