# The targets of tests/cost are gcc's alone.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  plenum_bench(NAME stack COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/stack.py ${CMAKE_BINARY_DIR})
endif()
