add_executable(plenum_bus_bench ${CMAKE_CURRENT_LIST_DIR}/bus.cpp)
target_link_libraries(plenum_bus_bench PRIVATE plenum_rig plenum_client plenum_warnings)
plenum_bench(NAME bus COMMAND plenum_bus_bench)
