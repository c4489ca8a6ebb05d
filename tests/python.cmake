# BEAMWAVE_PYTHON: a Python that has beamwave_postproc and pytest, looked for at every configure since
# test.sh makes .venv; empty where there is none, and the tests that need it are left out.
set(python_with_postproc "")
foreach(candidate IN ITEMS "${BEAMWAVE_PYTHON}" "${PROJECT_SOURCE_DIR}/.venv/bin/python" python3)
  if(candidate AND NOT python_with_postproc)
    execute_process(RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET COMMAND "${candidate}" -c
      "import sys, importlib.util as u; sys.exit(not all(map(u.find_spec, ['beamwave_postproc', 'pytest'])))")
    if(status EQUAL 0)
      set(python_with_postproc "${candidate}")
    endif()
  endif()
endforeach()
set(BEAMWAVE_PYTHON "${python_with_postproc}")
if(NOT BEAMWAVE_PYTHON)
  message(STATUS "Tests: no Python with beamwave_postproc and pytest (test.sh makes one): those that need it are left out")
endif()
