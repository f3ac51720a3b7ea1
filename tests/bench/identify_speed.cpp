// One fit, timed, for identify_speed.py: writes the ticks, the start and the bounds that the peer is to use,
// then fits.
//
// usage: identify_speed SEED FOLDER    prints {"seconds": ..., "cost_kPa2": ...}
// The time is that of the whole call: laying out the log, solving, covariance. The solver is left to the one
// start given.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>

#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/ticks.hpp"
#include "host-sim/reproduce/actuators/population.hpp"

int main(int count, char** words) {
  using namespace plenum::host;
  if (count != 3) {
    std::fprintf(stderr, "usage: identify_speed SEED FOLDER\n");
    return 2;
  }
  const std::vector<trace::Log> logs{reproduce::actuators::record_chamber(
      static_cast<unsigned>(std::strtoul(words[1], nullptr, 10)), reproduce::actuators::Motion::moderate)};
  const auto rig = reproduce::actuators::population_rig();
  identify::FitOptions options;
  options.start = identify::default_start(logs, rig);
  options.explore = options.refine_free_run = false;

  const identify::Ticks ticks = identify::lay_out(logs);
  std::ofstream file(std::filesystem::path(words[2]) / "ticks.csv");
  file << std::setprecision(17);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    file << ticks.command_V[i] << ',' << ticks.volume_mL[i] << ',' << ticks.volume_rate_mL_s[i] << ','
         << ticks.pressure_kPa[i] << '\n';
  }
  std::ofstream start(std::filesystem::path(words[2]) / "start.csv");
  start << std::setprecision(17);
  for (const double c : options.start->c) start << c << '\n';

  constexpr int kRepeats = 5;
  double seconds = 1e9;
  double cost_kPa2 = 0.0;
  for (int k = 0; k < kRepeats; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    cost_kPa2 = identify::fit_tassa9(logs, rig, options).cost_kPa2;
    seconds =
        std::min(seconds, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  std::printf("{\"seconds\": %.9g, \"cost_kPa2\": %.12g}\n", seconds, cost_kPa2);
}
