module bw_netcdf_source
  !! A NetCDF file as a source of histories: every variable with the dimension of the samples gives one column or, with a second
  !! dimension, one column for each place along it, called `name(1)`, `name(2)`, … Results of beamwave are such files.
  !! The file is open only while it is read.
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use bw_error, only: error_type, fail, status_bad_file, status_bad_input
  use bw_kinds, only: dp, i8
  use bw_missing, only: missing
  use bw_netcdf_path, only: has_backslash
  use bw_netcdf_reading, only: all_is_well, end_reading => close_netcdf, open_to_read => open_netcdf, read_numbers, status_text
  use bw_netcdf_survey, only: netcdf_column, survey
  use bw_record_source, only: record_source
  use bw_text, only: text_of
  implicit none (type, external)
  private

  integer, parameter :: block_size = 2**20           !! numbers of a variable held in memory at a time

  type, extends(record_source), public :: netcdf_source
    type(netcdf_column), allocatable, private :: where(:)
  contains
    procedure :: open => open_netcdf
    procedure :: read_times
    procedure :: read_values
    procedure :: place_of_row
    procedure :: close => close_netcdf
    procedure, private :: take_rows
  end type netcdf_source

  type :: row_block
    !! Rows and columns of one variable that one call of the library reads.
    integer :: first_column = 0, last_column = 0     !! in the list of requested columns
    integer(i8) :: first_row = 0, last_row = 0
  end type row_block

