module bw_netcdf_survey
  !! The contents of a NetCDF file: the dimension of the samples, and the variables that have it, each one or several columns.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_error, only: error_type, fail, status_bad_file
  use bw_files, only: look_at, path_state
  use bw_kinds, only: dp, i8
  use bw_missing, only: missing
  use bw_netcdf_reading, only: all_is_well, close_netcdf, find_variable, is_classic, netcdf_dimension, netcdf_variable, &
    open_netcdf, read_dimensions, read_number, read_numbers, read_text, read_variable, status_text
  use bw_record, only: column_type
  use bw_record_source, only: record_source
  use bw_sensor_unit, only: quantity_of
  use bw_text, only: append, lower, string, text_of
  use bw_time_column, only: mark_time
  implicit none (type, external)
  private
  public :: survey

  integer, parameter :: most_columns = 1000000       !! largest number that a scene can give
  character(*), parameter :: quantities = ' displacement velocity acceleration strain '
  character(*), parameter :: sample_names = ' time t sample samples index '

  type, public :: netcdf_column
    !! The place of a column, and the packing of its numbers.
    integer :: variable = 0                          !! NetCDF's number of it
    integer :: rank = 1                              !! number of dimensions, 1 or 2
    integer :: place = 1                             !! index along the dimension other than that of the samples
    logical :: samples_first = .false.               !! samples vary fastest
    logical :: is_single = .false.                   !! numbers in single precision
    real(dp) :: fills(2) = missing                   !! values that mark missing numbers
    real(dp) :: factor = 1.0_dp, offset = 0.0_dp     !! packing by the CF conventions
  end type netcdf_column

