# add_pfunit_ctest(<name> TEST_SOURCES <file.pf> … [OTHER_SOURCES …] [LINK_LIBRARIES …] [LABELS …])
#
# The stand-in's form of pFUnit's function: a program of that name, registered with CTest. Needs the
# target funit and the program BEAMWAVE_AWK.
set(BEAMWAVE_DIRECTIVES "${CMAKE_CURRENT_LIST_DIR}/directives.awk")
set(BEAMWAVE_FUNIT_NAMES "${CMAKE_CURRENT_LIST_DIR}/funit.f90")

# <out> becomes the Fortran source made from a .pf file.
function(funit_translate file out)
  get_filename_component(suite "${file}" NAME_WE)
  get_filename_component(input "${file}" ABSOLUTE)
  set(output "${CMAKE_CURRENT_BINARY_DIR}/${suite}.f90")
  add_custom_command(OUTPUT "${output}"
    COMMAND "${BEAMWAVE_AWK}" -v "name=${suite}" -v "names=${BEAMWAVE_FUNIT_NAMES}" -f "${BEAMWAVE_DIRECTIVES}" "${input}" > "${output}"
    DEPENDS "${input}" "${BEAMWAVE_DIRECTIVES}" "${BEAMWAVE_FUNIT_NAMES}"
    COMMENT "Reading directives of ${suite}.pf"
    VERBATIM)
  set(${out} "${output}" PARENT_SCOPE)
endfunction()

# The main program of the suites given after its name.
function(funit_driver name)
  set(uses "")
  set(calls "")
  foreach(suite IN LISTS ARGN)
    string(APPEND uses "  use ${suite}_suite, only: run_${suite} => run_suite\n")
    string(APPEND calls "  call run_${suite}()\n")
  endforeach()
  file(CONFIGURE OUTPUT "${CMAKE_CURRENT_BINARY_DIR}/${name}_driver.f90" @ONLY CONTENT
"program ${name}_driver
  use funit, only: start_tests, finish_tests
${uses}  implicit none (type, external)
  call start_tests('${name}')
${calls}  call finish_tests()
end program ${name}_driver
")
endfunction()

function(add_pfunit_ctest name)
  cmake_parse_arguments(PARSE_ARGV 1 TEST "" "" "TEST_SOURCES;OTHER_SOURCES;LINK_LIBRARIES;LABELS")
  if(TEST_UNPARSED_ARGUMENTS OR NOT TEST_TEST_SOURCES)
    message(FATAL_ERROR "add_pfunit_ctest(${name}): TEST_SOURCES [OTHER_SOURCES] [LINK_LIBRARIES] [LABELS] only")
  endif()
  set(sources "")
  set(suites "")
  foreach(file IN LISTS TEST_TEST_SOURCES)
    funit_translate("${file}" source)
    list(APPEND sources "${source}")
    get_filename_component(suite "${file}" NAME_WE)
    list(APPEND suites "${suite}")
  endforeach()
  funit_driver(${name} ${suites})
  add_executable(${name} ${sources} ${TEST_OTHER_SOURCES} "${CMAKE_CURRENT_BINARY_DIR}/${name}_driver.f90")
  set_target_properties(${name} PROPERTIES Fortran_MODULE_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}/mod/${name}")
  target_link_libraries(${name} ${TEST_LINK_LIBRARIES} funit)
  add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}")
  if(TEST_LABELS)
    set_tests_properties(${name} PROPERTIES LABELS "${TEST_LABELS}")
  endif()
endfunction()
