// The inner loop of free_run(), compiled once for each set of instructions.
#pragma once

#include "host-sim/effects/free_run.hpp"

namespace plenum::host::effects {

using FreeRunKernel = void(const Surroundings&, const Drive&, EffectSet, std::span<const Run>,
                           std::span<double>);

FreeRunKernel free_run_any_machine;
FreeRunKernel free_run_x86_64_v3;
FreeRunKernel free_run_x86_64_v4;

}  // namespace plenum::host::effects
