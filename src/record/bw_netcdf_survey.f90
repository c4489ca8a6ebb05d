module bw_netcdf_survey
  !! What is in a NetCDF file: the dimension of the samples, and the variables that have it. One process looks at the file and
  !! puts what it finds into texts, another makes columns of these.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_error, only: error_type, fail, status_bad_file
  use bw_files, only: look_at, path_state
  use bw_kinds, only: dp, i8
  use bw_missing, only: missing
  use bw_netcdf_reading, only: all_is_well, find_variable, is_classic, netcdf_dimension, netcdf_variable, open_netcdf, &
    read_dimensions, read_number, read_numbers, read_text, read_variable, status_text
  use bw_record, only: column_type
  use bw_record_source, only: record_source
  use bw_sensor_unit, only: quantity_of
  use bw_text, only: append, lower, string, text_builder, text_of
  use bw_time_column, only: mark_time
  implicit none (type, external)
  private
  public :: list_columns, survey

  character(*), parameter :: facts_form = '(3(i0,1x),2(l1,1x),4(es24.16e3,1x))'
  integer, parameter :: most_columns = 1000000       !! as many as a scene can number
  integer, parameter :: texts_each = 6               !! of a variable: name, unit, quantity, facts, places, what is odd about it
  character(*), parameter :: quantities = ' displacement velocity acceleration strain '
  character(*), parameter :: sample_names = ' time t sample samples index '

  type, public :: netcdf_column
    !! Where a column lies, and how its numbers are packed.
    integer :: variable = 0                          !! NetCDF's number
    integer :: rank = 1                              !! dimensions, 1 or 2
    integer :: place = 1                             !! along the dimension that is not that of the samples
    logical :: samples_first = .false.               !! samples vary fastest
    logical :: is_single = .false.                   !! of single precision
    real(dp) :: fills(2) = missing                   !! what stands where a number is missing
    real(dp) :: factor = 1.0_dp, offset = 0.0_dp     !! that CF packs numbers with
  end type netcdf_column

