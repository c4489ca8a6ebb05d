module bw_file_rows
  !! The variables of a result beside its cases: coordinates and all numbers of the scene, known before any case is run,
  !! and values known when all are done.
  use bw_amplitude_spectrum, only: frequency_axis
  use bw_classic_head, only: classic_head
  use bw_kinds, only: dp, i8
  use bw_line_windows, only: window_end, window_start
  use bw_missing, only: is_missing
  use bw_record, only: sensor_type
  use bw_over_cases, only: case_quantiles, over_cases
  use bw_repeats, only: pooled_lines, pooled_words
  use bw_result_layout, only: dimension_length, dimension_names, has, quantile_levels, result_layout
  use bw_result_table, only: result_table, unit_of_sensors
  use bw_scene, only: scene_type
  use bw_scene_cases, only: case_count, times_in_a_row
  use bw_scene_resolved, only: numeric_input, numeric_inputs, values_of_sweep
  use bw_stopwatch, only: stage_words
  use bw_text, only: string, text_of
  use bw_time_grid, only: sample_times
  implicit none (type, external)
  private
  public :: add_dimensions, coordinate_rows, end_rows, input_rows, swept_names

  character(*), parameter :: number_of_file = 'record_file'   !! a variable of repeats
  character(*), parameter, public :: quantities(*) = [character(12) :: 'displacement', 'velocity', 'acceleration', 'strain']
  integer, parameter :: at_once = 65536                       !! numbers of a swept input in memory

  type :: series_type
    !! The values of a swept input.
    real(dp), allocatable :: values(:)    !! repeated as often as needed
    integer :: each = 1                   !! consecutive cases with the same value
  end type series_type

