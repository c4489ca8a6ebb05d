# beamwave_room(<name> [SOURCES …] [EXCEPT …] [USES <room> …] [LINKS <target> …])
#
# A room is a folder of src/: one static library and one directory of modules, of all Fortran files in the folder and below it,
# EXCEPT main programs, and of SOURCES that are made elsewhere. It sees the modules of the rooms named in USES and of no others,
# so that the build holds to the direction of the data. Module directories are not passed on: a room names every room whose
# modules it uses.
function(beamwave_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;USES;LINKS;EXCEPT" ${ARGN})
  set(target beamwave_${name})
  set(modules "${PROJECT_BINARY_DIR}/modules/${name}")
  file(GLOB_RECURSE sources RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}" CONFIGURE_DEPENDS "*.f90")
  list(REMOVE_ITEM sources ${ROOM_EXCEPT})
  add_library(${target} STATIC ${sources} ${ROOM_SOURCES})
  add_library(beamwave::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES
    Fortran_MODULE_DIRECTORY "${modules}" BEAMWAVE_MODULES "${modules}")
  target_link_libraries(${target} PRIVATE beamwave_flags)
  target_link_libraries(${target} PUBLIC ${ROOM_LINKS})
  foreach(used IN LISTS ROOM_USES)
    target_link_libraries(${target} PUBLIC beamwave::${used})
    target_include_directories(${target} PRIVATE "${PROJECT_BINARY_DIR}/modules/${used}")
  endforeach()
endfunction()

# beamwave_see(<target> <room> …): lets a program or a test use and link these rooms.
function(beamwave_see target)
  target_link_libraries(${target} PRIVATE beamwave_flags)
  foreach(used IN LISTS ARGN)
    target_link_libraries(${target} PRIVATE beamwave::${used})
    target_include_directories(${target} PRIVATE "${PROJECT_BINARY_DIR}/modules/${used}")
  endforeach()
endfunction()

# beamwave_short_arrays(<source> …): files of this folder whose work arrays are short, a few hundred numbers, and asked for
# so often that the heap would take longer than their use.
function(beamwave_short_arrays)
  if(CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
    set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -fstack-arrays)
  endif()
endfunction()

# beamwave_wide_vectors(<source> …): files of this folder whose loops are worth the widest registers there are.
function(beamwave_wide_vectors)
  if(BEAMWAVE_NATIVE AND BEAMWAVE_HAS_WIDE_VECTORS)
    set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -mprefer-vector-width=512)
  endif()
endfunction()

# beamwave_fused_products(<source> …): files of this folder whose loops are worth a product and a sum in one instruction,
# rounded once. Not for the compensated products of double-double arithmetic, which need each product rounded on its own. One
# build gives the same bits run after run all the same; where the processor has no such instruction nothing changes.
function(beamwave_fused_products)
  if(CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
    set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -ffp-contract=fast)
  endif()
endfunction()
