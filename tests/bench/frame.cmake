add_executable(plenum_frame_bench ${CMAKE_CURRENT_LIST_DIR}/frame.cpp)
target_link_libraries(plenum_frame_bench PRIVATE plenum_firmware plenum_warnings)
# What it counts must hold first: of that no instruction is counted, and a few seconds tell it.
add_test(NAME Plenum.FrameBench COMMAND plenum_frame_bench)
plenum_bench(NAME node.instructions_per_frame COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_LIST_DIR}/frame.py plenum_frame_bench)
