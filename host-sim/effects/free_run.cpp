#include "host-sim/effects/free_run.hpp"

#include "host-sim/effects/free_run_kernel.hpp"

namespace plenum::host::effects {
namespace {

FreeRunKernel* widest() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512cd")) {
    return free_run_x86_64_v4;
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")) {
    return free_run_x86_64_v3;
  }
#endif
  return free_run_any_machine;
}

}  // namespace

Drive make_drive(std::span<const double> command_V, std::span<const double> volume_m3, const Timing& timing,
                 std::span<const double> supply_Pa) {
  Drive drive{{command_V.begin(), command_V.end()}, {}, timing};
  const std::size_t rows = volume_m3.size();
  const auto bend = [&](std::size_t row) {
    return row == 0 || row + 1 >= rows ? 0.0 : volume_m3[row - 1] - 2.0 * volume_m3[row] + volume_m3[row + 1];
  };
  drive.volume_m3.reserve((rows - 1) * static_cast<std::size_t>(timing.steps) + 1);
  for (std::size_t row = 0; row + 1 < rows; ++row) {
    const double curve = 0.5 * (bend(row) + bend(row + 1));
    for (int i = 0; i < timing.steps; ++i) {
      const double s = static_cast<double>(i) / timing.steps;
      drive.volume_m3.push_back(volume_m3[row] + s * (volume_m3[row + 1] - volume_m3[row]) -
                                0.5 * s * (1.0 - s) * curve);
    }
  }
  drive.volume_m3.push_back(volume_m3.back());
  for (std::size_t row = 0; row + 1 < supply_Pa.size(); ++row) {
    drive.supply_Pa.push_back(0.5 * (supply_Pa[row] + supply_Pa[row + 1]));
  }
  return drive;
}

void free_run(const Surroundings& around, const Drive& drive, EffectSet on, std::span<const Run> runs,
              std::span<double> readings) {
  static FreeRunKernel* const kernel = widest();
  kernel(around, drive, on, runs, readings);
}

}  // namespace plenum::host::effects
