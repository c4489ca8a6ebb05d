module bw_result_definition
  !! The dimensions and variables of a result file that are filled case by case.
  use bw_case_result, only: case_words
  use bw_error, only: error_type
  use bw_event, only: event_words
  use bw_netcdf, only: check, define_variable, put_words
  use bw_result_layout, only: result_layout, dimension_length, has_dimension
  use bw_result_table, only: is_held, variable_row, variable_table
  use bw_stopwatch, only: stage_count
  use netcdf, only: nf90_def_dim, nf90_double, nf90_inq_dimid, nf90_int, nf90_put_att
  implicit none (type, external)
  private
  public :: define_dimensions, define_variables

  type, public :: open_file
    !! A result file under definition.
    integer :: id = 0                             !! NetCDF's
    character(:), allocatable :: path
    type(result_layout) :: layout
    character(:), allocatable :: swept            !! variables of swept inputs, by spaces
  end type open_file

  character(*), parameter :: dimension_names(*) = &
    [character(12) :: 'case', 'mode', 'mode_before', 'profile', 'event', 'point', 'time', 'frequency', 'peak']

contains

  subroutine define_dimensions(file, error)
    !! Those that the result has, by the layout.
    type(open_file), intent(in) :: file
    type(error_type), allocatable, intent(inout) :: error
    integer :: dimension, length, i
    do i = 1, size(dimension_names)
      length = dimension_length(file%layout, dimension_names(i))
      if (length > 0) call check(nf90_def_dim(file%id, trim(dimension_names(i)), length, dimension), file%path, error)
    end do
    call check(nf90_def_dim(file%id, 'stage', stage_count, dimension), file%path, error)
  end subroutine define_dimensions

  subroutine define_variables(file, error)
    !! Every variable of the layout, with its attributes. **Errors**: `status_bad_file`.
    type(open_file), intent(in) :: file
    type(error_type), allocatable, intent(inout) :: error
    type(variable_row), allocatable :: table(:)
    integer :: i, variable
    table = variable_table()
    do i = 1, size(table)
      if (.not. is_held(file%layout, table(i))) cycle
      associate (row => table(i))
        call define(file, trim(row%name), trim(row%dimensions), nf90_double, trim(row%units), row%long_name, variable, error)
        if (row%references /= '') then
          call check(nf90_put_att(file%id, variable, 'references', trim(row%references)), file%path, error)
        end if
      end associate
    end do
    call define_histories(file, error)
    call define_numbers(file, error)
    call define_variable(file%id, file%path, 'stage_seconds', nf90_double, [dimension_of(file, 'stage')], 's', &
                         'wall time of the stage over all cases', variable, error)
  end subroutine define_variables

  subroutine define_histories(file, error)
    !! The large arrays.
    type(open_file), intent(in) :: file
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable
    if (.not. has_dimension(file%layout, 'time')) return
    call define(file, 'displacement', 'point time', nf90_double, 'm', 'transverse displacement in the rotating frame', &
                variable, error)
    call check(nf90_put_att(file%id, variable, 'references', 'Eqs 4, 13 and 29'), file%path, error)
    if (file%layout%velocity) call define(file, 'velocity', 'point time', nf90_double, 'm s-1', &
                                          'transverse velocity in the rotating frame', variable, error)
    if (has_dimension(file%layout, 'frequency')) then
      call define(file, 'amplitude', 'point frequency', nf90_double, 'm', &
                  'one-sided amplitude spectrum of the displacement', variable, error)
    end if
  end subroutine define_histories

  subroutine define_numbers(file, error)
    !! Counts, states and kinds.
    type(open_file), intent(in) :: file
    type(error_type), allocatable, intent(inout) :: error
    integer :: variable
    call define(file, 'mode_count', '', nf90_int, '1', 'number of modes', variable, error)
    if (has_dimension(file%layout, 'peak')) then
      call define(file, 'peak_count', '', nf90_int, '1', 'number of measured peaks', variable, error)
    end if
    call define(file, 'case_status', '', nf90_int, '1', 'how the case ended', variable, error)
    call put_words(file%id, file%path, variable, case_words, 0, error)
    if (.not. has_dimension(file%layout, 'event')) return
    call define(file, 'event_kind', 'event', nf90_int, '1', 'kind of the event', variable, error)
    call put_words(file%id, file%path, variable, event_words, 0, error)
  end subroutine define_numbers

  subroutine define(file, name, dimensions, kind, units, long_name, variable, error)
    !! One variable over its own dimensions (in the file's order, by spaces) with `case` leading in a sweep.
    type(open_file), intent(in) :: file
    character(*), intent(in) :: name, dimensions, units, long_name
    integer, intent(in) :: kind
    integer, intent(out) :: variable
    type(error_type), allocatable, intent(inout) :: error
    integer, allocatable :: ids(:)
    character(:), allocatable :: coordinates
    integer :: gap
    gap = index(dimensions, ' ')
    if (dimensions == '') then
      allocate (ids(0))
    else if (gap == 0) then
      ids = [dimension_of(file, dimensions)]
    else
      ids = [dimension_of(file, dimensions(gap + 1:)), dimension_of(file, dimensions(:gap - 1))]
    end if
    if (has_dimension(file%layout, 'case')) ids = [ids, dimension_of(file, 'case')]
    call define_variable(file%id, file%path, name, kind, ids, units, long_name, variable, error)
    coordinates = trim(adjustl(file%swept//position_of(dimensions)))
    if (coordinates /= '') call check(nf90_put_att(file%id, variable, 'coordinates', coordinates), file%path, error)
  end subroutine define

  pure function position_of(dimensions) result(name)
    !! The places along the beam that belong to a variable's dimensions.
    character(*), intent(in) :: dimensions
    character(:), allocatable :: name
    name = ''
    if (index(dimensions, 'point') == 1) name = ' point_position'
    if (dimensions == 'profile') name = ' profile_position'
  end function position_of

  integer function dimension_of(file, name) result(id)
    type(open_file), intent(in) :: file
    character(*), intent(in) :: name
    integer :: status
    status = nf90_inq_dimid(file%id, name, id)
  end function dimension_of

end module bw_result_definition
