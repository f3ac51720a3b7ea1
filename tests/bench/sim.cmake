add_executable(plenum_sim_bench ${CMAKE_CURRENT_LIST_DIR}/sim.cpp)
target_link_libraries(plenum_sim_bench PRIVATE plenum_rig plenum_client plenum_identify plenum_warnings)
plenum_bench(NAME sim COMMAND plenum_sim_bench)
