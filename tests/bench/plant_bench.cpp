// Nanoseconds of one chamber over one 10 ms tick, volume moving, by valve, spool and how hard the command
// works.
#include <benchmark/benchmark.h>

#include <cmath>

#include "host-sim/plant/chamber.hpp"

namespace {

using namespace plenum::host::plant;

enum class Drive { calm, sine, strokes };

double command_V(Drive drive, int tick) {
  switch (drive) {
    case Drive::calm:
      return 5.0 + 0.6 * std::sin(0.044 * tick) + 0.2 * std::sin(0.2 * tick);
    case Drive::sine:
      return 5.0 + 2.0 * std::sin(0.0628 * tick);
    case Drive::strokes:
      return (tick / 25) % 2 == 0 ? 0.0 : 10.0;
  }
  return 5.0;
}

void chamber_tick(benchmark::State& state, const Valve& valve, const Gas& gas, bool spool, double mean_m3,
                  Drive drive) {
  ChamberConfig config;
  config.gas = gas;
  if (spool) config.spool = SpoolConfig{};
  const VolumeMotion motion(mean_m3,
                            {VolumeSine{0.3 * mean_m3, 0.7, 0.3}, VolumeSine{0.06 * mean_m3, 1.6, 1.0}});
  ChamberPlant plant(valve, config, motion);
  int tick = 0;
  for (auto _ : state) benchmark::DoNotOptimize(plant.advance(command_V(drive, tick++), 0.01));
  state.counters["steps"] = static_cast<double>(plant.steps_tried()) / tick;
}

const Valve kPlate = ThinPlateValve({});
const Valve kMpye = MpyeValve(MpyeChannel::a);

BENCHMARK_CAPTURE(chamber_tick, plate_calm_100mL, kPlate, Gas{}, false, 100e-6, Drive::calm);
BENCHMARK_CAPTURE(chamber_tick, plate_calm_spool_100mL, kPlate, Gas{}, true, 100e-6, Drive::calm);
BENCHMARK_CAPTURE(chamber_tick, plate_sine_spool_100mL, kPlate, Gas{}, true, 100e-6, Drive::sine);
BENCHMARK_CAPTURE(chamber_tick, plate_strokes_40mL, kPlate, Gas{}, false, 40e-6, Drive::strokes);
BENCHMARK_CAPTURE(chamber_tick, mpye_calm_400mL, kMpye, reference_atmosphere(), false, 400e-6, Drive::calm);
BENCHMARK_CAPTURE(chamber_tick, mpye_calm_spool_400mL, kMpye, reference_atmosphere(), true, 400e-6,
                  Drive::calm);
BENCHMARK_CAPTURE(chamber_tick, mpye_sine_spool_400mL, kMpye, reference_atmosphere(), true, 400e-6,
                  Drive::sine);
BENCHMARK_CAPTURE(chamber_tick, mpye_strokes_spool_40mL, kMpye, reference_atmosphere(), true, 40e-6,
                  Drive::strokes);
BENCHMARK_CAPTURE(chamber_tick, plate_strokes_tenth_mL, kPlate, Gas{}, false, 0.1e-6, Drive::strokes);

}  // namespace
