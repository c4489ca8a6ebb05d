# Compiler flags of every target. No -ffast-math: results keep IEEE arithmetic, and the compensated
# products of src/base need each product rounded on its own (-ffp-contract=off; beamwave_fused_products names the exceptions).
if(NOT CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
  message(WARNING "beamwave was tried with gfortran only; this is ${CMAKE_Fortran_COMPILER_ID}")
endif()

add_library(beamwave_flags INTERFACE)
target_compile_options(beamwave_flags INTERFACE
  -std=f2018 -fimplicit-none -ffp-contract=off
  -Wall -Wextra -Wno-compare-reals)   # where reals are compared for equality, equality is meant
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  # gfortran 12 takes the descriptor of an array that is allocated by assignment for uninitialised at -O3
  target_compile_options(beamwave_flags INTERFACE -O3 -Wno-uninitialized -Wno-maybe-uninitialized)
endif()
if(BEAMWAVE_NATIVE)
  include(CheckCompilerFlag)
  check_compiler_flag(Fortran -march=native BEAMWAVE_HAS_MARCH_NATIVE)
  if(BEAMWAVE_HAS_MARCH_NATIVE)
    target_compile_options(beamwave_flags INTERFACE -march=native)
  else()  # said in --version too, which reports what was done, not what was asked for
    message(WARNING "BEAMWAVE_NATIVE: this compiler does not take -march=native; building without it")
    set(BEAMWAVE_NATIVE OFF)
  endif()
  # gfortran halves the registers of AVX-512 unless told otherwise; files named by beamwave_wide_vectors gain a tenth
  check_compiler_flag(Fortran "-march=native -mprefer-vector-width=512" BEAMWAVE_HAS_WIDE_VECTORS)
endif()
if(BEAMWAVE_CHECKS)
  target_compile_options(beamwave_flags INTERFACE
    -O1 -Werror -fcheck=all -fcheck=no-array-temps -fbacktrace -ffpe-trap=invalid,zero,overflow -finit-real=snan -finit-derived)
endif()
if(BEAMWAVE_SANITIZE)
  target_compile_options(beamwave_flags INTERFACE -O1 -fbacktrace -fno-omit-frame-pointer
    -fsanitize=address,undefined -Wno-uninitialized -Wno-maybe-uninitialized)   # gfortran 12: false, as at -O3
  target_link_options(beamwave_flags INTERFACE -fsanitize=address,undefined)
endif()
