// What a board says of itself, as JSON; the same names in every command.
#pragma once

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {

/// Object indices, codes and CRCs are text: "8250h", so that a person finds them in the standard.
std::string hex(std::uint32_t value, int digits);

Json identity_json(const client::Identity& identity);
Json versions_json(const client::Versions& versions);
/// The RMS errors are null where nothing was compared.
Json comparison_json(const client::Comparison& comparison);
/// Null when there is no fault.
Json fault_json(const std::optional<client::FaultEntry>& fault);

/// One sentence: what to look at, and how it clears; where a code stands for several faults, that of each.
std::string fault_advice(const client::FaultEntry& fault);

}  // namespace plenum::host::tools
