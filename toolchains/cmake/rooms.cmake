# plenum_room(NAME SOURCES ... LINKS ...): one room of the house as one static library target.
# plenum_test(NAME SOURCES ... LINKS ...): one GoogleTest executable, every case of it a ctest entry. The framework's headers are
# parsed once for all of them, by plenum_test_headers (tests/CMakeLists.txt). In std::string + "..." of headers parsed before, gcc 12
# sees an overflow that is none (its bug 105651, which stays silent where it parses the header itself): the tests do without those
# warnings, and the sanitizers look at the bounds where they are used.
# plenum_room_runs(PROGRAM): tests of this folder run PROGRAM, so that building the folder builds it.
function(plenum_room name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC ${ARG_LINKS} PRIVATE plenum_warnings ${ARG_PRIVATE_LINKS})
endfunction()

function(plenum_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LINKS} plenum_warnings GTest::gmock_main)
  target_precompile_headers(${name} REUSE_FROM plenum_test_headers)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${name} PRIVATE -Wno-array-bounds -Wno-restrict -Wno-stringop-overflow)
  endif()
  target_compile_definitions(${name} PRIVATE PLENUM_SOURCE_DIR="${CMAKE_SOURCE_DIR}" PLENUM_BINARY_DIR="${CMAKE_BINARY_DIR}")
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60)
endfunction()

function(plenum_room_runs program)
  get_filename_component(room ${CMAKE_CURRENT_SOURCE_DIR} NAME)
  add_custom_target(tests_of_${room}_run_${program} ALL DEPENDS ${program})
endfunction()
