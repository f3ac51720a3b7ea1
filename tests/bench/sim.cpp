// How much faster than real time is the whole loop: 8 chambers regulated through the board, with a client
// that sends set points and SYNC at 100 Hz over the bus and decodes the stream of every chamber; one thread.
//
// The chambers are captured, identified and given their models first, which is not timed. Then 20 s of sines,
// steps and sums of sines are followed. The wall time is that of the thread on its core: the one thread never
// waits, and what else the machine does is not counted. The quickest of kRuns such runs.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <vector>

#include "firmware/config/model_image.hpp"
#include "host-sim/client/capture.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/identify/fit.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/recorded_log.hpp"
#include "host-sim/tools/rig_link.hpp"
#include "tests/bench/row.hpp"

namespace {

using namespace plenum::host;

constexpr int kRuns = 7;
constexpr std::size_t kTicks = 2000;
constexpr unsigned kChambers = 8;

trace::RigDescription description_of(double supply_Pa, double ambient_Pa) {
  trace::RigDescription description;
  description.supply.pressure_Pa = supply_Pa;
  description.ambient.pressure_Pa = ambient_Pa;
  return description;
}

std::vector<std::uint8_t> model_image(const identify::Tassa9& model) {
  plenum::config::ModelParameters parameters;
  parameters.kind = plenum::config::ModelKind::tassa9;
  const auto values = model.image();
  parameters.count = static_cast<decltype(parameters.count)>(values.size());
  std::transform(values.begin(), values.end(), parameters.value.begin(),
                 [](double value) { return static_cast<float>(value); });
  std::array<std::uint8_t, plenum::config::kMaxImageBytes> bytes{};
  const std::size_t size = plenum::config::encode(parameters, bytes);
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)};
}

void teach(client::Session& session, const trace::RigDescription& description) {
  const std::vector<client::CapturedRow> rows = client::capture(session, {.seconds = 30.0});
  std::vector<client::ModelUpload> uploads;
  for (unsigned c = 0; c < kChambers; ++c) {
    uploads.push_back({static_cast<std::uint8_t>(c),
                       model_image(identify::fit_tassa9({tools::log_of(rows, c)}, description).model)});
  }
  session.upload_models(uploads);
}

/// A third each of sines of 0.5 to 2.25 Hz, steps every half second, and sums of eight sines up to 3 Hz.
std::vector<std::vector<double>> references() {
  std::vector<std::vector<double>> all(kChambers);
  for (unsigned c = 0; c < kChambers; ++c) {
    for (std::size_t k = 0; k < kTicks; ++k) {
      const double t = 0.01 * static_cast<double>(k);
      double y = 350e3;
      if (k < kTicks / 3) {
        y += 100e3 * std::sin(2.0 * std::numbers::pi * (0.5 + 0.25 * c) * t);
      } else if (k < 2 * kTicks / 3) {
        y += std::fmod(t + 0.1 * c, 1.0) < 0.5 ? -100e3 : 100e3;
      } else {
        for (int m = 0; m < 8; ++m)
          y += 20e3 * std::sin(2.0 * std::numbers::pi * (0.2 + 0.4 * m) * t + m * m + c);
      }
      all[c].push_back(y);
    }
  }
  return all;
}

double thread_time_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double realtime_factor(const rig::RigConfig& config, const trace::RigDescription& description) {
  rig::Rig rig(config);
  tools::RigLink link(rig);
  client::Session session(link, 1);
  teach(session, description);
  const auto wanted = references();
  double best = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const double simulated_s = rig.now_s();
    const double begin_s = thread_time_s();
    client::follow(session, wanted, {});
    const double wall_s = thread_time_s() - begin_s;
    best = std::max(best, (rig.now_s() - simulated_s) / wall_s);
  }
  return best;
}

}  // namespace

int main() {
  const double mpye = realtime_factor(rig::mpye_rig({}), description_of(rig::MpyeRig{}.supply_Pa, 100e3));
  plenum::bench::print({"sim.realtime_factor_8_chambers", mpye, "x", "higher", 500.0});
  const trace::RigDescription thin_plate;
  plenum::bench::print({"sim.realtime_factor_8_chambers_thin_plate",
                        realtime_factor(rig::thin_plate_rig(thin_plate, {}), thin_plate), "x", "higher"});
}
