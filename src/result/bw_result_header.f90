module bw_result_header
  !! What a result file says before its first case: global attributes, coordinates, and the inputs.
  use bw_kinds, only: dp, i4
  use bw_amplitude_spectrum, only: frequency_axis
  use bw_error, only: error_type
  use bw_late_values, only: late_values
  use bw_netcdf, only: check, define_variable, put_words
  use bw_result_layout, only: result_layout, has_dimension, dimension_length
  use bw_scene, only: effect_names, method_name, scene_type
  use bw_scene_cases, only: case_count, times_in_a_row
  use bw_scene_resolved, only: numeric_input, numeric_inputs, resolved_text, values_of_sweep
  use bw_stopwatch, only: stage_count, stage_words
  use bw_time_grid, only: sample_times
  use bw_version, only: program_commit, program_compiler, program_libraries, program_native, program_version
  use netcdf, only: nf90_double, nf90_global, nf90_inq_dimid, nf90_int, nf90_put_att
  implicit none (type, external)
  private
  public :: put_global_attributes, put_coordinates, put_inputs, swept_names, source_text

contains

  pure function source_text() result(text)
    !! The program, its version and its commit.
    character(:), allocatable :: text
    text = 'beamwave '//program_version//' ('//program_commit//')'
  end function source_text

  subroutine put_global_attributes(file, path, scene, error, study)
    !! What the file says of itself: scene, program, method. **Errors**: `status_bad_file`.
    integer, intent(in) :: file
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    type(error_type), allocatable, intent(inout) :: error
    character(*), intent(in), optional :: study   !! the study whose result it is; absent: a run's
    integer(i4), parameter :: format_version = 1
    character(:), allocatable :: command
    command = 'run'
    if (present(study)) command = study
    call put('Conventions', 'CF-1.11')
    call check(nf90_put_att(file, nf90_global, 'format_version', format_version), path, error)
    call put('title', scene%header%title)
    call put('source', source_text())
    call put('created', time_stamp())
    call put('history', time_stamp()//': beamwave '//command//' '//scene%file)
    if (present(study)) call put('study', study)
    call put('scene', resolved_text(scene))
    call put('effects', effect_names(scene))
    call put('method', method_name(scene))
    call put('notes', '')
    call put('compiler', program_compiler//merge(', tuned for its processor', repeat(' ', 25), program_native))
    call put('libraries', program_libraries)
  contains
    subroutine put(name, text)
      character(*), intent(in) :: name, text
      call check(nf90_put_att(file, nf90_global, name, trim(text)), path, error)
    end subroutine put
  end subroutine put_global_attributes

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

  subroutine put_coordinates(file, path, scene, layout, late, error)
    !! Coordinate variables, which are known before any case is run. **Errors**: `status_bad_file`.
    integer, intent(in) :: file
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    type(result_layout), intent(in) :: layout
    type(late_values), intent(inout) :: late
    type(error_type), allocatable, intent(inout) :: error
    integer :: j
    call put_numbers(file, path, layout, 'case', 'number of the case', late, error)
    call put_numbers(file, path, layout, 'mode', 'mode number k', late, error)
    call put_numbers(file, path, layout, 'mode_before', 'mode number k before the capture', late, error)
    call put_numbers(file, path, layout, 'event', 'number of the event', late, error)
    call put_numbers(file, path, layout, 'peak', 'number of the measured peak, by frequency', late, error)
    call put_stages(file, path, late, error)
    if (has_dimension(layout, 'profile')) call put_axis(file, path, 'profile_position', 'profile', '1', &
      'place along the beam, x/l', [(real(j, dp)/(layout%profile - 1), j=0, layout%profile - 1)], late, error)
    if (.not. has_dimension(layout, 'time')) return
    call put_axis(file, path, 'point_position', 'point', '1', 'place along the beam, x/l', scene%response%points, late, error)
    call put_axis(file, path, 'time', 'time', 's', 'time since the impact', &
                  sample_times(scene%response%duration, scene%response%samples), late, error)
    if (has_dimension(layout, 'frequency')) call put_axis(file, path, 'frequency', 'frequency', 'Hz', 'frequency', &
      frequency_axis(scene%response%samples, scene%response%duration), late, error)
  end subroutine put_coordinates

  subroutine put_numbers(file, path, layout, name, long_name, late, error)
    !! A coordinate that counts from 1.
    integer, intent(in) :: file
    character(*), intent(in) :: path
    type(result_layout), intent(in) :: layout
    character(*), intent(in) :: name, long_name
    type(late_values), intent(inout) :: late
    type(error_type), allocatable, intent(inout) :: error
    integer :: dimension, variable
    if (.not. has_dimension(layout, name) .or. allocated(error)) return
    call check(nf90_inq_dimid(file, name, dimension), path, error)
    call define_variable(file, path, name, nf90_int, [dimension], '1', long_name, variable, error)
    if (allocated(error)) return
    call late%add_numbers(variable, dimension_length(layout, name))
  end subroutine put_numbers

  subroutine put_stages(file, path, late, error)
    integer, intent(in) :: file
    character(*), intent(in) :: path
    type(late_values), intent(inout) :: late
    type(error_type), allocatable, intent(inout) :: error
    integer :: dimension, variable, i
    call check(nf90_inq_dimid(file, 'stage', dimension), path, error)
    if (allocated(error)) return
    call define_variable(file, path, 'stage', nf90_int, [dimension], '1', 'stage of the work', variable, error)
    if (allocated(error)) return
    call put_words(file, path, variable, stage_words, 1, error)
    call late%add(variable, [(real(i, dp), i=1, stage_count)])
  end subroutine put_stages

  subroutine put_axis(file, path, name, dimension_name, units, long_name, values, late, error)
    integer, intent(in) :: file
    character(*), intent(in) :: path, name, dimension_name, units, long_name
    real(dp), intent(in) :: values(:)
    type(late_values), intent(inout) :: late
    type(error_type), allocatable, intent(inout) :: error
    integer :: dimension, variable
    if (allocated(error)) return
    call check(nf90_inq_dimid(file, dimension_name, dimension), path, error)
    call define_variable(file, path, name, nf90_double, [dimension], units, long_name, variable, error, coordinate=.true.)
    if (allocated(error)) return
    call late%add(variable, values)
  end subroutine put_axis

  pure function swept_names(scene) result(names)
    !! Variables of the swept inputs, by spaces.
    type(scene_type), intent(in) :: scene
    character(:), allocatable :: names
    type(numeric_input), allocatable :: inputs(:)
    integer :: i
    names = ''
    inputs = numeric_inputs(scene)
    do i = 1, size(inputs)
      if (inputs(i)%is_swept) names = names//' '//input_variable(inputs(i))
    end do
    names = trim(adjustl(names))
  end function swept_names

  pure function input_variable(input) result(name)
    type(numeric_input), intent(in) :: input
    character(:), allocatable :: name
    name = trim(input%group)//'_'//trim(input%name)
  end function input_variable

  subroutine put_inputs(file, path, scene, late, error)
    !! Every number of the resolved scene, scalar or (case).
    integer, intent(in) :: file
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    type(late_values), intent(inout) :: late
    type(error_type), allocatable, intent(inout) :: error
    type(numeric_input), allocatable :: inputs(:)
    integer :: i
    inputs = numeric_inputs(scene)
    do i = 1, size(inputs)
      if (allocated(error)) return
      call put_input(file, path, scene, inputs(i), late, error)
    end do
  end subroutine put_inputs

  subroutine put_input(file, path, scene, input, late, error)
    integer, intent(in) :: file
    character(*), intent(in) :: path
    type(scene_type), intent(in) :: scene
    type(numeric_input), intent(in) :: input
    type(late_values), intent(inout) :: late
    type(error_type), allocatable, intent(inout) :: error
    integer, allocatable :: dimensions(:)
    integer :: variable, kind
    kind = merge(nf90_int, nf90_double, input%is_integer)
    allocate (dimensions(merge(1, 0, input%is_swept)))
    if (input%is_swept) call check(nf90_inq_dimid(file, 'case', dimensions(1)), path, error)
    call define_variable(file, path, input_variable(input), kind, dimensions, trim(input%unit), input%meaning, variable, &
                         error, coordinate=.true.)
    if (allocated(error)) return
    if (input%is_swept) then
      call late%add_repeated(variable, values_of_sweep(scene, input), times_in_a_row(scene, input%sweep), &
                             int(case_count(scene)))
    else
      call late%add(variable, [input%value], is_scalar=.true.)
    end if
  end subroutine put_input

end module bw_result_header
