module bw_netcdf_source
  !! A NetCDF file as a source of histories: every variable that has the dimension of the samples is a column, or several, one
  !! for each place of its other dimension, called `name(1)`, `name(2)`, … A result of beamwave is such a file.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input
  use bw_kinds, only: dp, i4, i8
  use bw_missing, only: is_missing, missing
  use bw_netcdf_path, only: has_backslash, plain_path
  use bw_record, only: column_type
  use bw_record_source, only: record_source
  use bw_sensor_unit, only: quantity_of
  use bw_text, only: lower, text_of
  use netcdf, only: nf90_char, nf90_close, nf90_float, nf90_get_att, nf90_get_var, nf90_inq_varid, nf90_inquire, &
    nf90_inquire_attribute, nf90_inquire_dimension, nf90_inquire_variable, nf90_max_name, nf90_max_var_dims, nf90_noerr, &
    nf90_nowrite, nf90_open, nf90_strerror, nf90_string
  use bw_time_column, only: mark_time
  implicit none (type, external)
  private

  integer, parameter :: block_size = 2**18           !! numbers of a variable in memory at a time
  character(*), parameter :: quantities = ' displacement velocity acceleration strain '
  character(*), parameter :: sample_names = ' time t sample samples index '

  type :: netcdf_column
    !! Where a column lies.
    integer :: variable = 0                          !! NetCDF's number
    integer :: dimensions = 1                        !! 1, or 2
    integer :: place = 1                             !! along the dimension that is not that of the samples
    logical :: samples_first = .false.               !! samples vary fastest
    logical :: is_single = .false.                   !! of single precision
  end type netcdf_column

  type, extends(record_source), public :: netcdf_source
    integer, private :: file = -1
    integer, private :: samples = 0                  !! NetCDF's number of their dimension
    integer(i8), private :: rows = 0
    type(netcdf_column), allocatable, private :: where(:)
  contains
    procedure :: open => open_netcdf
    procedure :: read_times
    procedure :: read_values
    procedure :: place_of_row
    procedure :: close => close_netcdf
    procedure, private :: check
    procedure, private :: find_samples
    procedure, private :: add_columns
    procedure, private :: describe_column
    procedure, private :: read_part
    procedure, private :: refuse_number
  end type netcdf_source