contains

  subroutine survey(path, texts, error)
    !! Look at a file. The first text is how many samples there are. The file is not closed: the process ends.
    !! **Errors**: `status_bad_file`, without the file's name.
    character(*), intent(in) :: path
    type(string), allocatable, intent(out) :: texts(:)
    type(error_type), allocatable, intent(inout) :: error
    type(netcdf_dimension), allocatable :: dimensions(:)
    type(netcdf_variable) :: variable
    type(string), allocatable :: found(:)
    integer(i8) :: columns, more
    real(dp) :: needed                               ! bytes
    integer :: file, samples, variables, v, last, status
    call open_netcdf(path, file, status)
    call read_dimensions(file, dimensions, variables, status)
    call check(status, error)
    samples = dimension_of_samples(dimensions)
    if (samples == 0) call refuse('has no samples', error)
    allocate (found(1 + texts_each*variables))
    last = 1
    columns = 0
    needed = 0.0_dp
    do v = 0, variables - 1
      if (allocated(error)) return
      call read_variable(file, v, variable, status)
      call check(status, error)
      if (allocated(error)) return
      needed = needed + bytes_of(variable, dimensions)
      if (.not. variable%is_numeric .or. .not. any(variable%dimensions == samples - 1)) cycle
      more = 1
      if (size(variable%dimensions) == 2) more = dimensions(1 + other_dimension(variable, samples - 1))%length
      columns = columns + more
      if (size(variable%dimensions) > 2) call refuse(variable%name//' has '//text_of(size(variable%dimensions))// &
        ' dimensions, as in a sweep; accepted: a record of one case', error)
      if (more < 1) call refuse(variable%name//' has no columns', error)
      if (columns > most_columns) call refuse('has '//text_of(columns)//' columns and more; accepted: up to '// &
        text_of(most_columns), error)
      call look_at_variable(file, v, variable, samples - 1, int(more), found(last + 1:last + texts_each), error)
      last = last + texts_each
    end do
    call check_length(path, file, needed, error)
    if (last == 1) call refuse('has no variable along the dimension of its samples', error)
    if (allocated(error)) return
    found(1)%text = text_of(dimensions(samples)%length)
    allocate (texts(last))
    do v = 1, last
      call move_alloc(found(v)%text, texts(v)%text)
    end do
  end subroutine survey

  pure real(dp) function bytes_of(variable, dimensions) result(bytes)
    !! The least that a variable takes in a file of a classic format, its attributes apart.
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

  subroutine check_length(path, file, needed, error)
    !! **Errors**: the end of a file of a classic format was cut off, for which the library would give zeros.
    character(*), intent(in) :: path
    integer, intent(in) :: file
    real(dp), intent(in) :: needed                   !! bytes
    type(error_type), allocatable, intent(inout) :: error
    type(path_state) :: state
    integer :: ignored
    if (allocated(error)) return
    if (.not. is_classic(file)) return
    ignored = look_at(path, state)
    if (real(state%bytes, dp) < needed) call fail(error, status_bad_file, 'is cut off: it has '//text_of(state%bytes)// &
                                                  ' bytes, and says that it has '//text_of(needed)//' at least')
  end subroutine check_length

  subroutine check(status, error)
    !! Turn a NetCDF status into an error. Keeps an error that is there.
    integer, intent(in) :: status
    type(error_type), allocatable, intent(inout) :: error
    if (status == all_is_well .or. allocated(error)) return
    call fail(error, status_bad_file, 'cannot be read: '//status_text(status))
  end subroutine check

  subroutine refuse(problem, error)
    !! Say what is wrong with the file. Keeps an error that is there.
    character(*), intent(in) :: problem
    type(error_type), allocatable, intent(inout) :: error
    if (.not. allocated(error)) call fail(error, status_bad_file, problem)
  end subroutine refuse

  pure integer function dimension_of_samples(dimensions) result(samples)
    !! The dimension called time, or the like; else the longest; 0 where that has no length.
    type(netcdf_dimension), intent(in) :: dimensions(:)
    integer :: d
    do samples = 1, size(dimensions)
      if (index(sample_names, ' '//lower(dimensions(samples)%name)//' ') > 0) exit
    end do
    if (samples > size(dimensions)) samples = maxloc([(dimensions(d)%length, d=1, size(dimensions))], dim=1)
    if (samples == 0) return
    if (dimensions(samples)%length == 0) samples = 0
  end function dimension_of_samples

  pure integer function other_dimension(variable, samples) result(other)
    !! The dimension of two that is not that of the samples.
    type(netcdf_variable), intent(in) :: variable
    integer, intent(in) :: samples
    other = variable%dimensions(1)
    if (other == samples) other = variable%dimensions(2)
  end function other_dimension

  subroutine look_at_variable(file, number, variable, samples, columns, texts, error)
    !! What a file says of a variable.
    integer, intent(in) :: file, number
    type(netcdf_variable), intent(in) :: variable
    integer, intent(in) :: samples                   !! NetCDF's number of their dimension
    integer, intent(in) :: columns
    type(string), intent(inout) :: texts(texts_each)
    type(error_type), allocatable, intent(inout) :: error
    type(netcdf_column) :: facts
    character(200) :: line
    integer :: rank, status
    if (allocated(error)) return
    status = all_is_well
    rank = size(variable%dimensions)
    facts = netcdf_column(number, rank, columns, variable%dimensions(rank) == samples, variable%is_single)
    texts(1)%text = variable%name
    call read_text(file, number, 'units', texts(2)%text, status)
    call read_text(file, number, 'quantity', texts(3)%text, status)
    call take_number('_FillValue', facts%fills(1))
    call take_number('missing_value', facts%fills(2))
    call take_number('scale_factor', facts%factor)
    call take_number('add_offset', facts%offset)
    where (.not. ieee_is_finite(facts%fills)) facts%fills = missing     ! what is not finite is missing anyway
    if (allocated(error)) return
    if (.not. (ieee_is_finite(facts%factor) .and. ieee_is_finite(facts%offset))) call fail(error, status_bad_file, &
      variable%name//': its scale_factor or add_offset is no finite number')
    write (line, facts_form) facts
    texts(4)%text = trim(line)
    call find_places(file, facts, variable%name, texts(5)%text, texts(6)%text, status)
    call check(status, error)
  contains
    subroutine take_number(name, value)
      character(*), intent(in) :: name
      real(dp), intent(inout) :: value
      integer(i8) :: there
      call read_number(file, number, name, value, there, status)
      if (there == 0 .or. there == 1 .or. allocated(error)) return
      call fail(error, status_bad_file, variable%name//': its attribute '//name//' is not one number')
    end subroutine take_number
  end subroutine look_at_variable

  subroutine find_places(file, facts, name, places, note, status)
    !! ξ of each column, by blanks: its variable's attribute `position`, or of two dimensions `point_position`; empty where neither
    !! says it. What is no such place is odd.
    integer, intent(in) :: file
    type(netcdf_column), intent(in) :: facts
    character(*), intent(in) :: name                 !! of the variable
    character(:), allocatable, intent(out) :: places, note
    integer, intent(inout) :: status
    type(netcdf_variable) :: points
    type(text_builder) :: lines
    real(dp), allocatable :: values(:)
    integer(i8) :: there
    integer :: c, problem
    allocate (values(facts%place), source=missing)
    call read_number(file, facts%variable, 'position', values(1), there, status)
    if (there == 1) values = values(1)
    c = -1
    if (there == 0 .and. facts%rank == 2) c = find_variable(file, 'point_position')
    if (c >= 0) then
      problem = status
      call read_variable(file, c, points, problem)
      if (problem == all_is_well) problem = merge(problem, 1, size(points%dimensions) == 1 .and. points%is_numeric)
      call read_numbers(file, c, [1_i8], [int(facts%place, i8)], values, problem)
      if (problem == all_is_well) there = 1
    end if
    note = ''
    if (there == 1) there = merge(1, -1, all(ieee_is_finite(values)))
    if (there == 1) there = merge(1, -1, all(values >= 0.0_dp .and. values <= 1.0_dp))
    if (there /= 0 .and. there /= 1) note = 'position: what the file says of '//name//' is no number from 0 to 1, and is not used'
    do c = 1, merge(facts%place, 0, there == 1)
      call lines%append(text_of(values(c))//' ')
    end do
    places = lines%text()
  end subroutine find_places

  pure subroutine list_columns(texts, source, of_column)
    !! The columns of a file, from what was found in it.
    type(string), intent(in) :: texts(:)
    class(record_source), intent(inout) :: source    !! gets all but its path
    type(netcdf_column), allocatable, intent(out) :: of_column(:)
    type(netcdf_column), allocatable :: facts(:)     ! of the variables; their place is how many columns they have
    type(column_type) :: column
    real(dp), allocatable :: places(:)
    integer :: v, c, first, last
    read (texts(1)%text, *) source%rows
    allocate (facts(size(texts)/texts_each))
    do v = 1, size(facts)
      read (texts(2 + texts_each*(v - 1) + 3)%text, *) facts(v)
    end do
    allocate (source%columns(sum(facts%place)), of_column(sum(facts%place)))
    last = 0
    do v = 1, size(facts)
      first = 2 + texts_each*(v - 1)
      call describe(texts(first:first + 2), column, source%is_labelled)
      if (allocated(places)) deallocate (places)
      allocate (places(facts(v)%place), source=missing)
      if (texts(first + 4)%text /= '') read (texts(first + 4)%text, *) places
      if (texts(first + 5)%text /= '') call append(source%notes, texts(first + 5)%text)
      do c = 1, facts(v)%place
        last = last + 1
        source%columns(last) = column
        if (facts(v)%rank == 2) source%columns(last)%name = column%name//'('//text_of(c)//')'
        source%columns(last)%position = places(c)
        of_column(last) = facts(v)
        of_column(last)%place = c
      end do
    end do
  end subroutine list_columns

  pure subroutine describe(texts, column, is_labelled)
    !! What the columns of a variable have in common.
    type(string), intent(in) :: texts(3)             !! its name, unit and quantity in the file
    type(column_type), intent(inout) :: column
    logical, intent(inout) :: is_labelled            !! the file says what some variables measure
    column%name = texts(1)%text
    column%unit = texts(2)%text
    column%quantity = texts(3)%text
    if (index(quantities, ' '//lower(column%name)//' ') > 0) column%quantity = lower(column%name)
    if (index(quantities, ' '//column%quantity//' ') == 0) column%quantity = ''
    if (column%quantity /= '') is_labelled = .true.
    if (column%quantity == '') column%quantity = quantity_of(column%unit)
    if (column%name == 'recorded') is_labelled = .true.  ! a result of a record: what was fitted to it is not measured
    if (column%name == 'fitted') column%quantity = ''
    call mark_time(column)
  end subroutine describe

end module bw_netcdf_survey
