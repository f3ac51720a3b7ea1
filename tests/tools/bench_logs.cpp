// Recordings of the plants' components as a test bench would write them: noisy, and in whole steps of a converter.
// Called with the component, the file to write, a seed, and what the component needs.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "host-sim/plant/random.hpp"
#include "host-sim/plant/regulator_valve/testbed.hpp"
#include "host-sim/plant/relief_valve/two_stage.hpp"
#include "host-sim/reproduce/relief_valve/recorded.hpp"

namespace {

namespace regulator = plenum::host::plant::regulator_valve;

constexpr double kStep_Pa = 125.0;         // 13 bits of 10 bar
constexpr double kReliefStep_Pa = 2500.0;  // 13 bits of 200 bar
constexpr double kReliefNoise_Pa = 5000.0;
constexpr double kFlowNoise = 1e-3;  // of the flow

double counted(double value, double step) {
  return step * std::round(value / step);
}

/// regulator FILE SEED HOLD_S [up]: the staircase of Fig. 6, turned at once; with `up` no way back.
bool write_regulator(std::FILE* file, std::uint64_t seed, double hold_s, bool up_only) {
  const regulator::ValveConfig valve = regulator::bench_valve();
  std::vector<regulator::Hold> holds = regulator::staircase(0.25e-3, 13, hold_s);
  if (up_only) holds.resize(14);
  const regulator::Recording recording =
      regulator::record(valve, {.turn_s = 0.0, .noise_Pa = 1000.0, .seed = seed}, valve.ambient_Pa, holds);
  std::fprintf(file, "time_s,screw_m,pressure_Pa\n");
  for (std::size_t k = 0; k < recording.screw_m.size(); ++k) {
    std::fprintf(file, "%.3f,%.6g,%.0f\n", recording.sample_s * static_cast<double>(k), recording.screw_m[k],
                 counted(recording.pressure_Pa[k] + valve.ambient_Pa, kStep_Pa));
  }
  return true;
}

namespace bench = plenum::host::reproduce::relief_valve;

/// relief-curve FILE SEED POINTS: the two-stage valve of host-sim/plant at rest, 10 to 110 L/min.
/// relief-step FILE SEED RATE: it, driven from 9.3 to 89 L/min at RATE [L/min/s].
bool write_relief(std::FILE* file, std::uint64_t seed, double how, bool curve) {
  const plenum::host::plant::relief_valve::TwoStagePhysics valve(
      plenum::host::plant::relief_valve::appendix_a_settling());
  plenum::host::plant::Random random(seed);
  const auto write = [&](double pressure_Pa, double flow_m3_s) {
    const double flow_noise = kFlowNoise * random.gaussian();
    const double noise_Pa = kReliefNoise_Pa * random.gaussian();
    std::fprintf(file, "%.0f,%.6g\n", counted(pressure_Pa + noise_Pa, kReliefStep_Pa),
                 flow_m3_s * (1.0 + flow_noise));
  };
  if (curve) {
    std::fprintf(file, "pressure_drop_Pa,flow_m3_s\n");
    for (const auto& [P, Q] : bench::static_points(valve, 10.0, 110.0, static_cast<int>(how))) write(P, Q);
    return true;
  }
  const auto run = bench::recorded(valve, {"", 9.3, 89.0, how, 0.28});
  std::fprintf(file, "time_s,pressure_drop_Pa,flow_m3_s\n");
  for (std::size_t k = 0; k < run.pressure_Pa.size(); ++k) {
    std::fprintf(file, "%.3f,", run.step_s * static_cast<double>(k));
    write(run.pressure_Pa[k], run.flow_m3_s[k]);
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  std::FILE* file = std::fopen(argv[2], "w");
  if (file == nullptr) return 2;
  const std::uint64_t seed = std::strtoull(argv[3], nullptr, 10);
  const std::string component = argv[1];
  bool known = false;
  if (component == "regulator") {
    known = write_regulator(file, seed, std::strtod(argv[4], nullptr),
                            argc > 5 && std::strcmp(argv[5], "up") == 0);
  }
  if (component == "relief-curve" || component == "relief-step") {
    known = write_relief(file, seed, std::strtod(argv[4], nullptr), component == "relief-curve");
  }
  return std::fclose(file) == 0 && known ? 0 : 2;
}
