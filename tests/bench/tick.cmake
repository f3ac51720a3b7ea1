add_executable(plenum_tick_bench ${CMAKE_CURRENT_LIST_DIR}/tick.cpp)
target_link_libraries(plenum_tick_bench PRIVATE plenum_firmware plenum_warnings)
plenum_bench(NAME tick COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/tick.py plenum_tick_bench)
plenum_bench(NAME model.greybox_tick_cost COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/tick.py plenum_tick_bench --greybox)
