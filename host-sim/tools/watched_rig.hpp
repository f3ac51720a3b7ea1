// A simulated rig with a session to its first board, and an eye on what its chambers really do, which no board has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "host-sim/client/capture.hpp"
#include "host-sim/client/model_bytes.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/tools/rig_link.hpp"
#include "host-sim/trace/model_json.hpp"

namespace plenum::host::tools {

class WatchedRig {
 public:
  /// The first `chambers` of the first board are used.
  WatchedRig(const rig::RigConfig& config, unsigned chambers)
      : truth_Pa_(chambers), rig_(config), link_(rig_, "master", [this] { look(); }), session_(link_, 1) {}
  WatchedRig(const WatchedRig&) = delete;
  WatchedRig& operator=(const WatchedRig&) = delete;

  client::Session& session() { return session_; }

  /// The same model in every chamber. Throws as Session::upload_models().
  void upload(const trace::ModelFile& model, client::Doubted doubted = client::Doubted::refuse) {
    std::vector<client::ModelUpload> uploads;
    for (std::size_t c = 0; c < truth_Pa_.size(); ++c)
      uploads.push_back(
          {static_cast<std::uint8_t>(c), client::encode_model(model.kind, model.parameters, {})});
    session_.upload_models(uploads, doubted);
  }

  /// Lets the rig's time pass, and whatever comes over the bus meanwhile. Throws std::logic_error when it is later already.
  void pass_until(double bus_time_s) {
    if (link_.now_s() > bus_time_s) throw std::logic_error("the rig's time has passed");
    while (link_.now_s() < bus_time_s) link_.receive(bus_time_s - link_.now_s());
  }

  /// Of each chamber: true pressure less reference, at the end of each tick [Pa].
  using Errors_Pa = std::vector<std::vector<double>>;

  /// Lets the board follow one reference [Pa] a chamber. Throws as client::follow().
  Errors_Pa follow(const std::vector<std::vector<double>>& reference_Pa, std::uint8_t preview_ticks) {
    constexpr double kTicks_per_s = 100.0;
    const auto chambers = static_cast<unsigned>(truth_Pa_.size());
    const auto rows =
        client::follow(session_, reference_Pa, {.preview_ticks = preview_ticks, .chambers = chambers});
    // a row's frames follow its tick at once
    const auto first = static_cast<std::size_t>(rows.front().bus_time_s * kTicks_per_s);
    Errors_Pa errors_Pa(chambers);
    for (std::size_t c = 0; c < chambers; ++c) {
      for (std::size_t k = 0; k < rows.size(); ++k)
        errors_Pa[c].push_back(truth_Pa_[c].at(first + k) - reference_Pa[c][k]);
    }
    return errors_Pa;
  }

 private:
  void look() {
    for (std::size_t c = 0; c < truth_Pa_.size(); ++c) truth_Pa_[c].push_back(rig_.board(0).pressure_Pa(c));
  }

  std::vector<std::vector<double>> truth_Pa_;  ///< from tick 0 on
  rig::Rig rig_;
  RigLink link_;
  client::Session session_;
};

}  // namespace plenum::host::tools
