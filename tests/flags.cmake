# BEAMWAVE_COMPILER, BEAMWAVE_FLAGS: what the program is built with, for the documents that hold measured numbers. The
# commands of bench/ read them from a file of the build.
get_target_property(flags beamwave_flags INTERFACE_COMPILE_OPTIONS)
string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
list(JOIN flags " " flags)
string(STRIP "${CMAKE_Fortran_FLAGS} ${CMAKE_Fortran_FLAGS_${build_type}} ${flags}" BEAMWAVE_FLAGS)
set(BEAMWAVE_COMPILER "${CMAKE_Fortran_COMPILER_ID} ${CMAKE_Fortran_COMPILER_VERSION}")
file(WRITE "${PROJECT_BINARY_DIR}/bench/compiler.txt" "${BEAMWAVE_COMPILER}\n${BEAMWAVE_FLAGS}\n")
