# What the toolchain files of the boards have in common: Debian's cross compiler, the tree of toolchains/sysroot, and qemu-user for
# what the build runs. Set before: CMAKE_SYSTEM_PROCESSOR, plenum_triplet, plenum_debian_arch, plenum_qemu (program and least CPU).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_C_COMPILER ${plenum_triplet}-gcc)
set(CMAKE_CXX_COMPILER ${plenum_triplet}-g++)
set(CMAKE_LIBRARY_ARCHITECTURE ${plenum_triplet})

cmake_path(SET plenum_sysroot NORMALIZE ${CMAKE_CURRENT_LIST_DIR}/../../build/sysroot/${plenum_debian_arch})
if(NOT EXISTS ${plenum_sysroot})
  message(FATAL_ERROR "${plenum_sysroot} is missing: run toolchains/sysroot ${plenum_debian_arch}, or the build by toolchains/dev")
endif()
set(CMAKE_SYSROOT ${plenum_sysroot})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${plenum_sysroot})
set(ENV{PKG_CONFIG_LIBDIR} ${plenum_sysroot}/usr/lib/${plenum_triplet}/pkgconfig:${plenum_sysroot}/usr/share/pkgconfig)

set(CMAKE_CROSSCOMPILING_EMULATOR ${plenum_qemu} -L ${plenum_sysroot})
