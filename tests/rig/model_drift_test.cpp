// The warning of a model that no longer fits: a machine changes, its board is not told.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/capture.hpp"
#include "host-sim/client/model_bytes.hpp"
#include "host-sim/identify/greybox.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "tests/rig/watched_rig.hpp"

namespace plenum::host::rig {
namespace {

constexpr unsigned kChambers = 2;
constexpr std::uint16_t kModelDrift = 0xFF0B;
constexpr double kFitError_kPa = 0.15;  // of readings with 0.1 kPa of noise

std::vector<std::vector<double>> sines_Pa(double amplitude_Pa, double frequency_Hz) {
  std::vector<double> sine(1500);
  for (std::size_t k = 0; k < sine.size(); ++k)
    sine[k] = 350e3 +
              amplitude_Pa * std::sin(2.0 * std::numbers::pi * frequency_Hz * 0.01 * static_cast<double>(k));
  return {kChambers, sine};
}

/// A rig that really has `effects`, and a board with the model of its data sheet, fitted to `fit_error_kPa`.
struct Machine {
  explicit Machine(const std::map<std::string, std::map<std::string, double>>& effects,
                   double fit_error_kPa = kFitError_kPa, std::uint64_t seed = 1)
      : watched(
            thin_plate_rig(described(effects), {.chambers = kChambers, .volume_swing = 0.1, .seed = seed})),
        session(watched, 1) {
    const trace::ModelFile sheet = identify::greybox_of({}).file;
    std::vector<client::ModelUpload> uploads;
    for (std::uint8_t c = 0; c < kChambers; ++c) {
      uploads.push_back(
          {c, client::encode_model(sheet.kind, sheet.parameters, {.fit_error_kPa = fit_error_kPa})});
    }
    session.upload_models(uploads);
  }
  static trace::RigDescription described(
      const std::map<std::string, std::map<std::string, double>>& effects) {
    trace::RigDescription description;
    description.effects = effects;
    return description;
  }
  /// Whether the board has told it, after 15 s of a sine.
  bool tells_drift(double amplitude_Pa = 100e3, double frequency_Hz = 1.0) {
    rows = client::follow(session, sines_Pa(amplitude_Pa, frequency_Hz),
                          {.preview_ticks = 8, .chambers = kChambers})
               .size();
    const auto fault = client::read_fault(session);
    return fault && fault->code == kModelDrift;
  }
  WatchedRig watched;
  client::Session session;
  std::size_t rows = 0;
};

TEST(ModelDrift, IsToldOfAMachineThatHasChangedAndNothingIsStoppedByIt) {
  const std::map<std::string, std::map<std::string, double>> changes{
      {"dead_time", {{"delay_s", 0.025}}},
      {"spool_lag", {{"natural_frequency_Hz", 12.0}, {"damping", 0.8}}},
      {"chamber_leak", {{"conductance_g_s_MPa", 1.0}}},
      {"valve_hysteresis", {{"width_V", 0.4}}},
      {"sensor_lag", {{"time_constant_s", 0.05}}},
      {"volume_error", {{"offset_mL", 100.0}}},
      {"null_drift", {{"drift_at_60_s_V", 1.5}}},
      {"tube_dynamics", {{"length_m", 3.0}, {"bore_mm", 4.0}}}};
  for (const auto& change : changes) {
    Machine machine({change});
    EXPECT_TRUE(machine.tells_drift()) << change.first;
    EXPECT_EQ(machine.rows, 1500U) << change.first;
    EXPECT_GT(client::read_drift_Pa(machine.session, 0), 4 * 200.0) << change.first;
  }
}

TEST(ModelDrift, IsNotToldOfAMachineThatIsAsItsModelWhateverItFollows) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    for (const auto& [amplitude_Pa, frequency_Hz] :
         {std::pair{0.0, 1.0}, {100e3, 0.5}, {150e3, 2.0}, {40e3, 8.0}}) {
      Machine machine({}, kFitError_kPa, seed);
      EXPECT_FALSE(machine.tells_drift(amplitude_Pa, frequency_Hz))
          << amplitude_Pa << " Pa, " << frequency_Hz << " Hz";
      EXPECT_LT(client::read_drift_Pa(machine.session, 0), 2 * 200.0);
    }
  }
}

TEST(ModelDrift, IsNotToldOfAModelThatDoesNotStateItsFit) {
  Machine machine({{"dead_time", {{"delay_s", 0.025}}}}, 0.0);
  EXPECT_FALSE(machine.tells_drift());
}

TEST(ModelDrift, IsToldByTheRatioThatIsSetWhileTheModelIsInForce) {
  constexpr std::uint8_t kDriftAlarmRatio = 18;
  Machine machine({{"dead_time", {{"delay_s", 0.025}}}});
  const auto set = [&](float ratio) {
    machine.session.request_state(0);  // INIT
    for (std::uint16_t c = 0; c < kChambers; ++c)
      machine.session.write(static_cast<std::uint16_t>(canopen::object::kChamberSettings + c),
                            kDriftAlarmRatio, ratio);
  };
  set(1000.0F);
  EXPECT_FALSE(machine.tells_drift());
  set(4.0F);
  EXPECT_TRUE(machine.tells_drift());
}

TEST(ModelDrift, LeavesTheLastSecondsInTheLog) {
  Machine machine({{"dead_time", {{"delay_s", 0.025}}}});
  ASSERT_TRUE(machine.tells_drift());
  EXPECT_GE(machine.session.read<std::uint16_t>(canopen::object::kCapture, 5), 1000U) << "rows";
}

}  // namespace
}  // namespace plenum::host::rig
