module bw_record_columns
  !! Selects the columns of a file that a scene refers to, and finds quantity, unit and place of its sensors.
  use bw_error, only: error_type, fail, status_bad_input
  use bw_input_values, only: position_of
  use bw_kinds, only: dp
  use bw_missing, only: is_missing
  use bw_record, only: bare_name, sensor_type
  use bw_record_par, only: column_choice, most_columns, record_par
  use bw_record_source, only: record_source
  use bw_scene, only: scene_type
  use bw_sensor_unit, only: factor_of, force_factor, si_unit
  use bw_text, only: shortened, shortest, string, text_of
  use bw_time_column, only: named_time
  implicit none (type, external)
  private
  public :: choose_columns, listed, sensors_of

  integer, parameter :: most_listed = 30               !! columns listed in a message

contains

  subroutine choose_columns(scene, source, time, columns, force, error)
    !! Find the columns of times, sensors and hammer. **Errors**: `status_bad_input` for a column that the file does not have.
    type(scene_type), intent(in) :: scene              !! with a record
    class(record_source), intent(in) :: source
    integer, intent(out) :: time                       !! 0: times follow from the sampling rate
    integer, allocatable, intent(out) :: columns(:)    !! of the sensors
    integer, intent(out) :: force                      !! 0: none
    type(error_type), allocatable, intent(inout) :: error
    type(string) :: bare(size(source%columns))         ! names of the columns in lower case and without units
    integer :: i
    do i = 1, size(bare)
      bare(i)%text = bare_name(source%columns(i)%name)
    end do
    time = 0
    force = 0
    allocate (columns(0))
    associate (record => scene%record)
      if (allocated(record%time)) then
        call choose(scene, source, bare, 'time', record%time, time, error)
      else
        time = named_time(source%columns)
      end if
      if (is_missing(record%sample_rate)) call check_time(scene, source, time, error)
      if (allocated(record%force)) call choose(scene, source, bare, 'force', record%force, force, error)
      if (allocated(error)) return
      if (allocated(record%columns)) then
        deallocate (columns)
        allocate (columns(size(record%columns)))
        do i = 1, size(columns)
          call choose(scene, source, bare, 'columns', record%columns(i), columns(i), error)
          if (allocated(error)) return
        end do
      else
        columns = pack(all_sensors(source, time), all_sensors(source, time) /= force)
      end if
      if (.not. is_missing(record%sample_rate)) time = 0     ! a column of times is then ignored
    end associate
    call check_choice(scene, source, time, columns, error)
    if (force > 0) call check_force(scene, source, time, columns, force, error)
  end subroutine choose_columns

  subroutine check_time(scene, source, time, error)
    !! Check that there is a column of times, and that it holds numbers. **Errors**: `status_bad_input`.
    type(scene_type), intent(in) :: scene
    class(record_source), intent(in) :: source
    integer, intent(in) :: time                        !! 0: none
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: problem
    if (time == 0) then
      problem = 'no column of '//source%path//' has a name of times, such as time or t'
      if (count(source%columns%is_time) > 1) problem = 'several columns of '//source%path//' have names of times'
      call refuse(scene, 'time', 'is missing, and '//problem//'; accepted: '//listed(source)//'; or sample_rate', error)
    else if (.not. source%columns(time)%is_numeric) then
      call refuse(scene, 'time', shown(source, time)//' of '//source%path//' holds dates, clock times or words, not numbers; '// &
                  'accepted: a column of seconds (beamwave-record converts dates and clock times), or sample_rate', error)
    end if
  end subroutine check_time

  pure function all_sensors(source, time) result(columns)
    !! Return all columns of numbers except the time and others named like it or as a time; if the file gives the
    !! quantities of some, only those.
    class(record_source), intent(in) :: source
    integer, intent(in) :: time
    integer, allocatable :: columns(:)
    logical :: taken(size(source%columns)), says(size(source%columns))
    integer :: i
    do i = 1, size(taken)
      taken(i) = source%columns(i)%is_numeric .and. i /= time .and. .not. source%columns(i)%is_time
      says(i) = source%columns(i)%quantity /= ''
      if (time > 0) taken(i) = taken(i) .and. (source%columns(i)%name == '' .or. &
                                               source%columns(i)%name /= source%columns(time)%name)
    end do
    if (any(taken .and. says) .and. source%is_labelled) taken = taken .and. says
    columns = pack([(i, i=1, size(taken))], taken)
  end function all_sensors

  subroutine check_choice(scene, source, time, columns, error)
    !! Check that there is a sensor, that none is the time or named twice, and that lists of the scene match them.
    type(scene_type), intent(in) :: scene
    class(record_source), intent(in) :: source
    integer, intent(in) :: time, columns(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    if (size(columns) == 0) call refuse(scene, 'columns', source%path//' has no column of numbers besides the time; accepted: '// &
                                        'at least one sensor', error)
    if (size(columns) > most_columns) call refuse(scene, 'columns', source%path//' has '//text_of(size(columns))// &
      ' columns of numbers besides the time; accepted: up to '//text_of(most_columns)//', by name or number', error)
    if (allocated(error)) return
    do i = 1, size(columns)
      if (columns(i) == time) call refuse(scene, 'columns', 'includes the column of times, '//shown(source, time)// &
                                          '; accepted: columns of sensors', error)
      if (any(columns(:i - 1) == columns(i))) call refuse(scene, 'columns', 'names '//shown(source, columns(i))// &
                                                          ' twice; accepted: each once', error)
      if (.not. source%columns(columns(i))%is_numeric) call refuse(scene, 'columns', shown(source, columns(i))//' of '// &
        source%path//' holds no numbers; accepted: '//listed(source), error)
    end do
    associate (record => scene%record)
      if (allocated(record%points)) call check_count(scene, source, 'points', size(record%points), columns, error)
      if (allocated(record%quantities)) then
        if (size(record%quantities) > 1) call check_count(scene, source, 'quantity', size(record%quantities), columns, error)
      end if
      if (allocated(record%scales)) then
        if (size(record%scales) > 1) call check_count(scene, source, 'scale', size(record%scales), columns, error)
      end if
    end associate
  end subroutine check_choice

  subroutine check_force(scene, source, time, columns, force, error)
    !! Check that the hammer's column holds numbers, is not used otherwise, and has a unit of force.
    type(scene_type), intent(in) :: scene
    class(record_source), intent(in) :: source
    integer, intent(in) :: time, columns(:), force
    type(error_type), allocatable, intent(inout) :: error
    if (force == time .or. any(columns == force)) then
      call refuse(scene, 'force', shown(source, force)//' is also the time or a sensor; accepted: a column of its own', error)
    else if (.not. source%columns(force)%is_numeric) then
      call refuse(scene, 'force', shown(source, force)//' of '//source%path//' holds no numbers; accepted: '//listed(source), error)
    else if (.not. force_factor(source%columns(force)%unit) > 0) then
      call refuse(scene, 'force', shown(source, force)//' of '//source%path//" is in '"//shortened(source%columns(force)%unit)// &
                  "', which is no unit of force; accepted: N, mN, kN, lbf, or no unit", error)
    end if
  end subroutine check_force

  subroutine check_count(scene, source, name, values, columns, error)
    !! Check that a list has one value for each sensor.
    type(scene_type), intent(in) :: scene
    class(record_source), intent(in) :: source
    character(*), intent(in) :: name
    integer, intent(in) :: values, columns(:)
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: text
    integer :: i
    if (values == size(columns)) return
    text = ''
    do i = 1, min(size(columns), most_listed)
      text = text//', '//shown(source, columns(i))
    end do
    if (size(columns) > most_listed) text = text//', ...'
    call refuse(scene, name, 'has '//text_of(values)//trim(merge(' value ', ' values', values == 1))//', and '// &
                source%path//' has '//text_of(size(columns))//trim(merge(' sensor ', ' sensors', size(columns) == 1))// &
                ' ('//text(3:)//'); accepted: one for each sensor', error)
  end subroutine check_count

  subroutine choose(scene, source, bare, name, choice, column, error)
    !! Find the number of a column that the scene refers to.
    type(scene_type), intent(in) :: scene
    class(record_source), intent(in) :: source
    type(string), intent(in) :: bare(:)                !! names of all columns, by `bare_name`
    character(*), intent(in) :: name                   !! in `&record`
    type(column_choice), intent(in) :: choice
    integer, intent(out) :: column
    type(error_type), allocatable, intent(inout) :: error
    integer, allocatable :: found(:)
    column = choice%number
    if (choice%name == '') then
      if (column > size(source%columns)) call refuse(scene, name, text_of(column)//' is no column of '//source%path// &
                                                    ', which has '//text_of(size(source%columns))//'; accepted: '// &
                                                    listed(source), error)
      return
    end if
    found = named(source, bare, choice%name)
    if (size(found) == 0) then
      call refuse(scene, name, "'"//shortened(choice%name)//"' is no column of "//source%path//'; accepted: '// &
                  listed(source), error)
    else if (size(found) > 1) then
      call refuse(scene, name, "'"//shortened(choice%name)//"' is the name of several columns of "//source%path// &
                  '; accepted: their numbers, as '//text_of(found(1))//' and '//text_of(found(2)), error)
    else
      column = found(1)
    end if
  end subroutine choose

  pure function named(source, bare, name) result(found)
    !! Find columns by name: exactly, else without regard to case and unit.
    class(record_source), intent(in) :: source
    type(string), intent(in) :: bare(:)
    character(*), intent(in) :: name
    integer, allocatable :: found(:)
    character(:), allocatable :: wanted
    logical :: same(size(bare)), alike(size(bare))
    integer :: i
    wanted = bare_name(name)
    do i = 1, size(bare)
      same(i) = source%columns(i)%name == name
      alike(i) = bare(i)%text == wanted .and. name /= ''
    end do
    found = pack([(i, i=1, size(same))], same)
    if (size(found) == 0) found = pack([(i, i=1, size(same))], alike)
  end function named

  pure function listed(source) result(text)
    !! List the columns of the file by name, or by number if they have none.
    class(record_source), intent(in) :: source
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, min(size(source%columns), most_listed)
      if (source%columns(i)%name /= '') text = text//", '"//shortened(source%columns(i)%name)//"'"
    end do
    if (text == '') then
      text = 'numbers 1 to '//text_of(size(source%columns))//' (it has no names)'
    else
      text = text(3:)
      if (size(source%columns) > most_listed) text = text//', ...'
      text = text//', or numbers 1 to '//text_of(size(source%columns))
    end if
  end function listed

  pure function shown(source, column) result(text)
    !! Return a column as a message shows it.
    class(record_source), intent(in) :: source
    integer, intent(in) :: column
    character(:), allocatable :: text
    text = 'column '//text_of(column)
    if (source%columns(column)%name /= '') text = "'"//shortened(source%columns(column)%name)//"'"
  end function shown

  subroutine refuse(scene, name, problem, error)
    !! Report `SCENE:LINE: record%name: …`, unless there is an error already.
    type(scene_type), intent(in) :: scene
    character(*), intent(in) :: name, problem
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: place
    integer :: line
    if (allocated(error)) return
    line = scene%groups(position_of(scene%groups, 'record'))%line_of(name)
    place = scene%file
    if (line > 0) place = place//':'//text_of(line)
    call fail(error, status_bad_input, place//': record%'//name//': '//problem)
  end subroutine refuse

  pure function sensors_of(record, source, columns) result(sensors)
    !! Return name, quantity, unit and place of each sensor: as given by the scene, else by the file.
    type(record_par), intent(in) :: record
    class(record_source), intent(in) :: source
    integer, intent(in) :: columns(:)
    type(sensor_type), allocatable :: sensors(:)
    integer :: i
    allocate (sensors(size(columns)))
    do i = 1, size(columns)
      associate (column => source%columns(columns(i)), sensor => sensors(i))
        sensor%name = column%name
        if (column%name == '') sensor%name = 'column '//text_of(columns(i))
        sensor%quantity = column%quantity
        if (allocated(record%quantities)) sensor%quantity = record%quantities(min(i, size(record%quantities)))%text
        if (allocated(record%scales)) then
          call apply_unit(column%unit, sensor, record%scales(min(i, size(record%scales))))
        else
          call apply_unit(column%unit, sensor)
        end if
        if (sensor%quantity == '') sensor%quantity = 'displacement'
        sensor%position = column%position
        if (allocated(record%points)) sensor%position = record%points(i)
      end associate
    end do
  end function sensors_of

  pure subroutine apply_unit(unit, sensor, scale)
    !! Find the unit of a sensor's numbers. It is SI if the file gives none or a known one, or if the scene's scale converts
    !! to SI; else that of the file, for lack of a conversion.
    character(*), intent(in) :: unit                   !! in the file; empty: not given
    type(sensor_type), intent(inout) :: sensor         !! its quantity is empty if not known
    real(dp), intent(in), optional :: scale            !! absent: the scene gives none
    real(dp) :: factor
    factor = factor_of(unit, sensor%quantity)
    if (factor > 0.0_dp) sensor%scale = factor
    if (present(scale)) sensor%scale = scale
    if (unit == '') then
      sensor%unit = si_unit(sensor%quantity)
      if (sensor%quantity == '') sensor%unit = si_unit('displacement')
    else if (factor > 0.0_dp .or. (present(scale) .and. sensor%quantity /= '')) then
      sensor%unit = si_unit(sensor%quantity)
    else
      sensor%unit = unit
      if (abs(sensor%scale - 1.0_dp) > 0) sensor%unit = unit//'/'//shortest(sensor%scale, 6)     ! UDUNITS: V/1000 is 1 mV
    end if
  end subroutine apply_unit

end module bw_record_columns
