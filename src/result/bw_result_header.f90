module bw_result_header
  !! What a result file says before its first case: global attributes, coordinates, and the inputs.
  use bw_line_windows, only: window_end, window_start
  use bw_kinds, only: dp, i4
  use bw_amplitude_spectrum, only: frequency_axis
  use bw_error, only: error_type
  use bw_missing, only: is_missing
  use bw_netcdf, only: known_series, netcdf_file, variable_text
  use bw_result_layout, only: dimension_length, has, result_layout
  use bw_scene, only: effect_names, method_name, scene_type
  use bw_scene_cases, only: case_count, times_in_a_row
  use bw_scene_resolved, only: given_names, numeric_input, numeric_inputs, resolved_text, values_of_sweep
  use bw_stopwatch, only: stage_words
  use bw_text, only: joined, text_of
  use bw_time_grid, only: sample_times
  use bw_version, only: program_commit, program_compiler, program_libraries, program_native, program_version
  use netcdf, only: nf90_global, nf90_put_att
  implicit none (type, external)
  private
  character(*), parameter :: number_of_file = 'record_file'   !! a variable of repeats
  character(*), parameter, public :: quantities(*) = [character(12) :: 'displacement', 'velocity', 'acceleration', 'strain']

  public :: coordinates_of, put_global_attributes, put_coordinates, put_inputs, swept_names, source_text

