# LAPACK, FFTW3, MINPACK and NetCDF-Fortran as imported targets beamwave::{lapack,fftw,minpack,netcdff}, and what they
# call themselves in BEAMWAVE_LIBRARY_VERSIONS.
#
# gfortran does not look for .mod and .f03 files in /usr/include, and CMake drops -I/usr/include as
# implicit, so the directory is passed as a plain compile option.
find_package(PkgConfig QUIET)

function(beamwave_import name library module_dir)
  add_library(beamwave_${name} INTERFACE)
  add_library(beamwave::${name} ALIAS beamwave_${name})
  target_link_libraries(beamwave_${name} INTERFACE "${library}")
  target_compile_options(beamwave_${name} INTERFACE "$<$<COMPILE_LANGUAGE:Fortran>:-I${module_dir}>")
endfunction()

# hints from pkg-config, without its imported targets
if(PkgConfig_FOUND)
  pkg_check_modules(BW_PC_NETCDF QUIET netcdf-fortran)
  pkg_check_modules(BW_PC_NETCDF_C QUIET netcdf)
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

find_program(BW_NC_CONFIG nc-config)
if(BW_NC_CONFIG)
  execute_process(COMMAND ${BW_NC_CONFIG} --prefix OUTPUT_VARIABLE BW_NC_PREFIX OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()

find_path(BW_NETCDF_MODULES netcdf.mod
  HINTS ${BW_PC_NETCDF_FMODDIR} ${BW_PC_NETCDF_INCLUDEDIR} ${BW_NF_INCLUDE})
find_library(BW_NETCDFF_LIBRARY netcdff HINTS ${BW_PC_NETCDF_LIBRARY_DIRS} ${BW_NF_PREFIX}/lib)
# netCDF-Fortran stands on the C library, which is called too
get_filename_component(BW_NETCDFF_DIR "${BW_NETCDFF_LIBRARY}" DIRECTORY)
find_library(BW_NETCDF_LIBRARY netcdf HINTS ${BW_NETCDFF_DIR} ${BW_PC_NETCDF_C_LIBRARY_DIRS} ${BW_NC_PREFIX}/lib)
find_path(BW_FFTW_INCLUDE fftw3.f03 HINTS ${BW_PC_FFTW_INCLUDEDIR})
find_library(BW_FFTW_LIBRARY fftw3 HINTS ${BW_PC_FFTW_LIBRARY_DIRS})
find_library(BW_MINPACK_LIBRARY minpack)
find_package(LAPACK QUIET)

set(missing "")
if(NOT BW_NETCDF_MODULES OR NOT BW_NETCDFF_LIBRARY OR NOT BW_NETCDF_LIBRARY)
  string(APPEND missing "\n  NetCDF-Fortran (netcdf.mod, libnetcdff, libnetcdf; packages libnetcdff-dev, netcdf-fortran-devel)")
endif()
if(NOT BW_FFTW_INCLUDE OR NOT BW_FFTW_LIBRARY)
  string(APPEND missing "\n  FFTW 3 (fftw3.f03, libfftw3; packages libfftw3-dev, fftw-devel)")
endif()
if(NOT BW_MINPACK_LIBRARY)
  string(APPEND missing "\n  MINPACK (libminpack; packages minpack-dev, minpack-devel)")
endif()
if(NOT LAPACK_FOUND)
  string(APPEND missing "\n  LAPACK (packages libopenblas-dev, liblapack-dev, openblas-devel)")
endif()
if(missing)
  message(FATAL_ERROR "beamwave needs, and this machine lacks:${missing}")
endif()

# One program that uses all of them proves that they are there for this very compiler (a netcdf.mod
# written by another one is not), and says which versions they are.
if(NOT BEAMWAVE_LIBRARY_VERSIONS)
  try_run(ran compiled "${PROJECT_BINARY_DIR}/probe" "${CMAKE_CURRENT_LIST_DIR}/probe_libraries.f90"
    COMPILE_DEFINITIONS "-I${BW_NETCDF_MODULES}" "-I${BW_FFTW_INCLUDE}"
    LINK_LIBRARIES "${BW_NETCDFF_LIBRARY}" "${BW_NETCDF_LIBRARY}" "${BW_FFTW_LIBRARY}" "${BW_MINPACK_LIBRARY}" LAPACK::LAPACK
    COMPILE_OUTPUT_VARIABLE build_output RUN_OUTPUT_VARIABLE versions)
  if(NOT compiled OR NOT ran EQUAL 0)
    unset(ran CACHE)        # tried again next time: the libraries may be another set by then
    unset(compiled CACHE)
    message(FATAL_ERROR "NetCDF-Fortran, FFTW 3, MINPACK and LAPACK are there, but a program that uses them does not "
      "build or run with ${CMAKE_Fortran_COMPILER}:\n${build_output}\n${versions}")
  endif()
  string(STRIP "${versions}" versions)
  set(BEAMWAVE_LIBRARY_VERSIONS "${versions}" CACHE INTERNAL "Libraries and their versions")
  message(STATUS "Libraries: ${BEAMWAVE_LIBRARY_VERSIONS}")
endif()

beamwave_import(netcdff "${BW_NETCDFF_LIBRARY};${BW_NETCDF_LIBRARY}" "${BW_NETCDF_MODULES}")
beamwave_import(fftw "${BW_FFTW_LIBRARY}" "${BW_FFTW_INCLUDE}")
add_library(beamwave_minpack INTERFACE)
add_library(beamwave::minpack ALIAS beamwave_minpack)
target_link_libraries(beamwave_minpack INTERFACE "${BW_MINPACK_LIBRARY}")
add_library(beamwave_lapack INTERFACE)
add_library(beamwave::lapack ALIAS beamwave_lapack)
target_link_libraries(beamwave_lapack INTERFACE LAPACK::LAPACK)
