find_package(SUNDIALS REQUIRED COMPONENTS cvode nvecserial)
add_executable(plenum_cvode_bench ${CMAKE_CURRENT_LIST_DIR}/cvode.cpp)
target_link_libraries(plenum_cvode_bench PRIVATE plenum_plant plenum_warnings SUNDIALS::cvode_shared SUNDIALS::nvecserial_shared)
plenum_bench(NAME plant.speed_vs_cvode COMMAND plenum_cvode_bench)
