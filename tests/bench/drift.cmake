add_executable(plenum_drift_bench ${CMAKE_CURRENT_LIST_DIR}/drift.cpp)
target_link_libraries(plenum_drift_bench PRIVATE plenum_identify plenum_plant plenum_warnings Threads::Threads)
plenum_bench(NAME drift COMMAND plenum_drift_bench)
