# Run at build time: writes the version module, and touches it only when its text changes.
# cmake -D SOURCE=… -D TEMPLATE=… -D OUTPUT=… -D PROJECT_VERSION=… … -P stamp_version.cmake
set(git git -C "${SOURCE}" -c "safe.directory=*")
execute_process(COMMAND ${git} rev-parse --show-toplevel OUTPUT_VARIABLE top RESULT_VARIABLE status
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(REAL_PATH "${SOURCE}" source_path)
set(BEAMWAVE_COMMIT unknown)
if(status EQUAL 0 AND "${top}" STREQUAL "${source_path}")
  execute_process(COMMAND ${git} rev-parse --short=12 HEAD OUTPUT_VARIABLE commit RESULT_VARIABLE status
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(status EQUAL 0)
    set(BEAMWAVE_COMMIT "${commit}")
    execute_process(COMMAND ${git} status --porcelain OUTPUT_VARIABLE changes
      OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(changes)
      string(APPEND BEAMWAVE_COMMIT "+")
    endif()
  endif()
endif()
if(NATIVE)
  set(BEAMWAVE_NATIVE_LOGICAL ".true.")
else()
  set(BEAMWAVE_NATIVE_LOGICAL ".false.")
endif()
configure_file("${TEMPLATE}" "${OUTPUT}" @ONLY)
