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

namespace {

const char* reaction_text(Reaction reaction) {
  switch (reaction) {
    case Reaction::none:
      return "none: it is reported only";
    case Reaction::hold:
      return "every chamber regulates to its hold set point";
    case Reaction::safe:
      return "every chamber gets its safe output";
    case Reaction::vent:
      return "the faulty chamber is vented, the others get their safe output";
  }
  return "unknown";
}

}  // namespace

std::string fault_advice(std::uint16_t code) {
  const auto* spec = client::fault_spec(code);
  if (spec == nullptr) return "this program does not know it: use the program of the firmware's release";
  return fmt::format("look at: {}; {}", spec->blame,
                     spec->clears == Clears::by_itself
                         ? "it goes with its cause"
                         : "then plenum reset --fault, which clears it when its cause is gone");
}

std::string fault_text(const client::FaultEntry& fault) {
  const std::string where = fault.chamber == 0 ? "" : fmt::format(", chamber {}", fault.chamber);
  return fmt::format("{} {}{}", hex(fault.code, 4), client::fault_name(fault.code), where);
}

Json fault_json(const std::optional<client::FaultEntry>& fault) {
  if (!fault) return nullptr;
  const auto* spec = client::fault_spec(fault->code);
  return {{"code", hex(fault->code, 4)},
          {"name", client::fault_name(fault->code)},
          {"chamber", fault->chamber == 0 ? Json(nullptr) : Json(fault->chamber)},
          {"reaction", spec == nullptr ? Json(nullptr) : Json(reaction_text(spec->reaction))},
          {"advice", fault_advice(fault->code)}};
}

}  // namespace plenum::host::tools
