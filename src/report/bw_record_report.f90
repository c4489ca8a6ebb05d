module bw_record_report
  !! The printed report of a record: lines with intervals, rejected candidates with reasons, and the noise.
  use bw_case_result, only: record_result
  use bw_columns, only: fixed, most_rows, note_rest, pair_cells, short, table_of, text_table, to_its_error
  use bw_constants, only: two_pi
  use bw_kinds, only: dp
  use bw_measured, only: measured_type
  use bw_missing, only: is_missing, scaled
  use bw_record, only: unit_in, without_unit
  use bw_record_lines, only: reason_texts, status_words
  use bw_record_summary, only: record_summary
  use bw_sensor_unit, only: is_unit
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: report_record, report_waves, short_name

  integer, parameter :: shown_candidates = 10, shown_sensors = 16

contains

  subroutine report_record(record, measured, confidence, lines)
    !! Print the whole report.
    type(record_result), intent(in) :: record
    type(measured_type), intent(in) :: measured      !! waves
    real(dp), intent(in) :: confidence               !! of the intervals
    type(text_builder), intent(inout) :: lines
    call lines%append(record_summary(record%extent))
    if (size(record%lines%angular_frequency) > 0) call report_lines(record, confidence, lines)
    if (allocated(record%constant_real)) call report_constants(record, lines)
    if (allocated(measured%wavenumber)) call report_waves(record, measured, lines)
    if (size(record%lines%rejected) > 0) call report_rejected(record, lines)
    call report_noise(record, lines)
  end subroutine report_record

  subroutine report_lines(record, confidence, lines)
    !! Print a row for each line, with the amplitude of the best signal-to-noise ratio.
    type(record_result), intent(in) :: record
    real(dp), intent(in) :: confidence
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    integer :: k
    call lines%append_line('')
    call lines%append_line('  Lines; +/- is half the interval of '//shortest(100*confidence, 6)//' %, bound the Cramer-Rao '// &
                           'bound in this noise (one standard deviation)')
    if (size(record%extent%sensors) > 1) call lines%append_line('  Amplitudes are those of the sensor with the best '// &
                                                              'signal-to-noise ratio')
    table = table_of('line|frequency|+/-|bound|decay rate|+/-|bound|damping|amplitude|+/-|what', &
                     '|Hz|Hz|Hz|1/s|1/s|1/s|%|||', [6, 14, 11, 11, 13, 11, 11, 11, 12, 11, 0])
    call table%put_head(lines)
    do k = 1, min(most_rows, size(record%lines%angular_frequency))
      call report_line(record, k, table, lines)
    end do
    call note_rest(lines, size(record%lines%angular_frequency), most_rows)
    if (any([(drift_text(record, k) /= '', k=1, size(record%lines%status))])) &
      & call lines%append_line('  Drift: change of the frequency over the record, or over three decay times if these are shorter')
  end subroutine report_lines

  subroutine report_line(record, k, table, lines)
    !! Print the row of line k.
    type(record_result), intent(in) :: record
    integer, intent(in) :: k
    type(text_table), intent(in) :: table
    type(text_builder), intent(inout) :: lines
    integer :: s
    associate (found => record%lines)
      s = maxloc(abs(found%amplitude(:, k))/max(found%noise_deviation, tiny(1.0_dp)), dim=1)
      call table%put_row(lines, text_of(k)//'|'//to_its_error(found%angular_frequency(k)/two_pi, &
        scaled(found%angular_frequency_error(k), 1/two_pi))//'|'//short(scaled(found%angular_frequency_error(k), 1/two_pi))//'|'// &
        short(scaled(found%angular_frequency_bound(k), 1/two_pi))//'|'//to_its_error(found%decay_rate(k), &
        found%decay_rate_error(k))//'|'//short(found%decay_rate_error(k))//'|'//short(found%decay_rate_bound(k))//'|'// &
        shortest(100*found%decay_rate(k)/hypot(found%decay_rate(k), found%angular_frequency(k)), 3)//'|'// &
        shortest(abs(found%amplitude(s, k)), 4)//'|'//short(found%amplitude_error(s, k)), &
        '   '//place_text(record, s)//kinds_text(found%status(k))//drift_text(record, k))
    end associate
  end subroutine report_line

  pure function short_name(name) result(text)
    !! Return a sensor's name without its unit.
    character(*), intent(in) :: name
    character(:), allocatable :: text
    text = name
    if (is_unit(unit_in(name))) text = without_unit(name)
  end function short_name

  function place_text(record, s) result(text)
    !! Return the sensor and its unit.
    type(record_result), intent(in) :: record
    integer, intent(in) :: s
    character(:), allocatable :: text
    associate (sensor => record%extent%sensors(s))
      text = sensor%unit
      if (text == '1') text = sensor%quantity
      if (size(record%extent%sensors) > 1) text = text//' at '//short_name(sensor%name)
    end associate
  end function place_text

  pure function kinds_text(status) result(text)
    !! List the statuses of a line, after a semicolon.
    integer, intent(in) :: status
    character(:), allocatable :: text, word
    integer :: i
    text = ''
    do i = 2, size(status_words)
      if (.not. btest(status, i - 1)) cycle
      word = trim(status_words(i))
      if (index(word, '_') > 0) word(index(word, '_'):index(word, '_')) = ' '
      text = text//', '//word
    end do
    if (text /= '') text = ';'//text(2:)
  end function kinds_text

  pure function drift_text(record, k) result(text)
    !! Return the change of a drifting line's frequency, with half its interval; empty if noise may have caused it, since then it is
    !! the decay rate that changes.
    type(record_result), intent(in) :: record
    integer, intent(in) :: k
    character(:), allocatable :: text
    text = ''
    associate (drift => record%lines%drift(k)/two_pi, error => record%lines%quantile*record%lines%drift_bound(k)/two_pi)
      if (.not. is_missing(record%lines%drift_bound(k)) .and. abs(drift) > error) &
        & text = ' by '//to_its_error(drift, error)//' +/- '//short(error)//' Hz'
    end associate
  end function drift_text

  subroutine report_constants(record, lines)
    !! Print a row for each line, with the modal constant of the sensor that measures it best, and the modal mass.
    type(record_result), intent(in) :: record
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    real(dp) :: size_of, error
    integer :: k, s
    if (all(is_missing(record%constant_error))) return
    call lines%append_line('')
    call lines%append_line('  Modal constants phi phi/M of sensor and hammer (amplitude over blow); mass is M for a shape that '// &
                           'is 1 at both')
    table = table_of('line|constant|+/-|phase|mass|at', '|1/kg|1/kg|degrees|kg', [6, 14, 12, 10, 12, 0])
    call table%put_head(lines)
    do k = 1, min(most_rows, size(record%constant_real, 1))
      if (all(is_missing(record%constant_error(k, :)))) cycle
      s = maxloc(hypot(record%constant_real(k, :), record%constant_imag(k, :))/record%constant_error(k, :), dim=1, &
                 mask=.not. is_missing(record%constant_error(k, :)))
      size_of = hypot(record%constant_real(k, s), record%constant_imag(k, s))
      error = record%constant_error(k, s)
      call table%put_row(lines, text_of(k)//'|'//to_its_error(record%constant_real(k, s), error)//'|'//short(error)//'|'// &
        shortest(atan2(record%constant_imag(k, s), record%constant_real(k, s))*360/two_pi, 3)//'|'// &
        shortest(1/size_of, 4), '   '//short_name(record%extent%sensors(s)%name))
    end do
  end subroutine report_constants

  subroutine report_waves(record, measured, lines)
    !! Print wave numbers and velocities with half their intervals, and properties of the beam from their dispersion.
    type(record_result), intent(in) :: record
    type(measured_type), intent(in) :: measured
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    integer :: k
    if (all(is_missing(measured%wavenumber))) return           ! a note says why
    call lines%append_line('')
    table = table_of('line|wave number|+/-|phase velocity|+/-|group velocity|+/-', &
                     '|1/m|1/m|m/s|m/s|m/s|m/s', [6, 14, 12, 16, 12, 16, 12])
    call table%put_head(lines)
    do k = 1, min(most_rows, size(measured%wavenumber))
      call table%put_row(lines, text_of(k)//'|'//pair_cells(measured%wavenumber(k), measured%wavenumber_error(k))//'|'// &
                         pair_cells(measured%phase_velocity(k), measured%phase_velocity_error(k))//'|'// &
                         pair_cells(measured%group_velocity(k), measured%group_velocity_error(k)))
    end do
    if (.not. is_missing(record%stiffness_root(1))) call lines%append_line('  Their dispersion: sqrt(EI/(rho A)) '// &
      interval_text(record%stiffness_root)//' m2/s'//rotation_text(record%angular_velocity))
  end subroutine report_waves

  pure function rotation_text(pair) result(text)
    !! Return the angular velocity estimated from the dispersion, after a comma.
    real(dp), intent(in) :: pair(2)
    character(:), allocatable :: text
    text = ''
    if (is_missing(pair(1))) return
    text = ', angular velocity '//interval_text(pair)//' rad/s'
  end function rotation_text

  pure function interval_text(pair) result(text)
    !! Return a value and half its interval, if it has one.
    real(dp), intent(in) :: pair(2)
    character(:), allocatable :: text
    text = to_its_error(pair(1), pair(2))
    if (.not. is_missing(pair(2))) text = text//' +/- '//shortest(pair(2), 2)
  end function interval_text

  subroutine report_rejected(record, lines)
    !! Print rejected candidates of lines, and why.
    type(record_result), intent(in) :: record
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    integer :: i
    associate (rejected => record%lines%rejected)
      call lines%append_line('')
      call lines%append_line('  Rejected candidates')
      table = table_of('frequency|over noise|reason', 'Hz|power', [16, 13, 0])
      call table%put_head(lines)
      do i = 1, min(most_rows, size(rejected))
        call table%put_row(lines, fixed(rejected(i)%angular_frequency/two_pi)//'|'//shortest(rejected(i)%ordinate, 3)//'|'// &
                           trim(reason_texts(rejected(i)%reason)), detail=i > shown_candidates)
      end do
      if (size(rejected) > most_rows) call lines%append_line('   ...  '//text_of(size(rejected))//' in all')
    end associate
  end subroutine report_rejected

  subroutine report_noise(record, lines)
    !! Print the residual noise of each sensor.
    type(record_result), intent(in) :: record
    type(text_builder), intent(inout) :: lines
    character(:), allocatable :: text
    integer :: s
    call lines%append_line('')
    text = ''
    do s = 1, min(shown_sensors, size(record%extent%sensors))
      associate (sensor => record%extent%sensors(s))
        if (sensor%left_out) cycle
        text = text//', '//short_name(sensor%name)//' '//shortest(record%lines%noise_deviation(s), 3)//' '// &
          sensor%unit
      end associate
    end do
    if (size(record%extent%sensors) > shown_sensors) text = text//', ...'
    call lines%append_line('  Noise, standard deviation of the residual: '//text(3:))
  end subroutine report_noise

end module bw_record_report
