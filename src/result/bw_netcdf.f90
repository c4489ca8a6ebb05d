module bw_netcdf
  !! A NetCDF-4 file that is written once, with errors as values. First everything is defined, then values are written: a
  !! change from one to the other costs NetCDF-4 a pass over all that is there. So values that are known when their variable
  !! is defined are put aside until `put_known`.
  use bw_kinds, only: dp, i4
  use bw_error, only: error_type, fail, status_bad_file
  use bw_missing, only: missing
  use bw_netcdf_path, only: plain_path
  use netcdf, only: nf90_char, nf90_close, nf90_create, nf90_def_dim, nf90_def_var, nf90_double, nf90_global, nf90_inq_dimid, &
    nf90_int, nf90_netcdf4, nf90_noclobber, nf90_noerr, nf90_put_att, nf90_put_var, nf90_strerror
  implicit none (type, external)
  private

  integer, parameter :: at_once = 65536           !! numbers of a variable in memory

  type, public :: variable_text
    !! What a file says of a variable, and how it is stored.
    character(64) :: name = ''
    character(24) :: dimensions = ''     !! names in the file's order, by spaces; a scalar has none
    character(40) :: units = '1'         !! UDUNITS, but for sensors whose unit is not known
    character(120) :: long_name = ''
    character(40) :: references = ''     !! the paper's equation; empty where it is not one of the paper's
    logical :: is_integer = .false.
    logical :: is_complete = .false.     !! every value exists, as of coordinates and of integers: there is no fill
    character(240) :: flags = ''         !! CF's flags, by spaces: what the numbers first_flag, first_flag + 1, … stand for
    integer :: first_flag = 0
    logical :: has_masks = .false.       !! flags are bits 1, 2, 4, …, of which several may be set
  end type variable_text

  type, public :: known_series
    !! Numbers that a variable runs through, or one column of its rows.
    real(dp), allocatable :: values(:)   !! again and again; unallocated: they count from 1
    integer :: each = 1                  !! how many times each stands in a row
  end type known_series

  type :: known_values
    !! The values of a variable that is defined and not yet written.
    integer :: variable = 0              !! NetCDF's number
    integer :: rank = 0
    integer :: count = 0                 !! how many numbers it holds, or rows of them
    type(known_series), allocatable :: columns(:)   !! of a variable with rows; one of any other
    character(:), allocatable :: names(:)           !! of a variable of texts; unallocated: of numbers
  end type known_values

  type, public :: netcdf_file
    integer :: id = 0                    !! NetCDF's number of the file
    character(:), allocatable :: path
    integer, private :: known = 0        !! how many variables have values that are put aside
    type(known_values), allocatable, private :: list(:)
  contains
    procedure :: create
    procedure :: check
    procedure :: add_dimension
    procedure :: define
    procedure :: define_known
    procedure :: define_rows
    procedure :: define_names
    procedure :: put_text
    procedure :: put_known
    procedure :: close => close_file
    procedure :: dimension_ids
    procedure, private :: put_aside
  end type netcdf_file

