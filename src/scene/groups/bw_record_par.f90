module bw_record_par
  !! `&record`: histories read from files, of a beam that was measured or simulated elsewhere.
  use bw_input_name, only: any_number, columns_input, input_group, input_name, number_range, positive, real_input, &
                           reals_input, texts_input, unit_interval
  use bw_input_values, only: group_values, input_value, position_of
  use bw_kinds, only: dp
  use bw_missing, only: missing
  use bw_scene_messages, only: message_list, shown
  use bw_text, only: string, text_of
  implicit none (type, external)
  private
  public :: build_record, check_record, complete_record, one_choice

  integer, parameter, public :: most_columns = 4096    !! of the sensors
  integer, parameter :: most_files = 10000

  type, public :: column_choice
    !! A column of a table, by its name or its number.
    character(:), allocatable :: name            !! '' if given by number
    integer :: number = 0                        !! from 1; 0 if given by name
  end type column_choice

  type, public :: record_par
    type(string), allocatable :: files(:)        !! as the user gave them, relative to the scene; repeats of one measurement, (n)
    integer :: file = 1                          !! index of the file of this case
    type(column_choice), allocatable :: time     !! unallocated: not given
    real(dp) :: time_scale = missing             !! s over the file's unit of time, > 0; `missing`: from the file's unit
    real(dp) :: sample_rate = missing            !! [Hz], > 0; `missing` if times are read
    type(column_choice), allocatable :: columns(:)   !! the sensors; unallocated: all but the time, (n_sensors)
    type(string), allocatable :: quantities(:)   !! of all sensors, or one for each; unallocated: from the file, (1 or n_sensors)
    real(dp), allocatable :: scales(:)           !! SI over the unit of the column; unallocated: from that unit, (1 or n_sensors)
    real(dp), allocatable :: points(:)           !! ξ of each sensor; unallocated: from the file, if given, (n_sensors)
    type(column_choice), allocatable :: force    !! of the hammer; unallocated: the force is unknown
    real(dp) :: force_point = 1                  !! ξ of the blow
    real(dp) :: first_time = -huge(1.0_dp)       !! first and last time used [s], in the file's time
    real(dp) :: last_time = huge(1.0_dp)
  end type record_par

  type(input_group), parameter, public :: record_group = input_group( &
    'record', needs='spectrum', excludes='impact response', absent='histories are simulated, not read', &
    physics='Measured histories take the place of simulated ones. They are analysed as a free decay after one or several '// &
    'blows: a sum of damped sinusoids and noise.', &
    example='&record file = ''input/records/ring_down_1.csv'', quantity = ''acceleration'', points = 0.5, 1.0 /|&spectrum '// &
    '/', &
    rules='Paths are relative to the scene. A file is text (columns separated by commas, semicolons, tabs or blanks; header '// &
    'lines; comments behind # or %) or NetCDF, such as a result of beamwave; its content decides. Several files are repeats of '// &
    'one measurement, each a case. Give `time` or `sample_rate`; without both the time is the column or variable named time or '// &
    't, or a usual name of loggers (X_Value, Zeit, elapsed time). Times may be uneven but must increase. Without `columns` '// &
    'every column except the time is a sensor. Without `points` there are only frequencies and decay rates. With `force` the '// &
    'amplitudes are divided by the hammer''s blow and become modal constants and frequency responses. `&beam` may be absent.')

  type(input_name), parameter, public :: record_names(*) = [ &
    input_name('record', 'file', texts_input, required=.true., most=most_files, meaning='one file, or repeats'), &
    input_name('record', 'time', columns_input, range=number_range(1.0_dp, 1e6_dp), excludes='sample_rate', &
               meaning='column of the times'), &
    input_name('record', 'time_scale', real_input, '1', positive, excludes='sample_rate', &
               meaning='unit of the times in seconds; absent: by the file'), &
    input_name('record', 'sample_rate', real_input, 'Hz', number_range(1e-9_dp, 1e15_dp), excludes='time time_scale', &
               meaning='sampling rate, the first sample at time 0'), &
    input_name('record', 'columns', columns_input, range=number_range(1.0_dp, 1e6_dp), most=most_columns, &
               meaning='columns of the sensors'), &
    input_name('record', 'quantity', texts_input, words='displacement velocity acceleration strain', most=most_columns, &
               meaning='measured quantity; absent: by the file'), &
    input_name('record', 'scale', reals_input, '1', any_number, most=most_columns, &
               meaning='factor to SI, of all or each; absent: by the file'), &
    input_name('record', 'points', reals_input, '1', unit_interval, most=most_columns, &
               meaning='place of each sensor: x/l, 0 at the root, 1 at the tip'), &
    input_name('record', 'force', columns_input, range=number_range(1.0_dp, 1e6_dp), meaning='column of the hammer''s force'), &
    input_name('record', 'force_point', real_input, '1', unit_interval, &
               meaning='place of the hammer''s blow: x/l; absent: the tip'), &
    input_name('record', 'start', real_input, 's', any_number, swept=.true., meaning='beginning of the part used'), &
    input_name('record', 'end', real_input, 's', any_number, swept=.true., meaning='end of the part used')]

  character(*), parameter :: per_sensor(*) = [character(8) :: 'columns', 'points', 'quantity', 'scale']

