module bw_netcdf_path
  !! Paths as the NetCDF library takes them.
  use, intrinsic :: iso_c_binding, only: c_null_char
  implicit none (type, external)
  private
  public :: has_backslash, plain_path

contains

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

end module bw_netcdf_path
