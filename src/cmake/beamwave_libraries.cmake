# LAPACK, FFTW3 and NetCDF-Fortran as imported targets beamwave::{lapack,fftw,netcdf}.
#
# gfortran does not look for .mod and .f03 files in /usr/include, and CMake drops -I/usr/include as
# implicit, so the directory is passed as a plain compile option.
find_package(PkgConfig QUIET)

function(beamwave_require value what)
  if(NOT ${value})
    message(FATAL_ERROR "beamwave needs ${what}: not found")
  endif()
endfunction()

function(beamwave_import name library module_dir)
  add_library(beamwave_${name} INTERFACE)
  add_library(beamwave::${name} ALIAS beamwave_${name})
  target_link_libraries(beamwave_${name} INTERFACE "${library}")
  target_compile_options(beamwave_${name} INTERFACE "$<$<COMPILE_LANGUAGE:Fortran>:-I${module_dir}>")
endfunction()

# hints from pkg-config, without its imported targets
if(PkgConfig_FOUND)
  pkg_check_modules(BW_PC_NETCDF QUIET netcdf-fortran)
  pkg_check_modules(BW_PC_FFTW QUIET fftw3)
  pkg_get_variable(BW_PC_NETCDF_FMODDIR netcdf-fortran fmoddir)
endif()
find_program(BW_NF_CONFIG nf-config)
if(BW_NF_CONFIG)
  execute_process(COMMAND ${BW_NF_CONFIG} --includedir OUTPUT_VARIABLE BW_NF_INCLUDE
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  execute_process(COMMAND ${BW_NF_CONFIG} --prefix OUTPUT_VARIABLE BW_NF_PREFIX
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()

find_path(BW_NETCDF_MODULES netcdf.mod
  HINTS ${BW_PC_NETCDF_FMODDIR} ${BW_PC_NETCDF_INCLUDEDIR} ${BW_NF_INCLUDE})
find_library(BW_NETCDFF_LIBRARY netcdff HINTS ${BW_PC_NETCDF_LIBRARY_DIRS} ${BW_NF_PREFIX}/lib)
beamwave_require(BW_NETCDF_MODULES "NetCDF-Fortran (netcdf.mod; libnetcdff-dev, netcdf-fortran-devel)")
beamwave_require(BW_NETCDFF_LIBRARY "NetCDF-Fortran (libnetcdff; libnetcdff-dev, netcdf-fortran-devel)")
beamwave_import(netcdf "${BW_NETCDFF_LIBRARY}" "${BW_NETCDF_MODULES}")

find_path(BW_FFTW_INCLUDE fftw3.f03 HINTS ${BW_PC_FFTW_INCLUDEDIR})
find_library(BW_FFTW_LIBRARY fftw3 HINTS ${BW_PC_FFTW_LIBRARY_DIRS})
beamwave_require(BW_FFTW_INCLUDE "FFTW 3 (fftw3.f03; libfftw3-dev, fftw-devel)")
beamwave_require(BW_FFTW_LIBRARY "FFTW 3 (libfftw3; libfftw3-dev, fftw-devel)")
beamwave_import(fftw "${BW_FFTW_LIBRARY}" "${BW_FFTW_INCLUDE}")

find_package(LAPACK REQUIRED)
add_library(beamwave_lapack INTERFACE)
add_library(beamwave::lapack ALIAS beamwave_lapack)
target_link_libraries(beamwave_lapack INTERFACE LAPACK::LAPACK)
