plenum_bench(NAME fixed.tick COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/soft_tick.py
  ${CMAKE_BINARY_DIR}/bench/soft_tick)
