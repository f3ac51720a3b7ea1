add_executable(plenum_regulate_bench ${CMAKE_CURRENT_LIST_DIR}/regulate.cpp)
target_link_libraries(plenum_regulate_bench PRIVATE plenum_rig plenum_client plenum_identify plenum_identify_chamber plenum_warnings
  Threads::Threads)
plenum_bench(NAME regulate COMMAND plenum_regulate_bench)
plenum_bench(NAME model.regulate COMMAND plenum_regulate_bench models)
