# 32-bit Arm without floating point (ARMv5TE): every float of the core goes through the compiler's library.
set(CMAKE_SYSTEM_PROCESSOR armv5tel)
set(plenum_triplet arm-linux-gnueabi)
set(plenum_debian_arch armel)
set(plenum_qemu qemu-arm-static -cpu arm926)
include(${CMAKE_CURRENT_LIST_DIR}/debian-cross.cmake)
