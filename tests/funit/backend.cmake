# Which add_pfunit_ctest the tests get: pFUnit's own, or the stand-in's of this folder.
set(TEST_BACKEND AUTO CACHE STRING
  "What runs the .pf tests: PFUNIT (required), STANDIN (of tests/funit), AUTO (pFUnit where it is installed)")
set_property(CACHE TEST_BACKEND PROPERTY STRINGS AUTO PFUNIT STANDIN)

if(TEST_BACKEND STREQUAL "PFUNIT")
  find_package(PFUNIT 4 REQUIRED)
elseif(TEST_BACKEND STREQUAL "AUTO")
  find_package(PFUNIT 4 QUIET)
elseif(NOT TEST_BACKEND STREQUAL "STANDIN")
  message(FATAL_ERROR "TEST_BACKEND is ${TEST_BACKEND}: AUTO, PFUNIT or STANDIN")
endif()

if(PFUNIT_FOUND AND NOT TEST_BACKEND STREQUAL "STANDIN")
  set(BEAMWAVE_TEST_BACKEND PFUNIT)
  message(STATUS "Tests: pFUnit ${PFUNIT_VERSION}")
else()
  set(BEAMWAVE_TEST_BACKEND STANDIN)
  message(STATUS "Tests: the stand-in for pFUnit in tests/funit")
  find_program(BEAMWAVE_AWK NAMES awk gawk mawk REQUIRED)
  include("${CMAKE_CURRENT_LIST_DIR}/add_pfunit_ctest.cmake")
endif()

# funit_track_suites(<folder>): pFUnit's drivers include their list of suites through a macro, which no
# dependency scan sees; without this a file added to an existing build would not be run.
function(funit_track_suites folder)
  get_property(targets DIRECTORY "${folder}" PROPERTY BUILDSYSTEM_TARGETS)
  get_property(binary_dir DIRECTORY "${folder}" PROPERTY BINARY_DIR)
  foreach(target IN LISTS targets)
    if(EXISTS "${binary_dir}/${target}.inc")
      set_property(SOURCE "${binary_dir}/${target}_driver.F90" TARGET_DIRECTORY ${target}
        APPEND PROPERTY OBJECT_DEPENDS "${binary_dir}/${target}.inc")
    endif()
  endforeach()
endfunction()
