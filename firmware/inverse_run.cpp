#include "firmware/inverse_run.hpp"

#include <algorithm>
#include <bit>

namespace plenum {
namespace {

using config::ImageError;
using control::InverseCheck;

InverseCheck::Range grid_of(const config::ChamberSettings& chamber,
                            const config::SupplyPressures& model) noexcept {
  const float at_low_mL = config::volume_mL(chamber, chamber.position_valid_low_V);
  const float at_high_mL = config::volume_mL(chamber, chamber.position_valid_high_V);
  const float middle_mL = 0.5F * (at_low_mL + at_high_mL);
  const float quarter_mL = 0.25F * numeric::abs(at_high_mL - at_low_mL);
  return {.pressure_low_kPa = std::max(chamber.pressure_low_kPa, model.ambient_kPa),
          .pressure_high_kPa = std::min(chamber.pressure_high_kPa, model.supply_kPa),
          .volume_low_mL = middle_mL - quarter_mL,
          .volume_high_mL = middle_mL + quarter_mL,
          .command_low_V = chamber.command_low_V,
          .command_high_V = chamber.command_high_V,
          .span_kPa = model.supply_kPa - model.ambient_kPa};
}

}  // namespace

void InverseRun::begin(std::uint8_t chamber) noexcept {
  // A new image for the chamber at hand: its check begins anew.
  if (chamber_ == chamber) chamber_ = kNobody;
  waiting_ = static_cast<std::uint8_t>(waiting_ | 1U << chamber);
}

/// What is no longer wanted is passed over.
bool InverseRun::find_work(const config::ParameterSlots& slots) noexcept {
  if (chamber_ >= kNobody || !slots.proving(chamber_)) chamber_ = kNobody;
  while (chamber_ == kNobody && waiting_ != 0) {
    const auto next = static_cast<std::size_t>(std::countr_zero(waiting_));
    waiting_ = static_cast<std::uint8_t>(waiting_ & (waiting_ - 1U));
    if (!slots.proving(next)) continue;
    chamber_ = next;
    started_ = false;
  }
  return chamber_ != kNobody;
}

config::ImageVerdict InverseRun::start(const config::ModelParameters& staged) noexcept {
  const InverseCheck::Range grid = grid_of(settings_.chamber(chamber_), config::supply_of(staged));
  staged_.take_over(staged, grid.command_low_V, grid.command_high_V);
  check_.begin(grid);
  started_ = true;
  return config::validate_volume(staged, static_cast<float>(grid.volume_low_mL));
}

config::ModelPoint InverseRun::failing_point() const noexcept {
  const InverseCheck::Point& at = check_.point();
  return {.pressure_kPa = static_cast<float>(at.pressure_kPa),
          .volume_mL = static_cast<float>(at.volume_mL),
          .command_V = static_cast<float>(at.command_V),
          .wanted_kPa = static_cast<float>(at.wanted_kPa),
          .came_kPa = static_cast<float>(at.came_kPa)};
}

bool InverseRun::step(config::ParameterSlots& slots) noexcept {
  if (!find_work(slots)) return false;
  config::ImageVerdict verdict;
  InverseCheck::Finding found = InverseCheck::Finding::passed;
  if (!started_) verdict = start(slots.staged(chamber_));
  const control::PressureModel* const model = staged_.in_force();
  if (verdict) found = model == nullptr ? InverseCheck::Finding::inverse_fails : check_.step(*model);
  switch (found) {
    case InverseCheck::Finding::running:
      return true;
    case InverseCheck::Finding::passed:
      break;
    case InverseCheck::Finding::inverse_fails:
      verdict = {.error = ImageError::inverse_fails};
      break;
    case InverseCheck::Finding::no_authority:
      verdict = {.error = ImageError::no_authority};
      break;
  }
  slots.prove(chamber_, verdict, failing_point());
  chamber_ = kNobody;
  return true;
}

}  // namespace plenum
