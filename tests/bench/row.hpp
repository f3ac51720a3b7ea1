// A row of build/host/bench/summary.json, as CMakeLists.txt of this folder describes it.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace plenum::bench {

struct Row {
  std::string name;
  double value = 0.0;
  const char* unit = "";
  const char* better = "lower";    ///< or "higher"
  std::optional<double> target{};  ///< none: only reported
  const char* peer = nullptr;      ///< what it is compared with, null: with nothing
  double peer_value = 0.0;
};

/// On standard output.
inline void print(const Row& row) {
  fmt::print(R"({{"name": "{}", "value": {:.6g}, "unit": "{}", "better": "{}", "target": {})", row.name,
             row.value, row.unit, row.better, row.target ? fmt::format("{:.6g}", *row.target) : "null");
  if (row.peer != nullptr) fmt::print(R"(, "peer": "{}", "peer_value": {:.6g})", row.peer, row.peer_value);
  fmt::print("}}\n");
}

/// The 95th percentile, by nearest rank.
inline double p95(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[(95 * values.size() + 99) / 100 - 1];
}

}  // namespace plenum::bench