contains

  subroutine add_dimensions(layout, head)
    !! Add the dimensions of a result.
    type(result_layout), intent(in) :: layout
    type(classic_head), intent(inout) :: head
    integer :: i
    do i = 1, size(dimension_names)
      associate (length => dimension_length(layout, trim(dimension_names(i))))
        if (length > 0) call head%add_dimension(trim(dimension_names(i)), length)
      end associate
    end do
  end subroutine add_dimensions

  subroutine coordinate_rows(table, scene)
    !! Put coordinates, and properties of a record's sensors.
    class(result_table), intent(inout) :: table
    type(scene_type), intent(in) :: scene
    character(*), parameter :: along = 'place along the beam, x/l'
    character(:), allocatable :: begin                  ! the event at t = 0
    logical :: of_record
    integer :: j
    of_record = table%layout%of_record
    begin = 'beginning'
    if (allocated(scene%impact)) begin = 'impact'
    if (of_record) begin = 'first sample'
    call count_row(table, 'case', 'number of the case')
    call count_row(table, 'mode', 'mode number k')
    call count_row(table, 'mode_before', 'mode number k before the capture')
    call count_row(table, 'event', 'number of the event')
    call count_row(table, 'peak', 'number of the measured peak, by frequency')
    call count_row(table, 'window', 'part of the record')
    call count_row(table, 'candidate', 'number of what was looked at and is no line')
    call count_row(table, 'pooled', 'number of the line that repeats share, by frequency')
    call count_row(table, 'piece', 'number of the piece of the beam, from the root')
    call count_row(table, 'station', 'number of the station where pieces of the beam begin and end, from the root')
    call count_row(table, 'body', 'number of the body, in the order of the scene')
    call count_row(table, 'force', 'number of the force, in the order of the scene')
    call count_row(table, 'base', 'number of the motion of the base, in the order of the scene')
    call count_row(table, 'configuration', 'number of the configuration, in the order in which they come')
    call count_row(table, 'unknown', 'number of the unknown, in the order of the scene, then of further scenes')
    call count_row(table, 'unknown_too', 'number of the unknown, as unknown')
    if (table%real_row('quantile', 'quantile', '1', 'part of the cases that are at or below; 0: the least, 1: the largest', &
                       is_complete=.true.)) call table%put(quantile_levels)
    call count_row(table, 'stage', 'stage of the work', stage_words)
    if (.not. has(table%layout, 'places')) then
      call count_row(table, 'point', 'number of the sensor')
    else if (table%real_row('point_position', 'point', '1', along, is_complete=.true.)) then
      if (of_record) call table%put(table%layout%record%sensors%position)
      if (.not. of_record) call table%put(points_of(scene))
    end if
    if (table%real_row('profile_position', 'profile', '1', along, is_complete=.true.)) &
      call table%put([(real(j, dp)/(table%layout%profile - 1), j=0, table%layout%profile - 1)])
    if (table%real_row('time', 'time', 's', 'time since the '//begin, is_complete=.true.)) then
      if (of_record) call table%put(table%layout%record%times)
      if (.not. of_record) call table%put(sample_times(scene%response%duration, scene%response%samples))
    end if
    if (table%real_row('frequency', 'frequency', 'Hz', 'frequency', is_complete=.true.)) then
      if (of_record) call table%put(table%layout%record%frequencies)
      if (.not. of_record) call table%put(frequency_axis(scene%response%samples, scene%response%duration))
    end if
    if (table%real_row('response_frequency', 'response_frequency', 'Hz', 'frequency of the harmonic force', is_complete=.true.)) &
      call table%put(scene%frequency_response%frequency)
    if (allocated(table%layout%record)) call sensor_rows(table, table%layout%record%sensors)
  end subroutine coordinate_rows

  pure function points_of(scene) result(points)
    !! Return the points of histories or harmonic responses, which are the same.
    type(scene_type), intent(in) :: scene
    real(dp), allocatable :: points(:)
    if (allocated(scene%response)) then
      points = scene%response%points
    else
      points = scene%frequency_response%points
    end if
  end function points_of

  subroutine count_row(table, name, long_name, words)
    !! Put a coordinate that counts from 1.
    class(result_table), intent(inout) :: table
    character(*), intent(in) :: name, long_name
    character(*), intent(in), optional :: words(:)    !! the meaning of each number
    integer :: first, last, i
    if (.not. table%whole_row(name, name, long_name, words, 1)) return
    do first = 1, table%length_of(name), at_once
      last = min(first + at_once - 1, table%length_of(name))
      call table%store(first - 1_i8, [(real(i, dp), i=first, last)])
    end do
  end subroutine count_row

  subroutine sensor_rows(table, sensors)
    !! Put the sensors of a record, and its parts.
    class(result_table), intent(inout) :: table
    type(sensor_type), intent(in) :: sensors(:)
    type(string), dimension(size(sensors)) :: names, units
    integer :: kinds(size(sensors)), s
    do s = 1, size(sensors)
      names(s)%text = sensors(s)%name
      units(s)%text = sensors(s)%unit
      kinds(s) = findloc(quantities == sensors(s)%quantity, .true., dim=1)
    end do
    if (table%text_row('sensor_name', 'point letter', 'name of the sensor')) call table%put_texts(names)
    if (table%text_row('sensor_unit', 'point letter', 'unit of the sensor')) call table%put_texts(units)
    if (table%whole_row('sensor_quantity', 'point', 'what the sensor measures', quantities, 1)) call table%put(kinds)
    if (table%real_row('window_start', 'window', '1', 'where the part begins, part of the record', is_complete=.true.)) &
      call table%put(window_start)
    if (table%real_row('window_end', 'window', '1', 'where the part ends, part of the record', is_complete=.true.)) &
      call table%put(window_end)
  end subroutine sensor_rows

  pure function swept_names(scene) result(names)
    !! Return the variables of swept inputs, separated by spaces.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: names
    type(numeric_input), allocatable :: inputs(:)
    integer :: i, j
    names = ''
    inputs = numeric_inputs(scene)
    do i = 1, size(inputs)
      do j = 1, size(inputs(i)%sweeps)
        if (inputs(i)%sweeps(j) > 0) names = names//' '//swept_variable(inputs(i), j)
      end do
    end do
    do i = 1, size(scene%sweeps)
      if (scene%sweeps(i)%implied) names = names//' '//number_of_file
    end do
    names = trim(adjustl(names))
  end function swept_names

  pure function swept_variable(input, i) result(name)
    !! Return the variable of one swept number, such as `beam_length`, or `body_mass_2` for one of several: its only
    !! dimension is `case`, so that it can be a coordinate of all that depends on the case.
    type(numeric_input), intent(in) :: input
    integer, intent(in) :: i                          !! index of the number
    character(:), allocatable :: name
    name = input_variable(input)
    if (input%dimension /= '') name = name//'_'//text_of(i)
  end function swept_variable

  pure function input_variable(input) result(name)
    !! Return the variable of an input, such as `beam_length`, with all its numbers.
    type(numeric_input), intent(in) :: input
    character(:), allocatable :: name
    name = trim(input%group)//'_'//trim(input%name)
  end function input_variable

  subroutine input_rows(table, scene)
    !! Put every number of the resolved scene, scalar or along pieces or bodies, and (case) if swept.
    class(result_table), intent(inout) :: table
    type(scene_type), intent(in) :: scene
    type(numeric_input), allocatable :: inputs(:)
    character(:), allocatable :: along                  ! its dimensions
    integer :: i, j
    inputs = numeric_inputs(scene)
    do i = 1, size(inputs)
      associate (input => inputs(i))
        along = input%dimension
        if (input%is_swept) along = 'case '//input%dimension
        if (input_row(table, input, input_variable(input), along, trim(input%meaning), .not. any(is_missing(input%values)))) then
          if (input%is_swept) call put_swept(table, scene, input, 1, size(input%values))
          if (.not. input%is_swept) call table%put(input%values)
        end if
        do j = 1, size(input%sweeps)
          if (input%sweeps(j) == 0 .or. input%dimension == '') cycle
          if (input_row(table, input, swept_variable(input, j), 'case', trim(input%meaning)//'; '//trim(input%dimension)// &
                        ' '//text_of(j), .true.)) call put_swept(table, scene, input, j, j)
        end do
      end associate
    end do
    do i = 1, size(scene%sweeps)
      if (.not. scene%sweeps(i)%implied) cycle
      if (table%whole_row(number_of_file, 'case', 'number of the file among those of the record')) &
        call put_series(table, [series_type(scene%sweeps(i)%values, times_in_a_row(scene, i))], int(case_count(scene)))
    end do
  end subroutine input_rows

  logical function input_row(table, input, name, dimensions, meaning, is_complete) result(wanted)
    !! Define or request the row of an input.
    class(result_table), intent(inout) :: table
    type(numeric_input), intent(in) :: input
    character(*), intent(in) :: name, dimensions, meaning
    logical, intent(in) :: is_complete
    character(:), allocatable :: unit
    unit = trim(input%unit)
    if (unit == '') unit = '1'                          ! unit of the input that it names
    if (input%is_integer) then
      wanted = table%whole_row(name, dimensions, meaning)
    else
      wanted = table%real_row(name, dimensions, unit, meaning, is_complete=is_complete)
    end if
  end function input_row

  subroutine put_swept(table, scene, input, first, last)
    !! Put the values of some numbers of an input for all cases.
    class(result_table), intent(inout) :: table
    type(scene_type), intent(in) :: scene
    type(numeric_input), intent(in) :: input
    integer, intent(in) :: first, last                  !! range of its numbers
    type(series_type) :: series(first:last)
    integer :: i
    do i = first, last
      if (input%sweeps(i) == 0) then
        series(i)%values = [input%values(i)]
      else
        series(i) = series_type(values_of_sweep(scene, input, i), times_in_a_row(scene, input%sweeps(i)))
      end if
    end do
    call put_series(table, series, int(case_count(scene)))
  end subroutine put_swept

  subroutine put_series(table, series, cases)
    !! Put a row for each case, with one number of each series.
    class(result_table), intent(inout) :: table
    type(series_type), intent(in) :: series(:)
    integer, intent(in) :: cases
    real(dp), allocatable :: rows(:, :)
    integer :: done, i, k
    do done = 0, cases - 1, at_once/size(series)
      allocate (rows(size(series), min(at_once/size(series), cases - done)))
      do k = 1, size(series)
        associate (values => series(k)%values)
          rows(k, :) = [(values(mod((done + i)/series(k)%each, size(values)) + 1), i=0, size(rows, 2) - 1)]
        end associate
      end do
      call table%store(int(done, i8)*size(series), reshape(rows, [size(rows)]))
      deallocate (rows)
    end do
  end subroutine put_series

  subroutine end_rows(table, seconds, over)
    !! Put values known when all cases are done.
    class(result_table), intent(inout) :: table
    real(dp), intent(in) :: seconds(:)                  !! (stages)
    type(over_cases), intent(in) :: over                !! all cases; empty while rows are defined, and for one case
    if (table%real_row('stage_seconds', 'stage', 's', 'wall time of the stage over all cases')) call table%put(seconds)
    call pooled_rows(table, over%pooled)
    call quantile_rows(table, over%quantiles)
  end subroutine end_rows

  subroutine quantile_rows(table, quantiles)
    !! Put quantiles of the summaries of a design, and the number of cases behind them.
    class(result_table), intent(inout) :: table
    type(case_quantiles), intent(in), optional :: quantiles(:)   !! of each summary; absent while rows are defined
    integer :: s
    do s = 1, size(table%summaries)
      associate (summary => table%summaries(s))
        if (table%real_row('quantile_'//summary%name, 'quantile '//summary%dimensions, summary%units, 'quantiles of the '// &
                           summary%long_name//', over the cases')) &
          call table%put(reshape(quantiles(s)%values, [size(quantiles(s)%values)]))
        if (table%whole_row('quantile_cases_'//summary%name, summary%dimensions, 'number of cases that have the '// &
                            summary%long_name, needs='quantile')) call table%put(quantiles(s)%cases)
      end associate
    end do
  end subroutine quantile_rows

  subroutine pooled_rows(table, pooled)
    !! Put the lines shared by repeats of a record.
    class(result_table), intent(inout) :: table
    type(pooled_lines), intent(in), optional :: pooled
    character(*), parameter :: next = 'half the interval that holds what one more repeat measures', &
      scatter = 'standard deviation between repeats beyond their own errors'
    if (row('angular_frequency', 'rad s-1', 'angular frequency from all repeats')) call table%put(pooled%frequency%value)
    if (row('angular_frequency_error', 'rad s-1', 'half the interval of that')) call table%put(pooled%frequency%error)
    if (row('angular_frequency_next', 'rad s-1', next)) call table%put(pooled%frequency%next)
    if (row('angular_frequency_scatter', 'rad s-1', scatter)) call table%put(pooled%frequency%scatter)
    if (row('decay_rate', 's-1', 'rate of decay from all repeats')) call table%put(pooled%decay%value)
    if (row('decay_rate_error', 's-1', 'half the interval of that')) call table%put(pooled%decay%error)
    if (row('decay_rate_next', 's-1', next)) call table%put(pooled%decay%next)
    if (row('decay_rate_scatter', 's-1', scatter)) call table%put(pooled%decay%scatter)
    if (table%whole_row('pooled_count', 'pooled', 'number of repeats that have the line; 0: there is none')) &
      call table%put(pooled%count)
    if (table%whole_row('pooled_status', 'pooled', 'whether repeats scatter more than their own intervals allow; 0: no line', &
                        pooled_words, has_masks=.true.)) call table%put(pooled%status)
    if (table%whole_row('pooled_line', 'case peak', 'the line from all repeats that this one belongs to; 0: none', &
                        needs='pooled')) call table%put_columns(real(pooled%member, dp))
    if (response('h1_real', ' N-1', 'real part of H1 over all repeats')) call table%put_columns(pooled%h1_real)
    if (response('h1_imag', ' N-1', 'its imaginary part')) call table%put_columns(pooled%h1_imag)
    if (response('h2_real', ' N-1', 'real part of H2 over all repeats')) call table%put_columns(pooled%h2_real)
    if (response('h2_imag', ' N-1', 'its imaginary part')) call table%put_columns(pooled%h2_imag)
    if (table%real_row('pooled_coherence', 'point frequency', '1', 'coherence of response and force over all repeats', &
                       needs='pooled hammer')) call table%put_columns(pooled%coherence)
  contains
    logical function row(name, units, long_name)
      character(*), intent(in) :: name, units, long_name
      row = table%real_row('pooled_'//name, 'pooled', units, long_name)
    end function row
    logical function response(name, units, long_name)
      character(*), intent(in) :: name, units, long_name
      response = table%real_row('pooled_response_'//name, 'point frequency', unit_of_sensors//units, long_name, &
                                needs='pooled hammer')
    end function response
  end subroutine pooled_rows

end module bw_file_rows
