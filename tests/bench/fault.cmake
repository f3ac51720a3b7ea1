add_executable(plenum_fault_bench ${CMAKE_CURRENT_LIST_DIR}/fault.cpp)
target_link_libraries(plenum_fault_bench PRIVATE plenum_rig plenum_client plenum_warnings)
plenum_bench(NAME board.fault_to_safe COMMAND plenum_fault_bench)
