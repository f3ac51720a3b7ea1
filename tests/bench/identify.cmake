add_executable(plenum_identify_minimum ${CMAKE_CURRENT_LIST_DIR}/identify_minimum.cpp)
target_link_libraries(plenum_identify_minimum PRIVATE plenum_identify plenum_plant plenum_warnings)
plenum_bench(NAME identify COMMAND plenum_identify_minimum)

add_executable(plenum_identify_speed ${CMAKE_CURRENT_LIST_DIR}/identify_speed.cpp)
target_link_libraries(plenum_identify_speed PRIVATE plenum_identify plenum_plant plenum_warnings)
plenum_bench(NAME identify.speed_vs_scipy COMMAND ${Python3_EXECUTABLE} -B
  ${CMAKE_CURRENT_LIST_DIR}/identify_speed.py plenum_identify_speed)