contains

  subroutine open_netcdf(self, path, error)
    !! Find the dimension of the samples, and the variables that have it.
    class(netcdf_source), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    integer :: variables, v
    self%path = path
    if (has_backslash(path)) then
      call fail(error, status_bad_input, path//': NetCDF takes a backslash for a slash; accepted: a path without')
      return
    end if
    call self%check(nf90_open(plain_path(path), nf90_nowrite, self%file), error)
    if (allocated(error)) return
    call self%find_samples(error)
    allocate (self%columns(0), self%where(0))
    variables = 0
    if (.not. allocated(error)) call self%check(nf90_inquire(self%file, nVariables=variables), error)
    do v = 1, variables
      if (.not. allocated(error)) call self%add_columns(v, error)
    end do
    if (size(self%columns) == 0 .and. .not. allocated(error)) call fail(error, status_bad_input, path// &
      ': has no variable along the dimension of its samples')
  end subroutine open_netcdf

  subroutine check(self, status, error)
    !! Turn a NetCDF status into an error that names the file. Keeps an error that is there.
    class(netcdf_source), intent(in) :: self
    integer, intent(in) :: status
    type(error_type), allocatable, intent(inout) :: error
    if (status == nf90_noerr .or. allocated(error)) return
    call fail(error, status_bad_file, self%path//': cannot be read: '//trim(nf90_strerror(status)))
  end subroutine check

  subroutine find_samples(self, error)
    !! The dimension called time, or the like; else the longest.
    class(netcdf_source), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    character(nf90_max_name) :: name
    integer :: dimensions, d, length
    logical :: known
    known = .false.
    self%rows = 0
    dimensions = 0
    call self%check(nf90_inquire(self%file, nDimensions=dimensions), error)
    do d = 1, dimensions
      if (allocated(error)) return
      call self%check(nf90_inquire_dimension(self%file, d, name, length), error)
      if (known .or. (length <= self%rows .and. index(sample_names, ' '//trim(lower(name))//' ') == 0)) cycle
      known = index(sample_names, ' '//trim(lower(name))//' ') > 0
      self%samples = d
      self%rows = length
    end do
    if (self%rows == 0 .and. .not. allocated(error)) call fail(error, status_bad_input, self%path//': has no samples')
  end subroutine find_samples

  subroutine add_columns(self, variable, error)
    !! The columns of a variable, if it has any. **Errors**: `status_bad_input` for a sweep, whose cases are no sensors.
    class(netcdf_source), intent(inout) :: self
    integer, intent(in) :: variable
    type(error_type), allocatable, intent(inout) :: error
    character(nf90_max_name) :: name, other
    integer :: ids(nf90_max_var_dims), rank, type, length, i
    type(netcdf_column) :: found
    call self%check(nf90_inquire_variable(self%file, variable, name, type, rank, ids), error)
    if (allocated(error)) return
    if (type == nf90_char .or. type == nf90_string .or. .not. any(ids(:rank) == self%samples)) return
    if (rank > 2) then
      call fail(error, status_bad_input, self%path//': '//trim(name)//' has '//text_of(rank)//' dimensions, as in a sweep; '// &
                'accepted: a record of one case')
      return
    end if
    found = netcdf_column(variable, rank, 1, ids(1) == self%samples, type == nf90_float)
    length = 1
    if (rank == 2) call self%check(nf90_inquire_dimension(self%file, merge(ids(2), ids(1), found%samples_first), other, length), &
                                   error)
    do i = 1, length
      found%place = i
      call self%describe_column(found, trim(name), length, error)
    end do
  end subroutine add_columns

  subroutine describe_column(self, found, name, length, error)
    !! One more column, with what the file says of it.
    class(netcdf_source), intent(inout) :: self
    type(netcdf_column), intent(in) :: found
    character(*), intent(in) :: name                 !! of its variable
    integer, intent(in) :: length                    !! columns of the variable
    type(error_type), allocatable, intent(inout) :: error
    type(column_type) :: column
    type(column_type), allocatable :: more(:)
    integer :: n
    column%name = name
    if (found%dimensions == 2) column%name = name//'('//text_of(found%place)//')'
    column%unit = text_attribute(self%file, found%variable, 'units')
    column%quantity = text_attribute(self%file, found%variable, 'quantity')
    if (index(quantities, ' '//lower(name)//' ') > 0) column%quantity = lower(name)
    if (index(quantities, ' '//column%quantity//' ') == 0) column%quantity = ''
    if (column%quantity /= '') self%is_labelled = .true.
    if (column%quantity == '') column%quantity = quantity_of(column%unit)
    if (name == 'recorded') self%is_labelled = .true.  ! a result of a record: what was fitted to it is not measured
    if (name == 'fitted') column%quantity = ''
    call mark_time(column)
    column%position = sensor_position(self%file, found)
    n = size(self%columns)
    allocate (more(n + 1))
    more(:n) = self%columns
    more(n + 1) = column
    call move_alloc(more, self%columns)
    self%where = [self%where, found]
    if (length < 1) call fail(error, status_bad_input, self%path//': '//name//' has no columns')
  end subroutine describe_column

  real(dp) function sensor_position(file, found) result(position)
    !! ξ of a column: its variable's attribute `position`, or of several columns `point_position`; else missing.
    integer, intent(in) :: file
    type(netcdf_column), intent(in) :: found
    integer :: points, status
    status = nf90_get_att(file, found%variable, 'position', position)
    if (status /= nf90_noerr .and. found%dimensions == 2) then
      status = nf90_inq_varid(file, 'point_position', points)
      if (status == nf90_noerr) status = nf90_get_var(file, points, position, [found%place])
    end if
    if (status /= nf90_noerr) position = missing
    if (.not. ieee_is_finite(position)) position = missing
    if (position < 0.0_dp .or. position > 1.0_dp) position = missing
  end function sensor_position

  function text_attribute(file, variable, name) result(text)
    !! An attribute of a variable; empty where it has none.
    integer, intent(in) :: file, variable
    character(*), intent(in) :: name
    character(:), allocatable :: text
    integer :: length, type
    text = ''
    if (nf90_inquire_attribute(file, variable, name, xtype=type, len=length) /= nf90_noerr) return
    if (type /= nf90_char) return
    text = repeat(' ', length)
    if (nf90_get_att(file, variable, name, text) /= nf90_noerr) text = ''
    text = trim(text)
  end function text_attribute

  subroutine read_times(self, column, rows, times, steps, error)
    !! All digits of the times are there: those of double or of single precision.
    class(netcdf_source), intent(inout) :: self
    integer, intent(in) :: column
    integer(i8), intent(out) :: rows
    real(dp), allocatable, intent(out) :: times(:), steps(:)
    type(error_type), allocatable, intent(inout) :: error
    real(dp), allocatable :: part(:, :)
    rows = self%rows
    allocate (times(merge(rows, 0_i8, column > 0)), steps(merge(rows, 0_i8, column > 0)))
    if (column == 0) return
    allocate (part(rows, 1))
    call self%read_values([column], 1_i8, part, error)
    if (allocated(error)) return
    times = part(:, 1)
    steps = 0.0_dp
    if (self%where(column)%is_single) steps = 4*real(spacing(real(times)), dp)
  end subroutine read_times

  subroutine read_values(self, columns, first, values, error)
    !! Column by column; of a variable in which the samples vary slowest, in blocks of all its columns.
    class(netcdf_source), intent(inout) :: self
    integer, intent(in) :: columns(:)
    integer(i8), intent(in) :: first
    real(dp), intent(inout) :: values(:, :)
    type(error_type), allocatable, intent(inout) :: error
    integer :: s, n, row, rows_at_once
    n = size(values, 1)
    do s = 1, size(columns)
      associate (here => self%where(columns(s)))
        if (here%dimensions == 2 .and. .not. here%samples_first) cycle
        call self%read_part(here, int(first), values(:, s), error)
      end associate
    end do
    rows_at_once = max(1, block_size/max(1, size(columns)))
    do row = 1, n, rows_at_once                      ! so that a chunk of the file is unpacked once for all its columns
      do s = 1, size(columns)
        associate (here => self%where(columns(s)))
          if (here%dimensions == 1 .or. here%samples_first) cycle
          call self%read_part(here, int(first) + row - 1, values(row:min(n, row + rows_at_once - 1), s), error)
        end associate
      end do
    end do
    do s = 1, size(columns)
      if (.not. allocated(error)) call self%refuse_number(columns(s), first, values(:, s), error)
    end do
  end subroutine read_values

  subroutine read_part(self, here, first, values, error)
    !! Some samples of one column, unpacked as CF says.
    class(netcdf_source), intent(in) :: self
    type(netcdf_column), intent(in) :: here
    integer, intent(in) :: first
    real(dp), intent(inout) :: values(:)
    type(error_type), allocatable, intent(inout) :: error
    real(dp) :: fill, factor, offset
    logical :: filled
    if (allocated(error)) return
    if (here%dimensions == 1) then
      call self%check(nf90_get_var(self%file, here%variable, values, [first], [size(values)]), error)
    else if (here%samples_first) then
      call self%check(nf90_get_var(self%file, here%variable, values, [first, here%place], [size(values), 1]), error)
    else
      call self%check(nf90_get_var(self%file, here%variable, values, [here%place, first], [1, size(values)]), error)
    end if
    filled = nf90_get_att(self%file, here%variable, '_FillValue', fill) == nf90_noerr
    if (.not. filled) fill = missing
    where (values == fill) values = missing
    if (nf90_get_att(self%file, here%variable, 'scale_factor', factor) /= nf90_noerr) factor = 1.0_dp
    if (nf90_get_att(self%file, here%variable, 'add_offset', offset) /= nf90_noerr) offset = 0.0_dp
    if (factor == 1.0_dp .and. offset == 0.0_dp) return
    where (values /= missing) values = factor*values + offset
  end subroutine read_part

  subroutine refuse_number(self, column, first, values, error)
    !! Say where a number is missing, or is none. **Errors**: `status_bad_input`.
    class(netcdf_source), intent(in) :: self
    integer, intent(in) :: column
    integer(i8), intent(in) :: first
    real(dp), intent(in) :: values(:)
    type(error_type), allocatable, intent(inout) :: error
    integer(i8) :: j
    do j = 1, size(values, kind=i8)
      if (ieee_is_finite(values(j)) .and. .not. is_missing(values(j))) cycle
      call fail(error, status_bad_input, self%path//': '//self%columns(column)%name//': sample '//text_of(first + j - 1)// &
                ' is missing or no finite number; accepted: a record without gaps; cut such samples off by start and end')
      return
    end do
  end subroutine refuse_number

  function place_of_row(self, row) result(place)
    !! The number of a sample, for a message.
    class(netcdf_source), intent(inout) :: self
    integer(i8), intent(in) :: row
    character(:), allocatable :: place
    place = self%path//': sample '//text_of(row)
  end function place_of_row

  subroutine close_netcdf(self)
    !! Close the file.
    class(netcdf_source), intent(inout) :: self
    integer :: ignored
    if (self%file >= 0) ignored = nf90_close(self%file)
    self%file = -1
  end subroutine close_netcdf

end module bw_netcdf_source
