#include "host-sim/tools/board_json.hpp"

#include <fmt/format.h>

namespace plenum::host::tools {

using plenum::safety::Clears;
using plenum::safety::Reaction;

std::string hex(std::uint32_t value, int digits) {
  return fmt::format("{:0{}X}h", value, digits);
}

Json identity_json(const client::Identity& identity) {
  return {{"vendor_id", identity.vendor_id},
          {"product_code", identity.product_code},
          {"revision", identity.revision},
          {"serial", identity.serial}};
}

Json versions_json(const client::Versions& versions) {
  return {{"device", versions.device},
          {"hardware", versions.hardware},
          {"software", versions.software},
          {"schema_hash", hex(versions.schema_hash, 8)},
          {"parameter_count", versions.parameter_count},
          {"scalar_format", versions.scalar_format}};
}

Json comparison_json(const client::Comparison& comparison) {
  using Outcome = client::Comparison::Outcome;
  const bool compared = comparison.outcome == Outcome::passed || comparison.outcome == Outcome::worse;
  const auto name_of = [](Outcome outcome) {
    switch (outcome) {
      case Outcome::no_model:
        return "no model before";
      case Outcome::same:
        return "same as before";
      case Outcome::no_movement:
        return "no log with movement";
      case Outcome::not_awaited:
        return "forced";
      case Outcome::worse:
        return "worse";
      case Outcome::passed:
        return "passed";
    }
    return "unknown";
  };
  return {{"compared", compared},
          {"outcome", name_of(comparison.outcome)},
          {"rms_Pa", compared ? Json(comparison.rms_Pa) : Json(nullptr)},
          {"before_rms_Pa", compared ? Json(comparison.before_rms_Pa) : Json(nullptr)},
          {"doubt", comparison.doubt.empty() ? Json(nullptr) : Json(comparison.doubt)}};
}

namespace {

const char* reaction_text(Reaction reaction) {
  switch (reaction) {
    case Reaction::none:
      return "none: it is reported only";
    case Reaction::hold:
      return "every chamber regulates to its hold set point, or stays where it is";
    case Reaction::safe:
      return "every chamber gets its safe output";
    case Reaction::vent:
      return "the faulty chamber is vented, the others get their safe output";
  }
  return "unknown";
}

}  // namespace

std::string fault_advice(const client::FaultEntry& fault) {
  const auto specs = client::fault_specs(fault);
  if (specs.empty()) return "this program does not know it: use the program of the firmware's release";
  std::string advice;
  for (const auto* spec : specs) {
    if (specs.size() > 1) advice += fmt::format("{}if {}, ", advice.empty() ? "" : "; ", spec->name);
    advice += fmt::format("look at: {}; {}", spec->blame,
                          spec->clears == Clears::by_itself
                              ? "it goes with its cause"
                              : "then plenum reset --fault, which clears it when its cause is gone");
  }
  return advice;
}

Json fault_json(const std::optional<client::FaultEntry>& fault) {
  if (!fault) return nullptr;
  std::string reaction;
  for (const auto* spec : client::fault_specs(*fault))
    reaction += (reaction.empty() ? "" : ", or ") + std::string(reaction_text(spec->reaction));
  return {{"code", hex(fault->code, 4)},
          {"name", client::fault_name(*fault)},
          {"chamber", fault->chamber == 0 ? Json(nullptr) : Json(fault->chamber)},
          {"reaction", reaction.empty() ? Json(nullptr) : Json(reaction)},
          {"advice", fault_advice(*fault)}};
}

}  // namespace plenum::host::tools
