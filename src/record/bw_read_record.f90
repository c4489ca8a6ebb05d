module bw_read_record
  !! Reads a record from a file: the columns and the part that the scene selects, in SI, with notes.
  use bw_descriptors, only: close_file, open_regular, read_bytes
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input
  use bw_files, only: cannot_be_read, path_beside
  use bw_input_values, only: group_values, position_of
  use bw_kinds, only: dp, i1, i8
  use bw_missing, only: is_missing, missing, scaled
  use bw_netcdf_source, only: netcdf_source
  use bw_process, only: free_memory
  use bw_record, only: record_type
  use bw_record_columns, only: choose_columns, sensors_of
  use bw_record_notes, only: add_notes
  use bw_record_source, only: record_source
  use bw_sample_times, only: even_interval, first_fall, used_part
  use bw_scene, only: scene_type
  use bw_sensor_choice, only: choose_sensors
  use bw_sensor_unit, only: factor_of, force_factor
  use bw_spectrum_par, only: least_samples
  use bw_text, only: shortest, text_of
  use bw_text_source, only: text_source
  implicit none (type, external)
  private
  public :: choose_source, path_beside, read_record, record_path

  real(dp), parameter :: latest = 1.0e11_dp            !! s, 3000 years; later times are not in seconds
  real(dp), parameter :: largest = 1.0e150_dp          !! squares of such numbers are within double precision

