add_executable(plenum_model_bench ${CMAKE_CURRENT_LIST_DIR}/model.cpp)
target_link_libraries(plenum_model_bench PRIVATE plenum_firmware plenum_client plenum_identify_chamber plenum_identify plenum_plant
  plenum_warnings Threads::Threads)
plenum_bench(NAME model.greybox_drift COMMAND plenum_model_bench)
