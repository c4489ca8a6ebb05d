module bw_load_courses
  !! The loads of a scene as functions of time: values in SI, times in the unit of the motion. Load files are read here.
  use bw_beam_units, only: beam_units, units_of
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input
  use bw_kinds, only: dp, i8
  use bw_load_course, only: course_of_samples, course_of_shape, end_jump, is_over, load_course, &
    scaled_course
  use bw_load_par, only: load_par
  use bw_missing, only: is_missing
  use bw_read_record, only: choose_source, path_beside
  use bw_record, only: bare_name
  use bw_record_checksum, only: file_digits
  use bw_record_columns, only: listed
  use bw_record_par, only: column_choice
  use bw_record_source, only: record_source
  use bw_sample_times, only: first_fall
  use bw_scene, only: scene_type
  use bw_sensor_unit, only: factor_of, force_factor
  use bw_text, only: shortened, shortest, text_of
  use bw_time_column, only: named_time
  implicit none (type, external)
  private
  public :: check_load_files, courses_of

contains

  subroutine courses_of(scene, units, courses, error)
    !! Return the courses of the forces, N, then of base accelerations a as forces −m_i a, N, in the order of the scene.
    !! **Errors**: those of reading a file; `status_bad_input`, with the place, if a file does not hold what the scene requests.
    type(scene_type), intent(in) :: scene
    type(beam_units), intent(in) :: units
    type(load_course), allocatable, intent(out) :: courses(:)
    type(error_type), allocatable, intent(out) :: error
    integer :: l
    allocate (courses(0))
    if (allocated(scene%forces)) then
      do l = 1, size(scene%forces)
        call add(scene%forces(l)%load_par, 'force')
      end do
    end if
    if (allocated(scene%bases)) then
      do l = 1, size(scene%bases)
        call add(scene%bases(l), 'base')
        if (allocated(error)) return
        courses(size(courses)) = scaled_course(courses(size(courses)), -units%mass)
      end do
    end if
  contains
    subroutine add(load, group)
      type(load_par), intent(in) :: load
      character(*), intent(in) :: group
      real(dp), allocatable :: times(:), values(:)
      real(dp) :: duration
      if (allocated(error)) return
      if (load%shape == 'file') then
        call read_load(scene, load, group, times, values, error)
        if (allocated(error)) return
        courses = [courses, course_of_samples((times + load%start)/units%time%hi, values)]
      else
        duration = scene%response%duration - load%start
        if (.not. is_missing(load%duration)) duration = load%duration
        courses = [courses, course_of_shape(load%shape, load%amplitude, load%start/units%time%hi, duration/units%time%hi, &
                                            load%frequency*units%time%hi)]
      end if
      if (is_over(courses(size(courses)))) call fail(error, status_bad_input, scene%file//':'//text_of(load%line)//': '//group// &
        '%start: all of it lies before t = 0, where the motion begins; accepted: a later start')
    end subroutine add
  end subroutine courses_of

  subroutine check_load_files(scene, checksums, error)
    !! Read the files of all loads before any work is done.
    !! **Errors**: see `courses_of`; `status_bad_input` if requested accelerations have no limit as modes are added.
    type(scene_type), intent(in) :: scene
    character(:), allocatable, intent(out) :: checksums   !! of the files, separated by blanks; unallocated: no files
    type(error_type), allocatable, intent(out) :: error
    type(load_course), allocatable :: courses(:)
    type(beam_units) :: units
    integer :: l
    units = units_of(scene%beam)
    call courses_of(scene, units, courses, error)
    if (allocated(scene%forces)) then
      do l = 1, size(scene%forces)
        if (.not. allocated(error)) call check(scene%forces(l)%load_par)
        if (.not. allocated(error) .and. scene%response%acceleration) call check_limit(scene%forces(l)%load_par, courses(l))
      end do
    end if
    if (allocated(scene%bases)) then
      do l = 1, size(scene%bases)
        if (.not. allocated(error)) call check(scene%bases(l))
      end do
    end if
  contains
    subroutine check(load)
      type(load_par), intent(in) :: load
      if (.not. allocated(load%file)) return
      if (allocated(checksums)) then
        checksums = checksums//' '
      else
        checksums = ''
      end if
      checksums = checksums//file_digits(path_beside(scene%file, load%file), error)
    end subroutine check

    subroutine check_limit(load, course)
      type(load_par), intent(in) :: load
      type(load_course), intent(in) :: course
      real(dp) :: jump
      character(:), allocatable :: accepted
      if (.not. allocated(load%file)) return
      jump = end_jump(course, scene%response%duration/units%time%hi)
      accepted = 'a first and a last sample of 0 (subtract the offset of the sensor, or add a sample of 0 at either end)'
      if (course%left_out /= 0.0_dp) accepted = 'a later start (the part before t = 0 is ignored)'
      if (jump > 0.0_dp) call fail(error, status_bad_input, scene%file//':'//text_of(load%line)//': force%file: '//load%file// &
        ' begins or ends abruptly, with '//shortest(jump, 3)//' N, so that accelerations do not converge; accepted: '//accepted// &
        ', or no acceleration')
    end subroutine check_limit
  end subroutine check_load_files

  subroutine read_load(scene, load, group, times, values, error)
    !! Read the samples of a load, SI.
    type(scene_type), intent(in) :: scene
    type(load_par), intent(in) :: load
    character(*), intent(in) :: group
    real(dp), allocatable, intent(out) :: times(:), values(:)
    type(error_type), allocatable, intent(inout) :: error
    class(record_source), allocatable :: source
    character(:), allocatable :: path, name, problem
    real(dp), allocatable :: steps(:), column_values(:, :)
    real(dp) :: scale
    integer(i8) :: j, rows
    integer :: column, time
    path = path_beside(scene%file, load%file)
    call choose_source(path, source, error)
    if (.not. allocated(error)) call source%open(path, error)
    if (.not. allocated(error)) then
      call choose_columns(source, load, time, column, name, problem)
      if (allocated(problem)) call refused(name, problem)
    end if
    if (.not. allocated(error)) call source%read_times(time, rows, times, steps, error)
    if (allocated(error)) return
    if (time > 0) then
      scale = load%time_scale
      if (is_missing(scale)) scale = factor_of(source%columns(time)%unit, 'time')
      if (scale > 0.0_dp) times = scale*times
      j = first_fall(times)
      if (j > 0) call fail(error, status_bad_file, source%place_of_row(j)//': the time '//text_of(times(j))//' is not above '// &
                           'the one before it; accepted: increasing times, or sample_rate')
    else
      times = [(real(j, dp)/load%sample_rate, j=0, rows - 1)]
    end if
    if (rows < 2 .or. size(times) < 2) call refused('file', path//' has fewer than two samples; accepted: two or more')
    if (allocated(error)) return
    allocate (column_values(size(times), 1))
    call source%read_values([column], 1_i8, column_values, error)
    if (allocated(error)) return
    scale = load%scale
    if (is_missing(scale)) scale = factor_in_si(source%columns(column)%unit, group)
    if (.not. abs(scale) > 0.0_dp) call refused('scale', "is missing, and '"//shortened(source%columns(column)%unit)//"' of "// &
      path//' is not a known unit of the load; accepted: a factor to SI')
    values = scale*column_values(:, 1)
    call source%close()
  contains
    subroutine refused(name, problem)
      character(*), intent(in) :: name, problem
      if (.not. allocated(error)) call fail(error, status_bad_input, scene%file//':'//text_of(load%line)//': '//group//'%'// &
                                            name//': '//problem)
    end subroutine refused
  end subroutine read_load

  real(dp) function factor_in_si(unit, group) result(factor)
    !! Return the factor of a unit to SI; 0 if unknown. A column without a unit is in SI.
    character(*), intent(in) :: unit, group
    if (group == 'force') then
      factor = force_factor(unit)
    else if (len_trim(unit) == 0) then
      factor = 1.0_dp
    else
      factor = factor_of(unit, 'acceleration')
    end if
  end function factor_in_si

  subroutine choose_columns(source, load, time, column, name, problem)
    !! Choose the columns that the scene names, or else the only possible ones.
    class(record_source), intent(in) :: source
    type(load_par), intent(in) :: load
    integer, intent(out) :: time, column           !! time 0: the sampling rate gives the times
    character(:), allocatable, intent(out) :: name, problem   !! of an input, if there is no column for it
    integer, allocatable :: others(:)
    integer :: i
    column = 0
    time = named_time(source%columns)
    if (allocated(load%time)) time = place_of(source, load%time)
    if (time == 0 .and. (allocated(load%time) .or. is_missing(load%sample_rate))) then
      name = 'time'
      problem = 'no such column in '//source%path//'; accepted: '//listed(source)//'; or sample_rate'
      return
    end if
    others = pack([(i, i=1, size(source%columns))], source%columns%is_numeric .and. [(i /= time, i=1, size(source%columns))])
    if (allocated(load%column)) then
      column = place_of(source, load%column)
      if (column > 0) column = merge(column, 0, source%columns(column)%is_numeric)
    else if (size(others) == 1) then
      column = others(1)
    end if
    if (column == 0 .and. allocated(load%column)) then
      name = 'column'
      problem = 'no such column of numbers in '//source%path//'; accepted: '//listed(source)
    else if (column == 0) then
      name = 'column'
      problem = 'is missing, and '//source%path//' has '//text_of(size(others))//' columns of numbers besides the time; '// &
        'accepted: '//listed(source)
    end if
    if (.not. is_missing(load%sample_rate)) time = 0
  end subroutine choose_columns

  integer function place_of(source, choice) result(place)
    !! Return the index of a column by name or number; 0: none.
    class(record_source), intent(in) :: source
    type(column_choice), intent(in) :: choice
    place = choice%number
    if (choice%name == '') then
      if (place > size(source%columns)) place = 0
      return
    end if
    do place = size(source%columns), 1, -1
      if (source%columns(place)%name == choice%name .or. bare_name(source%columns(place)%name) == choice%name) return
    end do
  end function place_of

end module bw_load_courses