contains

  subroutine survey(path, source, of_column, error)
    !! Find the columns of a file.
    !! **Errors**: `status_bad_file`, without the file's name.
    character(*), intent(in) :: path
    class(record_source), intent(inout) :: source    !! receives everything but its path
    type(netcdf_column), allocatable, intent(out) :: of_column(:)
    type(error_type), allocatable, intent(inout) :: error
    type(netcdf_dimension), allocatable :: dimensions(:)
    type(netcdf_variable), allocatable :: variables(:)
    integer(i8), allocatable :: widths(:)            ! columns of each variable
    integer :: file, samples, v, first, status
    call open_netcdf(path, file, status)
    call read_dimensions(file, dimensions, variables, status)
    do v = 1, size(variables)
      call read_variable(file, v - 1, variables(v), status)
    end do
    call check(status, error)
    samples = dimension_of_samples(dimensions)
    if (samples == 0) call refuse('has no samples; variables in groups are not read', error)
    allocate (widths(size(variables)), source=0_i8)
    do v = 1, size(variables)
      if (allocated(error)) exit
      widths(v) = columns_of(variables(v), dimensions, samples)
      if (size(variables(v)%dimensions) > 2 .and. widths(v) > 0) call refuse(variables(v)%name//' has '// &
        text_of(size(variables(v)%dimensions))//' dimensions, as in a sweep; accepted: a record of one case', error)
      if (widths(v) < 0) call refuse(variables(v)%name//' has no columns', error)
      if (sum(widths) > most_columns) call refuse('has '//text_of(sum(widths))//' columns and more; accepted: up to '// &
        text_of(most_columns), error)
    end do
    call check_length(path, file, variables, dimensions, error)
    if (all(widths == 0)) call refuse('has no variable along the dimension of its samples', error)
    if (.not. allocated(error)) then
      source%rows = dimensions(samples)%length
      allocate (source%columns(sum(widths)), of_column(sum(widths)))
      first = 1
      do v = 1, size(variables)
        if (widths(v) == 0 .or. allocated(error)) cycle
        associate (last => first + int(widths(v)) - 1)
          call look_at_variable(file, v - 1, variables(v), samples - 1, source, source%columns(first:last), of_column(first:last), &
                                error)
          first = last + 1
        end associate
      end do
    end if
    call close_netcdf(file)
  end subroutine survey

  pure integer(i8) function columns_of(variable, dimensions, samples) result(columns)
    !! Count the columns of a variable: 0 without the dimension of the samples; negative if its other dimension has length 0.
    type(netcdf_variable), intent(in) :: variable
    type(netcdf_dimension), intent(in) :: dimensions(:)
    integer, intent(in) :: samples                   !! number of the dimension of the samples, from 1
    columns = 0
    if (.not. (variable%is_numeric .and. any(variable%dimensions == samples - 1))) return
    columns = 1
    if (size(variable%dimensions) /= 2) return
    columns = dimensions(1 + merge(variable%dimensions(2), variable%dimensions(1), variable%dimensions(1) == samples - 1))%length
    if (columns == 0) columns = -1
  end function columns_of

  pure real(dp) function bytes_of(variable, dimensions) result(bytes)
    !! Return the least size of a variable in a file of a classic format, without its attributes, bytes.
    type(netcdf_variable), intent(in) :: variable
    type(netcdf_dimension), intent(in) :: dimensions(:)
    integer, parameter :: head = 28
    integer :: d
    bytes = variable%bytes
    do d = 1, size(variable%dimensions)
      bytes = bytes*real(dimensions(1 + variable%dimensions(d))%length, dp)
    end do
    bytes = bytes + head + len(variable%name) + 4*size(variable%dimensions)
  end function bytes_of

  subroutine check_length(path, file, variables, dimensions, error)
    !! Check that a file of a classic format is complete: in place of a missing end the library returns zeros.
    character(*), intent(in) :: path
    integer, intent(in) :: file
    type(netcdf_variable), intent(in) :: variables(:)
    type(netcdf_dimension), intent(in) :: dimensions(:)
    type(error_type), allocatable, intent(inout) :: error
    type(path_state) :: state
    real(dp) :: needed                               ! bytes
    integer :: v, ignored
    if (allocated(error)) return
    if (.not. is_classic(file)) return
    ignored = look_at(path, state)
    needed = sum([(bytes_of(variables(v), dimensions), v=1, size(variables))])
    if (real(state%bytes, dp) < needed) call fail(error, status_bad_file, 'is cut off: it has '//text_of(state%bytes)// &
                                                  ' bytes, and its header requires '//text_of(needed)//' at least')
  end subroutine check_length

  subroutine check(status, error)
    !! Turn a NetCDF status into an error, unless there is one already.
    integer, intent(in) :: status
    type(error_type), allocatable, intent(inout) :: error
    if (status == all_is_well .or. allocated(error)) return
    call fail(error, status_bad_file, 'cannot be read: '//status_text(status))
  end subroutine check

  subroutine refuse(problem, error)
    !! Report what is wrong with the file, unless there is an error already.
    character(*), intent(in) :: problem
    type(error_type), allocatable, intent(inout) :: error
    if (.not. allocated(error)) call fail(error, status_bad_file, problem)
  end subroutine refuse

  pure integer function dimension_of_samples(dimensions) result(samples)
    !! Return the dimension called time or similarly, else the longest; 0 if its length is 0.
    type(netcdf_dimension), intent(in) :: dimensions(:)
    integer :: d
    do samples = 1, size(dimensions)
      if (index(sample_names, ' '//lower(dimensions(samples)%name)//' ') > 0) exit
    end do
    if (samples > size(dimensions)) samples = maxloc([(dimensions(d)%length, d=1, size(dimensions))], dim=1)
    if (samples == 0) return
    if (dimensions(samples)%length == 0) samples = 0
  end function dimension_of_samples

  subroutine look_at_variable(file, number, variable, samples, source, columns, of_column, error)
    !! Read the attributes of a variable and describe its columns.
    integer, intent(in) :: file, number
    type(netcdf_variable), intent(in) :: variable
    integer, intent(in) :: samples                   !! NetCDF's number of their dimension
    class(record_source), intent(inout) :: source    !! receives notes on invalid attributes
    type(column_type), intent(inout) :: columns(:)
    type(netcdf_column), intent(inout) :: of_column(:)
    type(error_type), allocatable, intent(inout) :: error
    type(column_type) :: column
    type(netcdf_column) :: facts
    real(dp) :: places(size(columns))
    integer :: rank, status, c
    status = all_is_well
    rank = size(variable%dimensions)
    facts = netcdf_column(number, rank, 1, variable%dimensions(rank) == samples, variable%is_single)
    column%name = variable%name
    call read_text(file, number, 'units', column%unit, status)
    call read_text(file, number, 'quantity', column%quantity, status)
    call take_number('_FillValue', facts%fills(1))
    call take_number('missing_value', facts%fills(2))
    call take_number('scale_factor', facts%factor)
    call take_number('add_offset', facts%offset)
    where (.not. ieee_is_finite(facts%fills)) facts%fills = missing     ! numbers that are not finite are missing in any case
    if (.not. (ieee_is_finite(facts%factor) .and. ieee_is_finite(facts%offset))) &
      call refuse(variable%name//': its scale_factor or add_offset is not a finite number', error)
    if (allocated(error)) return
    call describe(column, source%is_labelled)
    call find_places(file, facts, column%name, places, source%notes, status)
    call check(status, error)
    do c = 1, size(columns)
      columns(c) = column
      if (rank == 2) columns(c)%name = column%name//'('//text_of(c)//')'
      columns(c)%position = places(c)
      of_column(c) = facts
      of_column(c)%place = c
    end do
  contains
    subroutine take_number(name, value)
      character(*), intent(in) :: name
      real(dp), intent(inout) :: value
      integer(i8) :: there
      call read_number(file, number, name, value, there, status)
      if (there /= 0 .and. there /= 1) call refuse(variable%name//': its attribute '//name//' is not a single number', error)
    end subroutine take_number
  end subroutine look_at_variable

  subroutine find_places(file, facts, name, places, notes, status)
    !! Find ξ of each column: attribute `position` or, with two dimensions, variable `point_position`. Invalid places are noted.
    integer, intent(in) :: file
    type(netcdf_column), intent(in) :: facts
    character(*), intent(in) :: name                 !! of the variable
    real(dp), intent(out) :: places(:)               !! missing if neither gives it
    type(string), allocatable, intent(inout) :: notes(:)
    integer, intent(inout) :: status
    type(netcdf_variable) :: points
    integer(i8) :: there
    integer :: v, problem
    places = missing
    call read_number(file, facts%variable, 'position', places(1), there, status)
    if (there == 1) places = places(1)
    v = -1
    if (there == 0 .and. facts%rank == 2) v = find_variable(file, 'point_position')
    if (v >= 0) then
      problem = status
      call read_variable(file, v, points, problem)
      if (problem == all_is_well) problem = merge(problem, 1, size(points%dimensions) == 1 .and. points%is_numeric)
      call read_numbers(file, v, [1_i8], [size(places, kind=i8)], places, problem)
      if (problem == all_is_well) there = 1
    end if
    if (there == 1) there = merge(1, -1, all(ieee_is_finite(places)))
    if (there == 1) there = merge(1, -1, all(places >= 0.0_dp .and. places <= 1.0_dp))
    if (there /= 1) places = missing
    if (there /= 0 .and. there /= 1) call append(notes, 'position: the value that the file gives for '//name// &
                                                 ' is not a number from 0 to 1, and is ignored')
  end subroutine find_places

  pure subroutine describe(column, is_labelled)
    !! Find what the columns of a variable measure.
    type(column_type), intent(inout) :: column       !! with its name, unit and quantity in the file
    logical, intent(inout) :: is_labelled            !! the file gives the quantities of some variables
    if (index(quantities, ' '//lower(column%name)//' ') > 0) column%quantity = lower(column%name)
    if (index(quantities, ' '//column%quantity//' ') == 0) column%quantity = ''
    if (column%quantity /= '') is_labelled = .true.
    if (column%quantity == '') column%quantity = quantity_of(column%unit)
    if (column%name == 'recorded') is_labelled = .true.  ! result of a record: fitted histories are not measured
    if (column%name == 'fitted') column%quantity = ''
    call mark_time(column)
  end subroutine describe

end module bw_netcdf_survey
