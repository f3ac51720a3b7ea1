add_executable(plenum_safety_bench ${CMAKE_CURRENT_LIST_DIR}/safety.cpp)
target_link_libraries(plenum_safety_bench PRIVATE plenum_safety_case plenum_warnings fmt::fmt Threads::Threads)
plenum_bench(NAME safety COMMAND plenum_safety_bench)
