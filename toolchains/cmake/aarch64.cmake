# 64-bit Arm: Raspberry Pi 3 and later, i.MX 8, and the virtual board.
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(plenum_triplet aarch64-linux-gnu)
set(plenum_debian_arch arm64)
set(plenum_qemu qemu-aarch64-static -cpu cortex-a53)
include(${CMAKE_CURRENT_LIST_DIR}/debian-cross.cmake)
