// A machine whose valve is late, from its recording to its regulation: the nine parameters know nothing of a delay.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "host-sim/client/capture.hpp"
#include "host-sim/client/model_bytes.hpp"
#include "host-sim/identify/profile.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/recorded_log.hpp"
#include "tests/rig/watched_rig.hpp"

namespace plenum::host::rig {
namespace {

constexpr std::size_t kRows = 1000;
constexpr std::size_t kLeftOut = 50;  // until it follows

trace::RigDescription late_by(double delay_s) {
  trace::RigDescription description;
  description.effects = {{"dead_time", {{"delay_s", delay_s}}}};
  return description;
}

trace::ModelFile identified(const trace::RigDescription& description, const identify::Profiled& profiled) {
  WatchedRig watched(thin_plate_rig(description, {.chambers = 1}));
  client::Session session(watched, 1);
  const auto rows = client::capture(session, {.seconds = 40.0, .chambers = 1});
  identify::FitOptions options;
  options.stretch_s = 0.2;
  options.form = identify::Form::repaired;
  return identify::to_model_file(
      identify::fit_tassa9_profiled({tools::log_of(rows, 0)}, description, options, profiled), {});
}

/// Of a sine of 1 Hz [kPa RMS].
double tracking_kPa(const trace::RigDescription& description, const trace::ModelFile& model) {
  WatchedRig watched(thin_plate_rig(description, {.chambers = 1}));
  client::Session session(watched, 1);
  const std::vector<client::ModelUpload> uploads{{0, client::encode_model(model.kind, model.parameters, {})}};
  session.upload_models(uploads);
  std::vector<std::vector<double>> reference_Pa(1, std::vector<double>(kRows));
  for (std::size_t k = 0; k < kRows; ++k)
    reference_Pa[0][k] = 350e3 + 100e3 * std::sin(2.0 * std::numbers::pi * 0.01 * static_cast<double>(k));
  const auto rows = client::follow(session, reference_Pa, {.preview_ticks = 5, .chambers = 1});
  double squares = 0.0;
  for (std::size_t k = kLeftOut; k < rows.size(); ++k)
    squares += std::pow(1e-3 * (rows[k].sample[0].actual_Pa - rows[k].reference_Pa[0]), 2);
  return std::sqrt(squares / static_cast<double>(rows.size() - kLeftOut));
}

TEST(LateValve, IsRegulatedByTheDeadTimeThatItsRecordingShows) {
  const trace::RigDescription late = late_by(0.025);
  const trace::ModelFile found = identified(late, {});
  EXPECT_NEAR(found.parameters.back(), 0.025, 1e-3) << "s";
  const double with_kPa = tracking_kPa(late, found);
  const double without_kPa = tracking_kPa(late, identified(late, {.kink_width = true, .dead_time = false}));
  EXPECT_LT(with_kPa, 5.0);
  EXPECT_GT(without_kPa, 5.0 * with_kPa);
}

}  // namespace
}  // namespace plenum::host::rig
