// Staged models on the grid of the chamber that they are meant for: control/inverse_check.hpp, spread over ticks.
//
// The grid spans what the settings of the chamber leave to regulate:
//   pressure   pressure_low .. pressure_high, as far as they lie between the model's ambient and supply
//   volume     the middle half of what the position sensor may show: its limits are those of a wire break, and leave a margin beyond
//              every place of the piston, below no volume at all
//   command    command_low .. command_high
// A dead volume that takes all of the grid's smallest volume is refused beforehand, as a parameter (config::validate_volume()). A
// chamber that is not in use is checked as any other: what takes it into use asks for no model anew.
//
// Cost: InverseCheck::kPointsPerTick points of one chamber a tick, in the mean of random sets 23,000 instructions by tassa9, 31,000 by
// tassa9r, 27,000 by greybox (callgrind, x86-64); a model is taken over in the first of them, a grey-box one for 29,000 more. A
// chamber takes kTicks, chambers one after the other; no log is compared in these (shadow_run.hpp).
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/config/limits.hpp"
#include "firmware/config/parameter_slots.hpp"
#include "firmware/config/settings_desk.hpp"
#include "firmware/control/any_model.hpp"
#include "firmware/control/inverse_check.hpp"

namespace plenum {

class InverseRun final : public config::ModelProof {
 public:
  static constexpr std::size_t kTicks =
      control::InverseCheck::kPoints / control::InverseCheck::kPointsPerTick;

  /// The settings must outlive the run.
  explicit InverseRun(const config::SettingsDesk& settings) noexcept : settings_(settings) {}

  void begin(std::uint8_t chamber) noexcept override;

  /// One tick: checks on, and tells `slots` what is done. Returns false when there was nothing to do.
  bool step(config::ParameterSlots& slots) noexcept;

 private:
  static constexpr std::size_t kNobody = config::kChambers;

  bool find_work(const config::ParameterSlots& slots) noexcept;
  config::ImageVerdict start(const config::ModelParameters& staged) noexcept;
  config::ModelPoint failing_point() const noexcept;

  const config::SettingsDesk& settings_;
  std::uint8_t waiting_ = 0;  ///< mask of chambers
  std::size_t chamber_ = kNobody;
  bool started_ = false;
  control::AnyModel staged_;
  control::InverseCheck check_;
};

}  // namespace plenum
