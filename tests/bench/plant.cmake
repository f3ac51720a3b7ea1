add_executable(plenum_plant_bench ${CMAKE_CURRENT_LIST_DIR}/plant_bench.cpp)
target_link_libraries(plenum_plant_bench PRIVATE plenum_plant plenum_warnings benchmark::benchmark_main)
plenum_bench(NAME plant COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/plant.py plenum_plant_bench)