contains

  subroutine open_netcdf(self, path, error)
    !! Find the dimension of the samples, and the variables that have it.
    class(netcdf_source), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    self%path = path
    if (has_backslash(path)) then
      call fail(error, status_bad_input, path//': NetCDF reads a backslash as a slash; accepted: a path without backslashes')
      return
    end if
    call survey(path, self, self%where, error)
    if (allocated(error)) error%message = path//': '//error%message
  end subroutine open_netcdf

  subroutine read_times(self, column, rows, times, steps, error)
    !! Read the times, which have all digits of double or single precision.
    class(netcdf_source), intent(inout) :: self
    integer, intent(in) :: column
    integer(i8), intent(out) :: rows
    real(dp), allocatable, intent(out) :: times(:), steps(:)
    type(error_type), allocatable, intent(inout) :: error
    integer :: refused
    rows = self%rows
    allocate (times(merge(rows, 0_i8, column > 0)), steps(merge(rows, 0_i8, column > 0)), stat=refused)
    if (refused /= 0) call fail(error, status_bad_file, self%path//': not enough memory for '//text_of(rows)//' times')
    if (column == 0 .or. allocated(error)) return
    call self%take_rows([column], 1_i8, rows, times, error)
    steps = 0.0_dp
    if (self%where(column)%is_single .or. were_single()) steps = 4*real(spacing(real(times)), dp)

  contains

    pure logical function were_single()
      !! Whether times in double precision have been in single precision before.
      were_single = all(abs(times) < huge(1.0))
      if (were_single) were_single = all(abs(times - real(times)) <= 0)
    end function were_single

  end subroutine read_times

  subroutine read_values(self, columns, first, values, error)
    !! Read values in blocks: column by column, or all columns of a variable in which the samples vary slowest.
    class(netcdf_source), intent(inout) :: self
    integer, intent(in) :: columns(:)
    integer(i8), intent(in) :: first
    real(dp), intent(inout), contiguous :: values(:, :)
    type(error_type), allocatable, intent(inout) :: error
    integer(i8) :: rows
    rows = size(values, 1, kind=i8)
    call self%take_rows(columns, first, rows, values, error)
  end subroutine read_values

  subroutine take_rows(self, columns, first, rows, values, error)
    !! Read numbers, block by block.
    class(netcdf_source), intent(in) :: self
    integer, intent(in) :: columns(:)
    integer(i8), intent(in) :: first                 !! row
    integer(i8), intent(in) :: rows
    real(dp), intent(inout) :: values(rows, *)       !! (rows, columns)
    type(error_type), allocatable, intent(inout) :: error
    type(row_block), allocatable :: blocks(:)
    real(dp), allocatable :: found(:, :)
    integer :: file, status, b, s
    blocks = blocks_of(self%where(columns), rows)
    call open_to_read(self%path, file, status)
    do b = 1, size(blocks)
      associate (block => blocks(b))
        call read_block(self%where(columns(block%first_column:block%last_column)), file, first + block%first_row - 1, &
                        block%last_row - block%first_row + 1, found, status)
        if (status /= all_is_well) call fail(error, status_bad_file, 'cannot be read: '//status_text(status))
        if (allocated(error)) exit
        do s = block%first_column, block%last_column
          values(block%first_row:block%last_row, s) = found(:, s - block%first_column + 1)
        end do
      end associate
    end do
    call end_reading(file)
    if (allocated(error)) error%message = self%path//': '//error%message
  end subroutine take_rows

  pure function blocks_of(these, rows) result(blocks)
    !! Divide the reading into blocks, such that memory holds one block, and each chunk of the file is decompressed once for
    !! all its columns.
    type(netcdf_column), intent(in) :: these(:)      !! of the requested columns
    integer(i8), intent(in) :: rows
    type(row_block), allocatable :: blocks(:)
    integer(i8) :: row, at_once
    integer :: first, last, pass, n
    do pass = 1, 2                                   ! the first pass counts, the second lists
      n = 0
      last = 0
      do while (last < size(these))
        first = last + 1
        last = first
        do while (last < size(these))                ! further columns of the same variable
          if (these(first)%samples_first .or. these(last + 1)%variable /= these(first)%variable) exit
          last = last + 1
        end do
        at_once = max(1_i8, block_size/width_of(these(first:last)))
        do row = 1, rows, at_once
          n = n + 1
          if (pass == 2) blocks(n) = row_block(first, last, row, min(rows, row + at_once - 1))
        end do
      end do
      if (pass == 1) allocate (blocks(n))
    end do
  end function blocks_of

  pure integer(i8) function width_of(these) result(width)
    !! Return the number of adjacent columns of a variable from the first to the last of these.
    type(netcdf_column), intent(in) :: these(:)
    width = maxval(these%place) - minval(these%place) + 1
  end function width_of

  subroutine read_block(these, file, first, rows, values, status)
    !! Read some samples of columns of one variable, unpacked by the CF conventions.
    type(netcdf_column), intent(in) :: these(:)
    integer, intent(in) :: file
    integer(i8), intent(in) :: first, rows
    real(dp), allocatable, intent(out) :: values(:, :)       !! (rows, columns)
    integer, intent(inout) :: status
    real(dp), allocatable :: found(:, :)             ! all columns between these, in the order of the file
    integer(i8) :: place, width
    integer :: s
    place = minval(these%place)
    width = width_of(these)
    allocate (values(rows, size(these)))
    associate (here => these(1))
      if (here%rank == 1) then
        call read_numbers(file, here%variable, [first], [rows], values, status)
      else if (here%samples_first) then
        call read_numbers(file, here%variable, [place, first], [1_i8, rows], values, status)
      else
        allocate (found(width, rows))
        call read_numbers(file, here%variable, [first, place], [rows, width], found, status)
        if (status /= all_is_well) return
        do s = 1, size(these)
          values(:, s) = found(these(s)%place - place + 1, :)
        end do
      end if
      if (status /= all_is_well) return
      where (.not. ieee_is_finite(values)) values = missing
      where (values == here%fills(1) .or. values == here%fills(2)) values = missing
      if (here%factor == 1.0_dp .and. here%offset == 0.0_dp) return
      where (values /= missing) values = here%factor*values + here%offset
    end associate
  end subroutine read_block

  function place_of_row(self, row) result(place)
    !! Return the number of a sample, for a message.
    class(netcdf_source), intent(inout) :: self
    integer(i8), intent(in) :: row
    character(:), allocatable :: place
    place = self%path//': sample '//text_of(row)
  end function place_of_row

  subroutine close_netcdf(self)
    !! Do nothing: no file is open.
    class(netcdf_source), intent(inout) :: self
    associate (unused => self)
    end associate
  end subroutine close_netcdf

end module bw_netcdf_source
