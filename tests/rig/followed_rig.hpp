// A board of two chambers with measured valves, its models, and references for it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "firmware/config/model_image.hpp"
#include "host-sim/client/capture.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/identify/fit.hpp"
#include "host-sim/tools/recorded_log.hpp"
#include "tests/rig/watched_rig.hpp"

namespace plenum::host::rig {

inline constexpr unsigned kFollowed = 2;

inline MpyeRig followed_rig(double swing) {
  return {.chambers = kFollowed, .spool = false, .volume_swing = swing};
}

/// Models of the two channels of the measured valve, fitted once from what the board itself captured.
inline std::vector<client::ModelUpload> fitted_models(double swing) {
  static std::map<double, std::vector<client::ModelUpload>> fitted;
  std::vector<client::ModelUpload>& uploads = fitted[swing];
  if (!uploads.empty()) return uploads;
  WatchedRig watched(mpye_rig(followed_rig(swing)));
  client::Session session(watched, 1);
  const auto rows = client::capture(session, {.seconds = 20.0, .chambers = kFollowed});
  trace::RigDescription description;
  description.supply.pressure_Pa = 700e3;
  description.ambient.pressure_Pa = 100e3;
  for (std::uint8_t c = 0; c < kFollowed; ++c) {
    identify::FitOptions options;
    options.explore = false;
    options.refine_free_run = false;
    const auto fit = identify::fit_tassa9({tools::log_of(rows, c)}, description, options);
    plenum::config::ModelParameters parameters;
    parameters.kind = plenum::config::ModelKind::tassa9;
    const auto values = fit.model.image();
    parameters.count = static_cast<std::uint16_t>(values.size());
    std::transform(values.begin(), values.end(), parameters.value.begin(),
                   [](double value) { return static_cast<float>(value); });
    std::vector<std::uint8_t> image(plenum::config::kMaxImageBytes);
    image.resize(plenum::config::encode(parameters, image));
    uploads.push_back({c, image});
  }
  return uploads;
}

inline std::vector<std::vector<double>> same_for_both(const std::vector<double>& reference_Pa) {
  return std::vector<std::vector<double>>(kFollowed, reference_Pa);
}

}  // namespace plenum::host::rig
