module bw_netcdf_path
  !! Paths in the form that the NetCDF library reads literally.
  use, intrinsic :: iso_c_binding, only: c_null_char
  implicit none (type, external)
  private
  public :: has_backslash, plain_path

contains

  pure function plain_path(path) result(text)
    !! Return a path that NetCDF does not interpret. Otherwise it would drop blanks at either end, take `http://…` for a
    !! URL, `C:/…`, `//…` and `/cygdrive/…` for Windows paths, and a list in brackets for options.
    character(*), intent(in) :: path              !! without backslash, see `has_backslash`
    character(:), allocatable :: text
    integer :: i
    text = './'
    if (index(path, '/') == 1) text = '/.'
    do i = 1, len(path)
      if (path(i:i) == '/' .and. text(len(text):) == '/') cycle       ! the system takes two slashes for one
      text = text//path(i:i)
    end do
    text = text//c_null_char
  end function plain_path

  pure logical function has_backslash(path)
    !! Return whether a path has a backslash, which NetCDF takes for a slash: such a file cannot be opened.
    character(*), intent(in) :: path
    has_backslash = index(path, '\') > 0
  end function has_backslash

end module bw_netcdf_path