contains

  pure function record_path(scene, number) result(path)
    !! Return the path of a file of the record, relative to the scene.
    type(scene_type), intent(in) :: scene              !! with a record
    integer, intent(in) :: number                      !! of the file, from 1
    character(:), allocatable :: path
    path = path_beside(scene%file, scene%record%files(number)%text)
  end function record_path

  subroutine read_record(scene, number, record, error)
    !! Read one file of a scene's record.
    !! **Errors**: `status_bad_file` if it cannot be read, holds no history, or memory is refused; `status_bad_input`, with
    !! the place, if the scene requests what it does not hold, or too little of it remains.
    type(scene_type), intent(in) :: scene              !! with a record
    integer, intent(in) :: number                      !! of the file, from 1
    type(record_type), intent(out) :: record
    type(error_type), allocatable, intent(out) :: error
    class(record_source), allocatable :: source
    integer, allocatable :: columns(:)
    real(dp), allocatable :: times(:), steps(:)
    logical, allocatable :: timed(:)                    ! rows with a time of their own; finally, of the part used
    integer(i8) :: part(2)                             ! first and last row used
    integer :: time, force
    record%path = record_path(scene, number)
    call choose_source(record%path, source, error)
    if (.not. allocated(error)) call source%open(record%path, error)
    if (.not. allocated(error)) call choose_columns(scene, source, time, columns, force, error)
    if (.not. allocated(error)) call check_memory(record%path, source%rows, 3, error)
    if (.not. allocated(error)) call source%read_times(time, record%samples_there, times, steps, error)
    if (.not. allocated(error)) call take_times(scene, source, time, times, steps, record, timed, part, error)
    if (.not. allocated(error)) call read_sensors(scene, source, columns, part, record, error)
    if (.not. allocated(error) .and. force > 0) call read_force(source, force, part, record, error)
    if (.not. allocated(error)) call leave_out(timed, record, error)
    if (.not. allocated(error)) call convert(record, error)
    if (.not. allocated(error)) call add_notes(scene, source, time, columns, force, record)
    if (allocated(source)) call source%close()
  end subroutine read_record

  subroutine choose_source(path, source, error)
    !! Choose the kind of source: NetCDF is recognised by its first bytes, and any other file is read as text.
    character(*), intent(in) :: path
    class(record_source), allocatable, intent(out) :: source
    type(error_type), allocatable, intent(inout) :: error
    integer(i1), parameter :: hdf(8) = [-119_i1, 72_i1, 68_i1, 70_i1, 13_i1, 10_i1, 26_i1, 10_i1]
    integer(i1), parameter :: classic(3) = [67_i1, 68_i1, 70_i1]
    integer(i1) :: bytes(8)
    integer(i8) :: have
    integer :: descriptor, problem, ignored
    bytes = 0
    call open_regular(path, descriptor, error)
    if (allocated(error)) return
    problem = read_bytes(descriptor, 0_i8, bytes, have)
    ignored = close_file(descriptor)
    if (problem /= 0) then
      call cannot_be_read(error, path, problem)
    else if (all(bytes == hdf) .or. (all(bytes(:3) == classic) .and. bytes(4) >= 1 .and. bytes(4) <= 5)) then
      allocate (netcdf_source :: source)
    else
      allocate (text_source :: source)
    end if
    if (allocated(source)) allocate (source%notes(0))
  end subroutine choose_source

  subroutine check_memory(path, samples, numbers, error)
    !! Check before reading that memory suffices for the samples. **Errors**: `status_bad_file`.
    character(*), intent(in) :: path
    integer(i8), intent(in) :: samples
    integer, intent(in) :: numbers                     !! per sample
    type(error_type), allocatable, intent(inout) :: error
    integer(i8) :: free                                ! bytes; negative: not known
    free = free_memory()
    if (free < 0 .or. 8.0_dp*real(samples, dp)*numbers <= real(free, dp)) return
    call fail(error, status_bad_file, path//': not enough memory for '//text_of(samples)//' samples of '//text_of(numbers)// &
              ' numbers each')
  end subroutine check_memory

  subroutine take_times(scene, source, time, times, steps, record, timed, part, error)
    !! Find the times since the first sample used, and the rows that are used.
    type(scene_type), intent(in) :: scene
    class(record_source), intent(inout) :: source
    integer, intent(in) :: time                        !! column of the times; 0: times follow from the sampling rate
    real(dp), allocatable, intent(inout) :: times(:), steps(:)   !! in the file; of size 0 with a sampling rate; consumed
    type(record_type), intent(inout) :: record
    logical, allocatable, intent(out) :: timed(:)       !! rows of that part with a time of their own
    integer(i8), intent(out) :: part(2)
    type(error_type), allocatable, intent(inout) :: error
    real(dp) :: scale                                  ! s over the file's unit
    integer(i8) :: j
    integer, parameter :: many = 16                    ! last times examined: not all have omitted trailing zeros
    part = [1_i8, 0_i8]
    allocate (timed(record%samples_there), source=.true.)
    associate (par => scene%record, first => part(1), last => part(2))
      if (time > 0) then
        call mark_own_times(times, timed)
        if (.not. all(timed)) then
          times = pack(times, timed)
          steps = pack(steps, timed)
        end if
        scale = par%time_scale
        if (is_missing(scale)) scale = factor_of(source%columns(time)%unit, 'time')
        if (abs(scale - 1.0_dp) > 0 .and. scale > 0.0_dp) then
          times = scale*times
          steps = scale*steps
        end if
        call check_times(source, times, timed, error)
        if (allocated(error)) return
      else
        times = [(real(j, dp)/par%sample_rate, j=0, record%samples_there - 1)]
      end if
      call used_part(times, par%first_time, par%last_time, first, last)
      if (last - first + 1 < least_samples) then
        call refuse_short(scene, record, times, max(0_i8, last - first + 1), error)
      else if (last - first >= huge(1)) then
        call fail(error, status_bad_file, record%path//': has '//text_of(last - first + 1)//' samples; accepted: up to '// &
                  text_of(huge(1))//' between start and end')
      end if
      if (allocated(error)) return
      record%origin = times(first)
      if (time > 0) then
        record%interval = even_interval(times(first:last), steps(first:last))
        record%resolution = minval(steps(max(first, last - many):last))
      else
        record%interval = 1.0_dp/par%sample_rate
      end if
      if (record%interval > 0.0_dp) then
        record%times = [((j - first)*record%interval, j=first, last)]
      else
        record%times = times(first:last) - times(first)
      end if
    end associate
    part = [row_of(part(1), timed), row_of(part(2), timed)]
    timed = timed(part(1):part(2))
  end subroutine take_times

  pure subroutine mark_own_times(times, timed)
    !! Mark rows without a time, or with the time of the row before.
    real(dp), intent(in) :: times(:)
    logical, intent(inout) :: timed(:)                  !! false for these
    real(dp) :: last
    integer(i8) :: j
    last = missing
    do j = 1, size(times, kind=i8)
      timed(j) = .not. is_missing(times(j)) .and. abs(times(j) - last) > 0
      if (timed(j)) last = times(j)
    end do
  end subroutine mark_own_times

  pure integer(i8) function row_of(time, timed) result(row)
    !! Return the row of the file that has a time.
    integer(i8), intent(in) :: time                    !! index among the times
    logical, intent(in) :: timed(:)
    integer(i8) :: n
    n = 0
    do row = 1, size(timed, kind=i8)
      if (timed(row)) n = n + 1
      if (n == time) return
    end do
  end function row_of

  subroutine check_times(source, times, timed, error)
    !! Check that times increase and are plausible. **Errors**: `status_bad_file`, with the place.
    class(record_source), intent(inout) :: source
    real(dp), intent(in) :: times(:)
    logical, intent(in) :: timed(:)                     !! rows of the file that have these times
    type(error_type), allocatable, intent(inout) :: error
    integer(i8) :: row
    row = first_fall(times)
    if (row > 0) then
      call fail(error, status_bad_file, source%place_of_row(row_of(row, timed))//': the time '//text_of(times(row))// &
                ' is not later than '//text_of(times(row - 1))//' before it; accepted: increasing times, or sample_rate')
    else if (any(abs(times) > latest)) then
      row = findloc(abs(times) > latest, .true., dim=1, kind=i8)
      call fail(error, status_bad_file, source%place_of_row(row_of(row, timed))//': the time '//text_of(times(row))// &
                ' is beyond that of any clock; accepted: up to '//text_of(latest)//' s, or time_scale if the unit is not s')
    end if
  end subroutine check_times

  subroutine refuse_short(scene, record, times, samples, error)
    !! Report too few samples. **Errors**: `status_bad_input` if the scene excludes others, else `status_bad_file`.
    type(scene_type), intent(in) :: scene
    type(record_type), intent(in) :: record
    real(dp), intent(in) :: times(:)
    integer(i8), intent(in) :: samples
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: place
    integer :: line, status
    status = status_bad_file
    place = record%path//': has '//text_of(samples)//' samples'
    associate (group => scene%groups(position_of(scene%groups, 'record')))
      line = max(group%line_of('start'), group%line_of('end'))
      if (line > 0) then
        status = status_bad_input
        place = scene%file//':'//text_of(line)//': record%'//cut_by(group, line)//': leaves '//text_of(samples)//' of '// &
          text_of(size(times))//' samples of '//record%path
      end if
    end associate
    if (size(times) > 0) place = place//', whose times run from '//shortest(times(1), 6)//' to '// &
      shortest(times(size(times)), 6)//' s'
    call fail(error, status, place//'; accepted: '//text_of(least_samples)//' or more')
  end subroutine refuse_short

  pure function cut_by(group, line) result(name)
    !! Return which of start and end is given at a line.
    type(group_values), intent(in) :: group
    integer, intent(in) :: line
    character(:), allocatable :: name
    name = 'end'
    if (group%line_of('start') == line) name = 'start'
  end function cut_by

  subroutine read_force(source, column, part, record, error)
    !! Read the hammer's force at the samples used.
    class(record_source), intent(inout) :: source
    integer, intent(in) :: column
    integer(i8), intent(in) :: part(2)
    type(record_type), intent(inout) :: record
    type(error_type), allocatable, intent(inout) :: error
    real(dp) :: values(size(record%values, 1), 1)
    call source%read_values([column], part(1), values, error)
    if (.not. allocated(error) .and. any(is_missing(values))) call fail(error, status_bad_file, source%place_of_row(part(1) - 1 + &
      findloc(is_missing(values(:, 1)), .true., dim=1))//': a value of the force is missing; accepted: a force without gaps')
    if (.not. allocated(error)) record%force = force_factor(source%columns(column)%unit)*values(:, 1)
  end subroutine read_force

  subroutine read_sensors(scene, source, columns, part, record, error)
    !! Read all samples from the first to the last used.
    type(scene_type), intent(in) :: scene
    class(record_source), intent(inout) :: source
    integer, intent(in) :: columns(:)
    integer(i8), intent(in) :: part(2)                 !! first and last row used
    type(record_type), intent(inout) :: record
    type(error_type), allocatable, intent(inout) :: error
    integer :: status
    record%sensors = sensors_of(scene%record, source, columns)
    call check_memory(record%path, part(2) - part(1) + 1, size(columns), error)
    if (allocated(error)) return
    allocate (record%values(part(2) - part(1) + 1, size(columns)), stat=status)
    if (status /= 0) call fail(error, status_bad_file, record%path//': not enough memory')
    if (.not. allocated(error)) call source%read_values(columns, part(1), record%values, error)
  end subroutine read_sensors

  subroutine leave_out(timed, record, error)
    !! Choose sensors, and drop rows that lack a time of their own, or a number of such a sensor. **Errors**: `status_bad_file` if
    !! too few remain.
    logical, intent(in) :: timed(:)                     !! rows that have the times
    type(record_type), intent(inout) :: record
    type(error_type), allocatable, intent(inout) :: error
    logical :: whole(size(timed))
    logical, allocatable :: stays(:)                   ! which of the times are kept
    real(dp), allocatable :: values(:, :)
    integer(i8) :: lacking(size(record%sensors)), j
    integer :: s, first, last
    call choose_sensors(timed, record)
    whole = timed
    do s = 1, size(lacking)
      if (.not. record%sensors(s)%left_out) whole = whole .and. .not. is_missing(record%values(:, s))
      lacking(s) = count(is_missing(record%values(:, s)))
    end do
    record%left_out = count(.not. whole)
    if (allocated(record%force)) then
      record%force = pack(record%force, timed)
      record%force_times = record%times
    end if
    if (record%left_out == 0) return
    s = maxloc(lacking, dim=1)
    if (count(whole) < least_samples) call fail(error, status_bad_file, record%path//': has '//text_of(count(whole))// &
      ' complete rows, and column '//record%sensors(s)%name//' lacks '//text_of(lacking(s))//' of '// &
      text_of(size(timed))//' values; accepted: '//text_of(least_samples)//' rows or more')
    if (allocated(error)) return
    allocate (values(count(whole), size(lacking)))
    do s = 1, size(lacking)
      values(:, s) = pack(record%values(:, s), whole)
    end do
    call move_alloc(values, record%values)
    stays = pack(whole, timed)
    first = findloc(stays, .true., dim=1)
    last = findloc(stays, .true., dim=1, back=.true.)
    if (.not. all(stays(first:last))) record%interval = 0.0_dp
    record%origin = record%origin + record%times(first)
    if (allocated(record%force)) record%force_times = record%force_times - record%times(first)
    record%times = pack(record%times, stays) - record%times(first)
    if (record%interval > 0.0_dp) record%times = [(j*record%interval, j=0, size(record%times, kind=i8) - 1)]
  end subroutine leave_out

  subroutine convert(record, error)
    !! Convert samples to SI, or keep the file's unit if it is not known. **Errors**: `status_bad_file` if they are too large.
    type(record_type), intent(inout) :: record
    type(error_type), allocatable, intent(inout) :: error
    integer :: s
    do s = 1, size(record%sensors)
      associate (factor => record%sensors(s)%scale)
        if (maxval(abs(record%values(:, s))) <= largest/max(1.0_dp, abs(factor))) then
          if (abs(factor - 1.0_dp) > 0) record%values(:, s) = scaled(record%values(:, s), factor)
          cycle
        end if
      end associate
      call fail(error, status_bad_file, record%path//': '//record%sensors(s)%name//' has numbers that are too large; '// &
                'accepted: up to '//text_of(largest)//' in SI')
      return
    end do
  end subroutine convert

end module bw_read_record