contains

  subroutine create(self, path, error)
    !! A new file under a name that nothing has. **Errors**: `status_bad_file`, as those of all that follows.
    class(netcdf_file), intent(inout) :: self
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(out) :: error
    self%path = path
    call self%check(nf90_create(plain_path(path), ior(nf90_netcdf4, nf90_noclobber), self%id), error)
  end subroutine create

  subroutine check(self, status, error)
    !! Turn a NetCDF status into an error that names the file. Keeps an error that is there. A status above 0 is the system's and
    !! has its words; HDF5 has one for everything that the system refuses, and the usual reasons are asked for.
    class(netcdf_file), intent(in) :: self
    integer, intent(in) :: status
    type(error_type), allocatable, intent(inout) :: error
    character(:), allocatable :: reason
    if (status == nf90_noerr .or. allocated(error)) return
    reason = trim(nf90_strerror(status))
    if (status < 0) reason = reason//'; is the disk full, a quota used up, the directory gone or read-only?'
    call fail(error, status_bad_file, self%path//': cannot be written: '//reason)
  end subroutine check

  subroutine add_dimension(self, name, length, error)
    !! One more dimension.
    class(netcdf_file), intent(in) :: self
    character(*), intent(in) :: name
    integer, intent(in) :: length                 !! above 0
    type(error_type), allocatable, intent(inout) :: error
    integer :: ignored
    if (.not. allocated(error)) call self%check(nf90_def_dim(self%id, name, length, ignored), error)
  end subroutine add_dimension

  subroutine define(self, text, variable, error)
    !! A variable with its attributes. Doubles get an explicit fill value unless all of them exist; integers get none, as one
    !! would make xarray read them as reals.
    class(netcdf_file), intent(in) :: self
    type(variable_text), intent(in) :: text
    integer, intent(out) :: variable              !! NetCDF's number
    type(error_type), allocatable, intent(inout) :: error
    variable = 0
    if (allocated(error)) return
    call self%check(nf90_def_var(self%id, trim(text%name), merge(nf90_int, nf90_double, text%is_integer), &
                                 self%dimension_ids(trim(text%dimensions)), variable), error)
    if (allocated(error)) return
    if (.not. (text%is_integer .or. text%is_complete)) then
      call self%check(nf90_put_att(self%id, variable, '_FillValue', missing), error)
    end if
    call self%put_text('units', trim(text%units), error, variable)
    call self%put_text('long_name', trim(text%long_name), error, variable)
    if (text%references /= '') call self%put_text('references', trim(text%references), error, variable)
    if (text%flags == '' .or. allocated(error)) return
    call self%check(nf90_put_att(self%id, variable, trim(merge('flag_masks ', 'flag_values', text%has_masks)), &
                                 flag_values(text)), error)
    call self%put_text('flag_meanings', trim(text%flags), error, variable)
  end subroutine define

  pure function flag_values(text) result(values)
    !! One number for each of the flags.
    type(variable_text), intent(in) :: text
    integer(i4), allocatable :: values(:)
    integer :: i, n
    n = 1
    do i = 1, len_trim(text%flags)
      if (text%flags(i:i) == ' ') n = n + 1
    end do
    values = [(int(text%first_flag + i, i4), i=0, n - 1)]
    if (text%has_masks) values = 2_i4**[(i, i=0, n - 1)]
  end function flag_values

  subroutine define_known(self, text, error, values, count)
    !! A variable of at most one dimension whose values are known, and put aside: all of them, or the numbers from 1 on.
    class(netcdf_file), intent(inout) :: self
    type(variable_text), intent(in) :: text
    type(error_type), allocatable, intent(inout) :: error
    real(dp), intent(in), optional :: values(:)   !! integers as reals, which hold them exactly; absent: 1, 2, …
    integer, intent(in), optional :: count        !! of all that the variable holds; absent: of `values`
    type(known_series) :: column(1)
    integer :: n
    if (present(values)) then
      allocate (column(1)%values, source=values)
      n = size(values)
    end if
    if (present(count)) n = count
    call self%define_rows(text, column, n, error)
  end subroutine define_known

  subroutine define_rows(self, text, columns, count, error)
    !! A variable whose values run, row by row, through those of its columns again and again, and are put aside.
    class(netcdf_file), intent(inout) :: self
    type(variable_text), intent(in) :: text       !! of two dimensions, or of at most one where there is one column
    type(known_series), intent(in) :: columns(:)
    integer, intent(in) :: count                  !! of the rows, which may be many
    type(error_type), allocatable, intent(inout) :: error
    type(known_values) :: known
    call self%define(text, known%variable, error)
    if (allocated(error)) return
    known%rank = size(self%dimension_ids(trim(text%dimensions)))
    known%columns = columns
    known%count = count
    call self%put_aside(known)
  end subroutine define_rows

  subroutine define_names(self, text, names, error)
    !! A variable of texts, of two dimensions: names and their letters, with blanks behind them.
    class(netcdf_file), intent(inout) :: self
    type(variable_text), intent(in) :: text
    character(*), intent(in) :: names(:)
    type(error_type), allocatable, intent(inout) :: error
    type(known_values) :: known
    if (allocated(error)) return
    call self%check(nf90_def_var(self%id, trim(text%name), nf90_char, self%dimension_ids(trim(text%dimensions)), &
                                 known%variable), error)
    call self%put_text('long_name', trim(text%long_name), error, known%variable)
    call self%put_text('_Encoding', 'utf-8', error, known%variable)
    known%names = names
    call self%put_aside(known)
  end subroutine define_names

  subroutine put_aside(self, known)
    !! Remember the values of a variable.
    class(netcdf_file), intent(inout) :: self
    type(known_values), intent(in) :: known
    type(known_values), allocatable :: longer(:)
    if (.not. allocated(self%list)) allocate (self%list(50))
    if (self%known == size(self%list)) then
      allocate (longer(2*self%known))
      longer(:self%known) = self%list
      call move_alloc(longer, self%list)
    end if
    self%known = self%known + 1
    self%list(self%known) = known
  end subroutine put_aside

  subroutine put_known(self, error)
    !! Write all values that were put aside, those of a long variable piece by piece.
    class(netcdf_file), intent(inout) :: self
    type(error_type), allocatable, intent(inout) :: error
    integer :: first, i, n, rows, start(2), counts(2)      ! NetCDF reads as many as the variable has dimensions
    do i = 1, self%known
      associate (known => self%list(i))
        if (allocated(known%names)) then
          if (.not. allocated(error)) call self%check(nf90_put_var(self%id, known%variable, known%names), error)
          cycle
        end if
        rows = max(1, at_once/size(known%columns))
        do first = 1, known%count, rows
          if (allocated(error)) return
          n = min(rows, known%count - first + 1)
          start = [1, first]
          counts = [size(known%columns), n]
          if (known%rank == 1) start(1) = first
          if (known%rank == 1) counts(1) = n
          call self%check(nf90_put_var(self%id, known%variable, rows_of(known, first, n), start(:known%rank), &
                                       counts(:known%rank)), error)
        end do
      end associate
    end do
    self%known = 0
  end subroutine put_known

  pure function rows_of(known, first, n) result(values)
    !! n of a variable's rows from the first on, one behind the other.
    type(known_values), intent(in) :: known
    integer, intent(in) :: first, n
    real(dp) :: values(size(known%columns)*n)
    integer :: c, i
    do c = 1, size(known%columns)
      associate (column => known%columns(c), part => values(c::size(known%columns)))
        if (allocated(column%values)) then
          part = [(column%values(mod((first - 1 + i)/column%each, size(column%values)) + 1), i=0, n - 1)]
        else
          part = [(real(first + i, dp), i=0, n - 1)]
        end if
      end associate
    end do
  end function rows_of

  subroutine put_text(self, name, text, error, variable)
    !! An attribute of a variable, or of the file.
    class(netcdf_file), intent(in) :: self
    character(*), intent(in) :: name, text
    type(error_type), allocatable, intent(inout) :: error
    integer, intent(in), optional :: variable     !! NetCDF's number; absent: of the file
    integer :: owner
    owner = nf90_global
    if (present(variable)) owner = variable
    if (.not. allocated(error)) call self%check(nf90_put_att(self%id, owner, name, text), error)
  end subroutine put_text

  subroutine close_file(self, error)
    !! The file is whole.
    class(netcdf_file), intent(in) :: self
    type(error_type), allocatable, intent(inout) :: error
    if (.not. allocated(error)) call self%check(nf90_close(self%id), error)
  end subroutine close_file

  function dimension_ids(self, names) result(ids)
    !! NetCDF's numbers of dimensions, fastest first.
    class(netcdf_file), intent(in) :: self
    character(*), intent(in) :: names             !! in the file's order, by spaces
    integer, allocatable :: ids(:)
    integer :: first, gap, id, ignored
    allocate (ids(0))
    first = 1
    do while (first <= len(names))
      gap = index(names(first:)//' ', ' ')
      ignored = nf90_inq_dimid(self%id, names(first:first + gap - 2), id)
      ids = [id, ids]
      first = first + gap
    end do
  end function dimension_ids

end module bw_netcdf
