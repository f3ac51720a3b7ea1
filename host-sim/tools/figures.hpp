// What a fit of a component found, one figure a line: the same in print, in JSON and on a page.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "host-sim/report/page.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {

inline constexpr const char* kNotTold = "not told by these data";

struct Figure {
  std::string key;   ///< in the JSON, where the figure is in SI: "dead_band_m"
  std::string name;  ///< in print and on pages
  std::string unit;  ///< there
  double per_unit;   ///< what a figure in SI is multiplied with for it
  double value;      ///< SI
  double standard_error = std::numeric_limits<double>::quiet_NaN();  ///< SI; NaN: none is known
  std::string why_not{};  ///< in a few words, where the data do not tell it

  /// Told by the data: not said otherwise, and its standard error, where one is known, below a quarter of it.
  bool identified() const;
  /// `why_not`, or that the error is too large; empty where identified.
  std::string remark() const;
  std::string error_text() const;  ///< in `unit`; empty for none
};

using Figures = std::vector<Figure>;

void print(const Output& output, const Figures& figures, int indent);
/// {key: {"value", "standard_error", "identified", "why_not"}}, the last where it is not identified.
Json to_json(const Figures& figures);
report::Table table_of(const Figures& figures, std::string caption);

}  // namespace plenum::host::tools
