# Warnings are errors, with gcc and with clang (style.md of the project: one set of presets for people and CI).
add_library(plenum_warnings INTERFACE)
target_compile_options(plenum_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Werror
  -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wold-style-cast
  -Wnon-virtual-dtor -Woverloaded-virtual -Wnull-dereference -Wundef -Wcast-align)

# The firmware is freestanding in spirit: no exceptions, no run-time types, no hidden statics,
# and the same bits on every machine (no contraction of a*b+c, no reassociation).
add_library(plenum_firmware_flags INTERFACE)
target_compile_options(plenum_firmware_flags INTERFACE
  -fno-exceptions -fno-rtti -fno-threadsafe-statics -ffp-contract=off
  -fno-math-errno -fno-trapping-math)
target_compile_definitions(plenum_firmware_flags INTERFACE EIGEN_NO_MALLOC EIGEN_NO_DEBUG EIGEN_DONT_VECTORIZE)
