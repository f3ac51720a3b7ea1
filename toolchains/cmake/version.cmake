# plenum_version: what includes plenum_version.hpp links it. Written when CMake runs, for the tools that only read, and by every build.
set(write_version ${CMAKE_COMMAND} -D VERSION=${PROJECT_VERSION} -D SCALAR=${PLENUM_SCALAR} -D TOP=${CMAKE_SOURCE_DIR} -D TO=${CMAKE_BINARY_DIR}/version
                  -P ${CMAKE_SOURCE_DIR}/toolchains/cmake/write_version.cmake)
execute_process(COMMAND ${write_version} COMMAND_ERROR_IS_FATAL ANY)
add_custom_target(plenum_write_version
  COMMAND ${write_version}
  BYPRODUCTS ${CMAKE_BINARY_DIR}/version/plenum_version.hpp ${CMAKE_BINARY_DIR}/version/version.txt
  VERBATIM)
add_library(plenum_version INTERFACE)
target_include_directories(plenum_version INTERFACE ${CMAKE_BINARY_DIR}/version)
add_dependencies(plenum_version plenum_write_version)
