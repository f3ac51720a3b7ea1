# More cases than a run of all benchmarks has time for: tests/bench/gap.py PLENUM --cases 300
plenum_bench(NAME gap COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/gap.py plenum)
plenum_bench(NAME gap.seconds COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/gap.py plenum --seconds)

find_package(nlohmann_json REQUIRED)
add_executable(plenum_gap_speed ${CMAKE_CURRENT_LIST_DIR}/gap_speed.cpp)
target_link_libraries(plenum_gap_speed PRIVATE plenum_identify_chamber plenum_effects plenum_plant plenum_trace plenum_warnings
  nlohmann_json::nlohmann_json)
plenum_bench(NAME gap.speed_vs_scipy COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/gap_speed.py plenum
  plenum_gap_speed)


# Real recordings: what was put into them is known, what was in them before is not.
plenum_bench(NAME spiked COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/spiked.py plenum
  ${CMAKE_SOURCE_DIR}/tests/data/respiraworks)
