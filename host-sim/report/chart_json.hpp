// A chart as the page's script reads it.
#pragma once

#include <nlohmann/json.hpp>

#include "host-sim/report/chart.hpp"
#include "host-sim/report/encoding.hpp"

namespace plenum::host::report {

/// std::invalid_argument where arrays that belong together differ in length, naming chart, array, length and
/// expectation.
void require_consistent(const Chart& chart);

/// {"kind": "line" | "xy" | "bar" | "heat" | "histogram", ...}; arrays are indices into `pool`.
nlohmann::ordered_json to_json(const Chart& chart, ArrayPool& pool);

const std::string& title_of(const Chart& chart);
const std::string& caption_of(const Chart& chart);

}  // namespace plenum::host::report