contains

  pure function source_text() result(text)
    !! The program, its version and its commit.
    character(:), allocatable :: text
    text = 'beamwave '//program_version//' ('//program_commit//')'
  end function source_text

  subroutine put_global_attributes(file, scene, error, study)
    !! What the file says of itself: scene, program, method. **Errors**: `status_bad_file`.
    class(netcdf_file), intent(in) :: file
    type(scene_type), intent(in) :: scene
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in), optional :: study   !! the study whose result it is; absent: a run's
    integer(i4), parameter :: format_version = 1
    call file%put_text('Conventions', 'CF-1.11', error)
    if (.not. allocated(error)) call file%check(nf90_put_att(file%id, nf90_global, 'format_version', format_version), error)
    call file%put_text('title', trim(scene%header%title), error)
    call file%put_text('source', source_text(), error)
    call file%put_text('created', time_stamp(), error)
    call file%put_text('history', time_stamp()//': '//called_as(scene, study), error)
    if (present(study)) call file%put_text('study', study, error)
    call file%put_text('scene', trim(resolved_text(scene)), error)
    call file%put_text('given', given_names(scene), error)
    call file%put_text('effects', effect_names(scene), error)
    call file%put_text('method', trim(method_name(scene)), error)
    call file%put_text('notes', '', error)
    call file%put_text('report', '', error)
    call file%put_text('compiler', program_compiler//trim(merge(', tuned for its processor', repeat(' ', 25), program_native)), &
                       error)
    call file%put_text('libraries', program_libraries, error)
  end subroutine put_global_attributes

  function called_as(scene, study) result(text)
    !! The command as it was called, with its options; behind it the scene's file where a directory stands for that.
    type(scene_type), intent(in) :: scene
    character(*), intent(in), optional :: study   !! as above
    character(:), allocatable :: text, word
    logical :: named
    integer :: i, length
    text = 'beamwave'
    named = .false.
    do i = 1, command_argument_count()
      call get_command_argument(i, length=length)
      if (allocated(word)) deallocate (word)
      allocate (character(length) :: word)
      if (length > 0) call get_command_argument(i, word)
      named = named .or. word == scene%file
      text = text//' '//quoted(word)
    end do
    if (i == 1 .and. present(study)) text = text//' '//study                 ! no program of a command line
    if (i == 1 .and. .not. present(study)) text = text//' run'
    if (i == 1) text = text//' '//scene%file
    if (i > 1 .and. .not. named) text = text//' ('//scene%file//')'
  end function called_as

  pure function quoted(word) result(text)
    !! A word as a shell takes it for that word.
    character(*), intent(in) :: word
    character(:), allocatable :: text
    integer :: i
    text = word
    if (scan(word, ' ''"$\*?;&|<>()') == 0 .and. len(word) > 0) return
    text = ''''
    do i = 1, len(word)
      if (word(i:i) == '''') text = text//'''\'''
      text = text//word(i:i)
    end do
    text = text//''''
  end function quoted

  function time_stamp() result(text)
    !! Now, as ISO 8601.
    character(:), allocatable :: text
    character(8) :: date
    character(10) :: time
    character(5) :: zone
    call date_and_time(date, time, zone)
    text = date(1:4)//'-'//date(5:6)//'-'//date(7:8)//'T'//time(1:2)//':'//time(3:4)//':'//time(5:6)// &
      zone(1:3)//':'//zone(4:5)
  end function time_stamp

  pure function coordinates_of(layout) result(rows)
    !! The coordinate variables of a result, which are known before any case is run: integers count from 1.
    type(result_layout), intent(in) :: layout
    type(variable_text), allocatable :: rows(:)
    integer :: i
    rows = [ &
      number_of('case', 'number of the case'), &
      number_of('mode', 'mode number k'), &
      number_of('mode_before', 'mode number k before the capture'), &
      number_of('event', 'number of the event'), &
      number_of('peak', 'number of the measured peak, by frequency'), &
      number_of('window', 'part of the record'), &
      number_of('candidate', 'number of what was looked at and is no line'), &
      number_of('pooled', 'number of the line that repeats share, by frequency'), &
      number_of('piece', 'number of the piece of the beam, from the root'), &
      number_of('body', 'number of the body, in the order of the scene'), &
      number_of('unknown', 'number of the unknown, in the order of the scene, then of further scenes'), &
      number_of('stage', 'stage of the work', joined(stage_words)), &
      variable_text('profile_position', 'profile', '1', 'place along the beam, x/l', is_complete=.true.), &
      point_row(layout), &
      variable_text('time', 'time', 's', 'time since the '//trim(merge('first sample', 'impact      ', layout%of_record)), &
                    is_complete=.true.), &
      variable_text('frequency', 'frequency', 'Hz', 'frequency', is_complete=.true.)]
    rows = pack(rows, [(has(layout, trim(rows(i)%dimensions)), i=1, size(rows))])
  end function coordinates_of

  pure type(variable_text) function point_row(layout) result(row)
    !! The coordinate of points: their places, or the numbers of sensors whose places nobody says.
    type(result_layout), intent(in) :: layout
    if (has(layout, 'places')) then
      row = variable_text('point_position', 'point', '1', 'place along the beam, x/l', is_complete=.true.)
    else
      row = number_of('point', 'number of the sensor')
    end if
  end function point_row

  pure type(variable_text) function number_of(name, long_name, flags) result(row)
    !! A coordinate that counts from 1.
    character(*), intent(in) :: name, long_name
    character(*), intent(in), optional :: flags       !! what the numbers stand for, by spaces
    row = variable_text(name, name, '1', long_name, is_integer=.true., first_flag=1)
    if (present(flags)) row%flags = flags
  end function number_of

  subroutine put_coordinates(file, scene, layout, error)
    !! Coordinate variables. **Errors**: `status_bad_file`.
    class(netcdf_file), intent(inout) :: file
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(error_type), allocatable, intent(inout) :: error
    type(variable_text), allocatable :: rows(:)
    integer :: i
    rows = coordinates_of(layout)
    do i = 1, size(rows)
      if (rows(i)%is_integer) then
        call file%define_known(rows(i), error, count=dimension_length(layout, trim(rows(i)%dimensions)))
      else
        call file%define_known(rows(i), error, axis(scene, layout, trim(rows(i)%name)))
      end if
    end do
    if (allocated(layout%record)) call put_sensors(file, layout, error)
  end subroutine put_coordinates

  subroutine put_sensors(file, layout, error)
    !! What is known of the sensors of a record. **Errors**: `status_bad_file`.
    class(netcdf_file), intent(inout) :: file
    type(result_layout), intent(in) :: layout
    type(error_type), allocatable, intent(inout) :: error
    character(dimension_length(layout, 'letter')), dimension(layout%points) :: names, units
    type(variable_text) :: text
    integer :: s
    do s = 1, layout%points
      names(s) = layout%record%sensors(s)%name
      units(s) = layout%record%sensors(s)%unit
    end do
    call file%define_names(variable_text('sensor_name', 'point letter', long_name='name of the sensor'), names, error)
    call file%define_names(variable_text('sensor_unit', 'point letter', long_name='unit of the sensor'), units, error)
    text = variable_text('sensor_quantity', 'point', '1', 'what the sensor measures', is_integer=.true., &
                         flags=joined(quantities), first_flag=1)
    call file%define_known(text, error, [(real(findloc(quantities == layout%record%sensors(s)%quantity, .true., dim=1), dp), &
                                          s=1, layout%points)])
    if (dimension_length(layout, 'window') > 0) then
      text = variable_text('window_start', 'window', '1', 'where the part begins, part of the record', is_complete=.true.)
      call file%define_known(text, error, window_start)
      text = variable_text('window_end', 'window', '1', 'where the part ends, part of the record', is_complete=.true.)
      call file%define_known(text, error, window_end)
    end if
  end subroutine put_sensors

  pure function axis(scene, layout, name) result(values)
    !! Places along the beam, times in s, or frequencies in Hz.
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: name                  !! of the coordinate
    real(dp), allocatable :: values(:)
    integer :: j
    select case (name)
    case ('profile_position')
      values = [(real(j, dp)/(layout%profile - 1), j=0, layout%profile - 1)]
    case ('point_position')
      if (layout%of_record) values = layout%record%sensors%position
      if (.not. layout%of_record) values = scene%response%points
    case ('time')
      if (layout%of_record) values = layout%record%times
      if (.not. layout%of_record) values = sample_times(scene%response%duration, scene%response%samples)
    case ('frequency')
      if (layout%of_record) values = layout%record%frequencies
      if (.not. layout%of_record) values = frequency_axis(scene%response%samples, scene%response%duration)
    end select
  end function axis

  pure function swept_names(scene) result(names)
    !! Variables of the swept inputs, by spaces.
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
    !! The variable of one swept number, as `beam_length`, or of one of several `body_mass_2`: one that has the dimension `case`
    !! alone, so that all that depends on the case can have it as a coordinate.
    type(numeric_input), intent(in) :: input
    integer, intent(in) :: i                          !! which of its numbers
    character(:), allocatable :: name
    name = input_variable(input)
    if (input%dimension /= '') name = name//'_'//text_of(i)
  end function swept_variable

  pure function input_variable(input) result(name)
    !! The variable of an input, as `beam_length`, with all its numbers.
    type(numeric_input), intent(in) :: input
    character(:), allocatable :: name
    name = trim(input%group)//'_'//trim(input%name)
  end function input_variable

  subroutine put_inputs(file, scene, error)
    !! Every number of the resolved scene, scalar or along pieces or bodies, and (case) where swept. **Errors**: `status_bad_file`.
    class(netcdf_file), intent(inout) :: file
    type(scene_type), intent(in) :: scene
    type(error_type), allocatable, intent(inout) :: error
    type(numeric_input), allocatable :: inputs(:)
    type(variable_text) :: text
    integer :: i, j
    inputs = numeric_inputs(scene)
    do i = 1, size(inputs)
      associate (input => inputs(i))
        text = variable_text(input_variable(input), input%dimension, input%unit, input%meaning, is_integer=input%is_integer, &
                             is_complete=.not. any(is_missing(input%values)))
        if (text%units == '') text%units = '1'             ! that of what the input names
        if (input%is_swept) then
          text%dimensions = 'case '//input%dimension
          call file%define_rows(text, columns_of(scene, input), int(case_count(scene)), error)
          if (input%dimension == '') cycle
          do j = 1, size(input%sweeps)
            if (input%sweeps(j) == 0) cycle
            text = variable_text(swept_variable(input, j), 'case', input%unit, trim(input%meaning)//'; '// &
                                 trim(input%dimension)//' '//text_of(j), is_complete=.true.)
            call file%define_rows(text, columns_of(scene, input, j), int(case_count(scene)), error)
          end do
        else
          call file%define_known(text, error, input%values)
        end if
      end associate
    end do
    do i = 1, size(scene%sweeps)
      if (.not. scene%sweeps(i)%implied) cycle
      text = variable_text(number_of_file, 'case', '1', 'number of the file among those of the record', is_integer=.true.)
      call file%define_rows(text, [known_series(scene%sweeps(i)%values, times_in_a_row(scene, i))], int(case_count(scene)), error)
    end do
  end subroutine put_inputs

  pure function columns_of(scene, input, only) result(columns)
    !! What each number of a swept input, or one of them, runs through from case to case, (n).
    type(scene_type), intent(in) :: scene
    type(numeric_input), intent(in) :: input
    integer, intent(in), optional :: only             !! the number alone that is asked for
    type(known_series), allocatable :: columns(:)
    integer :: i, first, last
    first = 1
    last = size(input%values)
    if (present(only)) first = only
    if (present(only)) last = only
    allocate (columns(first:last))
    do i = first, last
      if (input%sweeps(i) == 0) then
        columns(i)%values = [input%values(i)]
      else
        columns(i)%values = values_of_sweep(scene, input, i)
        columns(i)%each = times_in_a_row(scene, input%sweeps(i))
      end if
    end do
  end function columns_of

end module bw_result_header
