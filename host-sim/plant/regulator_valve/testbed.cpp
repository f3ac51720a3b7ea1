#include "host-sim/plant/regulator_valve/testbed.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "host-sim/plant/random.hpp"
#include "host-sim/plant/refuse.hpp"
#include "host-sim/plant/regulator_valve/valve.hpp"

namespace plenum::host::plant::regulator_valve {

Recording record(const ValveConfig& valve, const TestbedConfig& bench, double pressure_Pa,
                 const std::vector<Hold>& holds) {
  constexpr double kAny = std::numeric_limits<double>::max();
  require_above("testbed sample_s", bench.sample_s, 0.0);
  require_within("testbed turn_s", bench.turn_s, 0.0, kAny);
  require_within("testbed noise_Pa", bench.noise_Pa, 0.0, kAny);
  if (holds.empty()) throw std::invalid_argument("testbed holds: none, expected at least one");

  Recording recording{.sample_s = bench.sample_s, .screw_m = {}, .pressure_Pa = {}};
  Valve plant(valve, holds.front().screw_m, pressure_Pa);
  Random random(bench.seed);
  for (const Hold& hold : holds) {
    require_above("testbed hold duration_s", hold.duration_s, 0.0);
    const double from_m = plant.screw_m();
    const double turn_s = std::max(bench.turn_s, bench.sample_s);
    const auto samples = static_cast<int>(std::lround(hold.duration_s / bench.sample_s));
    for (int k = 0; k < samples; ++k) {
      recording.screw_m.push_back(hold.screw_m);
      recording.pressure_Pa.push_back(plant.state().pressure_Pa - valve.ambient_Pa +
                                      bench.noise_Pa * random.gaussian());
      const double turned = std::min(1.0, (k + 1) * bench.sample_s / turn_s);
      plant.advance(from_m + turned * (hold.screw_m - from_m), bench.sample_s);
    }
  }
  return recording;
}

std::vector<Hold> staircase(double step_m, int steps, double hold_s) {
  std::vector<Hold> holds;
  for (int i = 0; i <= steps; ++i) holds.push_back({step_m * i, hold_s});
  for (int i = steps - 1; i >= 0; --i) holds.push_back({step_m * i, hold_s});
  return holds;
}

}  // namespace plenum::host::plant::regulator_valve
