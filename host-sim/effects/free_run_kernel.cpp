#include "host-sim/effects/free_run_kernel.hpp"

namespace plenum::host::effects {

void PLENUM_KERNEL(const Surroundings& around, const Drive& drive, EffectSet on, std::span<const Run> runs,
                   std::span<double> readings) {
  using N = Lanes<PLENUM_INSTRUCTION_SET>;
  std::array<N, kFigures> figures;
  N start, warmth;
  for (int i = 0; i < kLanes; ++i) {
    const Run& run = runs[static_cast<std::size_t>(i) < runs.size() ? static_cast<std::size_t>(i) : 0];
    for (std::size_t k = 0; k < kFigures; ++k) set_lane(figures[k], i, run.figures[k]);
    const auto add = [&](std::size_t figure, double more_V) {
      set_lane(figures[figure], i, run.figures[figure] + more_V);
    };
    const auto& null_V = run.start.null_V;
    add(kOpenAbove, null_V[0]);
    add(kExhaustBelow, null_V[0]);
    add(kFirstFigure[kIdNullDrift], null_V[1]);
    for (std::size_t k = 2; k < kOwnNull; ++k) add(kFirstFigure[kIdNullDrift] + k, null_V[k]);
    set_lane(start, i, run.start.pressure_Pa);
    set_lane(warmth, i, run.start.warmth_Pa);
  }
  ChamberModel<N> model(around, drive.timing, on, figures.data(), start, drive.command_V.front(),
                        drive.volume_m3.front(), warmth);
  double* out = readings.data();
  const auto put = [&](const N& reading) {
    for (int i = 0; i < kLanes; ++i) *out++ = lane(reading, i);
  };
  put(start);
  const auto steps = static_cast<std::size_t>(drive.timing.steps);
  const std::size_t rows = readings.size() / static_cast<std::size_t>(kLanes);
  for (std::size_t row = 0; row + 1 < rows; ++row) {
    if (!drive.supply_Pa.empty()) model.follow_supply(drive.supply_Pa[row]);
    put(model.tick(drive.command_V[row], std::span(drive.volume_m3).subspan(row * steps)));
  }
}

}  // namespace plenum::host::effects
