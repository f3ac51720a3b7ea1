# 32-bit Arm with floating point (ARMv7, VFPv3): BeagleBone, i.MX 6.
set(CMAKE_SYSTEM_PROCESSOR armv7l)
set(plenum_triplet arm-linux-gnueabihf)
set(plenum_debian_arch armhf)
set(plenum_qemu qemu-arm-static -cpu cortex-a8)
include(${CMAKE_CURRENT_LIST_DIR}/debian-cross.cmake)
