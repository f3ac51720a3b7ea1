# plenum_version: what includes plenum_version.hpp links it. Looked at anew by every build.
set(PLENUM_VERSION_FOLDER ${CMAKE_BINARY_DIR}/version)
add_custom_target(plenum_write_version
  COMMAND ${CMAKE_COMMAND} -D VERSION=${PROJECT_VERSION} -D TOP=${CMAKE_SOURCE_DIR} -D TO=${PLENUM_VERSION_FOLDER}
          -P ${CMAKE_SOURCE_DIR}/toolchains/cmake/write_version.cmake
  BYPRODUCTS ${PLENUM_VERSION_FOLDER}/plenum_version.hpp ${PLENUM_VERSION_FOLDER}/version.txt
  VERBATIM)
add_library(plenum_version INTERFACE)
target_include_directories(plenum_version INTERFACE ${PLENUM_VERSION_FOLDER})
add_dependencies(plenum_version plenum_write_version)
