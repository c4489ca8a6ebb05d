# Compiler flags of every target. No -ffast-math: results keep IEEE arithmetic, and the compensated
# products of src/base need each product rounded on its own (-ffp-contract=off).
if(NOT CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
  message(WARNING "beamwave was tried with gfortran only; this is ${CMAKE_Fortran_COMPILER_ID}")
endif()

add_library(beamwave_flags INTERFACE)
target_compile_options(beamwave_flags INTERFACE
  -std=f2018 -fimplicit-none -ffp-contract=off -Wall -Wextra -Wno-compare-reals)  # exact comparisons of reals are meant where they stand
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  target_compile_options(beamwave_flags INTERFACE -O3)
endif()
if(BEAMWAVE_NATIVE)
  target_compile_options(beamwave_flags INTERFACE -march=native)
endif()
if(BEAMWAVE_CHECKS)
  target_compile_options(beamwave_flags INTERFACE
    -O1 -Werror -fcheck=all -fbacktrace -ffpe-trap=invalid,zero,overflow -finit-real=snan -finit-derived)
endif()
if(BEAMWAVE_SANITIZE)
  target_compile_options(beamwave_flags INTERFACE -O1 -fbacktrace -fsanitize=address,undefined -fno-omit-frame-pointer)
  target_link_options(beamwave_flags INTERFACE -fsanitize=address,undefined)
endif()
