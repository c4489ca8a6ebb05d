# Run at build time: writes the version module, and touches it only when its text changes.
# cmake -D SOURCE=… -D TEMPLATE=… -D OUTPUT=… -D PROJECT_VERSION=… -D NATIVE=… -D BEAMWAVE_BUILD=…
#       -D BEAMWAVE_LIBRARIES=… -P stamp_version.cmake

# git may refuse a checkout that another user owns; who builds it trusts it
set(git git --no-optional-locks -C "${SOURCE}" -c "safe.directory=*")

function(ask_git answer)
  execute_process(COMMAND ${git} ${ARGN} OUTPUT_VARIABLE output RESULT_VARIABLE status
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT status EQUAL 0)  # no git, no repository, no commit yet
    set(output "")
  endif()
  set(${answer} "${output}" PARENT_SCOPE)
endfunction()

# a source archive unpacked inside somebody else's repository has no commit of its own
ask_git(top rev-parse --show-toplevel)
ask_git(commit rev-parse --short=12 HEAD)
file(REAL_PATH "${SOURCE}" source_path)
set(BEAMWAVE_COMMIT unknown)
if(commit AND top STREQUAL source_path)
  # what makes another program: a file of the commit that has changed, and whatever is new among the sources. Scenes, results
  # and notes that lie in the checkout do not
  ask_git(changed status --porcelain --untracked-files=no)
  ask_git(added status --porcelain --untracked-files=all -- src CMakeLists.txt)
  set(BEAMWAVE_COMMIT "${commit}")
  if(changed OR added)
    string(APPEND BEAMWAVE_COMMIT "+")
  endif()
endif()

if(NATIVE)
  set(BEAMWAVE_NATIVE_LOGICAL ".true.")
else()
  set(BEAMWAVE_NATIVE_LOGICAL ".false.")
endif()
configure_file("${TEMPLATE}" "${OUTPUT}" @ONLY)