contains

  pure subroutine check_record(record, messages)
    !! Check that lists match, that nothing is named twice, and that no scale is 0.
    type(group_values), intent(in) :: record
    type(message_list), intent(inout) :: messages
    call check_repeats(record, 'file', messages)
    call check_repeats(record, 'columns', messages)
    call check_counts(record, messages)
    associate (scale => record%values(record%at('scale')), columns => record%values(record%at('columns')), &
               time => record%values(record%at('time')))
      if (scale%known) then
        if (any(scale%numbers == 0.0_dp)) call messages%add(scale%line, 'record%scale', 'is 0; accepted: any other number')
      end if
      if (record%known('force_point') .and. .not. record%known('force')) call messages%add(record%line_of('force_point'), &
        'record%force_point', 'is given without force; accepted: both, or neither')
      if (.not. (columns%known .and. time%known)) return
      if (place_in(columns, 1, size(columns%texts), time, 1) > 0) call messages%add(columns%line, 'record%columns', &
        'contains the column of the times; accepted: columns of sensors')
    end associate
  end subroutine check_record

  pure subroutine check_repeats(record, name, messages)
    !! Report files or columns that are given twice.
    type(group_values), intent(in) :: record
    character(*), intent(in) :: name
    type(message_list), intent(inout) :: messages
    integer :: i
    associate (value => record%values(record%at(name)))
      if (.not. value%known) return
      do i = 2, size(value%texts)
        if (place_in(value, 1, i - 1, value, i) == 0) cycle
        call messages%add(value%lines(i), 'record%'//name, what(value, i)//' is given twice; accepted: each once')
      end do
    end associate
  end subroutine check_repeats

  pure integer function place_in(list, first, last, other, i) result(place)
    !! Return the place, from first to last, of item i of another list in a list; 0: none.
    type(input_value), intent(in) :: list, other
    integer, intent(in) :: first, last, i
    do place = last, first, -1
      if (list%texts(place)%text /= other%texts(i)%text) cycle
      if (other%texts(i)%text /= '' .or. list%numbers(place) == other%numbers(i)) return
    end do
    place = 0
  end function place_in

  pure function what(value, i) result(text)
    !! Return an item of a list as a message shows it.
    type(input_value), intent(in) :: value
    integer, intent(in) :: i
    character(:), allocatable :: text
    text = shown(value%texts(i)%text)
    if (value%texts(i)%text == '') text = text_of(nint(value%numbers(i)))
  end function what

  pure subroutine check_counts(record, messages)
    !! Check that lists of several values have one for each sensor; places are always one for each.
    type(group_values), intent(in) :: record
    type(message_list), intent(inout) :: messages
    integer :: i, first
    first = 0
    do i = 1, size(per_sensor)
      associate (value => record%values(record%at(trim(per_sensor(i)))))
        if (.not. value%known) cycle
        if (i > 2 .and. size(value%numbers) == 1) cycle
        if (first == 0) first = i
        if (record%count_of(trim(per_sensor(first))) == size(value%numbers)) cycle
        call messages%add(value%line, 'record%'//trim(per_sensor(i)), 'has '//text_of(size(value%numbers))//' values, and '// &
                          trim(per_sensor(first))//' has '//text_of(record%count_of(trim(per_sensor(first))))// &
                          '; accepted: '//trim(merge('one for each column    ', 'one, or one each column', i < 3)))
      end associate
    end do
  end subroutine check_counts

  pure subroutine complete_record(groups, messages)
    !! Check that the part used is not empty, in every case of a sweep.
    type(group_values), intent(in) :: groups(:)
    type(message_list), intent(inout) :: messages
    associate (record => groups(position_of(groups, 'record')))
      if (.not. (record%known('start') .and. record%known('end'))) return
      if (record%number('start') < record%number('end')) return
      call messages%add(record%line_of('end'), 'record%end', text_of(record%number('end'))//' is not after start = '// &
                        text_of(record%number('start'))//'; accepted: a later time')
    end associate
  end subroutine complete_record

  pure type(record_par) function build_record(values) result(record)
    !! Build a record from checked values.
    type(group_values), intent(in) :: values
    record%files = values%values(values%at('file'))%texts
    record%file = max(1, values%whole('file'))
    if (values%known('time')) record%time = one_choice(values%values(values%at('time')))
    if (values%known('columns')) record%columns = choices(values%values(values%at('columns')))
    if (values%known('quantity')) record%quantities = values%values(values%at('quantity'))%texts
    if (values%known('points')) record%points = values%values(values%at('points'))%numbers
    if (values%known('scale')) record%scales = values%values(values%at('scale'))%numbers
    if (values%known('force')) record%force = one_choice(values%values(values%at('force')))
    if (values%known('force_point')) record%force_point = values%number('force_point')
    if (values%known('time_scale')) record%time_scale = values%number('time_scale')
    if (values%known('sample_rate')) record%sample_rate = values%number('sample_rate')
    if (values%known('start')) record%first_time = values%number('start')
    if (values%known('end')) record%last_time = values%number('end')
  end function build_record

  pure type(column_choice) function one_choice(value) result(column)
    !! Return a single column.
    type(input_value), intent(in) :: value
    type(column_choice), allocatable :: columns(:)
    columns = choices(value)
    column = columns(1)
  end function one_choice

  pure function choices(value) result(columns)
    !! Return columns as a scene names them.
    type(input_value), intent(in) :: value
    type(column_choice), allocatable :: columns(:)
    integer :: i
    allocate (columns(size(value%texts)))
    do i = 1, size(columns)
      columns(i)%name = value%texts(i)%text
      columns(i)%number = nint(value%numbers(i))
    end do
  end function choices

end module bw_record_par
