module bw_pooled_table
  !! The printed table of the lines that repeats of a record share.
  use bw_columns, only: most_rows, note_rest, pair_cells, short, table_of, text_table
  use bw_constants, only: two_pi
  use bw_kinds, only: dp
  use bw_missing, only: is_missing, missing, scaled
  use bw_random_effects, only: pooled_value
  use bw_record, only: sensor_type
  use bw_record_report, only: short_name
  use bw_repeats, only: pooled_lines
  use bw_screen, only: details
  use bw_text, only: shortest, text_builder, text_of
  implicit none (type, external)
  private
  public :: pooled_table

contains

  function pooled_table(pooled, cases, confidence, sensors, frequencies) result(text)
    !! Return the table; empty if repeats share no line.
    type(pooled_lines), intent(in) :: pooled
    integer, intent(in) :: cases                  !! repeats
    real(dp), intent(in) :: confidence            !! of the intervals
    type(sensor_type), intent(in) :: sensors(:)
    real(dp), intent(in), optional :: frequencies(:)  !! Hz, of responses to a hammer
    character(:), allocatable :: text
    type(text_builder) :: lines, responses
    type(text_table) :: table
    integer :: k
    text = ''
    if (size(pooled%count) == 0) return
    call lines%append_line('')
    call lines%append_line('  Pooled repeats; +/- is half the interval of '//shortest(100*confidence, 6)// &
                           ' % of their mean, next +/- that of one more repeat')
    table = table_of('line|repeats|frequency|+/-|next +/-|scatter|decay rate|+/-|next +/-|scatter|damping|what', &
                     '||Hz|Hz|Hz|Hz|1/s|1/s|1/s|1/s|%', [6, 9, 14, 12, 12, 12, 12, 12, 12, 12, 10, 0])
    call table%put_head(lines)
    do k = 1, min(most_rows, size(pooled%count))
      call table%put_row(lines, text_of(k)//'|'//text_of(pooled%count(k))//' of '//text_of(cases)//'|'// &
                         value_cells(pooled%frequency(k), 1/two_pi)//'|'//value_cells(pooled%decay(k), 1.0_dp)//'|'// &
                         short(damping_part(pooled%frequency(k)%value, pooled%decay(k)%value), 3), &
                         status_text(pooled%status(k)))
    end do
    call note_rest(lines, size(pooled%count), most_rows)
    if (allocated(pooled%constant_real)) call report_constants(pooled, sensors, lines)
    if (allocated(pooled%coherence)) call report_responses(pooled, sensors, frequencies, responses)
    text = lines%text()//details(responses%text())
  end function pooled_table

  subroutine report_constants(pooled, sensors, lines)
    !! Print a row for each line, with the modal constant of the sensor that measures it best, and the modal mass.
    type(pooled_lines), intent(in) :: pooled
    type(sensor_type), intent(in) :: sensors(:)
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    real(dp) :: magnitude(size(sensors))
    integer :: k, s
    if (all(is_missing(pooled%constant_real%value))) return
    call lines%append_line('')
    call lines%append_line('  Modal constants from all repeats, phi phi/M of sensor and hammer; mass is M for a shape that '// &
                           'is 1 at both')
    table = table_of('line|constant|+/-|next +/-|scatter|phase|mass|at', '|1/kg|1/kg|1/kg|1/kg|degrees|kg', &
                     [6, 14, 12, 12, 12, 10, 12, 0])
    call table%put_head(lines)
    do k = 1, min(most_rows, size(pooled%count))
      associate (real_part => pooled%constant_real(k, :), imag_part => pooled%constant_imag(k, :))
        if (all(is_missing(real_part%value))) cycle
        magnitude = hypot(real_part%value, imag_part%value)
        s = maxloc(magnitude/real_part%error, dim=1, mask=.not. is_missing(real_part%value))
        call table%put_row(lines, text_of(k)//'|'//value_cells(real_part(s), 1.0_dp)//'|'// &
          shortest(atan2(imag_part(s)%value, real_part(s)%value)*360/two_pi, 3)//'|'//shortest(1/magnitude(s), 4), &
          '   '//short_name(sensors(s)%name))
      end associate
    end do
  end subroutine report_constants

  subroutine report_responses(pooled, sensors, frequencies, lines)
    !! Print H1, H2 and coherence over the repeats at the lines' frequencies, at the sensor of largest motion.
    type(pooled_lines), intent(in) :: pooled
    type(sensor_type), intent(in) :: sensors(:)
    real(dp), intent(in) :: frequencies(:)        !! Hz
    type(text_builder), intent(inout) :: lines
    type(text_table) :: table
    integer :: k, j, s
    call lines%append_line('')
    call lines%append_line('  Frequency response over the repeats, in the unit of sensors over 1 N, at the frequency '// &
                           'nearest to each line')
    table = table_of('line|frequency|H1|H2|coherence|at', '|Hz', [6, 14, 12, 12, 12, 0])
    call table%put_head(lines)
    do k = 1, min(most_rows, size(pooled%count))
      j = minloc(abs(frequencies - pooled%frequency(k)%value/two_pi), dim=1)
      s = maxloc(hypot(pooled%h1_real(j, :), pooled%h1_imag(j, :)), dim=1, mask=.not. is_missing(pooled%coherence(j, :)))
      if (s == 0) cycle
      call table%put_row(lines, text_of(k)//'|'//shortest(frequencies(j), 6)//'|'// &
        shortest(hypot(pooled%h1_real(j, s), pooled%h1_imag(j, s)), 4)//'|'// &
        shortest(hypot(pooled%h2_real(j, s), pooled%h2_imag(j, s)), 4)//'|'//shortest(pooled%coherence(j, s), 5), &
        '   '//short_name(sensors(s)%name))
    end do
  end subroutine report_responses

  pure real(dp) function damping_part(frequency, decay) result(part)
    !! Return the damping ratio, %.
    real(dp), intent(in) :: frequency, decay      !! rad/s, 1/s; if missing, so is the ratio
    part = missing
    if (.not. (is_missing(frequency) .or. is_missing(decay))) part = 100*decay/hypot(frequency, decay)
  end function damping_part

  pure function value_cells(pooled, unit) result(cells)
    !! A number, half its interval, that of the next repeat, and the scatter.
    type(pooled_value), intent(in) :: pooled
    real(dp), intent(in) :: unit
    character(:), allocatable :: cells
    cells = '-|-|-|-'
    if (.not. is_missing(pooled%value)) cells = pair_cells(scaled(pooled%value, unit), scaled(pooled%error, unit))//'|'// &
      shortest(unit*pooled%next, 2)//'|'//shortest(unit*pooled%scatter, 2)
  end function value_cells

  pure function status_text(status) result(text)
    !! Name the numbers that scatter more than the repeats' errors explain, and drift: the bits of `pooled_words` after the first.
    integer, intent(in) :: status
    character(:), allocatable :: text
    character(*), parameter :: words(*) = [character(20) :: ', frequency scatters', ', decay scatters', ', drifting']
    integer :: i
    text = ''
    do i = 1, size(words)
      if (btest(status, i)) text = text//trim(words(i))
    end do
    if (text /= '') text = '   '//text(3:)
  end function status_text

end module bw_pooled_table
