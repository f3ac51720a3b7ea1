// Findings as a file: schema plenum-reproduce/1.
#pragma once

#include <nlohmann/json.hpp>

#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce {

/// {"number", "title", "verdicts": {"reproduced": n, ...}, "parts": [{"title", "text", "findings": [{"item", "quantity",
/// "unit", "paper", "instead", "expect": "near"|"at most"|"at least", "tolerance", "ours", "source", "difference", "verdict", "why"}]}]}; a number
/// that is not finite is null.
nlohmann::ordered_json to_json(const Paper& paper, const std::vector<Part>& parts);

}  // namespace plenum::host::reproduce
