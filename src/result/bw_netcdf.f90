module bw_netcdf
  !! NetCDF calls with errors as values, and variables defined the way every result file wants them.
  use, intrinsic :: iso_c_binding, only: c_null_char
  use bw_kinds, only: i4
  use bw_error, only: error_type, fail, status_bad_file, why_not_written
  use bw_missing, only: missing
  use bw_text, only: joined
  use netcdf, only: nf90_create, nf90_def_var, nf90_double, nf90_fill_int, nf90_netcdf4, nf90_noclobber, nf90_noerr, &
    nf90_put_att, nf90_strerror
  implicit none (type, external)
  private
  public :: check, create_file, define_variable, has_backslash, plain_path, put_words

  integer(i4), parameter, public :: unwritten = nf90_fill_int   !! what an integer reads as before it is written

contains

  subroutine check(status, path, error)
    !! Turn a NetCDF status into an error that names the file. Keeps an error that is there.
    !! HDF5 gives one status for everything that the system refuses, so the usual reasons are named.
    integer, intent(in) :: status
    character(*), intent(in) :: path
    type(error_type), allocatable, intent(inout) :: error
    if (status == nf90_noerr .or. allocated(error)) return
    call fail(error, status_bad_file, path//': cannot be written: '//trim(nf90_strerror(status))//'; '// &
              why_not_written)
  end subroutine check

  subroutine create_file(path, id, error)
    !! A new NetCDF-4 file under a name that nothing has. **Errors**: `status_bad_file`.
    character(*), intent(in) :: path
    integer, intent(out) :: id
    type(error_type), allocatable, intent(out) :: error
    call check(nf90_create(plain_path(path), ior(nf90_netcdf4, nf90_noclobber), id), path, error)
  end subroutine create_file

  pure function plain_path(path) result(text)
    !! A path as NetCDF takes it for what it is. Left alone it would drop blanks at either end, and take `http://…` for a place
    !! in the net, `C:/…`, `//…` and `/cygdrive/…` for what they are under Windows, and a list in brackets for options.
    character(*), intent(in) :: path              !! one that `has_backslash` denies
    character(:), allocatable :: text
    integer :: i
    text = './'
    if (index(path, '/') == 1) text = '/.'
    do i = 1, len(path)
      if (path(i:i) == '/' .and. text(len(text):) == '/') cycle       ! two are one to the system
      text = text//path(i:i)
    end do
    text = text//c_null_char
  end function plain_path

  pure logical function has_backslash(path)
    !! NetCDF takes a backslash for a slash wherever it stands: such a file cannot be reached.
    character(*), intent(in) :: path
    has_backslash = index(path, '\') > 0
  end function has_backslash

  subroutine define_variable(file, path, name, kind, dimensions, units, long_name, variable, error, coordinate)
    !! A variable with its unit and meaning. Doubles get an explicit fill value unless they are coordinates, which
    !! never hold it; integers always exist, and one would make xarray read them as reals.
    integer, intent(in) :: file
    character(*), intent(in) :: path, name
    integer, intent(in) :: kind                    !! nf90_double or nf90_int
    integer, intent(in) :: dimensions(:)           !! fastest first; none for a scalar
    character(*), intent(in) :: units, long_name
    integer, intent(out) :: variable
    type(error_type), allocatable, intent(inout) :: error
    logical, intent(in), optional :: coordinate
    logical :: filled
    call check(nf90_def_var(file, name, kind, dimensions, variable), path, error)
    if (allocated(error)) return
    if (present(coordinate)) then
      filled = .not. coordinate
    else
      filled = kind == nf90_double
    end if
    if (filled) call check(nf90_put_att(file, variable, '_FillValue', missing), path, error)
    call check(nf90_put_att(file, variable, 'units', units), path, error)
    call check(nf90_put_att(file, variable, 'long_name', trim(long_name)), path, error)
  end subroutine define_variable

  subroutine put_words(file, path, variable, words, first, error)
    !! CF's flags: words for the numbers first, first + 1, …
    integer, intent(in) :: file
    character(*), intent(in) :: path
    integer, intent(in) :: variable
    character(*), intent(in) :: words(:)
    integer, intent(in) :: first
    type(error_type), allocatable, intent(inout) :: error
    integer :: i
    call check(nf90_put_att(file, variable, 'flag_values', [(int(i, i4), i=first, first + size(words) - 1)]), path, error)
    call check(nf90_put_att(file, variable, 'flag_meanings', joined(words)), path, error)
  end subroutine put_words

end module bw_netcdf
