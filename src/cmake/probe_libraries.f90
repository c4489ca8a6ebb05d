module probe_fftw
  !! FFTW's own interfaces, in a module of their own because the header declares more than is used.
  use, intrinsic :: iso_c_binding
  implicit none (type, external)
  private
  public :: fftw_number
  include 'fftw3.f03'

contains

  function fftw_number() result(number)
    !! `3.3.10`: exported wisdom opens with `(fftw-3.3.10 `, and nothing else in the Fortran interface names the version.
    character(:), allocatable :: number
    character(kind=c_char), pointer :: wisdom(:)
    integer :: i
    call c_f_pointer(fftw_export_wisdom_to_string(), wisdom, [32])
    number = ''
    do i = len('(fftw-') + 1, size(wisdom)
      if (scan(wisdom(i), '0123456789.') == 0) exit
      number = number//wisdom(i)
    end do
  end function fftw_number

end module probe_fftw

program probe_libraries
  !! Prints the versions of the libraries beamwave is built with: `NetCDF 4.9.0, FFTW 3.3.10, LAPACK 3.11.0`.
  !! Run by CMake when it configures, which shows at the same time that they compile, link and run.
  use netcdf, only: nf90_inq_libvers
  use probe_fftw, only: fftw_number
  implicit none (type, external)

  interface
    subroutine ilaver(major, minor, patch)
      implicit none (type, external)
      integer, intent(out) :: major, minor, patch
    end subroutine ilaver

    double precision function dpmpar(i)
      !! MINPACK's numbers of the machine.
      implicit none (type, external)
      integer, intent(in) :: i
    end function dpmpar
  end interface

  character(80) :: netcdf_version
  integer :: lapack(3)

  if (abs(dpmpar(1)/epsilon(1.0d0) - 1.0d0) > 1.0d-6) error stop 'MINPACK is built for another machine'
  netcdf_version = nf90_inq_libvers()  ! '4.9.0 of Jan 15 2023 …'
  call ilaver(lapack(1), lapack(2), lapack(3))
  print '(5a,i0,2(".",i0))', 'NetCDF ', netcdf_version(:index(netcdf_version, ' ') - 1), &
    ', FFTW ', fftw_number(), ', LAPACK ', lapack

end program probe_libraries
