module bw_record_variables
  !! What a result holds of a record beside frequencies and waves: its rows, and behind them the procedures that give their
  !! values, which are named after them. What a procedure gives is said in its row.
  use bw_case_result, only: case_result
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_netcdf, only: variable_text
  use bw_record_lines, only: reason_words, status_words
  use bw_result_variable, only: case_variable, result_variable, unit_of_sensors, values_of_case
  use bw_text, only: joined
  implicit none (type, external)
  private
  public :: record_variables

contains

  pure function record_variables() result(rows)
    !! All of them.
    type(result_variable), allocatable :: rows(:)
    rows = [line_variables(), dispersion_variables(), window_variables(), candidate_variables(), sensor_variables()]
  end function record_variables

  pure function line_variables() result(rows)
    !! Of each line.
    type(result_variable) :: rows(13)
    rows = [ &
      of_record('measured_angular_frequency_bound', 'peak', 'rad s-1', 'Cramer-Rao standard deviation of the angular frequency', &
                frequency_bound), &
      of_record('measured_decay_rate', 'peak', 's-1', 'rate of decay; negative grows', decay), &
      of_record('measured_decay_rate_error', 'peak', 's-1', 'half the interval of the rate of decay', decay_error), &
      of_record('measured_decay_rate_bound', 'peak', 's-1', 'Cramer-Rao standard deviation of the rate of decay', decay_bound), &
      of_record('measured_drift', 'peak', 'rad s-1', &
        'change of the angular frequency over the record or three decay times', drift), &
      of_record('measured_drift_bound', 'peak', 'rad s-1', 'Cramer-Rao standard deviation of that change', drift_bound), &
      of_record('measured_amplitude', 'point peak', unit_of_sensors, 'amplitude at the first sample', amplitude), &
      of_record('measured_amplitude_error', 'point peak', unit_of_sensors, 'half the interval of the amplitude', amplitude_error), &
      of_record('measured_amplitude_bound', 'point peak', unit_of_sensors, 'Cramer-Rao standard deviation of the amplitude', &
                amplitude_bound), &
      of_record('measured_phase', 'point peak', 'rad', 'phase of the cosine at the first sample', phase), &
      of_record('measured_phase_error', 'point peak', 'rad', 'half the interval of the phase', phase_error), &
      of_record('measured_phase_bound', 'point peak', 'rad', 'Cramer-Rao standard deviation of the phase', phase_bound), &
      of_record('peak_status', 'peak', '1', 'what the line is', status)]
    rows(13)%is_integer = .true.
    rows(13)%has_masks = .true.
    rows(13)%flags = joined(status_words)
  end function line_variables

  pure function dispersion_variables() result(rows)
    !! Of all lines together.
    type(result_variable) :: rows(4)
    rows = [ &
      of_record('measured_stiffness_root', '', 'm2 s-1', 'sqrt(EI/(rho A)) from the dispersion of the lines', stiffness_root), &
      of_record('measured_stiffness_root_error', '', 'm2 s-1', 'half its interval', stiffness_root_error), &
      of_record('measured_angular_velocity', '', 'rad s-1', 'angular velocity from the dispersion of the lines', &
                angular_velocity), &
      of_record('measured_angular_velocity_error', '', 'rad s-1', 'half its interval', angular_velocity_error)]
    rows%needs = 'record waves'
  end function dispersion_variables

  pure function window_variables() result(rows)
    !! Of each line in each part of the record by itself.
    type(result_variable) :: rows(4)
    rows = [ &
      of_record('window_angular_frequency', 'peak window', 'rad s-1', 'angular frequency in a part of the record', window_1), &
      of_record('window_angular_frequency_bound', 'peak window', 'rad s-1', 'its Cramer-Rao standard deviation', window_3), &
      of_record('window_decay_rate', 'peak window', 's-1', 'rate of decay in a part of the record', window_2), &
      of_record('window_decay_rate_bound', 'peak window', 's-1', 'its Cramer-Rao standard deviation', window_4)]
  end function window_variables

  pure function candidate_variables() result(rows)
    !! Of what was looked at, and is no line.
    type(result_variable) :: rows(4)
    rows = [ &
      of_record('candidate_angular_frequency', 'candidate', 'rad s-1', 'where something was looked at that is no line', &
                candidate_frequency), &
      of_record('candidate_ordinate', 'candidate', '1', 'power over that of the noise there', candidate_ordinate), &
      of_record('candidate_reason', 'candidate', '1', 'why it is no line; 0: there is none', candidate_reason), &
      of_record('candidate_count', '', '1', 'number of candidates that are no lines', candidate_count)]
    rows(3:4)%is_integer = .true.
    rows(3)%flags = joined(reason_words)
    rows(3)%first_flag = 1
  end function candidate_variables

  pure function sensor_variables() result(rows)
    !! Of each sensor: noise, and what is drawn.
    type(result_variable) :: rows(4)
    rows = [ &
      of_record('noise_deviation', 'point', unit_of_sensors, 'standard deviation of what the lines leave', noise_deviation), &
      of_record('noise_level', 'point frequency', unit_of_sensors, &
                'root mean square of what noise adds to the amplitude spectrum', noise), &
      of_record('recorded', 'point time', unit_of_sensors, 'samples, or in turn the least and the largest of a stretch of time', &
                recorded), &
      of_record('fitted', 'point time', unit_of_sensors, 'the same of the lines, with an offset and a slope', fitted)]
  end function sensor_variables

  pure type(result_variable) function of_record(name, dimensions, units, long_name, values) result(row)
    !! A row that only results of records have.
    character(*), intent(in) :: name, dimensions, units, long_name
    procedure(values_of_case) :: values
    row = case_variable(variable_text(name, dimensions, units, long_name), values, needs='record')
  end function of_record

  pure subroutine frequency_bound(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%lines%angular_frequency_bound(:size(values))
  end subroutine frequency_bound

  pure subroutine decay(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%lines%decay_rate(:size(values))
  end subroutine decay

  pure subroutine decay_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%lines%decay_rate_error(:size(values))
  end subroutine decay_error

  pure subroutine decay_bound(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%lines%decay_rate_bound(:size(values))
  end subroutine decay_bound

  pure subroutine drift(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%lines%drift(:size(values))
  end subroutine drift

  pure subroutine drift_bound(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%lines%drift_bound(:size(values))
  end subroutine drift_bound

  pure subroutine amplitude(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_lines(abs(result%record%lines%amplitude), values)
  end subroutine amplitude

  pure subroutine amplitude_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_lines(result%record%lines%amplitude_error, values)
  end subroutine amplitude_error

  pure subroutine amplitude_bound(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_lines(result%record%lines%amplitude_bound, values)
  end subroutine amplitude_bound

  pure subroutine phase(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_lines(atan2(result%record%lines%amplitude%im, result%record%lines%amplitude%re), values)
  end subroutine phase

  pure subroutine phase_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_lines(result%record%lines%phase_error, values)
  end subroutine phase_error

  pure subroutine phase_bound(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_lines(result%record%lines%phase_bound, values)
  end subroutine phase_bound

  pure subroutine status(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%lines%status(:size(values))
  end subroutine status

  pure subroutine put_lines(matrix, values)
    !! Numbers of sensors and lines, the lines running fastest, with `missing` behind them.
    real(dp), intent(in) :: matrix(:, :)                  !! (sensors, lines)
    real(dp), intent(out), contiguous :: values(:)
    integer :: s, room
    room = size(values)/size(matrix, 1)
    values = missing
    do s = 1, size(matrix, 1)
      values((s - 1)*room + 1:(s - 1)*room + size(matrix, 2)) = matrix(s, :)
    end do
  end subroutine put_lines

  pure subroutine stiffness_root(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%stiffness_root(1)
  end subroutine stiffness_root

  pure subroutine stiffness_root_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%stiffness_root(2)
  end subroutine stiffness_root_error

  pure subroutine angular_velocity(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%angular_velocity(1)
  end subroutine angular_velocity

  pure subroutine angular_velocity_error(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%angular_velocity(2)
  end subroutine angular_velocity_error

  pure subroutine window_1(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_windows(result%record%lines%windows(1, :, :), values)
  end subroutine window_1

  pure subroutine window_2(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_windows(result%record%lines%windows(2, :, :), values)
  end subroutine window_2

  pure subroutine window_3(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_windows(result%record%lines%windows(3, :, :), values)
  end subroutine window_3

  pure subroutine window_4(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_windows(result%record%lines%windows(4, :, :), values)
  end subroutine window_4

  pure subroutine put_windows(matrix, values)
    !! Numbers of windows and lines, the windows running fastest, with `missing` behind them.
    real(dp), intent(in) :: matrix(:, :)                  !! (windows, lines)
    real(dp), intent(out), contiguous :: values(:)
    values = missing
    values(:size(matrix)) = reshape(matrix, [size(matrix)])
  end subroutine put_windows

  pure subroutine candidate_frequency(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_some(result%record%lines%rejected%angular_frequency, missing, values)
  end subroutine candidate_frequency

  pure subroutine candidate_ordinate(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_some(result%record%lines%rejected%ordinate, missing, values)
  end subroutine candidate_ordinate

  pure subroutine candidate_reason(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    call put_some(real(result%record%lines%rejected%reason, dp), 0.0_dp, values)
  end subroutine candidate_reason

  pure subroutine candidate_count(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = size(result%record%lines%rejected)
  end subroutine candidate_count

  pure subroutine put_some(list, fill, values)
    !! As many of a list as there is room for.
    real(dp), intent(in) :: list(:), fill
    real(dp), intent(out), contiguous :: values(:)
    integer :: n
    n = min(size(list), size(values))
    values(:n) = list(:n)
    values(n + 1:) = fill
  end subroutine put_some

  pure subroutine noise_deviation(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = result%record%lines%noise_deviation
  end subroutine noise_deviation

  pure subroutine noise(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = reshape(result%record%noise, [size(values)])
  end subroutine noise

  pure subroutine recorded(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = reshape(result%record%recorded, [size(values)])
  end subroutine recorded

  pure subroutine fitted(result, values)
    type(case_result), intent(in) :: result
    real(dp), intent(out), contiguous :: values(:)
    values = reshape(result%record%fitted, [size(values)])
  end subroutine fitted

end module bw_record_variables
